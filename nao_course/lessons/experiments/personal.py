"""Pictures of a student's personal room, in which no setting was chosen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from nao_course._internal.personal_world import PersonalWorld
from nao_course.geometry import FloatArray
from nao_course.lessons.experiments.paper_table import PICTURES, Setting
from nao_course.lessons.experiments.scenes import CornerScene, nothing_costs, simulated_scene
from nao_course.plotting import Table, table

PROBABILITY = 0.95  # of the intervals
BEST: Setting = (120, 7, 50)  # of the solution's detector, in the lesson's pictures


def personal_scenes(world: PersonalWorld, pictures: int = PICTURES) -> tuple[CornerScene, ...]:
    """Render up to 30 pictures (240, 320, 3) of a student's personal room, each with its L and T corners (K, 2), px.

    The world's name determines the room and the places.
    """
    return tuple(simulated_scene(number, seed=world.seed("10: room")) for number in range(pictures))


def costs_in(scenes: Sequence[CornerScene], setting: Setting, grid_search: Callable[..., Any]) -> FloatArray:
    """Return the costs of a setting in some scenes, shape (S,), from a student's `grid_search`."""
    beta, gap, length = setting
    return np.array(grid_search(list(scenes), [beta], [gap], [length])[beta, gap, length], dtype=float)


def personal_costs(
    world: PersonalWorld,
    settings: Sequence[Setting],
    grid_search: Callable[..., Any],
    bootstrap_interval: Callable[..., Any],
) -> Table:
    """Return a table of the mean costs in a student's personal room, with 95 % intervals.

    Parameters
    ----------
    world : PersonalWorld
        Of the student.
    settings : sequence of (beta, gap, length)
        Settings to evaluate.
    grid_search, bootstrap_interval : callable
        The student's functions.
    """
    scenes = personal_scenes(world)
    costs = {"reporting nothing": nothing_costs(scenes)}
    costs |= {
        ", ".join(f"{value:g}" for value in each): costs_in(scenes, each, grid_search) for each in settings
    }
    rows = []
    for name, values in costs.items():
        low, high = bootstrap_interval(values.copy(), PROBABILITY, np.random.default_rng(0))
        rows.append((name, f"{values.mean():.2f}", f"{low:.2f} to {high:.2f}"))
    return table((f"room of {world}", "mean cost", "95 % interval"), rows)


def personal_numbers(world: PersonalWorld, grid_search: Callable[..., Any]) -> dict[str, float]:
    """Return the numbers of a student's table, for the solution's best setting.

    The first is the same for all students with this name. The second depends on the student's detector.
    """
    scenes = personal_scenes(world)
    return {
        "reporting nothing": float(nothing_costs(scenes).mean()),
        "120, 7, 50 with our detector": float(costs_in(scenes, BEST, grid_search).mean()),
    }
