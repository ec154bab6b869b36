"""What an update may not add: information about a rotation of everything, which no measurement contains."""

from __future__ import annotations

from typing import Any

import numpy as np

from nao_course.exercises import register
from nao_course.geometry import FloatArray


def rotation_direction(state: FloatArray) -> FloatArray:
    """Return N (n,), by which a state (n,) changes for each radian that everything rotates about the origin."""
    points = np.delete(state, 2).reshape(-1, 2)
    return np.insert(np.column_stack([-points[:, 1], points[:, 0]]).ravel(), 2, 1.0)


def rotation_information(state: FloatArray, covariance: FloatArray) -> float:
    """Return the information of a belief about a rotation of everything, per rad^2."""
    direction = rotation_direction(state)
    return float(direction @ np.linalg.pinv(covariance) @ direction)


@register
def keeps_rotation(args: tuple[Any, ...], kwargs: dict[str, Any], answer: Any) -> str:
    """Check that an update adds no information about the rotation of everything."""
    (before, covariance, *_), (after, updated) = args, answer
    if np.shape(after) != np.shape(before) or np.shape(updated) != np.shape(covariance):
        return ""
    if not np.isfinite(after).all() or not np.isfinite(updated).all():
        return ""
    ratio = rotation_information(np.asarray(after), np.asarray(updated))
    ratio /= rotation_information(before, covariance)
    if abs(ratio - 1) < 1e-6:
        return ""
    return (
        f"Your update multiplies the information about the rotation N by {ratio:.2f}, but no measurement contains "
        "information about it. Compute N at the new state for the new covariance"
    )
