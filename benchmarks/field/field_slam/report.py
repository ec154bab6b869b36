"""Table and figure of the errors of every variant, with their tails."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, replace
from functools import partial
from typing import Any

import cv2
import matplotlib.pyplot as plt
import numpy as np
from rich.progress import track

from benchmarks import BUILD, Result, Table
from benchmarks.field.field_slam.algorithms import (
    FILTER,
    GRAPH,
    BentRanges,
    Make,
    NewOnesAlone,
    Refusing,
    by_nearest_neighbour,
    jointly,
    surest_first,
)
from benchmarks.field.field_slam.detections import detections, prepare
from benchmarks.field.field_slam.variants import Options, Read, Score, run
from nao_course.lessons.slam_on_the_field.variants import RECORDED
from nao_course.metrics import band

FRESH = range(400, 500)  # drives that nothing was tuned on
SEEN = range(300, 400)  # what the compass believes of short lines was found on these
BEST = Options(lines=True, compass=True)
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
    "EKF, posts without the extra 2 cm": (Options(lines=True, compass=True, post_sigma=0.0), FILTER, 3),
    "EKF, lesson 03's corners": (Options(corners="lesson 03", lines=True, compass=True), FILTER, 3),
    "EKF, one picture at a stop": (BEST, FILTER, 1),
    "graph, one picture at a stop": (BEST, GRAPH, 1),
    "EKF, 0.3 false corners a picture": (replace(BEST, false_corners=0.3), FILTER, 3),
}
TWICE = "EKF, odometry twice as bad as stated"
AGAIN = (
    "compass: the complete EKF",
    "graph",
    "EKF, best compass of a stop first",
    "graph, best compass of a stop first",
    "EKF, one picture at a stop",
)


def scores_of(seed: int, factor: float, names: Sequence[str]) -> dict[str, Score]:
    """Run the named variants over a drive; with worse odometry, run the complete EKF only."""
    cv2.setNumThreads(1)
    reads = [Read.of(seen) for seen in detections(seed, factor)]
    if factor != 1:
        return {TWICE: run(reads, FILTER, BEST, seed)}
    chosen = {name: VARIANTS[name] for name in names}
    return {
        name: run(reads, make, options, seed, pictures) for name, (options, make, pictures) in chosen.items()
    }


def all_scores(
    seeds: Sequence[int], factor: float = 1.0, names: Sequence[str] = tuple(VARIANTS), jobs: int = 2
) -> dict[str, list[Score]]:
    """Run the named variants over the same drives, with a progress bar."""
    prepare(seeds, factor, jobs)
    with ProcessPoolExecutor(jobs) as pool:
        waiting = pool.map(partial(scores_of, factor=factor, names=names), seeds)
        found = list(track(waiting, f"variants, odometry {factor:g}", len(seeds)))
    return {name: [each[name] for each in found] for name in found[0]}


def summary(scores: Sequence[Score]) -> dict[str, float]:
    """Return medians and tails over drives; `lost` is the share of drives that end more than 0.15 m off."""
    each = {name: np.array([asdict(score)[name] for score in scores]) for name in asdict(scores[0])}
    position = each["position"]
    return {
        "drives": len(scores),
        "position": float(np.median(position)),
        "position 95 %": float(np.quantile(position, 0.95)),
        "position worst": float(position.max()),
        "heading": float(np.median(each["heading"])),
        "landmarks": float(np.median(each["landmarks"])) if np.isfinite(each["landmarks"]).all() else 0.0,
        "NEES mean": float(each["nees"].mean()),
        "NEES median": float(np.median(each["nees"])),
        "on the map": float(each["on_map"].mean()),
        "wrong": float(each["wrong"].mean()),
        "lost": float((position > 0.15).mean()),
    }


def for_the_lesson(scores: Mapping[str, Sequence[Score]]) -> list[dict[str, Any]]:
    """Return what the lesson shows of each variant: errors of each drive, m and degrees, and its NEES."""
    digits = {"position": 4, "heading": 3, "landmarks": 4, "nees": 2}
    return [
        {"variant": name}
        | {
            key: [round(getattr(each, key), places) for each in of if np.isfinite(getattr(each, key))]
            for key, places in digits.items()
        }
        for name, of in scores.items()
    ]


def main() -> Result:
    """Render what is missing, run all variants, draw the figure, and write what the lesson shows."""
    scores = all_scores(FRESH) | all_scores(FRESH, 2.0)
    RECORDED.write_text(json.dumps(for_the_lesson(scores)).replace("}, {", "},\n {") + "\n", encoding="utf-8")
    found = {name: summary(each) for name, each in scores.items()}
    again = {name: summary(each) for name, each in all_scores(SEEN, names=AGAIN).items()}
    low, high = band(3, len(FRESH))
    _draw({name: [score.position for score in each] for name, each in scores.items()})
    tables = (
        _table(f"end of {len(FRESH)} drives of 61 stops", found),
        _table(f"of {len(SEEN)} others", again),
    )
    note = f"95 % band of the mean NEES of {len(FRESH)} drives: {low:.2f} to {high:.2f}; its median should be 2.37"
    values: dict[str, Any] = {"variants": found, "NEES band": (low, high), "others": again}
    return Result("field_slam", values, tables, (note,))


def _table(title: str, found: Mapping[str, Mapping[str, float]]) -> Table:
    """Return a table with a row for each variant."""
    columns = (
        "variant",
        "drives",
        "position m",
        "95 %",
        "worst",
        "heading",
        "landmarks",
        "NEES",
        "median",
        "lost",
    )
    keys = (
        *("drives", "position", "position 95 %", "position worst"),
        *("heading", "landmarks", "NEES mean", "NEES median", "lost"),
    )
    rows = tuple((name, *(f"{of[key]:.3g}" for key in keys)) for name, of in found.items())
    return Table(title, columns, rows)


def _draw(positions: Mapping[str, Sequence[float]]) -> None:
    """Draw the final position errors of all drives, with a row for each variant."""
    figure, axes = plt.subplots(figsize=(9, 5.2), layout="constrained")
    names = list(positions)[::-1]
    for row, name in enumerate(names):
        each = np.array(positions[name])
        axes.plot(each, np.full(len(each), row), "|", color="#0b5fa5", markersize=9, alpha=0.6)
        axes.plot(np.median(each), row, "o", color="#b3261e", markersize=5)
    axes.set_yticks(range(len(names)), names, fontsize=8)
    axes.set_xscale("log")
    axes.set_xlabel("position error at the end of a drive (m); a bar each drive, a dot their median")
    axes.axvline(0.02, color="#777777", linewidth=0.8, linestyle=":")
    axes.grid(axis="x", alpha=0.3)
    BUILD.mkdir(exist_ok=True)
    figure.savefig(BUILD / "field_slam.png", dpi=110)
    plt.close(figure)
