"""Lines and leans in pictures: what lesson 04's challenge is about, and where an entry to it is worst."""

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
EXAMPLE = 48  # seed of a picture with a lean that can be seen


def draw_leaning_lines(pixel_to_ground: Callable[..., Any]) -> Drawing:
    """Draw the segments of one picture, and as they lie on the ground under the believed tilt and under the true one.

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
    views = {"tilt as believed": scene.view, "true tilt": scene.true_view}
    said = []
    with course_style():
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
    lean = np.degrees(scene.true_view.pitch - scene.view.pitch)
    return Drawing(
        figure,
        f"{len(scene.segments)} segments of field lines; the camera leans by {lean:+.1f} degrees. {'. '.join(said)}.",
    )


def _off_right_angles(ground: FloatArray) -> float:
    """How far (degrees) segments (N, 2, 2) are from being parallel or perpendicular to the longest, at most."""
    way = ground[:, 1] - ground[:, 0]
    direction = np.degrees(np.arctan2(way[:, 1], way[:, 0]))
    apart = direction - direction[np.linalg.norm(way, axis=1).argmax()]
    return float(np.abs((apart + 45) % 90 - 45).max())


def draw_worst_leans(run: Run) -> Drawing:
    """Draw the pictures whose pitch is off most: segments, and where the answer's lean would put the field's lines.

    Parameters
    ----------
    run : Run
        All cases of the challenge.

    Returns
    -------
    Drawing
        The figure; its text names them.
    """
    worst = sorted((each for each in run.results if each.kept), key=lambda each: -each.score)[:SHOWN]
    with course_style():
        figure = Figure(figsize=(9.9, 3.4))
        for number, each in enumerate(worst, start=1):
            scene, lean = each.kept
            ax = figure.add_subplot(1, SHOWN, number)
            answered = _leant(scene, lean)
            for points in _field_lines():
                ax.plot(*answered.project(points, scene.pose).T, color=ANSWER, lw=1.4, ls="--")
            _plot_segments(ax, scene.segments, scene.view)
            ax.set_title(f"{each.name}: {each.score:.1f}°, sigma {np.degrees(lean.sigma):.1f}°", fontsize=11)
        keys = [
            Line2D([], [], color=LINES, lw=2.4, label="segments given"),
            Line2D([], [], color=ANSWER, ls="--", label="the field as your lean would show it"),
        ]
        legend_below(figure, keys)
    said = ", ".join(f"{each.name} with {each.score:.2f} degrees" for each in worst)
    return Drawing(
        figure,
        f"Pitch of {len(run.results)} pictures, off by {run.score:.2f} degrees in the mean. The worst are {said}.",
    )


def _leant(scene: LinePicture, lean: Any) -> CameraView:
    return replace(scene.view, pitch=lean.pitch, roll=lean.roll)


def _field_lines() -> list[FloatArray]:
    """The field's straight lines as points (100, 2), metres."""
    return [np.linspace((x1, y1), (x2, y2), 100) for x1, y1, x2, y2 in Field(2012, half=False).lines]


def _plot_segments(ax: Axes, segments: FloatArray, view: CameraView) -> None:
    """Segments as they lie in the picture."""
    width, height = view.size
    for u1, v1, u2, v2 in segments:
        ax.plot([u1, u2], [v1, v2], color=LINES, lw=2.4)
    ax.set(xlim=(0, width - 1), ylim=(height - 1, 0), aspect="equal", xticks=[], yticks=[])
    ax.spines[["left", "bottom", "top", "right"]].set_visible(True)
