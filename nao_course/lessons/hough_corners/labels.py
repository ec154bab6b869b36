"""Recorded labels of lesson 03's pictures, for students whose lesson 01 is not finished."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nao_course.datasets.recorded_labels import Pixels, RecordedLabels
from nao_course.lessons.hough_corners.scenes import goal_line_at, three_places, tuning_pictures
from nao_course.sim import Reality

DISTANCES = np.arange(2.4, 6.3, 0.2)  # m, of the goal line
_NOTE = (
    "Your labels of lesson 01 are not usable yet, so the pictures of this lesson have recorded labels. They do not "
    "change with GREEN, YELLOW and beta. The control panel and the challenge need your own labels."
)


def lesson_pictures() -> list[Pixels]:
    """Return every simulated picture that the lesson labels; the challenge has others."""
    places = [each.pixels for each in (*three_places().values(), *tuning_pictures())]
    return [*places, *(each.pixels for each in goal_line_at(DISTANCES, Reality(seed=11)))]


_LABELS = RecordedLabels(Path(__file__).with_name("labels.npz"), lesson_pictures, _NOTE)
record, recorded_labels, or_recorded = _LABELS.record, _LABELS.find, _LABELS.or_recorded
