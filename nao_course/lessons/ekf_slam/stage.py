"""The stage of lesson 07: a map that grows while the robot drives, by the student's own filter."""

from __future__ import annotations

import numpy as np

from nao_course._internal.counts import say_count
from nao_course.geometry import Pose
from nao_course.sim import SimulatedNao, Truth
from nao_course.sim.drives import NamedEkf, checked_functions
from nao_course.slam import place_estimate
from nao_course.widgets.attempts import StudentCode
from nao_course.widgets.control_panel.named_landmarks import FollowedRobot
from nao_course.widgets.control_panel.pipeline import Frame, Overlay, Stage, StageFunction

REACH = 3.5  # m; beyond it a range from one picture is inaccurate (lesson 04)
SEED = 71  # seed of the measurements' noise


def _grow(student: StudentCode, nao: SimulatedNao) -> StageFunction:
    """Start at the origin with an empty map; predict with each command and update with each picture."""
    truth, kinds = Truth(nao), nao.field.detectable_kinds
    functions = checked_functions((student.predict, student.update_landmarks, student.add_landmark))
    robot = FollowedRobot(NamedEkf(Pose(), *functions), nao, REACH, SEED)

    def show(frame: Frame) -> Overlay:
        seen, _ = robot.follow(frame.picture.view)
        estimate = robot.slam.estimate(kinds)
        sigma = np.sqrt(np.trace(estimate.covariance[:2, :2]))
        return Overlay(
            result=estimate,
            pixels=seen.pixels,
            text=f"{say_count(len(estimate.landmarks), 'landmark')} on the map, {len(seen.numbers)} in view; "
            f"standard deviation of the position {sigma:.2f} m",
            estimate=place_estimate(estimate, truth.odometry_start),
        )

    return show


STAGE = Stage(
    name="growing map",
    lesson="07_ekf_slam",
    uses=("predict", "update_landmarks", "add_landmark"),
    wire=_grow,
    estimates=True,
    simulated=True,
)
