"""What lesson 02 adds to the robot: feet of posts in the live picture, from the student's own labels."""

import numpy as np

from nao_course.exercises import load_definitions
from nao_course.geometry import Pose
from nao_course.lessons.goalposts.stage import STAGE
from nao_course.lessons.hsl_filtering.stage import STAGE as LABELS_STAGE
from nao_course.sim import SimulatedNao, Truth
from nao_course.widgets.control_panel import Pipeline
from tests.paths import PROJECT

OWN = {
    **load_definitions(PROJECT / "solutions" / "01_hsl_filtering.ipynb"),
    **load_definitions(PROJECT / "solutions" / "02_goalposts.ipynb"),
}


def looked(functions, pose=Pose(0.6, 0.5, -0.25)):  # noqa: B008 - a pose does not change
    nao = SimulatedNao(pose=pose, rng=41)
    return nao, Pipeline([LABELS_STAGE, STAGE], functions, nao, time_limit=60.0).look(
        nao.take_picture("bottom")
    )


def test_the_feet_in_the_picture_are_those_of_the_posts():
    nao, seen = looked(OWN)
    found = seen.overlays["goal posts"]
    true = [mark.pixel for mark in Truth(nao).picture.landmarks if mark.landmark.kind == "post"]
    assert len(found.pixels) == len(true) == 2
    assert np.allclose(sorted(map(tuple, found.pixels)), sorted(true), atol=4.0)
    assert found.text == "2 goal posts" and found.result is not None


def test_a_picture_without_posts_has_none():
    _, seen = looked(OWN, Pose(1.0, 0.0, np.pi))
    assert seen.overlays["goal posts"].text == "0 goal posts"


def test_feet_that_are_none_are_said_in_words():
    for nonsense in (None, "feet", np.zeros((2, 3))):
        _, seen = looked({**OWN, "find_goalposts": lambda labels, answer=nonsense: answer})
        (said,) = seen.complaints
        assert said.startswith("Without goal posts: ")
