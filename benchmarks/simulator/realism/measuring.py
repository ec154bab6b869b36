"""Everything that is measured in one picture, by all instruments."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from benchmarks.pictures import paper_detector as paper
from benchmarks.simulator.realism.carpet import carpet_colour, carpet_light, carpet_noise
from benchmarks.simulator.realism.geometry import Geometry, Mask, Pixels
from benchmarks.simulator.realism.markings import (
    fringes,
    line_and_post_colours,
    line_edges,
    lines_by_distance,
)
from benchmarks.simulator.realism.profiles import Picture
from nao_course.geometry import FloatArray

# --- what is measured, in the tables' order ---

GROUPS: dict[str, tuple[str, ...]] = {
    "carpet's colour": (
        *(f"hue {q} %" for q in (1, 5, 50, 95, 99)),
        *(f"lightness {q} %" for q in (5, 25, 50, 75, 95)),
        *("saturation mean", "red", "green", "blue", "picture's mean lightness", "foreign on carpet %"),
    ),
    "carpet's light": (
        *("left / centre", "right / centre", "sides / centre", "far / near lightness"),
        *("bottom corners / bottom", "patch contrast 8 px", "patch contrast 24 px"),
    ),
    "noise and texture on carpet": (
        *(f"noise sd, {where}, {block}x{block}" for where in ("near", "far") for block in (1, 2, 4, 8)),
        *("grain sd", "grain sd, near", "grain sd, far"),
        *(f"noise sd {channel}" for channel in ("red", "green", "blue", "luma", "Cb", "Cr")),
        *("correlation next column", "correlation next row", "correlation 2 columns", "correlation 2 rows"),
        *("correlation red-green", "correlation green-blue", "correlation red-blue"),
        *("bright specks per 10000 px", "dark specks per 10000 px"),
    ),
    "line edges": (
        *("rise px", "rise px, across columns", "rise px, across rows", "chroma rise px"),
        *("overshoot on the line", "undershoot on the carpet", "line width cm"),
        *("red edge outwards, px", "blue edge outwards, px"),
    ),
    "lines by distance": tuple(
        f"{what}, {low:g}-{high:g} m"
        for what in ("width px", "true width px", "peak", "peak sd", "contrast", "above threshold %")
        for low, high in ((1, 1.5), (1.5, 2), (2, 3), (3, 4), (4, 5), (5, 6.5))
    ),
    "lines and posts": (
        *(f"line {c}" for c in ("red", "green", "blue", "lightness", "lightness sd")),
        *(f"post {c}" for c in ("red", "green", "blue", "hue", "lightness", "saturation")),
        *("post left / centre", "post right / centre", "post width cm"),
    ),
    "behind the field": (
        *(f"background lightness {q} %" for q in (5, 25, 50, 75, 95)),
        *("background saturation", "background white %", "background green %", "background yellow %"),
        *("background edges %", "border green %", "threshold of eq. 4.1"),
        *("white left off lines, px", "false segments"),
    ),
}
STATISTICS = tuple(name for names in GROUPS.values() for name in names)


Samples = dict[str, FloatArray]


def measure(pixels: Pixels, geometry: Geometry) -> Samples:
    """Measure all statistics of one picture.

    Parameters
    ----------
    pixels : ndarray of uint8, shape (H, W, 3)
        RGB, real or simulated.
    geometry : Geometry
        What it shows.

    Returns
    -------
    dict of str to ndarray
        Samples by the statistics' names; those that the picture says nothing about are missing.
    """
    picture = Picture(pixels)
    carpet = geometry.carpet & ~foreign(picture, geometry)
    samples: Samples = {}
    for part in (
        carpet_colour(picture, geometry, carpet),
        carpet_light(picture, geometry, carpet),
        carpet_noise(picture, geometry, carpet),
        line_edges(picture, geometry),
        fringes(picture, geometry),
        lines_by_distance(picture, geometry),
        line_and_post_colours(picture, geometry),
        behind_the_field(picture, geometry),
    ):
        samples.update(part)
    return {name: np.atleast_1d(np.asarray(value, dtype=float)) for name, value in samples.items()}


def foreign(picture: Picture, geometry: Geometry) -> Mask:
    """Return objects on the carpet: pixels that are not greenish after a median over 5 px (at 320), and 3 px around."""
    size = round(5 * geometry.scale) // 2 * 2 + 1
    odd = np.asarray(cv2.medianBlur((~picture.greenish).astype(np.uint8), min(size, 31)))
    rim = round(3 * geometry.scale) * 2 + 1
    return np.asarray(cv2.dilate(odd, np.ones((rim, rim), np.uint8)) > 0)


def behind_the_field(picture: Picture, geometry: Geometry) -> dict[str, Any]:
    """Measure what may confuse a detector: colours above the carpet, and white areas that are not lines."""
    samples: dict[str, Any] = {}
    threshold = paper.white_threshold(picture.hls[..., 1], 120.0)
    labels = paper.color_labels(picture.hls, threshold, paper.Hues())
    samples["threshold of eq. 4.1"] = threshold
    background = geometry.background
    if background.sum() > 500 * geometry.scale**2:
        light = picture.lightness[background]
        samples.update({f"background lightness {q} %": np.percentile(light, q) for q in (5, 25, 50, 75, 95)})
        samples["background saturation"] = picture.hls[..., 2][background].mean()
        for name, label in (("white", paper.WHITE), ("green", paper.GREEN), ("yellow", paper.YELLOW)):
            samples[f"background {name} %"] = 100 * (labels[background] == label).mean()
        grey = cv2.cvtColor(picture.pixels, cv2.COLOR_RGB2GRAY)
        samples["background edges %"] = 100 * (cv2.Canny(grey, 80, 160)[background] > 0).mean()
    if geometry.border.sum() > 100 * geometry.scale**2:
        samples["border green %"] = 100 * (labels[geometry.border] == paper.GREEN).mean()
    kept = paper.erase_background(labels) == paper.WHITE
    known = geometry.near_lines | geometry.near_posts
    samples["white left off lines, px"] = (kept & ~known).sum() / geometry.scale**2
    segments = paper.hough_segments(paper.edges(labels), paper.BEST[1], paper.BEST[2])
    places = (
        segments[:, :2][:, None]
        + np.linspace(0, 1, 9)[:, None] * (segments[:, 2:] - segments[:, :2])[:, None]
    )
    u, v = np.rint(places).astype(int).transpose(2, 0, 1)
    samples["false segments"] = (known[v, u].mean(axis=1) < 0.5).sum()
    return samples
