"""What lesson 02 adds to the robot: feet of posts in the live picture, from the student's own labels."""

import numpy as np

from nao_course.exercises import load_definitions
from nao_course.geometry import Pose
from nao_course.lessons.goalposts.measuring import Feet, match_feet
from nao_course.lessons.goalposts.stage import GREEN, STAGE, YELLOW
from nao_course.lessons.hsl_filtering.stage import STAGE as LABELS_STAGE
from nao_course.metrics import total
from nao_course.sim import SimulatedNao, Truth
from nao_course.widgets.control_panel import Pipeline
from tests.paths import PROJECT

OWN = {
    **load_definitions(PROJECT / "solutions" / "01_hsl_filtering.ipynb"),
    **load_definitions(PROJECT / "solutions" / "02_goalposts.ipynb"),
}


def looked(functions, pose=Pose(0.6, 0.5, -0.25)):
    nao = SimulatedNao(pose=pose, rng=41)
    return nao, Pipeline([LABELS_STAGE, STAGE], functions, nao, time_limit=60.0).process(
        nao.take_picture("bottom")
    )


def test_the_feet_in_the_picture_are_those_of_the_posts():
    nao, seen = looked(OWN)
    found = seen.overlays["goal posts"]
    true = [mark.pixel for mark in Truth(nao).picture.landmarks if mark.landmark.kind == "post"]
    assert len(found.pixels) == len(true) == 2
    assert np.allclose(sorted(map(tuple, found.pixels)), sorted(true), atol=4.0)
    assert found.text == "2 found" and found.result is not None


def test_posts_are_found_in_labels_with_the_lessons_limits_and_twice_as_many_as_with_narrow_ones(rng):
    assert f"GREEN, YELLOW = {GREEN}, {YELLOW}" in (PROJECT / "solutions" / "02_goalposts.md").read_text()
    there = SimulatedNao(pose=Pose(0.6, 0.5, -0.25), rng=41)
    robot = Pipeline([LABELS_STAGE, STAGE], OWN, there, time_limit=60.0)
    found, narrow = [], []
    for _ in range(16):
        x, y = rng.uniform((0.0, -1.5), (2.2, 1.5))
        nao = SimulatedNao(pose=Pose(x, y, float(np.arctan2(0.7 - y, 3.0 - x))), rng=41)
        seen = robot.process(nao.take_picture("bottom"))
        feet = Feet.of(Truth(nao).picture, nao.field)
        found.append(match_feet(seen.overlays["goal posts"].pixels, feet))
        narrow.append(match_feet(OWN["find_goalposts"](seen.overlays["labels"].result), feet))
    assert total(found).recall >= 0.7 and total(found).false <= 1
    assert total(found).hits >= 1.5 * total(narrow).hits


def test_a_picture_without_posts_has_none():
    _, seen = looked(OWN, Pose(1.0, 0.0, np.pi))
    assert seen.overlays["goal posts"].text == "0 found"
