"""What lesson 02 adds to the student's robot: the feet of goal posts in each picture, live."""

from __future__ import annotations

import numpy as np

from nao_course.geometry import as_points
from nao_course.plotting.drawing import say_count
from nao_course.sim import SimulatedNao
from nao_course.widgets.attempts import StudentCode
from nao_course.widgets.control_panel.pipeline import Look, Overlay, Sight, Stage


def _mark_feet(student: StudentCode, nao: SimulatedNao) -> Look:
    """Find the posts in the student's labels of each picture."""

    def look(sight: Sight) -> Overlay:
        feet = as_points(student.find_goalposts(np.asarray(sight.results["labels"])), name="feet (u, v)")
        return Overlay(feet, pixels=feet, text=say_count(len(feet), "goal post"))

    return look


STAGE = Stage(
    name="goal posts",
    lesson="02_goalposts",
    uses=("find_goalposts",),
    wire=_mark_feet,
    after=("labels",),
)
