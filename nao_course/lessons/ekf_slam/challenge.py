"""The challenge of lesson 07: know where you are after two laps, and how well you know it, at three times the noise."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from nao_course.challenges import CaseScore, Challenge, Column, recorded_rows
from nao_course.challenges.beliefs import DEEPEST, draw_worst_ends, odometry_covariance, say_bits, score_end
from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.lessons.ekf_slam.homework_log import OWN_SIGMAS, OWN_START, Sigmas
from nao_course.plotting import (
    plot_ellipse,
    plot_field,
    plot_landmarks,
    plot_path,
    plot_pose,
)
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
    return Drive(log, true, believed[-1], odometry_covariance(believed, np.tile(Q, (STEPS, 1, 1))))


def _step(
    control: FloatArray, Q: FloatArray, pose: Pose, landmarks: FloatArray, rng: np.random.Generator
) -> Step:
    """A control, and what is measured after it."""
    seen = range_and_bearing(pose.as_array(), landmarks)
    numbers = np.flatnonzero((seen[:, 1] <= REACH) & (np.abs(seen[:, 0]) <= SIDEWAYS))
    noisy = seen[numbers] + rng.standard_normal((len(numbers), 2)) * (SIGMAS.bearing, SIGMAS.range)
    noisy[:, 0], noisy[:, 1] = wrap_angle(noisy[:, 0]), np.maximum(noisy[:, 1], 0.05)
    return control, Q.copy(), numbers.tolist(), noisy.reshape(-1), SIGMAS.measurement_covariance


def judge(answer: Any, drive: Drive) -> CaseScore:
    """Score a belief at the end: by how many bits it is denser at the true pose than odometry's."""
    return score_end(answer, drive.path[-1], (drive.odometry, drive.odometry_covariance), drive)


def _plot_drive(ax: Axes, kept: Any) -> None:
    """A true path and a belief at its end, on as much of the ground as both need."""
    drive, pose, covariance = kept
    plot_field(FIELD, ax)
    plot_landmarks(LANDMARKS, KINDS, ax, GREY, size=5)
    path = [OWN_START @ Pose.from_array(one) for one in drive.path]
    plot_path(path, ax)
    end = OWN_START @ Pose.from_array(pose)
    plot_ellipse((end.x, end.y), covariance[:2, :2], ax, "ekf")  # the frames are parallel
    plot_pose(end, ax, "ekf")
    reach = 2.5 * np.sqrt(np.diag(covariance)[:2]).max()
    ends = np.array([(end.x, end.y)]) + reach * np.array([(-1, -1), (1, 1)])
    x0, y0, x1, y1 = FIELD.carpet
    metric_axes(ax, np.vstack([[(x0, y0), (x1, y1)], [(one.x, one.y) for one in path], ends]))


CHALLENGE = Challenge(
    lesson="07_ekf_slam",
    title="Challenge 07: two laps at three times the noise",
    task=f"{DRIVES} robots drive two laps without a map, all their errors {TIMES:.0f} times those of the lesson's log. "
    "Write a function of the log, a list of (control, control_covariance, numbers, measurements, "
    "measurement_covariance) for each step. It returns state and covariance at the end, pose first, in the frame of "
    "the start.",
    scoring=say_bits(DRIVES),
    seeds=range(DRIVES),
    make=make_drive,
    given=lambda drive: (drive.log,),
    judge=judge,
    figure=partial(draw_worst_ends, plot_drive=_plot_drive),
    columns=(Column("off", " cm", 1), Column("stated", " cm", 1), Column("NEES", "", 1)),
    rows=recorded_rows(Path(__file__).with_suffix(".json")),
    nothing=DEEPEST,
    unit=" bits",
    case="drive",
    name_of=partial("drive {}".format),
)
