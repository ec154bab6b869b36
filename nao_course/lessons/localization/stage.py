"""What lesson 06 adds to the student's robot: its estimated pose on a known field, by the student's own filter."""

from __future__ import annotations

import numpy as np

from nao_course._internal.counts import say_count
from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.localization.drives import REACH, LandmarkMeasurement, predicted, updated
from nao_course.sim import SimulatedNao, Truth
from nao_course.slam import Estimate
from nao_course.widgets.attempts import StudentCode
from nao_course.widgets.control_panel.named_landmarks import measure_by_name, new_commands
from nao_course.widgets.control_panel.pipeline import Frame, Overlay, Stage, StageFunction

START_ERROR = np.array([-0.4, 0.3, np.radians(12)])  # m, m, rad: estimated minus true pose at the start
START_COVARIANCE = np.diag([0.4**2, 0.4**2, np.radians(15) ** 2])
SEED = 61  # of the measurements' noise


def _localise(student: StudentCode, nao: SimulatedNao) -> StageFunction:
    """Follow the robot from a wrong estimate; the first picture shows that estimate, the next ones correct it."""
    truth, rng = Truth(nao), np.random.default_rng(SEED)
    places = nao.field.pose.to_parent(nao.field.detectable_positions)
    pose, covariance, done = truth.odometry_start.as_array() + START_ERROR, START_COVARIANCE, 0
    begun = False

    def look(frame: Frame) -> Overlay:
        nonlocal pose, covariance, done, begun
        if not begun and len(nao.odometry_path) == 1:
            begun = True
            return _overlay(pose, covariance, "the estimate at the start; the next picture corrects it")
        now, now_covariance, commands = pose, covariance, new_commands(nao, done)
        for command in commands:
            now, now_covariance = predicted(
                student.predict_pose, student.predict_covariance, now, now_covariance, *command
            )
        seen = measure_by_name(nao, frame.picture.view, REACH, rng)
        for place, *measured in zip(places[seen.numbers], seen.measurements, seen.covariances, strict=True):
            now, now_covariance = updated(
                student.localize, now, now_covariance, LandmarkMeasurement(place, *measured)
            )
        pose, covariance, done = now, now_covariance, done + len(commands)
        return _overlay(now, now_covariance, say_count(len(seen.numbers), "landmark"), seen.pixels)

    return look


def _overlay(
    pose: FloatArray, covariance: FloatArray, text: str, pixels: list[tuple[float, float]] | None = None
) -> Overlay:
    """Return an overlay with the estimate on the map and its standard deviations in words."""
    position, heading = np.sqrt(covariance[0, 0] + covariance[1, 1]), np.degrees(np.sqrt(covariance[2, 2]))
    return Overlay(
        result=(pose, covariance),
        pixels=np.array(pixels or []).reshape(-1, 2),
        text=f"{text}, σ {position:.2f} m and {heading:.0f}°",
        estimate=Estimate(Pose.from_array(pose), covariance, np.empty((0, 2)), np.empty((0, 2, 2))),
    )


STAGE = Stage(
    name="pose",
    lesson="06_localization",
    uses=("localize", "05:predict_pose", "05:predict_covariance"),
    wire=_localise,
    estimates=True,
    simulated=True,
)
