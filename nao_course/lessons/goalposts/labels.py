"""Recorded labels of lesson 02's pictures, for students whose lesson 01 is not finished."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy.typing as npt

from nao_course.datasets.recorded_labels import (
    Pixels,
    Recorded,
    find_labels,
    read_labels,
    with_recorded,
    write_labels,
)
from nao_course.geometry import Pose
from nao_course.lessons.goalposts.scenes import approach, robot_before, scenes_by_distance, turning_head
from nao_course.sim import Field, Reality, SimulatedNao

RECORDED = Path(__file__).with_name("labels.npz")
_NOTE = (
    "Your labels of lesson 01 are not usable yet, so the pictures of this lesson have recorded labels. They do not "
    "change with GREEN and YELLOW. The control panel and the challenge need your own labels."
)


def lesson_pictures() -> list[Pixels]:
    """Return every picture that the lesson labels, in the lesson's order."""
    nao = SimulatedNao(Field(2012), Pose(0.6, 0.5, -0.25), rng=41)
    pictures = [nao.take_picture("bottom").pixels, *turning_head().values()]
    pictures += [scene.pixels for seed in (0, 1) for scene in scenes_by_distance(seed=seed)]
    near, far = approach([0.9, 0.7, 0.55], Reality(seed=11)), approach([2.0], Reality(seed=11))[0]
    return [*pictures, *(scene.pixels for scene in near), robot_before(far.pixels, far.nearest)]


def record(label: Callable[[Any], Any], path: Path = RECORDED) -> None:
    """Write the labels of all pictures of the lesson to a file: ``label(pixels)`` returns labels (H, W), 0 to 3."""
    write_labels(path, lesson_pictures(), label)


def recorded_labels(picture: npt.ArrayLike) -> Pixels | None:
    """Return the recorded labels (H, W) of a picture of this lesson; None for any other picture."""
    return find_labels(_load(), picture)


@cache
def _load() -> Recorded:
    return read_labels(RECORDED)


def or_recorded(label: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Return a function like `label` that uses recorded labels if a function of lesson 01 is not usable."""
    return with_recorded(label, recorded_labels, _NOTE)
