"""Show the student's corners in the live picture of the control panel."""

from __future__ import annotations

import numpy as np

from nao_course._internal.counts import say_count
from nao_course.geometry import as_points
from nao_course.robot import Robot
from nao_course.widgets.attempts import StudentCode
from nao_course.widgets.control_panel.pipeline import Frame, Overlay, Stage, StageFunction


def _mark_corners(student: StudentCode, nao: Robot) -> StageFunction:
    """Return a function that finds corners in the labels of each frame."""

    def look(frame: Frame) -> Overlay:
        corners = as_points(student.find_corners(np.asarray(frame.results["labels"])), name="corners (u, v)")
        return Overlay(corners, pixels=corners, text=say_count(len(corners), "corner"))

    return look


STAGE = Stage(
    name="corners", lesson="03_hough_corners", uses=("find_corners",), wire=_mark_corners, after=("labels",)
)
