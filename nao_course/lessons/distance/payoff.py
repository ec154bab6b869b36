"""The payoff of lesson 04: marks in three pictures as points on the map with their covariances."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.distance.looks import PIXEL_SIGMA, TILT_SIGMA, Function, MarkedPicture, look_around
from nao_course.plotting.drawing import Drawing
from nao_course.plotting.ellipses import ellipse_outlines, filled_outlines
from nao_course.plotting.halo import HALO
from nao_course.plotting.legends import landmark_keys, legend_below
from nao_course.plotting.maps import plot_field, plot_landmarks
from nao_course.plotting.paths import plot_pose
from nao_course.plotting.pictures import plot_picture
from nao_course.plotting.style import LANDMARK_MARKERS, STYLES, course_style
from nao_course.sim import Field

POSE = Pose(0.95, 0.45, -0.12)
YAWS = {"head to the left": 0.62, "straight ahead": 0.0, "to the right": -0.62}
SHOWN_X, SHOWN_Y = (-0.4, 4.5), (-2.9, 3.2)  # m: whole ellipses
FARTHEST = 3.5  # m: farther marks are left out
COLOURS = ("#0b7d74", "#8e3fa8", "#b35c00")  # of the three pictures; none is a colour of a path
TRUE = STYLES["truth"].colour


@cache
def payoff_pictures() -> tuple[MarkedPicture, ...]:
    """Take the three pictures; the same at every call."""
    return tuple(each.within(FARTHEST) for each in look_around(POSE, list(YAWS.values()), rng=3))


@course_style()
def draw_payoff(
    pixel_to_ground: Callable[..., Any],
    ground_to_measurement: Callable[..., Any],
    measurement_covariance: Callable[..., Any],
    estimate_pitch: Callable[..., Any],
) -> Drawing:
    """Draw three pictures with marks, their points with ellipses on the map, and the points without each one's tilt.

    Parameters
    ----------
    pixel_to_ground, ground_to_measurement, measurement_covariance, estimate_pitch : callable
        The student's.

    Returns
    -------
    Drawing
        The figure; its text says how far the points are from the landmarks, before and after.
    """
    figure = Figure(figsize=(9.6, 8.4))
    grid = figure.add_gridspec(2, 6, height_ratios=[1, 2.1])
    maps = figure.add_subplot(grid[1, :3]), figure.add_subplot(grid[1, 3:])
    errors: tuple[list[float], list[float]] = ([], [])
    tilts = []
    for column, (title, look) in enumerate(zip(YAWS, payoff_pictures(), strict=True)):
        ax, colour = figure.add_subplot(grid[0, 2 * column : 2 * column + 2]), COLOURS[column]
        ax.set_title(title, fontsize=10, color=colour, weight="bold")
        _plot_marks(look, ax, colour)
        own = POSE.to_local(look.landmarks)
        tilt = float(estimate_pitch(look.marks.copy(), own, look.view))
        tilts.append(np.degrees(tilt))
        _plot_ellipses(look, maps[0], colour, pixel_to_ground, ground_to_measurement, measurement_covariance)
        for each, ax, turned in zip(errors, maps, (look, look.with_tilt(-tilt)), strict=True):
            each += _plot_points(turned, ax, colour, pixel_to_ground)
    for ax, title in zip(
        maps, ("with the assumed tilt, and 95 % ellipses", "after one angle for each picture"), strict=True
    ):
        plot_field(Field(2012), ax)
        ax.set(xlim=SHOWN_X, ylim=SHOWN_Y)
        ax.set_title(title, fontsize=10)
        plot_pose(POSE, ax, "truth")
        seen = [place for look in payoff_pictures() for place in look.landmarks.tolist()]
        ax.plot(*np.transpose(seen), "o", mfc="none", mec=TRUE, ms=11, mew=1.1, ls="")
    robot = Line2D([], [], color=TRUE, marker="o", ls="", ms=8, label="robot")
    true = Line2D([], [], mec=TRUE, mfc="none", marker="o", ls="", ms=10, label="true landmark")
    legend_below(figure, [*landmark_keys(("corner", "post"), "#555555", "measured"), true, robot], columns=4)
    before, after = errors
    words = (
        f"Three pictures of the field with {len(before)} corners and posts marked, each picture in its own colour. On "
        f"the left map each mark has become a point with an ellipse that grows with the distance; the points are "
        f"{np.median(before):.2f} m from their landmarks in the median, {max(before):.2f} m at most. On the right map "
        f"each picture was turned by one angle ({', '.join(f'{each:.1f}' for each in tilts)} degrees), and its points "
        f"are {np.median(after):.2f} m off in the median, {max(after):.2f} m at most."
    )
    return Drawing(figure, words, photo=True)


def _plot_marks(look: MarkedPicture, ax: Axes, colour: str) -> None:
    """Draw a picture with its marks."""
    plot_picture(look.pixels, ax, ticks=False)
    for kind, (u, v) in zip(look.kinds, look.marks, strict=True):
        marker = LANDMARK_MARKERS[kind]
        ax.plot(u, v, marker, color=colour, mfc="none", ms=9, mew=1.9, path_effects=HALO)


def _plot_points(look: MarkedPicture, ax: Axes, colour: str, to_ground: Function) -> list[float]:
    """Draw the marks as points on the map, and return their distances from the landmarks in m."""
    points = POSE.to_parent(np.asarray(to_ground(look.marks.copy(), look.view), dtype=float))
    plot_landmarks(points, look.kinds, ax, colour)
    return [float(each) for each in np.linalg.norm(points - look.landmarks, axis=1)]


def _plot_ellipses(
    look: MarkedPicture,
    ax: Axes,
    colour: str,
    to_ground: Function,
    to_measurement: Function,
    covariance: Function,
) -> None:
    """Draw the ellipse of each mark on the map."""
    measured = np.asarray(to_measurement(to_ground(look.marks.copy(), look.view)), dtype=float)
    full = np.asarray(covariance(look.marks.copy(), look.view, PIXEL_SIGMA, TILT_SIGMA), dtype=float)
    outlines = polar_outlines(measured, full)
    in_world = POSE.to_parent(outlines.reshape(-1, 2)).reshape(outlines.shape)
    ax.add_collection(filled_outlines(in_world, colour))


def polar_outlines(measurements: FloatArray, covariance: FloatArray, probability: float = 0.95) -> FloatArray:
    """Return outlines (k, corners, 2), robot frame, m, of the ellipses of measurements (k, 2), (bearing, range).

    The covariance (2k, 2k) is in the order bearing, range, bearing, range, ...; each landmark's own block is drawn.
    """
    k = len(measurements)
    blocks = np.array([covariance[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] for i in range(k)]).reshape(-1, 2, 2)
    bearing, away = np.moveaxis(ellipse_outlines(measurements, blocks, probability), 2, 0)
    return np.stack([away * np.cos(bearing), away * np.sin(bearing)], axis=2)
