"""The challenge of lesson 06: three measurements, and the most precise consistent estimate from them."""

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
from nao_course.codec import register
from nao_course.geometry import FloatArray, Pose, rotation_2d, wrap_angle
from nao_course.lessons.localization.drives import FIELD, KINDS, LANDMARKS
from nao_course.lessons.localization.figures import SMALL
from nao_course.plotting import (
    STYLES,
    Drawing,
    ellipse_outlines,
    plot_ellipse,
    plot_field,
    plot_landmarks,
    plot_pose,
)
from nao_course.plotting.legends import source_key
from nao_course.plotting.style import GREY
from nao_course.sim import SensorNoise
from nao_course.slam import range_and_bearing

ROBOTS = 40
BUDGET = 3  # measurements for each robot


@register
@dataclass(frozen=True, eq=False)
class LandmarkSensor:
    """Measure landmarks by their number, three times at most: ``sensor.measure(number)``.

    Measurements (L, N, 2) are (bearing, range) of N landmarks for the first, second and third measurement, in rad and
    m; covariances (L, N, 2, 2) are of their noise, in rad^2 and m^2.
    """

    _measurements: FloatArray
    _covariances: FloatArray

    def __post_init__(self) -> None:
        """Count measurements outside the fields, because the arguments of an entry must not change."""
        object.__setattr__(self, "_taken", [])

    def measure(self, number: Any) -> tuple[FloatArray, FloatArray]:
        """Return a measurement (2,) of landmark `number` and its R (2, 2).

        Raise a ValueError if there is no such landmark, or no measurement is left.
        """
        many = self._measurements.shape[1]
        if (
            isinstance(number, bool)
            or not isinstance(number, int | float | np.number)
            or number not in range(many)
        ):
            raise ValueError(f"a landmark's number is a row of landmarks, 0 to {many - 1}, got {number!r}")
        taken: list[int] = self.__dict__["_taken"]
        used = len(taken)
        if used >= len(self._measurements):
            raise ValueError(f"all {len(self._measurements)} measurements are used")
        taken.append(int(number))
        return self._measurements[used, int(number)].copy(), self._covariances[used, int(number)].copy()


@dataclass(frozen=True, eq=False)
class LostRobot:
    """Hold a robot whose estimate is wrong.

    The estimate, a pose (3,) and its covariance (3, 3), is consistent; it and the true pose (3,) are in m and rad, in
    the field frame.
    """

    pose: FloatArray
    covariance: FloatArray
    truth: FloatArray
    sensor: LandmarkSensor


def make_robot(seed: int) -> LostRobot:
    """Return a robot whose true pose is drawn from its estimate's distribution."""
    rng = np.random.default_rng([66, seed])
    pose = np.array([rng.uniform(0.4, 2.4), rng.uniform(-1.6, 1.6), rng.uniform(-np.pi, np.pi)])
    long, short = np.sort(rng.uniform(0.08, 0.5, 2))[::-1]
    turned = rotation_2d(rng.uniform(0, np.pi))
    covariance = np.zeros((3, 3))
    covariance[:2, :2] = turned @ np.diag([long**2, short**2]) @ turned.T
    covariance[2, 2] = np.radians(rng.uniform(3, 20)) ** 2
    truth = rng.multivariate_normal(pose, covariance)
    truth[2] = wrap_angle(truth[2])
    noise = SensorNoise()
    exact = np.tile(range_and_bearing(truth, LANDMARKS), (BUDGET, 1, 1))
    measured = noise.disturbed(exact, rng.standard_normal(exact.shape))
    sensor = LandmarkSensor(measured, np.array([noise.covariances(each) for each in measured]))
    return LostRobot(pose, covariance, truth, sensor)


def judge(answer: Any, robot: LostRobot) -> CaseScore:
    """Score an estimate by how many bits its density at the true pose exceeds the first estimate's."""
    pose, covariance = as_belief(answer)
    before = robot.pose, robot.covariance
    return score_belief(pose, covariance, robot.truth, before, (robot, pose, covariance))


def draw_worst_robots(run: Run) -> Drawing:
    """Draw the robots with the fewest bits: estimates before and after, and the true pose."""
    keys = [
        source_key("truth", "true pose"),
        source_key("odometry", "estimate before, 95 %"),
        source_key("ekf", "estimate after, 95 %"),
    ]
    return draw_worst(run, _plot_robot, keys, digits=1)


def _plot_robot(ax: Axes, kept: Any) -> None:
    """Plot a true pose and the estimates before and after."""
    robot, pose, covariance = kept
    plot_field(FIELD, ax)
    plot_landmarks(LANDMARKS, KINDS, ax, GREY, size=5)
    plot_ellipse(robot.pose[:2], robot.covariance[:2, :2], ax, "odometry")
    plot_pose(Pose.from_array(robot.pose), ax, "odometry", size=SMALL)
    plot_pose(Pose.from_array(robot.truth), ax, size=SMALL)
    plot_pose(Pose.from_array(pose), ax, "ekf", size=SMALL)
    (outline,) = ellipse_outlines(pose[:2], covariance[None, :2, :2])
    ax.plot(*np.vstack([outline, outline[:1]]).T, color=STYLES["ekf"].colour, lw=1.8, zorder=7)


CHALLENGE = Challenge(
    lesson="06_localization",
    title="Challenge 06: three measurements",
    task=f"{ROBOTS} robots are uncertain about their pose. Write a function of pose, covariance, landmarks "
    f"(10, 2) and sensor that returns a better pose and its covariance. It may call sensor.measure(number) "
    f"{BUDGET} times; each call returns a measurement of that landmark and its R.",
    scoring="bits gained: the logarithm to the base 2 of how much denser your estimate's distribution is at the "
    "true pose than the first estimate's, averaged over all robots. A smaller covariance scores more, "
    "but only if the true pose lies where it says.",
    seeds=range(ROBOTS),
    make=make_robot,
    given=lambda robot: (robot.pose, robot.covariance, LANDMARKS, robot.sensor),
    judge=judge,
    figure=draw_worst_robots,
    columns=(Column("off", " cm", 1), Column("stated", " cm", 1), Column("NEES", "", 1)),
    rows=recorded_rows(Path(__file__).with_suffix(".json")),
    nothing=DEEPEST,
    unit=" bits",
    case="robot",
    name_of=partial("robot {}".format),
)
