"""The texture of a worn carpet, generated from a seed, with smaller copies for large distances (a mipmap)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, rotation_2d
from nao_course.sim.shapes import Float32

Bytes = npt.NDArray[np.uint8]
Colour = tuple[int, int, int]
Rectangle = tuple[float, float, float, float]

TEXEL = 0.005  # m: width of a pixel of the finest texture
_LEVELS = 6
_STRIP = 2.0  # m: width of a strip of carpet


@dataclass(frozen=True)
class Wear:
    """The wear of a carpet; see `Reality` for the parameters."""

    grain: float
    mottle: float
    seams: float
    specks: float
    crumbs: float
    tape: float


@lru_cache(maxsize=2)  # 8 MB each; asked for at every picture
def carpet_levels(
    extent: Rectangle, lines: Rectangle, colour: Colour, wear: Wear, seed: int
) -> tuple[Bytes, ...]:
    """Make the texture of a carpet at several resolutions, each half as fine as the previous one.

    The rows run along y, the columns along x; the channels are RGB and an unused one. `extent` is the rectangle of the
    carpet and `lines` the rectangle of its outer lines: (x_min, y_min, x_max, y_max), m.
    """
    rng = np.random.default_rng([seed, 1])
    shape = tuple(int(np.ceil((extent[i + 2] - extent[i]) / TEXEL)) for i in (1, 0))
    light = wear.mottle * (0.7 * cloud(shape, 0.6, rng) + 0.7 * cloud(shape, 0.2, rng))
    light += wear.grain * (0.3 * cloud(shape, 0.012, rng) + cloud(shape, TEXEL, rng))
    warm = 0.9 * wear.mottle * cloud(shape, 0.7, rng) + 0.12 * wear.grain * cloud(shape, 0.01, rng)
    carpet: Float32 = np.stack([light + warm, light, light - warm], axis=2)
    carpet += np.array(colour, dtype=np.float32)
    brush = _Brush(carpet, extent, rng)
    _add_seams(brush, wear)
    _add_tape(brush, wear, lines)
    _add_crumbs(brush, wear)
    _add_specks(brush, wear)
    levels = [with_fourth(np.clip(np.rint(carpet), 0, 255).astype(np.uint8))]
    while len(levels) < _LEVELS:
        levels.append(halved(levels[-1]))
    return tuple(levels)


def with_fourth(picture: Bytes) -> Bytes:
    """Add an unused fourth channel to RGB, because OpenCV's `remap` is 2.5 times as fast with four channels."""
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2RGBA), dtype=np.uint8)


def halved(picture: Bytes) -> Bytes:
    """Return a picture at half the size, in which each pixel is the mean of four."""
    return np.asarray(cv2.resize(picture, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA), dtype=np.uint8)


def cloud(shape: tuple[int, ...], scale: float, rng: np.random.Generator) -> Float32:
    """Return a smooth random field with a standard deviation of 1, whose patches are `scale` metres wide."""
    cells = max(scale / TEXEL, 1.0)
    small = rng.standard_normal([int(n / cells) + 3 for n in shape], dtype=np.float32)
    field = small if cells == 1 else cv2.resize(small, shape[::-1], interpolation=cv2.INTER_CUBIC)
    field = field[: shape[0], : shape[1]]
    return np.asarray(field / max(float(field.std()), 1e-6), dtype=np.float32)


@dataclass(frozen=True, eq=False)
class _Brush:
    """A brush that paints on a carpet (rows, columns, 3) at positions in the field frame, m."""

    carpet: Float32
    extent: Rectangle
    rng: np.random.Generator

    @property
    def square_metres(self) -> float:
        return (self.extent[2] - self.extent[0]) * (self.extent[3] - self.extent[1])

    def anywhere(self) -> FloatArray:
        """Return a random point (2,) on the carpet."""
        return self.rng.uniform(self.extent[:2], self.extent[2:])

    def fill(self, points: npt.ArrayLike, colour: npt.ArrayLike) -> None:
        """Fill a polygon (N, 2) of the field frame."""
        pixels = (np.asarray(points, dtype=float) - self.extent[:2]) / TEXEL - 0.5
        shades = np.clip(np.asarray(colour, dtype=float), 0, 255).tolist()
        cv2.fillPoly(self.carpet, [np.rint(pixels * 16).astype(np.int32)], shades, cv2.LINE_8, 4)

    def shift(self, points: npt.ArrayLike, change: npt.ArrayLike) -> None:
        """Fill a polygon with the colour of the carpet at its centre plus a change."""
        pixel = ((np.mean(np.asarray(points), axis=0) - self.extent[:2]) / TEXEL).astype(int)
        column, row = np.clip(pixel, 0, np.array(self.carpet.shape[1::-1]) - 1)
        self.fill(points, self.carpet[row, column] + np.asarray(change, dtype=float))

    def box(self, centre: FloatArray, size: npt.ArrayLike, angle: float) -> FloatArray:
        """Return the corners (4, 2) of a rotated rectangle."""
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) / 2 * np.asarray(size)
        return np.asarray(corners @ rotation_2d(angle).T + centre)

    def lens(self, centre: FloatArray, size: npt.ArrayLike, angle: float) -> FloatArray:
        """Return the corners (12, 2) of a rotated, tapered patch."""
        t = np.linspace(0, 2 * np.pi, 12, endpoint=False)
        across = np.sin(t) * np.abs(np.sin(t)) * self.rng.uniform(0.7, 1.3, 12)
        points = np.column_stack([np.cos(t), across]) / 2 * np.asarray(size)
        return np.asarray(points @ rotation_2d(angle).T + centre)


