"""How a detector is scored: points that were found against points that are there, and how sure such a number is."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, fields, replace
from typing import Any, TypeVar

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, as_points

__all__ = ["REACH", "PointMatch", "match_points", "total", "wilson_interval"]

REACH = 8.0  # px at 240 rows: how far a point that is found may be from the true one


@dataclass(frozen=True, eq=False)
class PointMatch:
    """What of the points in a picture, or in several, was found.

    Parameters
    ----------
    found : ndarray of bool, shape (K,)
        Which of the true points.
    false : int
        How many points are at no true one.
    """

    found: npt.NDArray[np.bool_]
    false: int

    @property
    def hits(self) -> int:
        """How many true points are found."""
        return int(self.found.sum())

    @property
    def missed(self) -> int:
        """How many true points are not found."""
        return len(self.found) - self.hits

    @property
    def recall(self) -> float:
        """Of the true points, the part that is found; NaN if there are none."""
        return self.hits / len(self.found) if len(self.found) else float("nan")

    @property
    def precision(self) -> float:
        """Of the points, the part that is true; NaN if there are none."""
        points = self.hits + self.false
        return self.hits / points if points else float("nan")

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall: 2 hits / (true points + points); 0 where there is neither."""
        total = len(self.found) + self.hits + self.false
        return 2 * self.hits / total if total else 0.0


Match = TypeVar("Match", bound=PointMatch)


def match_points(
    points: npt.ArrayLike, truth: npt.ArrayLike, excused: npt.ArrayLike = (), reach: float = REACH
) -> PointMatch:
    """Pair found points with true ones, the nearest first, each at most once.

    Parameters
    ----------
    points : array_like, shape (N, 2)
        (u, v) of what was found, pixels.
    truth : array_like, shape (K, 2)
        (u, v) of what is there.
    excused : array_like, shape (M, 2), optional
        (u, v) of what may be found and need not be.
    reach : float
        How far a point may be from a true one, pixels.

    Returns
    -------
    PointMatch
        A point within `reach` of an excused one, and of no true one that is left, is not counted.

    Raises
    ------
    ValueError
        If points have another shape.
    """
    left, there = as_points(points, name="points (u, v)").copy(), as_points(truth, name="true points (u, v)")
    found = np.zeros(len(there), dtype=bool)
    for own, other in _nearest_first(left, there, reach):
        if not np.isnan(left[own]).any() and not found[other]:
            found[other], left[own] = True, np.nan
    left = left[~np.isnan(left).any(axis=1)]
    neither = _distances(left, as_points(excused, name="excused points (u, v)")) > reach
    return PointMatch(found, int(neither.all(axis=1).sum()))


def total(matches: Iterable[Match]) -> Match:
    """Add up the matches of several pictures: at least one, and all of one kind."""
    each = list(matches)
    sums: dict[str, Any] = {}
    for field in fields(each[0]):
        parts = [getattr(match, field.name) for match in each]
        sums[field.name] = sum(parts) if field.name == "false" else np.concatenate(parts)
    return replace(each[0], **sums)


def wilson_interval(hits: int, trials: int, z: float = 1.96) -> tuple[float, float]:
    """Return the interval of a part that is known from a few trials, by Wilson (1927); z = 1.96 is 95 %."""
    if not trials:
        return 0.0, 1.0
    part, share = hits / trials, z**2 / trials
    middle = (part + share / 2) / (1 + share)
    half = z / (1 + share) * float(np.sqrt(part * (1 - part) / trials + share / (4 * trials)))
    return middle - half, middle + half


def _distances(first: FloatArray, second: FloatArray) -> FloatArray:
    """Distances (N, M) between points; infinite where one is NaN."""
    apart = np.linalg.norm(first[:, None] - second[None], axis=2)
    return np.where(np.isnan(apart), np.inf, apart)


def _nearest_first(points: FloatArray, truth: FloatArray, reach: float) -> Iterator[tuple[int, int]]:
    """Pairs (point, true point) within reach, the closest first."""
    apart = _distances(points, truth)
    pairs = np.argwhere(apart <= reach)
    for i, j in pairs[np.argsort(apart[tuple(pairs.T)], kind="stable")]:
        yield int(i), int(j)
