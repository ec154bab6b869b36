"""Legends: one key for each source, kind of landmark and label, the same in every figure and panel."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from nao_course.plotting.style import LABEL_COLOURS, LANDMARK_MARKERS, style_of

if TYPE_CHECKING:
    from matplotlib.artist import Artist


def legend_below(figure: Figure, handles: Sequence[Artist], columns: int = 4) -> None:
    """Add a legend below all axes, unless `handles` is empty."""
    if handles:
        figure.legend(handles=list(handles), loc="outside lower center", ncols=min(columns, len(handles)))


def source_key(source: str, label: str | None = None) -> Line2D:
    """Return the legend key of a source of poses, with its own name or with `label`."""
    style = style_of(source)
    return Line2D(
        [],
        [],
        color=style.colour,
        ls=style.line,
        marker=style.marker,
        lw=1.9,
        ms=7,
        mec="white",
        label=label or style.label,
    )


def landmark_keys(kinds: Iterable[str], colour: str, whose: str) -> list[Line2D]:
    """Return one legend key for each kind of landmark in `kinds`."""
    present = [kind for kind in LANDMARK_MARKERS if kind in set(kinds)]
    return [
        Line2D(
            [],
            [],
            color=colour,
            marker=LANDMARK_MARKERS[kind],
            ls="",
            ms=8,
            mec="white",
            label=f"{whose} {kind}",
        )
        for kind in present
    ]


def label_keys(texts: Sequence[str]) -> list[Patch]:
    """Return legend keys of the four labels (other, green, yellow and white) with the given texts."""
    return [
        Patch(facecolor=colour, edgecolor="#333333", label=text)
        for text, colour in zip(texts, LABEL_COLOURS, strict=True)
    ]
