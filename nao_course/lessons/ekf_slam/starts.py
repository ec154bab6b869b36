"""Two ways to begin a map, the homework's and the textbook's, from a first pose that is not quite known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.datasets import HomeworkLog
from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.lessons.ekf_slam.homework_log import (
    OWN_SIGMAS,
    START_COVARIANCE,
    Belief,
    Function,
    LogRun,
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

DRIVES = 40
SHOWN = 18  # which of the drives is on the map
HOMEWORK, TEXTBOOK = STYLES["odometry"].colour, STYLES["ekf"].colour


@dataclass(frozen=True, eq=False)
class Start:
    """A pentagon whose first pose is not quite what the robot believes: zeros.

    Parameters
    ----------
    log : HomeworkLog
        Controls and measurements.
    path : ndarray, shape (M + 1, 3)
        True poses, in the frame in which the robot believes to begin at zeros.
    landmarks : ndarray, shape (k, 2)
        True, m.
    """

    log: HomeworkLog
    path: FloatArray
    landmarks: FloatArray

    def nees(self, run: LogRun) -> FloatArray:
        """Normalised estimation error squared of each pose, (M + 1,)."""
        off = run.states[:, :3] - self.path
        off[:, 2] = wrap_angle(off[:, 2])
        return squared_distances(off, run.covariances[:, :3, :3])

    def map_error(self, run: LogRun) -> float:
        """Mean distance of the landmarks from the truth at the end, m."""
        return float(np.hypot(*(run.landmarks - self.landmarks).T).mean())


@cache
def doubtful_start(seed: int) -> Start:
    """Drive a pentagon from a first pose that is drawn from what the robot believes of it."""
    recording = record_pentagon(seed)
    error = np.random.default_rng([7, seed]).standard_normal(3) * np.sqrt(np.diag(START_COVARIANCE))
    first = Pose.from_array(error)
    path = np.array([(first @ Pose.from_array(pose)).as_array() for pose in recording.path])
    return Start(recording.log, path, first.to_parent(recording.landmarks))


def run_all(start: Callable[[HomeworkLog], Belief], predict: Function, update: Function) -> list[LogRun]:
    """Run a student's filter along all drives, each begun by ``start(log)``."""
    logs = (doubtful_start(seed).log for seed in range(DRIVES))
    return [run_log(log, start(log), predict, update, OWN_SIGMAS) for log in logs]


def mean_nees(runs: list[LogRun]) -> FloatArray:
    """Mean NEES of the pose over all drives, for each step (M + 1,)."""
    return np.asarray(np.mean([doubtful_start(seed).nees(run) for seed, run in enumerate(runs)], axis=0))


def final_nees(init_landmarks: Function, predict: Function, update: Function) -> float:
    """Mean NEES of the pose at the end, of drives that are begun as the homework does."""
    runs = run_all(lambda log: homework_start(log, init_landmarks, OWN_SIGMAS), predict, update)
    return float(mean_nees(runs)[-1])


def draw_starts(
    init_landmarks: Function, add_landmark: Function, predict: Function, update: Function
) -> Drawing:
    """Draw what a map that is begun as if the pose were certain does to a filter's honesty.

    Parameters
    ----------
    init_landmarks, add_landmark, predict, update : callable
        The student's.

    Returns
    -------
    Drawing
        NEES over the steps of 40 drives, begun in both ways; and the map of one of them at its end.
    """
    runs = {
        "homework": run_all(lambda log: homework_start(log, init_landmarks, OWN_SIGMAS), predict, update),
        "textbook": run_all(lambda log: textbook_start(log, add_landmark, OWN_SIGMAS), predict, update),
    }
    drives = [doubtful_start(seed) for seed in range(DRIVES)]
    nees = {way: mean_nees(each) for way, each in runs.items()}
    colours = {"homework": HOMEWORK, "textbook": TEXTBOOK}
    names = {"homework": "as the homework", "textbook": "with add_landmark"}
    low, high = band(3, DRIVES)
    with course_style():
        figure = Figure(figsize=(10.4, 4.4))
        left, right = figure.subplots(1, 2, width_ratios=(1.15, 1))
        left.axhspan(low, high, color="#e3e5e8", zorder=0, label="95 % band")
        for way, values in nees.items():
            marker = STYLES["odometry" if way == "homework" else "ekf"].marker
            left.semilogy(values, color=colours[way], marker=marker, ms=4, lw=1.3, label=names[way])
        left.set(xlabel="step", ylabel="mean NEES of the pose (ideal: 3)")
        left.set_title(f"{DRIVES} drives")
        left.legend(fontsize=9)
        one = drives[SHOWN]
        outlines = {
            way: ellipse_outlines(each[SHOWN].landmarks, each[SHOWN].landmark_covariances)
            for way, each in runs.items()
        }
        for way, shapes in outlines.items():
            right.add_collection(filled_outlines(shapes, colours[way]))
        right.plot(*one.landmarks.T, "o", color=STYLES["truth"].colour, ms=4, zorder=5)
        metric_axes(right, np.concatenate([*outlines["textbook"], *outlines["homework"]]), margin=0.1)
        right.set_title("The map of one, 95 %")
        truth = Line2D([], [], marker="o", color=STYLES["truth"].colour, ls="", ms=4, label="landmark, true")
        legend_below(figure, [truth])
    last = {way: float(values[-1]) for way, values in nees.items()}
    inside = {way: _inside(each[SHOWN], one.landmarks) for way, each in runs.items()}
    all_inside = {
        way: sum(
            _inside(run, drive.landmarks) == drive.log.k for run, drive in zip(each, drives, strict=True)
        )
        for way, each in runs.items()
    }
    errors = [
        np.mean([drive.map_error(run) for drive, run in zip(drives, each, strict=True)])
        for each in runs.values()
    ]
    return Drawing(
        figure,
        f"Mean NEES of the pose over {DRIVES} drives whose first pose is not quite known. At the end it is "
        f"{last['homework']:.0f} for maps begun as the homework does, {last['textbook']:.1f} with add_landmark; the "
        f"band is {low:.2f} to {high:.2f}. Landmarks are {100 * errors[0]:.0f} and {100 * errors[1]:.0f} cm off on "
        f"average. In {all_inside['homework']} and {all_inside['textbook']} drives all true landmarks lie inside "
        f"their ellipses. In the map of one, {inside['homework']} of {one.log.k} true landmarks lie inside those "
        f"of the first, and {inside['textbook']} inside those of the second.",
    )


def _inside(run: LogRun, truth: FloatArray) -> int:
    """How many true landmarks lie inside their 95 % ellipses at the end."""
    return int(
        (squared_distances(run.landmarks - truth, run.landmark_covariances) <= band(2, 1, 0.9)[1]).sum()
    )
