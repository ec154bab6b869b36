"""Lesson 09, pose graphs: its exercises, what students get wrong in them, and other right ways to write them."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
import scipy.sparse
import scipy.sparse.linalg

from nao_course.geometry import wrap_angle
from nao_course.graphs import Graph, matrices

Array = npt.NDArray[np.float64]

# For a symmetric, positive definite matrix whose rows stand in a good order: no pivots, column by column.
SYMMETRIC = {"diag_pivot_thresh": 0.0, "relax": 1, "panel_size": 1, "options": {"SymmetricMode": True}}


def pose_residual(first: Array, second: Array, z: Array) -> Array:
    """t2v(inv(Z) inv(X_i) X_j): one edge (3,) or E of them (E, 3)."""
    x, y, theta = np.asarray(first).T
    x2, y2, theta2 = np.asarray(second).T
    zx, zy, turn = np.asarray(z).T
    c, s = np.cos(theta), np.sin(theta)
    ahead = c * (x2 - x) + s * (y2 - y) - zx
    left = -s * (x2 - x) + c * (y2 - y) - zy
    c, s = np.cos(turn), np.sin(turn)
    return np.array([c * ahead + s * left, -s * ahead + c * left, wrap_angle(theta2 - theta - turn)]).T


def pose_residual_jacobians(first: Array, second: Array, z: Array) -> tuple[Array, Array]:
    """By the first and by the second pose: (3, 3) each, or (E, 3, 3)."""
    x, y, theta = np.asarray(first).T
    x2, y2, _ = np.asarray(second).T
    turn = np.asarray(z).T[2]
    c, s = np.cos(theta + turn), np.sin(theta + turn)
    dx, dy = x2 - x, y2 - y
    by_first = matrices([[-c, -s, -s * dx + c * dy], [s, -c, -c * dx - s * dy], [0, 0, -1]])
    return by_first, matrices([[c, s, 0], [-s, c, 0], [0, 0, 1]])


def landmark_residual(pose: Array, landmark: Array, z: Array) -> Array:
    """The landmark in the pose's frame, minus z: (2,) or (E, 2)."""
    x, y, theta = np.asarray(pose).T
    lx, ly = np.asarray(landmark).T
    c, s = np.cos(theta), np.sin(theta)
    return np.array([c * (lx - x) + s * (ly - y), -s * (lx - x) + c * (ly - y)]).T - z


def landmark_residual_jacobians(pose: Array, landmark: Array, z: Array) -> tuple[Array, Array]:
    """By the pose (2, 3) and by the landmark (2, 2), or (E, 2, 3) and (E, 2, 2)."""
    x, y, theta = np.asarray(pose).T
    lx, ly = np.asarray(landmark).T
    c, s = np.cos(theta), np.sin(theta)
    dx, dy = lx - x, ly - y
    return matrices([[-c, -s, -s * dx + c * dy], [s, -c, -c * dx - s * dy]]), matrices([[c, s], [-s, c]])


def linearize(graph: Graph, states: Array) -> tuple[scipy.sparse.csc_array, Array]:
    """H (n, n) sparse and b (n,) over all states, the first pose's among them: H = J' Omega J, b = J' Omega e."""
    poses, landmarks = graph.split(states)
    groups = (
        (graph.pose_edges, poses, pose_residual, pose_residual_jacobians),
        (graph.landmark_edges, landmarks, landmark_residual, landmark_residual_jacobians),
    )
    blocks, b = [], np.zeros(graph.size)
    for edges, ends, residual, jacobians in groups:
        here, there = poses[edges.first], ends[edges.second]
        J = np.concatenate(jacobians(here, there, edges.z), axis=-1)
        weighted = J.mT @ edges.information
        blocks.append(weighted @ J)
        shares = weighted @ residual(here, there, edges.z)[..., None]
        b += np.bincount(edges.places.ravel(), shares.ravel(), graph.size)
    return graph.add_blocks(*blocks), b


def gauss_newton(graph: Graph, states: Array, iterations: int) -> tuple[Array, Array]:
    """States after so many steps, and chi2 before the first and after each of them: (iterations + 1,)."""
    states = np.array(states, dtype=float)
    history = [graph.squared_errors(states, pose_residual, landmark_residual).sum()]
    free = graph.elimination_order  # all but the first pose, which stays
    for _ in range(iterations):
        H, b = linearize(graph, states)
        factor = scipy.sparse.linalg.splu(H[free][:, free], "NATURAL", **SYMMETRIC)
        states[free] -= factor.solve(b[free])
        history.append(graph.squared_errors(states, pose_residual, landmark_residual).sum())
    return states, np.array(history)


def marginal_covariances(H: scipy.sparse.csc_array, indices: list[Array]) -> list[Array]:
    """Blocks of inv(H), H positive definite (without the first pose's rows): rows and columns indices[k] each."""
    factor = scipy.sparse.linalg.splu(H.tocsc(), permc_spec="MMD_AT_PLUS_A")
    blocks = []
    for index in indices:
        unit = np.zeros((H.shape[0], len(index)))
        unit[index, np.arange(len(index))] = 1.0
        blocks.append(factor.solve(unit)[index])
    return blocks


def reweight(graph: Graph, states: Array, width: float) -> Graph:
    """The graph with each edge's information times 1 / (1 + chi2 / width^2)^2 (Geman and McClure) at these states."""
    squares = graph.squared_errors(states, pose_residual, landmark_residual)
    weights = 1 / (1 + squares / width**2) ** 2
    return dataclasses.replace(graph, information=graph.information * weights[:, None, None])
