"""A map that is redrawn many times a second: the field is drawn once, and moving parts are drawn over a copy of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple
from matplotlib.lines import Line2D

from nao_course.geometry import FloatArray, Pose
from nao_course.plotting import (
    LANDMARK_MARKERS,
    as_path,
    course_style,
    estimate_outlines,
    plot_field,
    style_of,
)
from nao_course.plotting.legends import source_key
from nao_course.sim import Field
from nao_course.slam import KINDS, Estimate, Measurement, measured_points
from nao_course.widgets.vector_map import MapContents

DPI = 100
LARGEST = (4.4, 4.3)  # inches
_MEASURED = "measured"  # key of the measurements in the legend, beside the sources' keys
HEADING = 0.32  # m, length of the line that shows a robot's heading
POINT_MARKER = "*"  # for points that the student's code found; landmarks have other markers
_NO_POINTS = np.empty((0, 2))


class LiveMap:
    """A map of the field from above, at most `largest` (width, height) inches, with `ahead` metres beyond the carpet.

    `sources` maps the sources whose paths may appear to their names in the legend, in drawing order; the estimate has
    the colours of the last. `markers` has a letter for each source that is not drawn as a path.
    """

    @course_style()
    def __init__(
        self,
        field: Field,
        sources: Mapping[str, str],
        ahead: float = 0.0,
        markers: Mapping[str, str] | None = None,
        largest: tuple[float, float] = LARGEST,
    ) -> None:
        """Draw the field, and create the artists of everything that moves."""
        figure = Figure(figsize=_size(field, ahead, largest), dpi=DPI)
        self._canvas = _agg(figure)
        self._ax = figure.add_subplot()
        self._ax.tick_params(labelsize=9)
        plot_field(field, self._ax)
        if ahead:
            self._ax.set_xlim(right=field.carpet[2] + ahead)
            self._ax.set_xticks(np.arange(np.ceil(field.carpet[0]), field.carpet[2] + ahead))
        self._labels = {**sources, _MEASURED: "measured from here"}
        self._keys: dict[str, Any] = {name: source_key(name, label) for name, label in sources.items()}
        self._keys[_MEASURED] = _measured_key()
        for name, letters in (markers or {}).items():
            self._keys[name] = tuple(_marker_key(each, style_of(name).colour) for each in letters)
        self._legend = self._made_legend(figure, tuple(self._keys))
        self._canvas.draw()
        figure.set_layout_engine("none")  # the layout has room for the largest legend
        self._backgrounds: dict[tuple[str, ...], Any] = {}
        self._estimate = _EstimateArtists(style_of(list(sources)[-1]).colour)
        self._robots = {source: _RobotArtists(source) for source in sources}
        self._measurements = _MeasurementArtists()
        self._artists = (
            self._estimate.all
            + [a for each in self._robots.values() for a in each.all]
            + self._measurements.all
        )
        for artist in self._artists:
            artist.set_animated(True)
            self._ax.add_artist(artist)

    def draw(self, contents: MapContents) -> npt.NDArray[np.uint8]:
        """Return the map as an RGB picture (H, W, 3) of uint8."""
        self._estimate.show(contents.estimate)
        for source, robot in self._robots.items():
            robot.show(as_path(list(contents.paths.get(source, ()))))
        observer = contents.paths.get(contents.observer) or [Pose()]
        self._measurements.show(contents.seen, observer[-1], contents.observer)
        self._measurements.show_points(contents.points, observer[-1], contents.observer)
        # The estimating source belongs into the legend even before it has a path
        estimated = list(self._robots)[-1] if contents.estimate is not None else None
        shown = [source for source in self._robots if contents.paths.get(source) or source == estimated]
        self._canvas.restore_region(self._background((*shown, *([_MEASURED] if contents.seen else ()))))
        for artist in self._artists:
            self._ax.draw_artist(artist)
        return np.array(self._canvas.buffer_rgba())[:, :, :3]

    def _background(self, keys: tuple[str, ...]) -> Any:
        """Return the still part of the map with a legend for the keys; it is drawn once for each legend."""
        if keys not in self._backgrounds:
            figure = self._canvas.figure
            self._legend.remove()
            with course_style():
                self._legend = self._made_legend(figure, keys)
                self._canvas.draw()
            self._backgrounds[keys] = self._canvas.copy_from_bbox(figure.bbox)
        return self._backgrounds[keys]

    def _made_legend(self, figure: Figure, keys: tuple[str, ...]) -> Any:
        return figure.legend(
            handles=[self._keys[key] for key in keys],
            handler_map={tuple: HandlerTuple(ndivide=None)},
            loc="outside lower center",
            ncols=2 if _MEASURED in keys else 3,
            fontsize=9,
            handlelength=1.9,
            handletextpad=0.4,
            columnspacing=0.9,
            **({"labels": [self._labels[key] for key in keys]} if keys else {}),
        )


def _measured_key() -> Line2D:
    """Return the legend's key for measurements: an open marker, unlike a landmark's."""
    style: Any = {
        "color": "#4b5563",
        "lw": 0.8,
        "marker": LANDMARK_MARKERS["post"],
        "mfc": "none",
        "mew": 1.4,
    }
    return Line2D([], [], **style)


def _marker_key(marker: str, colour: str) -> Line2D:
    """Return the legend's key for points that are drawn with a marker."""
    return Line2D([], [], marker=marker, ms=8, ls="", color=colour, mec="white")


