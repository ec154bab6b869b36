"""The complete robot on drives under hard conditions: few pictures, false corners, and odometry worse than stated.

``python -m benchmarks field_tails`` compares the student's filter, updated with a stop's best compass first, with the
same filter inside of `JointUpdate` and `MultipleHypotheses`. Drives that end far from the truth are listed with the
stop after which the estimate was wrong.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import NamedTuple

from benchmarks import Result, Table, in_processes
from benchmarks.field.detections import detections, prepare
from benchmarks.field.variants import (
    BEST,
    ENDS,
    FILTER,
    LOST,
    Make,
    Options,
    Read,
    Score,
    joint_update,
    run,
    summary,
    surest_first,
    with_hypotheses,
)
from nao_course.field_slam.demo.drive import JOINT_CORNER_SIGMA
from nao_course.metrics import band

# Nothing was tuned on these drives. JointUpdate and MultipleHypotheses were tuned on drives 200 to 229.
FRESH = {1.0: range(1000, 1200), 2.0: range(800, 1000)}


class Hardship(NamedTuple):
    """True over stated noise of the odometry, pictures at a stop (1 or 3), and mean number of false corners added."""

    factor: float = 1.0
    frames: int = 3
    false_corners: float = 0.0


HARDSHIPS = {
    "normal": Hardship(),
    "one picture per stop": Hardship(frames=1),
    "0.3 false corners per picture": Hardship(false_corners=0.3),
    "odometry twice as bad as stated": Hardship(factor=2.0),
}
WHOLE = Options(lines=True, compass=True, whole=True, corner_sigma=JOINT_CORNER_SIGMA)
ALGORITHMS: dict[str, tuple[Options, Make]] = {
    "surest first": (BEST, surest_first(FILTER)),
    "joint update": (WHOLE, surest_first(joint_update)),
    "several hypotheses": (WHOLE, surest_first(with_hypotheses)),
}


def scores_of(seed: int, factor: float) -> dict[tuple[str, str], Score]:
    """Run a drive under each hardship with this odometry."""
    reads, scores = [Read.of(seen) for seen in detections(seed, factor)], {}
    for name, hardship in HARDSHIPS.items():
        if hardship.factor == factor:
            for algorithm, (options, make) in ALGORITHMS.items():
                chosen = replace(options, false_corners=hardship.false_corners)
                scores[name, algorithm] = run(reads, make, chosen, seed, hardship.frames)
    return scores


def main() -> Result:
    """Run all drives under all hardships, and list the lost ones."""
    scores: dict[tuple[str, str], dict[int, Score]] = {}
    for factor, seeds in FRESH.items():
        prepare(seeds, factor)
        runs = in_processes(partial(scores_of, factor=factor), seeds, f"drives, odometry noise x {factor:g}")
        for seed, each in zip(seeds, runs, strict=True):
            for name, score in each.items():
                scores.setdefault(name, {})[seed] = score
    found = {", ".join(name): summary(list(of.values())) for name, of in scores.items()}
    lost = [
        {"hardship": name[0], "algorithm": name[1], "seed": seed, "stop": score.misled}
        for name, of in scores.items()
        for seed, score in of.items()
        if score.position > LOST
    ]
    low, high = band(3, len(FRESH[1.0]))
    tables = (
        Table.of("after 61 stops", found, *ENDS, "wrong", shown=".3g"),
        Table(
            "lost drives; stop -1: uncertain to the end",
            ("hardship", "algorithm", "seed", "misled at stop"),
            tuple(tuple(each.values()) for each in lost),
        ),
    )
    note = f"95 % band of the mean NEES of {len(FRESH[1.0])} drives: {low:.2f} to {high:.2f}"
    return Result(
        "field_tails", {"conditions": found, "NEES band": (low, high), "lost": lost}, tables, (note,)
    )
