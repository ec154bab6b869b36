"""Figures of camera pictures with marked points, and of the labels of their pixels."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course._internal.counts import say_count
from nao_course.geometry import FloatArray, as_points
from nao_course.plotting.drawing import Drawing
from nao_course.plotting.halo import HALO
from nao_course.plotting.legends import label_keys, legend_below
from nao_course.plotting.style import FOUND, LABEL_COLOURS, course_style
from nao_course.sim import LABELS, Picture, VisibleLandmark


def as_pixels(picture: Picture | npt.ArrayLike) -> npt.NDArray[Any]:
    """Return an RGB picture or a single channel as an array."""
    array = picture.pixels if isinstance(picture, Picture) else np.asarray(picture)
    if array.ndim not in (2, 3) or (array.ndim == 3 and array.shape[2] != 3) or 0 in array.shape:
        raise ValueError(
            f"a picture must be a Picture or an array of shape (H, W, 3) or (H, W), got {array.shape}"
        )
    if array.ndim == 3 and array.dtype != np.uint8:
        raise ValueError(f"a picture's colours must be uint8 (0 to 255), got {array.dtype}")
    return array


def say_picture(picture: Picture | npt.NDArray[Any]) -> str:
    """Return a picture's camera, if known, and its size as text."""
    if isinstance(picture, Picture):
        return (
            f"picture of the {picture.camera} camera, {picture.view.size[0]} x {picture.view.size[1]} pixels"
        )
    height, width = picture.shape[:2]
    return f"{'picture' if picture.ndim == 3 else 'values of one channel'}, {width} x {height} pixels"


def plot_picture(picture: Picture | npt.ArrayLike, ax: Axes, ticks: bool = True, **options: Any) -> None:
    """Show a picture, (H, W, 3) of uint8 or (H, W), on axes in pixels; pass `options` to ``imshow``."""
    array = as_pixels(picture)
    height, width = array.shape[:2]
    if array.ndim == 2:
        options.setdefault("cmap", "gray")
    options.setdefault("interpolation", "nearest" if width <= 64 else "antialiased")
    ax.imshow(array, **options)
    ax.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5), xticks=[], yticks=[])
    ax.spines[["left", "bottom"]].set_visible(False)
    if ticks:
        ax.set(xlabel="u (px)", ylabel="v (px)")
        ax.set(xticks=_pixel_ticks(width, 4), yticks=_pixel_ticks(height, 3))
        ax.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5))


