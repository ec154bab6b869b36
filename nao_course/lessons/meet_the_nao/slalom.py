"""The gates of lesson 00's slalom, and which of them a path leads through."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray

WIDTH = 0.5  # m between the poles


@dataclass(frozen=True)
class Gate:
    """Two poles to pass between.

    Parameters
    ----------
    x, y : float
        Its middle, in the field frame, metres.
    heading_deg : float
        Of a robot that goes straight through, degrees.
    """

    x: float
    y: float
    heading_deg: float

    @property
    def poles(self) -> FloatArray:
        """The right and the left pole: (2, 2), metres."""
        heading = np.radians(self.heading_deg)
        across = WIDTH / 2 * np.array([-np.sin(heading), np.cos(heading)])
        return np.array([(self.x, self.y) - across, (self.x, self.y) + across])


GATES = (
    Gate(0.6, 0.3, 0.0),
    Gate(1.3, -0.3, 0.0),
    Gate(2.0, 0.3, 20.0),
    Gate(2.5, 1.0, 90.0),
    Gate(1.7, 1.5, 180.0),
    Gate(0.8, 1.2, 200.0),
    Gate(0.5, -0.8, 270.0),
    Gate(1.5, -1.4, 0.0),
)


def passed(path: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    """Say which gates a path leads through.

    Parameters
    ----------
    path : array_like, shape (M + 1, 2)
        Where the robot's middle was at the start and after each command, metres; it walks straight between.

    Returns
    -------
    ndarray of bool, shape (G,)
        For each gate whether a step crosses the line between its poles.
    """
    points = np.asarray(path, dtype=float)
    start, step = points[:-1], np.diff(points, axis=0)
    return np.array([bool(_crosses(start, step, *gate.poles).any()) for gate in GATES])


def _crosses(
    start: FloatArray, step: FloatArray, right: FloatArray, left: FloatArray
) -> npt.NDArray[np.bool_]:
    """Which steps (M, 2) from their starts (M, 2) cross the line from one pole to the other."""
    gate, to_start = left - right, start - right
    side, side_after = _cross(gate, to_start), _cross(gate, to_start + step)
    end = _cross(step, right - start), _cross(step, left - start)
    return ((side < 0) != (side_after < 0)) & (end[0] * end[1] <= 0)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
