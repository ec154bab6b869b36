"""How answers are judged: a picture of bytes; line segments that cover each other, in any order and however cut."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.exercises import Close, Comparison, Verdict, register
from nao_course.exercises.comparisons.structure import as_numbers
from nao_course.geometry import FloatArray

RIGHT = Verdict("right")


@register
def of_bytes(args: tuple[Any, ...], kwargs: dict[str, Any], answer: Any) -> str:
    """Say of an answer that is an array of other numbers than bytes that OpenCV takes no such picture."""
    dtype = getattr(answer, "dtype", np.dtype(np.uint8))
    return "" if dtype == np.uint8 else f"your picture has the dtype {dtype}; uint8 is wanted"


# An answer is looked at up to so many times the wanted length, and some pixels.
MOST_LENGTH, MORE_LENGTH = 4, 500.0
MOST_SEGMENTS = 2000


@register
@dataclass(frozen=True)
class Segments(Comparison):
    """Segments (N, 4) that cover the expected ones and nothing else.

    Parameters
    ----------
    tolerance : float
        How far a point of a segment may be from the nearest one of the other set, pixels.
    share : float
        Which part of the length has to be covered, in both directions.
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
                "value", f"your {_segments(have)} have {length:.3g} pixels in all, far more than there are"
            )
        extra, lacking = (
            1 - coverage(have, wanted, self.tolerance),
            1 - coverage(wanted, have, self.tolerance),
        )
        if extra > 1 - self.share:
            return Verdict(
                "value", f"{extra:.0%} of the length of your {_segments(have)} is where none belongs"
            )
        if lacking > 1 - self.share:
            return Verdict("value", f"{lacking:.0%} of what is to be found is not in your {_segments(have)}")
        return RIGHT

    def alike(self, answer: Any, got: Any) -> bool:
        """As above; a mistake's answer may be no segments at all."""
        if np.shape(answer)[1:] != (4,) or np.shape(got)[1:] != (4,):
            return bool(Close().compare(answer, got))
        return bool(self.compare(answer, got))


def _length(segments: FloatArray) -> float:
    """Length of all segments (N, 4) together, pixels."""
    ways = segments.reshape(-1, 4)
    return float(np.hypot(*(ways[:, 2:] - ways[:, :2]).T).sum())


def _segments(found: FloatArray) -> str:
    return "1 segment" if len(found) == 1 else f"{len(found)} segments"


def coverage(segments: npt.ArrayLike, others: npt.ArrayLike, tolerance: float) -> float:
    """Return which part of the length of segments (N, 4) is within `tolerance` pixels of others (M, 4); 1 for none."""
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
