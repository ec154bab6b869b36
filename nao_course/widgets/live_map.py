"""A map that is redrawn many times a second: the field once, what moves by blit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.geometry import FloatArray, Pose
from nao_course.plotting import (
    LANDMARK_MARKERS,
    as_path,
    course_style,
    estimate_outlines,
    measured_points,
    plot_field,
    style_of,
)
from nao_course.sim import Field
from nao_course.slam import Estimate, Measurement

DPI = 100
LARGEST = (4.4, 4.3)  # inches
HEADING = 0.32  # m, length of the line that shows where a robot looks


@dataclass(frozen=True)
class MapContents:
    """What a map shows at one time.

    Parameters
    ----------
    paths : mapping of str to sequence of Pose
        In the world, by source; the robot is drawn at the last pose.
    estimate : Estimate or None
        In the world; its landmarks and ellipses are drawn.
    source : str
        Whose colours the estimate gets.
    seen : sequence of Measurement
        Drawn from the robot of `observer`.
    observer : str
        Which source's robot measured.
    """

    paths: Mapping[str, Sequence[Pose]]
    estimate: Estimate | None = None
    source: str = "ekf"
    seen: Sequence[Measurement] = ()
    observer: str = "odometry"


class LiveMap:
    """The field from above.

    Parameters
    ----------
    field : Field
        The ground.
    sources : sequence of str
        Whose paths may appear, in the order they are drawn.
    """

    def __init__(self, field: Field, sources: Sequence[str]) -> None:
        """Draw the field once."""
        self._sources = tuple(sources)
        with course_style():
            self._figure = Figure(figsize=_size(field), dpi=DPI)
            self._canvas = FigureCanvasAgg(self._figure)
            self._ax = self._figure.add_subplot()
            self._ax.tick_params(labelsize=9)
            plot_field(field, self._ax)
            self._keys = [self.key(source) for source in self._sources]
            self._figure.legend(handles=self._keys, loc="outside lower center", ncols=3, fontsize=9.5)
            self._canvas.draw()
        self._background: Any = self._canvas.copy_from_bbox(self._figure.bbox)  # type: ignore[attr-defined]
        self._figure.set_layout_engine("none")

    def draw(self, contents: MapContents) -> npt.NDArray[np.uint8]:
        """Return the map as an RGB picture.

        Parameters
        ----------
        contents : MapContents
            What to show.

        Returns
        -------
        ndarray of uint8, shape (H, W, 3)
            RGB.
        """
        self._canvas.restore_region(self._background)  # type: ignore[attr-defined]
        for artist in self._artists(contents):
            self._ax.add_artist(artist)
            self._ax.draw_artist(artist)
            artist.remove()
        return np.asarray(self._canvas.buffer_rgba())[:, :, :3].copy()

    def _artists(self, contents: MapContents) -> list[Any]:
        """All that moves, the lowest first."""
        artists: list[Any] = []
        if contents.estimate is not None:
            artists += _estimate(contents.estimate, contents.source)
        for source in self._sources:
            path = as_path(list(contents.paths.get(source, ())))
            if len(path):
                artists += _path(path, source)
        if contents.seen and contents.paths.get(contents.observer):
            artists += _rays(contents.seen, contents.paths[contents.observer][-1], contents.observer)
        return artists

    @staticmethod
    def key(source: str) -> Line2D:
        """Entry of the legend for a source."""
        style = style_of(source)
        look = {"color": style.colour, "ls": style.line, "marker": style.marker, "mec": "white"}
        return Line2D([], [], lw=1.8, ms=8, label=style.label, **look)


def _size(field: Field) -> tuple[float, float]:
    """Inches that hold the carpet, the axes' labels and the legend."""
    x0, y0, x1, y1 = field.carpet
    scale = min((LARGEST[0] - 0.55) / (x1 - x0), (LARGEST[1] - 0.85) / (y1 - y0))
    return round(scale * (x1 - x0) + 0.55, 2), round(scale * (y1 - y0) + 0.85, 2)


def _estimate(estimate: Estimate, source: str) -> list[Any]:
    colour = style_of(source).colour
    outlines = estimate_outlines(estimate)
    sound = outlines[np.isfinite(outlines).all(axis=(1, 2))]
    shapes = PolyCollection(
        list(sound), facecolors=[to_rgba(colour, 0.18)], edgecolors=[to_rgba(colour, 0.9)]
    )
    marks = [
        Line2D(
            *_of_kind(estimate.landmarks, estimate.kinds, kind).T,
            marker=marker,
            ms=7,
            ls="",
            color=colour,
            mec="white",
        )
        for kind, marker in LANDMARK_MARKERS.items()
        if kind in estimate.kinds
    ]
    return [shapes, *marks]


def _of_kind(points: FloatArray, kinds: Sequence[str], kind: str) -> FloatArray:
    return points[np.array([each == kind for each in kinds], dtype=bool)]


def _path(path: FloatArray, source: str) -> list[Line2D]:
    style = style_of(source)
    x, y, theta = path[-1]
    tip = (x + HEADING * np.cos(theta), y + HEADING * np.sin(theta))
    return [
        Line2D(path[:, 0], path[:, 1], color=style.colour, ls=style.line, lw=1.6),
        Line2D([x, tip[0]], [y, tip[1]], color=style.colour, lw=2.4),
        Line2D([x], [y], color=style.colour, marker=style.marker, ms=10, mec="white", mew=1.2, ls=""),
    ]


def _rays(seen: Sequence[Measurement], pose: Pose, source: str) -> list[Line2D]:
    colour = style_of(source).colour
    ends = measured_points(seen, pose)
    rays = [Line2D([pose.x, x], [pose.y, y], color=colour, lw=0.8, alpha=0.7) for x, y in ends]
    kinds = [each.kind for each in seen]
    marks = [
        Line2D(*_of_kind(ends, kinds, kind).T, marker=marker, ls="", ms=9, mfc="none", mec=colour, mew=1.4)
        for kind, marker in LANDMARK_MARKERS.items()
        if kind in kinds
    ]
    return rays + marks
