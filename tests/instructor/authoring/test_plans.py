"""A plan is loaded, its reference gives the answers, and it is published without code."""

import numpy as np
import pytest

from nao_course.exercises import Case
from nao_course.exercises.checking import pack, unpack
from nao_course.instructor.authoring.plans import (
    PlanError,
    lesson_name,
    load_plan,
    publish,
    reference,
    with_answers,
)
from tests.toy import toy


def test_a_lesson_is_known_by_its_number_or_name(solutions):
    assert lesson_name("90", solutions) == lesson_name("90_toy", solutions) == "90_toy"
    with pytest.raises(PlanError, match=r"there are \['90_toy'\]"):
        lesson_name("91", solutions)


def test_a_good_plan_is_published_without_code_the_same_each_time(plan, right):
    public = publish("90_toy", plan, right)
    assert [(each.number, each.name, each.points) for each in public.exercises] == [
        ("90.1", "clamp", 2.0),
        ("90.2", "mean_of_positive", 3.0),
    ]
    assert [case.expected for case in public.exercises[0].cases] == [2.25, 0.5, 1.125]
    assert public.exercises[0].mistakes[0].answers == {"0": 3.0}
    assert public.exercises[1].mistakes[2].answers == {"1": {"raises": "ZeroDivisionError"}}
    assert public.exercises[1].mistakes[3].answers == {}  # right, but in place
    assert pack(public) == pack(publish("90_toy", plan, right))
    back = unpack(pack(public))
    assert (back.name, len(back.exercises), back.questions[0].right) == ("90_toy", 2, "Safety")


@pytest.mark.parametrize(
    ("function", "message"),
    [
        (lambda x, low, high: 1 / 0, "gives no answer: raised ZeroDivisionError"),
        (lambda x, low, high: {1}, "gives no answer: unsendable a value of type set"),
        (lambda x, low, high: [x.fill(0)][1:], "changes its input"),
    ],
)
def test_a_reference_that_fails_is_refused(plan, function, message):
    case = Case((np.ones(2), 0, 1), "first")
    with pytest.raises(PlanError, match=message):
        with_answers(plan["clamp"], [case], function)


@pytest.mark.parametrize("text", ["PLAN = 3", "", "1 / 0", "def f(:"])
def test_a_declaration_that_declares_nothing_is_refused(tmp_path, text):
    (tmp_path / "91_bad.py").write_text(text)
    with pytest.raises(PlanError, match=r"91_bad\.py: "):
        load_plan(tmp_path / "91_bad.py")
    with pytest.raises(FileNotFoundError):
        load_plan(tmp_path / "missing.py")


def test_a_lesson_that_is_not_built_is_said_so(tmp_path):
    folder = toy.solutions(tmp_path / "solutions")
    (folder / "90_toy.ipynb").unlink()
    with pytest.raises(FileNotFoundError, match="nao-course build"):
        reference("90", folder)
