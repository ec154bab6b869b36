"""Do the simulator's pictures look like the real ones? The same instruments measure both.

Every instrument takes a picture and its geometry, so that it knows where lines, posts and carpet are. The real
pictures' geometry is fitted (benchmarks/simulator/reality) and then moved, a little, onto the white lines themselves;
the simulator renders the whole field from the same view and pose (`simulated_twin`), and one table compares the two.
``compare(step=7)`` looks at every seventh picture, which takes some seconds.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import product
from typing import Any

import cv2
import numpy as np
from scipy.stats import spearmanr

from benchmarks import Result, Table
from benchmarks.pictures import paper_detector as paper
from benchmarks.simulator.real_scenes import (
    Geometry,
    Lines,
    Mask,
    Picture,
    Pixels,
    crossing,
    line_profiles,
    real_scenes,
    simulated_twin,
    thinned,
)
from nao_course.geometry import FloatArray
from nao_course.lessons.experiments.paper_table import BETAS, GAPS, LENGTHS
from nao_course.metrics import corner_cost, match_points
from nao_course.sim.reality import Reality

BINS = ((1, 1.5), (1.5, 2), (2, 3), (3, 4), (4, 5), (5, 6.5))  # m
# Immerkaer 1996: sees noise, not slopes or edges
LAPLACIAN = np.array([[1.0, -2, 1], [-2, 4, -2], [1, -2, 1]])
MOST_SAMPLES = 60  # of one picture, so that no picture outweighs the rest
LARGE = (1280, 960)
REACH = 7.5  # m: farther corners of a twin are not asked for, because hardly a real one is marked there
SETS_OF_ROOMS = 6  # a set of twins spreads over four rooms; single false corners decide the ranks of one set
# What is told by the mean over pictures, because it is mostly absent; of all else the median.
BY_MEAN = ("specks", "above threshold", "background white", "background edges", "left off lines")
Samples = dict[str, FloatArray]


def robust_sd(values: FloatArray) -> float:
    """Return the standard deviation estimated from the median absolute deviation."""
    return float(1.4826 * np.median(np.abs(values - np.median(values)))) if values.size else float("nan")


def measure(pixels: Pixels, geometry: Geometry) -> Samples:
    """Measure one picture; statistics that it says nothing about are missing."""
    picture, samples = Picture(pixels), dict[str, Any]()
    # objects on the carpet are left out, and 3 px (at 320) around
    size = round(5 * geometry.scale) // 2 * 2 + 1
    odd = np.asarray(cv2.medianBlur((~picture.greenish).astype(np.uint8), min(size, 31)))
    rim = round(3 * geometry.scale) * 2 + 1
    carpet = geometry.carpet & (cv2.dilate(odd, np.ones((rim, rim), np.uint8)) == 0)
    for instrument in (carpet_light, carpet_noise):
        samples |= instrument(picture, geometry, carpet)
    for tell in (line_edges, lines_by_distance, behind_the_field):
        samples |= tell(picture, geometry)
    return {name: np.atleast_1d(np.asarray(value, dtype=float)) for name, value in samples.items()}


def carpet_light(picture: Picture, geometry: Geometry, carpet: Mask) -> dict[str, Any]:
    """Measure hue (0..180) and lightness (0..255) of the carpet, and how its lightness changes over the picture."""
    light, samples = picture.lightness, dict[str, Any]()
    if carpet.sum() >= 500 * geometry.scale**2:
        samples |= {f"hue {q} %": np.percentile(picture.hls[carpet][:, 0], q) for q in (1, 50, 99)}
        samples |= {f"lightness {q} %": np.percentile(light[carpet], q) for q in (5, 50, 95)}
    samples["picture's mean lightness"] = light.mean()
    height, width = carpet.shape
    sixth, band = width // 6, round(8 * geometry.scale)
    parts = (
        slice(0, sixth),
        slice(width // 2 - sixth // 2, width // 2 + sixth // 2),
        slice(width - sixth, width),
    )
    rows = [slice(v, v + band) for v in range(0, height - band + 1, band)]
    left, centre, right = (
        np.array([_median_if_carpet(light[row, part], carpet[row, part]) for row in rows]) for part in parts
    )
    both = (left + right) / 2 / centre
    if np.isfinite(both).sum() >= 3:
        samples["sides / centre"] = np.nanmedian(both)
    near, far = (
        carpet & (geometry.distance > a) & (geometry.distance < b) for a, b in ((0.6, 1.2), (2.5, 4.0))
    )
    if min(near.sum(), far.sum()) > 300 * geometry.scale**2:
        samples["far / near lightness"] = np.median(light[far]) / np.median(light[near])
    return samples


def _median_if_carpet(light: FloatArray, carpet: Mask) -> float:
    return float(np.median(light[carpet])) if carpet.mean() > 0.5 else float("nan")


def carpet_noise(picture: Picture, geometry: Geometry, carpet: Mask) -> dict[str, Any]:
    """Measure the sensor's noise, the carpet's grain, and bright spots of more than five standard deviations."""
    if carpet.sum() < 2000 * geometry.scale**2:
        return {}
    samples: dict[str, Any] = {}
    for where, low, high in (("near", 0.5, 1.3), ("far", 2.0, 4.0)):
        part = carpet & (geometry.distance > low) & (geometry.distance < high)
        samples[f"noise sd, {where}, 1x1"] = noise_sd(picture.lightness, part)
    samples["grain sd"] = robust_sd(_rest(picture.lightness, carpet, round(15 * geometry.scale))[carpet])
    rest = _rest(picture.lightness, carpet, round(11 * geometry.scale))
    bright = (rest > 5 * robust_sd(rest[carpet])) & carpet
    number, _ = cv2.connectedComponents(bright.astype(np.uint8), connectivity=8)
    samples["bright specks per 10000 px"] = (number - 1) / carpet.sum() * 1e4 * geometry.scale**2
    return samples


def _rest(values: FloatArray, mask: Mask, size: int) -> FloatArray:
    """Return what values differ by from the mean of the masked ones in a square window around each pixel."""
    weight = cv2.blur(mask.astype(float), (size, size))
    return np.asarray(values - cv2.blur(np.where(mask, values, 0.0), (size, size)) / np.maximum(weight, 1e-9))


def noise_sd(channel: FloatArray, mask: Mask) -> float:
    """Return the standard deviation of white noise with the same response to a Laplacian."""
    whole = cv2.erode(mask.astype(np.uint8), np.ones((3, 3), np.uint8), borderValue=0) > 0
    if whole.sum() < 60:
        return float("nan")
    answer = cv2.filter2D(np.asarray(channel, dtype=float), -1, LAPLACIAN)[whole]
    # Whole numbers make the median jump by whole steps: spread each over its step.
    return robust_sd(answer + np.random.default_rng(0).uniform(-0.5, 0.5, answer.shape)) / 6.0


def line_edges(picture: Picture, geometry: Geometry) -> dict[str, Any]:
    """Measure the rise from 10 to 90 % across the edges of near lines (from 7 px at 320), px."""
    scale, lines = geometry.scale, geometry.lines
    lines = lines.chosen(lines.clear & (lines.half_width > 3.5 * scale) & (lines.distance < 3))
    if len(lines.pixel) < 10:
        return {}
    lines = lines.chosen(thinned(len(lines.pixel), 600))
    rise = _rise(picture, lines.chosen(line_profiles(picture, lines, scale, search=2.5).good), scale)
    return {} if rise is None else {"rise px": rise}


def _rise(picture: Picture, lines: Lines, scale: float) -> float | None:
    """Align all edges of the lines at half their height, and measure the mean edge."""
    if len(lines.pixel) < 10:
        return None
    step = 0.05 * scale
    offsets = np.arange(-4 * scale, 4 * scale + step / 2, step)
    wide = np.arange(-6 * scale, 8 * scale, step)
    shifted: list[FloatArray] = []
    for side in (-1, 1):  # from the line's middle outwards: each edge is at half_width
        middle = lines.pixel + side * lines.half_width[:, None] * lines.normal
        values = picture.read(middle[:, None] + side * wide[:, None] * lines.normal[:, None])
        inner = np.median(values[:, (wide > -3.4 * scale) & (wide < -2 * scale)], axis=1)
        outer = np.median(values[:, (wide > 2.5 * scale) & (wide < 5.5 * scale)], axis=1)
        contrast = np.where(np.abs(inner - outer) > 20, inner - outer, np.nan)
        level = (values - outer[:, None]) / contrast[:, None]
        start = np.full(len(level), int(np.argmin(np.abs(wide + 2.5 * scale))))
        for row, at in zip(level, crossing(wide, level, start, np.full(len(level), 0.5)), strict=True):
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
    high, low = (float(crossing(offsets, mean[None], start, np.array([q]))[0]) for q in (0.9, 0.1))
    return low - high


def lines_by_distance(picture: Picture, geometry: Geometry) -> dict[str, Any]:
    """Measure width, peak and visibility of lines across the view in bins of distance."""
    threshold = paper.white_threshold(picture.hls[..., 1])
    samples, every = dict[str, Any](), geometry.lines
    for low, high in BINS:
        lines = every.chosen(every.clear & every.across & (every.distance >= low) & (every.distance < high))
        if len(lines.pixel) < 5:
            continue
        lines = lines.chosen(thinned(len(lines.pixel), 200))
        profiles = line_profiles(picture, lines, geometry.scale, search=2.5)
        if profiles.good.sum() < 5:
            continue
        middle = lines.pixel + np.nan_to_num(profiles.centre)[:, None] * lines.normal
        above = picture.nearest(picture.lightness, middle) > threshold  # type: ignore[operator]
        name = f"{low:g}-{high:g} m"
        samples[f"width px, {name}"] = profiles.width[profiles.good]
        samples[f"peak, {name}"] = profiles.peak[profiles.good]
        samples[f"above threshold %, {name}"] = 100.0 * above[profiles.on_carpet]
    return samples


def behind_the_field(picture: Picture, geometry: Geometry) -> dict[str, Any]:
    """Measure what may confuse a detector: what is above the carpet, and white areas that are not lines."""
    samples, background = dict[str, Any](), geometry.background
    labels = paper.color_labels(picture.hls, paper.white_threshold(picture.hls[..., 1]))
    if background.sum() > 500 * geometry.scale**2:
        light = picture.lightness[background]
        samples |= {f"background lightness {q} %": np.percentile(light, q) for q in (25, 50, 95)}
        samples["background white %"] = 100 * (labels[background] == paper.WHITE).mean()
        grey = cv2.cvtColor(picture.pixels, cv2.COLOR_RGB2GRAY)
        samples["background edges %"] = 100 * (cv2.Canny(grey, 80, 160)[background] > 0).mean()
    kept = paper.erase_background(labels) == paper.WHITE
    known = geometry.near_lines | geometry.near_posts
    samples["white left off lines, px"] = (kept & ~known).sum() / geometry.scale**2
    return samples


# --- real and simulated ---


def summarise(measured: Iterable[Samples]) -> dict[str, float]:
    """Pool the samples of the pictures: mean of what is mostly absent, median of all else."""
    found: dict[str, list[FloatArray]] = {}
    for samples in measured:
        for name, values in samples.items():
            values = values[np.isfinite(values)]
            if values.size:
                found.setdefault(name, []).append(values[thinned(len(values), MOST_SAMPLES)])
    by_mean = {name: any(each in name for each in BY_MEAN) for name in found}
    return {
        name: float((np.mean if by_mean[name] else np.median)(np.concatenate(parts)))
        for name, parts in found.items()
    }


def compare(look: Reality | None = None, step: int = 1, large: bool = False) -> dict[str, dict[str, float]]:
    """Measure real pictures, every so many or the 8 large ones, and their twins; return both by statistic."""
    scenes = [s for s in real_scenes() if s.picture.has_large] if large else real_scenes()[::step]
    size = LARGE if large else None
    geometry = [scene.geometry(size) for scene in scenes]
    pictures = [scene.picture.read(large=large) for scene in scenes]
    twins = [simulated_twin(scene, look or Reality(), i, size)[0] for i, scene in enumerate(scenes)]
    real, simulated = (
        summarise(measure(p, g) for p, g in zip(side, geometry, strict=True)) for side in (pictures, twins)
    )
    return {name: {"real": real[name], "simulated": simulated.get(name, float("nan"))} for name in real}


# --- the paper's detector with its 27 settings ---


def costs_of_settings(scenes: Sequence[tuple[Pixels, FloatArray]]) -> FloatArray:
    """Return the costs (27, scenes) of the settings of Table A.1 on pictures with their corners (K, 2)."""
    columns = []
    for pixels, corners in scenes:
        hls = np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGB2HLS))
        edges = [
            paper.edges(paper.color_labels(hls, paper.white_threshold(hls[..., 1], beta))) for beta in BETAS
        ]
        columns.append(
            [
                corner_cost(match_points(paper.corners_of_edges(edge, gap, length), corners))
                for edge, gap, length in product(edges, GAPS, LENGTHS)
            ]
        )
    return np.array(columns).T


def rank_correlation(first: FloatArray, second: FloatArray) -> float:
    """Return Spearman's rank correlation."""
    return float(spearmanr(first, second).statistic)


