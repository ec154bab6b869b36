"""What an entry returned, as a copy of our own that its class cannot answer for; or a sentence for the student."""

from __future__ import annotations

from typing import Any

import numpy as np

from nao_course.geometry import FloatArray

MOST_POINTS = 1000  # of an entry in one picture


def as_found_points(answer: Any, name: str = "points") -> FloatArray:
    """Return an answer as points (K, 2).

    Parameters
    ----------
    answer : object
        What an entry returned.
    name : str
        What they are, such as "feet".

    Raises
    ------
    TypeError, ValueError
        If it is something else; the message is for the student.
    """
    if answer is None:
        raise TypeError(f"Your entry returns None: does it end with return {name}?")
    try:
        points = np.array(answer, dtype=float, subok=False)
    except (TypeError, ValueError):
        raise TypeError(f"Your entry must return points (K, 2), got {type(answer).__name__}.") from None
    if points.ndim != 2 or points.shape[1] != 2:
        raise ValueError(f"Your entry must return points (K, 2), none as (0, 2); got shape {points.shape}.")
    if not np.isfinite(points).all():
        raise ValueError("Your entry returns points that are NaN or infinite.")
    if len(points) > MOST_POINTS:
        raise ValueError(f"Your entry returns {len(points)} points; at most {MOST_POINTS} are looked at.")
    return points
