"""Camera-only SLAM from rendered pictures: every variant on the same drives.

``python -m benchmarks field_slam`` renders the drives once (build/drives, 8 s of a core each) and runs all variants
on their detections.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from benchmarks import Result, Table, in_processes, solution
from benchmarks.field.detections import detections, prepare
from benchmarks.field.variants import (
    BEST,
    ENDS,
    FILTER,
    GRAPH,
    Make,
    Options,
    Read,
    Score,
    by_nearest_neighbour,
    jointly,
    run,
    summary,
    surest_first,
)
from nao_course.field_slam.compass import wrap_quarter
from nao_course.field_slam.observation import Observation
from nao_course.geometry import FloatArray
from nao_course.lessons.slam_on_the_field.variants import RECORDED
from nao_course.metrics import band

FRESH = range(400, 500)  # drives that nothing was tuned on
SEEN = range(300, 400)  # what the compass believes of short lines was found on these
EKF: Any = solution("11")["EkfSlam"]


class Refusing(EKF):
    """A filter that ignores a compass reading outside of its gate."""

    def use_compass(self, direction: float, sigma: float) -> None:
        """Update with the compass if it is inside the gate."""
        off = wrap_quarter(-direction - self.state[2])
        near = off**2 <= self.gate**2 * (self.covariance[2, 2] + sigma**2)
        super().use_compass(direction, sigma if near else float("inf"))


class AsMeasured(Observation):
    """An observation that is not linearised at the expected ranges."""

    def linearised_at(self, ranges: Any) -> tuple[FloatArray, FloatArray]:
        """Return the measured values and their covariance."""
        return self.values.ravel(), self.covariance


class BentRanges(EKF):
    """A filter that treats a tilt as an error of the range instead of the inverse range."""

    def correct(self, seen: Observation) -> None:
        """Update with the measured ranges."""
        super().correct(AsMeasured(seen.measurements, seen.covariance, tilt=seen.tilt))


class NewOnesAlone(EKF):
    """A filter that ignores the correlation of new landmarks' measurements with the others of the picture."""

    def number(self, seen: Observation) -> None:
        """Associate the measurements, and mark those of new landmarks."""
        before = len(self.kinds)
        super().number(seen)
        self.new = np.asarray(self.indices) >= before

    def correct(self, seen: Observation) -> None:
        """Update with a covariance without the correlations of new landmarks."""
        shares = np.outer(~self.new, ~self.new) | np.eye(len(seen), dtype=bool)
        super().correct(replace(seen, covariance=seen.covariance * np.kron(shares, np.ones((2, 2)))))


# Name: options of the measurements, algorithm, pictures at each stop. Each line changes one thing in the line before.
VARIANTS: dict[str, tuple[Options | None, Make, int]] = {
    "odometry": (None, FILTER, 3),
    "the paper's corners and distances": (
        Options(corners="lesson 03", paper=True, constant=True),
        by_nearest_neighbour,
        3,
    ),
    "lesson 04's distances": (Options(corners="lesson 03", constant=True), by_nearest_neighbour, 3),
    "corners where lines meet": (Options(constant=True), by_nearest_neighbour, 3),
    "tilt in R, independent errors": (Options(shared=False), by_nearest_neighbour, 3),
    "tilt estimated with each picture": (Options(), by_nearest_neighbour, 3),
    "joint compatibility": (Options(), FILTER, 3),
    "tilt from lines": (Options(lines=True), FILTER, 3),
    "compass: the complete EKF": (BEST, FILTER, 3),
    "graph": (BEST, GRAPH, 3),
    "EKF, nearest neighbour": (BEST, by_nearest_neighbour, 3),
    "EKF, best compass of a stop first": (BEST, surest_first(FILTER), 3),
    "graph, best compass of a stop first": (BEST, surest_first(GRAPH), 3),
    "EKF, distant compasses rejected": (BEST, jointly(Refusing), 3),
    "EKF, ranges instead of 1/r": (BEST, jointly(BentRanges), 3),
    "EKF, new landmarks independent": (BEST, jointly(NewOnesAlone), 3),
    "EKF, posts without the extra 2 cm": (replace(BEST, post_sigma=0.0), FILTER, 3),
    "EKF, lesson 03's corners": (replace(BEST, corners="lesson 03"), FILTER, 3),
    "EKF, one picture at a stop": (BEST, FILTER, 1),
    "graph, one picture at a stop": (BEST, GRAPH, 1),
    "EKF, 0.3 false corners a picture": (replace(BEST, false_corners=0.3), FILTER, 3),
}
TWICE = "EKF, odometry twice as bad as stated"
AGAIN = (
    *("compass: the complete EKF", "graph", "EKF, best compass of a stop first"),
    *("graph, best compass of a stop first", "EKF, one picture at a stop"),
)


def scores_of(seed: int, factor: float, names: Sequence[str]) -> dict[str, Score]:
    """Run the named variants over a drive; with worse odometry, run the complete EKF only."""
    reads = [Read.of(seen) for seen in detections(seed, factor)]
    if factor != 1:
        return {TWICE: run(reads, FILTER, BEST, seed)}
    chosen = {name: VARIANTS[name] for name in names}
    return {
        name: run(reads, make, options, seed, pictures) for name, (options, make, pictures) in chosen.items()
    }


def all_scores(
    seeds: Sequence[int], factor: float = 1.0, names: Sequence[str] = tuple(VARIANTS)
) -> dict[str, list[Score]]:
    """Run the named variants over the same drives."""
    prepare(seeds, factor)
    found = in_processes(
        partial(scores_of, factor=factor, names=names), seeds, f"variants, odometry {factor:g}"
    )
    return {name: [each[name] for each in found] for name in found[0]}


def for_the_lesson(scores: Mapping[str, Sequence[Score]]) -> list[dict[str, Any]]:
    """Return what the lesson shows of each variant: errors of each drive, m and degrees, and its NEES."""
    places = {"position": 4, "heading": 3, "landmarks": 4, "nees": 2}
    return [
        {"variant": name}
        | {
            key: [round(getattr(each, key), count) for each in of if np.isfinite(getattr(each, key))]
            for key, count in places.items()
        }
        for name, of in scores.items()
    ]


def main() -> Result:
    """Run all variants, and write what the lesson shows."""
    scores = all_scores(FRESH) | all_scores(FRESH, 2.0)
    RECORDED.write_text(json.dumps(for_the_lesson(scores)).replace("}, {", "},\n {") + "\n", encoding="utf-8")
    found = {name: summary(each) for name, each in scores.items()}
    again = {name: summary(each) for name, each in all_scores(SEEN, names=AGAIN).items()}
    low, high = band(3, len(FRESH))
    tables = (
        Table.of(f"end of {len(FRESH)} drives of 61 stops", found, *ENDS, shown=".3g"),
        Table.of(f"of {len(SEEN)} others", again, *ENDS, shown=".3g"),
    )
    note = f"95 % band of the mean NEES of {len(FRESH)} drives: {low:.2f} to {high:.2f}; its median should be 2.37"
    return Result(
        "field_slam", {"variants": found, "NEES band": (low, high), "others": again}, tables, (note,)
    )
