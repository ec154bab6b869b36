"""The contents of a map at one time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from nao_course.geometry import FloatArray, Pose
from nao_course.slam import Estimate, Measurement

_NO_POINTS = np.empty((0, 2))


@dataclass(frozen=True)
class ShortAxis:
    """An axis of an estimate's 95 % ellipse that is too small for the error, or a heading that is too certain.

    Parameters
    ----------
    name : str
        Which axis it is: "across the heading".
    direction : float
        Direction of the axis in the world, toward the true position; of a heading, the estimated heading. rad
    claimed : float
        Half axis of the ellipse, m, or half of the 95 % interval of the heading, rad.
    error : float
        Error along the axis, m; of a heading, the true minus the estimated one, rad.
    is_heading : bool
        Whether it is the heading.
    """

    name: str
    direction: float
    claimed: float
    error: float
    is_heading: bool = False


@dataclass(frozen=True)
class MapContents:
    """The contents of a map at one time.

    Parameters
    ----------
    paths : mapping of str to sequence of Pose
        Paths in world coordinates, by source. The robot is drawn at the last pose.
    estimate : Estimate or None
        Estimate in world coordinates; its landmarks and ellipses are drawn.
    seen : sequence of Measurement
        Measurements, drawn from the robot of `observer`.
    observer : str
        Source whose robot measured.
    points : ndarray, shape (N, 2)
        Points that the student's code found, in the frame of that robot, m.
    cells : ndarray, shape (N, 2)
        Centres of grid cells in world coordinates, m, for example frontiers. A `VectorMap` draws them under everything.
    view : (float, float, float) or None
        Direction and half of the opening angle of the camera's view, in the frame of that robot, rad, and its reach, m,
        which may be infinite. A `VectorMap` draws it as a cone.
    short : ShortAxis or None
        The axis of the estimate that is too small. A `VectorMap` draws it with the error beside it.
    """

    paths: Mapping[str, Sequence[Pose]]
    estimate: Estimate | None = None
    seen: Sequence[Measurement] = ()
    observer: str = "odometry"
    points: FloatArray = field(default_factory=lambda: _NO_POINTS)
    cells: FloatArray = field(default_factory=lambda: _NO_POINTS)
    view: tuple[float, float, float] | None = None
    short: ShortAxis | None = None

    @property
    def observer_pose(self) -> Pose:
        """Pose of the robot that measured; the origin if it has no path."""
        return (self.paths.get(self.observer) or [Pose()])[-1]