def over_rooms() -> dict[str, Any]:
    """Return rank correlations of the mean costs of real pictures with those of twins, by set and over all rooms.

    Two random halves of the real pictures agree no better than `halves` (median), so nothing simulated can be asked to.
    """
    scenes = real_scenes()
    real = costs_of_settings([(scene.picture.pixels, scene.corners) for scene in scenes])
    sets = []
    for number in range(SETS_OF_ROOMS):
        twins = [simulated_twin(scene, Reality(seed=4 * number), i) for i, scene in enumerate(scenes)]
        with_truth = [
            (
                pixels,
                np.reshape(
                    [
                        mark.pixel
                        for mark in truth.landmarks
                        if mark.landmark.shape in ("L", "T") and not mark.occluded and mark.distance <= REACH
                    ],
                    (-1, 2),
                ),
            )
            for pixels, truth in twins
        ]
        sets.append(costs_of_settings(with_truth).mean(axis=1))
    rng, halves = np.random.default_rng(0), []
    for _ in range(200):
        parts = np.array_split(rng.permutation(real.shape[1]), 2)
        halves.append(rank_correlation(*(real[:, half].mean(axis=1) for half in parts)))
    mean = real.mean(axis=1)
    return {
        "rooms": 4 * SETS_OF_ROOMS,
        "rank correlation": rank_correlation(mean, np.mean(sets, axis=0)),
        "of each set": [rank_correlation(mean, each) for each in sets],
        "halves": float(np.nanmedian(halves)),
    }


def main() -> Result:
    """Measure all pictures at both sizes, and run the paper's detector in 24 rooms."""
    values: dict[str, Any] = {
        "all 94 pictures": compare(),
        "8 pictures of 1280 x 960": compare(large=True),
        "detector over rooms": over_rooms(),
    }
    tables = tuple(
        Table.of(
            title,
            {name: row | {"ratio": row["simulated"] / row["real"]} for name, row in values[title].items()},
        )
        for title in list(values)[:2]
    )
    rooms = values["detector over rooms"]
    note = (
        f"rank correlation of the paper's 27 mean costs over {rooms['rooms']} rooms: {rooms['rank correlation']:.2f}; "
        f"sets of four rooms: {', '.join(f'{each:.2f}' for each in rooms['of each set'])}; "
        f"halves of the real pictures: {rooms['halves']:.2f}"
    )
    return Result("realism", values, tables, (note,))
