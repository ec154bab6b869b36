"""Corners: where two lines meet near their ends, each with an arm that can be seen."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from nao_course.geometry import FloatArray

PARALLEL, HIDING = 0.05, 0.35  # sines: lines do not meet; an edge is hidden no longer than at this angle
Tolerance = Callable[[FloatArray], FloatArray]  # of points (N, 2), in the plane's unit


@dataclass(frozen=True, eq=False)
class Crossings:
    """Points where two lines meet.

    Parameters
    ----------
    points : ndarray, shape (K, 2)
        In the plane of the lines.
    strength : ndarray, shape (K,)
        Length of the shorter line.
    """

    points: FloatArray
    strength: FloatArray


def find_crossings(
    ends: FloatArray, width: FloatArray, flattest: Tolerance, reach: Tolerance, arm: Tolerance
) -> Crossings:
    """Points where two lines meet at an angle, near or between their ends, and that are no crossing of four arms.

    Parameters
    ----------
    ends : ndarray, shape (M, 4)
        Of the lines, in a picture or on the ground.
    flattest : callable
        Sine of the smallest angle between two lines, by where they meet.
    width : ndarray, shape (M,)
        Of the lines: beside another line an edge has no carpet, so that much of it is not seen.
    reach : callable
        How far a line may be extended beyond its ends besides, by where the lines meet.
    arm : callable
        How long an arm must be to be one, by where the lines meet.
    """
    i, j = np.triu_indices(len(ends), 1)
    start, way = ends[:, :2], ends[:, 2:] - ends[:, :2]
    length = np.hypot(*way.T)
    u = way / np.maximum(length, 1e-9)[:, None]
    sine = u[i, 0] * u[j, 1] - u[i, 1] * u[j, 0]
    steep = np.abs(sine) >= PARALLEL
    i, j, sine = i[steep], j[steep], sine[steep]
    between = start[j] - start[i]
    along = {
        "i": (between[:, 0] * u[j, 1] - between[:, 1] * u[j, 0]) / sine,
        "j": (between[:, 0] * u[i, 1] - between[:, 1] * u[i, 0]) / sine,
    }
    points = start[i] + along["i"][:, None] * u[i]
    need, near = arm(points), reach(points) + (width[i] + width[j]) / 2 / np.maximum(np.abs(sine), HIDING)
    arms = np.zeros((len(points), 4), dtype=bool)
    met = np.abs(sine) >= flattest(points)
    for column, (k, t) in enumerate(((i, along["i"]), (j, along["j"]))):
        met &= (t >= -near) & (t <= length[k] + near)
        arms[:, 2 * column] = t >= need
        arms[:, 2 * column + 1] = length[k] - t >= need
    met &= arms[:, :2].any(axis=1) & arms[:, 2:].any(axis=1) & ~arms.all(axis=1)
    return Crossings(points[met], np.minimum(length[i], length[j])[met])


def without_doubles(points: FloatArray, strength: FloatArray, radius: float) -> FloatArray:
    """Of points (K, 2) within `radius` of each other the strongest."""
    kept: list[FloatArray] = []
    for point in points[np.argsort(-strength, kind="stable")]:
        if all(np.hypot(*(point - other)) > radius for other in kept):
            kept.append(point)
    return np.array(kept).reshape(-1, 2)
