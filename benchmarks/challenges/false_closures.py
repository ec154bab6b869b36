"""Entries to lesson 09's challenge: odometry, plain Gauss-Newton, the lesson's kernel, and closures that are tested."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.sparse.linalg import splu

from benchmarks import solution
from nao_course.geometry import FloatArray
from nao_course.graphs import Graph

WIDTH = 3.0  # of the kernel, standard deviations
GATE = 16.0  # of three numbers: an honest closure fails it once in a thousand


def nothing(graph: Graph, states: FloatArray) -> FloatArray:
    """Use the odometry alone, without closures."""
    return states


def plain(graph: Graph, states: FloatArray) -> FloatArray:
    """Use all edges with their stated information, as the paper does."""
    return np.asarray(solution("09")["gauss_newton"](graph, states, 15)[0])


def kernel(graph: Graph, states: FloatArray) -> FloatArray:
    """Reweight all edges before each of twenty steps, starting with the odometry."""
    gauss_newton, reweight = (solution("09")[name] for name in ("gauss_newton", "reweight"))
    for _ in range(20):
        states = gauss_newton(reweight(graph, states, WIDTH), states, 1)[0]
    return states


def tested_one_by_one(graph: Graph, states: FloatArray) -> FloatArray:
    """Take the closure whose outcome is known best, believe it where it fits what is known, and go on with the next."""
    gauss_newton = solution("09")["gauss_newton"]
    believed = graph.edges[:, 1] == graph.edges[:, 0] + 1
    waiting = np.flatnonzero(~believed).tolist()
    e, S = _innovations(graph, waiting, _part(graph, believed), states)
    while waiting:
        best = int(np.argmin(np.linalg.slogdet(S)[1]))
        fits = e[best] @ np.linalg.solve(S[best], e[best]) < GATE
        number = waiting.pop(best)
        e, S = np.delete(e, best, axis=0), np.delete(S, best, axis=0)
        if fits:
            believed[number] = True
            states = gauss_newton(_part(graph, believed), states, 1)[0]
            if waiting:
                e, S = _innovations(graph, waiting, _part(graph, believed), states)
    return np.asarray(gauss_newton(_part(graph, believed), states, 5)[0])


def _part(graph: Graph, kept: npt.NDArray[np.bool_]) -> Graph:
    """Return the graph with some of its edges."""
    return replace(
        graph,
        edges=graph.edges[kept],
        measurements=graph.measurements[kept],
        information=graph.information[kept],
    )


def _innovations(
    graph: Graph, waiting: Sequence[int], known: Graph, states: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the residuals (C, 3) of closures at the current estimate, and their covariances (C, 3, 3)."""
    lesson, poses, ends = solution("09"), graph.split(states)[0], graph.edges[waiting]
    pairs = poses[ends[:, 0]], poses[ends[:, 1]], graph.measurements[waiting]
    rows = (3 * ends[:, :, None] + np.arange(3)).reshape(-1, 6)
    P = _covariances(lesson["linearize"](known, states)[0], rows)
    J = np.concatenate(lesson["pose_residual_jacobians"](*pairs), axis=2)
    S = J @ P @ J.mT + np.linalg.inv(graph.information[waiting])
    return np.asarray(lesson["pose_residual"](*pairs)), S


def _covariances(H: Any, rows: npt.NDArray[np.int64]) -> FloatArray:
    """Return blocks of the covariance (C, 6, 6), with the first pose known exactly."""
    every, where = np.unique(rows, return_inverse=True)
    units = np.zeros((H.shape[0], len(every)))
    units[every, np.arange(len(every))] = 1.0
    columns = np.zeros_like(units)
    columns[3:] = splu(H[3:, 3:].tocsc(), permc_spec="MMD_AT_PLUS_A").solve(units[3:])
    which = where.reshape(rows.shape)
    return np.asarray(columns[rows[:, :, None], which[:, None, :]])


FALSE_CLOSURE_ENTRIES: dict[str, Callable[[Graph, FloatArray], FloatArray]] = {
    "nothing: the odometry": nothing,
    "plain Gauss-Newton": plain,
    "the reference: the kernel": kernel,
    "a better one: each closure tested": tested_one_by_one,
}
