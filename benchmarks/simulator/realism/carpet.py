"""Instruments that look at the carpet: its colour, its light, its noise and texture."""

from __future__ import annotations

from typing import Any

import cv2
import numpy as np

from benchmarks.simulator.realism.geometry import Geometry, Mask
from benchmarks.simulator.realism.profiles import Picture, robust_sd
from nao_course.geometry import FloatArray


def carpet_colour(picture: Picture, geometry: Geometry, carpet: Mask) -> dict[str, Any]:
    """Return hue (0..180), lightness, saturation (0..255) and colour of the carpet, and the mean lightness of all."""
    samples: dict[str, Any] = {"picture's mean lightness": picture.lightness.mean()}
    if carpet.sum() < 500 * geometry.scale**2:
        return samples
    hue, lightness, saturation = picture.hls[carpet].T
    samples.update({f"hue {q} %": np.percentile(hue, q) for q in (1, 5, 50, 95, 99)})
    samples.update({f"lightness {q} %": np.percentile(lightness, q) for q in (5, 25, 50, 75, 95)})
    samples["saturation mean"] = saturation.mean()
    samples.update(zip(("red", "green", "blue"), np.median(picture.pixels[carpet], axis=0), strict=True))
    samples["foreign on carpet %"] = 100 * (1 - carpet.sum() / geometry.carpet.sum())
    return samples


