"""Lighting of the scene, and the lens and sensor of the camera, which turn linear light into a picture."""

from __future__ import annotations

from functools import lru_cache

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray
from nao_course.sim.field import Field
from nao_course.sim.reality import Reality
from nao_course.sim.shapes import Eye, Float32, centre_pixels

_COARSE = 8  # lighting changes so slowly in a picture that it is computed for every 8th pixel only
_MEAN_LIGHTNESS = 117.0  # of 255: mean lightness that the automatic exposure of the real camera produces
_BLUR_SMALL, _BLUR_WIDE = 0.38, 0.38  # px: sigma of the picture's scaling, and of the lens at a width of 320
_FALL_OFF = (1.3, 1.0, 0.75)  # measured vignette of red, green and blue, relative to green
# Lines are more overexposed the steeper they are seen from above: real pictures have 255 there even in the corners.
_TAPE = np.float32(12)
# Measured noise of red, green and blue, relative to their mean.
_CHANNEL_NOISE: Float32 = np.array([1.05, 0.78, 1.17], dtype=np.float32)


class Lamps:
    """Brightness of each part of a picture on a coarse grid: uneven light, colour cast and vignette."""

    def __init__(self, field: Field, eye: Eye, reality: Reality) -> None:
        self.reality, self.width = reality, eye.view.size[0]
        towards, cast, self._lamps = _lamps(reality.seed)
        rays = eye.field_rays(_COARSE)
        rays /= np.sqrt((rays**2).sum(axis=0))
        down = np.maximum(-rays[2], np.float32(0.02))
        gain = np.ones((*rays.shape[1:], 3), dtype=np.float32)
        if reality.gradient:
            where = eye.ground_position[:, None, None] + rays[:2] * (eye.view.height / down)
            across = where[0] * np.cos(towards) + where[1] * np.sin(towards)
            gain *= 1 + np.float32(reality.gradient) * np.tanh(across / 3).astype(np.float32)[..., None]
        if reality.vignette:  # measured in lightness, which is the square root of light
            some = np.ix_(*(centre_pixels(n, _COARSE) for n in eye.grid.right.shape))
            right, below = eye.grid.right[some], eye.grid.down[some]
            corner = np.tan(eye.view.hfov / 2) ** 2 + np.tan(eye.view.vfov / 2) ** 2
            fall = reality.vignette * ((right**2 + below**2) / corner)[..., None] * _FALL_OFF
            gain *= np.maximum(1 - fall, 0).astype(np.float32) ** 2
        if reality.white_balance:
            # A gain must not be negative.
            balance = np.maximum(1 + reality.white_balance * (cast - cast.mean()), 0)
            gain *= balance.astype(np.float32)
        self._gain, self._rays = gain, rays
        self._steep = np.maximum(down - np.float32(0.16), 0)[..., None]  # constant beyond 3 m

    @property
    def even(self) -> bool:
        """Whether the light is the same everywhere."""
        r = self.reality
        return not (r.gradient or r.vignette or r.white_balance)

    def at(self, pixels: npt.NDArray[np.intp]) -> Float32:
        """Return the gains (N, 3) at flat pixels (N,)."""
        rows, columns = np.divmod(pixels, self.width)
        return self._gain[rows // _COARSE, columns // _COARSE]

    def overexposed(self, pixels: npt.NDArray[np.intp]) -> Float32:
        """Return the overexposure (N, 1) of lines at flat pixels (N,), which is least when seen from the side."""
        rows, columns = np.divmod(pixels, self.width)
        steep = self._steep[rows // _COARSE, columns // _COARSE]
        return 1 + np.float32(self.reality.overexposure) * (1 + _TAPE * steep)

    def light_ground(self, light: Float32) -> None:
        """Apply gains, the effect of the carpet's pile, and reflections to a picture (H, W, 3) of ground and room."""
        r, size = self.reality, light.shape[1::-1]
        gain = self._gain
        if r.pile:  # from above, the gaps between the fibres are visible, which are darker and greener
            gain = gain * np.maximum(1 - r.pile * self._steep * (1.25, 0.41, 0.9), 0.05).astype(np.float32)
        if r.pile or not self.even:
            cv2.multiply(light, _enlarged(gain, size), dst=light)
        if r.glare:
            azimuth = np.arctan2(self._rays[1], self._rays[0])
            dip = np.arcsin(np.clip(-self._rays[2], 0, 1))
            where, low, wide, strength = self._lamps.T[..., None, None]
            off = (azimuth - where + np.pi) % (2 * np.pi) - np.pi
            lights = np.exp(-((off / wide) ** 2) - ((dip - low) / 0.2) ** 2).astype(np.float32)
            shine = (strength.astype(np.float32) * lights).sum(axis=0)
            shine *= np.clip(dip / 0.06, 0, 1) * np.float32(r.glare)  # only the ground reflects
            cv2.add(light, cv2.cvtColor(_enlarged(shine, size), cv2.COLOR_GRAY2RGB), dst=light)


@lru_cache(maxsize=8)
def _lamps(seed: int) -> tuple[float, FloatArray, FloatArray]:
    """Draw the direction in which the light grows (rad), the tint (3,), and the lamps that a room's carpet reflects.

    A lamp (of six, with four values) has an azimuth and a dip below the horizon, a width (rad) and a brightness.
    """
    rng = np.random.default_rng([seed, 3])
    towards, cast = rng.uniform(-np.pi, np.pi), rng.normal(0, 1, 3)
    return towards, cast, rng.uniform((-np.pi, 0.12, 0.25, 0.4), (np.pi, 0.40, 0.60, 1.0), (6, 4))


def _enlarged(coarse: Float32, size: tuple[int, ...]) -> Float32:
    """Interpolate a coarse grid (h, w[, 3]), with a point in the centre of each 8 by 8 pixels, to (width, height)."""
    whole = (coarse.shape[1] * _COARSE, coarse.shape[0] * _COARSE)
    return cv2.resize(coarse, whole, interpolation=cv2.INTER_LINEAR)[: size[1], : size[0]]


def develop(
    light: Float32, eye: Eye, reality: Reality, rng: np.random.Generator | None
) -> npt.NDArray[np.uint8]:
    """Make a picture from linear light (H, W, 3): blur, exposure, tone curve, noise and clipping."""
    gain = _exposure(light, reality, rng) if reality.exposure else 1.0
    if eye.turning.any():
        light = _smear(light, eye)
    if reality.blur:
        sigma = reality.blur * np.hypot(_BLUR_SMALL, _BLUR_WIDE * eye.view.size[0] / 320)
        light = cv2.GaussianBlur(light, (0, 0), float(sigma))
    shown = cv2.sqrt(light)
    if reality.noise and rng is not None:
        return _with_noise(shown, 255 * gain, reality.noise, rng)
    return cv2.convertScaleAbs(shown, alpha=255 * gain)


def _exposure(light: Float32, reality: Reality, rng: np.random.Generator | None) -> float:
    """Return the gain with which a picture has the mean lightness of the automatic exposure."""
    some = np.sqrt(light[_COARSE // 2 :: _COARSE, _COARSE // 2 :: _COARSE].reshape(-1, 3))
    if not len(some):
        return 1.0
    extremes = np.stack([some.max(axis=1), some.min(axis=1)])
    wanted = _MEAN_LIGHTNESS + (rng.normal(0, 4) if rng is not None else 0.0)
    low, high = 0.4, 1.8
    for _ in range(14):
        gain = (low + high) / 2
        mean = 127.5 * np.minimum(gain * extremes, 1).sum(axis=0).mean()
        low, high = (gain, high) if mean < wanted else (low, gain)
    return float(gain**reality.exposure)


def _smear(light: Float32, eye: Eye) -> Float32:
    """Add motion blur. A row is exposed during a quarter of the time in which the picture is read out."""
    _, about_left, about_up = eye.turning / 4
    shift = np.array([about_up * eye.view.focal[0], -about_left * eye.view.focal[1]])
    reach = int(np.ceil(np.abs(shift).max() / 2))
    if reach < 1:
        return light
    kernel = np.zeros((2 * reach + 1, 2 * reach + 1), dtype=np.float32)
    for u, v in np.linspace(-0.5, 0.5, 16 * reach + 1)[:, None] * shift + reach:
        kernel[round(v), round(u)] += 1
    return cv2.filter2D(light, -1, kernel / kernel.sum(), borderType=cv2.BORDER_REPLICATE)


@lru_cache(maxsize=1)
def _noise_tile() -> Float32:
    """Return a tile (512, 512, 3) of noise whose standard deviation, averaged over the channels, is 1."""
    return np.random.default_rng(33).standard_normal((512, 512, 3), dtype=np.float32) * _CHANNEL_NOISE


def _with_noise(shown: Float32, gain: float, sigma: float, rng: np.random.Generator) -> npt.NDArray[np.uint8]:
    """Add noise from random places of the tile, because new random numbers would double the time of a picture."""
    tile, picture = _noise_tile(), np.empty(shown.shape, dtype=np.uint8)
    for row in range(0, shown.shape[0], 256):
        for column in range(0, shown.shape[1], 256):
            block = shown[row : row + 256, column : column + 256]
            i, j = rng.integers(0, 257, 2)
            noise = tile[i : i + block.shape[0], j : j + block.shape[1]]
            picture[row : row + 256, column : column + 256] = cv2.addWeighted(
                block, gain, noise, sigma, 0, dtype=cv2.CV_8U
            )
    return picture
