"""Figures of lesson 03's measurements: costs of detectors, corners lost at each step, the erased goal line."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.lessons.hough_corners.measuring import STEPS, count_corners
from nao_course.lessons.hough_corners.scenes import (
    CornerPicture,
    goal_line_at,
    match_pictures,
    real_pictures,
    rows_between,
    tuning_pictures,
)
from nao_course.metrics import PointMatch, corner_cost, mean_interval, total
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import GREY, style_of
from nao_course.sim import Reality

# The counts of the lesson's solution in eight pictures of a real NAO; a test compares both.
BEHIND = 0.7  # m of carpet behind the goal line
REAL = dict(zip(STEPS, (10, 10, 10, 7, 0), strict=True))


def draw_costs(
    detectors: Mapping[str, Callable[[Any], Any]], pictures: Sequence[CornerPicture] | None = None
) -> Drawing:
    """Draw the mean costs of detectors, and their differences from reporting nothing or from another detector.

    Parameters
    ----------
    detectors : mapping of str to callable
        The detectors, by name: ``find(pixels)`` returns corners (K, 2).
    pictures : sequence of CornerPicture, optional
        Pictures in which the others are compared with the first detector. By default the thirty tuning pictures, in
        which all are compared with reporting nothing.

    Returns
    -------
    Drawing
        Mean costs on the left, mean differences on the right, both with 95 % intervals.
    """
    compared = detectors if pictures else {"nothing": lambda pixels: [], **detectors}
    among = pictures or tuning_pictures()
    return draw_matches({name: match_pictures(find, among) for name, find in compared.items()})


def mean_cost(find: Callable[[Any], Any]) -> float:
    """Return the mean cost of a detector on the tuning pictures; `find(pixels)` returns corners (K, 2)."""
    return float(np.mean([corner_cost(match) for match in match_pictures(find, tuning_pictures())]))


@course_style()
def draw_matches(matches: Mapping[str, Sequence[PointMatch]]) -> Drawing:
    """Draw the costs of several detectors; the others are compared with the first."""
    costs = {name: np.array([corner_cost(match) for match in each]) for name, each in matches.items()}
    first, names, words = next(iter(costs)), list[str](), list[str]()
    figure, blue = Figure(figsize=(9.9, 0.75 * len(costs) + 1.5)), STYLES["ekf"].colour
    left, right = figure.subplots(1, 2, sharey=True, width_ratios=(3, 2))
    for row, (name, each) in enumerate(costs.items()):
        sums = total(matches[name])
        counts = f"{sums.hits} found, {sums.false} false, {sums.missed} missed"
        names.append(f"{name}\n{counts}")
        words.append(f"{name}: {counts}, mean cost {_plot_mean(left, each, row)}")
        if name == first:
            right.plot(0.0, row, "o", color=blue, ms=9)
        else:
            words[-1] += f", difference from {first} {_plot_mean(right, each - costs[first], row)}"
    left.axvline(costs[first].mean(), color=STYLES["odometry"].colour, ls=":", lw=1.6)
    right.axvline(0.0, color=STYLES["odometry"].colour, ls=":", lw=1.6)
    left.set_yticks(range(len(costs)), names)
    left.set(xlabel="mean cost of a picture (lower is better)", ylim=(len(costs) - 0.5, -0.5))
    right.set(xlabel=f"difference from {first}")
    keys = [
        Line2D([], [], color=GREY, lw=2.5, marker="o", mfc=blue, mec=blue, ms=9, label="mean, 95 % interval"),
        Line2D([], [], color=STYLES["odometry"].colour, ls=":", lw=1.6, label=f"mean of {first}"),
    ]
    legend_below(figure, keys)
    return Drawing(figure, f"{len(costs[first])} pictures; lower is better. {'; '.join(words)}.")


def _plot_mean(ax: Axes, values: npt.NDArray[np.float64], row: int) -> str:
    """Plot a mean with its 95 % interval, and return both as text."""
    mean, (low, high) = values.mean(), mean_interval(values)
    ax.plot([low, high], [row, row], color=GREY, lw=2.5, solid_capstyle="butt")
    ax.plot(mean, row, "o", color=STYLES["ekf"].colour, ms=9)
    return f"{mean:.2f} (95 % from {low:.2f} to {high:.2f})"


def draw_funnel(
    label: Callable[[Any], Any], erase_background: Callable[[Any], Any], find_segments: Callable[[Any], Any]
) -> Drawing:
    """Draw how many true corners survive each step of the student's functions, in simulated and real pictures.

    Parameters
    ----------
    label, erase_background, find_segments : callable
        As for `count_corners`. If the real pictures are not installed, the solution's counts are shown.
    """
    steps = (label, erase_background, find_segments)
    simulated, real = tuning_pictures(), real_pictures()
    return draw_counts(
        {
            f"simulator, {len(simulated)} pictures": count_corners(simulated, *steps),
            "a real NAO, 8 pictures": count_corners(real, *steps) if real else REAL,
        }
    )


@course_style()
def draw_counts(funnels: Mapping[str, Mapping[str, int]]) -> Drawing:
    """Draw the counts after each step as funnels, one for each set of pictures, by its title."""
    figure = Figure(figsize=(9.9, 3.4))
    axes = figure.subplots(1, len(funnels), sharey=True, squeeze=False)[0]
    for ax, (name, counts) in zip(axes, funnels.items(), strict=True):
        whole = max(next(iter(counts.values())), 1)
        for row, left in enumerate(counts.values()):
            part = left / whole
            ax.barh(row, 1, left=-0.5, color="0.93")
            ax.barh(row, part, left=-part / 2, color=STYLES["ekf"].colour)
            ax.text(0.53, row, f"{left} ({part:.0%})", va="center", fontsize=10)
        ax.set_yticks(range(len(counts)), list(counts))
        ax.set(xticks=[], xlim=(-0.5, 0.85), ylim=(len(counts) - 0.5, -0.5))
        ax.set_title(name, fontsize=11)
        ax.spines[:].set_visible(False)
        ax.tick_params(left=False)
    said = "; ".join(
        f"{name}: {', '.join(f'{step} {left}' for step, left in counts.items())}"
        for name, counts in funnels.items()
    )
    return Drawing(figure, f"True corners that survive each step. {said}.")


def goal_line_left(
    distances: npt.ArrayLike,
    label: Callable[[Any], Any],
    erase_background: Callable[[Any, int], Any],
    runs: Sequence[int] = (7, 3),
) -> dict[int, list[float]]:
    """Measure the fraction of columns in which the goal line survives, by run and for each distance.

    The key 0 has the fractions without erasing.
    """
    pictures = goal_line_at(distances, Reality(seed=11))
    labels = [np.asarray(label(picture.pixels.copy())) for picture in pictures]
    both = list(zip(pictures, labels, strict=True))
    erased = {run: [picture.share(erase_background(each, run)) for picture, each in both] for run in runs}
    return {**erased, 0: [picture.share(each) for picture, each in both]}


@course_style()
def draw_goal_line(distances: npt.ArrayLike, left: Mapping[int, Sequence[float]]) -> Drawing:
    """Draw how much of the goal line survives erasing at each distance, and the limit from equation 3.2.

    Parameters
    ----------
    distances : array_like, shape (N,)
        Distance of the line from the point below the camera, metres.
    left : mapping of int to sequence of float
        The fractions that `goal_line_left` returns, by run; the key 0 has those without erasing.
    """
    far = np.arange(0.5, 20.0, 0.01)
    words = []
    figure = Figure(figsize=(7.6, 3.8))
    ax = figure.add_subplot()
    for (run, parts), source in zip(left.items(), ("ekf", "graph", "odometry"), strict=False):
        style, half = style_of(source), last_seen(distances, parts)
        name = f"run of {run}: measured" if run else "without erasing"
        marks: dict[str, Any] = {
            "marker": style.marker,
            "color": style.colour,
            "ms": 6,
            "ls": "-" if run else "--",
        }
        ax.plot(distances, parts, label=name, **marks)
        if not run:
            words.append(f"without erasing: {half:.1f} m")
            continue
        end = float(far[rows_between(far, BEHIND) < run][0])
        ax.axvline(end, color=style.colour, ls=":", lw=1.8)
        ax.annotate(f" equation 3.2:\n {end:.1f} m", (end, 1.1), fontsize=9, color=style.colour)
        words.append(f"run of {run}: {half:.1f} m measured, {end:.1f} m by equation 3.2")
    ax.set(
        xlabel="distance of the goal line (m)",
        ylabel="fraction of its columns that survives",
        ylim=(-0.04, 1.24),
        yticks=np.linspace(0, 1, 6),
    )
    legend_below(figure, ax.get_legend_handles_labels()[0])
    return Drawing(
        figure,
        f"Fraction of the goal line that survives, by distance. It falls to one half at: {'; '.join(words)}.",
    )


def last_seen(distances: npt.ArrayLike, parts: Sequence[float]) -> float:
    """Return the distance at which half of the line is left, metres; NaN if it never falls below one half."""
    x, y = np.asarray(distances, dtype=float), np.asarray(parts, dtype=float)
    below = np.flatnonzero(y < 0.5)
    if not len(below) or not below[0]:
        return float("nan")
    i = below[0]
    return float(x[i - 1] + (x[i] - x[i - 1]) * (y[i - 1] - 0.5) / (y[i - 1] - y[i]))
