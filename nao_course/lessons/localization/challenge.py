"""The challenge of lesson 06: three looks that make the robot surest, and honestly so."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from nao_course.challenges import CaseScore, Challenge, Column, Run, recorded_rows
from nao_course.challenges.beliefs import DEEPEST, as_belief, score_belief
from nao_course.challenges.worst_cases import draw_worst
from nao_course.exercises.codec import register
from nao_course.geometry import FloatArray, Pose, rotation_2d, wrap_angle
from nao_course.lessons.localization.drives import FIELD, KINDS, LANDMARKS, look_at
from nao_course.plotting import Drawing, plot_ellipse, plot_field, plot_landmarks, plot_pose
from nao_course.plotting.legends import source_key
from nao_course.plotting.style import GREY
from nao_course.sim import SensorNoise

ROBOTS = 40
LOOKS = 3


@register
@dataclass(frozen=True, eq=False)
class Looks:
    """A robot's head: ``looks.at(number)`` measures a landmark, three times at most.

    Parameters
    ----------
    _measurements : ndarray, shape (L, N, 2)
        (bearing, range) of each of N landmarks, for the first look, the second and the third: rad, m.
    _covariances : ndarray, shape (L, N, 2, 2)
        Of their noise: rad^2, m^2.
    """

    _measurements: FloatArray
    _covariances: FloatArray

    def __post_init__(self) -> None:
        """Begin with no look taken; that is no field, for what is given to an entry must stay as it was."""
        object.__setattr__(self, "_taken", [])

    def at(self, number: Any) -> tuple[FloatArray, FloatArray]:
        """Look at landmark `number`: its measurement (2,) and R (2, 2).

        Raises
        ------
        ValueError
            If there is no such landmark, or all looks are taken.
        """
        many = self._measurements.shape[1]
        if (
            isinstance(number, bool)
            or not isinstance(number, int | float | np.number)
            or number not in range(many)
        ):
            raise ValueError(f"a landmark's number is 0 to {many - 1}, a row of landmarks, got {number!r}")
        taken: list[int] = self.__dict__["_taken"]
        look = len(taken)
        if look >= len(self._measurements):
            raise ValueError(f"all {len(self._measurements)} looks are taken")
        taken.append(int(number))
        return self._measurements[look, int(number)].copy(), self._covariances[look, int(number)].copy()


@dataclass(frozen=True, eq=False)
class LostRobot:
    """A robot that is not where it believes to be.

    Parameters
    ----------
    pose, covariance : ndarray, shape (3,) and (3, 3)
        What it believes, and honestly: m, rad, field frame.
    truth : ndarray, shape (3,)
        Where it is.
    looks : Looks
        What it would measure.
    """

    pose: FloatArray
    covariance: FloatArray
    truth: FloatArray
    looks: Looks


def make_robot(seed: int) -> LostRobot:
    """Put a robot down somewhere, with a belief from which its truth is drawn."""
    rng = np.random.default_rng([66, seed])
    pose = np.array([rng.uniform(0.4, 2.4), rng.uniform(-1.6, 1.6), rng.uniform(-np.pi, np.pi)])
    long, short = np.sort(rng.uniform(0.08, 0.5, 2))[::-1]
    turned = rotation_2d(rng.uniform(0, np.pi))
    covariance = np.zeros((3, 3))
    covariance[:2, :2] = turned @ np.diag([long**2, short**2]) @ turned.T
    covariance[2, 2] = np.radians(rng.uniform(3, 20)) ** 2
    truth = rng.multivariate_normal(pose, covariance)
    truth[2] = wrap_angle(truth[2])
    seen = [
        [look_at(truth, number, SensorNoise(), rng) for number in range(len(LANDMARKS))] for _ in range(LOOKS)
    ]
    looks = Looks(
        np.array([[sight.measurement for sight in row] for row in seen]),
        np.array([[sight.covariance for sight in row] for row in seen]),
    )
    return LostRobot(pose, covariance, truth, looks)


def judge(answer: Any, robot: LostRobot) -> CaseScore:
    """Score a belief: by how many bits its density at the true pose is above that of the belief at first."""
    pose, covariance = as_belief(answer)
    before = robot.pose, robot.covariance
    return score_belief(pose, covariance, robot.truth, before, (robot, pose, covariance))


def draw_worst_robots(run: Run) -> Drawing:
    """Draw the robots with the fewest bits: before, after, and where they are."""
    keys = [
        source_key("truth", "where it is"),
        source_key("odometry", "believed before, 95 %"),
        source_key("ekf", "believed after, 95 %"),
    ]
    return draw_worst(run, _plot_robot, keys, digits=1)


def _plot_robot(ax: Axes, kept: Any) -> None:
    """A true pose, and the beliefs before and after."""
    robot, pose, covariance = kept
    plot_field(FIELD, ax)
    plot_landmarks(LANDMARKS, KINDS, ax, GREY, size=5)
    plot_ellipse(robot.pose[:2], robot.covariance[:2, :2], ax, "odometry")
    plot_ellipse(pose[:2], covariance[:2, :2], ax, "ekf")
    plot_pose(Pose.from_array(robot.pose), ax, "odometry")
    plot_pose(Pose.from_array(pose), ax, "ekf")
    plot_pose(Pose.from_array(robot.truth), ax)


CHALLENGE = Challenge(
    lesson="06_localization",
    title="Challenge 06: three looks",
    task=f"{ROBOTS} robots do not know well where they are. Write a function of pose, covariance, "
    "landmarks (10, 2) and looks. It may call "
    "looks.at(number) three times, which returns a measurement and its R, and returns the pose and "
    "covariance that it believes then.",
    scoring="bits gained: how much denser your belief is at the true pose than the belief at first, as a "
    "logarithm to the base 2, the mean "
    "over all robots. Who is surer scores more, but only if the truth is where the belief says.",
    seeds=range(ROBOTS),
    make=make_robot,
    given=lambda robot: (robot.pose, robot.covariance, LANDMARKS, robot.looks),
    judge=judge,
    figure=draw_worst_robots,
    columns=(Column("off", " cm", 1), Column("stated", " cm", 1), Column("NEES", "", 1)),
    rows=recorded_rows(Path(__file__).with_suffix(".json")),
    nothing=DEEPEST,
    unit=" bits",
    case="robot",
    name_of=partial("robot {}".format),
)
