"""What lesson 01 adds to the student's robot: their own labels of every pixel, live."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.geometry import Pose
from nao_course.plotting import painted
from nao_course.sim import LABELS, SimulatedNao, Truth
from nao_course.widgets.attempts import StudentCode
from nao_course.widgets.control_panel.pipeline import Look, Overlay, Sight, Stage

_PLACE = Pose(0.6, 0.5, -0.25)  # of the lesson's scene: carpet at the feet, the goal in view
_SEED = 41  # of the lesson's scene
_CARPET = np.s_[200:, 100:220]  # rows, columns of it that the lesson calibrates green with
_EPSILON = 10.0  # degrees by which the lesson widens green
_SAMPLE = 1000  # pixels whose mean lightness stands for the picture's


def _label_pixels(student: StudentCode, nao: SimulatedNao) -> Look:
    """Calibrate green and yellow on the lesson's scene, as the robot would before a game; then label each picture."""
    green, yellow = _calibrate(student, nao)

    def look(sight: Sight) -> Overlay:
        picture = sight.picture.pixels
        lightness = student.rgb_to_hsl(picture)[2]
        mean = student.average_lightness(lightness, _SAMPLE, np.random.default_rng(0))
        labels = student.color_labels(picture, green, yellow, student.white_threshold(mean))
        shares = [f"{name} {np.mean(labels == label):.0%}" for label, name in enumerate(LABELS) if label]
        return Overlay(labels, painted(labels), np.asarray(labels) > 0, text=", ".join(shares))

    return look


def _calibrate(student: StudentCode, nao: SimulatedNao) -> tuple[Any, Any]:
    """Limits of green and yellow, as the student's `calibrate_hue` finds them in examples of carpet and goal."""
    there = SimulatedNao(nao.field, _PLACE, rng=_SEED, reality=nao.reality)
    hue, saturation, _ = student.rgb_to_hsl(there.take_picture("bottom").pixels)
    truth = Truth(there).picture
    goal = _middle(truth is not None and truth.labels == LABELS.index("yellow"))
    if not goal.any():
        raise ValueError("there is no yellow goal on this field to calibrate yellow with")
    green = student.calibrate_hue(hue[_CARPET], saturation[_CARPET], epsilon=_EPSILON)
    return green, student.calibrate_hue(hue[goal], saturation[goal])


def _middle(mask: Any) -> npt.NDArray[np.bool_]:
    """A mask (H, W) without its edge, where colours mix."""
    return np.asarray(cv2.erode(np.asarray(mask, dtype=np.uint8), np.ones((5, 5))) > 0)


STAGE = Stage(
    name="labels",
    lesson="01_hsl_filtering",
    uses=("rgb_to_hsl", "average_lightness", "white_threshold", "calibrate_hue", "color_labels"),
    wire=_label_pixels,
)
