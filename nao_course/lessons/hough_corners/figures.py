"""Figures of lesson 03: segments in a picture, what detectors cost, and where true corners are lost."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray, as_points
from nao_course.lessons.hough_corners.scenes import three_places
from nao_course.plotting import STYLES, Drawing, course_style, plot_picture
from nao_course.plotting.drawing import say_count
from nao_course.plotting.style import GREY, HALO

CORNER = "#ff3b81"  # of what was found, as in lesson 02
SEGMENTS = ("#0072b2", "#d55e00", "#7a2cff", "#000000")

# Measured on the 30 pictures of standard_scenes("tune"): mean cost, both ends of its 95 % bootstrap interval, then
# hits, false and missed corners.
COSTS = {
    "nothing": (2.03, 1.63, 2.43, 0, 0, 61),
    "the paper's, endless lines": (4.23, 2.79, 5.76, 21, 23, 40),
    "the paper's, without erasing": (2.72, 1.36, 4.38, 19, 13, 42),
    "the paper's, 5 px longer": (1.28, 0.42, 2.19, 14, 2, 47),
}
# The same pictures: of the 61 true corners, how many are left after each step.
FUNNEL = {
    "in the picture": 61,
    "white within 3 px": 61,
    "still there after erasing": 49,
    "a segment within 6 px": 36,
    "two that are not parallel": 12,
}


def draw_segments(
    picture: npt.ArrayLike, segments: npt.ArrayLike, corners: npt.ArrayLike | None = None, title: str = ""
) -> Drawing:
    """Draw segments over a picture, and rings at corners.

    Parameters
    ----------
    picture : array_like of uint8, shape (H, W, 3)
        RGB.
    segments : array_like, shape (N, 4)
        (u1, v1, u2, v2) of each, pixels.
    corners : array_like, shape (K, 2), optional
        (u, v) of each, pixels.
    title : str
        Above the figure.

    Returns
    -------
    Drawing
        The figure; its text counts both and lists the corners.
    """
    points = as_points(np.zeros((0, 2)) if corners is None else corners, name="corners (u, v)")
    with course_style():
        figure = Figure(figsize=(6.4, 5.0))
        ax = figure.add_subplot()
        lines = _plot_segments(ax, picture, segments, points)
        ax.set_title(title, fontsize=11)
    said = "" if corners is None else f" and {_say_corners(points)}"
    return Drawing(figure, f"A picture with {say_count(lines, 'segment')}{said}.", photo=True)


def draw_places(segments_of: Callable[[Any], Any], corners_of: Callable[[Any], Any]) -> Drawing:
    """Draw three pictures side by side, with what `segments_of(pixels)` and `corners_of(pixels)` find in each."""
    words = []
    with course_style():
        figure = Figure(figsize=(9.9, 3.1))
        for number, (title, pixels) in enumerate(three_places().items(), start=1):
            ax = figure.add_subplot(1, 3, number)
            points = as_points(corners_of(pixels.copy()), name="corners (u, v)")
            lines = _plot_segments(ax, pixels, segments_of(pixels.copy()), points)
            ax.set_title(title, fontsize=11)
            words.append(f"{title}: {say_count(lines, 'segment')} and {_say_corners(points)}")
    return Drawing(
        figure, f"Three pictures with segments and the corners found. {'; '.join(words)}.", photo=True
    )


def _plot_segments(ax: Axes, picture: npt.ArrayLike, segments: npt.ArrayLike, points: FloatArray) -> int:
    """A picture with segments and rings at points; returns how many segments."""
    plot_picture(np.asarray(picture), ax, ticks=False)
    lines = np.asarray(segments, dtype=float).reshape(-1, 4)
    for i, (u1, v1, u2, v2) in enumerate(lines):
        ax.plot([u1, u2], [v1, v2], color=SEGMENTS[i % len(SEGMENTS)], lw=1.8, path_effects=HALO)
    for colour, width in (("white", 4.6), (CORNER, 2.4)):
        ax.plot(*points.T, "o", color=colour, mfc="none", ms=14, mew=width)
    return len(lines)


def _say_corners(points: FloatArray) -> str:
    """Such as "1 corner at (3, 4)"."""
    where = ", ".join(f"({u:.0f}, {v:.0f})" for u, v in points)
    return say_count(len(points), "corner") + (f" at {where}" if where else "")


def draw_costs() -> Drawing:
    """Draw what detectors cost on the tuning pictures, each with its 95 % interval and its counts."""
    with course_style():
        figure = Figure(figsize=(8.2, 3.4))
        ax = figure.add_subplot()
        for row, (cost, low, high, hits, false, missed) in enumerate(COSTS.values()):
            ax.plot([low, high], [row, row], color=GREY, lw=2.5)
            ax.plot(cost, row, "o", color=STYLES["ekf"].colour, ms=9)
            words = f"{hits} found, {false} false, {missed} missed"
            ax.annotate(words, (cost, row), (0, 9), textcoords="offset points", ha="center", fontsize=9)
        ax.axvline(COSTS["nothing"][0], color=STYLES["odometry"].colour, ls=":", lw=1.6)
        ax.set_yticks(range(len(COSTS)), list(COSTS))
        ax.set(xlabel="mean cost of a picture, less is better", ylim=(len(COSTS) - 0.5, -0.7))
    said = "; ".join(
        f"{name}: {cost:.2f}, 95 % from {low:.2f} to {high:.2f}"
        for name, (cost, low, high, *_) in COSTS.items()
    )
    return Drawing(figure, f"Mean cost of a picture. {said}.")


def draw_funnel() -> Drawing:
    """Draw how many of the true corners are left after each step of the paper's method."""
    whole = next(iter(FUNNEL.values()))
    with course_style():
        figure = Figure(figsize=(8.2, 3.4))
        ax = figure.add_subplot()
        for row, left in enumerate(FUNNEL.values()):
            ax.barh(row, whole, left=-whole / 2, color="0.93")
            ax.barh(row, left, left=-left / 2, color=STYLES["ekf"].colour)
            ax.text(whole / 2 + 1, row, f"{left} ({left / whole:.0%})", va="center", fontsize=10)
        ax.set_yticks(range(len(FUNNEL)), list(FUNNEL))
        ax.set(xticks=[], xlim=(-whole / 2, whole * 0.68), ylim=(len(FUNNEL) - 0.5, -0.5))
        for side in ("top", "right", "bottom", "left"):
            ax.spines[side].set_visible(False)
    said = ", ".join(f"{name} {left}" for name, left in FUNNEL.items())
    return Drawing(figure, f"True corners that are left after each step: {said}.")
