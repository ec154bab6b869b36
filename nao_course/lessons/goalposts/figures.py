"""Figures of lesson 02: feet in pictures, one column of labels, a post's height by distance, and recall by distance."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Arc, Rectangle

from nao_course._internal.counts import say_count
from nao_course.geometry import FloatArray, as_points
from nao_course.lessons.goalposts.measuring import FootMatch
from nao_course.lessons.goalposts.scenes import turning_head
from nao_course.metrics import total, wilson_interval
from nao_course.plotting import LABEL_COLOURS, STYLES, Drawing, course_style, plot_found, plot_picture
from nao_course.plotting.drawing import Table, table
from nao_course.plotting.halo import HALO
from nao_course.plotting.legends import label_keys, legend_below
from nao_course.plotting.style import FOUND, GREY, style_of
from nao_course.sim import LABELS

CANDIDATE = "#7a2cff"  # apart from feet, carpet, posts and lines
_NONE: tuple[()] = ()


@course_style()
def draw_feet(
    pictures: Mapping[str, npt.ArrayLike],
    feet: Sequence[npt.ArrayLike],
    candidates: Sequence[npt.ArrayLike] = _NONE,
    columns: int = 2,
    candidate: str = "candidate",
) -> Drawing:
    """Draw pictures side by side with the detected points.

    Parameters
    ----------
    pictures : mapping of str to array_like, (H, W, 3) of uint8
        Pictures by their titles.
    feet : sequence of array_like, shape (K, 2)
        (u, v) of the feet found in each.
    candidates : sequence of array_like, shape (N, 2)
        Candidates (u, v) of each picture; not drawn if empty.
    columns : int
        Number of columns in the grid.
    candidate : str
        Name of the candidates in the legend.

    Returns
    -------
    Drawing
        The figure; its text lists the feet.

    Raises
    ------
    ValueError
        If there are not as many sets of points as pictures.
    """
    found = [as_points(each, name="feet (u, v)") for each in feet]
    dots = [as_points(each, name="candidates (u, v)") for each in candidates] or [np.zeros((0, 2))] * len(
        found
    )
    if not len(pictures) == len(found) == len(dots):
        raise ValueError(
            f"{len(pictures)} pictures need as many sets of feet and of candidates, got {len(found)} and {len(dots)}"
        )
    columns = min(columns, len(pictures))
    rows = -(-len(pictures) // columns)
    width = {1: 5.6, 2: 4.1}.get(columns, 9.9 / columns)
    figure = Figure(figsize=(width * columns, rows * (width * 0.75 + 0.35) + 0.4))
    grid = list(figure.subplots(rows, columns, squeeze=False).flat)
    for ax, (title, picture), points, near in zip(grid, pictures.items(), found, dots, strict=False):
        plot_picture(np.asarray(picture), ax, ticks=False)
        # The white rims are below all dots, so that neighbours do not cover each other.
        ax.plot(*near.T, "o", color="white", ms=5.7)
        ax.plot(*near.T, "o", color=CANDIDATE, ms=4.3)
        plot_found(points, ax)
        ax.set_title(title, fontsize=11)
    for ax in grid[len(pictures) :]:
        ax.set_axis_off()
    keys = [Line2D([], [], color=CANDIDATE, marker="o", mec="white", ls="", ms=7, label=candidate)]
    keys = keys if candidates else []
    if any(map(len, found)) or not keys:
        ring: dict[str, Any] = {"color": FOUND, "marker": "o", "mfc": "none", "ms": 10, "mew": 2.2}
        keys.append(Line2D([], [], ls="", label="foot found", **ring))
    legend_below(figure, keys)
    said = "; ".join(
        f"{title}: {_say_points(points, 'foot', 'feet')}"
        for title, points in zip(pictures, found, strict=True)
        if len(points) or not candidates
    )
    with_what = "the candidates" if candidates and not said else "the feet found"
    return Drawing(
        figure,
        f"{say_count(len(found), 'picture')} with {with_what} in {'it' if len(found) == 1 else 'them'}. "
        f"{said or ', '.join(pictures)}.",
        photo=True,
    )


def draw_turning_head(find: Callable[[Any], Any]) -> Drawing:
    """Draw pictures from a robot that turns its head, with the feet that `find(pixels)` returns for each."""
    pictures = turning_head()
    return draw_feet(pictures, [find(pixels.copy()) for pixels in pictures.values()], columns=3)


@course_style()
def draw_column(labels: npt.ArrayLike, columns: Sequence[int], look_down: int = 10) -> Drawing:
    """Draw some columns of labels side by side, with the lowest yellow pixel and the pixels below it.

    Parameters
    ----------
    labels : array_like of int, shape (H, W)
        0 other, 1 green, 2 yellow, 3 white.
    columns : sequence of int
        Which.
    look_down : int
        How many pixels below the lowest yellow one are framed.

    Returns
    -------
    Drawing
        The figure; its text says what stands in each column.
    """
    array = np.asarray(labels)
    figure = Figure(figsize=(1.9 * len(columns) + 0.6, 5.2))
    axes = figure.subplots(1, len(columns), sharey=True, squeeze=False)[0]
    words = [_plot_column(ax, array[:, u], u, look_down) for ax, u in zip(axes, columns, strict=True)]
    axes[0].set_ylabel("v (px)")
    keys: list[Any] = label_keys(LABELS)
    keys.append(Line2D([], [], color=FOUND, marker=">", ls="", ms=9, label="lowest yellow"))
    keys.append(Rectangle((0, 0), 1, 1, fill=False, ec=FOUND, lw=2, label=f"{look_down} pixels below"))
    legend_below(figure, keys, columns=3)
    return Drawing(figure, f"Columns of labels from above. {' '.join(words)}")


def _plot_column(ax: Axes, column: npt.NDArray[Any], u: int, look_down: int) -> str:
    """Draw one column as coloured cells, and return a description."""
    height = len(column)
    edges = np.flatnonzero(np.diff(column)) + 1
    for first, last in zip((0, *edges), (*edges, height), strict=True):
        ax.add_patch(Rectangle((0, first - 0.5), 1, last - first, fc=LABEL_COLOURS[column[first]], ec="none"))
    ax.add_patch(Rectangle((0, -0.5), 1, height, fill=False, ec=GREY, lw=1))
    ax.set(xlim=(-0.3, 1.15), ylim=(height - 0.5, -0.5), xticks=[])
    ax.set_title(f"column {u}", fontsize=11, loc="center")
    yellow = np.flatnonzero(column == LABELS.index("yellow"))
    if not len(yellow):
        return f"Column {u} has no yellow."
    foot = int(yellow[-1])
    green = int((column[foot + 1 : foot + 1 + look_down] == LABELS.index("green")).sum())
    others = np.flatnonzero(column[:foot] != LABELS.index("yellow"))
    run = foot - (int(others[-1]) if len(others) else -1)
    ax.add_patch(Rectangle((-0.1, foot + 0.5), 1.2, look_down, fill=False, ec=FOUND, lw=2))
    ax.plot(-0.17, foot, ">", color=FOUND, ms=9, clip_on=False)
    ax.set_xlabel(f"lowest yellow {foot}")
    return f"Column {u}: lowest yellow at {foot}, {green} of {look_down} pixels below it green, run of {run} pixels."


@course_style()
def draw_heights(
    distances: npt.ArrayLike,
    heights: npt.ArrayLike,
    formula: tuple[npt.ArrayLike, npt.ArrayLike],
    limits: Mapping[str, float],
) -> Drawing:
    """Draw the height of posts in the picture by distance, measured and computed, with the required heights.

    Parameters
    ----------
    distances, heights : array_like, shape (N,)
        Measured: metres, pixels.
    formula : (array_like, array_like)
        Computed distances and heights, drawn as a line.
    limits : mapping of str to float
        Smallest heights in pixels, by name, drawn as horizontal lines.

    Returns
    -------
    Drawing
        The figure; its text says where the line falls below each limit.
    """
    x, y = (np.asarray(each, dtype=float) for each in formula)
    figure = Figure(figsize=(7.6, 4.6))
    ax = figure.add_subplot()
    ax.plot(x, y, color=STYLES["ekf"].colour, lw=2, label="equation 2.1")
    ax.plot(
        distances,
        heights,
        "o",
        color=STYLES["truth"].colour,
        ms=6,
        label="measured: yellow pixels in a column",
    )
    crossings: dict[str, float] = {}
    for style, (name, limit) in zip(("--", ":", "-."), limits.items(), strict=False):
        ax.axhline(limit, color=STYLES["odometry"].colour, ls=style, lw=1.6, label=f"{name}: {limit:g} px")
        if x[y >= limit].size and y.min() < limit:
            crossings[name] = float(x[y >= limit].max())
    ax.set(
        xlabel="distance of the post (m)", ylabel="height in the picture (px)", ylim=(0, None), xlim=(0, None)
    )
    ax.legend()
    met = [f"meets {name} at {at:.1f} m" for name, at in crossings.items()]
    met += [f"stays above {name}" for name in limits if name not in crossings]
    return Drawing(
        figure,
        f"Height of a goal post in the picture by distance, to {x.max():.1f} m. Equation 2.1 {', '.join(met)}.",
    )


def _xy(point: FloatArray) -> tuple[float, float]:
    """Return a point (2,) as two numbers."""
    return float(point[0]), float(point[1])


def _length(ax: Axes, start: tuple[float, float], end: tuple[float, float], colour: str = "black") -> None:
    """Draw a double arrow that reaches both points."""
    arrow: dict[str, Any] = {"arrowstyle": "<->", "color": colour, "shrinkA": 0, "shrinkB": 0}
    ax.annotate("", start, end, arrowprops=arrow)


@course_style()
def draw_side() -> Drawing:
    """Draw from the side how a camera that looks down sees a goal post, with its image plane."""
    distance, height, post = 1.1, 0.48, 0.8  # m, of the post and of both heights
    pitch = 0.26  # rad, downwards
    camera, along = np.array([0.0, height]), np.array([np.cos(pitch), -np.sin(pitch)])
    truth, axis = STYLES["truth"].colour, STYLES["odometry"].colour
    ends = {"foot": np.array([distance, 0.0]), "top": np.array([distance, post])}
    figure = Figure(figsize=(8.6, 4.2))
    ax = figure.add_subplot()
    ax.axhline(0, color="#3a9a50", lw=3)
    ax.plot([distance] * 2, [0, post], color="#d9a800", lw=7, solid_capstyle="butt")
    ax.plot(*np.transpose([camera, camera + 1.2 * distance * along]), color=axis, ls="--", lw=1.6)
    across = np.array([np.sin(pitch), np.cos(pitch)])
    # Place of the word for y in points, of the arrow for z beside the axis in m, and of its word at the arrow.
    aside = {
        "foot": ((10, -4), "left", -0.14, (0.45, -0.035)),
        "top": ((-8, 18), "right", 0.06, (0.68, 0.035)),
    }
    for name, end in ends.items():
        at = camera + ((end - camera) @ along) * along
        at_line, ha, beside, (part, away) = aside[name]
        look: dict[str, Any] = {"textcoords": "offset points", "color": FOUND, "ha": ha}
        ax.plot(*np.transpose([camera, end]), color=truth, lw=1.2)
        ax.plot(*np.transpose([at, end]), color=FOUND, lw=2.2)
        ax.plot(*at, "o", color=FOUND, ms=5)
        z = [camera + beside * across, at + beside * across]
        _length(ax, _xy(z[0]), _xy(z[1]), FOUND)
        ax.text(
            *_xy(z[0] + part * (z[1] - z[0]) + away * across),
            f"z of the {name}",
            rotation=-float(np.degrees(pitch)),
            color=FOUND,
            ha="center",
            va="center",
            path_effects=HALO,
        )
        ax.annotate(f"y of the {name}", (at + end) / 2, at_line, **look)
    starts = np.transpose([camera - 0.17 * across, camera + 0.09 * across])
    ax.plot(*starts, color=FOUND, lw=1)  # where both arrows for z start
    ax.plot(*camera, "s", color="black", ms=9)
    focal = 0.36 * distance  # the image plane, not to scale
    centre = camera + focal * along
    rays = [camera + (end - camera) * focal / ((end - camera) @ along) for end in ends.values()]
    ax.plot(*np.transpose([centre + 0.3 * across, centre - 0.25 * across]), color="#7a4fa3", lw=2)
    ax.plot(*np.transpose(rays), color="#7a4fa3", lw=6, solid_capstyle="butt")
    ax.text(*_xy(centre + 0.33 * across), "image plane", color="#7a4fa3", ha="center", fontsize=10)
    below = 0.06 * np.array([-np.sin(pitch), -np.cos(pitch)])
    _length(ax, _xy(camera + below), _xy(centre + below), "#7a4fa3")
    at_f = _xy(camera + 0.5 * focal * along + 1.9 * below)
    ax.text(*at_f, "f", color="#7a4fa3", style="italic", fontsize=12, ha="center", va="center")
    ax.add_patch(Arc(_xy(camera), 0.34, 0.34, theta1=-float(np.degrees(pitch)), theta2=0, color="black"))
    ax.text(*_xy(rays[1] + (-0.03, -0.05)), "n", color="#7a4fa3", style="italic", fontsize=12, ha="right")
    ax.plot([0, distance], [height] * 2, color=GREY, lw=1)
    _length(ax, (0, 0), (0, height))
    _length(ax, (0, -0.05), (distance, -0.05))
    _length(ax, (distance + 0.34, 0), (distance + 0.34, post))
    places = {
        "camera": (-0.05, height + 0.1),
        "h": (-0.05, height / 2),
        "d": (distance / 2, -0.13),
        "H": (distance + 0.36, post * 0.5),
        "p": (0.19, height - 0.035),
    }
    for word, place in places.items():
        ax.text(*place, word, fontsize=12, style="normal" if word == "camera" else "italic")
    ax.set(xlim=(-0.15, 1.4 * distance), ylim=(-0.16, post + 0.06), aspect="equal")
    ax.set_axis_off()
    return Drawing(
        figure,
        "A camera at height h, from the side, that looks down by p at a post of height H at distance d. Perpendicular "
        "lines go from foot and top of the post to the camera's axis. z is the distance along the axis, and y is the "
        "length of such a line. The image plane is at distance f, and the post is n high in it.",
    )


@course_style()
def draw_recall(matches: Mapping[str, Sequence[FootMatch]], width: float = 1.0) -> Drawing:
    """Draw precision and recall by distance, with 95 % intervals.

    Parameters
    ----------
    matches : mapping of str to sequence of FootMatch
        One a picture, by the detector's name. A picture counts at its nearest foot's distance.
    width : float
        Of the bins, metres.

    Returns
    -------
    Drawing
        The figure; its text gives the sums.
    """
    figure = Figure(figsize=(9.6, 4.1))
    left, right = figure.subplots(1, 2, sharex=True, sharey=True)
    looks = (("ekf", -0.06), ("odometry", 0.06), ("graph", 0.0))
    for (name, each), (source, aside) in zip(matches.items(), looks, strict=False):
        look = style_of(source)
        for ax, of in ((left, recall_counts), (right, precision_counts)):
            _plot_parts(
                ax,
                of(each, width),
                width,
                {"color": look.colour, "marker": look.marker, "label": name},
                aside,
            )
    left.set(ylabel="fraction", title="Recall: feet that are found")
    right.set(title="Precision: points that are correct")
    for ax in (left, right):
        ax.set(xlabel="distance (m)", ylim=(-0.02, 1.05), xlim=(0, None))
        ax.grid(color="#e3e5e8")
    legend_below(figure, left.get_legend_handles_labels()[0])
    said = "; ".join(f"{name}: {total(each)}" for name, each in matches.items())
    return Drawing(figure, f"Recall and precision by distance. In all: {said}.")


def recall_counts(matches: Sequence[FootMatch], width: float = 1.0) -> dict[int, tuple[int, int]]:
    """Count feet (found, all) in bins of distance, by the bin's number."""
    every = total(matches)
    bins = _bins(every.distances, width)
    return {int(b): (int(every.found[bins == b].sum()), int((bins == b).sum())) for b in np.unique(bins)}


