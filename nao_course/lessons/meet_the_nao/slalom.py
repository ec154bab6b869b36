"""The gates of the slalom in lesson 00, and a function that returns which of them a path passes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray

WIDTH = 0.5  # m between the poles


@dataclass(frozen=True)
class Gate:
    """Two poles around x, y, in m, field frame; a robot with the heading `heading_deg` walks straight between them."""

    x: float
    y: float
    heading_deg: float

    @property
    def poles(self) -> FloatArray:
        """Return the right and the left pole, shape (2, 2), in metres."""
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
    """Return which gates (G,) are crossed between their poles by a path (M + 1, 2) of straight steps, in metres."""
    points = np.asarray(path, dtype=float)
    start, step = points[:-1], np.diff(points, axis=0)
    return np.array([bool(_crosses(start, step, *gate.poles).any()) for gate in GATES])


def _crosses(
    start: FloatArray, step: FloatArray, right: FloatArray, left: FloatArray
) -> npt.NDArray[np.bool_]:
    """Return which steps (M, 2) from their starts (M, 2) cross the line between the poles."""
    gate, to_start = left - right, start - right
    side, side_after = _cross(gate, to_start), _cross(gate, to_start + step)
    end = _cross(step, right - start), _cross(step, left - start)
    return ((side < 0) != (side_after < 0)) & (end[0] * end[1] <= 0)


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
