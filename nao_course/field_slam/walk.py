"""The walk of a real robot as a drive: its pictures, and its true steps with simulated errors of odometry."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache

import numpy as np
import numpy.typing as npt

from nao_course.datasets import PointKind, RealPicture
from nao_course.datasets.pictures import shape_on_ground
from nao_course.field_slam.drives import OdometryNoisePerMove
from nao_course.geometry import FloatArray, Pose
from nao_course.sim import NAO_V4, CameraView, Field
from nao_course.slam import Motion

# The recordings have two known errors (docs/real_data.md). The camera looks lower than its joints report: this offset
# follows from the marked points of the walk's first picture, and only the true headings are computed with it. The first
# pictures were taken one stop farther back than was written down.
PITCH_OFFSET = float(np.radians(6.9))
BEFORE_THE_GAP, STOP = 7, 0.2  # number of these first pictures; distance between two stops, m
FIELD = Field(2012, half=False)
FARTHEST = 9.0  # m: the robot can see the goal from the other end of the field
# Differences from the written heading that are tried, because the robot was put down by hand; rad.
TURNS = np.radians(np.arange(-8.0, 8.1, 0.25))
OUTLIER = (
    20.0  # px: largest cost of a marked point, because a point that is farther off shows no known landmark
)


@dataclass(frozen=True, eq=False)
class WalkFrame:
    """A picture with the motion before it and the assumed view of the camera; the true pose serves for scores only.

    The motion is commanded or measured by odometry, and None if the robot only turned its head; a robot that moved
    several times since the picture before has `earlier` motions, too. The pixels (H, W, 3)
    are RGB, the pose is in the field frame, and `farthest` is the largest range of a measurement that is used, m. A
    view that is not `calibrated` has a constant offset in addition to the body's sway. Where the truth is not `known`,
    the pose is odometry's. Before the picture, the robot may have been `carried` away.
    """

    motion: Motion | None
    pixels: npt.NDArray[np.uint8]
    view: CameraView
    pose: Pose
    farthest: float = 6.0
    calibrated: bool = True
    known: bool = True
    earlier: tuple[Motion, ...] = ()
    carried: bool = False


def real_walk(
    pictures: Sequence[RealPicture], seed: int, marked_headings: bool = True
) -> Iterator[WalkFrame]:
    """Yield the pictures of a real walk; the odometry is the true steps with errors of `OdometryNoisePerMove`.

    The views follow from the head's joints and are not calibrated. With `marked_headings`, the true headings are
    computed from the marked points; otherwise they are those written down.
    """
    rng, odometry = np.random.default_rng([seed, 31]), OdometryNoisePerMove()
    before: Pose | None = None
    for number, picture in enumerate(pictures):
        back = STOP if number < BEFORE_THE_GAP else 0.0
        pose, view = replace(picture.pose, x=picture.pose.x - back), walk_view(picture)
        if marked_headings:
            lower = replace(view, pitch=view.pitch + PITCH_OFFSET)
            pose = replace(pose, theta=marked_heading(picture, lower, pose))
        yield WalkFrame(
            _step(before, pose, odometry, rng), picture.pixels, view, pose, FARTHEST, calibrated=False
        )
        before = pose


def walk_view(picture: RealPicture) -> CameraView:
    """Return the view of the camera that follows from the head's joints."""
    return NAO_V4.view("bottom", picture.head_yaw, picture.head_pitch)


@lru_cache(maxsize=128)
def marked_heading(picture: RealPicture, view: CameraView, pose: Pose) -> float:
    """Return the heading, rad in the field frame, that fits a picture's marked points best, or else the written one.

    The written one is returned if no marked point is usable.
    """
    if not any(_landmarks(point.kind) for point in picture.points):
        return pose.theta
    residuals = [_residuals(picture, view, replace(pose, theta=pose.theta + turn)) for turn in TURNS]
    costs = [np.minimum(np.hypot(*each.T), OUTLIER).sum() for each in residuals]
    best = int(np.argmin(costs))
    right = float(np.median(residuals[best][:, 0]))
    # A turn to the left moves all points in the picture to the right.
    return float(pose.theta + TURNS[best] - right / view.focal[0])


def _residuals(picture: RealPicture, view: CameraView, pose: Pose) -> FloatArray:
    """Return the offset of the nearest landmark of its kind from each marked point on the ground, (N, 2) px."""
    found = []
    for point in picture.points:
        if places := _landmarks(point.kind):
            offset = np.nan_to_num(view.project(places, pose) - (point.u, point.v), nan=1e6)
            found.append(offset[np.hypot(*offset.T).argmin()])
    return np.array(found)


@cache
def _landmarks(kind: PointKind) -> list[tuple[float, float]]:
    """Return the positions of the field's landmarks of this kind, m; an empty list for points above the ground."""
    shape = shape_on_ground(kind)
    return [(mark.x, mark.y) for mark in FIELD.landmarks if mark.shape == shape]


def _step(
    before: Pose | None, pose: Pose, odometry: OdometryNoisePerMove, rng: np.random.Generator
) -> Motion | None:
    """Return the true step between two poses with the errors of odometry; None for the first pose."""
    if before is None:
        return None
    step = before.inverse() @ pose
    true = Motion(step.x, step.theta)
    errors = rng.standard_normal(3) * np.sqrt(np.diag(odometry.covariance(true)))
    return Motion(true.distance + errors[0], true.turn + errors[2])
