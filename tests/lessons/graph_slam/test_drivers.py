"""How solvers are called: what they name is read from their message, and no large matrix becomes dense."""

import subprocess
import sys

import numpy as np
import pytest

from nao_course.exercises import Case, call, judging
from nao_course.lessons.graph_slam.drivers import (
    SolvedOrNamed,
    numbers_in,
    solution_or_unheld,
)


@pytest.mark.parametrize(
    ("message", "numbers"),
    [
        ("nothing holds 3, 4 and 12", [3, 4, 12]),
        ("loose: [np.int64(2), np.int64(7)]", [2, 7]),
        ("array([0 5])", [0, 5]),
        ("Singular matrix", []),
        ("1e-12 is too small, float64 or 0.5", []),
        ("variables 1,2.", [1, 2]),
    ],
)
def test_whole_numbers_are_read_and_those_in_words_and_fractions_are_not(message, numbers):
    assert numbers_in(message) == numbers


def gathered(function):
    case = Case((np.eye(2), np.ones(2)))
    return judging.answer(
        SolvedOrNamed(), lambda each: call(function, each, "solution_or_unheld"), case
    ).value


def test_an_answer_is_handed_on_and_an_error_gives_its_numbers():
    def refuse(omega, xi):
        raise np.linalg.LinAlgError("nothing holds 5, 2, 5")

    assert gathered(np.linalg.solve).tolist() == [1, 1]
    assert gathered(refuse) == {"named": [2, 5], "said": "nothing holds 5, 2, 5"}
    assert solution_or_unheld(refuse, np.eye(2), np.ones(2)) == ("raised", "nothing holds 5, 2, 5")


@pytest.mark.parametrize(
    "sent",
    [
        {"named": [2, 5], "said": ""},
        ("returned", {"named": [2, 5], "said": ""}),
        ("raised", [2, 5]),
        (),
        None,
    ],
    ids=repr,
)
def test_a_dict_that_is_returned_is_no_error_that_was_raised(sent):
    got = SolvedOrNamed().gather(Case(()), [sent])
    assert not SolvedOrNamed().compare({"named": [2, 5], "said": ""}, got)
    assert not SolvedOrNamed().compare(np.ones(2), got)


LOOSE = {"named": [2, 5], "said": ""}


@pytest.mark.parametrize(
    ("expected", "got", "said"),
    [
        (LOOSE, {"named": [2, 5], "said": "any words, 2 and 5"}, ""),
        (
            {"named": [2, 5], "said": ""},
            {"named": [2], "said": "only 2"},
            "names 1 variable, and nothing holds 2 of them: 'only 2'",
        ),
        (
            {"named": [2, 5], "said": ""},
            {"named": [1, 2], "said": "1, 2"},
            "names 2 variables, and nothing holds other ones",
        ),
        (LOOSE, np.ones(6), "has to raise a ValueError"),
        (np.ones(2), {"named": [], "said": "Singular matrix"}, "raises ValueError: 'Singular matrix'"),
        (np.ones(2), np.array([1.0, 1.1]), "off"),
        (np.ones(2), np.ones(2) + 1e-9, ""),
    ],
)
def test_a_verdict_says_whether_an_error_or_an_answer_was_due_and_never_which(expected, got, said):
    verdict = SolvedOrNamed().compare(expected, got)
    assert bool(verdict) is (said == "") and said in verdict.text
    assert "5" not in verdict.text, "a variable that nobody named stays unsaid"


def test_a_check_of_this_lesson_loads_no_panel_and_no_figure():
    heavy = "'ipywidgets', 'matplotlib.figure', 'nao_course.widgets', 'nao_course.lessons.graph_slam.panel'"
    script = (
        "import sys\n"
        "import nao_course.lessons.graph_slam.drivers\n"
        f"print([name for name in ({heavy}) if name in sys.modules])"
    )
    loaded = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert loaded.stdout.strip() == "[]"
