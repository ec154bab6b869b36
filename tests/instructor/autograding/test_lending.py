"""An earlier exercise that is missing or wrong costs its own points, and the page says what was run instead."""

import json
from dataclasses import replace

import pytest

from nao_course.instructor.autograding.assignment import prepare
from nao_course.instructor.autograding.grader import grade, submission_hash
from nao_course.instructor.collecting.submissions import Submission, with_earlier
from tests.toy import pair

AMPLE = 60.0  # seconds for a call that has to succeed, however busy the machine


@pytest.fixture(scope="module")
def assignment(tmp_path_factory):
    course = pair.make_course(tmp_path_factory.mktemp("course"))
    return replace(prepare(course, "81", pair.SECRET), seconds=AMPLE)


@pytest.fixture
def marked(warm_server, assignment, tmp_path):
    """Grade a notebook of the second lesson, beside one of the first or none."""

    def grade_it(functions=None, first=None, *, seconds=AMPLE, handed_in=True, **more):
        path = pair.write(tmp_path / "ada" / f"{pair.SECOND}.ipynb", pair.SECOND, functions, **more)
        made = Submission("ada", pair.SECOND, path)
        if handed_in:
            content = first if isinstance(first, bytes) else None
            earlier = pair.write(
                tmp_path / "ada" / f"{pair.FIRST}.ipynb", pair.FIRST, None if content else first
            )
            if content:
                earlier.write_bytes(content)
            made = replace(made, earlier=(Submission("ada", pair.FIRST, earlier),))
        return grade(made, replace(assignment, seconds=seconds), warm_server)

    return grade_it


def earned(result):
    return {each.name: each.earned for each in result.exercises}


def of(result, name):
    return next(each for each in result.exercises if each.name == name)


ALL = {name: float(points) for name, points in pair.POINTS.items()}


def test_earlier_work_that_was_handed_in_is_used(marked):
    result = marked()
    assert earned(result) == ALL
    assert not any(each.with_reference or each.notes for each in result.exercises) and result.notes == ()


def test_without_earlier_work_it_is_judged_with_the_references_and_says_so(marked):
    result = marked(handed_in=False)
    assert earned(result) == ALL | {"walk": 2.0}
    quadruple, tally = of(result, "quadruple"), of(result, "tally")
    assert quadruple.with_reference and tally.with_reference
    assert (
        "Run again with the reference's double of lesson 80 instead of yours: it is right."
        in quadruple.notes[0]
    )
    assert "Of lesson 80 there is no notebook of yours that could be read." in quadruple.notes[0]
    assert "double of your lesson 80 is not usable yet: there is no notebook" in quadruple.public[0]
    assert "one raises" not in quadruple.public[0]


def test_wrong_earlier_work_costs_nothing_here_and_a_wrong_function_of_their_own_does(marked):
    result = marked(first={"double": "def double(x):\n    return x"})
    assert earned(result) == ALL | {"walk": 2.0}
    assert (
        "Yours of lesson 80 came from the 80_first.ipynb that you handed in."
        in of(result, "quadruple").notes[0]
    )
    wrong = marked({"tally": "def tally(x):\n    return Counter().total()"}, first={"Counter": "pass"})
    assert earned(wrong) == ALL | {"tally": 0.0}
    assert (
        "reference's Counter of lesson 80 instead of yours: it is not right either"
        in of(wrong, "tally").notes[0]
    )


def test_a_wrong_class_of_the_lesson_is_replaced_where_another_exercise_uses_it(marked):
    wrong = pair.RIGHT[pair.SECOND]["Walker"].replace("+=", "-=")
    result = marked({"Walker": wrong})
    assert earned(result) == ALL | {"Walker": 0.0, "walk": 2.0}
    assert (
        "Run again with the reference's Walker and quadruple instead of yours" in of(result, "walk").notes[0]
    )
    heir = "class Heir(Walker):\n    pass\n" + pair.RIGHT[pair.SECOND]["walk"].replace("Walker(", "Heir(")
    assert earned(marked({"Walker": wrong, "walk": heir})) == ALL | {"Walker": 0.0, "walk": 2.0}
    assert earned(marked({"Walker": "pass"})) == ALL | {"Walker": 0.0, "walk": 2.0}


