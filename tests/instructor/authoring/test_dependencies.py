"""An exercise rests on what its declaration mentions, and on what does more than define names."""

import pytest

from nao_course.instructor.authoring.dependencies import code_by_exercise

DECLARATION = """
import numpy as np
import math
def helper(x): return other(x)
def other(x): return x
def alone(x): return math.pi
A = Exercise(name="first", hidden=lambda rng: helper(np.ones(3)))
B = Exercise(name="second", alternatives={"one": alone})
PLAN = LessonPlan([A, B])
"""
CELLS = [
    ("setup", "import os"),
    ("solution", "def first(x): return tool(x)"),
    ("solution", "def tool(x): return x"),
    ("solution", "def second(x): return -x"),
]


def lines(name, declaration=DECLARATION, cells=CELLS):
    """Return what an exercise rests on, as one word of each statement."""
    code = code_by_exercise(declaration, cells, ["first", "second"])[name]
    words = (
        "np",
        "math",
        "helper(x)",
        "other(x): ",
        "alone(x)",
        "'first'",
        "'second'",
        "os",
        "def first",
        "tool(x): ",
    )
    return {word for word in (*words, "def second", "PLAN") if word in code.replace(":\n", ": ")}


def test_an_exercise_rests_on_what_it_mentions_and_all_that_this_mentions():
    assert lines("first") == {"np", "helper(x)", "other(x): ", "'first'", "os", "def first", "tool(x): "}
    assert lines("second") == {"math", "alone(x)", "'second'", "os", "def second"}


def test_a_text_mentions_an_exercise_too():
    declaration = DECLARATION.replace('name="first"', 'name="first", text="as in second"')
    assert {"'second'", "def second"} - lines("first", declaration) == {"'second'"}
    assert "'second'" in lines("first", declaration.replace("as in second", "as in B"))


@pytest.mark.parametrize(
    "more",
    [
        "np.seterr()",
        "A.hints = ()",
        "from x import *",
        "@register\nclass math:\n    pass",
        "if x:\n    y = 2",
    ],
)
def test_all_rest_on_a_statement_that_does_more_than_define_names(more):
    for name in ("first", "second"):
        code = code_by_exercise(f"{DECLARATION}{more}\n", CELLS, ["first", "second"])[name]
        assert more in code
    assert (
        "x = 1" in code_by_exercise(DECLARATION, [*CELLS, ("student", "x = 1")], ["first", "second"])["first"]
    )
    assert (
        "print(1)"
        in code_by_exercise(DECLARATION, [*CELLS, ("solution", "y = 1\nprint(1)")], ["first", "second"])[
            "first"
        ]
    )


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('A = Exercise(name="first"', 'A = made(name="first"'),
        ("[A, B]", "[A, harder(B)]"),
        ("[A, B]", "exercises"),
        ("PLAN = ", "PLAN, more = 1, "),
        ("import math", "import math ("),
    ],
)
def test_each_rests_on_everything_unless_each_has_its_own_statement_and_a_plain_plan(old, new):
    found = code_by_exercise(DECLARATION.replace(old, new), CELLS, ["first", "second"])
    assert found["first"] == found["second"]
    assert new in found["first"] and "def second" in found["first"]
