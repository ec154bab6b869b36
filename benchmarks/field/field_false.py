"""Error against false corners: the course's SLAM, and two localizations on the known map.

``python -m benchmarks field_false`` adds false corners to the detections of drives: on robots, which stand for a while,
on papers and on neighbours' lines, which stay and are therefore seen again, and anywhere in a single picture. Each of
the four sources has an equal share; a source that is not in view is replaced by the last one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks import Result, Table, in_processes, write_json
from benchmarks.field.detections import detections, prepare
from benchmarks.field.field_tails import ALGORITHMS
from benchmarks.field.known_map import HIGH, LOW, GatedEkf, MonteCarlo
from benchmarks.field.variants import BEST, ENDS, Make, Options, Read, Score, named, named_table, run, summary
from nao_course.geometry import FloatArray
from nao_course.lessons.slam_on_the_field.false_corners import RECORDED as FOR_THE_LESSON
from nao_course.metrics import band

FRESH = range(2000, 2200)  # nothing was tuned on these drives; everything was on drives below 300
RATES = (0.0, 0.3, 1.0, 2.0, 3.0)  # mean number of false corners that are added to a picture
BASELINES: dict[str, tuple[Options, Make]] = {
    "Monte Carlo, known map": (BEST, MonteCarlo),
    "gated EKF, known map": (BEST, GatedEkf),
}
EVERY = ALGORITHMS | BASELINES
ROBOTS, STAYS, PAPERS, NEIGHBOURS = 8, 10, 8, 16  # corners of each source; stops for which a robot stands
BEYOND = (1.0, 3.0)  # m: distance of neighbours' lines from the field's
FARTHEST = 6.0  # m
BOX = ((10.0, 90.0), (310.0, 230.0))  # px: where a false corner is found
PIXEL = 0.5  # px: standard deviation of a false corner that is seen again


def sources(rng: np.random.Generator, stops: int) -> list[list[FloatArray]]:
    """Return the places (N, 2), m in the field frame, of robots, papers and neighbours' lines at each stop."""
    robots = np.repeat(rng.uniform(LOW, HIGH, (-(-stops // STAYS), ROBOTS, 2)), STAYS, axis=0)
    papers = rng.uniform(LOW, HIGH, (PAPERS, 2))
    around = rng.uniform(LOW - BEYOND[1], HIGH + BEYOND[1], (100 * NEIGHBOURS, 2))
    outside = np.maximum(LOW - around, around - HIGH).max(axis=1) > BEYOND[0]
    return [[robots[stop], papers, around[outside][:NEIGHBOURS]] for stop in range(stops)]


def with_false_corners(reads: Sequence[Read], rate: float, seed: int) -> list[Read]:
    """Return a drive's pictures with false corners added; the same seed and rate add the same ones."""
    rng, found = np.random.default_rng([seed, 41]), []
    places = sources(rng, -(-len(reads) // 3))
    for number, read in enumerate(reads):
        false = rng.uniform(*BOX, (rng.poisson(rate), 2))
        free = [_in_view(each, read) for each in places[number // 3]]
        for i, source in enumerate(rng.integers(len(free) + 1, size=len(false))):
            if source < len(free) and len(free[source]):
                chosen = rng.integers(len(free[source]))
                false[i] = free[source][chosen] + rng.normal(0.0, PIXEL, 2)
                free[source] = np.delete(free[source], chosen, axis=0)
        corners = np.vstack([read.corners.reshape(-1, 2), false])
        found.append(replace(read, corners=corners))
    return found


def _in_view(places: FloatArray, read: Read) -> FloatArray:
    """Return the pixels (N, 2) of the places that a picture shows."""
    pixels = read.seen.true_view.project(places, read.seen.pose)
    near = np.hypot(*read.seen.pose.to_local(places).T) < FARTHEST
    with np.errstate(invalid="ignore"):
        return pixels[near & ((pixels > BOX[0]) & (pixels < BOX[1])).all(axis=1)]


def scores_of(seed: int, rates: Sequence[float] = RATES) -> dict[tuple[float, str], Score]:
    """Run every algorithm over a drive with each rate of false corners."""
    reads = [Read.of(seen) for seen in detections(seed)]
    return {
        (rate, name): run(given, make, options, seed)
        for rate in rates
        for given in [with_false_corners(reads, rate, seed)]
        for name, (options, make) in EVERY.items()
    }


def for_the_lesson(found: Mapping[str, Mapping[str, float]]) -> dict[str, Any]:
    """Return what lesson 11's figure draws: shares of the drives by algorithm, at each rate of false corners."""
    algorithms = {
        name: {share: [found[f"{rate:g}, {name}"][share] for rate in RATES] for share in ("lost", "outside")}
        for name in EVERY
    }
    return {"false corners": RATES, "drives": len(FRESH), "algorithms": algorithms}


def main() -> Result:
    """Run the drives, and name the lost and the overconfident ones."""
    prepare(FRESH)
    runs = dict(zip(FRESH, in_processes(scores_of, FRESH, "drives with false corners"), strict=True))
    scores = {
        (f"{rate:g}", name): {seed: of[rate, name] for seed, of in runs.items()}
        for rate in RATES
        for name in EVERY
    }
    found = {", ".join(key): summary(list(of.values())) for key, of in scores.items()}
    ended = named(scores)
    write_json(FOR_THE_LESSON, for_the_lesson(found))
    low, high = band(3, len(FRESH))
    tables = (
        Table.of(f"false corners a picture, end of {len(FRESH)} drives", found, *ENDS, shown=".3g"),
        named_table(ended),
    )
    note = f"95 % band of the mean NEES of {len(FRESH)} drives: {low:.2f} to {high:.2f}"
    return Result(
        "field_false",
        {"seeds": [FRESH[0], FRESH[-1]], "conditions": found, "NEES band": (low, high), "named": ended},
        tables,
        (note,),
    )
