"""What a panel's function shows: pictures, figures, tables and words, for a browser and for a still figure."""

from __future__ import annotations

import html
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from nao_course.plotting import Drawing, course_style, plot_picture
from nao_course.plotting.legends import legend_below
from nao_course.sim import Picture
from nao_course.widgets.parts import jpeg, png

Pixels = npt.NDArray[np.uint8]

FEW_COLOURS = 32  # up to here a picture is painted and sent as PNG, which keeps each colour
_PARTS = "a picture, a Drawing, a table, a text, a Legend, or {title: picture, Drawing or table}"


@dataclass(frozen=True)
class Legend:
    """What the colours in a picture mean.

    Parameters
    ----------
    colours : mapping of str to str
        By meaning; such as "#ff0000".
    """

    colours: Mapping[str, str]

    def _repr_html_(self) -> str:
        """Patches with words."""
        return "".join(
            f"<span>{colour_key(colour)}{html.escape(text)}</span>" for text, colour in self.colours.items()
        )

    def patches(self) -> list[Patch]:
        """The same for a figure."""
        return [
            Patch(facecolor=colour, edgecolor="#333333", label=text) for text, colour in self.colours.items()
        ]


def colour_key(colour: str) -> str:
    """HTML of a small patch in a colour."""
    return f'<i class="nao-key" style="background:{colour}"></i>'


@dataclass(frozen=True)
class Shown:
    """All that one call of a panel's function gave.

    Parameters
    ----------
    pictures : mapping of str to Pixels
        RGB (H, W, 3) by title, in order; figures too.
    drawings : mapping of str to Drawing
        Those of them that are figures.
    tables : mapping of str to objects
        By title, in order; with ``_repr_html_`` for a page, and `repr` for a text.
    legends : tuple of Legend
        What colours mean.
    texts : tuple of str
        Sentences.
    """

    pictures: Mapping[str, Pixels]
    drawings: Mapping[str, Drawing]
    tables: Mapping[str, Any] = field(default_factory=dict)
    legends: tuple[Legend, ...] = ()
    texts: tuple[str, ...] = ()

    @classmethod
    def of(cls, parts: Iterable[Any]) -> Shown:
        """Sort what a function gave; a title that comes again takes the place of the first.

        Raises
        ------
        TypeError, ValueError
            For what cannot be shown.
        """
        pictures: dict[str, Any] = {}
        tables: dict[str, Any] = {}
        legends, texts = [], []
        for part in parts:
            if isinstance(part, str):
                texts.append(part)
            elif isinstance(part, Legend):
                legends.append(part)
            else:
                no_title = " " * (len(pictures) + len(tables))  # but a place of its own
                for title, each in part.items() if isinstance(part, Mapping) else [(no_title, part)]:
                    (pictures if is_picture(each) else tables)[str(title)] = each
        drawings = {title: each for title, each in pictures.items() if isinstance(each, Drawing)}
        seen = {title: as_picture(each) for title, each in pictures.items()}
        return cls(seen, drawings, tables, tuple(legends), tuple(texts))

    def tables_html(self) -> str:
        """The tables under their titles."""
        titles = (f"<b>{html.escape(title)}</b>" if title.strip() else "" for title in self.tables)
        return "".join(
            f"<div>{title}{table._repr_html_()}</div>"
            for title, table in zip(titles, self.tables.values(), strict=True)
        )

    def drawing(self, words: str, marks: Mapping[str, tuple[int, int]]) -> Drawing:
        """Return it as one figure.

        Parameters
        ----------
        words : str
            All of it for readers who cannot see it; what stands in the figure where there is no picture.
        marks : mapping of str to (int, int)
            Pixels (u, v) to mark, by the picture's title.

        Returns
        -------
        Drawing
            Pictures side by side; a single figure as it is.
        """
        if len(self.drawings) == len(self.pictures) == 1 and not self.legends:
            (only,) = self.drawings.values()
            return Drawing(only.figure, words, only.photo)
        shapes = [each.shape for each in self.pictures.values()] or [(40, 100, 3)]
        ratios = [width / height for height, width, _ in shapes]
        with course_style():
            figure = Figure(figsize=(9.6, min(9.6 / sum(ratios), 6.0) + (0.95 if self.legends else 0.4)))
            axes = figure.subplots(1, len(shapes), width_ratios=ratios, squeeze=False)[0]
            for ax, (title, pixels) in zip(axes, self.pictures.items(), strict=False):
                plot_picture(pixels, ax, ticks=False)
                ax.set_title(title.strip(), fontsize=11)
                if title in marks:
                    ax.plot(*marks[title], "+", ms=14, mew=3.5, color="white")
                    ax.plot(*marks[title], "+", ms=12, mew=1.5, color="#c84b00")
            if not self.pictures:
                axes[0].set_axis_off()
                axes[0].text(0.5, 0.5, words, ha="center", va="center", wrap=True)
            legend_below(figure, [key for each in self.legends for key in each.patches()], columns=2)
        return Drawing(figure, words, photo=True)


def parts_of(given: Any) -> Iterator[Any]:
    """What a function returned or yields, one after the other."""
    if isinstance(given, Iterator):
        yield from given
    elif given is None:
        raise TypeError(f"a panel shows {_PARTS}; the function returned nothing")
    else:
        yield given


def is_picture(shown: Any) -> bool:
    """Whether it is a picture or a figure, not a table; a TypeError for what is none of these."""
    if isinstance(shown, Drawing | Picture | np.ndarray):
        return True
    if not hasattr(shown, "_repr_html_"):
        raise TypeError(f"a panel shows {_PARTS}; got {type(shown).__name__}")
    return False


def as_picture(shown: Any) -> Pixels:
    """Return what is to be shown as an RGB picture (H, W, 3).

    Parameters
    ----------
    shown : Drawing, Picture or array
        Arrays: RGB (H, W, 3) or grey (H, W) of uint8, or bool (H, W).

    Raises
    ------
    TypeError, ValueError
        For anything else.
    """
    if isinstance(shown, Drawing):
        return _rendered(shown)
    array = shown.pixels if isinstance(shown, Picture) else np.asarray(shown)
    if array.dtype == bool:
        array = np.where(array, 255, 0).astype(np.uint8)
    if array.dtype != np.uint8 or not array.size or not (array.ndim == 2 or array.shape[2:] == (3,)):
        raise ValueError(
            "a picture must be uint8 of shape (H, W, 3) or (H, W), or bool of shape (H, W); "
            f"got {array.dtype} {array.shape}"
        )
    return array if array.ndim == 3 else np.repeat(array[..., None], 3, axis=2)


def _rendered(drawing: Drawing) -> Pixels:
    canvas: Any = FigureCanvasAgg(drawing.figure)
    with course_style():
        canvas.draw()
    return np.array(canvas.buffer_rgba())[:, :, :3]


def encoded(pixels: Pixels, is_figure: bool) -> tuple[str, bytes]:
    """Return a picture as ("png" or "jpeg", bytes): figures and painted pictures as PNG, photographs as JPEG."""
    sample = pixels[:: 1 + pixels.shape[0] // 48, :: 1 + pixels.shape[1] // 48].astype(np.int32)
    colours = np.unique(sample @ (65536, 256, 1))
    if is_figure or len(colours) <= FEW_COLOURS:
        return "png", png(pixels)
    return "jpeg", jpeg(pixels)
