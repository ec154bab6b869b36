"""A plan whose checks would fail a student later is refused, with the exercise and the reason."""

from dataclasses import replace

import numpy as np
import pytest

from nao_course.exercises import Case, Exact, LessonPlan, Mistake
from nao_course.instructor.authoring.plan_checks import check_plan
from nao_course.instructor.authoring.plans import PlanError


def test_a_good_plan_is_accepted(plan, right):
    check_plan("90_toy", plan, right)


def wrong(x, low, high):
    return 1 / 0


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"public": list}, "clamp: no public cases"),
        ({"hidden": lambda rng: []}, "clamp: no hidden cases"),
        ({"mistakes": []}, "clamp: 0 mistakes; at least 3 are wanted"),
        ({"alternatives": {}}, "clamp: 0 alternatives; at least 3 are wanted"),
        ({"alternatives": {"odd one": wrong}}, "clamp: alternative 'odd one' is not right"),
        (
            {"alternatives": {"odd one": lambda x, low, high: max(low, min(high, x)) + (low < 0)}},
            "clamp: alternative 'odd one' is not right in a hidden case",
        ),
        (
            {"mistakes": [Mistake("none", lambda x, low, high: max(low, min(high, x)), "m")]},
            "clamp: mistake 'none': no public case tells it from the right answer",
        ),
        (
            {"mistakes": [Mistake("none", lambda x, low, high: max(low, min(high, x)), "m")]},
            "clamp: mistake 'none': no hidden case tells it from the right answer",
        ),
        (
            {"mistakes": [Mistake(name, lambda x, low, high: x, name) for name in ("a", "b")]},
            "clamp: mistake 'b': its message is not shown",
        ),
        ({"mistakes": [Mistake("a", wrong, "m")] * 2}, "clamp: two mistakes are called 'a'"),
        ({"public": lambda: [Case((np.zeros((49, 64)), 0, 1))]}, "a picture of 64x49; 64x48 is the most"),
        ({"public": lambda: [Case(({"a": [np.zeros((480, 640, 3))]}, 0, 1))]}, "a picture of 640x480"),
        ({"public": lambda: [Case((np.random.default_rng().random(), 0, 1))]}, "not the same each time"),
        (
            {"hidden": lambda rng: [Case((np.random.default_rng().random(), 0, 1))]},
            "the same for the same seed",
        ),
        (
            {"public": lambda: [Case((object(), 0, 1))]},
            "clamp: a case cannot be sent: a value of type object",
        ),
        (
            {"public": lambda: [Case((1.0,), "too few")]},
            "clamp: the reference, case 1 'too few', gives no answer",
        ),
        ({"name": "nobody"}, "nobody: the solution notebook does not define it"),
        ({"name": "mean_of_positive"}, "mean_of_positive: the name is used twice"),
        ({"comparison": Exact(), "public": lambda: [Case((np.nan, np.nan, np.nan))]}, "not right by its own"),
    ],
)
def test_a_plan_that_would_fail_a_student_is_refused_and_says_where(plan, right, change, message):
    broken = replace(plan, exercises=[replace(plan["clamp"], **change), plan["mean_of_positive"]])
    with pytest.raises(PlanError) as refusal:
        check_plan("90_toy", broken, right)
    assert message in str(refusal.value)
    assert all(line.startswith("90_toy: ") for line in str(refusal.value).splitlines())


def test_names_of_other_lessons_and_odd_questions_are_refused(plan, right):
    with pytest.raises(PlanError, match="clamp: the name is used twice"):
        check_plan("90_toy", plan, right, taken=["clamp", "other"])
    check_plan("90_toy", plan, right, taken=["other", "other"])
    question = replace(plan.questions[0], right="Neither")
    with pytest.raises(PlanError, match="why: its right answer is not one of its choices"):
        check_plan("90_toy", replace(plan, questions=[question]), right)


def test_all_that_is_wrong_is_said_at_once(plan, right):
    broken = [replace(each, mistakes=[], alternatives={}) for each in plan.exercises]
    with pytest.raises(PlanError) as refusal:
        check_plan("90_toy", LessonPlan(broken), right)
    assert len(str(refusal.value).splitlines()) == 4


def test_practice_needs_no_mistakes(plan, right):
    check_plan("90_toy", LessonPlan([replace(plan["clamp"], points=0, mistakes=[], alternatives={})]), right)
