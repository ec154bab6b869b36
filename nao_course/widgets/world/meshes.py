"""Closed surfaces from which the robot is built: superellipsoids, which are anything from a ball to a rounded box."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, rotation_3d

ROWS, COLUMNS = 8, 12


@dataclass(frozen=True)
class Shape:
    """A superellipsoid on a link of the robot.

    `centre`, m, and `turned`, yaw, pitch and roll of its own axes, rad, are in the link's frame; `size` has the whole
    lengths along its own axes, m. `square` is the squareness of the outline from the side and from above: 1 is round,
    0.3 a box with rounded edges. `taper` has the lengths along x and y at the top in proportion to the bottom, and
    `shift` moves the top ahead, m.
    """

    link: str
    colour: str
    centre: tuple[float, float, float]
    size: tuple[float, float, float]
    square: tuple[float, float] = (1.0, 1.0)
    taper: tuple[float, float] = (1.0, 1.0)
    turned: tuple[float, float, float] = (0.0, 0.0, 0.0)
    shift: float = 0.0

    def mirrored(self, link: str) -> Shape:
        """Return the same shape on the link of the other side of the body."""
        (x, y, z), (yaw, pitch, roll) = self.centre, self.turned
        return Shape(
            link,
            self.colour,
            (x, -y, z),
            self.size,
            self.square,
            self.taper,
            (-yaw, pitch, -roll),
            self.shift,
        )

    def points(self) -> FloatArray:
        """Return the corners (N, 3) of the surface in the link's frame, m: lowest point, rings, highest point."""
        up, across = self.square
        latitude = np.linspace(-np.pi / 2, np.pi / 2, ROWS)[1:-1, None]
        longitude = np.linspace(0, 2 * np.pi, COLUMNS, endpoint=False)
        ring = _power(np.cos(latitude), up)
        unit = np.stack(
            [
                ring * _power(np.cos(longitude), across),
                ring * _power(np.sin(longitude), across),
                _power(np.sin(latitude), up) * np.ones(COLUMNS),
            ],
            axis=-1,
        ).reshape(-1, 3)
        unit = np.vstack([[0, 0, -1], unit, [0, 0, 1]])
        height = (unit[:, 2:] + 1) / 2
        unit[:, :2] *= 1 + height * (np.array(self.taper) - 1)
        own = unit * np.array(self.size) / 2
        own[:, 0] += height[:, 0] * self.shift
        return np.asarray(own @ rotation_3d(*self.turned).T + self.centre)


@lru_cache(maxsize=1)
def triangles() -> npt.NDArray[np.intp]:
    """Return the corners (M, 3) of the triangles of every shape, counterclockwise seen from outside."""
    rings = 1 + np.arange((ROWS - 2) * COLUMNS).reshape(ROWS - 2, COLUMNS)
    after = np.roll(rings, -1, axis=1)
    low, high = rings[:-1], rings[1:]
    low_after, high_after = after[:-1], after[1:]
    last = 1 + rings.size
    found = [
        np.stack([np.zeros(COLUMNS, dtype=int), after[0], rings[0]], axis=-1),
        np.stack([low, low_after, high_after], axis=-1),
        np.stack([low, high_after, high], axis=-1),
        np.stack([np.full(COLUMNS, last), rings[-1], after[-1]], axis=-1),
    ]
    return np.concatenate([each.reshape(-1, 3) for each in found])


def _power(value: FloatArray, exponent: float) -> FloatArray:
    """Return the power of the magnitude, with the sign of the value."""
    return np.asarray(np.sign(value) * np.abs(value) ** exponent)
