"""What a declaration says wrong is told with what was given and what is wanted, all of it at once."""

from dataclasses import replace

import pytest

from nao_course.exercises import (
    Case,
    Close,
    LessonPlan,
    Mistake,
    Points,
    Property,
    Question,
    Sibling,
    Written,
)
from nao_course.instructor.authoring.declarations import WAIVABLE, declaration_problems
from nao_course.instructor.authoring.plans import PlanError, load_plan

QUESTION = Question("why", "Why?", {"a": "No.", "b": "Yes."}, "b")
WRITTEN = Written("say_why", 2, "Why?", "Because.")
FINE = Mistake("a", abs, "A sentence.")
OF_AN_EXERCISE = {
    "name": ["", "two words", 3, None],
    "points": [-1, "2", None, True, float("nan"), float("inf")],
    "public": [[Case((1.0,))], None],
    "hidden": [[], None],
    "hints": ["Look here.", ("One.",), ("One.", ""), ("1", "2", "3"), None, (1, 2)],
    "sibling": ["print(1)", Sibling("Alike.", "print(1)", ""), Sibling("", "print(1)", "1")],
    "mistakes": [FINE, (("a", abs, "m"),), None],
    "alternatives": [[abs], {"a": 3}, {"": abs}, None],
    "comparison": [Close, None, "Close()"],
    "stars": [0, 7, 1.0, "1", True],
    "uses": ["clamp", 3, [3]],
    "driver": [None, 3],
    "with_reference": [-0.1, 1.5, "1"],
    "parts": [["move"], {"move": 0}, {"": 1}, {"move": "1"}],
    "equivalents": [["line"], {"line": ""}, {1: "a"}],
    "seconds": [0, -1, "10", 600],
}
AMOUNTS = "must be a number, 0 or more, or a tuple of them, one a column"
CASES = [(field, value) for field, values in OF_AN_EXERCISE.items() for value in values]


def said(*exercises, **more):
    return list(declaration_problems(LessonPlan(list(exercises), **more)))


def test_what_is_right_is_not_complained_about_and_questions_and_waived_rules_are_looked_at(plan):
    assert said(*plan.exercises, questions=[QUESTION], written=[WRITTEN]) == []
    assert said(replace(plan["clamp"], points=0.5, stars=3, uses=["a"], driver="jacobian", seconds=30)) == []
    assert said(waived=dict.fromkeys(WAIVABLE, "a lab of half an hour")) == []
    for more, message in (
        ({"questions": [replace(QUESTION, choices=["a", "b"])]}, "why: choices must be a dict of replies"),
        ({"questions": [replace(QUESTION, choices={"b": "Yes."})]}, "why: choices must be"),
        ({"questions": [replace(QUESTION, right="c")]}, "why: its right answer is not one of its choices"),
        ({"questions": QUESTION}, "PLAN: questions must be a list of Question, got Question("),
        ({"written": [replace(WRITTEN, rubric="")]}, "say_why: rubric must be a text, got ''"),
        ({"written": [replace(WRITTEN, points=-2)]}, "say_why: points must be a number, 0 or more, got -2"),
        ({"waived": ["3"]}, 'PLAN: waived must be a dict of reasons by rule, {"3": "a lab"}, got '),
        ({"waived": {"3": ""}}, "PLAN: waived must be a dict of reasons by rule"),
        ({"waived": {"3": "a lab", "9": "x", "16": "y"}}, "PLAN: the rules 16, 9 cannot be waived"),
    ):
        (problem,) = said(**more)
        assert problem.startswith(message)


def test_each_value_that_an_exercise_cannot_have_is_told_with_its_place(plan):
    for field, value in CASES:
        (problem,) = said(replace(plan["clamp"], **{field: value}))
        called = "Exercise " if field == "name" else "clamp: "
        assert problem.startswith(called) and f"{field} must be " in problem and ", got " in problem
    for change, message in INSIDE:
        (problem,) = said(replace(plan["clamp"], **change))
        assert problem.startswith(f"clamp: {message}")


INSIDE = [
    ({"driver": "no_driver"}, "driver: there is no driver 'no_driver'; choose one of ["),
    ({"driver": "nao_course.no_lesson:f"}, "driver: No module named 'nao_course.no_lesson'"),
    ({"comparison": Points(tolerance="2")}, f"Points's tolerance {AMOUNTS}; got '2'"),
    ({"comparison": Close(rtol=-1.0)}, f"Close's rtol {AMOUNTS}; got -1.0"),
    ({"comparison": Close(names="your hue")}, "Close's names must be a tuple, got the text 'your hue'"),
    ({"comparison": Property(lambda args, kwargs, answer: "")}, "its comparison cannot travel"),
    ({"mistakes": [FINE, Mistake("b", 3, "m")]}, "mistake 'b': function must be the wrong function, got 3"),
    ({"mistakes": [Mistake("b", abs, "")]}, "mistake 'b': message must be a sentence that helps, got ''"),
]


def test_all_that_is_wrong_in_a_file_is_said_at_once_with_its_name(tmp_path, plan):
    assert len(said(*(replace(each, stars=7, points=-1) for each in plan.exercises))) == 4
    assert said(plan["clamp"], FINE)[0].startswith("PLAN: exercises must be a list of Exercise, got ")
    file = tmp_path / "91_bad.py"
    file.write_text("from nao_course.exercises import LessonPlan\nPLAN = LessonPlan([3], written=4)\n")
    with pytest.raises(PlanError) as refusal:
        load_plan(file)
    assert [line.split(", got")[0] for line in str(refusal.value).splitlines()] == [
        "91_bad.py: PLAN: exercises must be a list of Exercise",
        "91_bad.py: PLAN: written must be a list of Written",
    ]
