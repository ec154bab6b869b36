"""The part of the student's robot that lesson 02 adds: the feet of goal posts in each picture, live."""

from __future__ import annotations

import numpy as np

from nao_course import plotting
from nao_course.colours import GREEN, YELLOW, mean_lightness
from nao_course.geometry import as_points
from nao_course.robot import Robot
from nao_course.widgets.attempts import StudentCode
from nao_course.widgets.control_panel.pipeline import Frame, Overlay, Stage, StageFunction


def _mark_feet(student: StudentCode, nao: Robot) -> StageFunction:
    """Label each picture with the lesson's limits, and find the posts in it."""

    def look(frame: Frame) -> Overlay:
        picture = frame.picture.pixels
        threshold = student.white_threshold(mean_lightness(picture))
        labels = np.asarray(student.color_labels(picture, GREEN, YELLOW, threshold))
        feet = as_points(student.find_goalposts(labels.copy()), name="feet (u, v)")
        return Overlay(feet, plotting.painted(labels), labels > 0, pixels=feet, text=f"{len(feet)} found")

    return look


STAGE = Stage(
    name="goal posts",
    lesson="02_goalposts",
    uses=("01:color_labels", "01:white_threshold", "find_goalposts"),
    wire=_mark_feet,
)
