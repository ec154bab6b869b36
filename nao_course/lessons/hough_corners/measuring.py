"""Tools to measure a student's detector: a step exchanged, and at which step true corners are lost."""

from __future__ import annotations

from collections.abc import Callable, Iterable
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
    "two that are not parallel",
)
WHITE_WITHIN, SEGMENT_WITHIN = 3.0, 6.0  # px at 240 rows
PARALLEL = float(np.sin(np.radians(10.0)))


def with_others(function: Callable[..., Any], **others: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function that is the same, but finds other functions behind names that it calls.

    Parameters
    ----------
    function : callable
        Written in Python, such as a student's.
    others : callable
        By the names that they take the place of.

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
    """Count the true corners that are left after each step.

    Parameters
    ----------
    pictures : iterable of CornerPicture
        With their corners.
    label, erase_background, find_segments : callable
        The steps: of a picture, of its labels (H, W), and of the labels that are left.

    Returns
    -------
    dict of str to int
        By the names of `STEPS`.
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
    """Whether a pixel of labels (H, W) that is white lies within so many pixels of a point (u, v)."""
    rows, columns = np.nonzero(labels == 3)
    return bool((np.hypot(columns - point[0], rows - point[1]) <= within).any())


def near_segments(
    segments: FloatArray, point: FloatArray, within: float = SEGMENT_WITHIN
) -> tuple[bool, bool]:
    """Whether a segment (u1, v1, u2, v2) of (N, 4) passes near a point, and whether two do that are not parallel."""
    if not len(segments):
        return False, False
    near = segments[distances_to_segments(point[None], segments)[0] <= within]
    angles = np.arctan2(near[:, 3] - near[:, 1], near[:, 2] - near[:, 0])
    apart = np.abs(np.sin(angles[:, None] - angles))
    return len(near) > 0, bool((apart > PARALLEL).any())
