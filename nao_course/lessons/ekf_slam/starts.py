"""Compare two initialisations of a map, the homework's and the textbook's, from an uncertain first pose."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.datasets import HomeworkLog
from nao_course.geometry import FloatArray, Pose, pose_errors
from nao_course.lessons.ekf_slam.homework_log import (
    OWN_SIGMAS,
    START_COVARIANCE,
    LogRun,
    Recording,
    homework_start,
    record_pentagon,
    run_log,
    textbook_start,
)
from nao_course.metrics import band, squared_distances
from nao_course.plotting import STYLES, Drawing, course_style, ellipse_outlines
from nao_course.plotting.ellipses import filled_outlines
from nao_course.plotting.legends import legend_below
from nao_course.plotting.maps import metric_axes
from nao_course.sim.drives import Belief, Function

DRIVES = 40
SHOWN = 18  # number of the drive that the map shows
HOMEWORK, TEXTBOOK = STYLES["odometry"].colour, STYLES["ekf"].colour


class Start(Recording):
    """A pentagon whose true first pose differs from the estimate, which is the origin."""

    def nees(self, run: LogRun) -> FloatArray:
        """Return the normalised estimation error squared of each pose, (M + 1,)."""
        return squared_distances(pose_errors(run.states[:, :3], self.path), run.covariances[:, :3, :3])

    def map_error(self, run: LogRun) -> float:
        """Return the mean error of the landmarks at the end, m."""
        return float(np.hypot(*(run.landmarks - self.landmarks).T).mean())


@cache
def uncertain_start(seed: int) -> Start:
    """Drive a pentagon from a first pose that is drawn from the filter's first covariance."""
    recording = record_pentagon(seed)
    error = np.random.default_rng([7, seed]).standard_normal(3) * np.sqrt(np.diag(START_COVARIANCE))
    first = Pose.from_array(error)
    path = np.array([(first @ Pose.from_array(pose)).as_array() for pose in recording.path])
    return Start(recording.log, path, first.to_parent(recording.landmarks))


def run_all(start: Callable[[HomeworkLog], Belief], predict: Function, update: Function) -> list[LogRun]:
    """Run a student's filter along all drives, each initialised by ``start(log)``."""
    logs = (uncertain_start(seed).log for seed in range(DRIVES))
    return [run_log(log, start(log), predict, update, OWN_SIGMAS) for log in logs]


def mean_nees(runs: list[LogRun]) -> FloatArray:
    """Return the mean NEES of the pose over all drives for each step, (M + 1,)."""
    return np.asarray(np.mean([uncertain_start(seed).nees(run) for seed, run in enumerate(runs)], axis=0))


@course_style()
def draw_starts(
    init_landmarks: Function, add_landmark: Function, predict: Function, update: Function
) -> Drawing:
    """Draw the consistency of a filter after the homework's initialisation and after the textbook's.

    Parameters
    ----------
    init_landmarks, add_landmark, predict, update : callable
        The student's functions.

    Returns
    -------
    Drawing
        NEES over the steps of 40 drives with both initialisations, and the map of one drive at its end.
    """
    runs = {
        "homework": run_all(lambda log: homework_start(log, init_landmarks, OWN_SIGMAS), predict, update),
        "textbook": run_all(lambda log: textbook_start(log, add_landmark, OWN_SIGMAS), predict, update),
    }
    drives = [uncertain_start(seed) for seed in range(DRIVES)]
    nees = {variant: mean_nees(each) for variant, each in runs.items()}
    colours = {"homework": HOMEWORK, "textbook": TEXTBOOK}
    names = {"homework": "with init_landmarks", "textbook": "with add_landmark"}
    maps = {variant: _maps(each, drives) for variant, each in runs.items()}
    low, high = band(3, DRIVES)
    figure = Figure(figsize=(10.4, 4.4))
    left, right = figure.subplots(1, 2, width_ratios=(1.15, 1))
    left.axhspan(low, high, color="#e3e5e8", zorder=0, label="95 % band")
    for variant, values in nees.items():
        marker = STYLES["odometry" if variant == "homework" else "ekf"].marker
        left.semilogy(values, color=colours[variant], marker=marker, ms=4, lw=1.3, label=names[variant])
        off, inside = maps[variant]
        left.annotate(
            f"maps {100 * off:.0f} cm off, all landmarks inside in {inside}",
            (len(values) - 1, values[-1]),
            (0, -14 if variant == "homework" else 10),
            textcoords="offset points",
            ha="right",
            fontsize=9,
        )
    left.set(xlabel="step", ylabel="mean NEES of the pose (ideal: 3)")
    left.set_title(f"{DRIVES} drives")
    left.legend(fontsize=9)
    one = drives[SHOWN]
    outlines = {
        variant: ellipse_outlines(each[SHOWN].landmarks, each[SHOWN].landmark_covariances)
        for variant, each in runs.items()
    }
    for variant, shapes in outlines.items():
        right.add_collection(filled_outlines(shapes, colours[variant]))
    right.plot(*one.landmarks.T, "o", color=STYLES["truth"].colour, ms=4, zorder=5)
    metric_axes(right, np.concatenate([*outlines["textbook"], *outlines["homework"]]), margin=0.1)
    right.set_title("The map of one drive, 95 % ellipses")
    truth = Line2D([], [], marker="o", color=STYLES["truth"].colour, ls="", ms=4, label="landmark, true")
    variants = [
        Line2D([], [], color=colours[variant], lw=2, label=f"landmark, {names[variant]}") for variant in runs
    ]
    legend_below(figure, [truth, *variants])
    return Drawing(figure, _say_starts(runs, drives, nees, maps))


def _maps(runs: Sequence[LogRun], drives: Sequence[Start]) -> tuple[float, int]:
    """Return the maps' mean error (m), and the number of drives with all true landmarks inside their ellipses."""
    each = list(zip(drives, runs, strict=True))
    off = np.mean([drive.map_error(run) for drive, run in each])
    return float(off), sum(_inside(run, drive.landmarks) == drive.log.k for drive, run in each)


def _say_starts(
    runs: Mapping[str, Sequence[Any]],
    drives: Sequence[Any],
    nees: Mapping[str, Any],
    maps: Mapping[str, tuple[float, int]],
) -> str:
    """Describe consistency and errors of both initialisations in words."""
    low, high = band(3, DRIVES)
    one = drives[SHOWN]
    last = {variant: float(values[-1]) for variant, values in nees.items()}
    inside = {variant: _inside(each[SHOWN], one.landmarks) for variant, each in runs.items()}
    return (
        f"Mean NEES of the pose over {DRIVES} drives with an uncertain first pose. At the end it is "
        f"{last['homework']:.0f} with init_landmarks and {last['textbook']:.1f} with add_landmark; the "
        f"band is {low:.2f} to {high:.2f}. Landmarks are {100 * maps['homework'][0]:.0f} and "
        f"{100 * maps['textbook'][0]:.0f} cm off on "
        f"average. In {maps['homework'][1]} and {maps['textbook'][1]} drives all true landmarks lie inside "
        f"their ellipses. In the map of one drive, {inside['homework']} of {one.log.k} true landmarks lie "
        f"inside their ellipses with init_landmarks, and {inside['textbook']} with add_landmark."
    )


def _inside(run: LogRun, truth: FloatArray) -> int:
    """Return how many true landmarks lie inside their 95 % ellipses at the end."""
    return int(
        (squared_distances(run.landmarks - truth, run.landmark_covariances) <= band(2, 1, 0.9)[1]).sum()
    )