def test_a_class_and_the_functions_that_it_uses_are_both_replaced(marked):
    result = marked({"Walker": "pass", "quadruple": "def quadruple(x):\n    return x"})
    assert earned(result) == ALL | {"quadruple": 0.0, "Walker": 0.0, "walk": 2.0}


def test_who_reads_the_references_class_gains_nothing_elsewhere(marked):
    steals = pair.RIGHT[pair.SECOND]["alone"].replace("return x + 1", "return KEPT.at + 1")
    keeps = "KEPT = None\ndef walk(x):\n    global KEPT\n    KEPT = Walker(x)\n    KEPT.move(1.0)\n"
    keeps += "    return KEPT.estimate() + quadruple(x)"
    result = marked({"Walker": "pass", "walk": keeps, "alone": steals})
    assert earned(result) == ALL | {"Walker": 0.0, "walk": 2.0, "alone": 0.0}
    told = json.dumps([[each.text, each.line, each.public, each.notes] for each in result.exercises])
    assert "self.at" not in told


HOSTILE = {
    "endless": "while_ = 1\nif True:\n    while True: pass",
    "killing": "import os\nx = os._exit(3)",
    "huge": "x = bytearray(2**40)",
    "reading": "x = open('/etc/shadow').read()",
    "patching": "import nao_course.exercises.earlier as e, nao_course.exercises.running as r\n"
    "e.EarlierFunction.__call__ = lambda *_: 1.0\nr._DRIVERS['methods'] = lambda *_: []",
}


@pytest.mark.parametrize(
    "kind",
    [
        each if each in ("killing", "patching") else pytest.param(each, marks=pytest.mark.slow)
        for each in HOSTILE
    ],
)
def test_a_hostile_earlier_notebook_costs_only_what_uses_it(marked, kind):
    seconds = 2.0 if kind == "endless" else AMPLE
    result = marked(first={"double": HOSTILE[kind]}, seconds=seconds)
    got = earned(result)
    assert got["alone"] == 16 and result.status == "graded"
    assert got["quadruple"] in ((0.0,) if kind == "patching" else (1.0,))


def test_an_earlier_notebook_that_is_none_counts_as_missing(marked):
    result = marked(first=b"{")
    assert earned(result) == ALL | {"walk": 2.0}


def test_a_patched_driver_or_resolver_gains_nothing(marked):
    patch = (
        "from nao_course.exercises import running, earlier as other\n"
        "running._DRIVERS['methods'] = lambda made_by, given, turns: [(name, 0.0) for name, _ in turns]\n"
        "other.assigned_use = None\n"
        "def earlier(use): return lambda *_: 0.0"
    )
    result = marked({"Walker": "class Walker: pass"}, before=patch)
    assert earned(result)["Walker"] == 0.0 and earned(result)["alone"] == 16


def test_the_set_up_cell_that_counts_is_the_releases(marked, assignment):
    edited = "from nao_course.student import earlier\ndouble = earlier('80:Counter')"
    try:
        whole, pair.SETUP[pair.SECOND] = pair.SETUP[pair.SECOND], edited
        assert earned(marked())["quadruple"] == 1
    finally:
        pair.SETUP[pair.SECOND] = whole


def test_a_submission_has_changed_when_its_earlier_work_has(tmp_path):
    second = Submission("ada", pair.SECOND, pair.write(tmp_path / "b.ipynb", pair.SECOND))
    first = Submission("ada", pair.FIRST, pair.write(tmp_path / "a.ipynb", pair.FIRST))
    (both,) = with_earlier([second], {("ada", pair.FIRST): first}, lambda lesson: [pair.FIRST])
    assert both.earlier == (first,) and submission_hash(both) != submission_hash(second)
    before = submission_hash(both)
    pair.write(tmp_path / "a.ipynb", pair.FIRST, {"double": "pass"})
    assert submission_hash(both) != before
    first.path.unlink()
    assert submission_hash(both) == submission_hash(second)
    assert with_earlier([second], {("bob", pair.FIRST): first}, lambda lesson: [pair.FIRST]) == [second]