def _add_seams(brush: _Brush, wear: Wear) -> None:
    """Add the joints between strips along the field: a faint line, dark gaps, and in places the white backing."""
    if not wear.seams:
        return
    rng, (x0, y0, x1, y1) = brush.rng, brush.extent
    first = y0 + rng.uniform(0.3, 0.9) * _STRIP
    for y in np.arange(first, y1, _STRIP):
        bad = rng.uniform(0.3, 1.0) * wear.seams
        faint = [(x0, y - 0.006), (x1, y - 0.006), (x1, y + 0.006), (x0, y + 0.006)]
        brush.shift(faint, np.full(3, -16.0 * wear.seams))
        for x in rng.uniform(x0, x1, rng.poisson(3.2 * bad * (x1 - x0))):
            at, slant = np.array([x, y + rng.normal(0, 0.008)]), rng.normal(0, 0.05)
            size = np.array([min(rng.exponential(0.11) + 0.02, 0.45), rng.uniform(0.01, 0.026)])
            brush.fill(brush.lens(at, size, slant), (30, 52, 34))
            if rng.random() < 0.22:  # the edge curls up and its backing is visible
                side = at + (rng.normal(0, 0.02), 0.018)
                white = rng.uniform(150, 255)
                brush.fill(brush.lens(side, size * (0.8, 0.45), slant), (white, white, white - 8))


def _add_tape(brush: _Brush, wear: Wear, lines: Rectangle) -> None:
    """Add dark patches of tape along the outside of the outer lines."""
    x0, y0, x1, y1 = lines
    for start, end, out in (
        ((x0, y0), (x1, y0), (0.0, -1.0)),
        ((x1, y0), (x1, y1), (1.0, 0.0)),
        ((x1, y1), (x0, y1), (0.0, 1.0)),
        ((x0, y1), (x0, y0), (-1.0, 0.0)),
    ):
        a, b = np.array(start), np.array(end)
        angle = float(np.arctan2(*(b - a)[::-1]))
        for t in brush.rng.uniform(0, 1, brush.rng.poisson(wear.tape * np.linalg.norm(b - a))):
            size = brush.rng.uniform((0.10, 0.045), (0.17, 0.055))
            at = a + t * (b - a) + np.array(out) * 0.06
            for _ in range(brush.rng.integers(1, 3)):  # two strips that overlap
                brush.fill(brush.box(at, size, angle + brush.rng.normal(0, 0.04)), (45, 38, 48))
                at = at + np.array(out) * 0.035 + brush.rng.normal(0, 0.03, 2)


def _add_crumbs(brush: _Brush, wear: Wear) -> None:
    """Add clusters of small yellowish and pale crumbs."""
    for _ in range(brush.rng.poisson(wear.crumbs * brush.square_metres)):
        centre = brush.anywhere()
        for bit in centre + brush.rng.normal(0, 0.15, (brush.rng.integers(4, 14), 2)):
            tint = (40, 26, -12) if brush.rng.random() < 0.4 else (30, 28, 26)
            size = np.full(2, brush.rng.uniform(0.006, 0.014))
            brush.shift(brush.lens(bit, size, 0.0), np.array(tint) * brush.rng.uniform(0.8, 2.0))


def _add_specks(brush: _Brush, wear: Wear) -> None:
    """Add pale specks, half as many dark specks, and a few smears."""
    rng = brush.rng
    for _ in range(rng.poisson(wear.specks * brush.square_metres)):
        across = 0.005 + rng.exponential(0.005)
        change = np.array([30, 26, 24]) * (1 + rng.exponential(0.6))
        if rng.random() < 1 / 3:
            change = -change
        elif rng.random() < 0.04:
            across, change = rng.uniform(0.04, 0.1), change * 0.6
        brush.shift(brush.lens(brush.anywhere(), (across * 1.6, across), rng.uniform(0, 3)), change)
