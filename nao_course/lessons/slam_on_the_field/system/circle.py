"""The middle of the centre circle, from the straight pieces that a picture's lines have of it."""

from __future__ import annotations

import numpy as np

from nao_course.geometry import FloatArray
from nao_course.lessons.slam_on_the_field.system.lines import to_ground
from nao_course.sim import CameraView, Field

RADIUS = Field(2012).dimensions.circle_diameter / 2  # m, by the rules
PIECE = (0.06, 0.6)  # m: how long a piece of it may seem
FARTHEST, ASIDE = 3.5, 0.06  # m: of a piece, from the camera, and from the circle
NEAR = 0.15  # m: middles that two pieces tell and that are one
LEAST_PIECES, STEPS = 3, 5
WORST = 60.0  # condition of the normal equations: pieces side by side do not tell how far the middle is


def circle_centre(lines: FloatArray, view: CameraView, radius: float = RADIUS) -> FloatArray:
    """Find the middle of a circle of known radius.

    Each piece tells two middles, one on either side. The one that most pieces tell is moved to where they are nearest
    to the circle.

    Parameters
    ----------
    lines : ndarray, shape (N, 4)
        As `read_lines` gives them, px.
    view : CameraView
        How the camera looks, its lean taken in.
    radius : float
        Of the circle, m.

    Returns
    -------
    ndarray, shape (1, 2) or (0, 2)
        (x, y) in the robot frame, m; nothing where fewer than three pieces agree, or they tell too little.
    """
    none = np.zeros((0, 2))
    ground = to_ground(lines.reshape(-1, 2), view).reshape(-1, 2, 2)
    way, middle = ground[:, 1] - ground[:, 0], ground.mean(axis=1)
    length = np.hypot(*way.T)
    with np.errstate(invalid="ignore"):  # what is at the horizon has no place
        piece = (length > PIECE[0]) & (length < PIECE[1]) & (np.hypot(*middle.T) < FARTHEST)
    ground, way, middle, length = ground[piece], way[piece], middle[piece], length[piece]
    if len(length) < LEAST_PIECES:
        return none
    left = np.column_stack([-way[:, 1], way[:, 0]]) / length[:, None]
    to_middle = np.sqrt(np.maximum(radius**2 - (length / 2) ** 2, 0.0))[:, None] * left
    told = np.vstack([middle + to_middle, middle - to_middle])
    votes = (np.linalg.norm(told[:, None] - told, axis=2) < NEAR) @ np.tile(length, 2)
    centre = told[votes.argmax()]
    points = np.stack([ground[:, 0], middle, ground[:, 1]], axis=1)
    for _ in range(STEPS):
        on = (np.abs(np.linalg.norm(points - centre, axis=2) - radius) < ASIDE).all(axis=1)
        if on.sum() < LEAST_PIECES:
            return none
        outward = middle[on] - centre
        distance = np.linalg.norm(outward, axis=1)
        outward = outward / distance[:, None]
        weighted = outward * length[on, None]
        information = weighted.T @ outward
        if np.linalg.cond(information) > WORST:
            return none
        centre = centre + np.linalg.solve(information, weighted.T @ (distance - radius))
    return np.asarray(centre + view.offset)[None]
