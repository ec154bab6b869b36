"""How far off distances are on a real robot's pictures, after one calibration: lesson 04's functions on marked points.

Ten pictures tell the constant offset of the camera's pitch; all others are measured with it. Which landmark a marked
point is comes from `benchmarks/simulator/reality.py`; where it is, from the robot's pose as it was set by hand.
The pictures choose nothing else: the camera is the maker's, its lens term that of the library.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from benchmarks import Result, Table, solution
from benchmarks.simulator.reality import corrected_walk, fit_set
from nao_course.datasets import RealPicture, read_pictures
from nao_course.geometry import FloatArray
from nao_course.lessons.distance.calibration import EDGES, Marked, by_distance, range_errors
from nao_course.sim import NAO_V4, CameraView

OWN = solution("04")
CALIBRATED_ON = 10  # pictures
SETS = {"real scenes": "scenes", "real walk": "straightwalk"}


def exact_distance(pixels: FloatArray, view: CameraView) -> FloatArray:
    """Return the distance from the robot by the lesson's exact geometry."""
    return np.asarray(OWN["ground_to_measurement"](OWN["pixel_to_ground"](pixels, view))[:, 1])


METHODS = {"the paper's formula": OWN["paper_distance"], "exact": exact_distance}


def marked(pictures: Sequence[RealPicture]) -> list[Marked]:
    """Return the landmarks on the ground in all pictures with at least four marked points, with the maker's view."""
    found = []
    for item in fit_set(pictures).matched:
        ground = item.landmarks[:, 2] == 0
        view = NAO_V4.view("bottom", item.picture.head_yaw, item.picture.head_pitch)
        found.append(
            Marked(item.pixels[ground], item.picture.pose.to_local(item.landmarks[ground, :2]), view)
        )
    return found


def split(pictures: Sequence[Marked]) -> tuple[list[Marked], list[Marked]]:
    """Split a set into ten evenly spread pictures for calibration, and the others."""
    chosen = set(np.linspace(0, len(pictures) - 1, CALIBRATED_ON).round().astype(int).tolist())
    return [each for i, each in enumerate(pictures) if i in chosen], [
        each for i, each in enumerate(pictures) if i not in chosen
    ]


def offset_of(pictures: Sequence[Marked]) -> float:
    """Return the constant offset of the camera, rad: the median over pictures."""
    return float(np.median([OWN["estimate_pitch"](each.pixels, each.ground, each.view) for each in pictures]))


def measured(which: str) -> tuple[float, dict[str, tuple[FloatArray, FloatArray]]]:
    """Return the offset of a set of real pictures, and (true, errors) of the others' distances by each method."""
    pictures = read_pictures(which)  # type: ignore[arg-type]
    ten, others = split(marked(corrected_walk(pictures) if which == "straightwalk" else pictures))
    offset = offset_of(ten)
    return offset, {name: range_errors(method, others, offset) for name, method in METHODS.items()}


def main() -> Result:
    """Calibrate and measure both sets."""
    rows: list[tuple[Any, ...]] = []
    values: dict[str, Any] = {}
    for title, which in SETS.items():
        offset, errors = measured(which)
        values[title] = {"offset_deg": float(np.degrees(offset))}
        for name, (true, each) in errors.items():
            found = by_distance(true, each)
            values[title][name] = [list(pair) for pair in found]
            numbers = [int(((low <= true) & (true < high)).sum()) for low, high in pairwise(EDGES)]
            rows += [
                (f"{title}, {name}", f"{low:g}-{high:g} m", number, *pair)
                for low, high, number, pair in zip(EDGES[:-1], EDGES[1:], numbers, found, strict=True)
            ]
    table = Table(
        "error of the distance after one calibration, m",
        ("set and method", "distance", "points", "median", "90 %"),
        tuple(rows),
    )
    return Result("distance", values, (table,))
