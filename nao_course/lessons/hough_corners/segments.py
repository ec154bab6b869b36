"""Compare answers of lesson 03: pictures by their dtype, line segments by the pixels that they cover."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course._internal.counts import say_count
from nao_course.exercises import Close, Comparison, Exact, Verdict, register
from nao_course.exercises.comparisons.structure import as_numbers
from nao_course.geometry import FloatArray

RIGHT = Verdict("right")


@register
@dataclass(frozen=True)
class BytePicture(Exact):
    """Compare pictures like `Exact`; an array of another dtype than uint8, which OpenCV needs, is wrong."""

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare the dtype of a picture first, and then its values."""
        dtype = getattr(got, "dtype", np.dtype(np.uint8))
        if dtype != np.uint8:
            return Verdict("type", f"your picture has dtype {dtype}, but OpenCV needs uint8")
        return super().compare(expected, got)

    def alike(self, answer: Any, got: Any) -> bool:
        """Return whether two wrong answers have the same dtype and the same values."""
        same = getattr(answer, "dtype", None) == getattr(got, "dtype", None)
        return same and bool(Exact().compare(answer, got))


@register
@dataclass(frozen=True)
class Crossing(Close):
    """Compare crossings (u, v) like `Close`; None is a wrong answer like any other, because it has a meaning."""

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare a crossing with the expected one; either may be None."""
        if got is None and expected is not None:
            return Verdict("value", "your answer is None, but these segments meet")
        return super().compare(expected, got)


# An answer that is longer than this many times the expected length plus some pixels is rejected at once.
MOST_LENGTH, MORE_LENGTH = 4, 500.0
MOST_SEGMENTS = 2000


@register
@dataclass(frozen=True)
class Segments(Comparison):
    """Compare segments (N, 4) by coverage: they must cover the expected ones and nothing else.

    Parameters
    ----------
    tolerance : float
        Largest distance of a point on a segment to the nearest segment of the other set, pixels.
    share : float
        Fraction of the length that must be covered, in both directions.
    """

    tolerance: float = 2.0
    share: float = 0.9

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare segments (x1, y1, x2, y2) with the expected ones."""
        wanted = np.asarray(expected, dtype=float)
        have = as_numbers(got, "your answer")
        if isinstance(have, Verdict):
            return have
        if have.ndim != 2 or have.shape[1] != 4:
            return Verdict(
                "shape", f"your answer has shape {have.shape}; N segments have shape (N, 4), none (0, 4)"
            )
        if not np.isfinite(have).all():
            return Verdict("nan", "your answer has NaN or infinity in it")
        have = have.astype(float)
        with np.errstate(over="ignore"):
            length, most = _length(have), MOST_LENGTH * (_length(wanted) + MORE_LENGTH)
        if length > most or len(have) > MOST_SEGMENTS:  # before points are made along them
            return Verdict(
                "value",
                f"your {_segments(have)} are {length:.3g} pixels long in total, far longer than expected",
            )
        extra, lacking = (
            1 - coverage(have, wanted, self.tolerance),
            1 - coverage(wanted, have, self.tolerance),
        )
        if extra > 1 - self.share:
            return Verdict(
                "value",
                f"{extra:.0%} of the length of your {_segments(have)} lies where no segment is expected",
            )
        if lacking > 1 - self.share:
            verb = "misses" if len(have) == 1 else "miss"
            return Verdict("value", f"your {_segments(have)} {verb} {lacking:.0%} of the expected length")
        return RIGHT

    def alike(self, answer: Any, got: Any) -> bool:
        """Return whether two wrong answers cover the same pixels; an answer of another shape is compared as numbers."""
        if np.shape(answer)[1:] != (4,) or np.shape(got)[1:] != (4,):
            return bool(Close().compare(answer, got))
        return bool(self.compare(answer, got))


def _length(segments: FloatArray) -> float:
    """Return the total length of segments (N, 4), pixels."""
    ways = segments.reshape(-1, 4)
    return float(np.hypot(*(ways[:, 2:] - ways[:, :2]).T).sum())


def _segments(found: FloatArray) -> str:
    return say_count(len(found), "segment")


def coverage(segments: npt.ArrayLike, others: npt.ArrayLike, tolerance: float) -> float:
    """Return the fraction of the length of segments (N, 4) within `tolerance` px of others (M, 4); 1 if N is 0."""
    points = sample(np.asarray(segments, dtype=float))
    near = np.asarray(others, dtype=float)
    if not len(points):
        return 1.0
    if not len(near):
        return 0.0
    return float((distances_to_segments(points, near).min(axis=1) <= tolerance).mean())


def sample(segments: FloatArray, step: float = 1.0) -> FloatArray:
    """Return points (K, 2) along segments (N, 4), about one every `step` pixels."""
    parts = [
        np.linspace(each[:2], each[2:], max(2, round(float(np.hypot(*(each[2:] - each[:2]))) / step)))
        for each in segments
    ]
    return np.concatenate(parts) if parts else np.zeros((0, 2))


def distances_to_segments(points: FloatArray, segments: FloatArray) -> FloatArray:
    """Return the distance (K, N) of each point (K, 2) to each segment (N, 4), pixels."""
    start, way = segments[:, :2], segments[:, 2:] - segments[:, :2]
    along = ((points[:, None] - start) * way).sum(axis=2) / np.maximum((way**2).sum(axis=1), 1e-9)
    nearest = start + np.clip(along, 0, 1)[..., None] * way
    return np.asarray(np.linalg.norm(points[:, None] - nearest, axis=2))
