"""A real robot's walk as a drive: its pictures, and its true steps with the noise of odometry."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache

import numpy as np
import numpy.typing as npt

from nao_course.datasets import PointKind, RealPicture
from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.slam_on_the_field.system.drives import FieldOdometry
from nao_course.sim import NAO_V4, CameraView, Field
from nao_course.slam import Motion

# How the real pictures are read (docs/real_data.md). The camera looks lower than its joints say: by what the points
# marked in the walk's first picture tell, which is taken at the start that the robot knows. The first pictures were
# taken one stop farther back than was written down.
PITCH_OFFSET = float(np.radians(6.9))
BEFORE_THE_GAP, STOP = 7, 0.2  # pictures, m
FIELD = Field(2012, half=False)
FARTHEST = 9.0  # m: the goal is seen from one end of the field to the other
TRIED = np.radians(np.arange(-8.0, 8.1, 0.25))  # headings beside the written one: a robot is put down by hand
LOST = 20.0  # px: a marked point that is farther from every landmark is of none


@dataclass(frozen=True, eq=False)
class Sight:
    """A picture and what a robot knows of it; the pose is for the score alone.

    Parameters
    ----------
    motion : Motion or None
        The command, or step, before it; None where only the head was turned.
    pixels : ndarray of uint8, shape (H, W, 3)
        RGB.
    view : CameraView
        As the robot believes.
    pose : Pose
        The true one, in the field's frame.
    farthest : float
        What seems farther away is not taken for a measurement, m.
    """

    motion: Motion | None
    pixels: npt.NDArray[np.uint8]
    view: CameraView
    pose: Pose
    farthest: float = 6.0


def real_walk(pictures: Sequence[RealPicture], seed: int, marked_headings: bool = True) -> Iterator[Sight]:
    """Walk along real pictures; the odometry is the true steps with errors of `FieldOdometry`.

    Parameters
    ----------
    pictures : sequence of RealPicture
        As `read_pictures` gives a walk.
    seed : int
        Of the odometry's errors.
    marked_headings : bool
        Whether the robot really looked where the marked points say, or along the field as was written down.

    Yields
    ------
    Sight
        One for each picture.
    """
    rng, odometry = np.random.default_rng([seed, 31]), FieldOdometry()
    before: Pose | None = None
    for number, picture in enumerate(pictures):
        back = STOP if number < BEFORE_THE_GAP else 0.0
        pose, view = replace(picture.pose, x=picture.pose.x - back), walk_view(picture)
        if marked_headings:
            pose = replace(pose, theta=marked_heading(picture, view, pose))
        yield Sight(_step(before, pose, odometry, rng), picture.pixels, view, pose, FARTHEST)
        before = pose


def walk_view(picture: RealPicture) -> CameraView:
    """What a robot believes of its camera that knows its constant offset."""
    view = NAO_V4.view("bottom", picture.head_yaw, picture.head_pitch)
    return replace(view, pitch=view.pitch + PITCH_OFFSET)


@lru_cache(maxsize=128)
def marked_heading(picture: RealPicture, view: CameraView, pose: Pose) -> float:
    """Where a robot looked, by the points that are marked in its picture; as written where there are none.

    Parameters
    ----------
    picture : RealPicture
        With its points.
    view : CameraView
        Of its camera.
    pose : Pose
        As it was written down.

    Returns
    -------
    float
        Rad, in the field's frame.
    """
    if not any(_landmarks(point.kind) for point in picture.points):
        return pose.theta
    tried = [_misses(picture, view, replace(pose, theta=pose.theta + turn)) for turn in TRIED]
    costs = [np.minimum(np.hypot(*misses.T), LOST).sum() for misses in tried]
    best = int(np.argmin(costs))
    right = float(np.median(tried[best][:, 0]))
    return float(
        pose.theta + TRIED[best] - right / view.focal[0]
    )  # a turn to the left moves all to the right


def _misses(picture: RealPicture, view: CameraView, pose: Pose) -> FloatArray:
    """From each marked point on the ground to the nearest landmark of its kind, (N, 2) px."""
    found = []
    for point in picture.points:
        if places := _landmarks(point.kind):
            away = np.nan_to_num(view.project(places, pose) - (point.u, point.v), nan=1e6)
            found.append(away[np.hypot(*away.T).argmin()])
    return np.array(found)


@cache
def _landmarks(kind: PointKind) -> list[tuple[float, float]]:
    """Where the field has what is marked as this kind, m; nothing for what is not on the ground."""
    shape = "post" if kind == "post_foot" else kind
    return [(mark.x, mark.y) for mark in FIELD.landmarks if mark.shape == shape]


def _step(
    before: Pose | None, pose: Pose, odometry: FieldOdometry, rng: np.random.Generator
) -> Motion | None:
    """What odometry says of a step: as far and as much of a turn as it was, with errors."""
    if before is None:
        return None
    step = before.inverse() @ pose
    true = Motion(step.x, step.theta)
    errors = rng.standard_normal(3) * np.sqrt(np.diag(odometry.covariance(true)))
    return Motion(true.distance + errors[0], true.turn + errors[2])
