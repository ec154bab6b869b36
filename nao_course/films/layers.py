"""Layers of a map: paths, ellipses, landmarks, points, lines and cells, each with its numbers for every frame."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray
from nao_course.plotting import LANDMARK_MARKERS, ellipse_outlines, style_of

Kind = Literal["path", "ellipses", "landmarks", "points", "curve", "lines", "cells", "cone", "axis", "wedge"]
KINDS: tuple[Kind, ...] = get_args(Kind)
# Numbers of one entry of a layer, and which of them are indices; the others are metres or radians
WIDTHS: Mapping[Kind, int] = {
    "path": 3,  # x, y, heading
    "ellipses": 5,  # x, y, and the matrix (a, b; b, d) that maps the unit circle to the ellipse
    "landmarks": 3,  # x, y, number of the kind
    "points": 2,
    "curve": 2,
    "lines": 4,  # both ends
    "cells": 2,  # centre
    "cone": 5,  # x, y, direction, half of the angle, reach
    "axis": 5,  # x, y, direction, half axis that is claimed, error along it
    "wedge": 5,  # x, y, estimated heading, half angle that is claimed, true minus estimated heading
}
INDICES: Mapping[Kind, tuple[int, ...]] = {"landmarks": (2,)}
MARKS = tuple(LANDMARK_MARKERS)  # kinds of landmarks by their numbers
DETECTED = 5.5  # px: half the width of an open marker around a measured landmark


@dataclass(frozen=True, eq=False)
class Layer:
    """A part of a map that moves.

    Parameters
    ----------
    kind : str
        What its numbers are: "path", "ellipses", "landmarks", "points", "curve", "lines", "cells",
        "cone", "axis" or "wedge"; a wedge is drawn in the lens only.
    frames : sequence of ndarray, shape (N, width of the kind)
        Numbers of each frame, in metres and radians. A path has those poses that are new in a frame. A layer that
        stands still has a single frame.
    colour : str
        "#rrggbb".
    label : str
        Name in the legend; empty for none.
    name : str
        Name by which a live map updates the layer.
    appearance : mapping of str to object
        Details for the script that draws it: marker, dash, width, size, side (m), fill, alpha, open, robot, trail,
        keeps (all earlier frames stay visible), jumps (no movement between frames), texts, keys, always, kinds (the
        legend names each kind of landmark), lens (a lens enlarges the map around the first ellipse until it shows the
        robots of all paths that are lensed).
    """

    kind: Kind
    frames: Sequence[FloatArray]
    colour: str
    label: str = ""
    name: str = ""
    appearance: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the shapes."""
        if self.kind not in KINDS:
            raise ValueError(f"Layer: kind must be one of {', '.join(KINDS)}; got {self.kind!r}")
        width = WIDTHS[self.kind]
        frames = []
        for number, each in enumerate(self.frames):
            frame = np.asarray(each, dtype=float)
            frame = frame.reshape(0, width) if frame.size == 0 else np.atleast_2d(frame)
            if frame.shape[1:] != (width,) or not np.isfinite(frame).all():
                raise ValueError(
                    f"Layer: frame {number} of {self.kind} must hold finite numbers of shape (N, {width}), "
                    f"got shape {frame.shape}"
                )
            frames.append(frame)
        object.__setattr__(self, "frames", tuple(frames))


def path_layer(
    source: str, poses: Iterable[npt.ArrayLike | None], label: str = "", **appearance: Any
) -> Layer:
    """Return the path of a robot, which is drawn at its last pose.

    Parameters
    ----------
    source : str
        A key of `nao_course.plotting.STYLES`, which gives colour, marker and line.
    poses : iterable of array_like, shape (3,) or (N, 3), or None
        New poses of each frame, m and rad; None if there is none yet.
    label : str
        Name in the legend; by default the source's.
    **appearance : object
        As in `Layer`.
    """
    style = style_of(source)
    frames = [
        np.empty((0, 3)) if each is None else np.atleast_2d(np.asarray(each, dtype=float)) for each in poses
    ]
    own = {"marker": style.marker, "dash": dash_of(style.line)}
    return Layer("path", frames, style.colour, label or style.label, appearance={**own, **appearance})


def dash_of(line: Any) -> list[float]:
    """Return the dashes and gaps of a line style of matplotlib, in widths of the line; empty for a solid line."""
    return list(line[1]) if isinstance(line, tuple) else []


