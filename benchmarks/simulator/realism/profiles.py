"""A picture's channels read between pixels, and profiles across its lines."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
import numpy.typing as npt
from scipy import ndimage

from benchmarks.simulator.realism.geometry import Lines, Mask, Pixels
from nao_course.geometry import FloatArray

_STEP = 0.125  # px at 320 wide, between the places where a profile is read
_REACH = 8.0  # px at 320 wide, how far a profile reaches beyond the line's edge


class Picture:
    """A picture's channels, read between pixels by cubic splines."""

    def __init__(self, pixels: Pixels) -> None:
        self.pixels = pixels
        self.hls = np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGB2HLS))
        self.lightness = self.hls[..., 1].astype(float)
        hue, saturation = self.hls[..., 0], self.hls[..., 2]
        self.greenish = (saturation > 0.16 * 255) & (hue > 35) & (hue < 90)

    @cached_property
    def _lightness_spline(self) -> FloatArray:
        return np.asarray(ndimage.spline_filter(self.lightness, order=3))

    @cached_property
    def _chroma_spline(self) -> FloatArray:
        red, green, blue = (self.pixels[..., i].astype(float) for i in range(3))
        return np.asarray(ndimage.spline_filter(green - (red + blue) / 2, order=3))

    def read(self, places: FloatArray, chroma: bool = False) -> FloatArray:
        """Return the lightness, or green minus the mean of red and blue, at positions (..., 2) as (u, v)."""
        spline = self._chroma_spline if chroma else self._lightness_spline
        where = np.moveaxis(places[..., ::-1], -1, 0)
        return np.asarray(ndimage.map_coordinates(spline, where, order=3, mode="nearest", prefilter=False))

    @cached_property
    def _channel_splines(self) -> list[FloatArray]:
        return [
            np.asarray(ndimage.spline_filter(self.pixels[..., i].astype(float), order=3)) for i in range(3)
        ]

    def read_channel(self, places: FloatArray, channel: int) -> FloatArray:
        """Return red, green or blue (0, 1, 2) at positions (..., 2) as (u, v)."""
        where = np.moveaxis(places[..., ::-1], -1, 0)
        spline = self._channel_splines[channel]
        return np.asarray(ndimage.map_coordinates(spline, where, order=3, mode="nearest", prefilter=False))

    def is_greenish(self, places: FloatArray) -> Mask:
        """Return whether the pixel at each position has the colour of any carpet."""
        height, width = self.greenish.shape
        column = np.clip(np.rint(places[..., 0]).astype(int), 0, width - 1)
        row = np.clip(np.rint(places[..., 1]).astype(int), 0, height - 1)
        return np.asarray(self.greenish[row, column])


@dataclass(frozen=True)
class Profiles:
    """Profiles (N, K) across lines at offsets (K,) px from where the line should be, and what follows from each.

    Parameters
    ----------
    offsets, values : ndarray, shape (K,) and (N, K)
        Where, and the lightness there.
    centre, width : ndarray, shape (N,)
        Middle and full width at half height of the bright peak, px.
    base, peak : ndarray, shape (N,)
        Lightness of the carpet on both sides, and the greatest within the peak.
    on_carpet, good : ndarray, shape (N,)
        Whether there is carpet on both sides; and between them a peak.
    """

    offsets: FloatArray
    values: FloatArray
    centre: FloatArray
    width: FloatArray
    base: FloatArray
    peak: FloatArray
    on_carpet: Mask
    good: Mask


