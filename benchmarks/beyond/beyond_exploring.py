"""Known part of a room after each move: nearest frontier, random goals, lanes."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from benchmarks import Result, Table, solution, write_json
from nao_course.lessons.beyond.exploring import Choose, anywhere_known, explore, lawn_mower, nearest_frontier
from nao_course.lessons.beyond.recorded import EXPLORING

ROOMS, MOVES, AT = range(30), 80, (10, 30, 60)
NAMES = ("nearest frontier", "at random", "lanes")
ENOUGH = 0.9  # of the visible area


def main() -> Result:
    """Explore all rooms with three strategies, and write the results."""
    own = solution("12")
    found: dict[str, dict[str, Any]] = {}
    for name in NAMES:
        parts = np.array(
            [
                [
                    known.part
                    for known in explore(own["travel_steps"], _strategy(name, own, room), room, MOVES)
                ]
                for room in ROOMS
            ]
        )
        quartiles = np.quantile(parts, (0.25, 0.5, 0.75), axis=0)
        found[name] = {"quartiles": quartiles.round(4).tolist(), "enough": _moves_until(parts)}
    recorded = {"rooms": len(ROOMS), "moves": MOVES, "enough": ENOUGH, "variants": found}
    write_json(EXPLORING, recorded)
    rows = tuple(
        (name, *(_said(of["quartiles"], move) for move in AT), _median_moves(of["enough"]))
        for name, of in found.items()
    )
    columns = ("strategy", *(f"after {move}" for move in AT), f"moves to {ENOUGH:.0%}")
    title = f"known of {len(ROOMS)} rooms (seeds 0 to {ROOMS[-1]}), %: median and quartiles"
    return Result("beyond_exploring", recorded, (Table(title, columns, rows),))


def _strategy(name: str, own: Mapping[str, Any], room: int) -> Choose:
    if name == "nearest frontier":
        return nearest_frontier(own["find_frontiers"])
    return anywhere_known(np.random.default_rng([room, 32])) if name == "at random" else lawn_mower()


def _moves_until(parts: np.ndarray) -> list[int | None]:
    """Return the number of moves after which each room (a row) is known well enough; None if it never is."""
    return [int(np.argmax(room >= ENOUGH)) if (room >= ENOUGH).any() else None for room in parts]


def _said(quartiles: list[list[float]], move: int) -> str:
    low, middle, high = (100 * each[move] for each in quartiles)
    return f"{middle:.0f} ({low:.0f}-{high:.0f})"


def _median_moves(moves: list[int | None]) -> str:
    median = np.median([MOVES if each is None else each for each in moves])
    return f"{median:.0f}" if median < MOVES else f"{MOVES} and more"
