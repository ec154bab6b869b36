"""Drives of a student's personal world, with moves for a certain position and with moves for much new carpet."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nao_course._internal.personal_world import PersonalWorld
from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.beyond.exploring import FREE, SHAPE, UNKNOWN, Grid, mark_visible
from nao_course.lessons.beyond.planning import Choose, Function, Journey, Option, journey

DRIVES = 5
_NO_BOXES = np.zeros(SHAPE, dtype=bool)


def most_carpet() -> Choose:
    """Return a function that chooses the move after which a robot has seen most of the carpet."""
    grid = np.full(SHAPE, UNKNOWN)

    def choose(state: FloatArray, covariance: FloatArray, offered: Sequence[Option]) -> int:
        _look(grid, state)
        pose = Pose.from_array(state[:3])
        ends = [pose @ Pose(option.control[0], 0.0, option.control[1]) for option in offered]
        return int(np.argmax([_seen(_look(grid.copy(), end.as_array())) for end in ends]))

    return choose


def _look(grid: Grid, pose: FloatArray) -> Grid:
    """Mark in a grid what is visible from a pose, and return the grid."""
    mark_visible(grid, _NO_BOXES, pose[:2], pose[2])
    return grid


def _seen(grid: Grid) -> float:
    return float((grid == FREE).mean())


def seen_part(drive: Journey) -> float:
    """Return the fraction of the carpet that a robot has seen on a drive."""
    grid = np.full(SHAPE, UNKNOWN)
    for pose in drive.truth:
        _look(grid, pose)
    return _seen(grid)


def personal_numbers(
    world: PersonalWorld,
    choose_move: Function,
    predict: Function,
    update_landmarks: Function,
    add_landmark: Function,
) -> dict[str, float]:
    """Return standard deviations by both rules, medians of five drives, and how much more carpet exploring shows."""
    first, ekf = world.seed("12: drives"), (predict, update_landmarks, add_landmark)
    seeds = range(first, first + DRIVES)
    chosen = [journey(choose_move, ekf, seed) for seed in seeds]
    exploring = [journey(most_carpet(), ekf, seed) for seed in seeds]
    sigma, exploring_sigma = (
        100 * float(np.median([drive.sigmas.mean() for drive in drives])) for drives in (chosen, exploring)
    )
    more = np.mean([*map(seen_part, exploring)]) - np.mean([*map(seen_part, chosen)])
    return {
        "standard deviation with your choice, median of five drives (cm)": sigma,
        "standard deviation while exploring, median of five drives (cm)": exploring_sigma,
        "more carpet seen while exploring (percentage points)": 100 * float(more),
    }
