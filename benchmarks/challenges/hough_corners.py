"""Entries to lesson 03's challenge: nothing, the paper's method as it stands, the lesson's own, and a better one."""

from itertools import combinations
from typing import Any

import numpy as np

from benchmarks import solution
from benchmarks.challenges.corner_detector import find_corners_better
from benchmarks.challenges.pictures import Pixels, finds_points
from benchmarks.challenges.posts import labels_of, nothing

ENDLESS = 1e9  # px


@finds_points
def paper(picture: Pixels) -> Any:
    """Detect corners by Aliyev et al. 2014, section 4.3, with the hue alone and intersections of infinite lines."""
    own, labels = solution("03"), labels_of(picture, 0.0)
    white = own["line_picture"](own["erase_background"](labels))
    pairs = combinations(own["hough_segments"](white), 2)
    meetings = [own["segment_intersection"](*pair, ENDLESS) for pair in pairs]
    points = np.array([each for each in meetings if each is not None]).reshape(-1, 2)
    inside = ((points >= 0) & (points < white.shape[::-1])).all(axis=1)
    return own["remove_doubles"](points[inside], 10.0)


@finds_points
def reference(picture: Pixels) -> Any:
    """Use the lesson's detector, with a least saturation and segments that are 5 pixels longer."""
    return solution("03")["find_corners"](labels_of(picture))


CORNER_ENTRIES = {
    "nothing": nothing,
    "the paper's, infinite lines": paper,
    "the reference": reference,
    "a better detector": find_corners_better,
}
