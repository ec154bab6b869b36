"""Real pictures with the fitted field drawn over them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from benchmarks import BUILD
from benchmarks.simulator.reality.fit import FIELD, Case, Prediction, SetFit, errors_of, fitted_view
from nao_course.datasets import PictureSet, RealPicture
from nao_course.geometry import FloatArray
from nao_course.sim.field import Field

# Told apart by readers who see red and green alike: they differ in lightness, from each other and the carpet.
LINE_COLOUR, GOAL_COLOUR, EDGE_COLOUR = "#0033cc", "#cc0066", "#ff9d00"
SHOWN: tuple[tuple[PictureSet, str], ...] = (
    ("scenes", "scene_001.png"),
    ("scenes", "scene_030.png"),
    ("straightwalk", "walk_001.png"),
    ("scenes", "scene_017.png"),
    ("scenes", "scene_046.png"),
    ("straightwalk", "walk_010.png"),
    ("scenes", "scene_061.png"),
    ("scenes", "scene_014.png"),
    ("straightwalk", "walk_017.png"),
)


def field_curves(field: Field, camera: FloatArray) -> dict[str, list[FloatArray]]:
    """Sample a field as curves of points (N, 3) in metres, by the colour they are drawn in.

    Lines, arcs and marks by their two edges; posts and bars by their outlines, seen from above `camera` (2,).
    """
    d, half = field.dimensions, field.dimensions.line_width / 2
    lines = [edge for line in [*field.lines, *field.mark_lines] for edge in _outline(line, half)]
    for x, y, radius, first, last in field.arcs:
        angles = np.linspace(first, last, 240)
        for r in (radius - half, radius + half):
            lines.append(np.column_stack([x + r * np.cos(angles), y + r * np.sin(angles), 0 * angles]))
    goals = []
    for x, y in field.posts:
        away = np.array([x, y]) - camera
        aside = np.array([-away[1], away[0]]) / np.linalg.norm(away) * d.post_diameter / 2
        goals += [
            _straight((*((x, y) + s * aside), 0.0), (*((x, y) + s * aside), d.post_height)) for s in (-1, 1)
        ]
    for first_end, last_end in field.bars:
        goals += [
            _straight(first_end + (0, 0, s), last_end + (0, 0, s))
            for s in (-d.bar_diameter / 2, d.bar_diameter / 2)
        ]
    x0, y0, x1, y1 = field.carpet
    corners = [(x0, y0, 0.0), (x1, y0, 0.0), (x1, y1, 0.0), (x0, y1, 0.0), (x0, y0, 0.0)]
    edges = [_straight(a, b) for a, b in pairwise(corners)]
    return {LINE_COLOUR: lines, GOAL_COLOUR: goals, EDGE_COLOUR: edges}


def _straight(first: npt.ArrayLike, last: npt.ArrayLike) -> FloatArray:
    """Return points (300, 3) from one to the other; so many that a lens bends them smoothly."""
    return np.linspace(np.asarray(first, dtype=float), np.asarray(last, dtype=float), 300)


def _outline(line: FloatArray, half: float) -> list[FloatArray]:
    """Return the four sides of a line on the ground that is parallel to an axis."""
    x0, y0, x1, y1 = (*np.minimum(line[:2], line[2:]), *np.maximum(line[:2], line[2:]))
    if x0 == x1:
        corners = [(x0 - half, y0, 0.0), (x0 + half, y0, 0.0), (x0 + half, y1, 0.0), (x0 - half, y1, 0.0)]
    else:
        corners = [(x0, y0 - half, 0.0), (x1, y0 - half, 0.0), (x1, y0 + half, 0.0), (x0, y0 + half, 0.0)]
    return [_straight(a, b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)]


def draw_pictures(fits: dict[PictureSet, SetFit], cases: Sequence[Case]) -> Path:
    """Draw nine real pictures with the fitted field over them into ``build/reality.png``.

    Returns
    -------
    Path
        Of the figure, in a folder that git ignores.
    """
    predictions: dict[str, list[Prediction]] = {}
    for prediction in (p for case in cases for p in case.predictions):
        predictions.setdefault(prediction.picture, []).append(prediction)
    figure = Figure(figsize=(15, 13.8), dpi=130, layout="constrained")
    figure.set_layout_engine("constrained", hspace=0.05, h_pad=0.08)
    for axes, (name, file) in zip(figure.subplots(3, 3).flat, SHOWN, strict=True):
        fit = fits[name]
        number = [item.picture.name for item in fit.matched].index(file)
        _draw_picture(
            axes, fit.matched[number].picture, fit.values, fit.corrections[number], predictions[file]
        )
    figure.legend(handles=_legend(), loc="outside lower center", ncols=5, fontsize=13, frameon=False)
    figure.suptitle(
        "A real NAO's pictures and the library's field, seen through the fitted camera", fontsize=18
    )
    BUILD.mkdir(exist_ok=True)
    figure.savefig(BUILD / "reality.png")
    return BUILD / "reality.png"


def _draw_picture(
    axes: Axes,
    picture: RealPicture,
    values: FloatArray,
    correction: FloatArray,
    predictions: Sequence[Prediction],
) -> None:
    """Draw one picture, the field over it, and its marked and predicted points."""
    view, pose = fitted_view(picture, values, correction)
    width, height = view.size
    axes.imshow(picture.read(large=picture.has_large), extent=(-0.5, width - 0.5, height - 0.5, -0.5))
    camera = pose.to_parent(view.position[:2])[0]
    for colour, curves in field_curves(FIELD, camera).items():
        style = (0, (4, 2)) if colour == EDGE_COLOUR else "-"
        for curve in curves:
            axes.plot(*view.project(curve, pose).T, color=colour, linewidth=1.0, linestyle=style)
    axes.plot(*np.array([p.marked for p in predictions]).T, **MARKED)
    axes.plot(*np.array([p.predicted for p in predictions]).T, **PREDICTED)
    axes.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5), xticks=[], yticks=[])
    middle = float(np.median(errors_of(predictions)))
    where = (
        f"from ({picture.pose.x:.2f}, {picture.pose.y:.2f}) m, heading {np.degrees(picture.pose.theta):.0f}°"
    )
    title = f"{picture.path.stem.replace('_', ' ')}, {where}".replace("-", "−")
    axes.set_title(f"{title}\n{len(predictions)} points, median error {middle:.1f} pixels", fontsize=12)


HALO = [withStroke(linewidth=2.6, foreground="white")]
MARKED: dict[str, Any] = {
    "linestyle": "",
    "marker": "o",
    "markersize": 10,
    "fillstyle": "none",
    "color": "black",
    "path_effects": HALO,
}
PREDICTED: dict[str, Any] = {
    "linestyle": "",
    "marker": "x",
    "markersize": 6,
    "markeredgewidth": 1.5,
    "color": "#d55e00",
    "path_effects": HALO,
}


def _legend() -> list[Line2D]:
    """Return what the curves and marks mean."""
    return [
        Line2D([], [], color=LINE_COLOUR, label="lines, circle, marks"),
        Line2D([], [], color=GOAL_COLOUR, label="goal"),
        Line2D([], [], color=EDGE_COLOUR, linestyle=(0, (4, 2)), label="edge of the carpet by the rules"),
        Line2D([], [], label="marked by hand", **MARKED),
        Line2D([], [], label="predicted from the other points", **PREDICTED),
    ]
