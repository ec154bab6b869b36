"""A film: layers of a map, perhaps matrices beside it, and a caption for each step, stored as JSON."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from nao_course.films.layers import KINDS, WIDTHS, Layer
from nao_course.films.scene import (
    bounds_of,
    carpet_bounds,
    layer_frame,
    layer_numbers,
    scene_data,
    two_colours,
)
from nao_course.geometry import FloatArray
from nao_course.plotting import matrix_signs
from nao_course.plotting.style import FOUND
from nao_course.sim import Field

FORMAT = "nao-course film 1"
LEVELS = 200  # of a matrix: an entry of 1 is stored as 200
TALLEST = 460  # px: largest height of a map
MARGIN = 0.3  # m around the layers of a map without a field
POSITIVE, NEGATIVE, ZERO = "#0b5fa5", "#c84b00", "#ffffff"  # entries of 1, -1 and 0
PACES = (1, 3, 8, 20)  # steps a second that a film offers


@dataclass(frozen=True, eq=False)
class Matrix:
    """A symmetric matrix beside the map.

    Parameters
    ----------
    title : str
        Its title.
    frames : sequence of ndarray, shape (n, n)
        Values from -1 to 1 of each frame; n may grow.
    blocks : sequence of int
        Sizes of the blocks that lines separate; their sum is the largest n.
    names : sequence of str
        Names of the blocks.
    signs : bool
        Whether only the signs have a meaning.
    marked : sequence of sequences of int, optional
        Rows of each frame whose common entries are framed.
    """

    title: str
    frames: Sequence[FloatArray]
    blocks: Sequence[int]
    names: Sequence[str]
    signs: bool = False
    marked: Sequence[Sequence[int]] | None = None

    @property
    def size(self) -> int:
        """Largest number of rows."""
        return sum(self.blocks)

    def data(self) -> dict[str, Any]:
        """Return the matrix as values for JSON."""
        return {
            "title": self.title,
            "alt": f"{self.title}, {self.size} rows; each caption says what has changed",
            "size": self.size,
            "blocks": list(self.blocks),
            "names": list(self.names),
            "levels": LEVELS,
            "signs": self.signs,
            "mark": FOUND,
            "positive": two_colours(matrix_signs.POSITIVE if self.signs else POSITIVE),
            "negative": two_colours(matrix_signs.NEGATIVE if self.signs else NEGATIVE),
            "zero": two_colours(ZERO, "#181c22"),
            "frames": _without_repeats([self._numbers(each) for each in self.frames]),
            "marked": None if self.marked is None else [list(each) for each in self.marked],
        }

    def _numbers(self, matrix: FloatArray) -> list[int]:
        """Return the upper triangle, row by row, as whole numbers."""
        padded = np.zeros((self.size, self.size))
        padded[: len(matrix), : len(matrix)] = matrix
        numbers: list[int] = np.rint(padded[np.triu_indices(self.size)] * LEVELS).astype(int).tolist()
        return numbers


@dataclass(frozen=True, eq=False)
class Film:
    """A film of a drive.

    Parameters
    ----------
    title : str
        Name of the film, also for screen readers.
    layers : sequence of Layer
        From the lowest to the highest. Each has one frame for every caption, or a single one if it stands still.
    captions : sequence of str
        What happens in each frame; screen readers read it.
    field : Field, optional
        Drawn under the layers.
    matrices : sequence of Matrix
        Beside the map.
    step : str
        What a frame is called, such as "Step".
    pace : int
        Frames a second at first, one of `PACES`.
    bounds : sequence of float, optional
        Limits of the map x_min, y_min, x_max, y_max, m; by default the limits of the carpet or of the layers.

    Raises
    ------
    ValueError
        If there are no captions, or a layer or a matrix has another number of frames.
    """

    title: str
    layers: Sequence[Layer]
    captions: Sequence[str]
    field: Field | None = None
    matrices: Sequence[Matrix] = ()
    step: str = "Step"
    pace: int = 3
    bounds: Sequence[float] | None = None

    def __post_init__(self) -> None:
        """Check the numbers of frames."""
        if not self.captions:
            raise ValueError("Film: a film needs at least one caption")
        if self.pace not in PACES:
            raise ValueError(f"Film: pace must be one of {PACES} frames a second, got {self.pace!r}")
        parts = [(each.label or each.kind, each.frames) for each in self.layers]
        for name, frames in (*parts, *((each.title, each.frames) for each in self.matrices)):
            if len(frames) not in (1, len(self.captions)):
                raise ValueError(
                    f"Film: {name} has {len(frames)} frames; expected {len(self.captions)}, one for each caption, or 1"
                )

    @property
    def alt(self) -> str:
        """What the film shows, in a sentence for screen readers."""
        shown = ", ".join(dict.fromkeys(each.label for each in self.layers if each.label))
        return f"Map with {shown}. {self.captions[-1]}"

    def data(self) -> dict[str, Any]:
        """Return the film as values for JSON, with lengths in millimetres and angles in milliradians."""
        bounds = self.bounds
        if bounds is None:
            bounds = bounds_of(self.layers, MARGIN) if self.field is None else carpet_bounds(self.field)
        scene = scene_data(self.field, self.layers, bounds, self.alt, TALLEST)
        for layer, data in zip(self.layers, scene["layers"], strict=True):
            numbers = [layer_numbers(layer.kind, each) for each in layer.frames]
            data["frames"] = numbers if layer.kind == "path" else _without_repeats(numbers)
        return {
            "format": FORMAT,
            "title": self.title,
            "step": self.step,
            "pace": self.pace,
            "paces": list(PACES),
            **scene,
            "matrices": [each.data() for each in self.matrices],
            "captions": list(self.captions),
        }

    def to_json(self) -> str:
        """Return the film as JSON without spaces; equal films give equal texts."""
        return json.dumps(self.data(), separators=(",", ":"), ensure_ascii=False)

    def save(self, path: str | Path) -> Path:
        """Save the film as a JSON file, and return its path."""
        path = Path(path)
        path.write_text(self.to_json() + "\n", encoding="utf-8")
        return path


def _without_repeats(frames: Sequence[list[Any]]) -> list[list[Any] | None]:
    """Return the frames with None in place of a frame that equals the one before it."""
    return [None if number and each == frames[number - 1] else each for number, each in enumerate(frames)]


# --- reading ---


def read_film(source: str | Path) -> dict[str, Any]:
    """Read and check a film file.

    Parameters
    ----------
    source : str or Path
        Path of the file.

    Returns
    -------
    dict
        The values of the file, as `Film.data` makes them.

    Raises
    ------
    ValueError
        If the file is not a film. The message names the file, the place in it, and what is wrong there.
    """
    path = Path(source)
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except (UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise ValueError(f"{path.name} is not a film: it is not valid JSON ({error})") from None
    wrong = wrong_in_film(data)
    if wrong:
        raise ValueError(f"{path.name} is not a film: {wrong}. Record it again.")
    checked: dict[str, Any] = data
    return checked


def frames_of(data: Mapping[str, Any], number: int) -> list[FloatArray]:
    """Return the frames (N, width) of a layer of a film's data, in metres and radians."""
    layer, last, frames = data["layers"][number], list[int](), []
    for each in layer["frames"]:
        last = last if each is None else each
        frames.append(layer_frame(layer["kind"], last))
    return frames


