"""The challenge of lesson 07: know where you are after two laps, and how well you know it, at three times the noise."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from nao_course.challenges import CaseScore, Challenge, Column, Run, recorded_rows
from nao_course.challenges.beliefs import DEEPEST, as_belief, score_belief
from nao_course.geometry import FloatArray, Pose, rotation_2d, wrap_angle
from nao_course.lessons.ekf_slam.homework_log import OWN_SIGMAS, OWN_START, Sigmas
from nao_course.metrics import band
from nao_course.plotting import (
    Drawing,
    course_style,
    plot_ellipse,
    plot_field,
    plot_landmarks,
    plot_path,
    plot_pose,
)
from nao_course.plotting.legends import legend_below, source_key
from nao_course.plotting.maps import metric_axes
from nao_course.plotting.style import GREY
from nao_course.sim import Field
from nao_course.slam import range_and_bearing

DRIVES = 40
STEPS, STEP, SIDE = 50, 0.3, 5  # two laps of the pentagon
TIMES = 3.0  # the noise of the lesson's log
REACH, SIDEWAYS = 2.0, float(np.radians(60))  # m, rad
SIGMAS = Sigmas(*(TIMES * each for each in vars(OWN_SIGMAS).values()))
FIELD = Field(2012)
_MARKS = [mark for mark in FIELD.landmarks if mark.kind != "cross"]
LANDMARKS: FloatArray = np.array([(mark.x, mark.y) for mark in _MARKS])
KINDS = ["post" if mark.kind == "post" else "corner" for mark in _MARKS]
SHOWN = 3

Step = tuple[FloatArray, FloatArray, list[int], FloatArray, FloatArray]


@dataclass(frozen=True, eq=False)
class Drive:
    """Two laps, in the frame of the robot's first pose.

    Parameters
    ----------
    log : list of (control, control_covariance, numbers, measurements, measurement_covariance)
        What the robot knows of each step; in the first it stands still.
    path : ndarray, shape (M + 1, 3)
        True poses.
    odometry, odometry_covariance : ndarray, shapes (3,) and (3, 3)
        Believed at the end by who sees nothing.
    """

    log: list[Step]
    path: FloatArray
    odometry: FloatArray
    odometry_covariance: FloatArray


def make_drive(seed: int) -> Drive:
    """Drive two laps; the same seed gives the same."""
    rng = np.random.default_rng([77, seed])
    controls = np.array([(STEP, 2 * np.pi / 5 if n % SIDE == 0 else 0.0) for n in range(1, STEPS + 1)])
    Q, landmarks = SIGMAS.control_covariance, OWN_START.to_local(LANDMARKS)
    truth, told = Pose(), [Pose()]
    path, log = [truth], [_step(np.zeros(2), np.zeros((3, 3)), truth, landmarks, rng)]
    for distance, turn in controls:
        along, across, turned = rng.standard_normal(3) * np.sqrt(np.diag(Q))
        truth = truth @ Pose(distance + along, across, turn + turned)
        path.append(truth)
        log.append(_step(np.array([distance, turn]), Q, truth, landmarks, rng))
        told.append(told[-1] @ Pose(distance, 0.0, turn))
    true, believed = (np.array([each.as_array() for each in poses]) for poses in (path, told))
    return Drive(log, true, believed[-1], _spread(believed, Q))


def _step(
    control: FloatArray, Q: FloatArray, pose: Pose, landmarks: FloatArray, rng: np.random.Generator
) -> Step:
    """A control, and what is measured after it."""
    seen = range_and_bearing(pose.as_array(), landmarks)
    numbers = np.flatnonzero((seen[:, 1] <= REACH) & (np.abs(seen[:, 0]) <= SIDEWAYS))
    noisy = seen[numbers] + rng.standard_normal((len(numbers), 2)) * (SIGMAS.bearing, SIGMAS.range)
    noisy[:, 0], noisy[:, 1] = wrap_angle(noisy[:, 0]), np.maximum(noisy[:, 1], 0.05)
    return control, Q.copy(), numbers.tolist(), noisy.reshape(-1), SIGMAS.measurement_covariance


def _spread(told: FloatArray, Q: FloatArray) -> FloatArray:
    """Covariance (3, 3) of the last of the poses (N, 3) that odometry tells.

    A step's slip along and across carries it along; a turn that was wrong swings it about the end of that step.
    """
    away = told[-1, :2] - told[1:, :2]
    slips = np.tile(np.eye(3), (len(away), 1, 1))
    slips[:, :2, :2] = [rotation_2d(theta) for theta in told[:-1, 2]]
    slips[:, 0, 2], slips[:, 1, 2] = -away[:, 1], away[:, 0]
    return np.asarray(np.einsum("kij,jl,kml->im", slips, Q, slips))


def judge(answer: Any, drive: Drive) -> CaseScore:
    """Score a belief at the end: by how many bits it is denser at the true pose than odometry's."""
    pose, covariance = as_belief(answer, with_map=True)
    alone = drive.odometry, drive.odometry_covariance
    return score_belief(pose, covariance, drive.path[-1], alone, (drive, pose, covariance))


