"""Entries to lesson 08's challenge: none, the nearest, the least certain, most information, the smallest trace."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from nao_course.geometry import FloatArray

Candidates = Sequence[tuple[int, int, float]]


def nothing(omega: FloatArray, xi: FloatArray, candidates: Candidates) -> int:
    """Measure nothing more, as the paper does."""
    return -1


def nearest(omega: FloatArray, xi: FloatArray, candidates: Candidates) -> int:
    """Measure the landmark that is nearest to its pose: what a robot that merely looks does."""
    x = np.linalg.solve(omega, xi)
    return int(np.argmin([abs(x[landmark] - x[pose]) for pose, landmark, _ in candidates]))


def _spread(omega: FloatArray, candidates: Candidates) -> FloatArray:
    """Return the variance of each candidate's difference in the graph."""
    p = np.linalg.inv(omega)
    return np.array([p[i, i] + p[j, j] - 2 * p[i, j] for i, j, _ in candidates])


def least_known(omega: FloatArray, xi: FloatArray, candidates: Candidates) -> int:
    """Measure the difference that is known worst, however badly it can be measured."""
    return int(np.argmax(_spread(omega, candidates)))


def most_information(omega: FloatArray, xi: FloatArray, candidates: Candidates) -> int:
    """Measure what lowers the entropy most: the variance of the difference against that of the measurement."""
    return int(np.argmax(_spread(omega, candidates) / [epsilon for *_, epsilon in candidates]))


def smallest_trace(omega: FloatArray, xi: FloatArray, candidates: Candidates) -> int:
    """Add each candidate, invert, and take the smallest sum of variances."""
    traces = []
    for pose, landmark, epsilon in candidates:
        row = np.zeros(len(xi))
        row[landmark], row[pose] = 1.0, -1.0
        traces.append(np.trace(np.linalg.inv(omega + np.outer(row, row) / epsilon)))
    return int(np.argmin(traces))


CHOICE_ENTRIES: dict[str, Callable[..., int]] = {
    "nothing, as in the paper": nothing,
    "the nearest": nearest,
    "the least certain difference": least_known,
    "the reference: most information": most_information,
    "a better one": smallest_trace,
}
