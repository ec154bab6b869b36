"""The catalogue of mistakes in a measurement's Jacobian from which lesson 05's challenge chooses."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, wrap_angle
from nao_course.slam import range_and_bearing

Change = Callable[[FloatArray, float], FloatArray]

ROWS = ("bearing", "range")
COLUMNS = ("x", "y", "theta", "l_x", "l_y")
_STEP = 1e-6  # of central differences


def jacobian_at(pose: npt.ArrayLike, landmark: npt.ArrayLike) -> FloatArray:
    """Return the Jacobian (2, 5) of (bearing, range) by x, y, theta, l_x and l_y, from central differences."""
    at = np.concatenate([np.asarray(pose, dtype=float), np.asarray(landmark, dtype=float)])
    changes = np.stack([_measured(at + step) - _measured(at - step) for step in _STEP * np.eye(5)], axis=1)
    changes[0] = wrap_angle(changes[0])
    return changes / (2 * _STEP)


def _measured(at: FloatArray) -> FloatArray:
    return range_and_bearing(at[:3], at[3:])


def _times(row: int, columns: tuple[int, ...], power: int = 0, factor: float = 1.0) -> Change:
    """Return a change that multiplies entries of a row by a factor and a power of the range."""

    def change(matrix: FloatArray, distance: float) -> FloatArray:
        changed = matrix.copy()
        changed[row, list(columns)] *= factor * distance**power
        return changed

    return change


def _exchange(row: int, columns: tuple[int, int]) -> Change:
    """Return a change that swaps two entries of a row but keeps the sign that belongs to each position."""

    def change(matrix: FloatArray, distance: float) -> FloatArray:
        changed = matrix.copy()
        sign = -1.0 if row == 0 else 1.0
        changed[row, list(columns)] = sign * matrix[row, list(columns[::-1])]
        return changed

    return change


def _parts_exchanged(matrix: FloatArray, distance: float) -> FloatArray:
    return matrix[:, [3, 4, 2, 0, 1]]


def _rows_exchanged(matrix: FloatArray, distance: float) -> FloatArray:
    return matrix[::-1].copy()


_ROBOT, _LANDMARK = (0, 1), (3, 4)

# Each mistake, by its name, changes the right matrix (2, 5); it is given the range, too.
MISTAKES: Mapping[str, Change] = MappingProxyType(
    {
        "the -1 is missing": _times(0, (2,), factor=0.0),
        "plus 1 for -1": _times(0, (2,), factor=-1.0),
        "bearing by x, y: sign": _times(0, _ROBOT, factor=-1.0),
        "bearing by l_x, l_y: sign": _times(0, _LANDMARK, factor=-1.0),
        "range by x, y: sign": _times(1, _ROBOT, factor=-1.0),
        "range by l_x, l_y: sign": _times(1, _LANDMARK, factor=-1.0),
        "bearing by x, y: r for r^2": _times(0, _ROBOT, power=1),
        "bearing by l_x, l_y: r for r^2": _times(0, _LANDMARK, power=1),
        "range by x, y: r^2 for r": _times(1, _ROBOT, power=-1),
        "range by l_x, l_y: r^2 for r": _times(1, _LANDMARK, power=-1),
        "bearing by x, y: dx and dy swapped": _exchange(0, _ROBOT),
        "bearing by l_x, l_y: dx and dy swapped": _exchange(0, _LANDMARK),
        "range by x, y: dx and dy swapped": _exchange(1, _ROBOT),
        "range by l_x, l_y: dx and dy swapped": _exchange(1, _LANDMARK),
        "robot and landmark exchanged": _parts_exchanged,
        "bearing and range exchanged": _rows_exchanged,
        "bearing in degrees": _times(0, (0, 1, 2, 3, 4), factor=180 / np.pi),
    }
)


def with_mistake(name: str, pose: npt.ArrayLike, landmark: npt.ArrayLike) -> FloatArray:
    """Return the Jacobian (2, 5) of a measurement with one mistake of the catalogue."""
    matrix = jacobian_at(pose, landmark)
    away = np.asarray(landmark, dtype=float) - np.asarray(pose, dtype=float)[:2]
    return MISTAKES[name](matrix, float(np.hypot(*away)))
