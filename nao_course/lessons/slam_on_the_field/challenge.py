"""The challenge of lesson 11: estimate the final pose and covariance of drives without known associations."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes

from nao_course.challenges import CaseScore, Challenge, Column, recorded_rows
from nao_course.challenges.beliefs import DEEPEST, draw_worst_ends, odometry_belief, say_bits, score_end
from nao_course.field_slam.drives import OdometryNoisePerMove
from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.slam_on_the_field.worlds import FIELD, KINDS, LANDMARKS, DrawnDrive, Log, drawn_drive
from nao_course.plotting import plot_ellipse, plot_field, plot_landmarks, plot_path, plot_pose
from nao_course.plotting.style import GREY

DRIVES, MOVES = 12, 12
FALSE_RATE = 0.1  # false corners in a picture, on average
FIRST_SEED = 11_000


@dataclass(frozen=True, eq=False)
class Case:
    """A drive, and odometry's estimate of its final pose (3,) with covariance (3, 3), in the field's frame."""

    drive: DrawnDrive
    odometry: FloatArray
    odometry_covariance: FloatArray

    @property
    def given(self) -> tuple[Pose, Log]:
        """Arguments of an entry."""
        return self.drive.start, list(self.drive.log)


def make_case(seed: int) -> Case:
    """Return the drive of a seed."""
    drive = drawn_drive(FIRST_SEED + seed, MOVES, false_rate=FALSE_RATE)
    motions = [motion for motion, _ in drive.log if motion is not None]
    noise = [OdometryNoisePerMove().covariance(motion) for motion in motions]
    return Case(drive, *odometry_belief(drive.start, motions, noise))


def judge(answer: Any, case: Case) -> CaseScore:
    """Score a final estimate: by how many bits its density at the true pose exceeds odometry's."""
    return score_end(answer, case.drive.poses[-1], (case.odometry, case.odometry_covariance), case.drive)


def _plot_drive(ax: Axes, kept: Any) -> None:
    """Plot a true path and the estimate at its end."""
    drive, pose, covariance = kept
    plot_field(FIELD, ax)
    plot_landmarks(LANDMARKS, KINDS, ax, GREY, size=5)
    plot_path(drive.poses, ax)
    plot_ellipse(pose[:2], covariance[:2, :2], ax, "ekf")
    plot_pose(Pose.from_array(pose), ax, "ekf")


CHALLENGE = Challenge(
    lesson="11_slam_on_the_field",
    title="Challenge 11: twelve drives without names",
    task=f"{DRIVES} robots drive {MOVES} moves over the half field from a known start and take three pictures "
    "at each stop. The measurements have no names, and every tenth picture contains a corner that does not exist. "
    "Write a function of "
    "start (a Pose) and log, a list of (motion or None, observation). It returns the final pose and its covariance in "
    "the field's frame; a whole state with its covariance is accepted, too.",
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
