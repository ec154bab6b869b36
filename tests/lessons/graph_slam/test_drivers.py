"""How solvers are called: what they name is read from their message, and no large matrix becomes dense."""

import numpy as np
import pytest

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


def test_an_answer_is_handed_on_and_an_error_gives_its_numbers():
    def refuse(omega, xi):
        raise np.linalg.LinAlgError("nothing holds 5, 2, 5")

    assert solution_or_unheld(np.linalg.solve, np.eye(2), np.ones(2)).tolist() == [1, 1]
    found = solution_or_unheld(refuse, np.eye(2), np.ones(2))
    assert found == {"named": [2, 5], "said": "nothing holds 5, 2, 5"}


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
