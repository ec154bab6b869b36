"""The complete robot on drives under hard conditions: few pictures, and odometry worse than stated.

``python -m benchmarks field_tails`` compares the student's filter, updated with a stop's best compass first, with the
same filter inside of `JointUpdate` and `MultipleHypotheses`. Lost and overconfident drives are listed with the stop
after which the estimate was wrong. ``python -m benchmarks field_false`` has the same drives without a hardship, and
with false corners.
"""

from __future__ import annotations

from typing import NamedTuple

from benchmarks import Result, Table, in_processes
from benchmarks.field.detections import detections, prepare
from benchmarks.field.variants import (
    BEST,
    ENDS,
    FILTER,
    Make,
    Options,
    Read,
    Score,
    joint_update,
    named,
    named_table,
    run,
    summary,
    surest_first,
    with_hypotheses,
)
from nao_course.field_slam.demo.drive import JOINT_CORNER_SIGMA
from nao_course.metrics import band

FRESH = range(2000, 2200)  # nothing was tuned on these drives; everything was on drives below 300


class Hardship(NamedTuple):
    """True over stated noise of the odometry, and pictures at a stop (1 or 3)."""

    factor: float = 1.0
    frames: int = 3


HARDSHIPS = {
    "one picture per stop": Hardship(frames=1),
    "odometry twice as bad as stated": Hardship(factor=2.0),
}
WHOLE = Options(lines=True, compass=True, whole=True, corner_sigma=JOINT_CORNER_SIGMA)
ALGORITHMS: dict[str, tuple[Options, Make]] = {
    "surest first": (BEST, surest_first(FILTER)),
    "joint update": (WHOLE, surest_first(joint_update)),
    "several hypotheses": (WHOLE, surest_first(with_hypotheses)),
}


def scores_of(seed: int) -> dict[tuple[str, str], Score]:
    """Run every algorithm over a drive under each hardship."""
    scores = {}
    for name, hardship in HARDSHIPS.items():
        reads = [Read.of(seen) for seen in detections(seed, hardship.factor)]
        for algorithm, (options, make) in ALGORITHMS.items():
            scores[name, algorithm] = run(reads, make, options, seed, hardship.frames)
    return scores


def main() -> Result:
    """Run all drives under all hardships, and name the lost and the overconfident ones."""
    for hardship in HARDSHIPS.values():
        prepare(FRESH, hardship.factor)
    runs = dict(zip(FRESH, in_processes(scores_of, FRESH, "hard drives"), strict=True))
    scores = {key: {seed: of[key] for seed, of in runs.items()} for key in runs[FRESH[0]]}
    found = {", ".join(name): summary(list(of.values())) for name, of in scores.items()}
    ended = named(scores)
    low, high = band(3, len(FRESH))
    tables = (Table.of("after 61 stops", found, *ENDS, "wrong", shown=".3g"), named_table(ended))
    note = f"95 % band of the mean NEES of {len(FRESH)} drives: {low:.2f} to {high:.2f}"
    return Result(
        "field_tails", {"conditions": found, "NEES band": (low, high), "named": ended}, tables, (note,)
    )
