"""Conversion of an entry's answer to a plain array, with an error message for the student if that fails."""

from __future__ import annotations

from typing import Any

import numpy as np

from nao_course.geometry import FloatArray

MOST_POINTS = 1000  # largest number of points in one answer


def as_found_points(answer: Any, name: str = "points") -> FloatArray:
    """Return an answer as points (K, 2).

    Raise a TypeError or ValueError with a message for the student, which calls them `name`, if it is something else.
    """
    if answer is None:
        raise TypeError(f"Your entry returns None: does it end with return {name}?")
    try:
        points = np.array(answer, dtype=float, subok=False)
    except (TypeError, ValueError):
        raise TypeError(
            f"Your entry must return points of shape (K, 2), got {type(answer).__name__}."
        ) from None
    if points.ndim != 2 or points.shape[1] != 2:
        raise ValueError(
            f"Your entry must return points of shape (K, 2), or (0, 2) without any points; got shape {points.shape}."
        )
    if not np.isfinite(points).all():
        raise ValueError("Your entry returns points that contain NaN or infinite numbers.")
    if len(points) > MOST_POINTS:
        raise ValueError(f"Your entry returns {len(points)} points, but at most {MOST_POINTS} are allowed.")
    return points
