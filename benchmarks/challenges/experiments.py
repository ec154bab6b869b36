"""Entries to lesson 10's challenge: nothing, the paper's setting, the best of the lesson's 27, and a better detector.

Each says its interval by rooms that it was tried in: others than the challenge's, of the same three presets.
"""

from collections.abc import Callable
from typing import Any

import numpy as np

from benchmarks import solution
from benchmarks.challenges.corner_detector import find_corners_better
from benchmarks.challenges.pictures import Pixels
from benchmarks.challenges.posts import labels_of
from nao_course.geometry import FloatArray

Rooms = list[Pixels]
Detector = Callable[[Pixels], FloatArray]
PAPER, BEST = (120, 5, 40), (120, 7, 50)
# Quantiles 0.1 and 0.9 of nine other rooms of six pictures: lab 2010 to 2012, dark 2020 to 2022, harsh 2030 to 2032.
NOTHING_CLAIM, PAPER_CLAIM, BEST_CLAIM, BETTER_CLAIM = (9.2, 14.0), (8.0, 13.4), (7.7, 13.1), (-1.6, 2.1)


def with_setting(beta: float, gap: float, length: float) -> Detector:
    """Return the lesson's detector with a setting."""
    return lambda picture: solution("03")["find_corners"](labels_of(picture, beta=beta), gap, length)


def nothing(pictures: Rooms) -> Any:
    """Find no corner; a room then costs as much as there are corners in a picture."""
    return [np.zeros((0, 2)) for _ in pictures], *NOTHING_CLAIM


def paper(pictures: Rooms) -> Any:
    """Use the best setting of the paper."""
    return [with_setting(*PAPER)(picture) for picture in pictures], *PAPER_CLAIM


def reference(pictures: Rooms) -> Any:
    """Use the setting with the lowest mean in the lesson."""
    return [with_setting(*BEST)(picture) for picture in pictures], *BEST_CLAIM


def better(pictures: Rooms) -> Any:
    """Use lesson 03's better detector."""
    return [find_corners_better(picture) for picture in pictures], *BETTER_CLAIM


ROOM_ENTRIES = {
    "nothing": nothing,
    "the paper's setting": paper,
    "the reference": reference,
    "a better detector": better,
}
