"""The room around the carpet, generated from a seed and painted on upright planes, from which the renderer samples.

The room does not need to be exact, because all of it has the label "other".
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray
from nao_course.sim.carpet import Bytes, Rectangle, cloud, halved
from nao_course.sim.furniture import Furniture, Workshop, choose_piece, sides, wall
from nao_course.sim.shapes import Eye, Float32


@dataclass(frozen=True, eq=False)
class Curtain:
    """A texture of walls or furniture on an upright plane along one side of the carpet.

    `start` (2,) is the plane's left end as seen from outside, m, `along` and `outwards` (2,) are unit vectors along it
    and away from the carpet, in the field frame. Each texture (rows, columns, 4) has colours times the covered area,
    and transparency (255 is fully transparent), from the top down; a second texture of half the size is for large
    distances.
    """

    start: FloatArray
    along: FloatArray
    outwards: FloatArray
    paint: tuple[Bytes, Bytes]


PIXEL = 0.008  # m: width of a texture's pixel
TOP, _BOTTOM = 2.2, -0.06  # m above the ground; the part below the ground is for shadows
_CURTAINS = (0.8, 0.3)  # m behind the carpet: distances of the planes with furniture, the farthest first
_EVERY = 8  # px: spacing of the rays that are computed
_GRAZING = np.float32(0.02)  # a plane that is seen at a smaller angle (rad) is skipped
# m of height per m of depth: a thing farther back is painted higher, as a NAO sees it from three metres away.
_DEPTH = 0.16


@lru_cache(maxsize=2)  # 12 MB each; asked for at every picture
def furnish(carpet: Rectangle, amount: float, seed: int) -> tuple[Curtain, ...]:
    """Put walls and furniture around a carpet (x_min, y_min, x_max, y_max); an `amount` of 1 is a full laboratory.

    The curtains are returned in the order in which they must be painted.
    """
    rng = np.random.default_rng([seed, 2])
    texture = 0.6 * cloud((600, 600), 0.25, rng) + 0.5 * cloud((600, 600), 0.05, rng)
    texture += 0.5 * cloud((600, 600), 0.015, rng)
    walls, layers = [], []
    for start, along, outwards, length, facing in sides(carpet):
        distance = rng.uniform(1.15, 1.5)
        things, tone = wall(Workshop(rng), start, along, outwards, distance, length, facing)
        canvas = _Canvas(start - along * 2 + outwards * distance, along, outwards, length + 4, texture, rng)
        canvas.fill(tone)
        canvas.add(things)
        walls.append(canvas.done())
        pieces = [Workshop(rng) for _ in _CURTAINS]
        crowd = rng.choice([0.2, 0.5, 1.1, 2.4])  # some sides are nearly empty, others full
        for _ in range(rng.poisson(3.0 * crowd * amount * length)):
            build, between = choose_piece(rng)
            away = rng.uniform(*between)
            w = pieces[int(np.argmin(np.abs(np.array(_CURTAINS) - away)))]
            w.place(
                start + along * rng.uniform(-0.8, length + 0.8) + outwards * away, facing + rng.normal(0, 0.3)
            )
            build(w)
        for away, w in zip(_CURTAINS, pieces, strict=True):
            canvas = _Canvas(start - along + outwards * away, along, outwards, length + 2, texture, rng)
            canvas.add(w.done(), shadows=True)
            layers.append((-away, canvas.done()))
    return (*walls, *(curtain for _, curtain in sorted(layers, key=lambda layer: layer[0])))


class _Canvas:
    """A curtain that is being painted with shaded polygons and their shadows."""

    def __init__(
        self,
        start: FloatArray,
        along: FloatArray,
        outwards: FloatArray,
        length: float,
        texture: Float32,
        rng: np.random.Generator,
    ) -> None:
        self.start, self.along, self.outwards, self.texture, self.rng = start, along, outwards, texture, rng
        shape = (round((TOP - _BOTTOM) / PIXEL), round(length / PIXEL))
        self.paint = np.zeros((*shape, 3), dtype=np.float32)
        self.covered = np.zeros(shape, dtype=np.float32)

    def fill(self, colour: npt.ArrayLike) -> None:
        """Fill the curtain with a colour that is darker towards the floor and varies along the wall."""
        rows, columns = self.covered.shape
        fading = np.linspace(1.1, 0.95, rows, dtype=np.float32)[:, None]
        waves = cv2.resize(
            self.rng.normal(1, 0.12, (2, 8)).astype(np.float32),
            (columns, rows),
            interpolation=cv2.INTER_CUBIC,
        )
        self.paint[:] = (fading * waves)[..., None] * np.asarray(colour, dtype=np.float32)
        self.covered[:] = 1

    def add(self, furniture: Furniture, shadows: bool = False) -> None:
        """Paint pieces, the farthest first."""
        flat = furniture.points[:, :2] - self.start
        depth = flat @ self.outwards
        across = flat @ self.along / PIXEL
        up = (TOP - furniture.points[:, 2] - _DEPTH * depth) / PIXEL
        outlines = np.split(np.column_stack([across, up]), furniture.starts[1:-1])
        far = (furniture.places - self.start) @ self.outwards
        last = -1
        for i in np.argsort(-far[furniture.piece], kind="stable"):
            piece = furniture.piece[i]
            if shadows and piece != last:
                mine = np.concatenate([outlines[k] for k in np.flatnonzero(furniture.piece == piece)])
                self._shadow(mine)
            last = piece
            self._shape(outlines[i], furniture.colours[i])

    def _shadow(self, points: FloatArray) -> None:
        """Darken the surroundings of the foot of a piece."""
        low, high = points.min(axis=0), points.max(axis=0)
        half = (high[0] - low[0]) / 2 + 6
        middle, foot = (low[0] + high[0]) / 2, min(high[1], TOP / PIXEL)
        found = self._window(np.array([middle - half, foot - 14]), np.array([middle + half, foot + 8]))
        if found is None:
            return
        (x0, y0, x1, y1), part = found
        across = (np.arange(x0, x1, dtype=np.float32) - np.float32(middle)) / np.float32(half)
        down = (np.arange(y0, y1, dtype=np.float32) - np.float32(foot)) / np.where(
            np.arange(y0, y1) < foot, 14, 8
        )
        depth = 0.75 * np.maximum(1 - across**2 - down[:, None] ** 2, 0)
        self._blend(part, depth.astype(np.float32), np.zeros(3, dtype=np.float32))

    def _shape(self, outline: FloatArray, colour: Bytes) -> None:
        """Paint a polygon with a random shade, a rough surface, and rounded edges if it has many corners."""
        found = self._window(outline.min(axis=0) - 1, outline.max(axis=0) + 2)
        if found is None:
            return
        (x0, y0, x1, y1), part = found
        mask = np.zeros((y1 - y0, x1 - x0), dtype=np.uint8)
        cv2.fillPoly(mask, [np.rint((outline - (x0, y0)) * 16).astype(np.int32)], 255, cv2.LINE_AA, 4)
        steep, aslant, rough = self.rng.normal((0.14, 0.0, 0.045), (0.1, 0.14, 0.03))
        shade = 1 + np.linspace(steep, -steep, y1 - y0, dtype=np.float32)[:, None]
        shade = shade + np.linspace(aslant, -aslant, x1 - x0, dtype=np.float32)
        i, j = self.rng.integers(0, 300, 2)
        patch = self.texture[i : i + y1 - y0, j : j + x1 - x0]
        shade[: patch.shape[0], : patch.shape[1]] += np.float32(abs(rough)) * patch
        if len(outline) > 8:
            inwards = cv2.distanceTransform(mask, cv2.DIST_L2, 3)
            shade *= np.float32(0.62) + np.float32(0.5) * np.sqrt(inwards / max(float(inwards.max()), 1.0))
        shown = np.maximum(shade, np.float32(0.1))[..., None] * colour.astype(np.float32)
        self._blend(part, mask * np.float32(1 / 255), shown.astype(np.float32))

    def _window(
        self, low: FloatArray, high: FloatArray
    ) -> tuple[tuple[int, int, int, int], tuple[slice, slice]] | None:
        """Return the pixels between two corners that are on the canvas, as (x0, y0, x1, y1) and as slices."""
        rows, columns = self.covered.shape
        x0, y0 = np.maximum(np.floor(low), 0).astype(int).tolist()
        x1, y1 = np.minimum(np.ceil(high), (columns, rows)).astype(int).tolist()
        return ((x0, y0, x1, y1), (slice(y0, y1), slice(x0, x1))) if x0 < x1 and y0 < y1 else None

    def _blend(self, part: tuple[slice, slice], area: Float32, colour: Float32) -> None:
        paint, covered = self.paint[part], self.covered[part]
        paint += area[..., None] * (colour - paint)
        covered += area * (1 - covered)

    def done(self) -> Curtain:
        """Return the finished curtain."""
        shows = cv2.convertScaleAbs(1 - self.covered, alpha=255)
        paint = np.dstack([cv2.convertScaleAbs(self.paint), shows])
        return Curtain(self.start, self.along, self.outwards, (paint, halved(paint)))


def _with_rim(grid: Float32) -> Float32:
    """Extend a grid (3, h, w) by one linearly extrapolated point on each side."""
    for axis in (1, 2):
        n = grid.shape[axis]
        first, second, before, last = (
            np.take(grid, [min(i, n - 1)], axis) for i in (0, 1, max(n - 2, 0), n - 1)
        )
        grid = np.concatenate([2 * first - second, grid, 2 * last - before], axis)
    return grid


def _along(direction: FloatArray, rays: Float32) -> Float32:
    """Return the components of rays (3, h, w) along a horizontal direction (2,)."""
    x, y = direction.astype(np.float32)
    return np.asarray(x * rays[0] + y * rays[1])


def paint_curtains(eye: Eye, curtains: tuple[Curtain, ...], picture: Bytes) -> None:
    """Paint a room over the upper rows of a picture (rows, W, 4).

    The points where rays meet a curtain are computed for every 8th pixel, and interpolated linearly between them.
    """
    rays = _with_rim(eye.field_rays(_EVERY))
    for curtain in curtains:
        offset = eye.ground_position - curtain.start
        distance = np.float32(-offset @ curtain.outwards)
        towards = _along(curtain.outwards, rays)
        if distance <= 0 or towards.max() < _GRAZING:
            continue
        reach = distance / np.maximum(towards, _GRAZING)
        sideways = _along(curtain.along, rays)
        level = int(distance / eye.view.focal[0] > 0.6 * PIXEL)
        paint, pixel = curtain.paint[level], np.float32(PIXEL * 2**level)
        across = (reach * sideways + np.float32(offset @ curtain.along)) / pixel
        down = (np.float32(TOP - eye.view.height) - reach * rays[2]) / pixel
        rows, columns = paint.shape[:2]
        inside = (
            (towards > _GRAZING) & (np.abs(across / columns - 0.5) < 0.5) & (np.abs(down / rows - 0.5) < 0.5)
        )
        window = [np.flatnonzero(inside.any(axis=1 - axis)) for axis in (0, 1)]
        if not len(window[0]):
            continue
        (r0, r1), (c0, c1) = (
            (max(int(each[0]) - 1, 1), min(int(each[-1]) + 1, n - 2))
            for each, n in zip(window, inside.shape, strict=True)
        )
        part = picture[(r0 - 1) * _EVERY : r1 * _EVERY, (c0 - 1) * _EVERY : c1 * _EVERY]
        if not part.size:
            continue
        size = ((c1 - c0 + 3) * _EVERY, (r1 - r0 + 3) * _EVERY)
        u, v = (
            cv2.resize(each[r0 - 1 : r1 + 2, c0 - 1 : c1 + 2], size)[_EVERY:, _EVERY:][
                : part.shape[0], : part.shape[1]
            ]
            for each in (across, down)
        )
        shown = cv2.remap(paint, u, v, cv2.INTER_LINEAR, borderValue=(0, 0, 0, 255))
        through = cv2.cvtColor(cv2.extractChannel(shown, 3), cv2.COLOR_GRAY2RGBA)
        cv2.multiply(part, through, dst=part, scale=1 / 255)
        cv2.add(part, shown, dst=part)
