"""Corners: the paper's detector and two better ones, on simulated and on real pictures, and what each step brings.

``python -m benchmarks corners`` prints the tables; images/make.py draws the steps as recorded. All values were
chosen on the simulator's tuning sets and the 8 scenes that are also there at 1280 x 960; the 56 others, the walk, and
the simulator's sets "report" and "whole" only report.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from benchmarks import RESULTS, Result, Table
from benchmarks.challenges.corners import find_corners_better, find_corners_on_ground
from benchmarks.challenges.corners.in_picture import CHOSEN as CHOSEN_IN_PICTURE
from benchmarks.challenges.corners.on_ground import CHOSEN as CHOSEN_ON_GROUND
from benchmarks.pictures import paper_detector as paper
from benchmarks.simulator.reality import SET_VALUES, fitted_view
from nao_course.datasets import PictureSet, RealPicture, read_pictures
from nao_course.geometry import FloatArray
from nao_course.metrics import CornerTruth, corner_cost, mean_interval, total
from nao_course.sim import CameraView, standard_scenes
from nao_course.sim.scenes import SceneSet

RUNS = 3
# Of each set's camera, as docs/real_data.md has them with square pixels: height (m), fields of view, lens, offset of
# the pitch (rad). They are a calibration, of no picture on its own.
CALIBRATED: Mapping[PictureSet, tuple[float, ...]] = {
    "scenes": (0.479, np.radians(59.5), np.radians(46.5), -0.088, np.radians(5.4)),
    "straightwalk": (0.479, np.radians(59.1), np.radians(46.0), -0.025, np.radians(6.4)),
}


@dataclass(frozen=True, eq=False)
class Case:
    """A picture (H, W, 3), what a robot believes of its camera, and the corners."""

    pixels: npt.NDArray[np.uint8]
    view: CameraView
    truth: CornerTruth


Detector = Callable[[npt.NDArray[np.uint8], CameraView], FloatArray]


def simulated(which: SceneSet) -> list[Case]:
    """Return one of the simulator's standard sets."""
    return [Case(scene.pixels, scene.view, CornerTruth.of(scene.truth)) for scene in standard_scenes(which)]


def real(pictures: Sequence[RealPicture], which: PictureSet) -> list[Case]:
    """Return real pictures with the corners that were marked by hand."""
    values = np.array(CALIBRATED[which])
    assert len(values) == len(SET_VALUES)
    return [
        Case(each.pixels, fitted_view(each, values, np.zeros(3))[0], CornerTruth.marked(each.points))
        for each in pictures
    ]


def tuning_sets() -> dict[str, list[Case]]:
    """Return the sets on which values were chosen, with the real scenes if they are available."""
    sets = {"simulator, near": simulated("tune"), "simulator, whole field": simulated("whole_tune")}
    with suppress(FileNotFoundError):
        sets["8 real scenes"] = real([each for each in read_pictures("scenes") if each.has_large], "scenes")
    return sets


def reporting_sets() -> dict[str, list[Case]]:
    """Return the sets that are used only for reporting."""
    sets = {"simulator, reporting set": simulated("report"), "simulator, whole field": simulated("whole")}
    with suppress(FileNotFoundError):
        others = [each for each in read_pictures("scenes") if not each.has_large]
        sets["the other 56 real scenes"] = real(others, "scenes")
        sets["real straight walk"] = real(read_pictures("straightwalk"), "straightwalk")
    return sets


def nothing(picture: npt.NDArray[np.uint8], view: CameraView) -> FloatArray:
    """Find no corner."""
    return np.zeros((0, 2))


def papers(picture: npt.NDArray[np.uint8], view: CameraView) -> FloatArray:
    """Detect corners by Aliyev et al. 2014, with the best values of its Table A.1."""
    hls = np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2HLS), dtype=np.uint8)
    labels = paper.color_labels(hls, paper.white_threshold(hls[..., 1]), paper.Hues())
    return paper.find_corners(labels)


def in_picture(picture: npt.NDArray[np.uint8], view: CameraView) -> FloatArray:
    """Detect corners with lesson 03's better detector, which uses only the picture."""
    return find_corners_better(picture)


DETECTORS: Mapping[str, Detector] = {
    "nothing": nothing,
    "the paper's": papers,
    "better, in the picture": in_picture,
    "better, on the ground": find_corners_on_ground,
}

