"""Outputs of a cell: finished figures with alt texts, and tables; and functions that write alt texts."""

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
    """A finished figure with its alt text.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure, which may still be added to.
    alt : str
        Alt text: the figure's contents in words.
    photo : bool
        Whether the figure contains camera pictures, which are much smaller as JPEG than as PNG.
    """

    figure: Figure
    alt: str
    photo: bool = False

    def __post_init__(self) -> None:
        """Lay the figure out once, because matplotlib would otherwise change the layout at each drawing."""
        with course_style():
            self.figure.draw_without_rendering()
            self.figure.set_layout_engine("none")

    def image(self, kind: str = "png") -> bytes:
        """Return the figure as a "png", "jpeg" or "svg" file; equal figures give equal bytes."""
        options: dict[str, dict[str, Any]] = {
            "png": {"metadata": {"Software": None}},
            "svg": {"metadata": {"Date": None, "Creator": None}},
            "jpeg": {"pil_kwargs": {"quality": 84, "subsampling": 0, "optimize": True}},
        }
        if kind not in options:
            raise ValueError(f"kind must be one of {', '.join(options)}; got {kind!r}")
        buffer = io.BytesIO()
        with course_style():
            self.figure.savefig(buffer, format=kind, dpi=100, **options[kind])
        return buffer.getvalue()

    def save(self, path: str | Path) -> Path:
        """Save the figure in the format of the file's suffix: .png, .jpeg or .svg.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        ValueError
            If the suffix is not supported.
        """
        path = Path(path)
        kind = path.suffix.lower().lstrip(".").replace("jpg", "jpeg")
        path.write_bytes(self.image(kind))
        return path

    def __repr__(self) -> str:
        """Return the alt text."""
        return f"Drawing({self.alt!r})"

    def _repr_html_(self) -> str:
        """Return the figure as HTML with its alt text."""
        kind = "jpeg" if self.photo else "png"
        data = self.image(kind)
        return image_tag(data if self.photo else _with_few_colours(data), self.alt, kind)


def _with_few_colours(png: bytes) -> bytes:
    """Return a PNG with a palette of 256 colours, a third as large and without visible loss for line drawings."""
    with Image.open(io.BytesIO(png)) as image:
        buffer = io.BytesIO()
        image.convert("RGB").quantize(256, Image.Quantize.MEDIANCUT).save(buffer, "png", optimize=True)
    return buffer.getvalue()


def image_tag(data: bytes, alt: str, kind: str) -> str:
    """Return an HTML image with embedded data; `kind` is "png" or "jpeg"."""
    encoded = base64.b64encode(data).decode("ascii")
    source = f"data:image/{kind};base64,{encoded}"
    return f'<img alt="{html.escape(alt, quote=True)}" style="max-width: 100%" src="{source}">'


@dataclass(frozen=True)
class Table:
    """A small table, shown as HTML in a notebook and as lines of text elsewhere.

    Parameters
    ----------
    columns : tuple of str
        Headings of the columns.
    rows : tuple of tuple of str
        Cells of each row, one per column.
    """

    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    def __repr__(self) -> str:
        """Return the table as lines of text with aligned columns."""
        lines = (self.columns, *self.rows)
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        return "\n".join(
            "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
            for line in lines
        )

    def _repr_html_(self) -> str:
        """Return the table as HTML."""

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
    """Return a table of values.

    Parameters
    ----------
    columns : sequence of str
        Headings of the columns.
    rows : iterable of sequences
        Values of each row, one per column, shown as `str` formats them.

    Returns
    -------
    Table
        The table, shown if it is a cell's last line.

    Raises
    ------
    ValueError
        If the number of values in a row differs from the number of columns.
    """
    texts = tuple(tuple(str(value) for value in row) for row in rows)
    for number, row in enumerate(texts, start=1):
        if len(row) != len(columns):
            raise ValueError(f"row {number} has {len(row)} values, but there are {len(columns)} columns")
    return Table(tuple(columns), texts)


# --- parts of alt texts ---


def say_angle(angle: float) -> str:
    """Return an angle (rad) as text in whole degrees."""
    return f"{np.degrees(angle):z.0f} deg"


def say_place(pose: FloatArray) -> str:
    """Return a pose (x, y, theta) as text in metres and degrees, without a heading if theta is NaN."""
    heading = "" if np.isnan(pose[2]) else f", heading {say_angle(pose[2])}"
    return f"({pose[0]:z.2f}, {pose[1]:z.2f}) m{heading}"
