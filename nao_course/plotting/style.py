"""Style of the course's figures: colour, marker and line of each source of poses, and matplotlib's settings."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal

import matplotlib.style
from matplotlib.patheffects import withStroke

from nao_course.sim.field import MarkKind

Source = Literal["truth", "odometry", "ekf", "graph"]  # of poses


@dataclass(frozen=True)
class Style:
    """Style of a source of poses, the same in every figure of the course.

    Parameters
    ----------
    label : str
        Its name in legends.
    colour : str
        Colour that differs from the others also in lightness, and for readers with a colour vision deficiency.
    marker, line : str or tuple
        Matplotlib's marker and line style; each source has its own, so that figures can be printed in black and white.
    """

    label: str
    colour: str
    marker: str
    line: Any


# After Okabe and Ito (2008) and Tol (2021); tests/plotting/test_plotting.py measures them for three kinds of vision.
STYLES: Mapping[Source, Style] = MappingProxyType(
    {
        "truth": Style("truth", "#1a1a1a", "o", "-"),
        "odometry": Style("odometry", "#c84b00", "s", (0, (5, 2))),
        "ekf": Style("EKF", "#0b5fa5", "^", (0, (7, 1.5, 1, 1.5))),
        "graph": Style("graph", "#a14566", "D", (0, (1.2, 1.2))),
    }
)
LANDMARK_MARKERS: Mapping[MarkKind, str] = MappingProxyType({"corner": "P", "post": "o", "cross": "x"})

CARPET, LINE, YELLOW, GREY = "#b5d1ac", "#ffffff", "#f0c419", "#6b7280"
LABEL_COLOURS = ("#4b4b55", "#3f9b55", "#f2c413", "#ffffff")  # other, green, yellow, white
FOUND = "#ff3b81"  # rings around detected points; differs from the carpet, posts and lines
HALO = [withStroke(linewidth=2.5, foreground="white", alpha=0.8)]
_OWN_STYLE = {
    "font.family": "DejaVu Sans",  # included in matplotlib, so that text looks the same on every machine
    "font.size": 10.5,
    "axes.titlesize": 12,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": False,
    "legend.fontsize": 10,
    "figure.constrained_layout.use": True,
    "svg.hashsalt": "nao_course",
}


@contextmanager
def course_style() -> Iterator[None]:
    """Use the course's settings for matplotlib within a ``with`` block."""
    with matplotlib.style.context(["default", _OWN_STYLE]):
        yield


def style_of(source: str) -> Style:
    """Return the style of "truth", "odometry", "ekf" or "graph"; raise ValueError for another name."""
    for name, style in STYLES.items():
        if name == source:
            return style
    raise ValueError(f"source must be one of {', '.join(map(repr, STYLES))}, got {source!r}")
