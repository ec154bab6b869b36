"""The given solver, with which the map moves until the student's functions replace its parts.

Its derivatives are differences, and it solves the least squares problem of all residuals as one sparse system.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import scipy.sparse
import scipy.sparse.linalg

from nao_course.geometry import FloatArray, wrap_angle
from nao_course.graphs import Edges, Graph
from nao_course.lessons.pose_graphs.worlds import between, moved

Function = Callable[..., Any]
STEP = 1e-6  # m and rad, of the differences


def given_pose_residual(first: FloatArray, second: FloatArray, z: FloatArray) -> FloatArray:
    """Return poses (E, 3) as seen from the poses that the measurements z (E, 3) predict."""
    return between(moved(first, z), second)


def given_landmark_residual(pose: FloatArray, landmark: FloatArray, z: FloatArray) -> FloatArray:
    """Return landmarks (E, 2) in the frames of poses (E, 3), minus the measurements z (E, 2)."""
    return between(pose, np.column_stack([landmark, np.zeros(len(landmark))]))[:, :2] - z


def differences(residual: Function) -> Function:
    """Return a function that computes the Jacobians of a residual by central differences."""

    def jacobians(first: FloatArray, second: FloatArray, z: FloatArray) -> list[FloatArray]:
        found = []
        for which, end in enumerate((first, second)):
            columns = []
            for move in STEP * np.eye(end.shape[1]):
                ends = [
                    (first + sign * move, second) if which == 0 else (first, second + sign * move)
                    for sign in (1, -1)
                ]
                change = np.subtract(*(np.asarray(residual(*pair, z)) for pair in ends))
                change[:, 2:] = wrap_angle(change[:, 2:])
                columns.append(change / (2 * STEP))
            found.append(np.stack(columns, axis=2))
        return found

    return jacobians


def given_gauss_newton(
    graph: Graph,
    states: FloatArray,
    iterations: int,
    *,
    pose_residual: Function = given_pose_residual,
    landmark_residual: Function = given_landmark_residual,
    pose_residual_jacobians: Function | None = None,
    landmark_residual_jacobians: Function | None = None,
) -> tuple[FloatArray, FloatArray]:
    """Take some steps of Gauss-Newton with the first pose held; return the states (size,) and chi2 at each of them.

    A student may replace the residuals and Jacobians; by default the Jacobians are differences of the residuals.
    """
    states = states.copy()
    residuals = pose_residual, landmark_residual
    jacobians = (
        pose_residual_jacobians or differences(pose_residual),
        landmark_residual_jacobians or differences(landmark_residual),
    )
    chi2 = [graph.squared_errors(states, *residuals).sum()]
    for _ in range(iterations):
        A, r = _whitened(graph, states, residuals, jacobians)
        states[3:] -= _least_squares(A[:, 3:], r)
        chi2.append(graph.squared_errors(states, *residuals).sum())
    return states, np.array(chi2)


def _whitened(
    graph: Graph, states: FloatArray, residuals: tuple[Function, ...], jacobians: tuple[Function, ...]
) -> tuple[Any, FloatArray]:
    """Return the Jacobian of all residuals and the residuals, in standard deviations: one row per number."""
    poses, landmarks = graph.split(states)
    tall, right = [], []
    for edges, ends, residual, jacobian in zip(
        (graph.pose_edges, graph.landmark_edges), (poses, landmarks), residuals, jacobians, strict=True
    ):
        if len(edges.z):
            given = poses[edges.first], ends[edges.second], edges.z
            roots = np.linalg.cholesky(edges.information).mT
            right.append((roots @ np.asarray(residual(*given))[:, :, None]).ravel())
            tall.append(_rows(edges, [roots @ np.asarray(each) for each in jacobian(*given)], graph.size))
    return scipy.sparse.vstack(tall).tocsc(), np.concatenate(right)


def _rows(edges: Edges, blocks: list[FloatArray], size: int) -> Any:
    """Return the blocks of each edge, (E, d, 3) and (E, d, w), as rows of one sparse matrix."""
    numbers = np.arange(edges.z.size).reshape(edges.z.shape)
    begins = 0, blocks[0].shape[2]
    parts = []
    for begin, block in zip(begins, blocks, strict=True):
        columns = edges.places[:, None, begin : begin + block.shape[2]]
        rows, columns = np.broadcast_arrays(numbers[:, :, None], columns)
        parts.append(
            scipy.sparse.coo_array((block.ravel(), (rows.ravel(), columns.ravel())), (edges.z.size, size))
        )
    return parts[0] + parts[1]


def _least_squares(A: Any, r: FloatArray) -> FloatArray:
    """Return the x with the smallest |A x - r|, from the sparse system of x and the remaining residuals."""
    identity = scipy.sparse.eye_array(len(r))
    both = scipy.sparse.block_array([[identity, A], [A.T, None]]).tocsc()
    solution: FloatArray = scipy.sparse.linalg.splu(both).solve(np.append(r, np.zeros(A.shape[1])))
    return solution[len(r) :]