def carpet_light(picture: Picture, geometry: Geometry, carpet: Mask) -> dict[str, Any]:
    """Measure the change of the carpet's lightness over a picture: sides to centre, far to near, and in patches."""
    samples: dict[str, Any] = {}
    height, width = carpet.shape
    fifth, band = width // 6, round(8 * geometry.scale)
    parts = {
        "left": slice(0, fifth),
        "centre": slice(width // 2 - fifth // 2, width // 2 + fifth // 2),
        "right": slice(width - fifth, width),
    }
    rows: list[dict[str, float]] = []
    for v in range(0, height - band + 1, band):
        light = picture.lightness[v : v + band]
        mask = carpet[v : v + band]
        rows.append(
            {
                n: float(np.median(light[:, s][mask[:, s]])) if mask[:, s].mean() > 0.5 else np.nan
                for n, s in parts.items()
            }
        )
    table = {name: np.array([row[name] for row in rows]) for name in parts}
    for name in ("left", "right"):
        ratio = table[name] / table["centre"]
        if np.isfinite(ratio).sum() >= 3:
            samples[f"{name} / centre"] = np.nanmedian(ratio)
    both = (table["left"] + table["right"]) / 2 / table["centre"]
    if np.isfinite(both).sum() >= 3:
        samples["sides / centre"] = np.nanmedian(both)
    bottom = slice(height - height // 8, height)
    edge, middle = (np.array(bounds) * width // 10 for bounds in ((0, 1, 9, 10), (4, 6)))
    corners = [picture.lightness[bottom, a:b][carpet[bottom, a:b]] for a, b in (edge[:2], edge[2:])]
    centre = picture.lightness[bottom, middle[0] : middle[1]][carpet[bottom, middle[0] : middle[1]]]
    if min(len(each) for each in (*corners, centre)) > 200 * geometry.scale**2:
        samples["bottom corners / bottom"] = np.mean([np.median(c) for c in corners]) / np.median(centre)
    near, far = (
        carpet & (geometry.distance > a) & (geometry.distance < b) for a, b in ((0.6, 1.2), (2.5, 4.0))
    )
    if min(near.sum(), far.sum()) > 300 * geometry.scale**2:
        samples["far / near lightness"] = np.median(picture.lightness[far]) / np.median(
            picture.lightness[near]
        )
    trend = _local_mean(picture.lightness, carpet, round(64 * geometry.scale))
    for size in (8, 24):
        n = round(size * geometry.scale)
        whole = cv2.blur(carpet.astype(np.float32), (n, n)) > 0.999
        patches = (cv2.blur(picture.lightness, (n, n)) / np.maximum(trend, 1))[whole]
        if whole.sum() > 2000 * geometry.scale**2:
            samples[f"patch contrast {size} px"] = 100 * robust_sd(patches)
    return samples


def _local_mean(values: FloatArray, mask: Mask, size: int) -> FloatArray:
    """Return the mean of the masked values in a square window around each pixel."""
    weight = cv2.blur(mask.astype(float), (size, size))
    return np.asarray(cv2.blur(np.where(mask, values, 0.0), (size, size)) / np.maximum(weight, 1e-9))


# Immerkaer 1996: sees noise, not slopes or edges
_LAPLACIAN = np.array([[1.0, -2, 1], [-2, 4, -2], [1, -2, 1]])


def noise_sd(channel: FloatArray, mask: Mask, block: int = 1) -> float:
    """Return the standard deviation of white noise with the same response to a Laplacian, after block averaging."""
    if block > 1:
        height, width = (n // block * block for n in channel.shape)
        shape = (height // block, block, width // block, block)
        channel = channel[:height, :width].reshape(shape).mean(axis=(1, 3))
        mask = np.asarray(mask[:height, :width].reshape(shape).all(axis=(1, 3)))
    whole = cv2.erode(mask.astype(np.uint8), np.ones((3, 3), np.uint8), borderValue=0) > 0
    if whole.sum() < 60:
        return float("nan")
    answer = cv2.filter2D(np.asarray(channel, dtype=float), -1, _LAPLACIAN)[whole]
    # Whole numbers make the median jump by whole steps: spread each over its step.
    spread = np.random.default_rng(0).uniform(-0.5, 0.5, answer.shape) if block == 1 else 0.0
    return robust_sd(answer + spread) / 6.0


def carpet_noise(picture: Picture, geometry: Geometry, carpet: Mask) -> dict[str, Any]:
    """Measure sensor noise and carpet grain: strength by scale and channel, correlation, specks."""
    if carpet.sum() < 2000 * geometry.scale**2:
        return {}
    samples: dict[str, Any] = {}
    rest = picture.lightness - _local_mean(picture.lightness, carpet, round(15 * geometry.scale))
    samples["grain sd"] = robust_sd(rest[carpet])
    for where, low, high in (("near", 0.5, 1.3), ("far", 2.0, 4.0)):
        part = carpet & (geometry.distance > low) & (geometry.distance < high)
        samples[f"grain sd, {where}"] = (
            robust_sd(rest[part]) if part.sum() > 200 * geometry.scale**2 else np.nan
        )
        for block in (1, 2, 4, 8):
            samples[f"noise sd, {where}, {block}x{block}"] = noise_sd(picture.lightness, part, block)
    rgb = [picture.pixels[..., i].astype(float) for i in range(3)]
    red, green, blue = rgb
    luma = 0.299 * red + 0.587 * green + 0.114 * blue
    channels = {
        "red": red,
        "green": green,
        "blue": blue,
        "luma": luma,
        "Cb": 0.564 * (blue - luma),
        "Cr": 0.713 * (red - luma),
    }
    samples.update({f"noise sd {name}": noise_sd(channel, carpet) for name, channel in channels.items()})
    rest = np.clip(rest, *(np.array([-4, 4]) * robust_sd(rest[carpet])))
    for name, (dv, du) in {
        "next column": (0, 1),
        "next row": (1, 0),
        "2 columns": (0, 2),
        "2 rows": (2, 0),
    }.items():
        samples[f"correlation {name}"] = _shifted_correlation(rest, carpet, dv, du)
    whole = cv2.erode(carpet.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    answers = [cv2.filter2D(channel, -1, _LAPLACIAN)[whole] for channel in rgb]
    for name, i, j in (("red-green", 0, 1), ("green-blue", 1, 2), ("red-blue", 0, 2)):
        samples[f"correlation {name}"] = _correlation(answers[i], answers[j])
    samples.update(_specks(picture, geometry, carpet))
    return samples


def _shifted_correlation(rest: FloatArray, mask: Mask, dv: int, du: int) -> float:
    """Return the correlation of pixels with those `dv` rows and `du` columns away."""
    height, width = rest.shape
    a, b = rest[: height - dv, : width - du], rest[dv:, du:]
    both = mask[: height - dv, : width - du] & mask[dv:, du:]
    return _correlation(a[both], b[both])


def _correlation(a: FloatArray, b: FloatArray) -> float:
    """Return the correlation; NaN if nothing varies."""
    return float(np.corrcoef(a, b)[0, 1]) if np.std(a) > 0 and np.std(b) > 0 else float("nan")


def _specks(picture: Picture, geometry: Geometry, carpet: Mask) -> dict[str, float]:
    """Return the spots that differ from their surroundings by more than five standard deviations."""
    rest = picture.lightness - _local_mean(picture.lightness, carpet, round(11 * geometry.scale))
    sd = robust_sd(rest[carpet])
    counts = {}
    for name, mask in (("bright", rest > 5 * sd), ("dark", rest < -5 * sd)):
        number, _ = cv2.connectedComponents((mask & carpet).astype(np.uint8), connectivity=8)
        counts[f"{name} specks per 10000 px"] = (number - 1) / carpet.sum() * 1e4 * geometry.scale**2
    return counts
