"""Outputs of a cell: finished figures with alt texts, and tables; and functions that write alt texts."""

from __future__ import annotations

import base64
import html
import io
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nao_course.geometry import FloatArray
from nao_course.plotting.style import LABEL_COLOURS, course_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage
    from matplotlib.transforms import Bbox

# A number with its unit, a ratio or nothing, such as 3.1, 12 %, 23 of 98, 1.2 +- 0.3, -.
_NUMBER = re.compile(
    r"[<>≈]?\s*[-+−]?\d[\d.,]*(e[-+]?\d+)?(\s?(%|[a-zµ°²³/]+|of \d+|(\+-|±|to|/).*))?|[-–—]?|nan"
)


LEAST = 0.72  # of a drawing's width, in a narrow column: letters of 9 points are still 9 px high
NO_PHOTO = "drawn"  # matplotlib's name (gid) of an image that is a drawing itself


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
        return self.html(self.alt)

    def html(self, alt: str) -> str:
        """Return the figure as HTML with an alt text.

        The course's style sheet (nao_course/lab/custom) inverts the lightness of a ``nao-figure`` on a dark page. In a
        figure with photographs it inverts what is below ``nao-around``, which has a hole for each photograph.
        """
        kind = "jpeg" if self.photo else "png"
        data = self.image("jpeg") if self.photo else _with_few_colours(self.image())
        kept = [np.array(box.extents) for box in self._in_true_colours()]
        if not kept:
            return image_tag(data, alt, kind, name="nao-figure", least=LEAST * self.figure.bbox.width)
        around = f'<span class="nao-around" style="clip-path: {_around(kept, np.array(self.figure.bbox.size))}"></span>'
        return f'<div class="nao-photos">{image_tag(data, alt, kind)}{around}</div>'

    def _in_true_colours(self) -> Iterator[Bbox]:
        """Yield the places (pixels) of photographs, of pictures of labels and of the keys to these labels."""
        from matplotlib.patches import Patch

        pictures = [
            axes
            for axes in self.figure.axes
            if any(
                image.get_gid() != NO_PHOTO and (self.photo or _has_true_colours(image))
                for image in axes.images
            )
        ]
        yield from (axes.bbox.frozen() for axes in pictures)
        for legend in self.figure.legends if pictures else ():
            keys = (key for key in legend.legend_handles if isinstance(key, Patch))
            yield from (key.get_window_extent().padded(1) for key in keys)


def _has_true_colours(image: AxesImage) -> bool:
    """Return whether an image is in RGB, grey or the colours of the labels: not a matrix in a scale of colours."""
    colours = image.get_cmap()
    is_listed = getattr(colours, "colors", None) == LABEL_COLOURS
    return np.ndim(image.get_array()) == 3 or colours.name == "gray" or is_listed  # type: ignore[arg-type]


def _around(boxes: Iterable[FloatArray], size: FloatArray) -> str:
    """Return a figure of `size` (width, height) without boxes (left, bottom, right, top) as a polygon of CSS."""
    corners = [(0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (0.0, 100.0), (0.0, 0.0)]
    for box in boxes:
        left, bottom, right, top = np.clip(100 * box / np.tile(size, 2), 0, 100)
        down, up = 100 - bottom, 100 - top
        corners += [(left, up), (right, up), (right, down), (left, down), (left, up), (0.0, 0.0)]
    return f"polygon(evenodd, {', '.join(f'{x:.2f}% {y:.2f}%' for x, y in corners)})"


def _with_few_colours(png: bytes) -> bytes:
    """Return a PNG with a palette of 256 colours, a third as large and without visible loss for line drawings."""
    from PIL import Image

    with Image.open(io.BytesIO(png)) as image:
        buffer = io.BytesIO()
        image.convert("RGB").quantize(256, Image.Quantize.MEDIANCUT).save(buffer, "png", optimize=True)
    return buffer.getvalue()


def image_tag(data: bytes, alt: str, kind: str, *, name: str = "", least: float = 0.0) -> str:
    """Return an HTML image with embedded data; `kind` is "png" or "jpeg", and `name` its class for style sheets.

    In a narrow column of JupyterLab it keeps a width of `least` px, if that is more than the style sheet's width.
    """
    encoded = base64.b64encode(data).decode("ascii")
    source = f"data:image/{kind};base64,{encoded}"
    named = f' class="{name}"' if name else ""
    kept = f"; --nao-wider: {least:.0f}px" if least else ""
    return f'<img{named} alt="{html.escape(alt, quote=True)}" style="max-width: 100%{kept}" src="{source}">'


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
        """Return the table as HTML, with columns of numbers at the right and all others at the left."""
        sides = [
            "right" if column and all(map(_NUMBER.fullmatch, column)) else "left"
            for column in ([row[number] for row in self.rows] for number in range(len(self.columns)))
        ]

        def cell(tag: str, text: str, number: int) -> str:
            wrap = "; white-space: nowrap" if sides[number] == "right" and tag == "td" else ""
            style = f"text-align: {sides[number]}; padding: 0.15em 0.8em{wrap}"
            return f'<{tag} style="{style}">{html.escape(text)}</{tag}>'

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