def precision_counts(matches: Sequence[FootMatch], width: float = 1.0) -> dict[int, tuple[int, int]]:
    """Count points (right, all) in bins of the distance of their picture's nearest foot."""
    counts: dict[int, tuple[int, int]] = {}
    for each in matches:
        if len(each.distances) and (points := int(each.found.sum()) + each.false):
            number = int(_bins(each.distances.min(), width))
            right, every = counts.get(number, (0, 0))
            counts[number] = (right + int(each.found.sum()), every + points)
    return dict(sorted(counts.items()))


def _bins(distances: npt.ArrayLike, width: float) -> npt.NDArray[np.int_]:
    """Return the numbers of the bins that contain the distances; an edge belongs to the nearer bin."""
    return np.maximum(np.ceil(np.asarray(distances) / width - 1e-6).astype(int) - 1, 0)


def score_table(found: Mapping[str, Mapping[str, Sequence[FootMatch]]]) -> Table:
    """Set in a table what detectors find in sets of pictures.

    Parameters
    ----------
    found : mapping of str to mapping of str to sequence of FootMatch
        The matches of each set's pictures, by detector: ``found[set][detector]``.

    Returns
    -------
    Table
        A row for each, with the 95 % interval of the recall.
    """
    rows = []
    for pictures, detectors in found.items():
        for name, matches in detectors.items():
            every = total(matches)
            low, high = wilson_interval(every.hits, len(every.found))
            recall = f"{every.hits} of {len(every.found)}"
            rows.append((pictures, name, recall, f"{low:.0%} to {high:.0%}", every.false))
    return table(("pictures", "detector", "feet found", "95 % interval", "false points"), rows)


def _plot_parts(
    ax: Axes, counts: Mapping[int, tuple[int, int]], width: float, look: dict[str, Any], aside: float
) -> None:
    """Draw a point for each bin with its interval."""
    middle: FloatArray = (np.array(list(counts)) + 0.5) * width + aside
    parts = np.array([hits / trials for hits, trials in counts.values()])
    low, high = np.array([wilson_interval(*each) for each in counts.values()]).T
    ax.errorbar(
        middle,
        parts,
        [parts - np.minimum(low, parts), np.maximum(high, parts) - parts],
        ls="none",
        capsize=3,
        lw=1.6,
        ms=6,
        **look,
    )


def _say_points(points: FloatArray, one: str, many: str) -> str:
    where = ", ".join(f"({u:.0f}, {v:.0f})" for u, v in points)
    return f"{len(points)} {one if len(points) == 1 else many}{f' at {where}' if where else ''}"