def _pixel_ticks(length: int, parts: int) -> list[int]:
    """Return equally spaced tick positions and the last pixel."""
    return [*(length * part // parts for part in range(parts)), length - 1]


def _marked(landmarks: Iterable[VisibleLandmark] | npt.ArrayLike) -> tuple[FloatArray, list[str]]:
    """Return the pixels (N, 2) and the kinds of the points to be marked in a picture."""
    values: Any = landmarks
    if not isinstance(values, np.ndarray):
        values = list(values)
        if values and all(isinstance(each, VisibleLandmark) for each in values):
            return as_points([each.pixel for each in values]), [
                "hidden" if each.occluded else each.landmark.kind for each in values
            ]
    points = as_points(values, name="landmarks (pixels u, v)")
    return points, ["point"] * len(points)


# kind: (marker, colour); open shapes, so that the marked pixels stay visible
_MARKS = {
    "corner": ("s", "#ff3b81"),
    "post": ("o", "#2c7bff"),
    "cross": ("D", "#ff8c1a"),
    "hidden": ("x", "#111111"),
    "point": ("o", "#ff3b81"),
}


def _mark(ax: Axes, points: FloatArray, kinds: Sequence[str]) -> list[Line2D]:
    keys = []
    for kind in sorted(set(kinds), key=[*_MARKS].index):
        marker, colour = _MARKS[kind]
        chosen = np.array([each == kind for each in kinds], dtype=bool)
        options: dict[str, Any] = {
            "marker": marker,
            "color": colour,
            "mfc": "none",
            "ls": "",
            "ms": 12,
            "mew": 2.2,
        }
        ax.plot(*points[chosen].T, **options, path_effects=HALO)
        options |= {"ms": 9, "mew": 1.8}
        keys.append(Line2D([], [], **options, label="behind a post" if kind == "hidden" else kind))
    return keys


@course_style()
def draw_picture(
    picture: Picture | npt.ArrayLike,
    landmarks: Iterable[VisibleLandmark] | npt.ArrayLike = (),
    title: str | None = None,
) -> Drawing:
    """Draw one picture, with landmarks or other points marked in it.

    Parameters
    ----------
    picture : Picture or array_like, shape (H, W, 3) of uint8, or (H, W)
        The picture.
    landmarks : iterable of VisibleLandmark, or array_like of shape (N, 2)
        True landmarks, or pixels (u, v).
    title : str, optional
        Title of the figure.

    Returns
    -------
    Drawing
        The figure.

    Raises
    ------
    ValueError
        If a shape is wrong.
    """
    array = as_pixels(picture)
    points, kinds = _marked(landmarks)
    figure = Figure(figsize=(7.2, 7.2 * array.shape[0] / array.shape[1] + (1.1 if len(points) else 0.8)))
    ax = figure.add_subplot()
    plot_picture(array, ax)
    legend_below(figure, _mark(ax, points, kinds), columns=5)
    ax.set_title(title or "")
    words = f"{title or 'One'}: {say_picture(picture if isinstance(picture, Picture) else array)}."
    if len(points):
        where = ", ".join(f"{kind} ({u:.0f}, {v:.0f})" for kind, (u, v) in zip(kinds, points, strict=True))
        words += f" Marked at (u, v): {where}."
    return Drawing(figure, words, photo=array.ndim == 3)


@course_style()
def draw_pictures(
    pictures: Sequence[Picture | npt.ArrayLike], titles: Sequence[str] = (), columns: int = 3
) -> Drawing:
    """Draw several pictures in a grid.

    Parameters
    ----------
    pictures : sequence of Picture or array_like, (H, W, 3) of uint8, or (H, W)
        At least one picture.
    titles : sequence of str
        One title for each picture, or no titles.
    columns : int
        Number of columns of the grid.

    Returns
    -------
    Drawing
        The figure.

    Raises
    ------
    ValueError
        If there is no picture, or the numbers of pictures and titles differ.
    """
    arrays = [as_pixels(picture) for picture in pictures]
    if not arrays:
        raise ValueError("pictures must contain at least one picture, got an empty sequence")
    if len(titles) not in (0, len(arrays)):
        raise ValueError(f"{len(arrays)} pictures need {len(arrays)} titles or none, got {len(titles)}")
    if columns < 1:
        raise ValueError(f"columns must be at least 1, got {columns}")
    columns = min(columns, len(arrays))
    rows = -(-len(arrays) // columns)
    names = list(titles) or [f"{number + 1}" for number in range(len(arrays))]
    width = {1: 7.0, 2: 4.7}.get(columns, 9.9 / columns)
    figure = Figure(figsize=(width * columns, rows * (width * 0.75 + 0.45)))
    grid = figure.subplots(rows, columns, squeeze=False)
    for ax, array, name in zip(grid.flat, arrays, names, strict=False):
        plot_picture(array, ax, ticks=False)
        ax.set_title(name, fontsize=11)
    for ax in grid.flat[len(arrays) :]:
        ax.set_axis_off()
    said = "; ".join(
        f"{name}: {say_picture(picture if isinstance(picture, Picture) else array)}"
        for name, picture, array in zip(names, pictures, arrays, strict=True)
    )
    return Drawing(figure, f"{say_count(len(arrays), 'picture')} side by side. {said}.", photo=True)


def plot_found(points: npt.ArrayLike, ax: Axes, size: float = 13) -> None:
    """Mark detected points (K, 2), (u, v) px, with rings that are visible on any picture."""
    for colour, width in (("white", 4.6), (FOUND, 2.4)):
        ax.plot(*as_points(points).T, "o", color=colour, mfc="none", ms=size, mew=width)


@course_style()
def draw_labels(labels: npt.ArrayLike, title: str | None = None) -> Drawing:
    """Draw the class of each pixel: other, green, yellow, white.

    Parameters
    ----------
    labels : array_like of int, shape (H, W)
        0 other, 1 green, 2 yellow, 3 white.
    title : str, optional
        Title of the figure.

    Returns
    -------
    Drawing
        The figure; its alt text contains the fraction of the picture that each class covers.

    Raises
    ------
    ValueError
        If the shape is wrong, or a label is not from 0 to 3.
    """
    array = _labels(labels)
    parts = [float((array == label).mean()) for label in range(len(LABELS))]
    figure = Figure(figsize=(7.2, 7.2 * array.shape[0] / array.shape[1] + 1.1))
    ax = figure.add_subplot()
    plot_picture(array, ax, cmap=ListedColormap(LABEL_COLOURS), vmin=-0.5, vmax=3.5, interpolation="nearest")
    texts = [f"{label} {name} ({parts[label]:.1%})" for label, name in enumerate(LABELS)]
    legend_below(figure, label_keys(texts))
    ax.set_title(title or "")
    said = ", ".join(f"{name} {part:.1%}" for name, part in zip(LABELS, parts, strict=True))
    return Drawing(
        figure, f"{title or 'Labels'}: classes of {array.shape[1]} x {array.shape[0]} pixels: {said}."
    )


def painted(labels: npt.ArrayLike, colours: Sequence[str] = LABEL_COLOURS) -> npt.NDArray[np.uint8]:
    """Return a picture that shows labels in their colours.

    Parameters
    ----------
    labels : array_like of int, shape (H, W)
        0 other, 1 green, 2 yellow, 3 white.
    colours : sequence of str
        One colour for each label; by default the colours of the course's figures.

    Returns
    -------
    ndarray of uint8, shape (H, W, 3)
        RGB.

    Raises
    ------
    ValueError
        If the shape is wrong, or a label is not from 0 to 3.
    """
    palette = np.round(255 * np.array([to_rgb(colour) for colour in colours])).astype(np.uint8)
    return np.take(palette, _labels(labels).astype(np.intp), axis=0)


def _labels(labels: npt.ArrayLike) -> npt.NDArray[Any]:
    array = np.asarray(labels)
    if array.ndim != 2 or array.size == 0:
        raise ValueError(f"labels must have shape (H, W), got {array.shape}")
    in_range = array.min() >= 0 and array.max() < len(LABELS)
    whole = array.dtype.kind in "iu"  # then the range is enough; a fast check matters for panels
    if not (in_range and (whole or np.isin(array, range(len(LABELS))).all())):
        wrong = sorted(set(np.unique(array).tolist()) - set(range(len(LABELS))))
        raise ValueError(f"labels must be 0 other, 1 green, 2 yellow or 3 white; got {wrong[:5]}")
    return array
