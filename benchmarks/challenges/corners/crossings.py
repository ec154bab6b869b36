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
    """Find points where two lines meet at an angle, near or between their ends, and that are no crossing of four arms.

    Parameters
    ----------
    ends : ndarray, shape (M, 4)
        Of the lines, in a picture or on the ground.
    width : ndarray, shape (M,)
        Of the lines: beside another line an edge has no carpet, so that much of it is not seen.
    flattest : callable
        Sine of the smallest angle between two lines, by where they meet.
    reach : callable
        How far a line may be extended beyond its ends besides, by where the lines meet.
    arm : callable
        How long an arm must be to be one, by where the lines meet.

    Returns
    -------
    Crossings
        In no particular order, doubles among them.
    """
    start, way = ends[:, :2], ends[:, 2:] - ends[:, :2]
    length = np.hypot(*way.T)
    way = way / np.maximum(length, 1e-9)[:, None]
    i, j = np.triu_indices(len(ends), 1)
    sine = _cross(way[i], way[j])
    steep = np.abs(sine) >= PARALLEL
    i, j, sine = i[steep], j[steep], sine[steep]
    between = start[j] - start[i]
    along_i, along_j = _cross(between, way[j]) / sine, _cross(between, way[i]) / sine
    points = start[i] + along_i[:, None] * way[i]
    need, near = arm(points), reach(points) + (width[i] + width[j]) / 2 / np.maximum(np.abs(sine), HIDING)
    met, arms = np.abs(sine) >= flattest(points), []
    for k, along in ((i, along_i), (j, along_j)):
        met &= (along >= -near) & (along <= length[k] + near)
        arms.append(np.array([along >= need, length[k] - along >= need]))
    met &= arms[0].any(axis=0) & arms[1].any(axis=0) & ~(arms[0] & arms[1]).all(axis=0)
    return Crossings(points[met], np.minimum(length[i], length[j])[met])


def _cross(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the cross products (N,) of vectors (N, 2)."""
    return np.asarray(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])


def without_doubles(points: FloatArray, strength: FloatArray, radius: float) -> FloatArray:
    """Keep of points (K, 2) within `radius` of each other the strongest."""
    kept: list[FloatArray] = []
    for point in points[np.argsort(-strength, kind="stable")]:
        if all(np.hypot(*(point - other)) > radius for other in kept):
            kept.append(point)
    return np.array(kept).reshape(-1, 2)
