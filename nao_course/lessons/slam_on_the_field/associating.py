"""Nearest neighbour and joint compatibility on single looks, and what a filter makes of a whole drive."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from nao_course.geometry import wrap_angle
from nao_course.lessons.slam_on_the_field.system.drives import FieldOdometry
from nao_course.lessons.slam_on_the_field.worlds import (
    KINDS,
    DrawnDrive,
    Riddle,
    riddle,
)
from nao_course.metrics import squared_distances
from nao_course.plotting import Drawing, course_style
from nao_course.plotting.legends import legend_below
from nao_course.slam import Estimate, run_slam

RUNS = 30
POSITION_SIGMA, HEADING_SIGMA = 0.15, float(np.radians(8.0))  # m along each axis, rad
GATE = 3.0
GOOD, BAD = "#1a7f37", "#b3261e"

Associate = Callable[..., Any]


def riddles(runs: int = RUNS) -> list[Riddle]:
    """The looks on which associations are compared."""
    return [riddle(seed, POSITION_SIGMA, HEADING_SIGMA) for seed in range(runs)]


def shares(associate: Associate, looks: list[Riddle]) -> list[tuple[int, int]]:
    """For each look how many associations are right, and of how many.

    Raises
    ------
    ValueError
        If there is not one number for each measurement.
    """
    found = []
    for each in looks:
        given = (
            each.state.copy(),
            each.covariance.copy(),
            list(KINDS),
            each.observation,
            each.observation.covariance.copy(),
        )
        indices = np.asarray(associate(*given, GATE))
        if indices.shape != (len(each.origins),):
            raise ValueError(
                f"{len(each.origins)} measurements need as many numbers, got shape {indices.shape}"
            )
        found.append((each.right(indices), len(each.origins)))
    return found


def right_share(associate: Associate) -> float:
    """How many of all associations are right in the lesson's thirty runs, in percent."""
    right, all_of_them = np.sum(shares(associate, riddles()), axis=0)
    return round(100 * float(right / all_of_them), 1)


def draw_matching(associate: Associate, associate_jointly: Associate) -> Drawing:
    """Draw how many associations are right in each of thirty runs, by both methods."""
    looks = riddles()
    by = {
        "nearest neighbour": shares(associate, looks),
        "joint compatibility": shares(associate_jointly, looks),
    }
    wrong = {name: np.array([all_of - right for right, all_of in found]) for name, found in by.items()}
    count = sum(all_of for _, all_of in by["nearest neighbour"])
    with course_style():
        figure = Figure(figsize=(8.6, 3.0))
        ax = figure.add_subplot()
        for number, (name, colour) in enumerate(zip(wrong, (BAD, GOOD), strict=True)):
            x = np.arange(1, RUNS + 1) + 0.4 * number - 0.2
            share = 100 - 100 * wrong[name].sum() / count
            ax.bar(x, wrong[name], 0.38, color=colour, label=f"{name}: {share:.1f} % right", zorder=3)
        ax.set(xlabel="run", ylabel="wrong of a look", xlim=(0.4, RUNS + 0.6), ylim=(0, None))
        ax.yaxis.set_major_locator(MaxNLocator(integer=True))
        legend_below(figure, ax.get_legend_handles_labels()[0])
    said = "; ".join(f"{name} {100 - 100 * each.sum() / count:.1f} %" for name, each in wrong.items())
    return Drawing(
        figure,
        f"Wrong associations in each of {RUNS} looks with {count} measurements in all, the position in doubt by "
        f"{100 * POSITION_SIGMA:.0f} cm along each axis and the heading by {np.degrees(HEADING_SIGMA):.0f} degrees. "
        f"Right: {said}.",
    )


@dataclass(frozen=True, eq=False)
class Outcome:
    """What a filter made of a drive.

    Parameters
    ----------
    drive : DrawnDrive
        Which.
    estimate : Estimate
        At its end.
    path : ndarray, shape (S, 3)
        Estimated at each step.
    off : float
        Distance of the last position from the true one, m.
    nees : float
        Of the last pose.
    """

    drive: DrawnDrive
    estimate: Estimate
    path: Any
    off: float
    nees: float


def follow(
    slam_class: Callable[..., Any], drive: DrawnDrive, gate: float, match: Associate | None = None
) -> Outcome:
    """Run a student's class over a drive."""
    chosen = {} if match is None else {"association": match}
    slam = slam_class(drive.start, FieldOdometry(), gate, **chosen)
    estimates = run_slam(slam, drive.log)
    path = np.array([each.pose.as_array() for each in estimates])
    error = path[-1] - drive.poses[-1]
    error[2] = wrap_angle(error[2])
    spread = estimates[-1].covariance + 1e-12 * np.eye(3)
    nees = float(squared_distances(error[None], spread[None])[0])
    return Outcome(drive, estimates[-1], path, float(np.hypot(*error[:2])), nees)
