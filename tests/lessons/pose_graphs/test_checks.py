"""What lesson 09's public checks take, refuse and say, beyond the declaration's mistakes and alternatives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse
from scipy.sparse.linalg import splu, spsolve

from nao_course.exercises import lesson
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


def whole_inverse(H, indices):
    inverse = splu(H.tocsc()).solve(np.eye(H.shape[0]))
    return [inverse[np.ix_(index, index)] for index in indices]


def dense_by_product(H, indices):
    inverse = np.linalg.inv(H @ np.eye(H.shape[0]))
    return [inverse[np.ix_(index, index)] for index in indices]


def dense(H, indices):
    inverse = np.linalg.inv(H.toarray())
    return [inverse[np.ix_(index, index)] for index in indices]


def loose(H, indices):
    """As a solver that stops early has it; how early differs from processor to processor."""
    return [(1 + 5e-7) * block for block in OWN["marginal_covariances"](H, indices)]


def with_something_on_the_diagonal(H, indices):
    return OWN["marginal_covariances"](H + 1e-8 * scipy.sparse.eye_array(H.shape[0]), indices)


def block_of_h(H, indices):
    return [np.linalg.inv(H[index][:, index].toarray()) for index in indices]


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (whole_inverse, "WholeMatrixError: your function held 4.5 million numbers at a time"),
        (dense_by_product, "the blocks need a few columns of it"),
        (dense, "You make H dense."),
        (loose, "it is close"),
        (with_something_on_the_diagonal, "it is close"),
        (block_of_h, "if all other variables were known exactly"),
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
        ({"careful": True}, "take the whole step, with nothing added to H"),
        ({"diagonal": 1e-3}, "take the whole step, with nothing added to H"),
        ({"patience": 1e-8}, "`iterations` steps are wanted"),
        ({"order": True}, "What was solved with b[free] belongs to states[free]"),
        ({"hold": slice(0, -3)}, "You hold the last three numbers"),
    ],
)
def test_what_is_no_plain_step_is_told(changed, said):
    assert CHECK("gauss_newton", stepped())
    report = CHECK("gauss_newton", stepped(**changed))
    assert not report and said in repr(report)


def test_a_system_with_nothing_held_is_told_whatever_comes_of_it():
    def solve(graph, states, iterations):
        found, history = OWN["gauss_newton"](graph, states, iterations)
        return found + np.arange(len(found)) % 7, history

    assert "your first pose does not stay" in repr(CHECK("gauss_newton", solve))


def weights(graph, states, width):
    squares = graph.squared_errors(states, OWN["pose_residual"], OWN["landmark_residual"])
    return 1 / (1 + squares / width**2)


def reweighted_in_place(graph, states, width):
    information = graph.information
    information *= weights(graph, states, width)[:, None, None]
    return replace(graph, information=information)


def reweighted_by_assigning(graph, states, width):
    graph.information = graph.information * weights(graph, states, width)[:, None, None]
    return graph


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (reweighted_in_place, "You write into the graph that you were given"),
        (reweighted_by_assigning, "cannot be changed by assigning"),
    ],
)
def test_a_graph_that_is_given_stays_as_it_is(wrong, said):
    report = CHECK("reweight", wrong)
    assert not report and said in repr(report)


def test_a_residual_that_asks_for_three_numbers_takes_three_edges_for_one_and_is_refused():
    def residual(first, second, z):
        if len(first) == 3:
            return np.array([OWN["pose_residual"](first.T, second.T, z.T)]).squeeze().T
        return OWN["pose_residual"](first, second, z)

    assert "len(pose) == 3 does not tell three edges" in repr(CHECK("pose_residual", residual))
    listed = CHECK("pose_residual", lambda *pair: OWN["pose_residual"](*pair).tolist())
    assert not listed and "linearize calculates with it" in repr(listed)
