"""Where a robot was put, its new commands, and the simulator's measurements with known landmark correspondences."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np

from nao_course.geometry import FloatArray, Pose
from nao_course.robot import PlacedNao, Robot
from nao_course.sim import CameraView, SimulatedNao, Truth, visible_landmarks
from nao_course.sim.drives import NamedEkf
from nao_course.slam import Motion


class NamedMeasurements(NamedTuple):
    """The landmarks in a picture, measured by the simulator.

    `numbers` index the field's `detectable` landmarks; measurements (n, 2) are bearing (rad) and range (m) with
    covariances (n, 2, 2), and `pixels` are (u, v) in the picture.
    """

    numbers: list[int]
    measurements: FloatArray
    covariances: FloatArray
    pixels: list[tuple[float, float]]


def start_of(nao: Robot) -> Pose:
    """Return where a robot's odometry begins in the world: the truth, or what a person says who has put it there."""
    if isinstance(nao, SimulatedNao):
        return Truth(nao).odometry_start
    return nao.start if isinstance(nao, PlacedNao) else nao.field.pose


def new_motions(nao: Robot, done: int) -> list[Motion]:
    """Return the robot's commands after the first `done`."""
    path = nao.odometry_path[done:]
    steps = [before.inverse() @ after for before, after in pairwise(path)]
    return [Motion(step.x, step.theta) for step in steps]


def new_commands(nao: Robot, done: int) -> list[tuple[FloatArray, FloatArray]]:
    """Return the commands (2,) after the first `done`, with the covariances (3, 3) of their errors."""
    return [
        (np.array([motion.distance, motion.turn]), nao.odometry_noise.covariance(motion))
        for motion in new_motions(nao, done)
    ]


def measure_by_name(
    nao: SimulatedNao, view: CameraView, reach: float, rng: np.random.Generator
) -> NamedMeasurements:
    """Measure the visible landmarks within `reach` (m), with the noise of the robot's sensor."""
    marks = nao.field.detectable
    seen = [
        each
        for each in visible_landmarks(nao.field, Truth(nao).pose, view)
        if each.landmark in marks and not each.occluded and each.distance <= reach
    ]
    exact = np.array([(each.bearing, each.distance) for each in seen]).reshape(-1, 2)
    measured = nao.sensor_noise.disturbed(exact, rng.standard_normal(exact.shape))
    numbers = [marks.index(each.landmark) for each in seen]
    return NamedMeasurements(
        numbers, measured, nao.sensor_noise.covariances(measured), [each.pixel for each in seen]
    )


class FollowedRobot:
    """A filter that follows the robot of a panel, with known landmark correspondences.

    `slam` is the filter after the last picture, at first before the first command; landmarks are measured up to
    `reach`, m.
    """

    def __init__(self, slam: NamedEkf, nao: SimulatedNao, reach: float, seed: int) -> None:
        """Start before the robot's first command."""
        self.slam, self._nao, self._reach = slam, nao, reach
        self._rng, self._done = np.random.default_rng(seed), 0

    def follow(self, view: CameraView) -> tuple[NamedMeasurements, float]:
        """Predict with the new commands and update with one picture; if this raises an error, the filter stays.

        Return the measurements of the picture, and the distance of the new commands, m.
        """
        slam, commands = self.slam.copy(), new_commands(self._nao, self._done)
        for command in commands:
            slam.move(*command)
        seen = measure_by_name(self._nao, view, self._reach, self._rng)
        slam.observe(seen.numbers, seen.measurements, seen.covariances)
        self.slam, self._done = slam, self._done + len(commands)
        return seen, sum(abs(float(control[0])) for control, _ in commands)
