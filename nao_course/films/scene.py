"""What a browser needs to draw a map: the field, the layers' appearance and the colours, as whole numbers."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.films.layers import INDICES, WIDTHS, Layer
from nao_course.geometry import FloatArray
from nao_course.plotting.style import (
    CARPET,
    DARK_CARPET,
    DARK_LINE,
    DARK_PAPER,
    GREY,
    LINE,
    PAPER,
    YELLOW,
    on_dark,
)
from nao_course.sim import Field

UNIT = 0.001  # m and rad: a film holds whole millimetres and milliradians
POST_RIM = 0.02  # m around a post, so that it stays visible on a small map
Numbers = list[int]


def whole(values: npt.ArrayLike) -> Numbers:
    """Return lengths (m) or angles (rad) as whole millimetres or milliradians, flat."""
    rounded: Numbers = np.rint(np.asarray(values, dtype=float).ravel() / UNIT).astype(int).tolist()
    return rounded


def layer_numbers(kind: Any, frame: FloatArray) -> Numbers:
    """Return the numbers of a layer's frame (N, width) as whole numbers, flat."""
    scaled = frame / UNIT
    for column in INDICES.get(kind, ()):
        scaled[:, column] = frame[:, column]
    numbers: Numbers = np.rint(scaled.ravel()).astype(int).tolist()
    return numbers


def layer_frame(kind: Any, numbers: Sequence[int]) -> FloatArray:
    """Return a layer's frame (N, width) in metres and radians, the inverse of `layer_numbers`."""
    frame = np.array(numbers, dtype=float).reshape(-1, WIDTHS[kind]) * UNIT
    for column in INDICES.get(kind, ()):
        frame[:, column] /= UNIT
    return frame


def layer_data(layer: Layer) -> dict[str, Any]:
    """Return a layer's kind and appearance, without its frames."""
    appearance = dict(layer.appearance)
    if "side" in appearance:
        appearance["side"] = whole(appearance["side"])[0]
    names = {"label": layer.label, "name": layer.name}
    return {
        "kind": layer.kind,
        **two_colours(layer.colour),
        **{key: value for key, value in names.items() if value},
        **appearance,
    }


def two_colours(colour: str, dark: str = "") -> dict[str, str]:
    """Return a colour for light and for dark pages."""
    return {"colour": colour, "dark": dark or on_dark(colour)}


def scene_data(
    field: Field | None, layers: Sequence[Layer], bounds: Sequence[float], alt: str, tallest: int
) -> dict[str, Any]:
    """Return everything of a map that does not move.

    The bounds are x_min, y_min, x_max, y_max in m, `tallest` is the largest height of the map in px, and the layers are
    ordered from the lowest to the highest, above the field if there is one.
    """
    return {
        "bounds": whole(bounds),
        "field": None if field is None else field_data(field),
        "paper": two_colours(PAPER, DARK_PAPER) if field is None else two_colours(CARPET, DARK_CARPET),
        "layers": [layer_data(each) for each in layers],
        "alt": alt,
        "tallest": tallest,
    }


def field_data(field: Field) -> dict[str, Any]:
    """Return the lines, arcs and goals of a field in the field frame, with its pose on the map."""
    d = field.dimensions
    strips = np.vstack([field.lines, field.mark_lines]).reshape(-1, 2, 2)
    boxes = np.hstack([strips.min(axis=1) - d.line_width / 2, strips.max(axis=1) + d.line_width / 2])
    goal = YELLOW if d.goal_colour == "yellow" else "#d9dde3"
    return {
        "pose": whole(field.pose.as_array()),
        "carpet": {"box": whole(field.carpet), **two_colours(CARPET, DARK_CARPET)},
        "line": two_colours(LINE, DARK_LINE),
        "lines": [whole(each) for each in boxes],
        "width": whole(d.line_width)[0],
        "arcs": [whole(each) for each in field.arcs],
        "bars": [whole(each[:, :2]) for each in field.bars],
        "posts": [whole([*each, d.post_diameter / 2 + POST_RIM]) for each in field.posts],
        "goal": {"colour": goal, "rim": "#6d5600" if d.goal_colour == "yellow" else GREY},
    }


def bounds_of(layers: Sequence[Layer], margin: float) -> list[float]:
    """Return limits (x_min, y_min, x_max, y_max), m, that contain all positions of the layers, with a margin."""
    places = [frame[:, :2] for layer in layers for frame in layer.frames if len(frame)]
    if not places:
        return [-1.0, -1.0, 1.0, 1.0]
    every = np.vstack(places)
    return [*(every.min(axis=0) - margin), *(every.max(axis=0) + margin)]


def carpet_bounds(field: Field) -> list[float]:
    """Return the limits of a field's carpet on the map, m."""
    x0, y0, x1, y1 = field.carpet
    corners = field.pose.to_parent([(x, y) for x in (x0, x1) for y in (y0, y1)])
    return [*corners.min(axis=0), *corners.max(axis=0)]
