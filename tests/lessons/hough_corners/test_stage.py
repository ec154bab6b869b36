"""What lesson 03 adds to the robot: corners in the live picture, from the student's own labels."""

import numpy as np

from nao_course.exercises import load_definitions
from nao_course.geometry import Pose
from nao_course.lessons.hough_corners.stage import STAGE
from nao_course.lessons.hsl_filtering.stage import STAGE as LABELS_STAGE
from nao_course.metrics import CornerTruth
from nao_course.sim import Field, SimulatedNao, Truth
from nao_course.widgets.control_panel import Pipeline
from tests.paths import PROJECT

OWN = {
    **load_definitions(PROJECT / "solutions" / "01_hsl_filtering.ipynb"),
    **load_definitions(PROJECT / "solutions" / "03_hough_corners.ipynb"),
}


def looked(functions, pose=Pose(1.3, -0.4, -0.6)):
    nao = SimulatedNao(Field(2012), pose, rng=41)
    return nao, Pipeline([LABELS_STAGE, STAGE], functions, nao, time_limit=60.0).process(
        nao.take_picture("bottom")
    )


def test_what_is_marked_is_a_corner_of_the_lines():
    nao, seen = looked(OWN)
    found = seen.overlays["corners"]
    match = CornerTruth.of(Truth(nao).picture).match(found.pixels)
    assert match.hits == len(found.pixels) == 1 and match.false == 0
    assert found.text == "1 corner" and np.array_equal(found.result, found.pixels)


def test_a_picture_without_corners_has_none():
    _, seen = looked(OWN, Pose(1.5, 0.0, np.pi))
    assert seen.overlays["corners"].text == "0 corners"
