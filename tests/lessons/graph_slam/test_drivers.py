"""How solvers are called: what they name is read from their message, and no large matrix becomes dense."""

import numpy as np
import pytest
import scipy.sparse
import scipy.sparse.linalg

from nao_course.exercises import Case, call, judging
from nao_course.lessons.graph_slam.drivers import (
    MOST_FILL,
    SMALL,
    SolvedOrNamed,
    fills_up,
    numbers_in,
    solution_or_unheld,
    watched_orders,
)

LOOSE = {"named": [2, 5], "said": ""}


def gathered(function):
    case = Case((np.eye(2), np.ones(2)))
    name = "solution_or_unheld"
    return judging.answer(SolvedOrNamed(), lambda each: call(function, each, name), case).value


def test_an_answer_is_handed_on_and_an_error_gives_its_numbers():
    def refuse(omega, xi):
        raise np.linalg.LinAlgError("nothing holds 5, 2, 5")

    assert gathered(np.linalg.solve).tolist() == [1, 1]
    assert gathered(refuse) == {"named": [2, 5], "said": "nothing holds 5, 2, 5"}
    assert solution_or_unheld(refuse, np.eye(2), np.ones(2)) == ("raised", "nothing holds 5, 2, 5")
    assert numbers_in("Singular matrix") == numbers_in("1e-12 is too small, float64 or 0.5") == []
    assert numbers_in("loose: [np.int64(2), np.int64(7)], array([0 5])") == [2, 7, 0, 5]
    assert numbers_in("nothing holds 3, 4 and 12.") == [3, 4, 12]


def test_a_list_of_numpys_numbers_is_read_to_its_end():
    def refuse(omega, xi):
        raise ValueError(f"nothing holds {list(np.arange(1500))}")

    assert gathered(refuse)["named"] == list(range(1500))


@pytest.mark.parametrize("sent", [LOOSE, ("returned", LOOSE), None], ids=repr)
def test_a_dict_that_is_returned_is_no_error_that_was_raised(sent):
    got = SolvedOrNamed().gather(Case(()), [sent])
    assert not SolvedOrNamed().compare(LOOSE, got)
    assert not SolvedOrNamed().compare(np.ones(2), got)


@pytest.mark.parametrize(
    ("expected", "got", "said"),
    [
        (LOOSE, {"named": [2, 5], "said": "any words, 2 and 5"}, ""),
        (LOOSE, {"named": [2], "said": "only 2"}, "names 1 variable, but nothing holds 2"),
        (LOOSE, {"named": [1, 2], "said": "1, 2"}, "names 2 variables, but nothing holds other ones"),
        (LOOSE, np.ones(6), "should raise a ValueError"),
        (np.ones(2), {"named": [], "said": "Singular matrix"}, "raises ValueError: 'Singular matrix'"),
        (np.ones(2), np.array([1.0, 1.1]), "is wrong"),
        (np.ones(2), np.ones(2) + 1e-9, ""),
    ],
)
def test_a_verdict_says_whether_an_error_or_an_answer_was_due_and_never_which(expected, got, said):
    verdict = SolvedOrNamed().compare(expected, got)
    assert bool(verdict) is (said == "") and said in verdict.text
    assert "5" not in verdict.text, "a variable that nobody named stays unsaid"


def star(size, centre):
    """Return a system in which every variable is linked to one."""
    links = np.full(size, 1.0)
    matrix = scipy.sparse.lil_array((size, size))
    matrix[centre], matrix[:, [centre]] = -links, -links[:, None]
    matrix.setdiag(2.0 * size)
    return matrix.tocsc()


def test_the_entries_of_a_factor_are_counted_up_to_a_limit_and_scipys_solvers_are_as_before_afterwards(rng):
    assert fills_up(star(SMALL, 0)) and not fills_up(star(SMALL, SMALL - 1))
    dense = 2 * MOST_FILL + 4
    assert not fills_up(scipy.sparse.eye_array(dense)) and not fills_up(star(dense, 0))
    before = scipy.sparse.linalg.splu, scipy.sparse.linalg.spsolve
    with pytest.raises(KeyError), watched_orders():
        raise KeyError
    assert (scipy.sparse.linalg.splu, scipy.sparse.linalg.spsolve) == before


@pytest.mark.parametrize("solver", ["splu", "spsolve"])
def test_a_poor_order_is_stopped_at_once_and_a_good_one_is_not(solver):
    def solve(omega, xi):
        if solver == "splu":
            return scipy.sparse.linalg.splu(omega, permc_spec="NATURAL").solve(xi)
        return scipy.sparse.linalg.spsolve(omega, xi, permc_spec="NATURAL")

    size = SMALL + 10
    assert solution_or_unheld(solve, star(size, 0), np.ones(size)) == ("poor order", None)
    kind, x = solution_or_unheld(solve, star(size, size - 1), np.ones(size))
    assert kind == "returned" and star(size, size - 1) @ x == pytest.approx(np.ones(size))
    assert solution_or_unheld(solve, star(100, 0), np.ones(100))[0] == "returned"
    with pytest.warns(scipy.sparse.SparseEfficiencyWarning) as said:
        solution_or_unheld(lambda omega, xi: solve(omega.tocoo(), xi), star(100, 99), np.ones(100))
    assert {each.filename for each in said} == {__file__}, "it names the student's line"


def test_a_stopped_order_is_wrong_also_if_its_error_is_caught_and_messages_that_were_cut_off_are_alike():
    def catches(omega, xi):
        try:
            return scipy.sparse.linalg.splu(omega, permc_spec="NATURAL").solve(xi)
        except Exception as error:
            raise ValueError("nothing holds 1") from error

    sent = solution_or_unheld(catches, star(SMALL + 10, 0), np.ones(SMALL + 10))
    comparison = SolvedOrNamed()
    got = comparison.gather(Case(()), [sent])
    for expected in (np.ones(2), LOOSE):
        verdict = comparison.compare(expected, got)
        assert not verdict and f"more than {MOST_FILL} times as many entries" in verdict.text
    assert comparison.alike(got, dict(got)) and not comparison.alike(np.ones(2), got)
    parts = (range(2000), range(1800), range(1, 2000))
    all_of_them, cut, other = ({"named": list(part), "said": ""} for part in parts)
    assert SolvedOrNamed().alike(all_of_them, cut) and not SolvedOrNamed().alike(all_of_them, other)
