"""Scores of detectors: points that were found in pictures are compared with the true points."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, as_points
from nao_course.sim import PictureTruth

__all__ = ["REACH", "CornerTruth", "PointMatch", "corner_cost", "match_points", "total"]

REACH = 8.0  # px in a picture of 240 rows: largest distance of a found point from the true point
HIT, FALSE, MISSED = -1.333, 5.0, 1.0  # costs of Aliyev et al. 2014, table 6.1; a true negative costs nothing


@dataclass(frozen=True, eq=False)
class PointMatch:
    """The result of comparing found points with true points, in one picture or in several.

    Parameters
    ----------
    found : ndarray of bool, shape (K,)
        Whether each of the true points was found.
    false : int
        Number of found points that match no true point.
    """

    found: npt.NDArray[np.bool_]
    false: int

    @property
    def hits(self) -> int:
        """Number of true points that were found."""
        return int(self.found.sum())

    @property
    def missed(self) -> int:
        """Number of true points that were not found."""
        return len(self.found) - self.hits

    @property
    def recall(self) -> float:
        """Share of the true points that were found; NaN if there are no true points."""
        return self.hits / len(self.found) if len(self.found) else float("nan")

    @property
    def precision(self) -> float:
        """Share of the found points that are true; NaN if no points were found."""
        points = self.hits + self.false
        return self.hits / points if points else float("nan")

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall, 2 hits / (true + found points); 0 if there are no points at all."""
        total = len(self.found) + self.hits + self.false
        return 2 * self.hits / total if total else 0.0


Match = TypeVar("Match", bound=PointMatch)


def match_points(
    points: npt.ArrayLike, truth: npt.ArrayLike, excused: npt.ArrayLike = (), reach: float = REACH
) -> PointMatch:
    """Match found points with true points, the closest pairs first, each point at most once.

    Parameters
    ----------
    points : array_like, shape (N, 2)
        Found points (u, v), px.
    truth : array_like, shape (K, 2)
        True points (u, v), px.
    excused : array_like, shape (M, 2), optional
        Points (u, v) that a detector may find but need not find, px.
    reach : float
        Largest distance of a found point from a true point, px.

    Returns
    -------
    PointMatch
        Result of the match. A found point near an excused point that matches no true point is not counted.

    Raises
    ------
    ValueError
        If an array of points has another shape.
    """
    unmatched = as_points(points, name="points (u, v)").copy()
    true = as_points(truth, name="true points (u, v)")
    found = np.zeros(len(true), dtype=bool)
    for own, other in _nearest_first(unmatched, true, reach):
        if not np.isnan(unmatched[own]).any() and not found[other]:
            found[other], unmatched[own] = True, np.nan
    unmatched = unmatched[~np.isnan(unmatched).any(axis=1)]
    too_far = _distances(unmatched, as_points(excused, name="excused points (u, v)")) > reach
    return PointMatch(found, int(too_far.all(axis=1).sum()))


def total(matches: Iterable[Match]) -> Match:
    """Combine the matches of several pictures; there must be at least one, and all of the same class."""
    each = list(matches)
    sums: dict[str, Any] = {}
    for field in fields(each[0]):
        parts = [getattr(match, field.name) for match in each]
        sums[field.name] = sum(parts) if field.name == "false" else np.concatenate(parts)
    return replace(each[0], **sums)


class MarkedPoint(Protocol):
    """A point that a person has marked in a picture."""

    @property
    def kind(self) -> str:
        """Kind of the point, such as "L", "T", "X" or "post_foot"."""
        ...

    @property
    def u(self) -> float:
        """Column in the picture, px."""
        ...

    @property
    def v(self) -> float:
        """Row in the picture, px."""
        ...


@dataclass(frozen=True, eq=False)
class CornerTruth:
    """The true corners of the field's lines in a picture.

    Parameters
    ----------
    corners : ndarray, shape (K, 2)
        Corners (u, v) of the shapes L and T, px.
    excused : ndarray, shape (M, 2)
        Crossings X and posts (u, v), px. A corner that is found there counts as neither right nor wrong.
    reach : float
        Largest distance of a hit from its corner, px; 8 in a picture of 240 rows.
    """

    corners: FloatArray
    excused: FloatArray
    reach: float = REACH

    @classmethod
    def of(cls, truth: PictureTruth) -> CornerTruth:
        """Take the corners from the ground truth of a simulated picture, including hidden corners."""
        marks = [(mark.landmark.shape, mark.pixel) for mark in truth.landmarks]
        return cls._split(marks, REACH * truth.view.size[1] / 240)

    @classmethod
    def marked(cls, points: Iterable[MarkedPoint], reach: float = REACH) -> CornerTruth:
        """Take the corners from points that a person has marked in a picture, such as `RealPicture.points`."""
        return cls._split([(point.kind, (point.u, point.v)) for point in points], reach)

    @classmethod
    def _split(cls, marks: Sequence[tuple[str, tuple[float, float]]], reach: float) -> CornerTruth:
        """Separate the corners, which count, from all other points, which are excused."""
        corners, others = (
            as_points([pixel for shape, pixel in marks if (shape in ("L", "T")) == counts])
            for counts in (True, False)
        )
        return cls(corners, others, reach)

    def match(self, points: npt.ArrayLike) -> PointMatch:
        """Match found corners (N, 2), given as (u, v) in px, with the true corners; see `match_points`."""
        return match_points(points, self.corners, self.excused, self.reach)


def corner_cost(match: PointMatch) -> float:
    """Return the cost by the paper (table 6.1): -1.333 for each hit, 5 for each false point, 1 for each missed one."""
    return HIT * match.hits + FALSE * match.false + MISSED * match.missed


def _distances(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the distances (N, M) between points; infinite if a point is NaN."""
    distances = np.linalg.norm(first[:, None] - second[None], axis=2)
    return np.where(np.isnan(distances), np.inf, distances)


def _nearest_first(points: FloatArray, truth: FloatArray, reach: float) -> Iterator[tuple[int, int]]:
    """Yield the pairs (found point, true point) within reach, the closest pair first."""
    distances = _distances(points, truth)
    pairs = np.argwhere(distances <= reach)
    for i, j in pairs[np.argsort(distances[tuple(pairs.T)], kind="stable")]:
        yield int(i), int(j)
