"""What lesson 03 adds to the student's robot: corners of the field's lines in each picture, live."""

from __future__ import annotations

import numpy as np

from nao_course.geometry import as_points
from nao_course.plotting.drawing import say_count
from nao_course.sim import SimulatedNao
from nao_course.widgets.attempts import StudentCode
from nao_course.widgets.control_panel.pipeline import Look, Overlay, Sight, Stage


def _mark_corners(student: StudentCode, nao: SimulatedNao) -> Look:
    """Find the corners in the student's labels of each picture."""

    def look(sight: Sight) -> Overlay:
        corners = as_points(student.find_corners(np.asarray(sight.results["labels"])), name="corners (u, v)")
        return Overlay(corners, pixels=corners, text=say_count(len(corners), "corner"))

    return look


STAGE = Stage(
    name="corners",
    lesson="03_hough_corners",
    uses=("find_corners",),
    wire=_mark_corners,
    after=("labels",),
)