def wrong_in_film(data: Any) -> str:
    """Return what is wrong in the data of a film, or nothing."""
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        return f"its format must be {FORMAT!r}"
    expected = {
        "title": str,
        "alt": str,
        "step": str,
        "captions": list,
        "layers": list,
        "matrices": list,
        "bounds": list,
    }
    for key, expected_type in expected.items():
        if not isinstance(data.get(key), expected_type):
            return f"{key} must be a {expected_type.__name__}"
    count = len(data["captions"])
    if not count or not all(isinstance(each, str) for each in data["captions"]):
        return "captions must be texts, at least one"
    bounds = data["bounds"]
    if len(bounds) != 4 or not _are_whole(bounds) or bounds[0] >= bounds[2] or bounds[1] >= bounds[3]:
        return "bounds must be four whole numbers x_min, y_min, x_max, y_max in this order"
    for number, layer in enumerate(data["layers"]):
        kind = layer.get("kind") if isinstance(layer, dict) else None
        if kind not in KINDS:
            return f"layer {number} has the unknown kind {kind!r}"
        if wrong := _wrong_frames(layer.get("frames"), count, WIDTHS[kind], exact=False):
            return f"layer {number} ({kind}): {wrong}"
    for number, matrix in enumerate(data["matrices"]):
        size = matrix.get("size") if isinstance(matrix, dict) else None
        if not isinstance(size, int) or size < 1:
            return f"matrix {number} has no size"
        if wrong := _wrong_frames(matrix.get("frames"), count, size * (size + 1) // 2, exact=True):
            return f"matrix {number}: {wrong}"
    return ""


def _wrong_frames(frames: Any, count: int, width: int, *, exact: bool) -> str:
    """Return what is wrong with the frames of a layer or, with a fixed number of values, of a matrix."""
    if not isinstance(frames, list) or len(frames) not in (1, count):
        return f"it must have 1 or {count} frames, one for each caption"
    for number, frame in enumerate(frames):
        if frame is None and number:
            continue
        if not isinstance(frame, list) or not _are_whole(frame):
            return f"frame {number} must be a list of whole numbers"
        if len(frame) % width or (exact and len(frame) != width):
            return f"frame {number} has {len(frame)} numbers, which does not fit {width} for each entry"
    return ""


def _are_whole(values: list[Any]) -> bool:
    return all(isinstance(each, int) and not isinstance(each, bool) for each in values)