def _agg(figure: Figure) -> Any:
    """Return a canvas in memory, untyped because matplotlib's methods have no types."""
    return FigureCanvasAgg(figure)


def _size(field: Field, ahead: float, largest: tuple[float, float]) -> tuple[float, float]:
    """Return the figure's width and height (inches) with room for the carpet, the axes' labels and the legend."""
    x0, y0, x1, y1 = field.carpet
    x1 += ahead
    scale = min((largest[0] - 0.55) / (x1 - x0), (largest[1] - 0.85) / (y1 - y0))
    return round(scale * (x1 - x0) + 0.55, 2), round(scale * (y1 - y0) + 1.05, 2)


def _of_kind(points: FloatArray, kinds: Sequence[str], kind: str) -> FloatArray:
    chosen: FloatArray = (
        points[np.array([each == kind for each in kinds], dtype=bool)] if len(points) else points
    )
    return chosen


class _RobotArtists:
    """A path, and the robot at its end."""

    def __init__(self, source: str) -> None:
        style = style_of(source)
        self._path = Line2D([], [], color=style.colour, ls=style.line, lw=1.6)
        self._heading = Line2D([], [], color=style.colour, lw=2.4)
        self._body = Line2D(
            [], [], color=style.colour, marker=style.marker, ms=10, mec="white", mew=1.2, ls=""
        )
        self.all: list[Any] = [self._path, self._heading, self._body]

    def show(self, path: FloatArray) -> None:
        """Show poses (N, 3); an empty path hides the robot."""
        x, y, theta = path[-1:].T
        self._path.set_data(path[:, 0], path[:, 1])
        self._heading.set_data(
            np.concatenate([x, x + HEADING * np.cos(theta)]), np.concatenate([y, y + HEADING * np.sin(theta)])
        )
        self._body.set_data(x, y)


class _EstimateArtists:
    """Landmarks and ellipses of an estimate."""

    def __init__(self, colour: str) -> None:
        self._shapes = PolyCollection(
            [], facecolors=[to_rgba(colour, 0.18)], edgecolors=[to_rgba(colour, 0.9)]
        )
        self._marks = {
            kind: Line2D([], [], marker=LANDMARK_MARKERS[kind], ms=8, ls="", color=colour, mec="white")
            for kind in KINDS
        }
        self.all: list[Any] = [self._shapes, *self._marks.values()]

    def show(self, estimate: Estimate | None) -> None:
        """Show an estimate; None hides it."""
        outlines = np.empty((0, 1, 2)) if estimate is None else estimate_outlines(estimate)
        self._shapes.set_verts(list(outlines[np.isfinite(outlines).all(axis=(1, 2))]))
        for kind, marks in self._marks.items():
            chosen = _NO_POINTS if estimate is None else _of_kind(estimate.landmarks, estimate.kinds, kind)
            marks.set_data(chosen[:, 0], chosen[:, 1])


class _MeasurementArtists:
    """Rays from the robot to the measured landmarks, with open markers at their ends."""

    def __init__(self) -> None:
        self._rays = Line2D([], [], lw=0.8, alpha=0.7)
        self._ends = {
            kind: Line2D([], [], marker=LANDMARK_MARKERS[kind], ls="", ms=9, mfc="none", mew=1.4)
            for kind in KINDS
        }
        self._points = Line2D([], [], marker=POINT_MARKER, ls="", ms=9, mec="white", mew=0.8)
        self.all: list[Any] = [self._rays, *self._ends.values(), self._points]

    def show(self, seen: Sequence[Measurement], pose: Pose, source: str) -> None:
        """Show measurements taken at `pose`, in the colour of their source."""
        ends, colour = measured_points(seen, pose), style_of(source).colour
        rays = np.full((len(ends), 3, 2), np.nan)  # robot, landmark, gap
        rays[:, 0], rays[:, 1] = (pose.x, pose.y), ends
        self._rays.set(data=rays.reshape(-1, 2).T, color=colour)
        for kind, marks in self._ends.items():
            marks.set(data=_of_kind(ends, [each.kind for each in seen], kind).T, markeredgecolor=colour)

    def show_points(self, points: FloatArray, pose: Pose, source: str) -> None:
        """Show points (N, 2) of the robot frame at `pose`, in the colour of their source."""
        self._points.set(data=pose.to_parent(points).T, markerfacecolor=style_of(source).colour)
