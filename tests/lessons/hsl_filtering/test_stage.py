"""What lesson 01 adds to the robot: the solution's functions label the live picture as the truth does."""

import numpy as np
import pytest

from nao_course.exercises import load_definitions
from nao_course.geometry import Pose
from nao_course.lessons.hsl_filtering.stage import STAGE
from nao_course.sim import Field, SimulatedNao, Truth
from nao_course.widgets.control_panel import ControlPanel, Pipeline
from tests.paths import PROJECT

OWN = load_definitions(PROJECT / "solutions" / "01_hsl_filtering.ipynb")


def panel_of(nao):
    return ControlPanel(nao, Truth(nao), pipeline=Pipeline([STAGE], OWN, nao, time_limit=60.0))


@pytest.mark.parametrize("pose", [Pose(0.6, 0.5, -0.25), Pose(1.2, -0.5, 0.6)])
def test_the_labels_are_the_lessons_and_mostly_true(pose):
    panel = panel_of(SimulatedNao(pose=pose, rng=41))
    labels = panel._own.latest.overlays["labels"].result
    truth = panel.cockpit.picture_truth("bottom").labels
    carpet = truth == 1
    assert np.mean(labels[carpet] == 1) > 0.85
    assert np.mean(labels[truth == 3] == 3) > 0.9
    assert f"green {np.mean(labels == 1):.0%}" in panel.summary()


def test_other_pixels_of_the_picture_stay_as_they_are():
    panel = panel_of(SimulatedNao(pose=Pose(0.6, 0.5, -0.25), rng=41))
    labels = panel._own.latest.overlays["labels"].result
    pixels = panel.cockpit.pictures["bottom"].pixels
    shown, _ = panel._screen.shown("bottom")
    assert np.array_equal(shown[labels == 0], pixels[labels == 0])
    assert not np.array_equal(shown[labels == 1], pixels[labels == 1])


def test_a_field_without_a_yellow_goal_says_so():
    nao = SimulatedNao(Field(2025), rng=3)
    assert "no yellow goal" in panel_of(nao).summary()
