"""The middle of the centre circle, from the straight pieces that a picture's lines have of it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray
from nao_course.lessons.slam_on_the_field.system.lines import to_ground
from nao_course.lessons.slam_on_the_field.system.observation import tilt_slopes
from nao_course.sim import CameraView, Field

RADIUS = Field(2012).dimensions.circle_diameter / 2  # m, by the rules
PIECE = (0.06, 0.6)  # m: how long a piece of it may seem
FARTHEST, ASIDE = 3.5, 0.06  # m: of a piece, from the camera, and from the circle
NEAR = 0.15  # m: middles that two pieces tell and that are one
LEAST_PIECES, STEPS = 3, 5
WORST = 60.0  # condition of the normal equations: pieces side by side do not tell how far the middle is


class Circle(NamedTuple):
    """A circle that was found.

    Parameters
    ----------
    centre : ndarray, shape (2,)
        (x, y) in the robot frame, m.
    slopes : ndarray, shape (2, 2)
        Of that by pitch and roll that were believed too small, m / rad: those of the pieces that tell it.
    """

    centre: FloatArray
    slopes: FloatArray


def find_circle(lines: npt.ArrayLike, view: CameraView) -> Circle | None:
    """Find the centre circle, whose radius the rules give.

    Each piece tells two middles, one on either side. The one that most pieces tell is moved to where they are nearest
    to the circle.

    Parameters
    ----------
    lines : array_like, shape (N, 4)
        As `read_lines` gives them, px.
    view : CameraView
        How the camera looks, its lean taken in.

    Returns
    -------
    Circle or None
        None where fewer than three pieces agree, or they tell too little.
    """
    ground = to_ground(np.asarray(lines, dtype=float).reshape(-1, 2), view).reshape(-1, 2, 2) + view.offset
    way, middle = ground[:, 1] - ground[:, 0], ground.mean(axis=1)
    length = np.hypot(*way.T)
    with np.errstate(invalid="ignore"):  # what is at the horizon has no place
        piece = (length > PIECE[0]) & (length < PIECE[1]) & (np.hypot(*middle.T) < FARTHEST)
    ground, way, middle, length = ground[piece], way[piece], middle[piece], length[piece]
    if len(length) < LEAST_PIECES:
        return None
    left = np.column_stack([-way[:, 1], way[:, 0]]) / length[:, None]
    to_middle = np.sqrt(np.maximum(RADIUS**2 - (length / 2) ** 2, 0.0))[:, None] * left
    told, weight = np.vstack([middle + to_middle, middle - to_middle]), np.tile(length, 2)
    near = np.linalg.norm(told[:, None] - told, axis=2) < NEAR
    winner = near[(near @ weight).argmax()]
    centre = np.average(told[winner], axis=0, weights=weight[winner])
    points = np.stack([ground[:, 0], middle, ground[:, 1]], axis=1)
    for _ in range(STEPS):
        on = (np.abs(np.linalg.norm(points - centre, axis=2) - RADIUS) < ASIDE).all(axis=1)
        if on.sum() < LEAST_PIECES:
            return None
        outward = middle[on] - centre
        distance = np.linalg.norm(outward, axis=1)
        outward = outward / distance[:, None]
        weighted = outward * length[on, None]
        information = weighted.T @ outward
        if np.linalg.cond(information) > WORST:
            return None
        centre = centre + np.linalg.solve(information, weighted.T @ (distance - RADIUS))
    polar = np.column_stack([np.arctan2(*middle[on].T[::-1]), np.hypot(*middle[on].T)])
    farther = (outward * middle[on]).sum(axis=1) / polar[
        :, 1
    ]  # of a metre in range, the part that leads outward
    by_lean = farther[:, None] * tilt_slopes(polar).reshape(-1, 2, 2)[:, 1]
    return Circle(centre, np.linalg.solve(information, weighted.T @ by_lean))
