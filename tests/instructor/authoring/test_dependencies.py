"""An exercise rests on what its declaration mentions, and on what does more than define names."""

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


def of(name, declaration=DECLARATION, cells=()):
    return code_by_exercise(declaration, [*CELLS, *cells], ["first", "second"])[name]


def lines(name, declaration=DECLARATION, cells=()):
    """Return what an exercise rests on, as one word of each statement."""
    code = of(name, declaration, cells).replace(":\n", ": ")
    words = {"np.ones", "math.pi", "os", "PLAN", "helper(x)", "other(x): ", "alone(x)", "tool(x): "}
    return {word for word in words | {"'first'", "'second'", "def first", "def second"} if word in code}


def test_an_exercise_rests_on_what_it_mentions_and_all_that_this_mentions():
    assert lines("first") == {"np.ones", "helper(x)", "other(x): ", "'first'", "os", "def first", "tool(x): "}
    assert lines("second") == {"math.pi", "alone(x)", "'second'", "os", "def second"}


def test_a_text_mentions_an_exercise_too():
    declaration = DECLARATION.replace('name="first"', 'name="first", text="as in second"')
    assert {"'second'", "def second"} - lines("first", declaration) == {"'second'"}
    assert "'second'" in lines("first", declaration.replace("as in second", "as in B"))


def test_all_rest_on_a_statement_that_does_more_than_define_names():
    for more in (
        *("np.seterr()", "A.hints = ()", "import x", "from x import y", "if x:\n    y = 2"),
        "@register\nclass math:\n    pass",
    ):
        assert all(more in of(name, f"{DECLARATION}{more}\n") for name in ("first", "second"))
    assert "x = 1" in of("first", cells=[("student", "x = 1")])
    assert "print(1)" in of("first", cells=[("solution", "y = 1\nprint(1)")])


def test_each_rests_on_everything_unless_each_has_its_own_statement_and_a_plain_plan():
    for old, new in (
        ('A = Exercise(name="first"', 'A = made(name="first"'),
        *(("[A, B]", plan) for plan in ("[A, harder(B)]", "exercises")),
        ("PLAN = ", "PLAN, more = 1, "),
        ("import math", "import math ("),
    ):
        first, second = (of(name, DECLARATION.replace(old, new)) for name in ("first", "second"))
        assert first == second and new in first and "def second" in first
