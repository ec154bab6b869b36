"""Exploration on a grid: a room of boxes, the part that a robot has seen, and three strategies."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray
from nao_course.sim import Field

Function = Callable[..., Any]
Cell = tuple[int, int]
Grid = npt.NDArray[np.int_]
UNKNOWN, FREE, OCCUPIED = -1, 0, 1
CELL = 0.1  # m
X0, Y0, X1, Y1 = Field(2012).carpet  # m
SHAPE = round((Y1 - Y0) / CELL), round((X1 - X0) / CELL)  # rows along y, columns along x
BOXES, START = 8, (0.45, 0.05)  # m, field frame
STRIDE = 3  # cells of a move
REACH = 2.0  # m
HALF_VIEW = float(np.radians(30.0))
RAYS = np.radians(np.arange(-30.0, 30.1, 1.0))
ALONG = np.arange(0.0, REACH, CELL / 2)
GLANCES = (-2.0, -1.0, 0.0, 1.0, 2.0)  # rad: all around except behind
STEPS: tuple[Cell, ...] = ((1, 0), (-1, 0), (0, 1), (0, -1))


def room_of_boxes(seed: int) -> npt.NDArray[np.bool_]:
    """Return which cells of the carpet are occupied by boxes; there are no boxes near the start."""
    rng = np.random.default_rng([seed, 31])
    taken = np.zeros(SHAPE, dtype=bool)
    centres = cell_centres()
    for _ in range(BOXES):
        while True:
            place = rng.uniform((0.2, -2.2), (3.2, 2.2))
            if np.hypot(*(place - START)) > 0.7:
                break
        half = rng.permutation([rng.uniform(0.15, 0.3), rng.uniform(0.15, 0.8)]) / 2
        taken |= (np.abs(centres - place) <= half).all(axis=-1)
    return taken


def cell_centres() -> FloatArray:
    """Return the centres of all cells (rows, columns, 2): x and y in m, field frame."""
    ys, xs = np.mgrid[: SHAPE[0], : SHAPE[1]]
    return np.stack([X0 + CELL * (xs + 0.5), Y0 + CELL * (ys + 0.5)], axis=-1)


def cell_of(place: FloatArray) -> Cell:
    """Return (row, column) of a position (2,), m."""
    return int(np.floor((place[1] - Y0) / CELL)), int(np.floor((place[0] - X0) / CELL))


def mark_visible(grid: Grid, taken: npt.NDArray[np.bool_], place: FloatArray, headings: Any) -> None:
    """Mark in a grid the cells that are visible from a position (2,): free cells, and the first box on each ray."""
    angles = (np.atleast_1d(headings)[:, None] + RAYS).ravel()
    points = place + ALONG[:, None, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    columns = np.floor((points[..., 0] - X0) / CELL).astype(int)
    rows = np.floor((points[..., 1] - Y0) / CELL).astype(int)
    inside = (rows >= 0) & (rows < SHAPE[0]) & (columns >= 0) & (columns < SHAPE[1])
    rows, columns = rows.clip(0, SHAPE[0] - 1), columns.clip(0, SHAPE[1] - 1)
    hit = taken[rows, columns] | ~inside
    before = np.cumsum(hit, axis=0) - hit == 0  # nothing nearer along this ray
    free, box = before & ~hit, before & hit & inside
    grid[rows[free], columns[free]] = FREE
    grid[rows[box], columns[box]] = OCCUPIED


def passable(grid: Grid) -> npt.NDArray[np.bool_]:
    """Return the cells that are known to be free and not beside a box, because the robot is wider than a cell."""
    near = np.pad(grid == OCCUPIED, 1)
    rows, columns = grid.shape
    beside = sum(near[1 + i : 1 + i + rows, 1 + j : 1 + j + columns] for i, j in ((0, 0), *STEPS)) > 0
    return np.asarray((grid == FREE) & ~beside)


def way_back(steps: npt.NDArray[np.int_], goal: Cell) -> list[Cell]:
    """Return the shortest path from the cell where `steps` is 0 to a reachable goal."""
    way = [goal]
    while steps[way[-1]] > 0:
        i, j = way[-1]
        rows, columns = steps.shape
        beside = [(i + a, j + b) for a, b in STEPS if 0 <= i + a < rows and 0 <= j + b < columns]
        way.append(next(each for each in beside if steps[each] == steps[i, j] - 1))
    return way[::-1]


# --- strategies: each returns a goal, or None without a goal ---

Choose = Callable[[Grid, npt.NDArray[np.int_], Cell], Cell | None]


def nearest_frontier(find_frontiers: Function) -> Choose:
    """Return Yamauchi's strategy: drive to the nearest frontier."""

    def choose(grid: Grid, steps: npt.NDArray[np.int_], here: Cell) -> Cell | None:
        ends = as_mask(find_frontiers(grid.copy()), grid.shape) & (steps > 0)
        return _nearest(ends, steps)

    return choose


