"""The challenge of lesson 07: estimate the pose after two laps, and its covariance, at three times the noise."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from nao_course.challenges import CaseScore, Challenge, Column, recorded_rows
from nao_course.challenges.beliefs import DEEPEST, draw_worst_ends, odometry_belief, say_bits, score_end
from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.ekf_slam.homework_log import OWN_SIGMAS, OWN_START
from nao_course.plotting import plot_ellipse, plot_field, plot_landmarks, plot_path, plot_pose
from nao_course.plotting.maps import metric_axes
from nao_course.plotting.style import CARPET, GREY
from nao_course.sim import Field
from nao_course.sim.drives import FieldOfView, measure_in_view, true_path
from nao_course.slam import Motion

DRIVES = 40
STEPS, STEP, SIDE = 50, 0.3, 5  # two laps of the pentagon
TIMES = 3.0  # the noise of the lesson's log
VIEW = FieldOfView(float(np.radians(60)), 2.0)  # rad, m
SIGMAS = OWN_SIGMAS.times(TIMES)
BESIDE = 1.0  # m that a figure shows beside the carpet
FIELD = Field(2012)
LANDMARKS, KINDS = FIELD.detectable_positions, FIELD.detectable_kinds

Record = tuple[FloatArray, FloatArray, list[int], FloatArray, FloatArray]


@dataclass(frozen=True, eq=False)
class TwoLaps:
    """Two laps, in the frame of the robot's first pose.

    `log` has for each step control, control covariance, numbers, measurements and their covariance; in the first step
    the robot stands still. `path` (M + 1, 3) has the true poses; `odometry` (3,) and its covariance (3, 3) are
    estimated at the end from the controls alone.
    """

    log: list[Record]
    path: FloatArray
    odometry: FloatArray
    odometry_covariance: FloatArray


def make_drive(seed: int) -> TwoLaps:
    """Drive two laps; the same seed gives the same drive."""
    rng = np.random.default_rng([77, seed])
    motions = [Motion(STEP, 2 * np.pi / 5 if n % SIDE == 0 else 0.0) for n in range(1, STEPS + 1)]
    Q, landmarks = SIGMAS.control_covariance, OWN_START.to_local(LANDMARKS)
    path = [Pose()]
    log = [_record(np.zeros(2), np.zeros((3, 3)), path[0], landmarks, rng)]
    for motion in motions:
        path.append(true_path([motion], SIGMAS, rng, path[-1])[-1])
        log.append(_record(np.array([motion.distance, motion.turn]), Q, path[-1], landmarks, rng))
    true = np.array([each.as_array() for each in path])
    return TwoLaps(log, true, *odometry_belief(Pose(), motions, [Q] * STEPS))


def _record(
    control: FloatArray, Q: FloatArray, pose: Pose, landmarks: FloatArray, rng: np.random.Generator
) -> Record:
    """Return a control and the measurements after it."""
    numbers, seen = measure_in_view(pose.as_array(), landmarks, SIGMAS, VIEW, rng)
    seen[:, 1] = np.maximum(seen[:, 1], 0.05)
    return control, Q.copy(), numbers.tolist(), seen.reshape(-1), SIGMAS.measurement_covariance


def judge(answer: Any, drive: TwoLaps) -> CaseScore:
    """Score an estimate at the end by the bits that its density at the true pose gains over odometry."""
    return score_end(answer, drive.path[-1], (drive.odometry, drive.odometry_covariance), drive)


def _plot_drive(ax: Axes, kept: Any) -> None:
    """Plot the true path, and the estimate at its end."""
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
    ax.set_facecolor(CARPET)
    # All drives have the same scale, unless the end of one is farther away.
    around = np.reshape(FIELD.carpet, (2, 2)) + BESIDE * np.array([[-1], [1]])
    metric_axes(ax, np.vstack([around, [(one.x, one.y) for one in path], ends]))


CHALLENGE = Challenge(
    lesson="07_ekf_slam",
    title="Challenge 07: two laps at three times the noise",
    task=f"{DRIVES} robots drive two laps without a map. All errors are {TIMES:.0f} times those in our log. "
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
