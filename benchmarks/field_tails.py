"""The field's worst drives: few looks, false corners, odometry worse than told; and what a careful filter does.

``python -m benchmarks field_tails`` uses the drives of ``field_slam``, whose table has the plain filter on them. Three
ideas: a compass asks for lines that agree, a landmark stays that is seen three times, and odometry's noise is learnt
from the compass. On fresh drives the median is that of easy ones; the tails stay open: one drive in ten or so is lost
with false corners or with odometry twice as bad.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from functools import partial

import cv2
from rich.progress import track

from benchmarks import Result, Table
from benchmarks.field_slam.algorithms import FILTER
from benchmarks.field_slam.detections import detections, prepare
from benchmarks.field_slam.report import summary
from benchmarks.field_slam.variants import Read, Score, Ways, run
from nao_course.geometry import Pose
from nao_course.lessons.slam_on_the_field.system.careful import CarefulSlam
from nao_course.lessons.slam_on_the_field.system.compass import LEAST_SUPPORT

FRESH = {1.0: range(100, 200), 2.0: range(100, 130)}  # drives that nothing was tuned on, by odometry's factor
# Name: how much worse odometry is than told, looks a stop, false corners a picture.
HARDSHIPS = {
    "as it is": (1.0, 3, 0.0),
    "one look a stop": (1.0, 1, 0.0),
    "0.3 false corners a picture": (1.0, 3, 0.3),
    "odometry twice as bad and not told": (2.0, 3, 0.0),
}


def careful(start: Pose) -> CarefulSlam:
    """Lesson 11's filter with joint compatibility, and its doubts."""
    return CarefulSlam(FILTER(start))  # type: ignore[arg-type]


def scores_of(seed: int, factor: float) -> dict[str, Score]:
    """Run a drive under each hardship with this odometry."""
    cv2.setNumThreads(1)
    reads, scores = [Read.of(seen, LEAST_SUPPORT) for seen in detections(seed, factor)], {}
    for name, (worse, looks, false_corners) in HARDSHIPS.items():
        if worse == factor:
            ways = Ways(lines=True, compass=True, false_corners=false_corners)
            scores[name] = run(reads, careful, ways, seed, looks)
    return scores


def main(jobs: int = 2) -> Result:
    """Render what is missing, and run all drives under all hardships."""
    scores: list[Mapping[str, Score]] = []
    for factor, seeds in FRESH.items():
        prepare(seeds, factor, jobs)
        with ProcessPoolExecutor(jobs) as pool:
            waiting = pool.map(partial(scores_of, factor=factor), seeds)
            scores += track(waiting, f"hard drives, odometry {factor:g}", len(seeds))
    return result(scores)


def result(scores: Sequence[Mapping[str, Score]]) -> Result:
    """The table of some drives."""
    found = {name: summary([each[name] for each in scores if name in each]) for name in HARDSHIPS}
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
    return Result("field_tails", found, (Table("the careful filter after 61 stops", columns, rows),))
