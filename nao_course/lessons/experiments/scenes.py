"""Simulated and real pictures for trying settings, each with its true corners."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.challenges.progress import Progress
from nao_course.datasets import PictureSet, read_pictures
from nao_course.exercises.earlier import EarlierNotUsable
from nao_course.exercises.trying import Message, show
from nao_course.geometry import FloatArray
from nao_course.lessons.experiments.paper_table import BETAS, GAPS, LENGTHS, PICTURES, SETTINGS, Setting
from nao_course.lessons.experiments.resampling import as_table
from nao_course.metrics import CornerTruth
from nao_course.sim.reality import Reality
from nao_course.sim.scenes import SceneSet, standard_scene

COSTS = Path(__file__).with_name("costs.json")  # by the solution, for each setting and picture
Pixels = npt.NDArray[np.uint8]
CornerScene = tuple[Pixels, FloatArray]  # a picture (H, W, 3), and its corners (K, 2), (u, v) px


@lru_cache(maxsize=600)
def simulated_scene(
    number: int, which: SceneSet = "tune", size: tuple[int, int] = (320, 240), seed: int = 0
) -> CornerScene:
    """Return a picture of a standard set, counted from 0, with its L and T corners; it is read-only.

    Another `seed` selects other rooms and places.
    """
    scene = standard_scene(which, number, size, Reality(seed=seed))
    pair = scene.pixels, CornerTruth.of(scene.truth).corners
    for array in pair:
        array.setflags(write=False)
    return pair


def simulated_scenes(
    which: SceneSet = "tune", size: tuple[int, int] = (320, 240), seed: int = 0
) -> tuple[CornerScene, ...]:
    """Return all thirty pictures of the simulator's set "tune" or "report"; another `seed` selects other rooms."""
    return tuple(simulated_scene(number, which, size, seed) for number in range(PICTURES))


def real_scenes(which: PictureSet) -> tuple[CornerScene, ...]:
    """Read the pictures of a real NAO with hand-marked corners; the list is empty if they are not installed."""
    try:
        pictures = read_pictures(which)
    except FileNotFoundError:
        return ()
    return tuple((each.pixels, CornerTruth.marked(each.points).corners) for each in pictures)


def recorded_costs(scenes: Sequence[CornerScene]) -> dict[Setting, FloatArray] | None:
    """Return the costs (S,) of the solution for the lesson's pictures, by setting; None for other pictures."""
    if len(scenes) != PICTURES or not np.array_equal(scenes[0][0], simulated_scene(0)[0]):
        return None
    costs = json.loads(COSTS.read_text(encoding="utf-8"))
    return as_table({setting: np.array(each) for setting, each in zip(SETTINGS, costs, strict=True)})


def nothing_costs(scenes: Sequence[CornerScene]) -> FloatArray:
    """Return what reporting nothing costs in each scene, (S,): 1 for each corner that is there."""
    return np.array([float(len(corners)) for _, corners in scenes])


def search_scenes(
    grid_search: Callable[..., Any], scenes: Sequence[CornerScene]
) -> dict[Setting, FloatArray]:
    """Search the 27 settings with a student's function and show the progress.

    The function is called once for each scene. Counting the scenes that it takes from a list would not work, because
    the count would start again in each of the student's loops. If a function of an earlier lesson is not usable, the
    costs of the solution are returned, which were recorded with the lesson's pictures, and a note says so.

    Parameters
    ----------
    grid_search : callable
        ``grid_search(scenes, betas, gaps, lengths)`` returns costs by setting.
    scenes : sequence of CornerScene
        At least one.

    Returns
    -------
    dict of Setting to ndarray, shape (S,)
        The costs of all scenes, the best mean first.
    """
    tables, progress = [], None
    for scene in scenes:
        try:
            tables.append(as_table(grid_search([scene], list(BETAS), list(GAPS), list(LENGTHS))))
        except EarlierNotUsable as reason:
            recorded = recorded_costs(scenes)
            if recorded is None:
                raise
            show(Message(f"{reason} The table is therefore our solution's, recorded with these pictures."))
            return recorded
        progress = progress or Progress(len(scenes), "scenes")  # an unwritten function shows no bar
        progress.step()
    if progress:
        progress.end()
    return as_table({key: np.concatenate([each[key] for each in tables]) for key in tables[0]})
