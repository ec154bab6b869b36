"""A plan whose checks would fail a student later is refused, with the exercise and the reason."""

import itertools
import signal
import time
from dataclasses import replace

import numpy as np
import pytest

from nao_course.exercises import Case, Exercise, LessonPlan, Mistake, calls
from nao_course.exercises.checking import grade_public
from nao_course.exercises.comparisons import Between, Close, Exact, Methods, Points
from nao_course.instructor.authoring import plan_checks, plans
from nao_course.instructor.authoring.plan_checks import check_plan, plan_warnings
from nao_course.instructor.authoring.plans import PlanError


def wrong(x, low, high):
    return 1 / 0


def right_answer(x, low, high):
    return max(low, min(high, x))


def public(*args, **more):
    return {"public": lambda: [Case(args, **more)]}


def hidden(*args):
    return {"hidden": lambda rng: [Case(args)]}


def mistake(function, name="a"):
    return {"mistakes": [Mistake(name, function, "m")]}


REFUSED = [
    ({"public": list}, "clamp: no public cases"),
    ({"hidden": lambda rng: []}, "clamp: no hidden cases"),
    ({"alternatives": {"odd one": wrong}}, "clamp: alternative 'odd one' is not right"),
    ({"alternatives": {"odd": lambda *x: right_answer(*x) + (x[1] < 0)}}, "'odd' is not right in a hidden"),
    (mistake(right_answer, "none"), "clamp: mistake 'none': no public case distinguishes"),
    (mistake(right_answer, "none"), "clamp: mistake 'none': no hidden case distinguishes"),
    ({"mistakes": [Mistake(name, lambda x, *_: x, name) for name in "ab"]}, "'b': its message is not shown"),
    ({"mistakes": [Mistake("a", wrong, "m")] * 2}, "clamp: two mistakes are called 'a'"),
    (mistake(lambda x: x), "mistake 'a' gives no answer in any case: TypeError"),
    (mistake(lambda x, low, high: nothing), "mistake 'a' gives no answer in any case: NameError"),  # noqa: F821
    (public(np.zeros((49, 64), bool), 0, 1), "a picture of 64x49; 64x48 is the most"),
    (public({"a": [np.zeros((480, 640, 3), np.uint8)]}, 0, 1), "a picture of 640x480"),
    (public(np.zeros((501, 500)), 0, 1), "an array of 250500 numbers; 250000 are the"),
    ({"public": lambda: [Case((np.random.default_rng().random(), 0, 1))]}, "not the same each time"),
    ({"hidden": lambda rng: [Case((np.random.default_rng().random(), 0, 1))]}, "the same for the same seed"),
    (public(object(), 0, 1), "clamp: a case cannot be sent: a value of type object"),
    (hidden(1.0, {1}, 1), "clamp: a case cannot be sent: a value of type set"),
    (public(1.0, name="too few"), "clamp: the reference, case 1 'too few', gives no answer"),
    ({"parts": {"below": 1}}, "clamp: it has a public case without a part; the case's name must begin with"),
    ({"parts": {"below": 1}}, "clamp: it has a hidden case without a part"),
    ({"parts": {"below": 1}}, "clamp: no hidden case tests the part 'below'"),
    ({"hidden": lambda rng: 1 / 0}, ": ZeroDivisionError: division by zero"),
    ({"hidden": list}, "clamp: its hidden cases: TypeError: "),
    ({"hidden": lambda rng: None}, "its hidden cases must be a list of Case, got None"),
    ({"hidden": lambda rng: [(1.0, 0, 1)]}, "its hidden cases must be a list of Case, got [(1.0, 0, 1)]"),
    ({"public": lambda: [Case(1.0)]}, "public case 1: args must be a tuple, Case((1.0,)) with its comma"),
    (public(1.0, name=3), "public case 1: name must be a few words, got 3"),
    ({"comparison": Between()}, "public case 1: Between wants expected=(low, high), got None"),
    ({"comparison": Points()}, "gives what Points cannot compare: "),
    ({"points": "2"}, "clamp: points must be a number, 0 or more, got '2'"),
    ({"name": "nobody"}, "nobody: the solution notebook does not define it"),
    ({"name": "mean_of_positive"}, "mean_of_positive: the name is used twice"),
    (public(np.nan, np.nan, np.nan) | {"comparison": Exact()}, "not right by its own"),
]


def test_a_plan_that_would_fail_a_student_is_refused_and_says_where(plan, right):
    for change, message in REFUSED:
        broken = replace(plan, exercises=[replace(plan["clamp"], **change), plan["mean_of_positive"]])
        with pytest.raises(PlanError) as refusal:
            check_plan("90_toy", broken, right)
        assert message in str(refusal.value)
        assert all(line.startswith("90_toy: ") for line in str(refusal.value).splitlines())