def draw_worst_drives(run: Run) -> Drawing:
    """Draw the drives with the fewest bits: the true path, and what is believed at its end."""
    judged = sorted((each for each in run.results if each.kept), key=lambda each: each.score)[:SHOWN]
    with course_style():
        figure = Figure(figsize=(9.9, 4.7))
        for number, each in enumerate(judged, start=1):
            drive, pose, covariance = each.kept
            ax = figure.add_subplot(1, SHOWN, number)
            plot_field(FIELD, ax)
            plot_landmarks(LANDMARKS, KINDS, ax, GREY, size=5)
            path = [OWN_START @ Pose.from_array(one) for one in drive.path]
            plot_path(path, ax)
            end = OWN_START @ Pose.from_array(pose)
            plot_ellipse((end.x, end.y), covariance[:2, :2], ax, "ekf")  # the frames are parallel
            plot_pose(end, ax, "ekf")
            ax.set_title(f"{each.name}: {each.score:.1f} bits", fontsize=11)
            reach = 2.5 * np.sqrt(np.diag(covariance)[:2]).max()
            ends = np.array([(end.x, end.y)]) + reach * np.array([(-1, -1), (1, 1)])
            x0, y0, x1, y1 = FIELD.carpet
            metric_axes(ax, np.vstack([[(x0, y0), (x1, y1)], [(one.x, one.y) for one in path], ends]))
        legend_below(
            figure, [source_key("truth", "where it drove"), source_key("ekf", "believed at the end, 95 %")]
        )
    said = ", ".join(f"{each.name} with {each.score:.1f} bits" for each in judged)
    return Drawing(figure, f"Score of {len(run.results)} drives: {run.score:.2f} bits. The worst are {said}.")


_LOW, _HIGH = band(3, DRIVES)
CHALLENGE = Challenge(
    lesson="07_ekf_slam",
    title="Challenge 07: two laps at three times the noise",
    task=f"{DRIVES} robots drive two laps without a map, all their errors {TIMES:.0f} times those of the lesson's log. "
    "Write a function of the log, a list of (control, control_covariance, numbers, measurements, "
    "measurement_covariance) for each step. It returns state and covariance at the end, pose first, in the frame of "
    "the start.",
    scoring="bits: how much denser your belief is at the robot's true pose than that of odometry alone, as a logarithm "
    "to the base 2, the mean over all drives. A small error counts only where your covariance is honest about it: "
    f"NEES between {_LOW:.1f} and {_HIGH:.1f} is.",
    seeds=range(DRIVES),
    make=make_drive,
    given=lambda drive: (drive.log,),
    judge=judge,
    figure=draw_worst_drives,
    columns=(Column("off", " cm", 1), Column("stated", " cm", 1), Column("NEES", "", 1)),
    rows=recorded_rows(Path(__file__).with_suffix(".json")),
    nothing=DEEPEST,
    unit=" bits",
    case="drive",
    name_of=partial("drive {}".format),
)
