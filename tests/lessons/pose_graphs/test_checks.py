"""What lesson 09's public checks accept, refuse and say, beyond the declaration's mistakes and alternatives."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse
from scipy.sparse.linalg import splu, spsolve

from nao_course.exercises import Case, lesson
from nao_course.lessons.pose_graphs import loop
from nao_course.lessons.pose_graphs.judging.comparing import SolvedStates
from tests.lessons.pose_graphs.own import OWN

CHECK = lesson("09_pose_graphs")[0]


def units(H, index):
    columns = np.zeros((H.shape[0], len(index)))
    columns[index, np.arange(len(index))] = 1
    return columns


def solved_sparse(H, indices):
    found = []
    for index in indices:
        X = spsolve(H.tocsc(), scipy.sparse.csc_array(units(H, np.append(index, 0))))
        found.append(X.toarray()[index][:, : len(index)])
    return found


def by_schur(H, indices):
    H, found = H.tocsr(), []
    for index in indices:
        rest = np.setdiff1d(np.arange(H.shape[0]), index)
        between = H[rest][:, index].toarray()
        share = splu(H[rest][:, rest].tocsc()).solve(between)
        found.append(np.linalg.inv(H[index][:, index].toarray() - between.T @ share))
    return found


@pytest.mark.parametrize("right", [solved_sparse, by_schur])
def test_blocks_by_way_of_sparse_columns_or_of_schur_are_right(right):
    assert CHECK("marginal_covariances", right)


def blocks_of(inverse_of):
    """Return a solution that cuts its blocks out of a whole inverse."""

    def solve(H, indices):
        inverse = inverse_of(H)
        return [inverse[np.ix_(index, index)] for index in indices]

    return solve


def times(factor):
    """As a solver that stops early has it; how early differs from processor to processor."""
    return lambda H, indices: [factor * block for block in OWN["marginal_covariances"](H, indices)]


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (blocks_of(lambda H: splu(H.tocsc()).solve(np.eye(H.shape[0]))), "held 4.5 million numbers"),
        (blocks_of(lambda H: np.linalg.inv(H @ np.eye(H.shape[0]))), "the blocks need a few columns"),
        (blocks_of(lambda H: np.linalg.inv(H.toarray())), "You make H dense"),
        (times(1 + 5e-7), "it is close"),
        (lambda H, rows: [np.linalg.inv(H[i][:, i].toarray()) for i in rows], "known exactly"),
    ],
)
def test_blocks_by_a_whole_matrix_or_nearly_right_are_refused_for_what_they_are(wrong, said):
    report = CHECK("marginal_covariances", wrong)
    assert not report and said in repr(report)


def stepped(hold=slice(3, None), careful=False, diagonal=0.0, patience=0.0, order=False):
    """Gauss-Newton with something changed."""

    def solve(graph, states, iterations):
        squares = OWN["pose_residual"], OWN["landmark_residual"]
        states, history = states.copy(), [graph.squared_errors(states, *squares).sum()]
        for _ in range(iterations):
            H, b = OWN["linearize"](graph, states)
            H = H + diagonal * scipy.sparse.eye_array(len(b))
            delta = np.zeros(len(b))
            delta[hold] = splu(H[hold, hold].tocsc()).solve(-b[hold])
            if order:
                free = graph.elimination_order
                delta[3:] = delta[free]
            if np.abs(delta).max() < patience:
                break
            while careful and graph.squared_errors(states + delta, *squares).sum() > 1.0001 * history[-1]:
                delta = delta / 2
            states = states + delta
            history.append(graph.squared_errors(states, *squares).sum())
        return states, np.array(history)

    return solve


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"careful": True}, "take the full step, and add nothing to H"),
        ({"diagonal": 1e-3}, "take the full step, and add nothing to H"),
        ({"patience": 1e-8}, "should take all `iterations` steps"),
        ({"order": True}, "solved with b[free] belongs to states[free]"),
        ({"hold": slice(0, -3)}, "You fix the last three numbers"),
    ],
)
def test_what_is_no_plain_step_is_told(changed, said):
    assert CHECK("gauss_newton", stepped())
    report = CHECK("gauss_newton", stepped(**changed))
    assert not report and said in repr(report)


def test_a_system_with_nothing_held_is_said_and_a_residual_that_is_not_for_many_edges_is_refused():
    def solve(graph, states, iterations):
        found, history = OWN["gauss_newton"](graph, states, iterations)
        return found + np.arange(len(found)) % 7, history

    assert "first pose" in repr(CHECK("gauss_newton", solve))

    def residual(first, second, z):
        if len(first) == 3:
            return np.array([OWN["pose_residual"](first.T, second.T, z.T)]).squeeze().T
        return OWN["pose_residual"](first, second, z)

    assert "len(first) == 3 holds for one pose and for three poses" in repr(CHECK("pose_residual", residual))
    listed = CHECK("pose_residual", lambda *pair: OWN["pose_residual"](*pair).tolist())
    assert not listed and "linearize computes with the result" in repr(listed)


def weighted(graph, states, width):
    squares = graph.squared_errors(states, OWN["pose_residual"], OWN["landmark_residual"])
    return graph.information / (1 + squares / width**2)[:, None, None]


def reweighted_in_place(graph, states, width):
    graph.information[:] = weighted(graph, states, width)
    return replace(graph)


def reweighted_by_assigning(graph, states, width):
    graph.information = weighted(graph, states, width)
    return graph


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (reweighted_in_place, "You change the graph that was given"),
        (reweighted_by_assigning, "assign to an attribute of the graph"),
    ],
)
def test_a_graph_that_is_given_stays_as_it_is(wrong, said):
    report = CHECK("reweight", wrong)
    assert not report and said in repr(report)


WORLD = loop(1, side=2)
EXPECTED = (WORLD.truth, np.array([2.0, 1.0]))
CASE = Case((WORLD.graph, WORLD.odometry, 1), expected=EXPECTED)


def moved(place, by):
    states = WORLD.truth.copy()
    states[place] += by
    return states, EXPECTED[1]


@pytest.mark.parametrize(
    ("answer", "right"),
    [
        (list(EXPECTED), True),
        (moved(5, 2 * np.pi), True),
        (moved(4, 2 * np.pi), False),
        (moved(5, 0.1), False),
        (moved(5, np.nan), False),
        ((WORLD.truth, np.array([2.0, 1.1])), False),
        ((WORLD.truth[:3], EXPECTED[1]), False),
        (WORLD.truth, False),
    ],
)
def test_headings_may_differ_by_whole_turns_and_nothing_else_may(answer, right):
    assert bool(SolvedStates().judge(CASE, answer)) is right
