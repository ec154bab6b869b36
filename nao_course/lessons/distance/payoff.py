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
from nao_course.plotting.legends import landmark_keys, legend_below
from nao_course.plotting.maps import plot_field, plot_landmarks
from nao_course.plotting.paths import plot_pose
from nao_course.plotting.pictures import plot_picture
from nao_course.plotting.style import HALO, LANDMARK_MARKERS, STYLES, course_style
from nao_course.sim import Field

POSE = Pose(0.95, 0.45, -0.12)
YAWS = {"head to the left": 0.62, "straight ahead": 0.0, "to the right": -0.62}
SHOWN_X, SHOWN_Y = (-0.4, 4.5), (-2.9, 3.2)  # m: whole ellipses
FARTHEST = 3.5  # m: farther marks are left out
ESTIMATE = STYLES["ekf"].colour


@cache
def payoff_pictures() -> tuple[MarkedPicture, ...]:
    """Take the three pictures; the same at every call."""
    return tuple(each.within(FARTHEST) for each in look_around(POSE, list(YAWS.values()), rng=3))


@course_style()
def draw_payoff(
    pixel_to_ground: Callable[..., Any],
    ground_to_measurement: Callable[..., Any],
    measurement_covariance: Callable[..., Any],
) -> Drawing:
    """Draw three pictures with their landmarks marked, and the map with a point and an ellipse for each mark.

    Parameters
    ----------
    pixel_to_ground, ground_to_measurement, measurement_covariance : callable
        The student's.

    Returns
    -------
    Drawing
        The figure; its text says how far the points are from the landmarks.
    """
    own = (pixel_to_ground, ground_to_measurement, measurement_covariance)
    errors: list[float] = []
    figure = Figure(figsize=(9.6, 8.6))
    grid = figure.add_gridspec(2, 3, height_ratios=[1, 2.1])
    above = figure.add_subplot(grid[1, :])
    plot_field(Field(2012), above)
    for column, (title, look) in enumerate(zip(YAWS, payoff_pictures(), strict=True)):
        ax = figure.add_subplot(grid[0, column])
        ax.set_title(title, fontsize=10)
        _plot_marks(look, ax)
        errors += _plot_points(look, above, *own)
    above.set(xlim=SHOWN_X, ylim=SHOWN_Y)
    plot_pose(POSE, above, "truth")
    ellipse = Line2D([], [], color=ESTIMATE, lw=1.4, label="95 % ellipse")
    robot = Line2D([], [], color=STYLES["truth"].colour, marker="o", ls="", ms=8, label="robot")
    legend_below(
        figure, [*landmark_keys(("corner", "post"), ESTIMATE, "measured"), ellipse, robot], columns=4
    )
    words = (
        f"Three pictures of the field with {len(errors)} corners and posts marked, and the map: each mark has become a "
        f"point with an ellipse that grows with the distance. The points are {np.median(errors):.2f} m from their "
        f"landmarks in the median, {max(errors):.2f} m at most."
    )
    return Drawing(figure, words, photo=True)


def _plot_marks(look: MarkedPicture, ax: Axes) -> None:
    """Draw a picture with its marks."""
    plot_picture(look.pixels, ax, ticks=False)
    for kind, (u, v) in zip(look.kinds, look.marks, strict=True):
        marker = LANDMARK_MARKERS[kind]
        ax.plot(u, v, marker, color=ESTIMATE, mfc="none", ms=9, mew=1.9, path_effects=HALO)


def _plot_points(
    look: MarkedPicture, ax: Axes, to_ground: Function, to_measurement: Function, covariance: Function
) -> list[float]:
    """Draw the marks as points with ellipses, and return their distances from the landmarks in m."""
    ground = np.asarray(to_ground(look.marks.copy(), look.view), dtype=float)
    measured = np.asarray(to_measurement(ground.copy()), dtype=float)
    full = np.asarray(covariance(look.marks.copy(), look.view, PIXEL_SIGMA, TILT_SIGMA), dtype=float)
    outlines = polar_outlines(measured, full)
    in_world = POSE.to_parent(outlines.reshape(-1, 2)).reshape(outlines.shape)
    ax.add_collection(filled_outlines(in_world, ESTIMATE))
    points = POSE.to_parent(ground)
    plot_landmarks(points, look.kinds, ax, ESTIMATE)
    return [float(each) for each in np.linalg.norm(points - look.landmarks, axis=1)]


def polar_outlines(measurements: FloatArray, covariance: FloatArray, probability: float = 0.95) -> FloatArray:
    """Return outlines (k, corners, 2), robot frame, m, of the ellipses of measurements (k, 2), (bearing, range).

    The covariance (2k, 2k) is in the order bearing, range, bearing, range, ...; each landmark's own block is drawn.
    """
    k = len(measurements)
    blocks = np.array([covariance[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] for i in range(k)]).reshape(-1, 2, 2)
    bearing, away = np.moveaxis(ellipse_outlines(measurements, blocks, probability), 2, 0)
    return np.stack([away * np.cos(bearing), away * np.sin(bearing)], axis=2)
