"""How costs grow when the work doubles and when it is ten times as large.

``python -m benchmarks growth`` takes some minutes. Seconds are of a processor, of the process and all that it started.
"""

import os
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from rich.progress import track

from benchmarks import ROOT, Result, Table, solution
from benchmarks.course.grading import lay_out
from benchmarks.course.similar import seconds_of_a_class
from benchmarks.course.waiting import module_seconds
from benchmarks.ekf.ekf_speed import WAYS, milliseconds
from benchmarks.graphs.linear_graphs import sparse
from nao_course.instructor.authoring.course import load_course
from nao_course.lessons.graph_slam.costs import corridor_system
from nao_course.lessons.pose_graphs.worlds import building

TIMES = (1, 2, 10)


def ekf_step(landmarks: int) -> float:
    """Return the seconds of one prediction and one update by lesson 07's filter."""
    return milliseconds(WAYS["new arrays"](landmarks)[0]) / 1000


def linear_solve(variables: int) -> float:
    """Return the seconds of solving a corridor of lesson 08 in a good order."""
    omega, xi = corridor_system(variables, np.random.default_rng(8))
    return milliseconds(lambda: sparse("MMD_AT_PLUS_A")(omega, xi)) / 1000


def optimise(poses: int) -> float:
    """Return the seconds of three steps of lesson 09's `gauss_newton` on a building."""
    world = building(poses=poses)
    return milliseconds(lambda: solution("09")["gauss_newton"](world.graph, world.odometry, 3)) / 1000


def convert(pixels: int) -> float:
    """Return the seconds of lesson 01's conversion of a picture to hue, saturation and lightness."""
    picture = np.random.default_rng(1).integers(0, 256, (120, pixels // 120, 3), dtype=np.uint8)
    return milliseconds(lambda: solution("01")["rgb_to_hsl"](picture)) / 1000


def compare(students: int) -> float:
    """Return the seconds of finding copied work in a class, a fifteenth of which copied."""
    return seconds_of_a_class(load_course(ROOT), students, students // 15)


def grade(notebooks: int, runs: int = 1) -> float:
    """Return the seconds of the last of several runs of the grader on a class of lesson 01."""
    with tempfile.TemporaryDirectory() as folder:
        lay_out(Path(folder, "class"), notebooks)
        words = ("nao_course.cli", "grade", str(Path(folder, "class")), "--out", str(Path(folder, "grades")))
        return [module_seconds(ROOT, *words) for _ in range(runs)][-1]


GROWTH: dict[str, tuple[Callable[[int], float], int]] = {  # and the size that is doubled
    "EKF step, landmarks": (ekf_step, 100),
    "linear graph, variables": (linear_solve, 3000),
    "Gauss-Newton, poses": (optimise, 200),
    "picture to hue, pixels": (convert, 19_200),
    "similar, students": (compare, 30),
    "grade, notebooks": (grade, 2),
    "grade again with nothing new, notebooks": (partial(grade, runs=2), 2),
}


def main() -> Result:
    """Measure each cost at its size, twice and ten times it."""
    os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
    load, rows = os.getloadavg()[0], {}
    for what, (seconds, size) in track(GROWTH.items(), "costs"):
        took = [seconds(size * times) for times in TIMES]
        rows[what] = {"size": float(size), "s": took[0], "x 2": took[1] / took[0], "x 10": took[2] / took[0]}
    note = f"Load of the machine at the beginning: {load:.1f}."
    return Result(
        "growth", {"load": load, "costs": rows}, (Table.of("How costs grow", rows, shown=".4g"),), (note,)
    )