_GROUND, _PICTURE = CHOSEN_ON_GROUND, CHOSEN_IN_PICTURE
# What is left out of a detector, by the detector.
STEPS: Mapping[str, Mapping[str, Detector]] = {
    "on the ground": {
        "all steps": find_corners_on_ground,
        "no carpet on both sides": partial(
            find_corners_on_ground,
            settings=replace(_GROUND, pieces=replace(_GROUND.pieces, both_sides=False)),
        ),
        "lines of any width": partial(
            find_corners_on_ground, settings=replace(_GROUND, widening=8.0, slack=20.0)
        ),
        "pieces not merged": partial(
            find_corners_on_ground, settings=replace(_GROUND, lines=replace(_GROUND.lines, merged=False))
        ),
        "curves are not left out": partial(find_corners_on_ground, settings=replace(_GROUND, bend=1e6)),
        "no lean": partial(find_corners_on_ground, settings=replace(_GROUND, lean=False)),
        "no right angles": partial(find_corners_on_ground, settings=replace(_GROUND, right_angles=False)),
    },
    "in the picture": {
        "all steps": in_picture,
        "no carpet on both sides": lambda picture, view: find_corners_better(
            picture, replace(_PICTURE, pieces=replace(_PICTURE.pieces, both_sides=False))
        ),
        "lines of any width": lambda picture, view: find_corners_better(
            picture, replace(_PICTURE, widening=1.0, slack=20.0)
        ),
        "pieces not merged": lambda picture, view: find_corners_better(
            picture, replace(_PICTURE, lines=replace(_PICTURE.lines, merged=False))
        ),
        "curves are not left out": lambda picture, view: find_corners_better(
            picture, replace(_PICTURE, bend=1e6)
        ),
    },
}


@dataclass(frozen=True)
class Score:
    """What a detector finds in a set: counts, mean cost with its 95 % bootstrap interval, and ms a picture."""

    pictures: int
    hits: int
    false: int
    missed: int
    cost: float
    low: float
    high: float
    median_ms: float
    most_ms: float

    @classmethod
    def of(cls, detector: Detector, cases: Sequence[Case]) -> Score:
        """Run a detector over a set; a picture's time is the processor's, the median of three runs."""
        matches, times = [], []
        for case in cases:
            tries = []
            for _ in range(RUNS):
                start = time.process_time()
                found = detector(case.pixels, case.view)
                tries.append(1000 * (time.process_time() - start))
            times.append(np.median(tries))
            matches.append(case.truth.match(found))
        costs, summed = [corner_cost(each) for each in matches], total(matches)
        median, most = np.quantile(times, [0.5, 0.95]).tolist()
        return cls(
            len(cases),
            *(summed.hits, summed.false, summed.missed),
            float(np.mean(costs)),
            *mean_interval(costs),
            *(median, most),
        )


def draw_steps(scores: Mapping[str, Mapping[str, Score]]) -> Figure:
    """Draw the mean cost of each detector on all tuning pictures, complete and with one step left out."""
    figure = Figure(figsize=(9.0, 3.4), layout="constrained")
    for axes, (name, steps) in zip(figure.subplots(1, len(scores)), scores.items(), strict=True):
        at = np.arange(len(steps))[::-1]
        for y, (step, score) in zip(at, steps.items(), strict=True):
            colour = "#0072b2" if step == "all steps" else "#999999"
            axes.barh(y, score.cost, color=colour, height=0.65)
            axes.plot([score.low, score.high], [y, y], color="black", linewidth=1)
        axes.set_yticks(at, list(steps))
        axes.axvline(next(iter(steps.values())).cost, color="#0072b2", linewidth=0.8, linestyle=":")
        axes.axvline(0, color="black", linewidth=0.8)
        axes.set_xlabel("mean cost of a picture (lower is better)")
        axes.set_title(f"corners {name}")
        axes.spines[["top", "right"]].set_visible(False)
    return figure


def recorded_steps() -> dict[str, dict[str, Score]]:
    """Return the recorded costs of each detector, complete and with one step left out."""
    values = json.loads((RESULTS / "corners.json").read_text(encoding="utf-8"))
    return {
        name: {step: Score(**score) for step, score in values[f"steps, {name}"].items()} for name in STEPS
    }


def _rows(scores: Mapping[str, Score]) -> tuple[tuple[object, ...], ...]:
    return tuple(
        (
            name,
            f"{s.hits} / {s.false} / {s.missed}",
            s.cost,
            f"{s.low:.2f} to {s.high:.2f}",
            s.median_ms,
            s.most_ms,
        )
        for name, s in scores.items()
    )


COLUMNS = ("", "hits / false / missed", "mean cost", "95 %", "ms, median", "ms, 95 %")


def main() -> Result:
    """Score all detectors on all sets, leave each step out on the tuning sets, and draw what that costs."""
    tuning = tuning_sets()
    tables, values = list[Table](), dict[str, Any]()
    for title, cases in (
        {f"chosen on: {name}": each for name, each in tuning.items()} | reporting_sets()
    ).items():
        scores = {name: Score.of(detector, cases) for name, detector in DETECTORS.items()}
        tables.append(Table(f"{title}, {len(cases)} pictures", COLUMNS, _rows(scores)))
        values[title] = {name: asdict(score) for name, score in scores.items()}
    every = [case for cases in tuning.values() for case in cases]
    steps = {
        name: {step: Score.of(detector, every) for step, detector in detectors.items()}
        for name, detectors in STEPS.items()
    }
    for name, scores in steps.items():
        tables.append(
            Table(f"steps left out, {name}, on the {len(every)} tuning pictures", COLUMNS, _rows(scores))
        )
        values[f"steps, {name}"] = {step: asdict(score) for step, score in scores.items()}
    return Result(
        "corners", values, tuple(tables), ("what each step brings: python images/make.py corner_steps",)
    )
