"""What a cell shows: a finished figure with its text for screen readers, or a table; and words for such texts."""

from __future__ import annotations

import base64
import html
import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from nao_course.geometry import FloatArray
from nao_course.plotting.style import course_style


@dataclass(frozen=True, eq=False)
class Drawing:
    """A finished figure and what it shows in words.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure; add to it if you like.
    alt : str
        Its contents for a reader who cannot see it.
    photo : bool
        Whether it holds camera pictures: in a notebook these are small as JPEG and large as PNG.
    """

    figure: Figure
    alt: str
    photo: bool = False

    def __post_init__(self) -> None:
        """Lay the figure out once and for all: matplotlib's layout goes on moving at every drawing."""
        with course_style():
            self.figure.draw_without_rendering()
            self.figure.set_layout_engine("none")

    def image(self, kind: str = "png") -> bytes:
        """Return the figure as a "png", "jpeg" or "svg" file; the same figure gives the same bytes."""
        options: dict[str, dict[str, Any]] = {
            "png": {"metadata": {"Software": None}},
            "svg": {"metadata": {"Date": None, "Creator": None}},
            "jpeg": {"pil_kwargs": {"quality": 84, "subsampling": 0, "optimize": True}},
        }
        if kind not in options:
            raise ValueError(f"a drawing can be made into {', '.join(options)}; got {kind!r}")
        buffer = io.BytesIO()
        with course_style():
            self.figure.savefig(buffer, format=kind, dpi=100, **options[kind])
        return buffer.getvalue()

    def save(self, path: str | Path) -> Path:
        """Write the figure to a file; its suffix (.png, .jpeg or .svg) says how.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        ValueError
            For another suffix.
        """
        path = Path(path)
        kind = path.suffix.lower().lstrip(".").replace("jpg", "jpeg")
        path.write_bytes(self.image(kind))
        return path

    def __repr__(self) -> str:
        """Say what the figure shows."""
        return f"Drawing({self.alt!r})"

    def _repr_html_(self) -> str:
        """Show the figure in a notebook, with its text for screen readers."""
        kind = "jpeg" if self.photo else "png"
        data = self.image(kind)
        return image_tag(data if self.photo else _with_few_colours(data), self.alt, kind)


def _with_few_colours(png: bytes) -> bytes:
    """Return a PNG with a palette of 256 colours: a third as large, and a line drawing looks the same."""
    with Image.open(io.BytesIO(png)) as image:
        buffer = io.BytesIO()
        image.convert("RGB").quantize(256, Image.Quantize.MEDIANCUT).save(buffer, "png", optimize=True)
    return buffer.getvalue()


def image_tag(data: bytes, alt: str, kind: str) -> str:
    """HTML of a picture that needs no file; `kind` is "png" or "jpeg"."""
    encoded = base64.b64encode(data).decode("ascii")
    source = f"data:image/{kind};base64,{encoded}"
    return f'<img alt="{html.escape(alt, quote=True)}" style="max-width: 100%" src="{source}">'


@dataclass(frozen=True)
class Table:
    """A few values in rows and columns, for a reader: an HTML table in a notebook, lines of text elsewhere.

    Parameters
    ----------
    columns : tuple of str
        Their heads.
    rows : tuple of tuple of str
        As many cells each.
    """

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def __repr__(self) -> str:
        """The same in lines, columns below each other."""
        lines = (self.columns, *self.rows)
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        return "\n".join(
            "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
            for line in lines
        )

    def _repr_html_(self) -> str:
        """A table whose first column names its rows."""

        def cell(tag: str, text: str, number: int) -> str:
            side = "left" if number == 0 else "right"
            return f'<{tag} style="text-align: {side}; padding: 0.15em 0.8em">{html.escape(text)}</{tag}>'

        head = "".join(cell("th", text, number) for number, text in enumerate(self.columns))
        body = "".join(
            f"<tr>{''.join(cell('td', text, number) for number, text in enumerate(row))}</tr>"
            for row in self.rows
        )
        return f"<table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def table(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> Table:
    """Set values in a table.

    Parameters
    ----------
    columns : sequence of str
        Their heads.
    rows : iterable of sequences
        As many values each; they are shown as `str` gives them.

    Returns
    -------
    Table
        To be a cell's last line.

    Raises
    ------
    ValueError
        If a row has another number of values than there are columns.
    """
    texts = tuple(tuple(str(value) for value in row) for row in rows)
    for number, row in enumerate(texts, start=1):
        if len(row) != len(columns):
            raise ValueError(f"row {number} has {len(row)} values for {len(columns)} columns")
    return Table(tuple(columns), texts)


# --- words for alt texts ---


def say_angle(angle: float) -> str:
    """An angle (rad) in whole degrees."""
    return f"{np.degrees(angle):z.0f} deg"


def say_count(number: int, noun: str) -> str:
    """A number of things, such as "1 robot" or "3 robots"."""
    return f"{number} {noun}" + ("" if number == 1 else "s")


def say_place(pose: FloatArray) -> str:
    """A pose (x, y, theta) in metres and degrees; no heading where theta is NaN."""
    heading = "" if np.isnan(pose[2]) else f", heading {say_angle(pose[2])}"
    return f"({pose[0]:z.2f}, {pose[1]:z.2f}) m{heading}"
