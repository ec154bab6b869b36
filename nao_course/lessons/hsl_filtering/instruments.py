"""The filter panel's histogram of lightness and circle of hues, painted as arrays because figures are too slow.

Their paper is transparent and their writing grey, so that they are readable on a light page and on a dark one.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import hsv_to_rgb, to_rgba
from matplotlib.figure import Figure

from nao_course.lessons.hsl_filtering.light import BINS, MARKS, SPANS
from nao_course.plotting.style import INK, LABEL_COLOURS, course_style

Pixels = npt.NDArray[np.uint8]

WIDTH, HEIGHT = 400, 300  # px
LEFT, RIGHT, TOP, BOTTOM = 10, 390, 8, 250  # of the histogram's axes, px
CENTRE, INNER, OUTER = (WIDTH // 2, HEIGHT // 2), 36, 100  # of the circle's bars, px
PIXEL = "#c84b00"  # the chosen pixel, on picture and circle
WEDGE = 3  # degrees of a bar on the circle
_STACKED = (1, 0, 2, 3)  # labels from the bottom of the histogram to its top
_BAR_COLOURS = np.array([to_rgba(LABEL_COLOURS[k]) for k in _STACKED] + [(1.0, 1.0, 1.0, 0.0)]) * 255
_BAR_COLOURS = np.round(_BAR_COLOURS).astype(np.uint8)


def histogram_picture(counts: npt.NDArray[Any], marks: Mapping[str, float]) -> Pixels:
    """Paint a histogram (HEIGHT, WIDTH, 4) of the `lightness_counts` (4, BINS), with marks named as in `MARKS`."""
    picture = _histogram_paper().copy()
    stacked = np.cumsum(counts[list(_STACKED)], axis=0)
    # The brightest bin may be far higher: it is cut off
    most = 1.15 * max(1.0, float(np.sort(stacked[-1])[-2]))
    heights = np.minimum(stacked / most, 1.0)
    level = (BOTTOM - np.arange(TOP, BOTTOM))[:, None] / (BOTTOM - TOP)
    # (rows, BINS): the number of labels whose bars end below a point
    bars = np.sum(level[None] > heights[:, None, :], axis=0)
    columns = (np.arange(RIGHT - LEFT) * BINS) // (RIGHT - LEFT)
    picture[TOP:BOTTOM, LEFT:RIGHT] = np.take(_BAR_COLOURS, bars, axis=0)[:, columns]
    tops = (BOTTOM - np.round(heights[-1, columns] * (BOTTOM - TOP))).astype(np.int32)
    outline = np.column_stack((np.arange(LEFT, RIGHT, dtype=np.int32), tops))
    cv2.polylines(picture, [outline], False, _rgba(INK), 1)
    for name, at in marks.items():
        u = round(LEFT + (RIGHT - LEFT) * min(max(at, 0.0), 255.0) / 256)
        low, high = (round(BOTTOM - (BOTTOM - TOP) * end) for end in SPANS[name])
        cv2.line(picture, (u, low), (u, high), _rgba(MARKS[name][0]), 3)
    return picture


def hue_counts(hue: npt.NDArray[np.float32], counted: npt.NDArray[np.bool_]) -> npt.NDArray[np.float32]:
    """Count the chosen pixels (H, W) by hue in degrees [0, 360): an array (360 / WEDGE,)."""
    counts = cv2.calcHist([hue], [0], counted.astype(np.uint8), [360 // WEDGE], [0.0, 360.0])
    return np.asarray(counts, dtype=np.float32).ravel()


def circle_picture(
    counts: npt.NDArray[Any],
    arcs: Mapping[str, tuple[float, float]],
    pixel: float | None = None,
    added: Iterable[float] = (),
) -> Pixels:
    """Paint `hue_counts` (360 / WEDGE,) and intervals of hues on a circle, (HEIGHT, WIDTH, 4).

    `arcs` maps colours such as "#f2c413" to limits in degrees, of which low > high goes through 0; `pixel` is the hue
    of the chosen pixel, and `added` are the hues that were added to an example.
    """
    picture = _circle_paper().copy()
    lengths = INNER + (OUTER - INNER) * np.sqrt(counts / max(1, counts.max()))
    ends = _places(np.arange(0, 360 + WEDGE, WEDGE)[:, None], np.array([[INNER]]))[:, 0]
    starts = WEDGE * np.arange(len(counts))[:, None] + np.array([[0, WEDGE]])
    outer = _places(starts, lengths[:, None])
    for wedge in np.flatnonzero(counts):
        corners = np.array([ends[wedge], *outer[wedge], ends[wedge + 1]])
        cv2.fillConvexPoly(picture, corners, _hue_colour(WEDGE * (wedge + 0.5)))
    for number, (colour, (low, high)) in enumerate(arcs.items()):
        angles = np.linspace(low, low + (high - low) % 360, 90)
        line = [_places(angles, OUTER + 7.0 + 9 * number)]
        cv2.polylines(picture, line, False, _rgba(INK), 8, cv2.LINE_AA)
        cv2.polylines(picture, line, False, _rgba(colour), 5, cv2.LINE_AA)
    for hue in added:
        cv2.circle(picture, _place(hue, OUTER + 11.0), 4, _rgba(PIXEL), -1, cv2.LINE_AA)
    if pixel is not None:
        cv2.line(picture, CENTRE, _place(pixel, OUTER + 23.0), _rgba("white"), 5, cv2.LINE_AA)
        cv2.line(picture, CENTRE, _place(pixel, OUTER + 23.0), _rgba(PIXEL), 2, cv2.LINE_AA)
    return picture


def _rgba(colour: Any) -> tuple[int, int, int, int]:
    red, green, blue, alpha = (round(255 * part) for part in to_rgba(colour))
    return red, green, blue, alpha


@cache
def _hue_colour(hue: float) -> tuple[int, int, int, int]:
    return _rgba(hsv_to_rgb([hue / 360, 0.75, 0.8]))


def _places(hues: npt.ArrayLike, radii: npt.ArrayLike) -> npt.NDArray[np.int32]:
    """Return points (..., 2) of the circle's picture; hues increase counterclockwise, and 0 is on the right."""
    angles = np.radians(np.asarray(hues, dtype=float))
    points = np.stack((np.cos(angles), -np.sin(angles)), axis=-1) * np.asarray(radii, dtype=float)[..., None]
    return np.round(points + CENTRE).astype(np.int32)


