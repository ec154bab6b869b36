"""The results of a panel's function: pictures, figures, tables and texts, for a page or for a still figure."""

from __future__ import annotations

import html
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from nao_course.plotting import Drawing, course_style, plot_picture
from nao_course.plotting.drawing import NO_PHOTO
from nao_course.plotting.legends import legend_below
from nao_course.sim import Picture
from nao_course.widgets.parts import jpeg, png

Pixels = npt.NDArray[np.uint8]

FEW_COLOURS = 32  # a picture with at most this many colours is sent as PNG, which keeps each colour
_PARTS = "a picture, a Drawing, a table, a text, a Legend, or {title: picture, Drawing or table}"


@dataclass(frozen=True)
class Legend:
    """A legend: the meanings of the colours in a picture.

    Parameters
    ----------
    colours : mapping of str to str
        Colour of each meaning, such as "#ff0000".
    """

    colours: Mapping[str, str]

    def _repr_html_(self) -> str:
        """Return coloured patches with their meanings as HTML."""
        return "".join(
            f"<span>{colour_key(colour)}{html.escape(text)}</span>" for text, colour in self.colours.items()
        )

    def patches(self) -> list[Patch]:
        """Return coloured patches with their meanings for a figure's legend."""
        return [
            Patch(facecolor=colour, edgecolor="#333333", label=text) for text, colour in self.colours.items()
        ]


def colour_key(colour: str) -> str:
    """Return the HTML of a small patch in a colour."""
    return f'<i class="nao-key" style="background:{colour}"></i>'


