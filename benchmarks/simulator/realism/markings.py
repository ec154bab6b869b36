"""Instruments that look at lines and posts: edges, widths, colours, also by distance."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.pictures import paper_detector as paper
from benchmarks.simulator.realism.geometry import Geometry, Lines, Mask
from benchmarks.simulator.realism.profiles import (
    Picture,
    Profiles,
    crossing,
    half_way,
    line_profiles,
    robust_sd,
    thinned,
)
from nao_course.geometry import FloatArray

BINS = ((1, 1.5), (1.5, 2), (2, 3), (3, 4), (4, 5), (5, 6.5))  # metres


def line_edges(picture: Picture, geometry: Geometry) -> dict[str, Any]:
    """Measure the rise from 10 to 90 % across the edges of near lines (from 7 px at 320), and the overshoot."""
    scale = geometry.scale
    lines = geometry.lines
    lines = lines.chosen(lines.clear & (lines.half_width > 3.5 * scale) & (lines.distance < 3))
    samples: dict[str, Any] = {}
    if len(lines.pixel) < 10:
        return samples
    lines = lines.chosen(thinned(len(lines.pixel), 600))
    profiles = line_profiles(picture, lines, scale, search=2.5)
    chosen = profiles.good
    width = geometry.field.dimensions.line_width
    if chosen.sum() >= 10:
        samples["line width cm"] = 100 * width * profiles.width[chosen] / (2 * lines.half_width[chosen])
    steep = np.abs(lines.normal[:, 0]) > np.abs(lines.normal[:, 1])
    for name, keep in (
        ("rise px", chosen),
        ("rise px, across columns", chosen & steep),
        ("rise px, across rows", chosen & ~steep),
    ):
        edge = _mean_edge(picture, lines.chosen(keep), scale, chroma=False)
        if edge is None:
            continue
        samples[name] = edge.rise
        if name == "rise px":
            samples["overshoot on the line"], samples["undershoot on the carpet"] = (
                edge.overshoot,
                edge.undershoot,
            )
            chroma = _mean_edge(picture, lines.chosen(keep), scale, chroma=True)
            if chroma is not None:
                samples["chroma rise px"] = chroma.rise
    return samples


def fringes(picture: Picture, geometry: Geometry) -> dict[str, Any]:
    """Measure how far red and blue edges are outwards of green ones, px, scaled to the middle of the side."""
    scale, lines = geometry.scale, geometry.lines
    lines = lines.chosen(lines.clear & (lines.half_width > 1.2 * scale) & (lines.distance < 3))
    lines = lines.chosen(thinned(len(lines.pixel), 150))
    if len(lines.pixel) < 5:
        return {}
    good = line_profiles(picture, lines, scale, search=2.5)
    lines = replace(lines, pixel=lines.pixel + np.nan_to_num(good.centre)[:, None] * lines.normal).chosen(
        good.good
    )
    offsets = np.arange(-2.5 * scale, 2.5 * scale, 0.05 * scale)
    found: dict[str, list[FloatArray]] = {"red": [], "blue": []}
    side_px = geometry.view.size[0] / 2
    for side in (-1, 1):
        edge = lines.pixel + side * lines.half_width[:, None] * lines.normal
        places = edge[:, None] + side * offsets[:, None] * lines.normal[:, None]
        crossings = [half_way(offsets, np.clip(picture.read_channel(places, i), 0, 255)) for i in range(3)]
        away = edge - geometry.view.centre
        radius = np.hypot(*away.T)
        outwards = (away / np.maximum(radius, 1)[:, None] * side * lines.normal).sum(axis=1)
        use = (np.abs(outwards) > 0.7) & (radius > 0.25 * side_px)
        for name, i in (("red", 0), ("blue", 2)):
            shift = (crossings[i] - crossings[1])[use] / outwards[use] * side_px / radius[use]
            found[name].append(shift[np.isfinite(shift)])
    pooled = {f"{name} edge outwards, px": np.concatenate(parts) for name, parts in found.items()}
    return {name: values for name, values in pooled.items() if len(values) >= 5}


@dataclass(frozen=True)
class Edge:
    """A mean edge: rise in px, and how far it goes beyond its two levels (fractions of the contrast)."""

    rise: float
    overshoot: float
    undershoot: float


def _mean_edge(picture: Picture, lines: Lines, scale: float, chroma: bool) -> Edge | None:
    """Align all edges of the lines at half their height, and measure the mean edge."""
    if len(lines.pixel) < 10:
        return None
    step = 0.05 * scale
    offsets = np.arange(-4 * scale, 4 * scale + step / 2, step)
    shifted: list[FloatArray] = []
    for side in (-1, 1):
        # From the line's middle outwards: each edge is at half_width.
        middle = lines.pixel + side * lines.half_width[:, None] * lines.normal
        wide = np.arange(-6 * scale, 8 * scale, step)
        values = picture.read(middle[:, None] + side * wide[:, None] * lines.normal[:, None], chroma)
        inner = np.median(values[:, (wide > -3.4 * scale) & (wide < -2 * scale)], axis=1)
        outer = np.median(values[:, (wide > 2.5 * scale) & (wide < 5.5 * scale)], axis=1)
        level = (values - outer[:, None]) / np.where(np.abs(inner - outer) > 20, inner - outer, np.nan)[
            :, None
        ]
        start = np.full(len(level), int(np.argmin(np.abs(wide + 2.5 * scale))))
        half = crossing(wide, level, start, np.full(len(level), 0.5), 1)
        for row, at in zip(level, half, strict=True):
            if np.isfinite(at) and abs(at) < 2.5 * scale:
                shifted.append(np.interp(offsets, wide - at, row))
    if len(shifted) < 10:
        return None
    # Levels again, from the mean: single profiles are noisy, and a shift moves their windows.
    mean = np.median(shifted, axis=0)
    plateau = float(np.median(mean[(offsets < -2 * scale) & (offsets > -3.4 * scale)]))
    ground = float(np.median(mean[offsets > 2.2 * scale]))
    mean = (mean - ground) / (plateau - ground)
    start = np.array([int(np.argmin(np.abs(offsets + 2.5 * scale)))])
    ends = [float(crossing(offsets, mean[None], start, np.array([q]), 1)[0]) for q in (0.9, 0.1)]
    inside = mean[(offsets > -2 * scale) & (offsets < 0)]
    beyond = mean[(offsets < 2.2 * scale) & (offsets > 0)]
    return Edge(ends[1] - ends[0], float(inside.max() - 1), float(-beyond.min()))


def lines_by_distance(picture: Picture, geometry: Geometry) -> dict[str, Any]:
    """Measure width, peak and visibility of lines across the view in bins of distance."""
    threshold = paper.white_threshold(picture.hls[..., 1], 120.0)
    samples: dict[str, Any] = {}
    every = geometry.lines
    for low, high in BINS:
        keep = every.clear & every.across & (every.distance >= low) & (every.distance < high)
        lines = every.chosen(keep)
        if len(lines.pixel) < 5:
            continue
        lines = lines.chosen(thinned(len(lines.pixel), 200))
        profiles = line_profiles(picture, lines, geometry.scale, search=2.5)
        g = profiles.good
        if g.sum() < 5:
            continue
        name = f"{low:g}-{high:g} m"
        samples[f"width px, {name}"] = profiles.width[g]
        samples[f"true width px, {name}"] = 2 * lines.half_width[g]
        samples[f"peak, {name}"] = profiles.peak[g]
        samples[f"peak sd, {name}"] = robust_sd(profiles.peak[g])
        samples[f"contrast, {name}"] = (profiles.peak - profiles.base)[g]
        samples[f"above threshold %, {name}"] = (
            100.0 * _pixel_above(picture, lines, profiles, threshold)[profiles.on_carpet]
        )
    return samples


def _pixel_above(picture: Picture, lines: Lines, profiles: Profiles, threshold: float) -> FloatArray:
    """Return whether the pixel at the centre of each line is above the threshold (0 or 1)."""
    middle = lines.pixel + np.nan_to_num(profiles.centre)[:, None] * lines.normal
    height, width = picture.lightness.shape
    u = np.clip(np.rint(middle[:, 0]).astype(int), 0, width - 1)
    v = np.clip(np.rint(middle[:, 1]).astype(int), 0, height - 1)
    return np.asarray(picture.lightness[v, u] > threshold, dtype=float)


def line_and_post_colours(picture: Picture, geometry: Geometry) -> dict[str, Any]:
    """Measure the colour at the centre of near lines, and at the centres and sides of posts."""
    samples: dict[str, Any] = {}
    scale = geometry.scale
    lines = geometry.lines
    lines = lines.chosen(lines.clear & (lines.half_width > 2 * scale) & (lines.distance < 2.5))
    if len(lines.pixel) >= 10:
        profiles = line_profiles(picture, lines, scale, search=2.5)
        middle = (lines.pixel + profiles.centre[:, None] * lines.normal)[profiles.good]
        if len(middle) >= 10:
            u, v = np.rint(middle).astype(int).T
            for name, values in zip(("red", "green", "blue"), picture.pixels[v, u].T, strict=True):
                samples[f"line {name}"] = np.median(values)
            samples["line lightness"] = np.median(picture.lightness[v, u])
            samples["line lightness sd"] = robust_sd(picture.lightness[v, u])
    core = geometry.post_core
    hue, saturation = picture.hls[..., 0], picture.hls[..., 2]
    yellow = core & (hue > 18) & (hue < 40) & (saturation > 80)
    if yellow.sum() > 60 * scale**2 and yellow.sum() > 0.5 * core.sum():
        for name, values in zip(("red", "green", "blue"), picture.pixels[yellow].T, strict=True):
            samples[f"post {name}"] = np.median(values)
        for i, name in enumerate(("hue", "lightness", "saturation")):
            samples[f"post {name}"] = np.median(picture.hls[..., i][yellow])
        samples.update(_post_sides(picture, geometry, yellow))
    return samples


def _post_sides(picture: Picture, geometry: Geometry, yellow: Mask) -> dict[str, list[float]]:
    """Return the lightness at 40 % of the radius on each side of a post's axis relative to the axis, for wide posts."""
    ratios: dict[str, list[float]] = {"left": [], "right": []}
    widths: list[float] = []
    d = geometry.field.dimensions
    for x, y in geometry.field.posts:
        towards = np.array([x, y]) - geometry.eye
        aside = np.array([-towards[1], towards[0]]) / max(np.hypot(*towards), 1e-9) * d.post_diameter / 2
        axis = np.array([[x, y, z] for z in np.linspace(0.08, d.post_height - 0.1, 60)])
        sides = {
            n: geometry.view.project(axis + [*(f * aside), 0.0], geometry.pose)
            for n, f in (("left", 0.45), ("centre", 0.0), ("right", -0.45))
        }
        inside = np.all([geometry.view.contains(np.nan_to_num(p, nan=-9)) for p in sides.values()], axis=0)
        if inside.sum() < 10 or np.nanmedian(sides["right"][:, 0] - sides["left"][:, 0]) < 5 * geometry.scale:
            continue
        light = {}
        widths.append(
            100 * d.post_diameter * 1.5 * _yellow_part(picture, geometry, axis[inside], 1.5 * aside)
        )
        for name, pixels in sides.items():
            u, v = np.rint(pixels[inside]).astype(int).T
            light[name] = picture.lightness[v, u][yellow[v, u]]
        if min(len(values) for values in light.values()) >= 10:
            for name, found in ratios.items():
                found.append(float(np.median(light[name]) / np.median(light["centre"])))
    named = {f"post {name} / centre": found for name, found in ratios.items() if found}
    return {**named, "post width cm": widths} if widths else named


def _yellow_part(picture: Picture, geometry: Geometry, axis: FloatArray, half: FloatArray) -> float:
    """Return the yellow share of a strip `half` (2,) m to each side of a post's axis (N, 3): the median of its rows."""
    steps = np.linspace(-1, 1, 121)
    strip = axis[:, None] + steps[:, None] * np.array([*half, 0.0])
    u, v = np.rint(geometry.view.project(strip.reshape(-1, 3), geometry.pose)).T
    u, v = (
        np.clip(np.nan_to_num(x), 0, n - 1).astype(int)
        for x, n in zip((u, v), geometry.view.size, strict=True)
    )
    hue, _, saturation = picture.hls[v, u].T
    yellow = (hue > 18) & (hue < 40) & (saturation > 80)
    return float(np.median(yellow.reshape(len(axis), -1).mean(axis=1)))
