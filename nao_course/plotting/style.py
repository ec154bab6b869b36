"""Style of the course's figures: colour, marker and line of each source of poses, and matplotlib's settings."""

from __future__ import annotations

import colorsys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal

import numpy as np

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
LINE_RIM = "#44683c"  # around the lines of a field, which are dark where a dark page inverts a figure
# Of maps on a dark page, and of maps without a field
DARK_CARPET, DARK_LINE, PAPER, DARK_PAPER = "#24382b", "#bccabd", "#f1f3f1", "#1f2622"
LABEL_COLOURS = ("#4b4b55", "#3f9b55", "#f2c413", "#ffffff")  # other, green, yellow, white
INK = "#767676"  # of writing on transparent paper: the same contrast with a white page and with a black one
FOUND = "#ff3b81"  # rings around detected points; differs from the carpet, posts and lines
_CONTRAST = 5.0  # of a colour with the dark carpet
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
    from matplotlib.style import context  # takes long to import

    with context(["default", _OWN_STYLE]):
        yield


def luminance(colour: str) -> float:
    """Return the relative luminance, 0 to 1, of a colour "#rrggbb" as the WCAG defines it."""
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [each / 12.92 if each <= 0.04045 else ((each + 0.055) / 1.055) ** 2.4 for each in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(first: str, second: str) -> float:
    """Return the contrast of two colours "#rrggbb", 1 to 21, as the WCAG defines it."""
    low, high = sorted((luminance(first), luminance(second)))
    return (high + 0.05) / (low + 0.05)


def on_dark(colour: str) -> str:
    """Return a colour "#rrggbb" for dark pages: black becomes white, and other colours as light as legibility needs."""
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    hue, lightness, saturation = colorsys.rgb_to_hls(red, green, blue)
    if max(red, green, blue) < 0.2:
        return "#f4f4f4"
    for light in np.arange(lightness, 1.0, 0.02):
        parts = colorsys.hls_to_rgb(hue, float(light), saturation)
        lighter = "#" + "".join(f"{round(255 * each):02x}" for each in parts)
        if contrast(lighter, DARK_CARPET) >= _CONTRAST:
            return lighter
    return "#ffffff"


def style_of(source: str) -> Style:
    """Return the style of "truth", "odometry", "ekf" or "graph"; raise ValueError for another name."""
    for name, style in STYLES.items():
        if name == source:
            return style
    raise ValueError(f"source must be one of {', '.join(map(repr, STYLES))}, got {source!r}")