def ellipse_layer(
    colour: str,
    frames: Iterable[tuple[npt.ArrayLike, npt.ArrayLike]],
    label: str = "",
    probability: float = 0.95,
    **appearance: Any,
) -> Layer:
    """Return covariance ellipses.

    Parameters
    ----------
    colour : str
        "#rrggbb".
    frames : iterable of (array_like (N, 2), array_like (N, 2, 2))
        Means, m, and covariances, m^2, of each frame. An invalid covariance has no ellipse.
    label : str
        Name in the legend.
    probability : float
        Probability inside each ellipse.
    **appearance : object
        As in `Layer`.
    """
    return Layer(
        "ellipses",
        [ellipse_numbers(*each, probability) for each in frames],
        colour,
        label,
        appearance=appearance,
    )


def ellipse_numbers(
    centres: npt.ArrayLike, covariances: npt.ArrayLike, probability: float = 0.95
) -> FloatArray:
    """Return the numbers (N, 5) of ellipses by their means (N, 2) and covariances (N, 2, 2), without invalid ones."""
    means = np.asarray(centres, dtype=float).reshape(-1, 2)
    # The outline's points at 0 and 90 degrees are the columns of the matrix that maps the unit circle to the ellipse.
    outlines = ellipse_outlines(means, covariances, probability, corners=5)
    rows = np.column_stack([means, outlines[:, 0] - means, outlines[:, 1, 1] - means[:, 1]])
    return np.asarray(rows[np.isfinite(rows).all(axis=1)])


def landmark_layer(
    colour: str, frames: Iterable[tuple[npt.ArrayLike, Sequence[str]]], label: str = "", **appearance: Any
) -> Layer:
    """Return landmarks with the marker of their kind.

    Parameters
    ----------
    colour : str
        "#rrggbb".
    frames : iterable of (array_like (N, 2), sequence of str)
        Positions, m, and kinds ("corner", "post" or "cross") of each frame.
    label : str
        Name in the legend.
    **appearance : object
        As in `Layer`.
    """
    numbers = [landmark_numbers(*each) for each in frames]
    shown = sorted({int(kind) for frame in numbers for kind in frame[:, 2]})
    own = {"markers": list(LANDMARK_MARKERS.values()), "keys": shown or [0]}
    return Layer("landmarks", numbers, colour, label, appearance={**own, **appearance})


def landmark_numbers(positions: npt.ArrayLike, kinds: Sequence[str]) -> FloatArray:
    """Return the numbers (N, 3) of landmarks by their positions (N, 2), m, and their kinds."""
    places = np.asarray(positions, dtype=float).reshape(-1, 2)
    return (
        np.column_stack([places, [MARKS.index(kind) for kind in kinds]]) if len(places) else np.empty((0, 3))
    )


def point_layer(colour: str, frames: Iterable[npt.ArrayLike], label: str = "", **appearance: Any) -> Layer:
    """Return points (N, 2), m, of each frame; a ``size`` below 2 px draws dots, for example for particles."""
    return Layer(
        "points", [_pairs(each) for each in frames], colour, label, appearance={"marker": "o", **appearance}
    )


def curve_layer(colour: str, frames: Iterable[npt.ArrayLike], label: str = "", **appearance: Any) -> Layer:
    """Return a curve through points (N, 2), m, of each frame, for example a path that is estimated anew."""
    return Layer("curve", [_pairs(each) for each in frames], colour, label, appearance=appearance)


def cell_layer(
    colour: str, side: float, frames: Iterable[npt.ArrayLike], label: str = "", **appearance: Any
) -> Layer:
    """Return soft square cells of a grid with some `side`, m, by their centres (N, 2), m, of each frame."""
    own = {"side": side, "jumps": True}
    return Layer("cells", [_pairs(each) for each in frames], colour, label, appearance={**own, **appearance})


def line_layer(colour: str, frames: Iterable[npt.ArrayLike], label: str = "", **appearance: Any) -> Layer:
    """Return straight lines (N, 4) as x1, y1, x2, y2, m, of each frame, for example rays or the edges of a graph."""
    lines = [np.asarray(each, dtype=float).reshape(-1, 4) for each in frames]
    return Layer("lines", lines, colour, label, appearance=appearance)


def _pairs(points: npt.ArrayLike) -> FloatArray:
    return np.asarray(points, dtype=float).reshape(-1, 2)
