"""A picture of a student's personal world, with one stray pixel in the example of the goal."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np

from nao_course._internal.personal_world import PersonalWorld
from nao_course.geometry import Pose
from nao_course.lessons.hsl_filtering.payoff import GREEN, YELLOW, Pixels, picture_from, without_edges

PLACES = (0.3, -0.8), (1.2, 0.8)  # m, field frame: the robot is between these corners
GOAL = (3.0, 0.0)  # m: the middle of the goal of 2012
TURN = 0.15  # rad: the robot looks past the middle of the goal by this at most
HUES = (0.5, 0.95)  # quantiles of the carpet's hues, between which the stray pixel's is
ROUNDING = 1e-4  # degrees: pixels of the same colour have the same hue up to this


def personal_example(world: PersonalWorld) -> tuple[Pixels, Pixels, tuple[int, int]]:
    """Return a picture (H, W, 3) of the goal, its true labels (H, W), and row and column of a pixel of the carpet."""
    rng = world.rng("01: picture")
    x, y = rng.uniform(*PLACES).tolist()
    heading = np.arctan2(GOAL[1] - y, GOAL[0] - x) + rng.uniform(-TURN, TURN)
    pixels, labels = picture_from(Pose(x, y, float(heading)), rng)
    hues = cv2.cvtColor(pixels, cv2.COLOR_RGB2HSV)[..., 0]  # of 2 degrees each
    low, high = np.quantile(hues[labels == GREEN], HUES)
    row, column = rng.choice(np.argwhere((labels == GREEN) & (low <= hues) & (hues <= high))).tolist()
    return pixels, labels, (row, column)


def personal_numbers(
    world: PersonalWorld,
    rgb_to_hsl: Callable[..., Any],
    hue_mask: Callable[..., Any],
    calibrate_hue: Callable[..., Any],
) -> dict[str, float]:
    """Return the upper limits of yellow without and with a stray pixel, and how much of the carpet it makes yellow."""
    pixels, labels, stray = personal_example(world)
    hue, saturation, _ = rgb_to_hsl(pixels)
    goal = without_edges(labels == YELLOW)
    _, clean = calibrate_hue(hue[goal], saturation[goal], ROUNDING)
    goal[stray] = True
    limits = calibrate_hue(hue[goal], saturation[goal], ROUNDING)
    return {
        "upper limit of yellow without the pixel (degrees)": float(clean),
        "upper limit of yellow with the pixel (degrees)": float(limits[1]),
        "carpet labelled yellow (%)": 100 * float(np.mean(hue_mask(hue[labels == GREEN], *limits))),
    }
