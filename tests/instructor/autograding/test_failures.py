"""What is told of a hidden case is its kind, a shape and a line of the student's own: never what its input decides."""

import json
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from nao_course.exercises.case import Case
from nao_course.exercises.comparisons import All, Close, Each, Property, Unordered
from nao_course.exercises.exercise import PublicExercise
from nao_course.exercises.running import Outcome, alarm
from nao_course.instructor.autograding import failures
from nao_course.instructor.autograding.failures import definition_lines, describe_failure, own_line
from nao_course.instructor.collecting.files import Files
from nao_course.instructor.sandbox.protocol import UNREADABLE

EXERCISE = PublicExercise("f", "90.1", 1.0, 1, Close(), [], [], [], "", True)
SOURCE = 'def f(x):\n    return x / 0\n    y = "é"  # return x / 1\n\ndef g(x):\n    return TABLE[x]'


def described(expected, got, comparison=None, case=None):
    """What is told of an answer to a hidden case."""
    return outcome_of(Outcome("value", got), case or Case((), expected=expected), comparison)


def outcome_of(outcome, case, comparison=None):
    exercise = replace(EXERCISE, comparison=comparison or Close())
    return failures.describe_outcome(exercise, case, outcome, Files(b"{}", {}), 10.0)


@pytest.fixture
def files():
    cells = [{"cell_type": "code", "source": SOURCE.splitlines(keepends=True)}]
    content = json.dumps({"cells": cells}, indent=1).encode()
    return Files(content, {"mine.py": b"def g(x):\n    return x.gone\n"})


OTHER_LINES = [
    "line 3: return x / 0",  # it stands in another line
    "line 2: return x.gone",  # of a helper file
    "line 6: return TABLE[x]",  # of another function
    *("line 2: return x / 1", "line 2: x / 0", "line 2: return x / 0.123", "line 99999: return x / 0"),
    *("line 2", ""),
]


def test_a_line_is_told_where_it_stands_in_the_last_definition_of_the_exercise(files):
    for line in ("line 2: return x / 0", 'line 3: y = "é"  # return x / 1'):
        assert own_line(line, files, "f") == line
    assert [line for line in OTHER_LINES if own_line(line, files, "f") != ""] == []
    second = "import numpy\n\ndef f(\n    x,\n) -> float:\n# why\n\n    return x\nf(1)"
    found = definition_lines(notebook(SOURCE, second, "g = 1"), "f")
    assert sorted(number for number, _ in found) == [3, 4, 5, 6, 7, 8] and (8, "return x") in found
    assert (2, "self.x = 1") not in definition_lines(notebook("class F:\n  self.x = 1"), "f")
    assert (2, "self.x = 1") in definition_lines(notebook("class F:\n  self.x = 1"), "F")
    odd = [b"", b"{", b"[]", b'{"cells": 7}', b'{"cells": [7]}', b"[" * 10**5, b" " * 2**22]
    for content in (*odd, notebook("def f(x):\n" + " \n" * 200)):
        assert definition_lines(content, "f") == frozenset()
    with alarm(60.0):  # blanks without end are read in one pass
        assert definition_lines(notebook("def f(x):\n    return x\n" + " " * 2**20), "f")


def notebook(*sources):
    cells = [{"cell_type": "code", "source": source} for source in sources]
    return json.dumps({"cells": cells}).encode()


def test_a_difference_is_told_by_its_kind_and_without_a_value():
    for got, said in [
        (np.zeros((2, 4)), "the wrong shape: another size along axis 1."),
        (np.zeros(7), "1 dimensions instead of 2"),
        (None, "It returns None"),
        (np.full((2, 3), np.nan), "NaN"),
        ("text", "wrong kind"),
        (np.full((2, 3), 987.0), "not the right values"),
    ]:
        told = described(np.zeros((2, 3)), got)
        assert told is not None and told.state == "wrong"
        assert said in told.text and "987" not in told.text
        assert described(np.zeros((2, 3)), np.zeros((2, 3))) is None
    law = Property(lambda args, kwargs, answer: f"{args[0]} must be {kwargs['wanted']}, you have {answer}")
    case = Case((987.25,), kwargs={"wanted": 654.5})
    for comparison in (law, All((law, Close())), Each({0: law}), Unordered(law)):
        told = described((3.0,), (3.0,), comparison, replace(case, expected=(3.0,)))
        assert told is not None and told.state == "wrong"
        assert not any(word in told.text for word in ("987", "654", "must", "you have"))
    assert "does not have a property that is asked for" in described(3.0, 3.0, law, case).text
    case = Case((987.25,), raises="ValueError")
    told = described(None, 987.25, case=case)
    assert told is not None and told.state == "wrong"
    assert told.text == "It returns an answer where it has to raise an exception."
    raised = Outcome("raised", text="ValueError: 987", errors=("ValueError", "Exception"))
    assert outcome_of(raised, case) is None
    other = Outcome("raised", text="KeyError: 987", errors=("KeyError", "Exception"))
    assert outcome_of(other, case).text == "It raises KeyError."


def test_a_failure_is_told_in_fixed_words_and_without_a_number_of_the_students(files):
    ended = partial(Outcome, "died", None)
    for outcome, said in (
        (Outcome("raised", text="KeyError: 5"), "It raises KeyError."),
        (Outcome("raised", text="E3_14: 5", line="line 1: 5"), "It raises an exception of its own."),
        (ended("the process was ended by signal 9 (Killed)"), "It ends Python itself (Killed)."),
        (ended("the process was ended by signal 12 (User 2)"), "It ends Python itself."),
        (ended("the process ended itself with status 77"), "It ends Python itself."),
        (ended("signal 3.14"), "It ends Python itself."),
        (ended("it called base too often"), "It calls a function of another exercise too often."),
        (ended(UNREADABLE), "Its answer is of a kind that cannot be sent."),
    ):
        told = describe_failure("f", outcome, files, 1.0)
        assert (told.text, told.line) == (said, "")
