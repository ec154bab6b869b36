"""Figures of lesson 03: segments and corners in pictures, votes for lines, and a close-up of one line."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.colors import PowerNorm
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D

from nao_course._internal.counts import say_count
from nao_course.geometry import FloatArray, as_points
from nao_course.lessons.hough_corners.scenes import three_places
from nao_course.plotting import Drawing, course_style, plot_found, plot_picture
from nao_course.plotting.halo import HALO
from nao_course.plotting.marks import TRUE
from nao_course.plotting.style import FOUND

# The colours are used in turn, so that neighbouring segments differ; black is for the truth.
SEGMENTS = ("#0072b2", "#d55e00", "#7a2cff")
_NONE: tuple[()] = ()
PART = (60, 36)  # width and height of a close-up, px

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
def draw_votes(line_picture: npt.ArrayLike, around: tuple[float, float]) -> Drawing:
    """Draw the edge pixels of a part of a line picture, and their votes for lines by angle and distance.

    Parameters
    ----------
    line_picture : array_like of uint8, shape (H, W)
        Lines 255, all else 0.
    around : (float, float)
        Centre of the part, (u, v) px. The two lines with the most votes have rings.

    Returns
    -------
    Drawing
        The figure; its text has the votes, angles and distances of these two lines.
    """
    figure = Figure(figsize=(9.9, 3.8), layout="constrained")
    ax, plane = figure.subplots(1, 2)
    ax.set_anchor("N")
    edges, left, top = _plot_part(line_picture, around, ax, "edge pixels", edges=True)
    at = np.argwhere(edges)[:, ::-1] + (left, top) - around
    angles, far = np.radians(np.arange(180)), round(np.hypot(*edges.shape) / 2) + 1
    normals = np.array([np.cos(angles), np.sin(angles)])
    rows = np.rint(at @ normals).astype(int) + far
    votes = np.array([np.bincount(each, minlength=2 * far + 1) for each in rows.T]).T
    best = np.unravel_index(votes.argmax(), votes.shape)
    others = np.where(abs(np.arange(2 * far + 1) - best[0])[:, None] > 4, votes, 0)
    seconds = np.unravel_index(others.argmax(), votes.shape)
    rings = [(int(angle), int(row) - far) for row, angle in (best, seconds)]
    image = plane.imshow(
        votes, cmap="Greys", norm=PowerNorm(0.5), aspect="auto", extent=(-0.5, 179.5, far + 0.5, -far - 0.5)
    )
    figure.colorbar(image, ax=plane, label="votes")
    line = at[rows[:, best[1]] == best[0]]
    for point, colour in zip(line[np.linspace(0, len(line) - 1, 5).astype(int)[1:4]], SEGMENTS, strict=False):
        plane.plot(np.arange(180), point @ normals, color=colour, lw=1.6)
        ax.plot(*(point + around), "o", color=colour, ms=8)
        for tilt in angles[::18]:
            ax.axline(point + around, point + around + (np.cos(tilt), np.sin(tilt)), color=colour, lw=0.8)
    plot_found(rings, plane, size=13)
    plane.set(xlabel="angle of the line's normal (degrees)", ylabel="distance from the centre (px)")
    plane.invert_yaxis()  # positive distances are at the top
    counts = [int(votes[distance + far, angle]) for angle, distance in rings]
    plane.set_title(f"votes: {counts[0]} and {counts[1]} in the rings", fontsize=11)
    said = [
        f"{count} at {ring[0]} degrees and {ring[1]} px" for count, ring in zip(counts, rings, strict=True)
    ]
    return Drawing(
        figure,
        f"Edge pixels around one line, and their votes by angle and distance. The most votes are {' and '.join(said)}. "
        "The curves of three pixels of one edge cross at the first.",
    )


@course_style()
def draw_close_up(
    line_picture: npt.ArrayLike, segments: npt.ArrayLike, around: tuple[float, float]
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

    Returns
    -------
    Drawing
        The figure; its text counts white pixels, edge pixels and segments.
    """
    lines = as_points(segments, columns=4, name="segments (u1, v1, u2, v2)")
    figure = Figure(figsize=(9.9, 3.8))
    left_axes, right_axes = figure.subplots(1, 2)
    white, *corner = _plot_part(line_picture, around, left_axes, "white pixels")
    edges, *_ = _plot_part(line_picture, around, right_axes, "your segments on the edge pixels", edges=True)
    passing = lines[[bool(cv2.clipLine((*corner, *PART), *_ends(line))[0]) for line in lines]]
    plot_segments(passing, right_axes, width=2.2)
    _add_legend(figure, rings=False, crosses=False)
    return Drawing(
        figure,
        f"Close-up of {PART[0]} x {PART[1]} pixels: {np.count_nonzero(white)} white pixels, "
        f"{np.count_nonzero(edges)} edge pixels, {say_count(len(passing), 'segment')} along the edges.",
    )


def _plot_part(
    line_picture: npt.ArrayLike, around: tuple[float, float], ax: Axes, title: str, *, edges: bool = False
) -> tuple[npt.NDArray[Any], int, int]:
    """Plot a part of a line picture, or its edges; return the part and its first column and row."""
    white = np.asarray(line_picture, dtype=np.uint8)
    left, top = (max(0, round(centre - length / 2)) for centre, length in zip(around, PART, strict=True))
    part = (cv2.Canny(white, 50, 150) if edges else white)[top : top + PART[1], left : left + PART[0]]
    extent = (left - 0.5, left + part.shape[1] - 0.5, top + part.shape[0] - 0.5, top - 0.5)
    ax.imshow(part, cmap="gray", vmin=0, vmax=255, interpolation="nearest", extent=extent)
    ax.set(xlabel="u (px)", ylabel="v (px)", autoscale_on=False)
    ax.set_title(title, fontsize=11)
    return part, left, top


def _ends(segment: FloatArray) -> tuple[tuple[int, int], tuple[int, int]]:
    """Return both ends in whole pixels, as OpenCV needs them."""
    u1, v1, u2, v2 = (round(float(each)) for each in segment)
    return (u1, v1), (u2, v2)


def _say_corners(points: FloatArray) -> str:
    """Return a text such as "1 corner at (3, 4)"."""
    where = ", ".join(f"({u:.0f}, {v:.0f})" for u, v in points)
    return say_count(len(points), "corner") + (f" at {where}" if where else "")
