"""Figures of lesson 03: segments and corners in pictures, and a line seen close up, its edges and their segments."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray, as_points
from nao_course.lessons.hough_corners.scenes import three_places
from nao_course.plotting import Drawing, course_style, plot_found, plot_picture
from nao_course.plotting.drawing import say_count
from nao_course.plotting.style import HALO

SEGMENTS = ("#0072b2", "#d55e00", "#7a2cff", "#000000")  # in turn, so that pieces of a line can be told apart
_NONE: tuple[()] = ()


def draw_segments(
    pictures: Mapping[str, npt.ArrayLike],
    segments: Sequence[npt.ArrayLike],
    corners: Sequence[npt.ArrayLike] = _NONE,
) -> Drawing:
    """Draw pictures side by side, with segments in them and rings at corners.

    Parameters
    ----------
    pictures : mapping of str to array_like, shape (H, W, 3) of uint8
        RGB, by their titles.
    segments : sequence of array_like, shape (N, 4)
        (u1, v1, u2, v2) of those in each picture, pixels.
    corners : sequence of array_like, shape (K, 2)
        (u, v) of the corners in each; none are drawn where it is empty.

    Returns
    -------
    Drawing
        The figure; its text counts both and lists the corners.

    Raises
    ------
    ValueError
        If there is no picture, or there are not as many sets of segments, and of corners; or a shape is another.
    """
    points: list[FloatArray | None] = [as_points(each, name="corners (u, v)") for each in corners]
    points = points or [None] * len(pictures)
    if not 0 < len(pictures) == len(segments) == len(points):
        raise ValueError(
            f"{len(pictures)} pictures need as many sets of segments and of corners, got {len(segments)} and "
            f"{len(points)}"
        )
    columns = 2 if len(pictures) == 4 else min(len(pictures), 3)
    rows, width = -(-len(pictures) // columns), {1: 6.4, 2: 4.9, 3: 3.3}[columns]
    words = []
    with course_style():
        figure = Figure(figsize=(width * columns, rows * (width * 0.75 + 0.3)))
        grid = figure.subplots(rows, columns, squeeze=False).flat
        for ax, (title, picture), lines, found in zip(grid, pictures.items(), segments, points, strict=False):
            plot_picture(np.asarray(picture), ax, ticks=False)
            said = say_count(plot_segments(lines, ax), "segment")
            if found is not None:
                plot_found(found, ax, size=15 if len(pictures) == 1 else 12)
                said += f" and {_say_corners(found)}"
            ax.set_title(title, fontsize=11)
            words.append(f"{title}: {said}")
    said = "A picture" if len(words) == 1 else f"{say_count(len(words), 'picture')} side by side"
    return Drawing(figure, f"{said}, with what was found. {'; '.join(words)}.", photo=True)


def draw_places(segments_of: Callable[[Any], Any], corners_of: Callable[[Any], Any]) -> Drawing:
    """Draw the lesson's three places, with what `segments_of(pixels)` and `corners_of(pixels)` find in each."""
    pictures = three_places()
    segments, corners = (
        [find(pixels.copy()) for pixels in pictures.values()] for find in (segments_of, corners_of)
    )
    return draw_segments(pictures, segments, corners)


def plot_segments(segments: npt.ArrayLike, ax: Axes, width: float = 1.8) -> int:
    """Add segments (N, 4), (u1, v1, u2, v2) px, each in another colour than the one before; return how many."""
    lines = as_points(segments, columns=4, name="segments (u1, v1, u2, v2)")
    for i, (u1, v1, u2, v2) in enumerate(lines):
        ax.plot([u1, u2], [v1, v2], color=SEGMENTS[i % len(SEGMENTS)], lw=width, path_effects=HALO)
    return len(lines)


def draw_close_up(
    line_picture: npt.ArrayLike,
    segments: npt.ArrayLike,
    around: tuple[float, float],
    size: tuple[int, int] = (60, 36),
) -> Drawing:
    """Draw a part of a picture of lines, pixel by pixel: the white, and Canny's edges with the segments along them.

    Parameters
    ----------
    line_picture : array_like of uint8, shape (H, W)
        Lines 255, all else 0.
    segments : array_like, shape (N, 4)
        (u1, v1, u2, v2) of each, pixels.
    around : (float, float)
        The middle of the part, (u, v) px.
    size : (int, int)
        Its width and height, pixels.

    Returns
    -------
    Drawing
        The figure; its text counts white and edge pixels, and the segments that pass.
    """
    white = np.asarray(line_picture, dtype=np.uint8)
    edges = cv2.Canny(white, 50, 150)
    left, top = (round(middle - length / 2) for middle, length in zip(around, size, strict=True))
    part = (slice(top, top + size[1]), slice(left, left + size[0]))
    lines = as_points(segments, columns=4, name="segments (u1, v1, u2, v2)")
    with course_style():
        figure = Figure(figsize=(9.9, 3.4))
        axes = figure.subplots(1, 2)
        for ax, picture, title in zip(axes, (white, edges), ("white", "edges, and segments"), strict=True):
            ax.imshow(picture, cmap="gray", vmin=0, vmax=255, interpolation="nearest")
            ax.set(
                xlim=(left - 0.5, left + size[0] - 0.5),
                ylim=(top + size[1] - 0.5, top - 0.5),
                xlabel="u (px)",
                ylabel="v (px)",
            )
            ax.set_title(title, fontsize=11)
        plot_segments(lines, axes[1], width=2.2)
    passing = sum(cv2.clipLine((left, top, *size), *_ends(line))[0] for line in lines)
    return Drawing(
        figure,
        f"{size[0]} x {size[1]} pixels close up: {int((white[part] > 0).sum())} of them white, "
        f"{int((edges[part] > 0).sum())} edges, {say_count(passing, 'segment')} along them.",
    )


def _ends(segment: FloatArray) -> tuple[tuple[int, int], tuple[int, int]]:
    """Both ends in whole pixels, as OpenCV wants them."""
    u1, v1, u2, v2 = (round(float(each)) for each in segment)
    return (u1, v1), (u2, v2)


def _say_corners(points: FloatArray) -> str:
    """Such as "1 corner at (3, 4)"."""
    where = ", ".join(f"({u:.0f}, {v:.0f})" for u, v in points)
    return say_count(len(points), "corner") + (f" at {where}" if where else "")
