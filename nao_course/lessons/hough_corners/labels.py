"""Recorded labels of lesson 03's pictures, for students whose lesson 01 is not finished."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.datasets.recorded_labels import (
    Pixels,
    Recorded,
    find_labels,
    read_labels,
    with_recorded,
    write_labels,
)
from nao_course.lessons.hough_corners.scenes import goal_line_at, three_places, tuning_pictures
from nao_course.sim import Reality

RECORDED = Path(__file__).with_name("labels.npz")
DISTANCES = np.arange(2.4, 6.3, 0.2)  # m, of the goal line
_NOTE = (
    "Your labels of lesson 01 are not usable yet, so the pictures of this lesson have recorded labels. They do not "
    "change with GREEN, YELLOW and beta. The control panel and the challenge need your own labels."
)


def lesson_pictures() -> list[Pixels]:
    """Return every simulated picture that the lesson labels; the challenge has others."""
    places = [each.pixels for each in (*three_places().values(), *tuning_pictures())]
    return [*places, *(each.pixels for each in goal_line_at(DISTANCES, Reality(seed=11)))]


def record(label: Callable[[Any], Any], path: Path = RECORDED) -> None:
    """Write the labels of all pictures of the lesson to a file: ``label(pixels)`` returns labels (H, W), 0 to 3."""
    write_labels(path, lesson_pictures(), label)


def recorded_labels(picture: npt.ArrayLike) -> Pixels | None:
    """Return the recorded labels (H, W) of a picture of this lesson; None for any other picture."""
    return find_labels(_load(), picture)


@cache
def _load() -> Recorded:
    return read_labels(RECORDED)


def or_recorded(label: Callable[..., Any]) -> Callable[..., Any]:
    """Return a function like `label` that uses recorded labels if a function of lesson 01 is not usable."""
    return with_recorded(label, recorded_labels, _NOTE)
