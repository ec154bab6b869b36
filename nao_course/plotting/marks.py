"""Marks painted into small pictures: black crosses at true points, and rings at detected points."""

from __future__ import annotations

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, as_points
from nao_course.plotting.style import FOUND

Pixels = npt.NDArray[np.uint8]
TRUE = "#000000"  # a cross with a white rim, as truth is black on maps


def enlarged(pixels: npt.ArrayLike, scale: int) -> Pixels:
    """Return a picture (H, W, 3) in which each pixel is a square of `scale` by `scale` pixels, so marks are sharp."""
    return np.asarray(pixels, dtype=np.uint8).repeat(scale, axis=0).repeat(scale, axis=1)


def at_scale(points: npt.ArrayLike, scale: int, name: str = "points (u, v)") -> FloatArray:
    """Return pixels (N, 2), (u, v), of a picture as pixels of the enlarged picture."""
    return as_points(points, name=name) * scale + (scale - 1) / 2


def with_crosses(pixels: npt.ArrayLike, points: npt.ArrayLike, scale: int = 1) -> Pixels:
    """Return a copy of a picture (H, W, 3) with a cross at each true point (K, 2), (u, v) px.

    A cross is 8 pixels wide times `scale`: use 2 for a picture that was enlarged twice. Paint crosses after rings,
    because a ring would hide the cross of a point that was missed by a few pixels.
    """
    shown = np.ascontiguousarray(pixels, dtype=np.uint8).copy()
    for where in as_points(points).round().astype(int).tolist():
        for colour, thickness in (((255, 255, 255), 3 * scale), (rgb(TRUE), scale)):
            cv2.drawMarker(shown, where, colour, cv2.MARKER_TILTED_CROSS, 8 * scale, thickness, cv2.LINE_AA)
    return shown


def with_rings(
    pixels: npt.ArrayLike, points: npt.ArrayLike, name: str = "points (u, v)", scale: int = 1
) -> Pixels:
    """Return a copy of a picture (H, W, 3) with a ring around each detected point (K, 2), (u, v) px.

    A ring is 14 pixels wide times `scale`.
    """
    shown = np.ascontiguousarray(pixels, dtype=np.uint8).copy()
    for u, v in as_points(points, name=name).round().astype(int).tolist():
        for colour, thickness in (((255, 255, 255), 3 * scale), (rgb(FOUND), 2 * scale)):
            cv2.circle(shown, (u, v), 7 * scale, colour, thickness, cv2.LINE_AA)
    return shown


def rgb(colour: str) -> tuple[int, int, int]:
    """Return a colour "#rrggbb" as three numbers from 0 to 255."""
    red, green, blue = (int(colour[i : i + 2], 16) for i in (1, 3, 5))
    return red, green, blue