def _place(hue: float, radius: float) -> tuple[int, int]:
    u, v = _places(hue, radius).tolist()
    return u, v


@cache
@course_style()
def _histogram_paper() -> Pixels:
    """Return the background of each histogram, which is its axis."""
    figure = Figure(figsize=(WIDTH / 100, HEIGHT / 100), dpi=100, facecolor="none")
    figure.set_layout_engine("none")
    ax = figure.add_axes((LEFT / WIDTH, 1 - BOTTOM / HEIGHT, (RIGHT - LEFT) / WIDTH, (BOTTOM - TOP) / HEIGHT))
    ax.set(xlim=(0, 256), xticks=(0, 50, 100, 150, 200, 250), yticks=())
    ax.set_xlabel("lightness", fontsize=15, labelpad=1, color=INK)
    ax.tick_params(labelsize=15, pad=2, colors=INK)
    ax.spines["left"].set_visible(False)
    ax.spines["bottom"].set_color(INK)
    ax.patch.set_visible(False)
    return _painted(figure)


@cache
@course_style()
def _circle_paper() -> Pixels:
    """Return the background of each circle: the pure colours and their angles."""
    figure = Figure(figsize=(WIDTH / 100, HEIGHT / 100), dpi=100, facecolor="none")
    figure.set_layout_engine("none")
    for degrees in range(0, 360, 60):
        u, v = _place(degrees, OUTER + 34.0)
        side = {0: "left", 180: "right"}.get(degrees, "center")
        figure.text(u / WIDTH, 1 - v / HEIGHT, f"{degrees}°", fontsize=15, color=INK, ha=side, va="center")
    paper = _painted(figure)
    for degrees in range(0, 360, 2):
        line = [_places([degrees, degrees + 2], INNER - 7.0)]
        cv2.polylines(paper, line, False, _hue_colour(degrees + 1.0), 10)
    return paper


def _painted(figure: Figure) -> Pixels:
    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    return np.array(canvas.buffer_rgba())
