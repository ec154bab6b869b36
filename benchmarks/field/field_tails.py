"""The complete robot on drives under hard conditions: few pictures, false corners, and odometry worse than stated.

``python -m benchmarks field_tails`` compares the student's filter, updated with a stop's best compass first, with the
same filter inside of `JointUpdate` and `MultipleHypotheses`. Drives that end far from the truth are listed with the
stop after which the estimate was wrong, and its pictures are in ``build/lost_drives.jpg``.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from typing import NamedTuple

import cv2
from matplotlib.figure import Figure
from rich.progress import track

from benchmarks import BUILD, Result, Table
from benchmarks.field.field_slam.algorithms import FILTER, Make, joint_update, surest_first, with_hypotheses
from benchmarks.field.field_slam.detections import detections, prepare, shots
from benchmarks.field.field_slam.report import BEST, summary
from benchmarks.field.field_slam.variants import Options, Read, Score, run
from nao_course.field_slam.demo.drive import JOINT_CORNER_SIGMA
from nao_course.metrics import band

# Nothing was tuned on these drives. JointUpdate and MultipleHypotheses were tuned on drives 200 to 229.
FRESH = {1.0: range(1000, 1200), 2.0: range(800, 1000)}


class Hardship(NamedTuple):
    """A condition of the drives.

    Parameters
    ----------
    factor : float
        True divided by stated standard deviations of the odometry.
    frames : int
        Pictures at each stop, 1 or 3.
    false_corners : float
        Mean number of false corners that are added to a picture.
    """

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
LOST = 0.15  # m
MOST_SHOWN = 12  # lost drives in the picture
Scores = Mapping[tuple[str, str], Mapping[int, Score]]


def scores_of(seed: int, factor: float) -> dict[tuple[str, str], Score]:
    """Run a drive under each hardship with this odometry."""
    cv2.setNumThreads(1)
    reads, scores = [Read.of(seen) for seen in detections(seed, factor)], {}
    for name, hardship in HARDSHIPS.items():
        if hardship.factor == factor:
            for algorithm, (options, make) in ALGORITHMS.items():
                chosen = replace(options, false_corners=hardship.false_corners)
                scores[name, algorithm] = run(reads, make, chosen, seed, hardship.frames)
    return scores


def main(jobs: int = 2) -> Result:
    """Render what is missing, run all drives under all hardships, and draw the lost ones."""
    found: dict[tuple[str, str], dict[int, Score]] = {}
    for factor, seeds in FRESH.items():
        prepare(seeds, factor, jobs)
        with ProcessPoolExecutor(jobs) as pool:
            waiting = pool.map(partial(scores_of, factor=factor), seeds)
            of_drives = track(waiting, f"drives, odometry noise x {factor:g}", len(seeds))
            for seed, scores in zip(seeds, of_drives, strict=True):
                for each, score in scores.items():
                    found.setdefault(each, {})[seed] = score
    return result(found)


def result(scores: Scores) -> Result:
    """Return the tables of the drives by hardship and algorithm, and of the lost drives."""
    found = {", ".join(each): summary(list(of.values())) for each, of in scores.items()}
    keys = ("drives", "position", "position 95 %", "position worst", "heading", "NEES mean", "wrong", "lost")
    columns = ("hardship", "drives", "position m", "95 %", "worst", "heading", "NEES", "wrong", "lost")
    rows = tuple((name, *(f"{of[key]:.3g}" for key in keys)) for name, of in found.items())
    lost = {
        (*each, seed): score
        for each, of in scores.items()
        for seed, score in of.items()
        if score.position > LOST
    }
    _draw({key: score for key, score in lost.items() if key[1] == "several hypotheses"})
    of_lost = tuple(
        (*key[:2], str(key[2]), f"{score.position:.2f}", _stop(score)) for key, score in lost.items()
    )
    low, high = band(3, len(FRESH[1.0]))
    note = f"95 % band of the mean NEES of {len(FRESH[1.0])} drives: {low:.2f} to {high:.2f}"
    tables = (
        Table("after 61 stops", columns, rows),
        Table("lost drives", ("hardship", "algorithm", "seed", "position m", "misled at stop"), of_lost),
    )
    values = {
        "conditions": found,
        "NEES band": (low, high),
        "lost": [
            dict(zip(("hardship", "algorithm", "seed"), key, strict=True), stop=score.misled)
            for key, score in lost.items()
        ],
    }
    return Result("field_tails", values, tables, (note,))


def _stop(score: Score) -> str:
    return "none: uncertain to the end" if score.misled < 0 else str(score.misled)


def _draw(lost: Mapping[tuple[str, str, int], Score]) -> None:
    """Draw the pictures of the stop that misled each lost drive, one drive in each row."""
    shown = {key: score for key, score in lost.items() if score.misled >= 0}
    if not shown:
        return
    chosen = list(shown.items())[:MOST_SHOWN]
    figure = Figure(figsize=(12, 3.4 * len(chosen)), layout="constrained")
    axes = figure.subplots(len(chosen), 3, squeeze=False)
    for row, ((hardship, _, seed), score) in zip(axes, chosen, strict=True):
        pictures = shots(seed, HARDSHIPS[hardship].factor)[3 * score.misled : 3 * score.misled + 3]
        for ax, shot in zip(row, pictures, strict=True):
            ax.imshow(shot.picture.pixels)
            ax.set(xticks=[], yticks=[])
        row[0].set_title(f"{hardship}, seed {seed}, stop {score.misled}", loc="left")
    BUILD.mkdir(exist_ok=True)
    figure.savefig(BUILD / "lost_drives.jpg", dpi=70)
