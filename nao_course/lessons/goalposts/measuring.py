"""Which goal feet a detector finds: true feet of a picture, hits, misses and false ones, and sums over pictures."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, as_points
from nao_course.sim import Field, PictureTruth

REACH = 8.0  # px at 240 rows: how far a foot that is found may be from the true one


@dataclass(frozen=True, eq=False)
class Feet:
    """The feet of goal posts in a picture.

    Parameters
    ----------
    pixels : ndarray, shape (K, 2)
        (u, v) of those that can be found.
    distances : ndarray, shape (K,)
        From the robot over the ground, metres; NaN where nobody knows.
    excused : ndarray, shape (M, 2)
        Feet that are hidden, or outside the picture: to find one of them, by its post, is neither right nor wrong.
    """

    pixels: FloatArray
    distances: FloatArray
    excused: FloatArray

    @classmethod
    def of(cls, truth: PictureTruth, field: Field) -> Feet:
        """Read the feet off a picture's truth; `field` is the one it was taken on."""
        seen = [mark for mark in truth.landmarks if mark.landmark.kind == "post"]
        clear = [mark for mark in seen if not mark.occluded]
        everywhere = truth.view.project(field.posts, truth.pose)
        known = as_points([mark.pixel for mark in clear])
        apart = (_between(everywhere, known) > 1e-6).all(axis=1)
        return cls(known, np.array([mark.distance for mark in clear]), everywhere[apart])


@dataclass(frozen=True, eq=False)
class FootMatch:
    """What of the feet in one picture, or in several, was found.

    Parameters
    ----------
    distances : ndarray, shape (K,)
        Of all true feet, metres.
    found : ndarray of bool, shape (K,)
        Which of them.
    false : int
        How many points are at no foot.
    """

    distances: FloatArray
    found: npt.NDArray[np.bool_]
    false: int

    @property
    def recall(self) -> float:
        """Of the true feet, the part that is found; NaN if there are none."""
        return float(self.found.mean()) if len(self.found) else float("nan")

    @property
    def precision(self) -> float:
        """Of the points, the part that is at a foot; NaN if there are none."""
        points = int(self.found.sum()) + self.false
        return float(self.found.sum() / points) if points else float("nan")

    @property
    def f1(self) -> float:
        """Harmonic mean of precision and recall: 2 found / (feet + points); 0 where there is neither."""
        total = len(self.found) + int(self.found.sum()) + self.false
        return 2 * float(self.found.sum()) / total if total else 0.0

    def __str__(self) -> str:
        """In words."""
        return f"{self.found.sum()} of {len(self.found)} feet found, {self.false} false"


def match_feet(points: npt.ArrayLike, feet: Feet, reach: float = REACH) -> FootMatch:
    """Pair found points with true feet, the nearest first, each at most once.

    Parameters
    ----------
    points : array_like, shape (N, 2)
        (u, v) of what was found, pixels.
    feet : Feet
        The truth.
    reach : float
        How far a point may be from its foot, pixels.

    Returns
    -------
    FootMatch
        A point within `reach` of an excused foot, and of no other, is not counted.

    Raises
    ------
    ValueError
        If the points have another shape.
    """
    left = as_points(points, name="points (u, v)")
    found = np.zeros(len(feet.pixels), dtype=bool)
    for own, foot in _nearest_first(left, feet.pixels, reach):
        if not np.isnan(left[own]).any() and not found[foot]:
            found[foot], left[own] = True, np.nan
    left = left[~np.isnan(left).any(axis=1)]
    false = (_between(left, feet.excused) > reach).all(axis=1).sum()
    return FootMatch(feet.distances, found, int(false))


def total(matches: Iterable[FootMatch]) -> FootMatch:
    """Add up the matches of several pictures."""
    each: Sequence[FootMatch] = list(matches)
    if not each:
        return FootMatch(np.zeros(0), np.zeros(0, dtype=bool), 0)
    distances, found = (
        np.concatenate(parts) for parts in zip(*((m.distances, m.found) for m in each), strict=True)
    )
    return FootMatch(distances, found.astype(bool), sum(m.false for m in each))


def wilson_interval(hits: int, trials: int, z: float = 1.96) -> tuple[float, float]:
    """Return the interval of a part that is known from a few trials, by Wilson (1927); z = 1.96 is 95 %."""
    if not trials:
        return 0.0, 1.0
    part, share = hits / trials, z**2 / trials
    middle = (part + share / 2) / (1 + share)
    half = z / (1 + share) * float(np.sqrt(part * (1 - part) / trials + share / (4 * trials)))
    return middle - half, middle + half


def _between(first: FloatArray, second: FloatArray) -> FloatArray:
    """Distances (N, M) between points; infinite where one is NaN."""
    apart = np.linalg.norm(first[:, None] - second[None], axis=2)
    return np.where(np.isnan(apart), np.inf, apart)


def _nearest_first(points: FloatArray, feet: FloatArray, reach: float) -> list[tuple[int, int]]:
    """Pairs (point, foot) within reach, the closest first."""
    apart = _between(points, feet)
    pairs = np.argwhere(apart <= reach)
    return [(int(i), int(j)) for i, j in pairs[np.argsort(apart[tuple(pairs.T)], kind="stable")]]
