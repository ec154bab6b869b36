"""The centre circle in a picture, found from the short line segments into which a line detector splits its arc."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from nao_course.field_slam.lines import to_ground
from nao_course.field_slam.observation import tilt_jacobian
from nao_course.geometry import FloatArray
from nao_course.sim import CameraView, Field

RADIUS = Field(2012).dimensions.circle_diameter / 2  # m, by the rules
SEGMENT_LENGTH = (0.06, 0.6)  # m on the ground; a chord of 0.6 m is already 8 cm away from its arc
FARTHEST = 3.5  # m, from the robot to a segment's midpoint
ON_CIRCLE = 0.06  # m, largest distance of a segment's points from the circle: about the width of a line
SAME_CENTRE = 0.15  # m: suggested centres that are nearer to each other count as votes for the same circle
# Two distances always determine a centre, whatever the segments belong to, so a third one has to confirm it.
LEAST_SEGMENTS = 3
STEPS = 5  # Gauss-Newton steps
WORST_CONDITION = (
    60.0  # of the normal equations: segments side by side do not determine the distance of the centre
)


class Circle(NamedTuple):
    """A circle with centre (x, y) in the robot frame, m, and its Jacobian (2, 2) for pitch and roll, m / rad.

    The errors of pitch and roll count as positive if the assumed tilt is too small.
    """

    centre: FloatArray
    tilt_jacobian: FloatArray


def find_circle(lines: npt.ArrayLike, view: CameraView, radius: float = RADIUS) -> Circle | None:
    """Find the centre circle, whose radius is known from the rules.

    Each segment suggests two possible centres, one on either side. The place with the most votes, weighted by length,
    is then refined by Gauss-Newton steps, which minimise the distances of the segments from the circle. Lines (N, 4)
    are as returned by `read_lines`, px; the view is corrected by the body tilt; the radius is in m, and 0 if the field
    has no circle. Return None if fewer than three segments agree, or if they do not determine the centre well enough.
    """
    ground = to_ground(np.asarray(lines, dtype=float).reshape(-1, 2), view).reshape(-1, 2, 2) + view.offset
    along, midpoint = ground[:, 1] - ground[:, 0], ground.mean(axis=1)
    length = np.hypot(*along.T)
    with np.errstate(invalid="ignore"):  # points at the horizon have no position on the ground
        kept = (length > SEGMENT_LENGTH[0]) & (length < SEGMENT_LENGTH[1])
        kept &= np.hypot(*midpoint.T) < FARTHEST
    ground, along, midpoint, length = ground[kept], along[kept], midpoint[kept], length[kept]
    if len(length) < LEAST_SEGMENTS or not radius:
        return None
    left = np.column_stack([-along[:, 1], along[:, 0]]) / length[:, None]
    to_centre = np.sqrt(np.maximum(radius**2 - (length / 2) ** 2, 0.0))[:, None] * left
    centres, weight = np.vstack([midpoint + to_centre, midpoint - to_centre]), np.tile(length, 2)
    near = np.linalg.norm(centres[:, None] - centres, axis=2) < SAME_CENTRE
    winner = near[(near @ weight).argmax()]
    centre = np.average(centres[winner], axis=0, weights=weight[winner])
    points = np.stack([ground[:, 0], midpoint, ground[:, 1]], axis=1)
    for _ in range(STEPS):
        on_circle = (np.abs(np.linalg.norm(points - centre, axis=2) - radius) < ON_CIRCLE).all(axis=1)
        if on_circle.sum() < LEAST_SEGMENTS:
            return None
        outward = midpoint[on_circle] - centre
        distance = np.linalg.norm(outward, axis=1)
        outward = outward / distance[:, None]
        weighted = outward * length[on_circle, None]
        information = weighted.T @ outward
        if np.linalg.cond(information) > WORST_CONDITION:
            return None
        centre = centre + np.linalg.solve(information, weighted.T @ (distance - radius))
    x, y = midpoint[on_circle].T
    polar = np.column_stack([np.arctan2(y, x), np.hypot(x, y)])
    # The tilt changes the range of a segment; only the part of that change that points outward moves the centre.
    outward_share = (outward * midpoint[on_circle]).sum(axis=1) / polar[:, 1]
    J = outward_share[:, None] * tilt_jacobian(polar).reshape(-1, 2, 2)[:, 1]
    return Circle(centre, np.linalg.solve(information, weighted.T @ J))
