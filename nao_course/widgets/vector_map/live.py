"""A live map of the field: Python sends what has changed, and the browser draws it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import anywidget
import numpy as np
import traitlets

from nao_course.films import Layer, script, style_sheet
from nao_course.films.layers import (
    DETECTED,
    cell_layer,
    ellipse_layer,
    ellipse_numbers,
    landmark_layer,
    landmark_numbers,
    line_layer,
    path_layer,
    point_layer,
)
from nao_course.films.scene import Numbers, carpet_bounds, layer_numbers, scene_data
from nao_course.geometry import FloatArray, Pose
from nao_course.plotting.drawing import say_place
from nao_course.plotting.style import FOUND, GREY, style_of
from nao_course.sim import Field
from nao_course.slam import measured_points
from nao_course.widgets.vector_map.contents import MapContents

CELL = 0.1  # m: side of a grid cell
FARTHEST = 1e4  # m; nothing beyond it is sent
KINDS_IN_LEGEND = ("corners", "goal posts", "crosses")  # in the order of LANDMARK_MARKERS
FRONTIER, VIEW, TOO_SMALL = "#7a35d0", "#fffbe0", "#b3001b"
_RENDER = """
export default {
  render({ model, el }) {
    const root = document.createElement("div");
    el.append(root);
    const live = new NaoLive.LiveMap(root, model.get("scene"));
    const receive = message => { if (!live.receive(message)) model.send({ ask: "everything" }); };
    model.on("msg:custom", receive);
    model.send({ ask: "everything" });
    return () => { model.off("msg:custom", receive); live.remove(); };
  },
};
"""


class MapWidget(anywidget.AnyWidget):
    """The widget of a live map."""

    _esm = script("map", "live") + _RENDER
    _css = style_sheet()
    scene = traitlets.Dict().tag(sync=True)


class VectorMap:
    """A live map of the field. The browser draws it and moves what has changed.

    Parameters
    ----------
    field : Field
        The field.
    sources : mapping of str to str
        Names for the legend of the sources whose paths may appear, in drawing order. The estimate has the colours of
        the last source.
    cells : str
        Name for the legend of the grid cells.
    tallest : int
        Largest height of the map, px; its width follows the page. 0 fills a place whose height is fixed.
    tweens : bool
        Whether the browser moves the robot smoothly between two updates.

    Examples
    --------
    >>> live = VectorMap(Field(), {"truth": "truth", "ekf": "your EKF"})
    >>> live.update(MapContents({"truth": [Pose(0.5, 0.0, 0.0)]}, observer="truth"))
    1
    >>> live.alt
    'Map of the field. truth: (0.50, 0.00) m, heading 0 deg.'
    """

    def __init__(
        self,
        field: Field,
        sources: Mapping[str, str],
        *,
        cells: str = "frontiers",
        tallest: int = 430,
        tweens: bool = True,
    ) -> None:
        """Build the widget with an empty map."""
        self._names, self._tweens = dict(sources), tweens
        self._number, self._sent = 0, dict[str, Any]()
        self.contents = MapContents({})
        layers = self._layers(cells)
        self._kinds = {each.name: each.kind for each in layers}
        x0, y0, x1, y1 = bounds = carpet_bounds(field)
        self._diagonal = float(np.hypot(x1 - x0, y1 - y0))  # m: no view cone is longer
        scene = scene_data(field, layers, bounds, self.alt, tallest)
        scene["field"]["label"] = "true lines and posts"
        self.widget = MapWidget(scene=scene)
        self.widget.on_msg(self._answer)

    def update(self, contents: MapContents) -> int:
        """Show other contents, and send the browser what has changed.

        Parameters
        ----------
        contents : MapContents
            The contents. A path that only grew since the last call costs no more than its new poses.

        Returns
        -------
        int
            Number of layers that were sent.
        """
        before, self.contents = self.contents, contents
        changes: dict[str, Any] = {}
        for source in self._names:
            name, path = f"path {source}", contents.paths.get(source, ())
            if added := self._added(before.paths.get(source, ()), path):
                changes[name] = {"add": added}
            elif len(path) != self._sent.get(name, 0) or not _grew(before.paths.get(source, ()), path):
                changes[name] = layer_numbers("path", _poses(path))
            self._sent[name] = len(path)
        for name, numbers in self._others(contents).items():
            if numbers != self._sent.get(name, []):
                changes[name] = self._sent[name] = numbers
        if changes:
            self._number += 1
            self._send(changes, whole=False)
        return len(changes)

    @property
    def alt(self) -> str:
        """The map's contents in words."""
        contents = self.contents
        said = [
            f"{name}: {say_place(contents.paths[source][-1].as_array())}."
            for source, name in self._names.items()
            if contents.paths.get(source)
        ]
        if contents.estimate is not None:
            said.append(f"Landmarks on the map: {len(contents.estimate.landmarks)}.")
        if len(contents.cells):
            said.append(f"Marked cells: {len(contents.cells)}.")
        return " ".join(["Map of the field.", *said])

    # --- layers ---

    def _layers(self, cells: str) -> list[Layer]:
        """Return the empty layers, from the lowest to the highest."""
        estimator = style_of(list(self._names)[-1])
        layers = {
            "cells": cell_layer(FRONTIER, CELL, [()], cells),
            "view": Layer("cone", [np.empty((0, 5))], VIEW, "camera's view"),
            "ellipses": ellipse_layer(estimator.colour, [((), np.empty((0, 2, 2)))], "95 % ellipse"),
            "robot": ellipse_layer(estimator.colour, [((), np.empty((0, 2, 2)))], lens=True),
            "rays": line_layer(GREY, [()], jumps=True),
            "landmarks": landmark_layer(estimator.colour, [((), ())], "estimated", kinds=KINDS_IN_LEGEND),
            "seen": landmark_layer(
                GREY, [((), ())], "measured from here", open=True, size=DETECTED, jumps=True, keys=[1]
            ),
            "points": point_layer(FOUND, [()], "found by your code", marker="*", size=5.0, jumps=True),
            **{
                f"path {source}": path_layer(source, [None], name, lensed=source == "truth")
                for source, name in self._names.items()
            },
            "axis": Layer("axis", [np.empty((0, 5))], TOO_SMALL, "axis too small, and the error"),
            "wedge": Layer("wedge", [np.empty((0, 5))], TOO_SMALL, "heading too certain, and the true one"),
        }
        return [
            Layer(each.kind, each.frames, each.colour, each.label, name, each.appearance)
            for name, each in layers.items()
        ]

    def _others(self, contents: MapContents) -> dict[str, Numbers]:
        """Return the numbers of all layers but the paths."""
        pose, estimate = contents.observer_pose, contents.estimate
        ends = measured_points(contents.seen, pose)
        kinds = [each.kind for each in contents.seen]
        rays = np.hstack([np.tile([pose.x, pose.y], (len(ends), 1)), ends])
        view = () if contents.view is None else _cone(pose, *contents.view, self._diagonal)
        frames: dict[str, FloatArray] = {
            "cells": np.asarray(contents.cells, dtype=float).reshape(-1, 2),
            "view": np.array(view, dtype=float).reshape(-1, 5),
            "ellipses": np.empty((0, 5))
            if estimate is None
            else ellipse_numbers(estimate.landmarks, estimate.landmark_covariances),
            "robot": np.empty((0, 5))
            if estimate is None
            else ellipse_numbers(estimate.pose.as_array()[:2], estimate.covariance[None, :2, :2]),
            "rays": rays,
            "landmarks": np.empty((0, 3))
            if estimate is None
            else landmark_numbers(estimate.landmarks, estimate.kinds),
            "seen": landmark_numbers(ends, kinds),
            "points": pose.to_parent(contents.points) if len(contents.points) else np.empty((0, 2)),
            "axis": np.empty((0, 5)),
            "wedge": np.empty((0, 5)),
        }
        if estimate is not None and (short := contents.short) is not None:
            row = (estimate.pose.x, estimate.pose.y, short.direction, short.claimed, short.error)
            frames["wedge" if short.is_heading else "axis"] = np.array([row])
        return {name: layer_numbers(self._kinds[name], _drawable(frame)) for name, frame in frames.items()}

    # --- messages ---

    @staticmethod
    def _added(before: Sequence[Pose], path: Sequence[Pose]) -> Numbers:
        """Return the numbers of the poses by which a path grew; nothing if it did not grow or is another one."""
        if not before or len(path) <= len(before) or not _grew(before, path):
            return []
        return layer_numbers("path", _poses(path[len(before) :]))

    def _send(self, layers: Mapping[str, Any], *, whole: bool) -> None:
        self.widget.send(
            {
                "number": self._number,
                "whole": whole,
                "layers": layers,
                "alt": self.alt,
                "tweens": self._tweens,
            }
        )

    def _answer(self, widget: Any, message: Any, buffers: Any) -> None:
        """Send everything to a page that has just opened the map, or that has missed a message."""
        if isinstance(message, dict) and message.get("ask") == "everything":
            paths = {
                f"path {source}": layer_numbers("path", _poses(self.contents.paths.get(source, ())))
                for source in self._names
            }
            self._send({**self._others(self.contents), **paths}, whole=True)


def _grew(before: Sequence[Pose], path: Sequence[Pose]) -> bool:
    """Return whether a path begins with an earlier one, by its first and last poses."""
    if not before:
        return not path
    return len(path) >= len(before) and path[0] == before[0] and path[len(before) - 1] == before[-1]


def _poses(path: Sequence[Pose]) -> FloatArray:
    return np.array([each.as_array() for each in path]).reshape(-1, 3)


def _drawable(frame: FloatArray) -> FloatArray:
    """Return the rows with finite numbers near the field: a student's estimate may contain others."""
    return np.asarray(frame[(np.isfinite(frame) & (np.abs(frame) < FARTHEST)).all(axis=1)])


def _cone(pose: Pose, direction: float, half: float, reach: float, longest: float) -> tuple[float, ...]:
    return pose.x, pose.y, pose.theta + direction, half, min(reach, longest)
