"""The stage of lesson 01: live labels of every pixel on the student's robot."""

from __future__ import annotations

from typing import Any

import numpy as np

from nao_course import plotting
from nao_course.colours import YELLOW
from nao_course.geometry import Pose
from nao_course.robot import Robot
from nao_course.sim import LABELS, SimulatedNao, Truth
from nao_course.widgets.attempts import StudentCode
from nao_course.widgets.control_panel.pipeline import Frame, Overlay, Stage, StageFunction

_PLACE = Pose(0.6, 0.5, -0.25)  # pose in the lesson's scene, with carpet and goal in view
_SEED = 41  # seed of the lesson's scene
_CARPET = np.s_[200:, 100:220]  # rows and columns with which the lesson calibrates green
_EPSILON = 10.0  # degrees by which the lesson widens green
_SAMPLE = 1000  # pixels in the sample for the mean lightness


def _label_pixels(student: StudentCode, nao: Robot) -> StageFunction:
    """Label each picture with limits that are calibrated once on the lesson's scene."""
    green, yellow = _calibrate(student, nao)

    def look(frame: Frame) -> Overlay:
        picture = frame.picture.pixels
        lightness = student.rgb_to_hsl(picture)[2]
        mean = student.average_lightness(lightness, _SAMPLE, np.random.default_rng(0))
        labels = student.color_labels(picture, green, yellow, student.white_threshold(mean))
        shares = [f"{name} {np.mean(labels == label):.0%}" for label, name in enumerate(LABELS) if label]
        return Overlay(labels, plotting.painted(labels), np.asarray(labels) > 0, text=", ".join(shares))

    return look


def _calibrate(student: StudentCode, nao: Robot) -> tuple[Any, Any]:
    """Return limits of green and yellow from the student's `calibrate_hue` and examples of carpet and goal.

    Nobody has marked the goal in the pictures of a real robot, so its yellow is the course's.
    """
    from nao_course.lessons.hsl_filtering.payoff import without_edges  # matplotlib comes with it

    there = nao
    if isinstance(nao, SimulatedNao):
        there = SimulatedNao(nao.field, _PLACE, rng=_SEED, reality=nao.reality)
    hue, saturation, _ = student.rgb_to_hsl(there.take_picture("bottom").pixels)
    green = student.calibrate_hue(hue[_CARPET], saturation[_CARPET], epsilon=_EPSILON)
    if not isinstance(there, SimulatedNao):
        return green, YELLOW
    truth = Truth(there).picture
    goal = without_edges(truth is not None and truth.labels == LABELS.index("yellow"))
    if not goal.any():
        raise ValueError("there is no yellow goal on this field to calibrate yellow with")
    return green, student.calibrate_hue(hue[goal], saturation[goal])


STAGE = Stage(
    name="labels",
    lesson="01_hsl_filtering",
    uses=("rgb_to_hsl", "average_lightness", "white_threshold", "calibrate_hue", "color_labels"),
    wire=_label_pixels,
)