def test_names_of_other_lessons_and_odd_questions_are_refused_and_all_is_said_at_once(plan, right):
    with pytest.raises(PlanError, match="clamp: the name is used twice"):
        check_plan("90_toy", plan, right, taken=["clamp", "other"])
    check_plan("90_toy", plan, right, taken=["other", "other"])
    question = replace(plan.questions[0], right="Neither")
    with pytest.raises(PlanError, match="why: its right answer is not one of its choices"):
        check_plan("90_toy", replace(plan, questions=[question]), right)
    broken = [replace(each, alternatives={"a": wrong, "b": wrong}) for each in plan.exercises]
    with pytest.raises(PlanError) as refusal:
        check_plan("90_toy", LessonPlan(broken), right)
    assert len(str(refusal.value).splitlines()) == 4


def test_a_good_plan_is_fine_and_needs_no_mistakes_but_build_warns_if_it_is_graded(plan, right):
    bare = replace(plan["clamp"], mistakes=[], alternatives={})
    (public,) = check_plan("90_toy", LessonPlan([bare]), right)
    assert grade_public(public, right["clamp"]) and not grade_public(public, wrong)
    (warning,) = plan_warnings(LessonPlan([bare, replace(bare, points=0)]))
    assert warning.startswith("clamp: it has 0 mistakes and 0 alternatives; with 3 of each")
    assert not list(plan_warnings(LessonPlan([bare], waived={"8": "a lab"})))
    assert not list(plan_warnings(plan)) and len(plan.exercises) == 2
    check_plan("90_toy", plan, right)
    slip = Mistake("a name", lambda x, low, high: np.clip(x, low, high)[0], "A number has no first element.")
    changed = replace(plan["clamp"], mistakes=[slip, *plan["clamp"].mistakes])
    check_plan("90_toy", LessonPlan([changed]), right)


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="this system has no alarm clock")
@pytest.mark.parametrize("what", ["mistake", "solution"])
def test_what_never_ends_is_stopped_and_said(plan, right, monkeypatch, what):
    monkeypatch.setattr(plans, "PATIENCE", 0.01)
    endless = lambda x, low, high: next(x for x in itertools.count() if x < 0)  # noqa: E731
    exercise, functions = plan["clamp"], dict(right)
    if what == "mistake":
        exercise = replace(exercise, mistakes=[Mistake("endless", endless, "It ends."), *exercise.mistakes])
    else:
        functions["clamp"] = endless
    with pytest.raises(PlanError, match="clamp: .*(does not end in public case 1|timed out)"):
        check_plan("90_toy", LessonPlan([exercise]), functions)


def slow(*args):
    """The solution, and some work: a hundredth of a second of it."""
    end = time.process_time() + 0.01
    while time.process_time() < end:
        pass
    return right_answer(*args)


def waits(*args):
    time.sleep(0.02)  # as where another program has the processor
    return right_answer(*args)


@pytest.mark.slow
def test_a_solution_that_the_grader_would_stop_is_refused_and_time_of_others_is_not_its_own(
    plan, right, monkeypatch
):
    short, longer = (LessonPlan([replace(plan["clamp"], seconds=seconds)]) for seconds in (0.006, 0.05))
    said = r"clamp: its solution takes 0\.\d s .*after 0\.006 s.*Exercise\(seconds="
    with pytest.raises(PlanError, match=said):
        check_plan("90_toy", short, {**right, "clamp": slow})
    check_plan("90_toy", longer, {**right, "clamp": waits})
    monkeypatch.setattr(plan_checks, "SECONDS_IN_ALL", 0.1)
    alone = LessonPlan([plan["clamp"]])
    check_plan("90_toy", alone, right)
    with pytest.raises(PlanError, match="its solutions take .* s for all cases; a submission has 0.1 s"):
        check_plan("90_toy", alone, {**right, "clamp": slow})


def test_an_exercise_whose_solution_uses_another_has_to_say_so(plan):
    space = {"np": np, "clamp": right_answer}
    body = "return clamp(0.0, 0.0, 1.0) + float(values[values > 0].mean())"
    exec(f"def mean_of_positive(values):\n    {body}", space)
    simple = replace(plan["mean_of_positive"], public=lambda: [Case((np.array([1.5, -2.0]),))], mistakes=[])
    with pytest.raises(PlanError, match="mean_of_positive: its solution uses clamp; add 'clamp' to its"):
        plans.publish("90_toy", LessonPlan([plan["clamp"], simple]), space)
    plans.publish("90_toy", LessonPlan([plan["clamp"], replace(simple, uses=["clamp"])]), space)


class Counter:
    def add(self, value):
        self.sum = value

    def total(self):
        return self.sum


def test_a_method_that_is_compared_is_one_that_a_case_calls(plan):
    turns = [calls(("add", 1.5), "total")]
    counter = Exercise("Counter", 0, lambda: turns, lambda rng: turns, ("a", "b"), driver="methods")
    misspelt, right = (replace(counter, comparison=Methods({name: Close()})) for name in ("totl", "total"))
    with pytest.raises(PlanError, match=r"Counter: Methods compares 'totl', which no case calls.*'total'"):
        check_plan("90_toy", LessonPlan([misspelt]), {"Counter": Counter})
    check_plan("90_toy", LessonPlan([right]), {"Counter": Counter})