@dataclass(frozen=True)
class Shown:
    """The results of one call of a panel's function.

    By title and in order, it has pictures in RGB (H, W, 3) or RGBA (H, W, 4), figures included, the figures alone, and
    tables, which have ``_repr_html_`` for a page and `repr` for a text.
    """

    pictures: Mapping[str, Pixels]
    drawings: Mapping[str, Drawing]
    tables: Mapping[str, Any] = field(default_factory=dict)
    legends: tuple[Legend, ...] = ()
    texts: tuple[str, ...] = ()

    @classmethod
    def of(cls, parts: Iterable[Any]) -> Shown:
        """Sort a function's results by kind; a repeated title replaces the earlier result; refuse unknown kinds."""
        pictures: dict[str, Any] = {}
        tables: dict[str, Any] = {}
        legends, texts = [], []
        for part in parts:
            if isinstance(part, str):
                texts.append(part)
            elif isinstance(part, Legend):
                legends.append(part)
            else:
                no_title = " " * (len(pictures) + len(tables))  # unique, so that each has its own place
                for title, each in part.items() if isinstance(part, Mapping) else [(no_title, part)]:
                    (pictures if is_picture(each) else tables)[str(title)] = each
        drawings = {title: each for title, each in pictures.items() if isinstance(each, Drawing)}
        seen = {title: as_picture(each) for title, each in pictures.items()}
        return cls(seen, drawings, tables, tuple(legends), tuple(texts))

    def tables_html(self) -> str:
        """Return the tables with their titles as HTML."""
        titles = (f"<b>{html.escape(title)}</b>" if title.strip() else "" for title in self.tables)
        return "".join(
            f"<div>{title}{table._repr_html_()}</div>"
            for title, table in zip(titles, self.tables.values(), strict=True)
        )

    @course_style()
    def drawing(self, words: str, marks: Mapping[str, tuple[float, ...]]) -> Drawing:
        """Return the pictures side by side as one figure, or a single figure, with marks at pixels (u, v) by title.

        `words` is the text alternative, and stands in the figure where there is no picture.
        """
        if len(self.drawings) == len(self.pictures) == 1 and not self.legends:
            (only,) = self.drawings.values()
            return Drawing(only.figure, words, only.photo)
        shapes = [each.shape for each in self.pictures.values()] or [(40, 100, 3)]
        ratios = [width / height for height, width, _ in shapes]
        keys = [key for each in self.legends for key in each.patches()]
        # Space for titles and the legend's rows, inches.
        around = 0.45 + (0.25 + 0.2 * -(-len(keys) // 2) if keys else 0.0)
        figure = Figure(figsize=(9.6, min(9.6 / sum(ratios), 6.0) + around))
        axes = figure.subplots(1, len(shapes), width_ratios=ratios, squeeze=False)[0]
        for ax, (title, pixels) in zip(axes, self.pictures.items(), strict=False):
            plot_picture(on_white(pixels), ax, ticks=False)
            if title in self.drawings and not self.drawings[title].photo:
                ax.images[0].set_gid(NO_PHOTO)
            ax.set_title(title.strip(), fontsize=11)
            if title in marks:
                ax.plot(*marks[title], "+", ms=14, mew=3.5, color="white")
                ax.plot(*marks[title], "+", ms=12, mew=1.5, color="#c84b00")
        if not self.pictures:
            axes[0].set_axis_off()
            axes[0].text(0.5, 0.5, words, ha="center", va="center", wrap=True)
        legend_below(figure, keys, columns=2)
        return Drawing(figure, words, photo=True)


def parts_of(given: Any) -> Iterator[Any]:
    """Yield the results of a function that returns one or yields several."""
    if isinstance(given, Iterator):
        yield from given
    elif given is None:
        raise TypeError(f"a panel shows {_PARTS}; the function returned None")
    else:
        yield given


def is_picture(shown: Any) -> bool:
    """Return whether a result is a picture or a figure; False for a table, and TypeError for anything else."""
    if isinstance(shown, Drawing | Picture | np.ndarray):
        return True
    if not hasattr(shown, "_repr_html_"):
        raise TypeError(f"a panel shows {_PARTS}; got {type(shown).__name__}")
    return False


def as_picture(shown: Any) -> Pixels:
    """Return a picture or a figure as RGB (H, W, 3) or RGBA (H, W, 4); refuse anything else with a ValueError.

    Arrays are RGB, RGBA or grey (H, W) of uint8, or bool (H, W).
    """
    if isinstance(shown, Drawing):
        return _rendered(shown)
    array = shown.pixels if isinstance(shown, Picture) else np.asarray(shown)
    if array.dtype == bool:
        array = np.where(array, 255, 0).astype(np.uint8)
    if array.dtype != np.uint8 or not array.size or not (array.ndim == 2 or array.shape[2:] in ((3,), (4,))):
        raise ValueError(
            "a picture must be uint8 of shape (H, W, 3), (H, W, 4) or (H, W), or bool of shape (H, W); "
            f"got {array.dtype} {array.shape}"
        )
    return array if array.ndim == 3 else np.repeat(array[..., None], 3, axis=2)


def on_white(pixels: Pixels) -> Pixels:
    """Return a picture (H, W, 3), or one with opacity (H, W, 4) as on white paper, in RGB."""
    if pixels.shape[2] == 3:
        return pixels
    opacity = pixels[..., 3:] / 255
    return np.round(pixels[..., :3] * opacity + 255 * (1 - opacity)).astype(np.uint8)


@course_style()
def _rendered(drawing: Drawing) -> Pixels:
    canvas: Any = FigureCanvasAgg(drawing.figure)
    canvas.draw()
    opaque = to_rgba(drawing.figure.get_facecolor())[3] > 0
    return np.array(canvas.buffer_rgba())[:, :, : 3 if opaque else 4]


def encoded(pixels: Pixels, is_figure: bool) -> tuple[str, bytes]:
    """Return a picture as ("png" or "jpeg", bytes): figures and painted pictures as PNG, photographs as JPEG."""
    sample = pixels[:: 1 + pixels.shape[0] // 48, :: 1 + pixels.shape[1] // 48].astype(np.int32)
    colours = np.unique(sample[..., :3] @ (65536, 256, 1))
    if is_figure or pixels.shape[2] == 4 or len(colours) <= FEW_COLOURS:
        return "png", png(pixels)
    return "jpeg", jpeg(pixels)
