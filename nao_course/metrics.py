"""How a detector is scored: points that were found against points that are there, and how sure such a number is."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Protocol, TypeVar

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, as_points, wrap_angle
from nao_course.sim import PictureTruth

__all__ = [
    "REACH",
    "CornerTruth",
    "PointMatch",
    "band",
    "corner_cost",
    "log_density",
    "match_points",
    "mean_interval",
    "squared_distances",
    "total",
    "wilson_interval",
]

REACH = 8.0  # px at 240 rows: how far a point that is found may be from the true one
HIT, FALSE, MISSED = -1.333, 5.0, 1.0  # Aliyev et al. 2014, table 6.1; nothing where nothing is costs nothing
DRAWS = 4000  # of the bootstrap


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


class MarkedPoint(Protocol):
    """A point that a person has marked in a picture."""

    @property
    def kind(self) -> str:
        """Such as "L", "T", "X" or "post_foot"."""
        ...

    @property
    def u(self) -> float:
        """Column, pixels."""
        ...

    @property
    def v(self) -> float:
        """Row, pixels."""
        ...


@dataclass(frozen=True, eq=False)
class CornerTruth:
    """The corners of the field's lines in a picture.

    Parameters
    ----------
    corners : ndarray, shape (K, 2)
        (u, v) of the corners L and T, pixels.
    excused : ndarray, shape (M, 2)
        (u, v) of crossings X and of posts: a corner found there is neither right nor wrong.
    reach : float
        How far a hit may be from its corner, pixels: 8 in a picture of 240 rows.
    """

    corners: FloatArray
    excused: FloatArray
    reach: float = REACH

    @classmethod
    def of(cls, truth: PictureTruth) -> CornerTruth:
        """Read the corners off the truth of a simulated picture; hidden ones count as well."""
        marks = [(mark.landmark.shape, mark.pixel) for mark in truth.landmarks]
        return cls._split(marks, REACH * truth.view.size[1] / 240)

    @classmethod
    def marked(cls, points: Iterable[MarkedPoint], reach: float = REACH) -> CornerTruth:
        """Take the points that a person has marked in a picture, such as those of `RealPicture.points`."""
        return cls._split([(point.kind, (point.u, point.v)) for point in points], reach)

    @classmethod
    def _split(cls, marks: Sequence[tuple[str, tuple[float, float]]], reach: float) -> CornerTruth:
        """Tell corners, which count, from all other points."""
        corners, others = (
            as_points([pixel for shape, pixel in marks if (shape in ("L", "T")) == counts])
            for counts in (True, False)
        )
        return cls(corners, others, reach)

    def match(self, points: npt.ArrayLike) -> PointMatch:
        """Pair found corners (N, 2), (u, v) px, with the true ones; see `match_points`."""
        return match_points(points, self.corners, self.excused, self.reach)


def corner_cost(match: PointMatch) -> float:
    """Add up the paper's costs (table 6.1) of a picture: -1.333 for each hit, 5 for each false, 1 for each missed."""
    return HIT * match.hits + FALSE * match.false + MISSED * match.missed


def mean_interval(values: npt.ArrayLike, probability: float = 0.95) -> tuple[float, float]:
    """Return the bootstrap interval of a mean: between which means the samples' own resamples lie.

    Parameters
    ----------
    values : array_like, shape (N,)
        One a picture; for two detectors on the same pictures the difference, so that hard pictures are hard for both.
    probability : float
        Of the interval.

    Returns
    -------
    (float, float)
        The same at every call; NaN for no values.

    References
    ----------
    B. Efron, *Bootstrap methods: another look at the jackknife*, The Annals of Statistics 7, 1979.
    """
    from scipy.stats import bootstrap  # takes long to import

    given = np.asarray(values, dtype=float)
    if len(given) < 2:
        return (float("nan"),) * 2 if not len(given) else (float(given[0]),) * 2
    found = bootstrap(
        (given,),
        np.mean,
        n_resamples=DRAWS,
        confidence_level=probability,
        method="percentile",
        rng=np.random.default_rng(0),
    )
    return float(found.confidence_interval.low), float(found.confidence_interval.high)


def wilson_interval(hits: int, trials: int, z: float = 1.96) -> tuple[float, float]:
    """Return the interval of a part that is known from a few trials, by Wilson (1927); z = 1.96 is 95 %."""
    if not trials:
        return 0.0, 1.0
    part, share = hits / trials, z**2 / trials
    middle = (part + share / 2) / (1 + share)
    half = z / (1 + share) * float(np.sqrt(part * (1 - part) / trials + share / (4 * trials)))
    return middle - half, middle + half


def band(degrees: int, runs: int, probability: float = 0.95) -> tuple[float, float]:
    """Between what the mean of `runs` independent squares lies with this probability.

    Parameters
    ----------
    degrees : int
        Of freedom of each: 3 for a pose's NEES, 2 for the NIS of bearing and range.
    runs : int
        How many are averaged.
    probability : float
        Part of the cases; half of the rest on each side.

    Returns
    -------
    (float, float)
        Quantiles of chi-square with ``degrees * runs`` degrees of freedom, divided by `runs` (Bar-Shalom et al.
        2001, section 5.4).

    Examples
    --------
    >>> [round(each, 2) for each in band(3, 100)]
    [2.54, 3.5]
    """
    from scipy.stats import chi2  # takes long to import

    low, high = chi2.ppf([(1 - probability) / 2, (1 + probability) / 2], degrees * runs) / runs
    return float(low), float(high)


def squared_distances(vectors: FloatArray, covariances: FloatArray) -> FloatArray:
    """Squared Mahalanobis distances (K,) of vectors (K, n) by covariances (K, n, n), such as NEES and NIS."""
    if not len(vectors):
        return np.zeros(0)
    scaled = np.linalg.solve(covariances, vectors[..., None])[..., 0]
    return np.asarray(np.einsum("ki,ki->k", vectors, scaled))


def log_density(pose: FloatArray, covariance: FloatArray, truth: FloatArray) -> tuple[float, float]:
    """Logarithm (base 2) of a belief's density at the true pose, and the normalised error squared (NEES) there.

    Parameters
    ----------
    pose, truth : ndarray, shape (3,)
        Believed and true: m, rad.
    covariance : ndarray, shape (3, 3)
        Of the belief, positive definite.

    Returns
    -------
    (float, float)
        Bits, and a number without a unit. Who is surer gains bits only where the truth is.
    """
    off = np.append(truth[:2] - pose[:2], wrap_angle(truth[2] - pose[2]))
    root = np.linalg.cholesky(covariance)
    squared = float(np.sum(np.linalg.solve(root, off) ** 2))
    nats = -squared / 2 - float(np.log(np.diag(root)).sum()) - 1.5 * np.log(2 * np.pi)
    return float(nats / np.log(2)), squared


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
