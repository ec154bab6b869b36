"""Functions of the library that give the same answers as exercises, and replace a student's unusable functions.

They answer any call. Recorded calls answer only the calls that the reference makes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.geometry import wrap_angle
from nao_course.slam import range_and_bearing

_STEP = 1e-6  # of difference quotients; their error is about 1e-10


def _by_pose(pose: npt.ArrayLike, landmark: npt.ArrayLike) -> npt.NDArray[Any]:
    """Return the difference quotients of bearing and range by the pose, (2, 3)."""
    moves = _STEP * np.eye(3)
    at = np.asarray(pose, dtype=float).reshape(3)
    return _quotients(range_and_bearing(at + moves, landmark), range_and_bearing(at - moves, landmark))


def _by_landmark(pose: npt.ArrayLike, landmark: npt.ArrayLike) -> npt.NDArray[Any]:
    """Return the difference quotients of bearing and range by the landmark's position, (2, 2)."""
    moves = _STEP * np.eye(2)
    at = np.asarray(landmark, dtype=float).reshape(2)
    return _quotients(range_and_bearing(pose, at + moves), range_and_bearing(pose, at - moves))


def _quotients(ahead: npt.NDArray[Any], behind: npt.NDArray[Any]) -> npt.NDArray[Any]:
    change = ahead - behind
    change[:, 0] = wrap_angle(change[:, 0])
    return change.T / (2 * _STEP)


IN_LIBRARY: Mapping[str, Callable[..., Any]] = {
    "05:expected_measurement": range_and_bearing,
    "05:measurement_jacobian_pose": _by_pose,
    "05:measurement_jacobian_landmark": _by_landmark,
    "07:warp2pi": wrap_angle,
}
