"""The field's worst drives: few looks, false corners, odometry worse than told; and who stands them.

``python -m benchmarks field_tails`` uses the drives of ``field_slam``, whose table has the plain filter on them.
Careful: a landmark stays that is seen three times, and odometry's noise is learnt from the compass; it keeps false
corners off the map, and loses more drives than the plain filter. Surest first: the picture with the surest compass of a
stop. Whole picture: lines and the centre circle besides.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial

import cv2
from rich.progress import track

from benchmarks import Result, Table
from benchmarks.field_slam.algorithms import FILTER, Make, surest_first, whole_picture
from benchmarks.field_slam.detections import detections, prepare
from benchmarks.field_slam.report import FRESH, WHOLE, summary
from benchmarks.field_slam.variants import Read, Score, run
from nao_course.geometry import Pose
from nao_course.lessons.slam_on_the_field.system.careful import CarefulSlam
from nao_course.slam import SlamAlgorithm

# Name: how much worse odometry is than told, looks a stop, false corners a picture.
HARDSHIPS = {
    "as it is": (1.0, 3, 0.0),
    "one look a stop": (1.0, 1, 0.0),
    "0.3 false corners a picture": (1.0, 3, 0.3),
    "odometry twice as bad and not told": (2.0, 3, 0.0),
}


def careful(start: Pose) -> SlamAlgorithm:
    """Lesson 11's filter with joint compatibility, and its doubts."""
    return CarefulSlam(FILTER(start))  # type: ignore[arg-type]


ALGORITHMS: dict[str, Make] = {
    "careful": careful,
    "surest first": surest_first(FILTER),
    "whole picture": surest_first(whole_picture),
}


def scores_of(seed: int, factor: float) -> dict[tuple[str, str], Score]:
    """Run a drive under each hardship with this odometry."""
    cv2.setNumThreads(1)
    reads, scores = [Read.of(seen) for seen in detections(seed, factor)], {}
    for name, (worse, looks, false_corners) in HARDSHIPS.items():
        if worse == factor:
            ways = replace(WHOLE, false_corners=false_corners)
            for algorithm, make in ALGORITHMS.items():
                scores[name, algorithm] = run(reads, make, ways, seed, looks)
    return scores


def main(jobs: int = 2) -> Result:
    """Render what is missing, and run all drives under all hardships."""
    found: dict[tuple[str, str], list[Score]] = {}
    for factor in (1.0, 2.0):
        prepare(FRESH, factor, jobs)
        with ProcessPoolExecutor(jobs) as pool:
            waiting = pool.map(partial(scores_of, factor=factor), FRESH)
            for scores in track(waiting, f"hard drives, odometry {factor:g}", len(FRESH)):
                for each, score in scores.items():
                    found.setdefault(each, []).append(score)
    return result(found)


def result(scores: Mapping[tuple[str, str], Sequence[Score]]) -> Result:
    """The table of some drives, by hardship and algorithm."""
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
