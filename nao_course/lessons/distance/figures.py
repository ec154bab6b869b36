"""Figures of lesson 04 on the geometry: what the paper's formulas, the lens and a tilt do over a whole picture."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import TwoSlopeNorm
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from nao_course.geometry import FloatArray
from nao_course.lessons.distance.looks import Function, measure_pixels, rows_of_two, usual_view
from nao_course.plotting.drawing import Drawing
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import GREY, STYLES, course_style
from nao_course.sim import CameraView

PAPER, TRUTH = STYLES["odometry"].colour, STYLES["truth"].colour


@course_style()
def draw_paper_error(
    paper_distance: Function,
    paper_bearing: Function,
    pixel_to_ground: Function,
    ground_to_measurement: Function,
) -> Drawing:
    """Draw, over a whole picture, the paper's formulas minus the exact geometry: distance and bearing.

    The camera looks ahead without lens term, roll or offset, so that only the formulas differ.

    Parameters
    ----------
    paper_distance, paper_bearing, pixel_to_ground, ground_to_measurement : callable
        The student's.

    Returns
    -------
    Drawing
        The figure; its text has numbers of a few places.
    """
    view = replace(usual_view(lens=False), offset=(0.0, 0.0))
    width, height = view.size
    u, v = np.meshgrid(np.linspace(0, width - 1, 81), np.linspace(0, height - 1, 121))
    pixels = np.column_stack([u.ravel(), v.ravel()])
    exact = measure_pixels(pixel_to_ground, ground_to_measurement, pixels, view)
    exact[exact[:, 1] > 8.0] = np.nan  # near the horizon a distance is useless anyway
    distance = (np.asarray(paper_distance(pixels, view)) - exact[:, 1]).reshape(u.shape)
    bearing = np.degrees(np.asarray(paper_bearing(pixels, view)) - exact[:, 0]).reshape(u.shape)
    figure = Figure(figsize=(9.9, 4.3))
    left, right = figure.subplots(1, 2, sharey=True)
    _plot_difference(left, (u, v), 100 * distance, [-100, -50, -20, -10, -3, 0, 3, 10, 20, 50], "cm")
    left.set_title("distance: paper minus exact (cm)", fontsize=11)
    left.set_ylabel("v (px)")
    _plot_difference(right, (u, v), bearing, [-12, -9, -6, -3, -1, 0, 1, 3, 6, 9, 12], "°")
    right.set_title("bearing: paper minus exact (degrees)", fontsize=11)
    for ax in (left, right):
        rows = ax.contour(
            u, v, exact[:, 1].reshape(u.shape), [1, 2, 3, 4, 5], colors=GREY, linestyles=":", linewidths=1.2
        )
        ax.clabel(rows, fmt="%g m", fontsize=8)
        ax.set(xlabel="u (px)", facecolor="#e3e5e8", xlim=(0, width - 1), ylim=(height - 1, 0))
    keys = [
        Line2D([], [], color=GREY, ls=":", label="true distance"),
        Patch(facecolor="#e3e5e8", label="beyond 8 m, and sky"),
    ]
    legend_below(figure, keys)
    words = []
    for away in (1.0, 2.0, 4.0):
        row = int(np.nanargmin(np.abs(exact[:, 1].reshape(u.shape)[:, 40] - away)))
        words.append(f"{100 * distance[row, 40]:+.0f} cm at {away:g} m ahead")
    corner = f"{bearing[-1, -1]:+.0f} degrees in the lower right corner"
    return Drawing(
        figure, f"The paper's distance minus the exact one: {', '.join(words)}. Its bearing: {corner}."
    )


def _plot_difference(
    ax: Axes, places: tuple[FloatArray, FloatArray], values: FloatArray, levels: Sequence[float], unit: str
) -> None:
    norm = TwoSlopeNorm(0.0, min(levels), max(levels))
    filled = np.clip(values, min(levels), max(levels))
    ax.contourf(*places, filled, sorted(levels), cmap="RdBu_r", norm=norm, extend="both", alpha=0.8)
    lines = ax.contour(*places, values, sorted(levels), colors=TRUTH, linewidths=0.8)
    ax.clabel(lines, fmt=lambda value: f"{value:g}{'' if unit == 'cm' else unit}", fontsize=9)


@course_style()
def draw_arrows(
    methods: Mapping[str, Callable[[FloatArray, CameraView], Any]], view: CameraView, longer: float = 2.0
) -> Drawing:
    """Draw arrows from true points on the ground to the points that each method computes.

    Parameters
    ----------
    methods : mapping of str to callable
        By title: ``method(pixels, view)`` gives (bearing, range), shape (N, 2).
    view : CameraView
        Of the camera.
    longer : float
        Factor by which the arrows are longer than the errors.

    Returns
    -------
    Drawing
        The figure; its text gives the median and the largest error of each method.
    """
    points = _grid_in_view(view)
    pixels = view.project(points)
    said = []
    figure = Figure(figsize=(9.9, 5.3))
    for ax, (title, method) in zip(
        figure.subplots(1, len(methods), sharex=True, sharey=True, squeeze=False)[0],
        methods.items(),
        strict=True,
    ):
        bearing, away = rows_of_two(title, method(pixels.copy(), view), len(pixels)).T
        ends = np.column_stack([away * np.cos(bearing), away * np.sin(bearing)])
        shift = ends - points
        true_length: dict[str, Any] = {"angles": "xy", "scale_units": "xy", "scale": 1 / longer}
        arrows = points[:, 1], points[:, 0], shift[:, 1], shift[:, 0]
        ax.quiver(*arrows, **true_length, color=PAPER, width=0.006, zorder=3)
        ax.plot(points[:, 1], points[:, 0], "o", color=TRUTH, ms=3.5, zorder=4)
        ax.plot(0, 0, "^", color=TRUTH, ms=9)
        ax.set(aspect="equal", xlim=(2.3, -2.3), ylim=(-0.2, 5.4), xlabel="y, to the left (m)")
        ax.grid(color="#e3e5e8")
        ax.set_title(title, fontsize=11)
        size = np.hypot(*shift.T)
        said.append(f"{title}: {np.median(size):.2f} m in the median, {size.max():.2f} m at most")
    figure.axes[0].set_ylabel("x, ahead (m)")
    keys = [
        Line2D([], [], color=TRUTH, marker="o", ls="", ms=4, label="true position"),
        Line2D([], [], color=PAPER, lw=2, label=f"error of the position, {longer:g} times as long"),
        Line2D([], [], color=TRUTH, marker="^", ls="", ms=8, label="robot"),
    ]
    legend_below(figure, keys)
    return Drawing(
        figure,
        f"Points on the ground in front of the robot, and arrows towards their computed positions. {'. '.join(said)}.",
    )


def _grid_in_view(view: CameraView) -> FloatArray:
    """Return visible points (N, 2) on rings in the robot frame."""
    rings = np.array([1.0, 2.0, 3.0, 4.0])  # far enough apart that no arrow reaches the next ring
    away, bearing = np.meshgrid(rings, np.radians(np.arange(-40, 41, 8)))
    points = np.column_stack([(away * np.cos(bearing)).ravel(), (away * np.sin(bearing)).ravel()])
    return points[view.contains(view.project(points))]
