"""The challenge of lesson 11: know where you are after a drive on which nobody names a landmark, and how surely."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from nao_course.challenges import CaseScore, Challenge, Column, recorded_rows
from nao_course.challenges.beliefs import DEEPEST, draw_worst_ends, odometry_covariance, say_bits, score_end
from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.slam_on_the_field.system.drives import FieldOdometry
from nao_course.lessons.slam_on_the_field.worlds import FIELD, KINDS, LANDMARKS, DrawnDrive, Log, drawn_drive
from nao_course.plotting import (
    plot_ellipse,
    plot_field,
    plot_landmarks,
    plot_path,
    plot_pose,
)
from nao_course.plotting.style import GREY

DRIVES, MOVES = 12, 12
FALSE_RATE = 0.1  # corners a picture that are none
FIRST_SEED = 11_000


@dataclass(frozen=True, eq=False)
class Case:
    """A drive, and what odometry alone believes at its end.

    Parameters
    ----------
    drive : DrawnDrive
        With its log.
    odometry, odometry_covariance : ndarray, shapes (3,) and (3, 3)
        In the field's frame.
    """

    drive: DrawnDrive
    odometry: FloatArray
    odometry_covariance: FloatArray

    @property
    def given(self) -> tuple[Pose, Log]:
        """What an entry gets."""
        return self.drive.start, list(self.drive.log)


def make_case(seed: int) -> Case:
    """Drive; the same seed gives the same."""
    drive = drawn_drive(FIRST_SEED + seed, MOVES, false_rate=FALSE_RATE)
    motions = [motion for motion, _ in drive.log if motion is not None]
    told = [drive.start]
    for motion in motions:
        told.append(told[-1] @ motion.as_pose())
    noise = np.array([FieldOdometry().covariance(motion) for motion in motions])
    path = np.array([each.as_array() for each in told])
    return Case(drive, path[-1], odometry_covariance(path, noise))


def judge(answer: Any, case: Case) -> CaseScore:
    """Score a belief at the end: by how many bits it is denser at the true pose than odometry's."""
    return score_end(answer, case.drive.poses[-1], (case.odometry, case.odometry_covariance), case.drive)


def _plot_drive(ax: Axes, kept: Any) -> None:
    """A true path and a belief at its end."""
    drive, pose, covariance = kept
    plot_field(FIELD, ax)
    plot_landmarks(LANDMARKS, KINDS, ax, GREY, size=5)
    plot_path(drive.poses, ax)
    plot_ellipse(pose[:2], covariance[:2, :2], ax, "ekf")
    plot_pose(Pose.from_array(pose), ax, "ekf")


CHALLENGE = Challenge(
    lesson="11_slam_on_the_field",
    title="Challenge 11: twelve drives without names",
    task=f"{DRIVES} robots drive {MOVES} moves over the half field from a known start and take three looks "
    "at each stop. Nothing says which landmark is which, and every tenth picture shows a corner that is none. "
    "Write a function of "
    "start (a Pose) and log, a list of (motion or None, observation). It returns pose and covariance at the end, in "
    "the field's frame; a whole state with its covariance will do.",
    scoring=say_bits(DRIVES),
    seeds=range(DRIVES),
    make=make_case,
    given=lambda case: case.given,
    judge=judge,
    figure=partial(draw_worst_ends, plot_drive=_plot_drive),
    columns=(Column("off", " cm", 1), Column("stated", " cm", 1), Column("NEES", "", 1)),
    rows=recorded_rows(Path(__file__).with_suffix(".json")),
    nothing=DEEPEST,
    unit=" bits",
    case="drive",
    name_of=partial("drive {}".format),
)
