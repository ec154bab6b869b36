"""Measure a student's detector: try its parts, replace a step, count the true corners left after each step."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from itertools import combinations
from types import FunctionType
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray
from nao_course.lessons.hough_corners.scenes import CornerPicture
from nao_course.lessons.hough_corners.segments import distances_to_segments

STEPS = (
    "in the picture",
    "white within 3 px",
    "still there after erasing",
    "a segment within 6 px",
    "two segments, not parallel",
)
WHITE_WITHIN, SEGMENT_WITHIN = 3.0, 6.0  # px at 240 rows
PARALLEL = float(np.sin(np.radians(10.0)))


def all_crossings(
    segments: npt.ArrayLike, intersect: Callable[[FloatArray, FloatArray], FloatArray | None]
) -> FloatArray:
    """Return where segments meet, for each pair of segments that has an intersection.

    Parameters
    ----------
    segments : (N, 4) array_like
        The ends (u1, v1, u2, v2) of each segment in pixels.
    intersect : callable
        Returns the intersection (u, v) of two segments in pixels, or None; for example a student's function.

    Returns
    -------
    (K, 2) numpy.ndarray
        The first segment with each later one, then the second with each later one, and so on.
    """
    found = (intersect(*pair) for pair in combinations(np.asarray(segments), 2))
    return np.reshape([point for point in found if point is not None], (-1, 2)).astype(float)


def with_others(function: Callable[..., Any], **others: Callable[..., Any]) -> Callable[..., Any]:
    """Return a copy of a function that calls other functions in place of some that it uses.

    Parameters
    ----------
    function : callable
        A function written in Python, such as a student's.
    others : callable
        The replacements, each by the name of the function it replaces.

    Examples
    --------
    >>> def double(x): return 2 * x
    >>> def use(x): return double(x) + 1
    >>> with_others(use, double=lambda x: 10 * x)(2), use(2)
    (21, 5)
    """
    names = {**function.__globals__, **others}
    made = FunctionType(
        function.__code__, names, function.__name__, function.__defaults__, function.__closure__
    )
    made.__kwdefaults__ = function.__kwdefaults__
    return made


def count_corners(
    pictures: Iterable[CornerPicture],
    label: Callable[[Any], Any],
    erase_background: Callable[[Any], Any],
    find_segments: Callable[[Any], Any],
) -> dict[str, int]:
    """Count the true corners that survive each step of the detector.

    Parameters
    ----------
    pictures : iterable of CornerPicture
        The pictures with their true corners.
    label, erase_background, find_segments : callable
        The steps: they take a picture, its labels (H, W), and the labels that were not erased.

    Returns
    -------
    dict of str to int
        The counts, by the names in `STEPS`.
    """
    left = np.zeros(len(STEPS), dtype=int)
    for picture in pictures:
        labels = np.asarray(label(picture.pixels.copy()))
        kept = np.asarray(erase_background(labels))
        segments = np.asarray(find_segments(kept), dtype=float).reshape(-1, 4)
        for corner in picture.truth.corners:
            white, still = (near_white(each, corner) for each in (labels, kept))
            left += [True, white, still, *near_segments(segments, corner)]
    return dict(zip(STEPS, left.tolist(), strict=True))


def near_white(labels: npt.NDArray[Any], point: FloatArray, within: float = WHITE_WITHIN) -> bool:
    """Return whether a white pixel of labels (H, W) lies within so many pixels of a point (u, v)."""
    rows, columns = np.nonzero(labels == 3)
    return bool((np.hypot(columns - point[0], rows - point[1]) <= within).any())


def near_segments(
    segments: FloatArray, point: FloatArray, within: float = SEGMENT_WITHIN
) -> tuple[bool, bool]:
    """Return whether a segment of (N, 4) passes near a point, and whether two do that are not parallel."""
    if not len(segments):
        return False, False
    near = segments[distances_to_segments(point[None], segments)[0] <= within]
    angles = np.arctan2(near[:, 3] - near[:, 1], near[:, 2] - near[:, 0])
    apart = np.abs(np.sin(angles[:, None] - angles))
    return len(near) > 0, bool((apart > PARALLEL).any())
