"""Do the simulator's pictures look like the real ones? The same statistics are measured in both.

The geometry of each picture is known, so carpet and background are measured separately.
"""

from collections.abc import Iterable
from typing import Any

import cv2
import numpy as np

from benchmarks import Result, Table, solution
from benchmarks.field.detections import quick_labels
from benchmarks.simulator.real_scenes import Geometry, Mask, Pixels, real_scenes
from nao_course.geometry import FloatArray
from nao_course.sim.reality import Reality

WHITE = 3  # label
# Immerkaer 1996: the response to noise, and not to gradients or edges.
LAPLACIAN = np.array([[1.0, -2, 1], [-2, 4, -2], [1, -2, 1]])
# Statistics that are 0 in most pictures, so that the mean over pictures is shown; of all others the median.
BY_MEAN = ("bright specks", "white %", "edges %", "white left off")


def robust_sd(values: FloatArray) -> float:
    """Return the standard deviation estimated from the median absolute deviation."""
    return float(1.4826 * np.median(np.abs(values - np.median(values)))) if values.size else float("nan")


def measure(pixels: Pixels, geometry: Geometry) -> dict[str, float]:
    """Measure one picture of 320 x 240; statistics for which it shows too little are missing."""
    hls = np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGB2HLS))
    hue, light, saturation = hls[..., 0], hls[..., 1].astype(float), hls[..., 2]
    other = ~((saturation > 0.16 * 255) & (hue > 35) & (hue < 90))
    # Objects on the carpet are left out, and 3 px around them.
    odd = cv2.dilate(cv2.medianBlur(other.astype(np.uint8), 5), np.ones((7, 7), np.uint8)) > 0
    carpet = geometry.carpet & ~odd
    found: dict[str, Any] = {"picture's mean lightness": light.mean()}
    if carpet.sum() >= 500:
        found |= {f"carpet, hue {q} %": np.percentile(hue[carpet], q) for q in (1, 50, 99)}
        found |= {f"carpet, lightness {q} %": np.percentile(light[carpet], q) for q in (5, 50, 95)}
    if carpet.sum() >= 2000:
        for where, low, high in (("near", 0.5, 1.3), ("far", 2.0, 4.0)):
            found[f"noise, {where}"] = noise_sd(
                light, carpet & (geometry.distance > low) & (geometry.distance < high)
            )
        found["grain"] = robust_sd(_rest(light, carpet, 15)[carpet])
        rest = _rest(light, carpet, 11)
        bright = (rest > 5 * robust_sd(rest[carpet])) & carpet
        number, _ = cv2.connectedComponents(bright.astype(np.uint8), connectivity=8)
        found["bright specks per 10000 px"] = (number - 1) / carpet.sum() * 1e4
    return found | behind_the_field(pixels, light, geometry)


def behind_the_field(pixels: Pixels, light: FloatArray, geometry: Geometry) -> dict[str, float]:
    """Measure what may confuse a detector: what is above the carpet, and white areas that are not lines."""
    labels, background, found = quick_labels(pixels), geometry.background, dict[str, Any]()
    if background.sum() > 500:
        found |= {
            f"behind the field, lightness {q} %": np.percentile(light[background], q) for q in (25, 50, 95)
        }
        found["behind the field, white %"] = 100 * (labels[background] == WHITE).mean()
        edges = cv2.Canny(cv2.cvtColor(pixels, cv2.COLOR_RGB2GRAY), 80, 160)
        found["behind the field, edges %"] = 100 * (edges[background] > 0).mean()
    kept = solution("03")["erase_background"](labels) == WHITE
    found["white left off the lines, px"] = (kept & ~geometry.near_lines & ~geometry.near_posts).sum()
    return found


def noise_sd(channel: FloatArray, mask: Mask) -> float:
    """Return the standard deviation of white noise with the same response to a Laplacian."""
    whole = cv2.erode(mask.astype(np.uint8), np.ones((3, 3), np.uint8), borderValue=0) > 0
    if whole.sum() < 60:
        return float("nan")
    answer = cv2.filter2D(np.asarray(channel, dtype=float), -1, LAPLACIAN)[whole]
    # Whole numbers make the median jump by whole steps: spread each over its step.
    return robust_sd(answer + np.random.default_rng(0).uniform(-0.5, 0.5, answer.shape)) / 6.0


def _rest(values: FloatArray, mask: Mask, size: int) -> FloatArray:
    """Return the difference from the mean of the masked values in a square window around each pixel."""
    weight = cv2.blur(mask.astype(float), (size, size))
    return np.asarray(values - cv2.blur(np.where(mask, values, 0.0), (size, size)) / np.maximum(weight, 1e-9))


def summarise(measured: Iterable[dict[str, float]]) -> dict[str, float]:
    """Return the mean or the median of each statistic over the pictures."""
    found: dict[str, list[float]] = {}
    for each in measured:
        for name, value in each.items():
            found.setdefault(name, []).append(value)
    return {
        name: float((np.nanmean if any(each in name for each in BY_MEAN) else np.nanmedian)(values))
        for name, values in found.items()
    }


def main() -> Result:
    """Measure all pictures and their twins."""
    scenes = real_scenes()
    geometry = [scene.geometry() for scene in scenes]
    real = [scene.picture.pixels for scene in scenes]
    twins = [scene.twin(Reality(), number) for number, scene in enumerate(scenes)]
    real_values, simulated = (
        summarise(measure(p, g) for p, g in zip(side, geometry, strict=True)) for side in (real, twins)
    )
    values = {
        name: {"real": value, "simulated": simulated[name], "ratio": simulated[name] / value}
        for name, value in real_values.items()
    }
    return Result("realism", values, (Table.of(f"all {len(scenes)} pictures", values),))
