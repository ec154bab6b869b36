"""Entries to lesson 01's challenge: the paper's rule, the lesson's own, and one that does better than both."""

from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from benchmarks import solution
from benchmarks.challenges.pictures import Pixels, check_picture

Labels = npt.NDArray[np.uint8]

GREEN, YELLOW = (90.0, 160.0), (44.0, 66.0)  # degrees; carpets and goals of several venues, as in the lesson
LINES = 41  # pixels: what white is brighter than is the mean of a square of this side
CONTRAST, PART = 15.0, 0.4  # levels; part of the 99.5 % quantile


def nothing(picture: Pixels) -> Labels:
    """Return the label "other" for all pixels."""
    return np.zeros(picture.shape[:2], dtype=np.uint8)


def reference(picture: Pixels, min_saturation: float = 0.16) -> Any:
    """Return the labels of the lesson's solution."""
    if not check_picture(picture).size:
        return nothing(picture)
    own = solution("01")
    mean = own["average_lightness"](own["rgb_to_hsl"](picture)[2], 1000, np.random.default_rng(0))
    return own["color_labels"](picture, GREEN, YELLOW, own["white_threshold"](mean), min_saturation)


def paper(picture: Pixels) -> Any:
    """Label by Aliyev et al. 2014, section 4.1: equation 4.1 with beta 120, and the hue alone."""
    return reference(picture, min_saturation=0.0)


def better(picture: Pixels) -> Labels:
    """Label white relative to its surroundings, and yellow and green after removing noise.

    All numbers were chosen in rooms 900 to 917, none of them the board's.
    """
    if not check_picture(picture).size:
        return nothing(picture)
    hls = cv2.cvtColor(cv2.medianBlur(picture, 5).astype(np.float32) / 255, cv2.COLOR_RGB2HLS)
    hue, saturation = hls[..., 0], hls[..., 2]
    labels = nothing(picture)
    labels[(hue >= 80) & (hue <= 170) & (saturation >= 0.12)] = 1
    yellow = (hue >= 44) & (hue <= 80) & (saturation >= 0.3)
    white = stands_out(picture, np.logical_or.accumulate(labels == 1, axis=0))
    labels[yellow] = 2
    labels[white] = 3
    return labels


def stands_out(picture: Pixels, field: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Return the pixels (H, W) whose darkest channel exceeds its local mean by a share of the brightest excesses."""
    darkest = picture.min(axis=2).astype(np.float32)
    chroma = picture.max(axis=2) - darkest
    contrast = darkest - cv2.blur(darkest, (LINES, LINES))
    strongest = float(np.percentile(contrast[field], 99.5)) if field.any() else 0.0
    found: npt.NDArray[np.bool_] = (contrast > max(CONTRAST, PART * strongest)) & (chroma < 0.5 * darkest)
    return found


COLOUR_ENTRIES = {
    "nothing": nothing,
    "the paper's rule": paper,
    "the reference": reference,
    "a better rule": better,
}
