"""The stage of lesson 11 for the student's robot: their SLAM on their measurements, with a board of error and NEES."""

from __future__ import annotations

import numpy as np

from nao_course._internal.counts import say_count
from nao_course.exercises.earlier import EarlierNotUsable
from nao_course.field_slam.observation import Observation
from nao_course.geometry import Pose, pose_errors
from nao_course.lessons.slam_on_the_field.worlds import observe
from nao_course.metrics import squared_distances
from nao_course.robot import Robot
from nao_course.sim import SimulatedNao, Truth
from nao_course.slam import Estimate, measured_points
from nao_course.widgets.attempts import StudentCode
from nao_course.widgets.control_panel.named_landmarks import new_motions, start_of
from nao_course.widgets.control_panel.pipeline import Frame, Overlay, Stage, StageFunction

SEED = 111  # of the measurements' noise, where the simulator makes them


def _follow(student: StudentCode, nao: Robot) -> StageFunction:
    """Start at the robot's known pose, follow the commands, and update with each picture once."""
    truth = Truth(nao) if isinstance(nao, SimulatedNao) else None
    slam = student.EkfSlam(start_of(nao), nao.odometry_noise)
    done, board, rng = 0, Board(), np.random.default_rng(SEED)

    def look(frame: Frame) -> Overlay:
        nonlocal done
        motions = new_motions(nao, done)
        for motion in motions:
            slam.move(motion)
        done += len(motions)
        with nao.aside(rng):  # measuring must not change how the robot slips next
            seen, whose = _seen(student, nao, frame)
        slam.observe(seen)
        estimate = slam.estimate()
        if not isinstance(estimate, Estimate):
            raise TypeError(f"estimate() must return an Estimate, got {type(estimate).__name__}")
        return Overlay(
            result=estimate,
            points=measured_points(seen, Pose()),
            text=f"{board.after(estimate, truth)}; {say_count(len(estimate.landmarks), 'landmark')} on the map; "
            f"{say_count(len(seen), 'measurement')} by {whose}",
            estimate=estimate,
        )

    return look


def _seen(student: StudentCode, nao: Robot, frame: Frame) -> tuple[Observation, str]:
    """Return a picture's measurements, and who made them: the student's function, or else the simulator."""
    picture, by = frame.picture, "sense()"
    if "measure" in student:
        try:
            return observe(student.measure, picture.pixels, picture.view), "your measure"
        except EarlierNotUsable as lacking:  # `measure` is written, but a function that it calls is not
            student.running = ""
            by += f", for {str(lacking).rstrip('.')}"
    if not isinstance(nao, SimulatedNao):
        raise ValueError("a real robot is measured by your measure of lesson 11, which is not ready")
    return _sensed(nao, picture.camera), by


def _sensed(nao: SimulatedNao, camera: str) -> Observation:
    """Return the simulator's measurements with its own noise, in which no tilt is shared."""
    seen = nao.sense(camera)
    R = np.zeros((len(seen), 2, len(seen), 2))
    for i, each in enumerate(seen):
        R[i, :, i] = nao.sensor_noise.covariance(each)
    return Observation(seen, R.reshape(2 * len(seen), -1) if seen else np.zeros((0, 0)))


class Board:
    """Error and NEES of all estimates so far."""

    def __init__(self) -> None:
        """Start without estimates."""
        self._nees: list[float] = []

    def after(self, estimate: Estimate, truth: Truth | None) -> str:
        """Return an estimate's stated standard deviation as text, and where the truth is known its error and NEES."""
        stated = f"states {100 * np.sqrt(max(np.trace(estimate.covariance[:2, :2]), 0.0)):.0f} cm"
        if truth is None:
            return stated
        error = pose_errors(estimate.pose.as_array(), truth.pose.as_array())
        covariance = estimate.covariance + np.diag([1e-6, 1e-6, 1e-6])  # the first pose is known exactly
        self._nees.append(float(squared_distances(error[None], covariance[None])[0]))
        return (
            f"off {100 * np.hypot(*error[:2]):.0f} cm, {stated}, "
            f"NEES {self._nees[-1]:.1f}, median {np.median(self._nees):.1f} (consistent: 2.4)"
        )


STAGE = Stage(
    name="estimate",
    lesson="11_slam_on_the_field",
    uses=("EkfSlam",),
    helped_by=("measure",),
    wire=_follow,
    estimates=True,
)