def anywhere_known(rng: np.random.Generator) -> Choose:
    """Return the strategy that drives to random known free cells, one after another."""
    goal: list[Cell] = []

    def choose(grid: Grid, steps: npt.NDArray[np.int_], here: Cell) -> Cell | None:
        if not goal or here == goal[0] or steps[goal[0]] <= 0:
            cells = np.argwhere(steps > 0)
            goal[:] = [(int(row), int(column)) for row, column in cells[rng.integers(len(cells), size=1)]]
        return goal[0]

    return choose


def lawn_mower(spacing: float = 1.0) -> Choose:
    """Return the strategy that drives up and down in lanes and around obstacles; it knows only the carpet's size."""
    lanes = np.arange(X0 + 0.4, X1, spacing)
    turns = [
        (x, y)
        for n, x in enumerate(lanes)
        for y in ((Y0 + 0.4, Y1 - 0.4) if n % 2 == 0 else (Y1 - 0.4, Y0 + 0.4))
    ]
    ends = [cell_of(np.array(each)) for each in turns]
    tried = 0

    def choose(grid: Grid, steps: npt.NDArray[np.int_], here: Cell) -> Cell | None:
        nonlocal tried
        while ends:
            reachable = np.argwhere(steps >= 0)
            row, column = reachable[np.argmin(np.square(reachable - ends[0]).sum(axis=1))]
            if (int(row), int(column)) != here and tried < 15:
                tried += 1
                return int(row), int(column)
            ends.pop(0)
            tried = 0
        return None

    return choose


def _nearest(wanted: npt.NDArray[np.bool_], steps: npt.NDArray[np.int_]) -> Cell | None:
    cells = np.argwhere(wanted)
    if not len(cells):
        return None
    row, column = cells[np.argmin(steps[wanted])]
    return int(row), int(column)


def as_mask(answer: Any, shape: tuple[int, ...]) -> npt.NDArray[np.bool_]:
    """Return the mask of a student's `find_frontiers`, also if it has 0 and 1; ValueError for anything else."""
    mask = np.array(answer)
    if mask.dtype.kind in "iu" and np.isin(mask, (0, 1)).all():
        mask = mask.astype(bool)
    if mask.shape != shape or mask.dtype != bool:
        raise ValueError(f"find_frontiers must return a boolean mask {shape}, got {mask.dtype} {mask.shape}")
    return mask


def as_steps(answer: Any, shape: tuple[int, ...]) -> npt.NDArray[np.int_]:
    """Return the steps of a student's `travel_steps` as integers; ValueError if they are not whole numbers."""
    steps = np.array(answer)
    if steps.dtype.kind == "f" and np.array_equal(steps, np.round(steps)) and np.isfinite(steps).all():
        steps = steps.astype(int)
    if steps.shape != shape or steps.dtype.kind not in "iu":
        raise ValueError(f"travel_steps must return whole numbers {shape}, got {steps.dtype} {steps.shape}")
    return steps.astype(int)


@dataclass(frozen=True, eq=False)
class Known:
    """Knowledge of a room after a move.

    `grid` (rows, columns) holds UNKNOWN, FREE or OCCUPIED, `place` (2,) is the robot's position in m, `goal` is the
    cell to which it drives, and `part` is the known fraction of the cells that can be seen at all.
    """

    grid: Grid
    place: FloatArray
    goal: Cell | None
    part: float


def explore(travel_steps: Function, choose: Choose, seed: int, moves: int) -> Iterator[Known]:
    """Explore a room of boxes, and yield the state of knowledge after each move.

    Each of the moves is 0.3 m long; a robot without a goal stays.
    """
    taken = room_of_boxes(seed)
    seeable = int(_seeable(taken).sum())
    grid = np.full(SHAPE, UNKNOWN)
    place, heading = np.array(START), 0.0
    mark_visible(grid, taken, place, heading + np.array(GLANCES))
    for _ in range(moves):
        here = cell_of(place)
        free = passable(grid)
        free[here] = True
        steps = as_steps(travel_steps(free.copy(), here), grid.shape)
        goal = choose(grid, steps, here)
        yield Known(grid.copy(), place.copy(), goal, float((grid != UNKNOWN).sum() / seeable))
        if goal is None:
            continue
        way = way_back(steps, goal)[1 : STRIDE + 1]
        there = cell_centres()[way[-1]] if way else place
        if way:
            heading = float(np.arctan2(*(there - place)[::-1]))
        place = there
        mark_visible(
            grid, taken, place, heading + np.array(GLANCES if not way or way[-1] == goal else (0.0,))
        )


def _seeable(taken: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Return the cells that are free, and the cells of boxes beside a free cell."""
    free = np.pad(~taken, 1)
    rows, columns = taken.shape
    return np.asarray(
        sum(free[1 + i : 1 + i + rows, 1 + j : 1 + j + columns] for i, j in ((0, 0), *STEPS)) > 0
    )
