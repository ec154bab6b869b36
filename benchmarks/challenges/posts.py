"""Entries to lesson 02's challenge: the paper's rule, the lesson's own, and one that does better than both."""

from typing import Any

import cv2
import numpy as np

from benchmarks import solution
from benchmarks.challenges.pictures import Pixels, finds_points
from nao_course.colours import GREEN, YELLOW, mean_lightness


def labels_of(picture: Pixels, min_saturation: float = 0.16, beta: float = 120.0) -> Any:
    """Return the labels of the lesson's solution."""
    own = solution("01")
    threshold = own["white_threshold"](mean_lightness(picture), beta)
    return own["color_labels"](picture, GREEN, YELLOW, threshold, min_saturation)


def nothing(picture: Pixels) -> Any:
    """Find no foot."""
    return np.zeros((0, 2))


@finds_points
def paper(picture: Pixels) -> Any:
    """Find posts by Aliyev et al. 2014, section 4.2, with the hue alone; "some" of "a few pixels" is 3 of 5."""
    own = solution("02")
    candidates = own["post_candidates"](labels_of(picture, 0.0), 3, 5, 0.15)
    return own["cluster_points"](candidates, 20.0)


@finds_points
def reference(picture: Pixels) -> Any:
    """Use the lesson's detector."""
    return solution("02")["find_goalposts"](labels_of(picture))


@finds_points
def better(picture: Pixels) -> Any:
    """Remove noise first, use a wider but more saturated yellow, and a longer linkage.

    All numbers were chosen in rooms 930 to 935, none of them the board's.
    """
    own = solution("02")
    hls = cv2.cvtColor(cv2.medianBlur(picture, 5).astype(np.float32) / 255, cv2.COLOR_RGB2HLS)
    hue, saturation = hls[..., 0], hls[..., 2]
    labels = np.zeros(hue.shape, dtype=np.uint8)
    labels[(hue >= 86) & (hue <= 170) & (saturation >= 0.12)] = 1
    labels[(hue >= 44) & (hue <= 84) & (saturation >= 0.4)] = 2
    candidates = own["post_candidates"](labels, 8, 10, 0.12)
    return own["cluster_points"](candidates, 32.0)


POST_ENTRIES = {
    "nothing": nothing,
    "the paper's rule": paper,
    "the reference": reference,
    "a better rule": better,
}
