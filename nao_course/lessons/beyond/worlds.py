"""Drives over the half field with known data association: commands, measurements and true poses."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from nao_course.field_slam.drives import OdometryNoisePerMove
from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.sim import Field, SensorNoise
from nao_course.sim.drives import FieldOfView, Step, measure_in_view
from nao_course.slam import Motion

FIELD = Field(2012)
LANDMARKS, KINDS = FIELD.detectable_positions, FIELD.detectable_kinds
NEAREST = 0.4  # m: closer landmarks are not measured
SENSOR = SensorNoise()
ODOMETRY = OdometryNoisePerMove()


AHEAD = FieldOfView(float(np.radians(30.0)), 3.0, NEAREST)  # one picture, 61 degrees wide
AROUND = FieldOfView(float(np.radians(60.0)), 2.5, NEAREST)  # two pictures side by side


Chooser = Callable[[], Motion]


def drive(
    start: Pose, choose: Chooser, moves: int, rng: np.random.Generator, view: FieldOfView = AROUND
) -> Iterator[Step]:
    """Drive and measure after each move; each command is requested only when it is needed.

    The true start is in the field frame, and the first step is at the start, before a move.
    """
    pose = start.as_array()
    for number in range(moves + 1):
        motion = choose() if number else None
        if motion is not None:
            pose = moved(pose, motion, rng.standard_normal(3))
        numbers, seen = measure_in_view(pose, LANDMARKS, SENSOR, view, rng)
        covariance = ODOMETRY.covariance(motion) if motion else np.zeros((3, 3))
        yield Step(pose, motion, covariance, numbers, seen, SENSOR.covariances(seen))


def moved(poses: FloatArray, motion: Motion, draws: FloatArray) -> FloatArray:
    """Move poses (..., 3) by a command, with errors scaled from standard normal draws (..., 3)."""
    errors = draws * np.sqrt(np.diag(ODOMETRY.covariance(motion)))
    poses = np.array(poses, dtype=float)
    along, across = motion.distance + errors[..., 0], errors[..., 1]
    cos, sin = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    poses[..., 0] += cos * along - sin * across
    poses[..., 1] += sin * along + cos * across
    poses[..., 2] = wrap_angle(poses[..., 2] + motion.turn + errors[..., 2])
    return poses