def line_profiles(picture: Picture, lines: Lines, scale: float, search: float) -> Profiles:
    """Read a profile across every line point; a peak is looked for within `search` px (at 320) of the middle."""
    half = lines.half_width[:, None]
    reach = float(lines.half_width.max(initial=1.0)) + (_REACH + search) * scale
    offsets = np.arange(-reach, reach + 1e-9, _STEP * scale)
    places = lines.pixel[:, None] + offsets[:, None] * lines.normal[:, None]
    values = np.clip(picture.read(places), 0, 255)  # a spline overshoots beside what is overexposed
    height, width = picture.lightness.shape
    limit = (width - 1, height - 1)
    values[((places < 0) | (places > limit)).any(axis=2)] = np.nan
    green = picture.is_greenish(places)
    # Carpet: from 1 to 3 px (at 320) beyond the edges, and as much more as the line may be off.
    beyond = np.abs(offsets)[None] - half
    sides = (beyond > (1.0 + search / 2) * scale) & (beyond < (3.0 + search / 2) * scale)
    left, right = sides & (offsets < 0), sides & (offsets > 0)
    base = (masked_median(values, left) + masked_median(values, right)) / 2
    is_carpet = [(green & side).sum(axis=1) > 0.7 * np.maximum(side.sum(axis=1), 1) for side in (left, right)]
    candidates = np.where(np.abs(offsets)[None] <= search * scale + half, values, -np.inf)
    candidates[np.isnan(candidates)] = -np.inf
    top = candidates.argmax(axis=1)
    peak = values[np.arange(len(values)), top]
    level = (base + peak) / 2
    with np.errstate(invalid="ignore"):
        low, high = crossing(offsets, values, top, level, -1), crossing(offsets, values, top, level, 1)
        good = (peak - base > 10) & is_carpet[0] & is_carpet[1] & np.isfinite(low + high)
    on_carpet = is_carpet[0] & is_carpet[1]
    return Profiles(offsets, values, (low + high) / 2, high - low, base, peak, on_carpet, good)


def masked_median(values: FloatArray, mask: Mask) -> FloatArray:
    """Return the median of the chosen values of each row; NaN if there are none."""
    chosen = np.sort(np.where(mask & ~np.isnan(values), values, np.inf), axis=1)
    count = np.isfinite(chosen).sum(axis=1)
    rows = np.arange(len(values))
    middle = (chosen[rows, np.maximum(count - 1, 0) // 2] + chosen[rows, np.maximum(count, 1) // 2]) / 2
    return np.where(count > 1, middle, np.nan)


def crossing(
    offsets: FloatArray, values: FloatArray, start: npt.NDArray[np.intp], level: FloatArray, direction: int
) -> FloatArray:
    """Return the offset (N,) at which each row, from `start` on, first falls to `level`; NaN if it does not."""
    if direction < 0:
        flipped = crossing(-offsets[::-1], values[:, ::-1], values.shape[1] - 1 - start, level, 1)
        return -flipped
    columns = np.arange(values.shape[1])
    with np.errstate(invalid="ignore"):
        below = (values < level[:, None]) & (columns[None] > start[:, None])
    first = below.argmax(axis=1)
    rows = np.arange(len(values))
    after, before = values[rows, first], values[rows, np.maximum(first - 1, 0)]
    with np.errstate(divide="ignore", invalid="ignore"):
        part = (before - level) / (before - after)
        found = offsets[np.maximum(first - 1, 0)] + part * (offsets[1] - offsets[0])
    return np.where(below.any(axis=1), found, np.nan)


def half_way(offsets: FloatArray, values: FloatArray) -> FloatArray:
    """Return where each profile (N, K), which starts on a bright line, falls half way to the carpet at its end."""
    high, low = (
        values[:, : values.shape[1] // 5].max(axis=1),
        np.median(values[:, -values.shape[1] // 4 :], axis=1),
    )
    level = np.where(high - low > 60, (high + low) / 2, np.nan)
    return crossing(offsets, values, np.full(len(values), 0), level, 1)


def thinned(n: int, most: int) -> Mask:
    """Choose every k-th of n, no more than `most`."""
    return np.arange(n) % max(1, -(-n // most)) == 0


def robust_sd(values: FloatArray) -> float:
    """Return the standard deviation estimated from the median absolute deviation."""
    return float(1.4826 * np.median(np.abs(values - np.median(values)))) if values.size else float("nan")
