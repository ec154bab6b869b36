"""Standard deviation and error after drives with chosen moves, with two fixed plans, and with random moves."""

from typing import Any

import numpy as np

from benchmarks import Result, Table, solution, write_json
from nao_course.lessons.beyond.particles import ParticleBelief
from nao_course.lessons.beyond.planning import Choose, Journey, at_random, in_a_circle, journey, straight_on
from nao_course.lessons.beyond.recorded import MOVES
from nao_course.metrics import band

SEEDS = range(30)
NAMES = ("smallest variance", "in a circle", "along the edge", "at random")
BLIND = ("smallest variance", "in a circle", "at random")  # from a start with the back to the goal
DRAWS = 10_000  # of the bootstrap


def main() -> Result:
    """Drive thirty times with each strategy, and write the results."""
    ekf, choose_move = solution("07"), solution("12")["choose_move"]
    functions = [ekf[name] for name in ("predict", "update_landmarks", "add_landmark")]

    def drives(name: str, back: bool) -> dict[str, Any]:
        return _summed_up(
            [journey(_chooser(name, choose_move, seed), functions, seed, back=back) for seed in SEEDS]
        )

    found = {name: drives(name, False) for name in NAMES}
    blind = {name: drives(name, True) for name in BLIND}
    low, high = band(3, len(SEEDS))
    saved = saving(found["smallest variance"]["sigma"], found["at random"]["sigma"])
    recorded = {
        "drives": len(SEEDS),
        "band": [round(low, 2), round(high, 2)],
        "saved": [round(each, 3) for each in saved],
        "variants": found,
        "back": blind,
    }
    write_json(MOVES, recorded)
    moves = len(found["at random"]["sigmas"]) - 1
    tables = tuple(
        Table.of(
            f"{len(SEEDS)} drives (seeds 0 to {SEEDS[-1]}) of {moves} moves, {start}: medians at the end, m; mean NEES",
            {
                name: {key: float(np.median(of[key])) for key in ("sigma", "error", "map")}
                | {"NEES": float(np.mean(of["nees"]))}
                for name, of in ways.items()
            },
            shown=".3g",
        )
        for start, ways in (("looking at the goal", found), ("with the back to it", blind))
    )
    part, least, most = saved
    notes = (
        f"choose_move: sigma {part:.0%} smaller than with random moves (95 % interval {least:.0%} to {most:.0%})",
        f"a consistent mean NEES is {low:.2f} to {high:.2f}",
    )
    return Result("beyond_moves", recorded, tables, notes)


def saving(chosen: list[float], other: list[float]) -> tuple[float, float, float]:
    """Return the share by which the median of `chosen` is below the median of `other`, with a 95 % interval."""
    first, second = np.array(chosen), np.array(other)
    picks = np.random.default_rng(0).integers(len(first), size=(DRAWS, len(first)))
    draws = 1 - np.median(first[picks], axis=1) / np.median(second[picks], axis=1)
    low, high = np.quantile(draws, (0.025, 0.975))
    return float(1 - np.median(first) / np.median(second)), float(low), float(high)


def _chooser(name: str, choose_move: Choose, seed: int) -> Choose:
    if name == "smallest variance":
        return choose_move
    return {"in a circle": in_a_circle, "along the edge": straight_on}.get(name) or at_random(seed)


def _summed_up(journeys: list[Journey]) -> dict[str, Any]:
    """Return the estimated and true errors at the ends, m, and quartiles of the uncertainty during the drives."""
    return {
        "sigma": [round(float(each.sigmas[-1]), 4) for each in journeys],
        "error": [round(float(each.errors[-1]), 4) for each in journeys],
        "map": [round(each.map_error, 4) for each in journeys],
        "nees": [round(_nees(each), 2) for each in journeys],
        "sigmas": np.quantile([each.sigmas for each in journeys], (0.25, 0.5, 0.75), axis=0)
        .round(4)
        .T.tolist(),
    }


def _nees(each: Journey) -> float:
    last = each.estimates[-1]
    return ParticleBelief(last.pose.as_array(), last.covariance).nees(each.truth[-1])
