"""Nearest neighbour and joint compatibility on single pictures, and the result of a filter on a whole drive."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from nao_course.field_slam.drives import OdometryNoisePerMove
from nao_course.geometry import pose_errors
from nao_course.lessons.slam_on_the_field.worlds import (
    KINDS,
    AssociationProblem,
    DrawnDrive,
    association_problem,
)
from nao_course.metrics import squared_distances
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.legends import legend_below
from nao_course.slam import Estimate, run_slam

RUNS = 30
POSITION_SIGMA, HEADING_SIGMA = 0.15, float(np.radians(8.0))  # m along each axis, rad
GATE = 3.0
GOOD, BAD = "#1a7f37", "#b3261e"

Associate = Callable[..., Any]


def association_problems(runs: int = RUNS) -> list[AssociationProblem]:
    """Return the pictures on which associations are compared."""
    return [association_problem(seed, POSITION_SIGMA, HEADING_SIGMA) for seed in range(runs)]


def shares(associate: Associate, pictures: list[AssociationProblem]) -> list[tuple[int, int]]:
    """Count for each picture the right associations, and all of them.

    Raise a ValueError if there is not one number for each measurement.
    """
    found = []
    for each in pictures:
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
    """Return the percentage of right associations in the lesson's thirty pictures."""
    right, all_of_them = np.sum(shares(associate, association_problems()), axis=0)
    return round(100 * float(right / all_of_them), 1)


@course_style()
def draw_matching(associate: Associate, associate_jointly: Associate) -> Drawing:
    """Draw the number of wrong associations in each of thirty pictures, by both methods."""
    pictures = association_problems()
    by = {
        "nearest neighbour": shares(associate, pictures),
        "joint compatibility": shares(associate_jointly, pictures),
    }
    wrong = {name: np.array([all_of - right for right, all_of in found]) for name, found in by.items()}
    count = sum(all_of for _, all_of in by["nearest neighbour"])
    figure = Figure(figsize=(8.6, 3.0))
    ax = figure.add_subplot()
    for number, (name, colour) in enumerate(zip(wrong, (BAD, GOOD), strict=True)):
        x = np.arange(RUNS) + 0.4 * number - 0.2
        share = 100 - 100 * wrong[name].sum() / count
        ax.bar(x, wrong[name], 0.38, color=colour, label=f"{name}: {share:.1f} % right", zorder=3)
    ax.set(xlabel="picture", ylabel="wrong measurements", xlim=(-0.6, RUNS - 0.4), ylim=(0, None))
    ax.yaxis.set_major_locator(MaxNLocator(integer=True))
    legend_below(figure, ax.get_legend_handles_labels()[0])
    said = "; ".join(f"{name} {100 - 100 * each.sum() / count:.1f} %" for name, each in wrong.items())
    return Drawing(
        figure,
        f"Wrong associations in each of {RUNS} pictures with {count} measurements in all. The standard deviation is "
        f"{100 * POSITION_SIGMA:.0f} cm along each axis and {np.degrees(HEADING_SIGMA):.0f} degrees of heading. "
        f"Right: {said}.",
    )


@dataclass(frozen=True, eq=False)
class Outcome:
    """The result of a filter on a drive.

    `estimate` and `nees` are at the end, `path` (S, 3) has the estimate at each step, and `off` is the distance of the
    last position from the true one in m.
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
    slam = slam_class(drive.start, OdometryNoisePerMove(), gate, **chosen)
    estimates = run_slam(slam, drive.log)
    path = np.array([each.pose.as_array() for each in estimates])
    error = pose_errors(path[-1], drive.poses[-1])
    covariance = estimates[-1].covariance + 1e-12 * np.eye(3)
    nees = float(squared_distances(error[None], covariance[None])[0])
    return Outcome(drive, estimates[-1], path, float(np.hypot(*error[:2])), nees)


def plot_median(
    ax: Axes,
    median: float,
    y: float,
    text: str,
    above: float,
    *,
    below: float = 0.0,
    ticks: float = 18.0,
    size: float = 9.0,
) -> None:
    """Mark the median of a row of values at height `y`, and write a text `above` (points) it."""
    ax.plot([median], [y - below], "|", ms=ticks, mew=2.5, color=STYLES["truth"].colour)
    ax.annotate(text, (median, y), (0, above), textcoords="offset points", ha="center", fontsize=size)
