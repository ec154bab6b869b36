"""What lesson 11 adds to the student's robot: their own SLAM by their own eyes, and a board of error and honesty."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import pairwise

import numpy as np

from nao_course.exercises.earlier import EarlierNotUsable
from nao_course.geometry import wrap_angle
from nao_course.lessons.slam_on_the_field.system.observation import POST_SIGMA, Observation, observation
from nao_course.metrics import squared_distances
from nao_course.plotting.drawing import say_count
from nao_course.sim import SimulatedNao, Truth
from nao_course.slam import Estimate, Measurement, Motion, measured_points
from nao_course.widgets.attempts import StudentCode
from nao_course.widgets.control_panel.pipeline import Look, Overlay, Sight, Stage


def _follow(student: StudentCode, nao: SimulatedNao) -> Look:
    """Begin where the robot stands, which it knows; follow the commands, and take each picture in once."""
    truth = Truth(nao)
    slam = student.EkfSlam(truth.odometry_start, nao.odometry_noise)
    done, board = 0, Board()

    def look(sight: Sight) -> Overlay:
        nonlocal done
        path = nao.odometry_path
        for before, after in pairwise(path[done:]):
            step = before.inverse() @ after
            slam.move(Motion(step.x, step.theta))
        done = len(path) - 1
        seen, whose = _seen(student, nao, sight)
        slam.observe(seen)
        estimate = slam.estimate()
        if not isinstance(estimate, Estimate):
            raise TypeError(f"estimate() must return an Estimate, got {type(estimate).__name__}")
        return Overlay(
            result=estimate,
            points=measured_points(seen, type(truth.pose)()),
            text=f"{board.after(estimate, truth)}; {say_count(len(estimate.landmarks), 'landmark')} on the map; "
            f"{say_count(len(seen), 'measurement')} by {whose}",
            estimate=estimate,
        )

    return look


def _seen(student: StudentCode, nao: SimulatedNao, sight: Sight) -> tuple[Observation, str]:
    """What a picture shows, and who measured it: the student's function, else the simulator."""
    picture, by = sight.picture, "sense()"
    if "measure" in student:
        try:
            seen = _checked(student.measure(picture.pixels, picture.view))
            return observation(seen, post_sigma=POST_SIGMA), "your measure"
        except EarlierNotUsable as lacking:  # measure is written, but what it calls is not
            student.running = ""
            by += f", for {str(lacking).rstrip('.')}"
    return _sensed(nao, picture.camera), by


def _sensed(nao: SimulatedNao, camera: str) -> Observation:
    """What the simulator measures, with its own noise: no tilt moves its bearings and ranges together."""
    seen = nao.sense(camera)
    R = np.zeros((len(seen), 2, len(seen), 2))
    for i, each in enumerate(seen):
        R[i, :, i] = nao.sensor_noise.covariance(each)
    return Observation(seen, R.reshape(2 * len(seen), -1) if seen else np.zeros((0, 0)))


def _checked(found: object) -> list[Measurement]:
    """What `measure` returned, if it is what it must be."""
    if not isinstance(found, Iterable) or isinstance(found, Measurement):
        raise TypeError(f"measure must return a list of Measurement, got {type(found).__name__}")
    seen = list(found)
    if any(not isinstance(each, Measurement) for each in seen):
        raise TypeError("measure must return a list of Measurement")
    return seen


class Board:
    """Error and honesty of all estimates so far."""

    def __init__(self) -> None:
        """Begin with none."""
        self._nees: list[float] = []

    def after(self, estimate: Estimate, truth: Truth) -> str:
        """Say how far an estimate is off, how far it says, and whether that has been honest so far."""
        error = estimate.pose.as_array() - truth.pose.as_array()
        error[2] = wrap_angle(error[2])
        spread = estimate.covariance + np.diag([1e-6, 1e-6, 1e-6])  # the first pose has no doubt at all
        self._nees.append(float(squared_distances(error[None], spread[None])[0]))
        stated = float(np.sqrt(max(np.trace(estimate.covariance[:2, :2]), 0.0)))
        return (
            f"off {100 * np.hypot(*error[:2]):.0f} cm, states {100 * stated:.0f} cm, "
            f"NEES {self._nees[-1]:.1f}, median {np.median(self._nees):.1f} (honest: 2.4)"
        )


STAGE = Stage(
    name="the estimate",
    lesson="11_slam_on_the_field",
    uses=("EkfSlam",),
    helped_by=("measure",),
    wire=_follow,
    estimates=True,
)
