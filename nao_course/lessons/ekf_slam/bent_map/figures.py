"""Figures of a map that bends, and of the measurements that find the filter's two bugs."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.geometry import FloatArray, pose_errors
from nao_course.lessons.ekf_slam.bent_map.runs import (
    ONE_ERROR,
    SAMPLES,
    TEST_CONTROL,
    TWO_ERRORS,
    FilterRun,
    bent_drive,
    covariance_differences,
    recorded_run,
    recorded_test,
    run_filter,
    sampled_covariance,
    scaled_difference,
)
from nao_course.lessons.ekf_slam.consistency import NOISY
from nao_course.lessons.ekf_slam.film import plot_blocks
from nao_course.metrics import band
from nao_course.plotting import STYLES, Drawing, course_style, ellipse_outlines
from nao_course.plotting.legends import legend_below
from nao_course.plotting.maps import metric_axes
from nao_course.plotting.style import GREY
from nao_course.sim.drives import Function

WRONG, RIGHT = STYLES["odometry"].colour, STYLES["ekf"].colour
MAP_SIZE = 5.6, 5.4  # inches: width and height of a map, so that all maps have one scale
LOWEST, HIGHEST = 0.1, 1e4  # of the axis that shows NEES
SCATTER = (
    0.03  # of the samples' covariance, divided by both standard deviations: smaller differences are white
)

# --- the map ---


@course_style()
def draw_bent_map(
    predict: Function | None = None,
    update_landmarks: Function | None = None,
    add_landmark: Function | None = None,
) -> Drawing:
    """Draw the map of the filter with two bugs, and beside it its innovations or the student's map of the same drive.

    Parameters
    ----------
    predict, update_landmarks, add_landmark : callable, optional
        The student's.

    Returns
    -------
    Drawing
        True and estimated path and landmarks; without functions the recorded filter's and its bearing innovations.
    """
    runs = {"The filter with two bugs": (recorded_run(TWO_ERRORS), WRONG)}
    if predict and update_landmarks and add_landmark:
        runs["Your filter"] = run_filter((predict, update_landmarks, add_landmark)), RIGHT
    return _draw_maps(runs)


def _draw_maps(runs: dict[str, tuple[FilterRun, str]]) -> Drawing:
    figure = Figure(figsize=(2 * MAP_SIZE[0], MAP_SIZE[1]))
    axes = figure.subplots(1, 2)
    if len(runs) == 1:
        steps, values = recorded_run(TWO_ERRORS).bearings.T
        _plot_bearings(axes[1], steps, values, WRONG)
        axes[1].set_title("Its bearing innovations")
    for ax, (title, (run, colour)) in zip(axes, runs.items(), strict=False):
        _plot_map(ax, run, colour)
        low, high = band(run.landmarks.size, 1)
        nees = "" if run.map_nees is None else f", NEES {run.map_nees:.1f} ({low:.1f} to {high:.1f})"
        ax.set_title(f"{title}: {100 * run.map_error:.0f} cm off{nees}")
    legend_below(figure, _map_keys([colour for _, colour in runs.values()]), columns=2)
    said = [f"{title}. {_say_run(run)}" for title, (run, _) in runs.items()]
    if len(runs) == 1:
        said.append(_say_bearings(recorded_run(TWO_ERRORS).bearings))
    return Drawing(figure, " ".join(said))


def _map_keys(colours: list[str]) -> list[Any]:
    truth = STYLES["truth"].colour
    return [
        Line2D([], [], color=truth, marker="o", ms=4, lw=1.2, label="true path and landmarks"),
        *(
            Line2D([], [], color=colour, marker="+", ms=9, mew=1.6, lw=1.6, label=f"estimated, {whose}")
            for colour, whose in zip(colours, ("recorded filter", "yours"), strict=False)
        ),
        Line2D([], [], color=GREY, lw=1.0, ls=":", label="error of a landmark"),
    ]


def _plot_map(ax: Axes, run: FilterRun, colour: str) -> None:
    truth = bent_drive().poses
    ax.plot(*truth[:, :2].T, color=STYLES["truth"].colour, lw=1.2)
    ax.plot(*run.true_landmarks.T, "o", color=STYLES["truth"].colour, ms=4, zorder=4)
    ax.plot(*run.path[:, :2].T, color=colour, lw=1.4)
    ax.plot(*run.landmarks.T, "+", color=colour, ms=9, mew=1.6, zorder=5)
    for estimate, true in zip(run.landmarks, run.true_landmarks, strict=True):
        ax.plot(*np.array([estimate, true]).T, ":", color=GREY, lw=1.0)
    is_covariance = np.linalg.eigvalsh(run.landmark_covariances).min(axis=1) > 0
    outlines = ellipse_outlines(run.landmarks[is_covariance], run.landmark_covariances[is_covariance])
    ax.add_collection(
        PolyCollection(list(outlines), facecolors=[to_rgba(colour, 0.07)], edgecolors=[to_rgba(colour, 0.9)])
    )
    metric_axes(
        ax, np.vstack([truth[:, :2], run.true_landmarks, recorded_run(TWO_ERRORS).landmarks]), margin=0.3
    )


def _say_run(run: FilterRun) -> str:
    drive = bent_drive()
    off = pose_errors(run.path[-1], drive.steps[-1].pose)
    return (
        f"Two circles past {len(run.landmarks)} landmarks. At the end the landmarks are {100 * run.map_error:.0f} cm "
        f"off on average, the position {100 * np.hypot(*off[:2]):.0f} cm off and the heading "
        f"{abs(np.degrees(off[2])):.0f} degrees off."
        + (f" The NEES of the map is {run.map_nees:.1f}." if run.map_nees is not None else "")
    )


# --- the first measurement: innovations ---


@course_style()
def draw_bearings(warp2pi: Any = None) -> Drawing:
    """Draw the bearing innovations of the filter with two bugs.

    Parameters
    ----------
    warp2pi : callable, optional
        The student's; a second plot shows the innovations of the filter that wraps them with it.

    Returns
    -------
    Drawing
        A point for each measurement, in degrees.
    """
    shown = {"The filter with two bugs": (*recorded_run(TWO_ERRORS).bearings.T, WRONG)}
    if warp2pi is not None:
        steps, values = recorded_run(ONE_ERROR).bearings.T
        shown["The same filter with your warp2pi"] = (
            steps,
            np.asarray(warp2pi(values.copy()), dtype=float),
            RIGHT,
        )
    figure = Figure(figsize=(8.4, 3.4 * len(shown)))
    axes = figure.subplots(len(shown), 1, squeeze=False)[:, 0]
    for ax, (title, (steps, values, colour)) in zip(axes, shown.items(), strict=True):
        _plot_bearings(ax, steps, values, colour)
        ax.set_title(title)
    largest = {
        title: int(np.degrees(np.abs(values).max()).round()) for title, (_, values, _) in shown.items()
    }
    return Drawing(
        figure,
        "Measured minus expected bearing of each measurement by step. "
        + "; ".join(f"{title}: at most {size} degrees" for title, size in largest.items())
        + ".",
    )


def _say_bearings(bearings: FloatArray) -> str:
    """Say in which steps a bearing innovation first exceeds half a turn, and how large the largest one is."""
    steps, values = bearings[np.abs(bearings[:, 1]) > np.pi].T
    return (
        f"The bearing innovations, measured minus expected, exceed half a turn in {len(set(steps))} steps, "
        f"first in step {steps[0]:.0f} with {np.degrees(values[0]):.0f} degrees."
    )


def _plot_bearings(ax: Axes, steps: FloatArray, values: FloatArray, colour: str) -> None:
    ax.plot(steps, np.degrees(values), "o", ms=3.5, color=colour)
    ax.axhline(0, color=GREY, lw=1, ls="--")
    ax.set(xlabel="step", ylabel="bearing innovation (deg)", ylim=(-400, 400), yticks=range(-360, 361, 180))


# --- the second measurement: NEES, and a covariance beside samples ---


@course_style()
def draw_second_error() -> Drawing:
    """Draw map and pose NEES of the filter after its first bug is fixed."""
    run = recorded_run(ONE_ERROR)
    low, high = band(3, 1)
    figure = Figure(figsize=(2 * MAP_SIZE[0], MAP_SIZE[1]))
    left, right = figure.subplots(1, 2)
    _plot_map(left, run, WRONG)
    heading = abs(np.degrees(pose_errors(run.path[-1], bent_drive().steps[-1].pose)[2]))
    left.set_title(f"One bug left: {100 * run.map_error:.0f} cm off, heading {heading:.0f}°")
    steps = np.arange(1, len(run.nees) + 1)
    negative = run.nees < 0
    right.axhspan(low, high, color="#e3e5e8", label="95 % band of one step")
    right.plot(
        steps, np.where(negative, np.nan, run.nees), "-o", ms=3.5, lw=1.2, color=WRONG, label="pose NEES"
    )
    right.plot(
        steps[negative], np.full(negative.sum(), LOWEST * 1.3), "x", color="#c0392b", label="negative NEES"
    )
    right.set(xlabel="step", ylabel="pose NEES", yscale="log", ylim=(LOWEST, HIGHEST), xlim=(1, len(steps)))
    right.legend(fontsize=9, loc="upper left")
    right.set_title("Three degrees of freedom")
    legend_below(figure, _map_keys([WRONG]), columns=2)
    return Drawing(
        figure,
        f"{_say_run(run)} The NEES of one pose should lie between {low:.1f} and {high:.1f} in 95 % of all steps. It is "
        f"above the band in {int((run.nees > high).sum())} of {len(steps)} steps and negative in "
        f"{int(negative.sum())}; its largest value is {run.nees.max():.0f}. "
        "Ellipses are left out where a landmark's covariance is not valid.",
    )


@course_style()
def draw_covariance_test(predict: Function | None = None) -> Drawing:
    """Draw a filter's covariance after a motion beside the covariance of many sampled robots.

    Parameters
    ----------
    predict : callable, optional
        The student's; without it, the filter that has one error left.

    Returns
    -------
    Drawing
        Covariances of the filter, of the samples, and their difference, white where it is at most `SCATTER`.
    """
    test = recorded_test()
    if predict is None:
        title, covariance = "The filter", np.array(test["predicted"])
    else:
        state, before = np.array(test["state"]), np.array(test["covariance"])
        answer = predict(state, before, TEST_CONTROL.copy(), NOISY.control_covariance, (len(state) - 3) // 2)
        title, covariance = "Your predict", np.array(answer[1], dtype=float)
    sampled = sampled_covariance()
    sigma = np.sqrt(np.diag(sampled))
    largest, difference = covariance_differences(covariance), scaled_difference(covariance)
    shown = {
        title: covariance / np.outer(sigma, sigma),
        f"{SAMPLES:,} sampled robots": sampled / np.outer(sigma, sigma),
        f"Difference, at most {max(largest.values()):.2f}\n(white: up to {SCATTER})": np.where(
            np.abs(difference) <= SCATTER, 0.0, difference
        ),
    }
    figure = Figure(figsize=(11.0, 4.2))
    axes = figure.subplots(1, len(shown))
    for ax, (name, matrix) in zip(axes, shown.items(), strict=True):
        image = plot_blocks(ax, matrix)
        ax.set_title(name)
    figure.colorbar(
        image, ax=list(axes), label="divided by both standard deviations", shrink=0.9, ticks=[-1, 0, 1]
    )
    return Drawing(
        figure,
        "Covariance after a motion of 1 m, divided by both standard deviations: of the filter, of the samples, and the "
        "difference. Largest difference: "
        + ", ".join(f"{name} {value:.2f}" for name, value in largest.items())
        + ".",
    )
