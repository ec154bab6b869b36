"""Corners: the paper's detector, by lesson 03's functions, and a better one, on simulated and on real pictures.

All values of the better one were chosen on the simulator's tuning sets and the 8 scenes that are also there at
1280 x 960; the 56 others, the walk, and the simulator's sets "report" and "whole" only report.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks import Result, Table, solution
from benchmarks.challenges.corner_detector import find_corners_better
from benchmarks.field.detections import quick_labels
from nao_course.datasets import PictureSet, RealPicture, read_pictures
from nao_course.geometry import FloatArray
from nao_course.metrics import CornerTruth, corner_cost, mean_interval, total
from nao_course.sim import standard_scenes
from nao_course.sim.scenes import SceneSet

Case = tuple[npt.NDArray[np.uint8], CornerTruth]
DETECTORS: Mapping[str, Callable[[npt.NDArray[np.uint8]], FloatArray]] = {
    "nothing": lambda pixels: np.zeros((0, 2)),
    "the paper's": lambda pixels: solution("03")["find_corners"](quick_labels(pixels)),
    "better, in the picture": find_corners_better,
}


def simulated(which: SceneSet) -> list[Case]:
    """Return one of the simulator's standard sets."""
    return [(scene.pixels, CornerTruth.of(scene.truth)) for scene in standard_scenes(which)]


def real(which: PictureSet, wanted: Callable[[RealPicture], bool] = lambda picture: True) -> list[Case]:
    """Return real pictures with the corners that were marked by hand; none where they are not."""
    try:
        pictures = read_pictures(which)
    except FileNotFoundError:
        return []
    return [(each.pixels, CornerTruth.marked(each.points)) for each in pictures if wanted(each)]


def score(detector: Callable[[npt.NDArray[np.uint8]], FloatArray], cases: Sequence[Case]) -> dict[str, float]:
    """Return counts, and the mean cost of a picture with its 95 % bootstrap interval."""
    matches = [truth.match(detector(pixels)) for pixels, truth in cases]
    costs, summed = [corner_cost(each) for each in matches], total(matches)
    low, high = mean_interval(costs)
    counts = {"hits": summed.hits, "false": summed.false, "missed": summed.missed}
    return {"pictures": len(cases), **counts, "cost": float(np.mean(costs)), "low": low, "high": high}


def main() -> Result:
    """Score all detectors on all sets."""
    tuning = {
        "chosen on: simulator, near": simulated("tune"),
        "chosen on: simulator, whole field": simulated("whole_tune"),
        "chosen on: 8 real scenes": real("scenes", lambda picture: picture.has_large),
    }
    sets = tuning | {
        "chosen on: all of these": [case for cases in tuning.values() for case in cases],
        "simulator, reporting set": simulated("report"),
        "simulator, whole field": simulated("whole"),
        "the other 56 real scenes": real("scenes", lambda picture: not picture.has_large),
        "real straight walk": real("straightwalk"),
    }
    values: dict[str, Any] = {
        title: {name: score(detector, cases) for name, detector in DETECTORS.items()}
        for title, cases in sets.items()
        if cases
    }
    return Result("corners", values, tuple(Table.of(title, found) for title, found in values.items()))
