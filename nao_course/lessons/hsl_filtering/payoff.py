"""The first and the last figure of lesson 01: one scene in three lights, and the labels of its pixels."""

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

LIGHTS = {"0.7 of the light": 0.7, "full light": 1.0, "1.1 of the light": 1.1}
GREEN, YELLOW, WHITE = (LABELS.index(name) for name in ("green", "yellow", "white"))


def draw_rgb_limits() -> Drawing:
    """Draw the goal in two lights, and the labels of a filter with fixed limits of red, green and blue.

    The limits are the 2 % and 98 % quantiles of each channel for carpet, goal and lines in the brighter picture.

    Returns
    -------
    Drawing
        The figure; its text gives the part of the lines that is found in each light.
    """
    picture, truth = payoff_scene()
    limits = {
        label: np.quantile(picture[truth == label], (0.02, 0.98), axis=0) for label in (GREEN, YELLOW, WHITE)
    }
    lit = {name: in_light(picture, factor) for name, factor in LIGHTS.items() if factor <= 1}
    return _figure(lit, [_between(each, limits) for each in lit.values()], truth == WHITE)


def _between(picture: Pixels, limits: Mapping[int, npt.NDArray[Any]]) -> Pixels:
    """Return the labels (H, W) of the pixels whose channels all lie between the limits of a label, 0 elsewhere."""
    labels = np.zeros(picture.shape[:2], dtype=np.uint8)
    for label, (low, high) in limits.items():
        labels[((picture >= low) & (picture <= high)).all(axis=2)] = label
    return labels


def draw_payoff(**functions: Callable[..., Any]) -> Drawing:
    """Draw the goal in three lights, and the labels that the student's six functions give its pixels.

    The hues are calibrated once, in the second picture, with the grass in front of the robot and with the goal.

    Parameters
    ----------
    **functions : callable
        rgb_to_hsl, average_lightness, white_threshold, calibrate_hue and color_labels by their names, and hue_mask,
        which color_labels calls.

    Returns
    -------
    Drawing
        The figure; its text gives the part of the lines that is found in each light.
    """
    picture, truth = payoff_scene()
    green, yellow = _calibrated(picture, truth, functions)
    lit = {name: in_light(picture, factor) for name, factor in LIGHTS.items()}
    labelled = [_labelled(each, green, yellow, functions) for each in lit.values()]
    return _figure(lit, labelled, truth == WHITE)


def payoff_scene() -> tuple[Pixels, Pixels]:
    """Return a picture (H, W, 3) of the goal and its true labels (H, W), which are the same at every call."""
    return picture_from(Pose(1.1, 0.9, -0.42), 7)


def picture_from(pose: Pose, rng: np.random.Generator | int) -> tuple[Pixels, Pixels]:
    """Return a picture (H, W, 3) of the field of 2012 from a pose on it, and its true labels (H, W)."""
    nao = SimulatedNao(Field(2012), pose, rng=rng)
    pixels, truth = nao.take_picture("bottom").pixels, Truth(nao).picture
    assert truth is not None  # a picture was taken
    return pixels, truth.labels


def without_edges(mask: npt.ArrayLike) -> npt.NDArray[np.bool_]:
    """Return a mask (H, W) without its edges, where a pixel mixes two colours."""
    return np.asarray(cv2.erode(np.asarray(mask, dtype=np.uint8), np.ones((5, 5))) > 0)


def _calibrated(picture: Pixels, truth: Pixels, own: Exercises) -> tuple[Any, Any]:
    """Return limits of green, from the grass in front of the robot, and of yellow, from posts and bar without edges."""
    hue, saturation, _ = own["rgb_to_hsl"](picture.copy())
    grass = np.s_[200:, 100:220]
    goal = without_edges(truth == YELLOW)
    green = own["calibrate_hue"](hue[grass], saturation[grass], 10.0)
    return green, own["calibrate_hue"](hue[goal], saturation[goal])


def _labelled(picture: Pixels, green: Any, yellow: Any, own: Exercises) -> Pixels:
    mean = own["average_lightness"](own["rgb_to_hsl"](picture)[2], 1000, np.random.default_rng(0))
    return np.asarray(own["color_labels"](picture.copy(), green, yellow, own["white_threshold"](mean)))


@course_style()
def _figure(
    pictures: Mapping[str, Pixels], labelled: Sequence[Pixels], lines: npt.NDArray[np.bool_]
) -> Drawing:
    figure = Figure(figsize=(2.3 * len(pictures), 4.0))
    rows = figure.subplots(2, len(pictures))
    for (above, below), (name, picture), labels in zip(rows.T, pictures.items(), labelled, strict=True):
        plot_picture(picture, above, ticks=False)
        above.set_title(name, fontsize=11)
        plot_picture(painted(labels), below, ticks=False)
    legend_below(figure, label_keys(LABELS))
    found = ", ".join(
        f"{name} {(labels[lines] == WHITE).mean():.0%}"
        for name, labels in zip(pictures, labelled, strict=True)
    )
    words = (
        f"Pictures of the goal in {len(pictures)} lights, and below each its labels: green carpet, yellow goal, "
        f"white lines, and the rest. Fraction of the lines' pixels that are found: {found}."
    )
    return Drawing(figure, words, photo=True)
