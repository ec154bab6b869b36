"""Figures of lesson 03: segments and corners in pictures, and a close-up of one line with its edges."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D

from nao_course._internal.counts import say_count
from nao_course.geometry import FloatArray, as_points
from nao_course.lessons.hough_corners.scenes import three_places
from nao_course.plotting import Drawing, course_style, plot_found, plot_picture
from nao_course.plotting.marks import TRUE
from nao_course.plotting.style import FOUND, HALO

# The colours are used in turn, so that neighbouring segments differ; black is for the truth.
SEGMENTS = ("#0072b2", "#d55e00", "#7a2cff")
_NONE: tuple[()] = ()

Finder = Callable[[Any], Any]


@course_style()
def draw_segments(
    pictures: Mapping[str, npt.ArrayLike],
    segments: Sequence[npt.ArrayLike],
    corners: Sequence[npt.ArrayLike] = _NONE,
    true: npt.ArrayLike | None = None,
) -> Drawing:
    """Draw pictures side by side with line segments, rings at the corners found and crosses at the true corners.

    Parameters
    ----------
    pictures : mapping of str to array_like, shape (H, W, 3) of uint8
        RGB, by their titles.
    segments : sequence of array_like, shape (N, 4)
        (u1, v1, u2, v2) of the segments in each picture, pixels.
    corners : sequence of array_like, shape (K, 2)
        (u, v) of the corners found in each picture; no rings are drawn if it is empty.
    true : array_like, shape (T, 2), optional
        (u, v) of the true corners, the same in all pictures.

    Returns
    -------
    Drawing
        The figure; its text counts the segments and lists the corners.

    Raises
    ------
    ValueError
        If there is no picture, if the lengths of the sequences differ, or if a shape is wrong.
    """
    points: list[FloatArray | None] = [as_points(each, name="corners (u, v)") for each in corners]
    points = points or [None] * len(pictures)
    if not 0 < len(pictures) == len(segments) == len(points):
        raise ValueError(
            f"{len(pictures)} pictures need as many sets of segments and of corners, got {len(segments)} and "
            f"{len(points)}"
        )
    crosses = None if true is None else as_points(true, name="true corners (u, v)")
    columns = 2 if len(pictures) == 4 else min(len(pictures), 3)
    rows, width = -(-len(pictures) // columns), {1: 5.0, 2: 4.2, 3: 3.3}[columns]
    words = []
    figure = Figure(figsize=(width * columns, rows * (width * 0.75 + 0.3) + 0.4))
    grid = figure.subplots(rows, columns, squeeze=False).flat
    for ax, (title, picture), lines, found in zip(grid, pictures.items(), segments, points, strict=False):
        said = _plot_picture_with(ax, picture, lines, found, crosses, columns)
        words.append(f"{title}: {said}")
        ax.set_title(f"{title}: {said}" if found is None else title, fontsize=11)
    _add_legend(figure, rings=bool(len(corners)), crosses=crosses is not None)
    said = "A picture" if len(words) == 1 else f"{say_count(len(words), 'picture')} side by side"
    if crosses is not None:
        said += f", {say_count(len(crosses), 'true corner')} in each"
    return Drawing(figure, f"{said}. {'; '.join(words)}.", photo=True)


@course_style()
def draw_places(detectors: Mapping[str, tuple[Finder, Finder]]) -> Drawing:
    """Draw what each detector finds in the lesson's three places, one row for each detector.

    Parameters
    ----------
    detectors : mapping of str to (callable, callable)
        By the row's title: ``segments_of(pixels)`` returns segments (N, 4), ``corners_of(pixels)`` corners (K, 2).

    Returns
    -------
    Drawing
        The figure, with crosses at the true corners; its text counts the segments and lists the corners found.
    """
    pictures, words = three_places(), []
    figure = Figure(figsize=(9.9, 2.75 * len(detectors) + 0.5))
    grid = figure.subplots(len(detectors), len(pictures), squeeze=False)
    for row, (name, (segments_of, corners_of)) in zip(grid, detectors.items(), strict=True):
        row[0].set_ylabel(name, fontsize=11)
        for ax, (title, picture) in zip(row, pictures.items(), strict=True):
            pixels, true = picture.pixels, picture.truth.corners
            found = as_points(corners_of(pixels.copy()), name="corners (u, v)")
            said = _plot_picture_with(ax, pixels, segments_of(pixels.copy()), found, true, 3)
            words.append(f"{title}, {name}: {say_count(len(true), 'true corner')}, {said}")
    for ax, title in zip(grid[0], pictures, strict=True):
        ax.set_title(title, fontsize=11)
    _add_legend(figure, rings=True, crosses=True)
    return Drawing(figure, f"Three places in columns. {'; '.join(words)}.", photo=True)


def _plot_picture_with(
    ax: Axes,
    picture: npt.ArrayLike,
    segments: npt.ArrayLike,
    found: FloatArray | None,
    true: FloatArray | None,
    columns: int,
) -> str:
    """Plot a picture with segments, crosses and rings; return the counts as text."""
    plot_picture(np.asarray(picture), ax, ticks=False)
    said = say_count(plot_segments(segments, ax), "segment")
    if found is not None:
        plot_found(found, ax, size=15 if columns == 1 else 13)
        said += f" and {_say_corners(found)}"
    if true is not None:  # after the rings, whose white border would hide a cross
        for colour, width in (("white", 4.0), (TRUE, 1.8)):
            ax.plot(*true.T, "x", color=colour, ms=9 if columns == 1 else 7, mew=width)
    return said


def _add_legend(figure: Figure, *, rings: bool, crosses: bool) -> None:
    """Add a legend of the marks below all pictures."""
    lines = tuple(Line2D([], [], color=colour, lw=2.4) for colour in SEGMENTS)
    keys: dict[str, Any] = {"line segments (three colours in turn)": lines}
    if rings:
        keys["corner found"] = Line2D([], [], color=FOUND, marker="o", mfc="none", mew=2.4, ms=11, ls="")
    if crosses:
        keys["true corner"] = Line2D([], [], color=TRUE, marker="x", mew=2.0, ms=9, ls="")
    figure.legend(
        list(keys.values()),
        list(keys),
        loc="outside lower center",
        ncols=3,
        handlelength=3.0,
        columnspacing=1.4,
        handler_map={tuple: HandlerTuple(ndivide=None)},
    )


def plot_segments(segments: npt.ArrayLike, ax: Axes, width: float = 1.8) -> int:
    """Add segments (N, 4), (u1, v1, u2, v2) px, in three colours in turn; return their number."""
    lines = as_points(segments, columns=4, name="segments (u1, v1, u2, v2)")
    for i, (u1, v1, u2, v2) in enumerate(lines):
        ax.plot([u1, u2], [v1, v2], color=SEGMENTS[i % len(SEGMENTS)], lw=width, path_effects=HALO)
    return len(lines)


@course_style()
def draw_close_up(
    line_picture: npt.ArrayLike,
    segments: npt.ArrayLike,
    around: tuple[float, float],
    size: tuple[int, int] = (60, 36),
) -> Drawing:
    """Draw a part of a line picture pixel by pixel, and beside it Canny's edges with the segments along them.

    Parameters
    ----------
    line_picture : array_like of uint8, shape (H, W)
        Lines 255, all else 0.
    segments : array_like, shape (N, 4)
        (u1, v1, u2, v2) of each, pixels.
    around : (float, float)
        Centre of the part, (u, v) px.
    size : (int, int)
        Width and height of the part, pixels.

    Returns
    -------
    Drawing
        The figure; its text counts white pixels, edge pixels and segments.
    """
    white = np.asarray(line_picture, dtype=np.uint8)
    edges = cv2.Canny(white, 50, 150)
    left, top = (round(centre - length / 2) for centre, length in zip(around, size, strict=True))
    part = (slice(top, top + size[1]), slice(left, left + size[0]))
    lines = as_points(segments, columns=4, name="segments (u1, v1, u2, v2)")
    figure = Figure(figsize=(9.9, 3.8))
    axes = figure.subplots(1, 2)
    titles = ("white pixels", "edge pixels (white) and your segments (coloured)")
    for ax, picture, title in zip(axes, (white, edges), titles, strict=True):
        ax.imshow(picture, cmap="gray", vmin=0, vmax=255, interpolation="nearest")
        ax.set(
            xlim=(left - 0.5, left + size[0] - 0.5),
            ylim=(top + size[1] - 0.5, top - 0.5),
            xlabel="u (px)",
            ylabel="v (px)",
        )
        ax.set_title(title, fontsize=11)
    passing = lines[[bool(cv2.clipLine((left, top, *size), *_ends(line))[0]) for line in lines]]
    plot_segments(passing, axes[1], width=2.2)
    _add_legend(figure, rings=False, crosses=False)
    return Drawing(
        figure,
        f"Close-up of {size[0]} x {size[1]} pixels: {int((white[part] > 0).sum())} white pixels, "
        f"{int((edges[part] > 0).sum())} edge pixels, {say_count(len(passing), 'segment')} along the edges.",
    )


def _ends(segment: FloatArray) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return both ends in whole pixels, as OpenCV needs them."""
    u1, v1, u2, v2 = (round(float(each)) for each in segment)
    return (u1, v1), (u2, v2)


def _say_corners(points: FloatArray) -> str:
    """Return a text such as "1 corner at (3, 4)"."""
    where = ", ".join(f"({u:.0f}, {v:.0f})" for u, v in points)
    return say_count(len(points), "corner") + (f" at {where}" if where else "")
