"""The control panel as a figure, for places without widgets."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.plotting import (
    Drawing,
    course_style,
    plot_estimate,
    plot_field,
    plot_measurements,
    plot_path,
    plot_picture,
    style_of,
)
from nao_course.plotting.legends import landmark_keys, legend_below, source_key
from nao_course.sim import Field
from nao_course.widgets.vector_map import MapContents
from nao_course.widgets.vector_map.live import FRONTIER

POINT_MARKER = "*"  # for points that the student's code found; landmarks have other markers
_CELLS: Any = {"marker": "s", "ms": 5, "ls": "", "mew": 0, "color": FRONTIER, "alpha": 0.5}


@course_style()
def draw_still(
    pictures: Mapping[str, Any], field: Field, contents: MapContents, names: Mapping[str, str], alt: str
) -> Drawing:
    """Draw the cameras' pictures, one below the other, beside the map.

    The pictures (H, W, 3) are by title, and `names` for the legend by source; the estimate has the colours of the last.
    """
    figure = Figure(figsize=(9.6, 5.4))
    grid = figure.add_gridspec(len(pictures), 2, width_ratios=(1.0, 1.25))
    for row, (title, pixels) in enumerate(pictures.items()):
        ax = figure.add_subplot(grid[row, 0])
        plot_picture(pixels, ax, ticks=False)
        ax.set_title(title, fontsize=11)
    ax = figure.add_subplot(grid[:, 1])
    plot_field(field, ax)
    _plot_contents(contents, list(names)[-1], ax)
    keys = [source_key(source, names[source]) for source in contents.paths]
    if contents.estimate is not None:
        keys += landmark_keys(contents.estimate.kinds, style_of(list(names)[-1]).colour, "estimated")
    if len(contents.points):
        keys.append(
            Line2D([], [], label="found by your code", ls="", marker=POINT_MARKER, **_point(contents))
        )
    if len(contents.cells):
        keys.append(Line2D([], [], label="frontiers", **_CELLS))
    legend_below(figure, keys, columns=3)
    return Drawing(figure, alt, photo=True)


def _point(contents: MapContents) -> dict[str, Any]:
    """Return the appearance of the points that the student's code found."""
    return {"ms": 11, "color": style_of(contents.observer).colour, "mec": "white", "mew": 0.8}


def _plot_contents(contents: MapContents, estimator: str, ax: Axes) -> None:
    ax.plot(*contents.cells.T, zorder=1.5, **_CELLS)
    if contents.estimate is not None:
        plot_estimate(contents.estimate, ax, estimator)
    for source, path in contents.paths.items():
        plot_path(list(path), ax, source)
    observer = contents.paths[contents.observer][-1]
    if len(contents.points):
        ax.plot(*observer.to_parent(contents.points).T, POINT_MARKER, **_point(contents))
    if contents.seen:
        plot_measurements(contents.seen, observer, ax, contents.observer)
