"""Figures of lesson 04's challenge: lines under the assumed and the true tilt, and an entry's worst pictures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.challenges import Run
from nao_course.geometry import FloatArray
from nao_course.lessons.distance.lines import LinePicture, line_picture_of
from nao_course.lessons.distance.looks import rows_of_two
from nao_course.plotting.drawing import Drawing
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import STYLES, course_style
from nao_course.sim import CameraView, Field

SHOWN = 3
LINES, ANSWER = STYLES["odometry"].colour, STYLES["ekf"].colour
EXAMPLE = 48  # seed of a picture with a visible tilt


@course_style()
def draw_tilted_lines(pixel_to_ground: Callable[..., Any]) -> Drawing:
    """Draw the segments of a picture, and their projections to the ground with the assumed and the true tilt.

    Parameters
    ----------
    pixel_to_ground : callable
        The student's.

    Returns
    -------
    Drawing
        The figure; its text gives the angles between the lines.
    """
    scene = line_picture_of(EXAMPLE)
    views = {"assumed pitch and roll": scene.view, "true pitch and roll": scene.true_view}
    said = []
    figure = Figure(figsize=(9.9, 3.7))
    first, second, third = figure.subplots(1, 3, width_ratios=[1.2, 1, 1])
    _plot_segments(first, scene.segments, scene.view)
    first.set_title("segments in the picture", fontsize=11)
    for ax, (title, view) in zip((second, third), views.items(), strict=True):
        ends = scene.segments.reshape(-1, 2)
        ground = rows_of_two("pixel_to_ground", pixel_to_ground(ends, view), len(ends)).reshape(-1, 2, 2)
        for (x1, y1), (x2, y2) in ground:
            ax.plot([y1, y2], [x1, x2], color=LINES, lw=2.4)
        off = _off_right_angles(ground)
        ax.set(aspect="equal", xlabel="y, to the left (m)", xlim=(1.7, -2.0), ylim=(1.2, 4.7))
        ax.grid(color="#e3e5e8")
        ax.set_title(f"{title}: {off:.1f}° off", fontsize=11)
        said.append(f"{title}: {off:.1f} degrees off right angles")
    second.set_ylabel("x, ahead (m)")
    tilt = np.degrees(scene.true_view.pitch - scene.view.pitch)
    return Drawing(
        figure,
        f"{len(scene.segments)} segments of field lines; the tilt is {tilt:+.1f} degrees. {'. '.join(said)}.",
    )


def _off_right_angles(ground: FloatArray) -> float:
    """Return the largest deviation (degrees) of segments (N, 2, 2) from right angles with the longest one."""
    way = ground[:, 1] - ground[:, 0]
    direction = np.degrees(np.arctan2(way[:, 1], way[:, 0]))
    apart = direction - direction[np.linalg.norm(way, axis=1).argmax()]
    return float(np.abs((apart + 45) % 90 - 45).max())


@course_style()
def draw_worst_tilts(run: Run) -> Drawing:
    """Draw the pictures with the largest errors: segments, and the field lines under the answer's tilt."""
    worst = sorted((each for each in run.results if each.kept), key=lambda each: -each.score)[:SHOWN]
    figure = Figure(figsize=(9.9, 3.4))
    for number, each in enumerate(worst, start=1):
        scene, estimate = each.kept
        ax = figure.add_subplot(1, SHOWN, number)
        answered = _tilted(scene, estimate)
        for points in _field_lines():
            ax.plot(*answered.project(points, scene.pose).T, color=ANSWER, lw=1.4, ls="--")
        _plot_segments(ax, scene.segments, scene.view)
        ax.set_title(f"{each.name}: {each.score:.1f}°, sigma {np.degrees(estimate.sigma):.1f}°", fontsize=11)
    keys = [
        Line2D([], [], color=LINES, lw=2.4, label="segments given"),
        Line2D([], [], color=ANSWER, ls="--", label="the field with your tilt"),
    ]
    legend_below(figure, keys)
    said = ", ".join(f"{each.name} with {each.score:.2f} degrees" for each in worst)
    return Drawing(
        figure,
        f"Pitch of {len(run.results)} pictures, off by {run.score:.2f} degrees in the mean. The worst are {said}.",
    )


def _tilted(scene: LinePicture, estimate: Any) -> CameraView:
    """Return the view with the pitch and roll of an answer."""
    return replace(scene.view, pitch=estimate.pitch, roll=estimate.roll)


def _field_lines() -> list[FloatArray]:
    """Return the straight lines of the field as points (100, 2) in m."""
    return [np.linspace((x1, y1), (x2, y2), 100) for x1, y1, x2, y2 in Field(2012, half=False).lines]


def _plot_segments(ax: Axes, segments: FloatArray, view: CameraView) -> None:
    """Draw segments in the picture."""
    width, height = view.size
    for u1, v1, u2, v2 in segments:
        ax.plot([u1, u2], [v1, v2], color=LINES, lw=2.4)
    ax.set(xlim=(0, width - 1), ylim=(height - 1, 0), aspect="equal", xticks=[], yticks=[])
    ax.spines[["left", "bottom", "top", "right"]].set_visible(True)
