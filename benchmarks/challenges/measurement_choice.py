"""Entries to lesson 08's challenge: none, the nearest, most information, and three one after the other."""

from collections.abc import Callable, Sequence

import numpy as np

from nao_course.geometry import FloatArray
from nao_course.lessons.graph_slam.challenge import MOST

Candidates = Sequence[tuple[int, int, float]]


def nothing(omega: FloatArray, xi: FloatArray, candidates: Candidates) -> list[int]:
    """Measure nothing more, as the paper does."""
    return []


def nearest(omega: FloatArray, xi: FloatArray, candidates: Candidates) -> list[int]:
    """Measure the landmarks that are nearest to their poses: what a robot that merely looks does."""
    x = np.linalg.solve(omega, xi)
    return np.argsort([abs(x[landmark] - x[pose]) for pose, landmark, _ in candidates])[:MOST].tolist()


def most_information(omega: FloatArray, xi: FloatArray, candidates: Candidates) -> list[int]:
    """Measure what lowers the entropy most: the variance of the difference divided by the measurement's."""
    p = np.linalg.inv(omega)
    each = [(p[i, i] + p[j, j] - 2 * p[i, j]) / epsilon for i, j, epsilon in candidates]
    return np.argsort(each)[-MOST:].tolist()


def _one_by_one(cost: Callable[[FloatArray], float]) -> Callable[..., list[int]]:
    """Return an entry that adds the candidate after which a cost of the variances is least, and so on."""

    def entry(omega: FloatArray, xi: FloatArray, candidates: Candidates) -> list[int]:
        chosen: list[int] = []
        for _ in range(MOST):
            after = {}
            for number in set(range(len(candidates))) - set(chosen):
                pose, landmark, epsilon = candidates[number]
                row = np.zeros(len(xi))
                row[landmark], row[pose] = 1.0, -1.0
                after[number] = omega + np.outer(row, row) / epsilon
            best = min(after, key=lambda number: cost(np.diag(np.linalg.inv(after[number]))))
            chosen.append(best)
            omega = after[best]
        return chosen

    return entry


CHOICE_ENTRIES: dict[str, Callable[..., list[int]]] = {
    "nothing, as in the paper": nothing,
    "the nearest": nearest,
    "one by one, smallest sum": _one_by_one(np.sum),
    "the reference: most information": most_information,
    "a better one: one by one, smallest maximum": _one_by_one(np.max),
}
