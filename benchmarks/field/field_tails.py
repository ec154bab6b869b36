"""Drives over the field under hard conditions: few pictures, false corners, and odometry that is worse than stated.

``python -m benchmarks field_tails`` uses the drives of ``field_slam``, whose table contains the results of the plain
filter. "Surest first" sorts the pictures of a stop by the uncertainty of their compass. "Joint update" also uses lines
and the centre circle. "Adaptive noise" is the joint update that estimates the odometry's noise from the compass.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial

import cv2
from rich.progress import track

from benchmarks import Result, Table
from benchmarks.field.field_slam.algorithms import FILTER, Make, adaptive_update, joint_update, surest_first
from benchmarks.field.field_slam.detections import detections, prepare
from benchmarks.field.field_slam.report import FRESH, WHOLE, summary
from benchmarks.field.field_slam.variants import Read, Score, run

# For each name: factor of the odometry's true noise, pictures at each stop, and false corners in each picture.
HARDSHIPS = {
    "normal": (1.0, 3, 0.0),
    "one picture per stop": (1.0, 1, 0.0),
    "0.3 false corners per picture": (1.0, 3, 0.3),
    "odometry twice as bad as stated": (2.0, 3, 0.0),
}


ALGORITHMS: dict[str, Make] = {
    "surest first": surest_first(FILTER),
    "joint update": surest_first(joint_update),
    "adaptive noise": surest_first(adaptive_update),
}


def scores_of(seed: int, factor: float) -> dict[tuple[str, str], Score]:
    """Run a drive under each hardship with this odometry."""
    cv2.setNumThreads(1)
    reads, scores = [Read.of(seen) for seen in detections(seed, factor)], {}
    for name, (worse, frames, false_corners) in HARDSHIPS.items():
        if worse == factor:
            options = replace(WHOLE, false_corners=false_corners)
            for algorithm, make in ALGORITHMS.items():
                scores[name, algorithm] = run(reads, make, options, seed, frames)
    return scores


def main(jobs: int = 2) -> Result:
    """Render what is missing, and run all drives under all hardships."""
    found: dict[tuple[str, str], list[Score]] = {}
    for factor in (1.0, 2.0):
        prepare(FRESH, factor, jobs)
        with ProcessPoolExecutor(jobs) as pool:
            waiting = pool.map(partial(scores_of, factor=factor), FRESH)
            for scores in track(waiting, f"drives, odometry noise x {factor:g}", len(FRESH)):
                for each, score in scores.items():
                    found.setdefault(each, []).append(score)
    return result(found)


def result(scores: Mapping[tuple[str, str], Sequence[Score]]) -> Result:
    """Return the table of the drives by hardship and algorithm."""
    found = {", ".join(each): summary(of) for each, of in scores.items()}
    keys = ("drives", "position", "position 95 %", "position worst", "heading", "NEES mean", "wrong", "lost")
    columns = (
        "hardship",
        "drives",
        "position m",
        "95 %",
        "worst",
        "heading",
        "NEES",
        "wrong landmarks",
        "lost",
    )
    rows = tuple((name, *(f"{of[key]:.3g}" for key in keys)) for name, of in found.items())
    return Result("field_tails", found, (Table("after 61 stops", columns, rows),))
