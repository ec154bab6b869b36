"""The payoff of lesson 01: one place of the field in three lights, labelled by the student's six functions."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from nao_course.geometry import Pose
from nao_course.lessons.hsl_filtering.light import in_light
from nao_course.plotting.drawing import Drawing
from nao_course.plotting.legends import label_keys, legend_below
from nao_course.plotting.pictures import painted, plot_picture
from nao_course.plotting.style import course_style
from nao_course.sim import LABELS, Field, SimulatedNao, Truth

Pixels = npt.NDArray[np.uint8]
Exercises = Mapping[str, Callable[..., Any]]

LIGHTS = {"0.7 of the light": 0.7, "the light of the calibration": 1.0, "1.1 of the light": 1.1}
YELLOW, WHITE = LABELS.index("yellow"), LABELS.index("white")


def draw_payoff(**functions: Callable[..., Any]) -> Drawing:
    """Draw the goal in three lights, and the labels that the lesson's six functions give its pixels.

    They are calibrated once, in the light of the second picture, on the grass before the robot and on the goal.

    Parameters
    ----------
    **functions : callable
        rgb_to_hsl, average_lightness, white_threshold, calibrate_hue and color_labels by their names; hue_mask, which
        the last one calls.

    Returns
    -------
    Drawing
        The figure; its text gives the part of the lines that is found in each light.
    """
    picture, truth = payoff_scene()
    green, yellow = _calibrated(picture, truth, functions)
    lit = [in_light(picture, factor) for factor in LIGHTS.values()]
    labelled = [_labelled(each, green, yellow, functions) for each in lit]
    return _figure(lit, labelled, truth == WHITE)


def payoff_scene() -> tuple[Pixels, Pixels]:
    """Return a picture (H, W, 3) of the goal from near by, and its true labels (H, W); the same at every call."""
    nao = SimulatedNao(Field(2012), Pose(1.1, 0.9, -0.42), rng=7)
    pixels, truth = nao.take_picture("bottom").pixels, Truth(nao).picture
    assert truth is not None  # a picture was taken
    return pixels, truth.labels


def _calibrated(picture: Pixels, truth: Pixels, own: Exercises) -> tuple[Any, Any]:
    """Limits of green, from the picture's lower middle, and of yellow, from the middle of posts and bar."""
    hue, saturation, _ = own["rgb_to_hsl"](picture.copy())
    grass = np.s_[200:, 100:220]
    goal = cv2.erode((truth == YELLOW).astype(np.uint8), np.ones((5, 5))) > 0
    green = own["calibrate_hue"](hue[grass], saturation[grass], 10.0)
    return green, own["calibrate_hue"](hue[goal], saturation[goal])


def _labelled(picture: Pixels, green: Any, yellow: Any, own: Exercises) -> Pixels:
    mean = own["average_lightness"](own["rgb_to_hsl"](picture)[2], 1000, np.random.default_rng(0))
    return np.asarray(own["color_labels"](picture.copy(), green, yellow, own["white_threshold"](mean)))


def _figure(pictures: Sequence[Pixels], labelled: Sequence[Pixels], lines: npt.NDArray[np.bool_]) -> Drawing:
    with course_style():
        figure = Figure(figsize=(7.6, 4.4))
        rows = figure.subplots(2, len(LIGHTS))
        for (above, below), name, picture, labels in zip(rows.T, LIGHTS, pictures, labelled, strict=True):
            plot_picture(picture, above, ticks=False)
            above.set_title(name, fontsize=11)
            plot_picture(painted(labels), below, ticks=False)
        legend_below(figure, label_keys(LABELS))
    found = ", ".join(
        f"{name} {(labels[lines] == WHITE).mean():.0%}" for name, labels in zip(LIGHTS, labelled, strict=True)
    )
    words = (
        "Pictures of the goal in three lights, and below each its labels: green carpet, yellow goal, white lines, "
        f"and the rest. Of the lines' pixels are found: {found}."
    )
    return Drawing(figure, words, photo=True)
