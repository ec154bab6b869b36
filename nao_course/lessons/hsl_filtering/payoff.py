"""The payoff of lesson 01: one place of the field in three lights, labelled by the student's six functions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from nao_course.exercises.trying import Message
from nao_course.geometry import Pose
from nao_course.lessons.hsl_filtering.light import in_light
from nao_course.plotting.drawing import Drawing
from nao_course.plotting.legends import label_keys, legend_below
from nao_course.plotting.pictures import painted, plot_picture
from nao_course.plotting.style import course_style
from nao_course.sim import LABELS, Field, SimulatedNao, Truth

LIGHTS = {"0.7 of the light": 0.7, "the light of the calibration": 1.0, "1.1 of the light": 1.1}
_TINY = np.array([[[60, 130, 70], [205, 190, 45]]], dtype=np.uint8)  # a pixel of grass and one of the goal
_HUES, _SATURATIONS = np.array([[128.6, 54.4]]), np.array([[0.37, 0.64]])

Exercises = dict[str, Callable[..., Any]]


def draw_payoff(
    rgb_to_hsl: Callable[..., Any],
    average_lightness: Callable[..., Any],
    white_threshold: Callable[..., Any],
    hue_mask: Callable[..., Any],
    color_labels: Callable[..., Any],
    calibrate_hue: Callable[..., Any],
) -> Drawing | Message:
    """Draw the goal in three lights, and the labels that the lesson's six functions give its pixels.

    They are calibrated once, in the light of the second picture, on the grass before the robot and on the goal.

    Parameters
    ----------
    rgb_to_hsl, average_lightness, white_threshold, hue_mask, color_labels, calibrate_hue : callable
        The exercises' functions.

    Returns
    -------
    Drawing or Message
        The figure, its text with the part of the lines that is found; or which functions are missing.
    """
    own: Exercises = {
        "rgb_to_hsl": rgb_to_hsl,
        "average_lightness": average_lightness,
        "white_threshold": white_threshold,
        "hue_mask": hue_mask,
        "color_labels": color_labels,
        "calibrate_hue": calibrate_hue,
    }
    if missing := unwritten(own):
        return Message(f"This shows your labels in three lights once you have written {', '.join(missing)}.")
    picture, truth = payoff_scene()
    try:
        green, yellow = _calibrated(picture, truth, own)
        labelled = [_labelled(in_light(picture, factor), green, yellow, own) for factor in LIGHTS.values()]
        return _figure([in_light(picture, factor) for factor in LIGHTS.values()], labelled, truth)
    except Exception as error:  # noqa: BLE001 - whatever a student's code raises is what it is about
        return Message(f"Your functions do not work together yet: {type(error).__name__}: {error}")


def payoff_scene() -> tuple[npt.NDArray[np.uint8], npt.NDArray[np.uint8]]:
    """Return a picture (H, W, 3) of the goal from near by, and its true labels (H, W); the same at every call."""
    nao = SimulatedNao(Field(2012), Pose(1.1, 0.9, -0.42), rng=7)
    return nao.take_picture("bottom").pixels, Truth(nao).picture.labels


def unwritten(own: Exercises) -> list[str]:
    """Return the names of the functions that are not written yet: each is called once with very little."""
    tries: dict[str, tuple[Any, ...]] = {
        "rgb_to_hsl": (_TINY,),
        "average_lightness": (np.array([[80.0, 90.0]]), 2, np.random.default_rng(0)),
        "white_threshold": (100.0,),
        "hue_mask": (_HUES, 100.0, 150.0),
        "color_labels": (_TINY, (100.0, 150.0), (40.0, 70.0), 180.0),
        "calibrate_hue": (_HUES, _SATURATIONS),
    }
    return [name for name, function in own.items() if _is_blank(function, tries[name])]


def _is_blank(function: Callable[..., Any], given: tuple[Any, ...]) -> bool:
    try:
        function(*given)
    except NotImplementedError:
        return True
    except Exception:  # noqa: BLE001 - written, and wrong: that shows where it is used
        return False
    return False


def _calibrated(
    picture: npt.NDArray[np.uint8], truth: npt.NDArray[np.uint8], own: Exercises
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Limits of green, from the picture's lower middle, and of yellow, from the middle of posts and bar."""
    hue, saturation, _ = own["rgb_to_hsl"](picture.copy())
    grass = np.s_[200:, 100:220]
    goal = cv2.erode((truth == LABELS.index("yellow")).astype(np.uint8), np.ones((5, 5))) > 0
    green = own["calibrate_hue"](hue[grass], saturation[grass], 10.0)
    return green, own["calibrate_hue"](hue[goal], saturation[goal])


def _labelled(
    picture: npt.NDArray[np.uint8], green: Any, yellow: Any, own: Exercises
) -> npt.NDArray[np.uint8]:
    lightness = own["rgb_to_hsl"](picture.copy())[2]
    mean = own["average_lightness"](lightness, 1000, np.random.default_rng(0))
    return np.asarray(own["color_labels"](picture.copy(), green, yellow, own["white_threshold"](mean)))


def _figure(pictures: list[Any], labelled: list[Any], truth: npt.NDArray[np.uint8]) -> Drawing:
    lines = truth == LABELS.index("white")
    with course_style():
        figure = Figure(figsize=(9.9, 5.6))
        rows = figure.subplots(2, len(LIGHTS))
        for (above, below), name, picture, labels in zip(rows.T, LIGHTS, pictures, labelled, strict=True):
            plot_picture(picture, above, ticks=False)
            above.set_title(name, fontsize=11)
            plot_picture(painted(labels), below, ticks=False)
        legend_below(figure, label_keys(LABELS))
    found = ", ".join(
        f"{name} {(labels[lines] == LABELS.index('white')).mean():.0%}"
        for name, labels in zip(LIGHTS, labelled, strict=True)
    )
    words = (
        "Pictures of the goal in three lights, and below each its labels: green carpet, yellow goal, white lines, and the "
        f"rest. Of the lines' pixels are found: {found}."
    )
    return Drawing(figure, words, photo=True)
