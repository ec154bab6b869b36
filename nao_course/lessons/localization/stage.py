"""What lesson 06 adds to the student's robot: where it is on the field that it knows, by the student's own filter."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.lessons.localization.drives import REACH, checked
from nao_course.plotting.drawing import say_count
from nao_course.sim import SimulatedNao, Truth, VisibleLandmark, visible_landmarks
from nao_course.slam import Estimate, Measurement, Motion
from nao_course.widgets.attempts import StudentCode
from nao_course.widgets.control_panel.pipeline import Look, Overlay, Sight, Stage

PUT_DOWN = np.array([-0.4, 0.3, np.radians(12)])  # m, m, rad: by how much the robot is wrong at first
DOUBT = np.diag([0.4**2, 0.4**2, np.radians(15) ** 2])
SEED = 61  # of the measurements' noise


def _localise(student: StudentCode, nao: SimulatedNao) -> Look:
    """Follow the robot from a wrong start: its commands, and the known landmarks in each picture."""
    truth, rng = Truth(nao), np.random.default_rng(SEED)
    pose, covariance, done = truth.odometry_start.as_array() + PUT_DOWN, DOUBT, 0

    def look(sight: Sight) -> Overlay:
        nonlocal pose, covariance, done
        now, spread = pose, covariance
        path = nao.odometry_path
        for before, after in pairwise(path[done:]):
            now, spread = _predicted(student, nao, now, spread, before.inverse() @ after)
        seen = [
            mark
            for mark in visible_landmarks(nao.field, truth.pose, sight.picture.view)
            if mark.landmark.kind != "cross" and not mark.occluded and mark.distance <= REACH
        ]
        for mark in seen:
            now, spread = _updated(student, nao, now, spread, mark, rng)
        pose, covariance, done = now, spread, len(path) - 1
        return Overlay(
            result=(now, spread),
            pixels=[mark.pixel for mark in seen],
            text=f"{say_count(len(seen), 'landmark')}, sure to {np.sqrt(spread[0, 0] + spread[1, 1]):.2f} m and "
            f"{np.degrees(np.sqrt(spread[2, 2])):.0f}°",
            estimate=Estimate(Pose.from_array(now), spread, np.empty((0, 2)), np.empty((0, 2, 2))),
        )

    return look


def _predicted(
    student: StudentCode, nao: SimulatedNao, pose: FloatArray, covariance: FloatArray, moved: Pose
) -> tuple[FloatArray, FloatArray]:
    """The belief after a command."""
    control = np.array([moved.x, moved.theta])
    noise = nao.odometry_noise.covariance(Motion(moved.x, moved.theta))
    spread = checked(
        student.predict_covariance(covariance, pose, control, noise), (3, 3), "predict_covariance"
    )
    moved_pose = checked(student.predict_pose(pose, control), (3,), "predict_pose")
    moved_pose[2] = wrap_angle(moved_pose[2])
    return moved_pose, spread


def _updated(
    student: StudentCode,
    nao: SimulatedNao,
    pose: FloatArray,
    covariance: FloatArray,
    mark: VisibleLandmark,
    rng: np.random.Generator,
) -> tuple[FloatArray, FloatArray]:
    """The belief after a landmark, which the simulator measures and names."""
    noise = nao.sensor_noise
    bearing = mark.bearing + noise.bearing * rng.standard_normal()
    distance = mark.distance * (1 + noise.range_fraction * rng.standard_normal())
    measured = Measurement(float(bearing), max(float(distance), 0.05))
    place = nao.field.pose.to_parent([mark.landmark.x, mark.landmark.y])[0]
    answer = student.localize(
        pose, covariance, np.array([measured.bearing, measured.range]), place, noise.covariance(measured)
    )
    if not isinstance(answer, tuple | list) or len(answer) != 2:
        raise ValueError("localize must return (pose, covariance)")
    return checked(answer[0], (3,), "localize: pose"), checked(answer[1], (3, 3), "localize: covariance")


STAGE = Stage(
    name="pose",
    lesson="06_localization",
    uses=("localize", "05:predict_pose", "05:predict_covariance"),
    wire=_localise,
    estimates=True,
)
