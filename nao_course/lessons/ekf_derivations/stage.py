"""What lesson 05 adds to the student's robot: a pose predicted from the commands alone, and its growing ellipse."""

from __future__ import annotations

import numpy as np

from nao_course.geometry import Pose, wrap_angle
from nao_course.robot import Robot
from nao_course.slam import Estimate
from nao_course.widgets.attempts import StudentCode
from nao_course.widgets.control_panel.named_landmarks import new_commands, start_of
from nao_course.widgets.control_panel.pipeline import Frame, Overlay, Stage, StageFunction


def _predict(student: StudentCode, nao: Robot) -> StageFunction:
    """Predict pose and covariance from each command, beginning where the robot was put."""
    pose, covariance, done = start_of(nao).as_array(), np.zeros((3, 3)), 0

    def look(frame: Frame) -> Overlay:
        nonlocal pose, covariance, done
        now, uncertainty, commands = pose, covariance, new_commands(nao, done)
        for control, noise in commands:
            uncertainty = _shaped(student.predict_covariance(uncertainty, now, control, noise), (3, 3))
            now = _shaped(student.predict_pose(now, control), (3,))
            now[2] = wrap_angle(now[2])
        pose, covariance, done = now, uncertainty, done + len(commands)
        sigma = np.sqrt(covariance[0, 0] + covariance[1, 1]), np.degrees(np.sqrt(covariance[2, 2]))
        return Overlay(
            result=(pose, covariance),
            text=f"standard deviation {sigma[0]:.2f} m and {sigma[1]:.0f}°",
            estimate=Estimate(Pose.from_array(pose), covariance, np.empty((0, 2)), np.empty((0, 2, 2))),
        )

    return look


def _shaped(value: object, shape: tuple[int, ...]) -> np.ndarray:
    """Return an answer as an array, or raise ValueError if it has another shape."""
    array = np.array(value, dtype=float)
    if array.shape != shape:
        raise ValueError(f"the answer has shape {array.shape}; its shape should be {shape}")
    return array


STAGE = Stage(
    name="dead reckoning",
    lesson="05_ekf_derivations",
    uses=("predict_pose", "predict_covariance"),
    wire=_predict,
    estimates=True,
)
