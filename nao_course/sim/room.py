"""The room a field lies in: a worn carpet, and the furniture, people and bags that stand behind it.

Everything is made from one seed. The carpet is a picture in the field frame with smaller copies for distance (a
mipmap). The room is painted once on upright planes around the carpet, like a stage set, and looked up by ray; what lies
on the carpet is flat polygons in space. None of it needs to be exact, for it is all labelled "other" or "green": what
is exact, lines and goals, is in shapes.py.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, rotation_2d
from nao_course.sim.shapes import Eye, Float32

Bytes = npt.NDArray[np.uint8]
Colour = tuple[int, int, int]
Rectangle = tuple[float, float, float, float]

TEXEL = 0.005  # metres a pixel of the carpet's finest copy is wide
_LEVELS = 6
_STRIP = 2.0  # metres a strip of carpet is wide


# --- the carpet ---


@dataclass(frozen=True)
class Wear:
    """What is on a carpet.

    Parameters
    ----------
    grain : float
        Standard deviation of its brightness from fibre to fibre, in levels of 255.
    mottle : float
        The same from patch to patch, some decimetres wide.
    seams : float
        How open the joints between its strips are, 0 to 1.
    specks, crumbs : float
        Single specks, and clusters of crumbs, a square metre.
    tape : float
        Dark patches of tape a metre along the outer lines.
    """

    grain: float
    mottle: float
    seams: float
    specks: float
    crumbs: float
    tape: float


@lru_cache(maxsize=4)
def carpet_levels(
    extent: Rectangle, lines: Rectangle, colour: Colour, wear: Wear, seed: int
) -> tuple[Bytes, ...]:
    """Make a carpet as pictures (rows along y, columns along x, RGB and idle), each half the size of the one before.

    `extent` is the carpet and `lines` the rectangle of its outer lines: x_min, y_min, x_max, y_max in metres.
    """
    rng = np.random.default_rng([seed, 1])
    shape = tuple(int(np.ceil((extent[i + 2] - extent[i]) / TEXEL)) for i in (1, 0))
    light = wear.mottle * (0.7 * _cloud(shape, 0.6, rng) + 0.7 * _cloud(shape, 0.2, rng))
    light += wear.grain * (0.3 * _cloud(shape, 0.012, rng) + _cloud(shape, TEXEL, rng))
    warm = 0.9 * wear.mottle * _cloud(shape, 0.7, rng) + 0.12 * wear.grain * _cloud(shape, 0.01, rng)
    carpet: Float32 = np.stack([light + warm, light, light - warm], axis=2)
    carpet += np.array(colour, dtype=np.float32)
    brush = _Brush(carpet, extent, rng)
    _add_seams(brush, wear)
    _add_tape(brush, wear, lines)
    _add_crumbs(brush, wear)
    _add_specks(brush, wear)
    levels = [with_fourth(np.clip(np.rint(carpet), 0, 255).astype(np.uint8))]
    while len(levels) < _LEVELS:
        levels.append(_half(levels[-1]))
    return tuple(levels)


def with_fourth(picture: Bytes) -> Bytes:
    """RGB with an idle fourth channel: OpenCV's `remap` is 2.5 times as quick with four channels as with three."""
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2RGBA), dtype=np.uint8)


def _half(picture: Bytes) -> Bytes:
    return np.asarray(cv2.resize(picture, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA), dtype=np.uint8)


def _cloud(shape: tuple[int, ...], scale: float, rng: np.random.Generator) -> Float32:
    """Smooth random field with unit deviation whose patches are `scale` metres wide."""
    cells = max(scale / TEXEL, 1.0)
    small = rng.standard_normal([int(n / cells) + 3 for n in shape], dtype=np.float32)
    field = small if cells == 1 else cv2.resize(small, shape[::-1], interpolation=cv2.INTER_CUBIC)
    field = field[: shape[0], : shape[1]]
    return np.asarray(field / max(float(field.std()), 1e-6), dtype=np.float32)


@dataclass(frozen=True)
class _Brush:
    """Paints on a carpet (rows, columns, 3) in metres of the field frame."""

    carpet: Float32
    extent: Rectangle
    rng: np.random.Generator

    @property
    def square_metres(self) -> float:
        return (self.extent[2] - self.extent[0]) * (self.extent[3] - self.extent[1])

    def anywhere(self) -> FloatArray:
        """A random point (2,) on the carpet."""
        return self.rng.uniform(self.extent[:2], self.extent[2:])

    def fill(self, points: npt.ArrayLike, colour: npt.ArrayLike) -> None:
        """Fill a polygon (N, 2) of the field frame."""
        pixels = (np.asarray(points, dtype=float) - self.extent[:2]) / TEXEL - 0.5
        shades = np.clip(np.asarray(colour, dtype=float), 0, 255).tolist()
        cv2.fillPoly(self.carpet, [np.rint(pixels * 16).astype(np.int32)], shades, cv2.LINE_8, 4)

    def shift(self, points: npt.ArrayLike, change: npt.ArrayLike) -> None:
        """Fill a polygon with the carpet's colour there, changed."""
        pixel = ((np.mean(np.asarray(points), axis=0) - self.extent[:2]) / TEXEL).astype(int)
        column, row = np.clip(pixel, 0, np.array(self.carpet.shape[1::-1]) - 1)
        self.fill(points, self.carpet[row, column] + np.asarray(change, dtype=float))

    def box(self, centre: FloatArray, size: npt.ArrayLike, angle: float) -> FloatArray:
        """Corners (4, 2) of a turned rectangle."""
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) / 2 * np.asarray(size)
        return np.asarray(corners @ rotation_2d(angle).T + centre)

    def lens(self, centre: FloatArray, size: npt.ArrayLike, angle: float) -> FloatArray:
        """Corners (12, 2) of a turned, tapered patch."""
        t = np.linspace(0, 2 * np.pi, 12, endpoint=False)
        across = np.sin(t) * np.abs(np.sin(t)) * self.rng.uniform(0.7, 1.3, 12)
        points = np.column_stack([np.cos(t), across]) / 2 * np.asarray(size)
        return np.asarray(points @ rotation_2d(angle).T + centre)


def _add_seams(brush: _Brush, wear: Wear) -> None:
    """Joints of strips that lie along the field: a faint line, dark gaps, and here and there the white backing."""
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
            if rng.random() < 0.22:  # the edge curls up and shows its backing
                side = at + (rng.normal(0, 0.02), 0.018)
                white = rng.uniform(150, 255)
                brush.fill(brush.lens(side, size * (0.8, 0.45), slant), (white, white, white - 8))


def _add_tape(brush: _Brush, wear: Wear, lines: Rectangle) -> None:
    """Dark patches that touch the outer lines from outside."""
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
    """Clusters of small yellowish and pale bits."""
    for _ in range(brush.rng.poisson(wear.crumbs * brush.square_metres)):
        centre = brush.anywhere()
        for bit in centre + brush.rng.normal(0, 0.15, (brush.rng.integers(4, 14), 2)):
            tint = (40, 26, -12) if brush.rng.random() < 0.4 else (30, 28, 26)
            size = np.full(2, brush.rng.uniform(0.006, 0.014))
            brush.shift(brush.lens(bit, size, 0.0), np.array(tint) * brush.rng.uniform(0.8, 2.0))


def _add_specks(brush: _Brush, wear: Wear) -> None:
    """Pale specks, half as many dark ones, and a few rubbed smears."""
    rng = brush.rng
    for _ in range(rng.poisson(wear.specks * brush.square_metres)):
        across = 0.005 + rng.exponential(0.005)
        change = np.array([30, 26, 24]) * (1 + rng.exponential(0.6))
        if rng.random() < 1 / 3:
            change = -change
        elif rng.random() < 0.04:
            across, change = rng.uniform(0.04, 0.1), change * 0.6
        brush.shift(brush.lens(brush.anywhere(), (across * 1.6, across), rng.uniform(0, 3)), change)


# --- what stands behind the field ---


@dataclass(frozen=True)
class Furniture:
    """Flat polygons in space, back to front within each piece.

    Parameters
    ----------
    points : ndarray, shape (P, 3)
        All corners in the field frame, metres.
    starts : ndarray of int, shape (N + 1,)
        Where each polygon's corners begin.
    colours : ndarray of uint8, shape (N, 3)
        As the camera shows them.
    piece : ndarray of int, shape (N,)
        Which piece of furniture a polygon belongs to.
    places : ndarray, shape (pieces, 2)
        Where each piece stands.
    """

    points: FloatArray
    starts: npt.NDArray[np.intp]
    colours: Bytes
    piece: npt.NDArray[np.intp]
    places: FloatArray


class _Workshop:
    """Collects polygons of pieces that are built about their own origin and then put somewhere."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        self.polygons: list[tuple[FloatArray, Colour, int]] = []
        self.places: list[tuple[float, float]] = []
        self._at, self._facing = np.zeros(2), 0.0

    def place(self, at: FloatArray, facing: float) -> None:
        """Begin a piece at a point of the field frame; its front (negative own y) looks along `facing` (rad)."""
        self._at, self._facing = np.asarray(at, dtype=float), facing
        self.places.append((float(at[0]), float(at[1])))

    def polygon(self, points: FloatArray, colour: npt.ArrayLike) -> None:
        """Add a polygon (N, 3) in the piece's own frame: x to its right seen from the front, y away, z up."""
        array = np.asarray(points, dtype=float)
        turned = array[:, :2] @ rotation_2d(self._facing + np.pi / 2).T + self._at
        shown = np.clip(np.asarray(colour, dtype=float) + self.rng.normal(0, 3), 0, 255)
        r, g, b = np.rint(shown).astype(int).tolist()
        self.polygons.append((np.column_stack([turned, array[:, 2]]), (r, g, b), len(self.places) - 1))

    def plate(
        self, x: float, z: float, width: float, height: float, colour: npt.ArrayLike, y: float = 0.0
    ) -> None:
        """Add an upright rectangle with its lower middle at (x, z)."""
        left, right = x - width / 2, x + width / 2
        self.polygon(
            np.array([(left, y, z), (right, y, z), (right, y, z + height), (left, y, z + height)]), colour
        )

    def table(
        self, x: float, z: float, width: float, depth: float, colour: npt.ArrayLike, y: float = 0.0
    ) -> None:
        """Add a level rectangle with its front middle at (x, y)."""
        left, right = x - width / 2, x + width / 2
        self.polygon(
            np.array([(left, y, z), (right, y, z), (right, y + depth, z), (left, y + depth, z)]), colour
        )

    def box(
        self, x: float, z: float, size: tuple[float, float, float], colour: npt.ArrayLike, y: float = 0.0
    ) -> None:
        """Add a box (width, depth, height): its sides, top and front, lit from above."""
        width, depth, height = size
        shade = np.asarray(colour, dtype=float)
        for side in (-1, 1):
            edge = x + side * width / 2
            corners = [
                (edge, y, z),
                (edge, y + depth, z),
                (edge, y + depth, z + height),
                (edge, y, z + height),
            ]
            self.polygon(np.array(corners), shade * 0.75)
        self.table(x, z + height, width, depth, np.minimum(shade * 1.15, 255), y)
        self.plate(x, z, width, height, shade, y)

    def blob(
        self, x: float, z: float, width: float, height: float, colour: npt.ArrayLike, y: float = 0.0
    ) -> None:
        """Add an upright rounded patch with its lower middle at (x, z)."""
        angles = np.linspace(0, 2 * np.pi, 14, endpoint=False)
        radius = 1 + self.rng.normal(0, 0.08, 14)
        across, up = radius * np.cos(angles) * width / 2, radius * np.sin(angles) * height / 2
        middle = z + height / 2
        self.polygon(np.column_stack([x + across, np.full(14, y), np.maximum(middle + up, 0.0)]), colour)

    def limb(
        self, path: list[tuple[float, float]], width: float, colour: npt.ArrayLike, y: float = 0.0
    ) -> None:
        """Add an upright band of the given width along a path of (x, z)."""
        points = np.array(path, dtype=float)
        way = np.gradient(points, axis=0)
        normal = (
            np.column_stack([-way[:, 1], way[:, 0]]) / np.linalg.norm(way, axis=1, keepdims=True) * width / 2
        )
        outline = np.concatenate([points + normal, (points - normal)[::-1]])
        self.polygon(np.column_stack([outline[:, 0], np.full(len(outline), y), outline[:, 1]]), colour)

    def done(self) -> Furniture:
        """Return all that was built."""
        lengths = [len(points) for points, _, _ in self.polygons]
        return Furniture(
            points=np.concatenate([p for p, _, _ in self.polygons]) if lengths else np.empty((0, 3)),
            starts=np.concatenate([[0], np.cumsum(lengths)]).astype(np.intp),
            colours=np.array([c for _, c, _ in self.polygons], dtype=np.uint8).reshape(-1, 3),
            piece=np.array([k for _, _, k in self.polygons], dtype=np.intp),
            places=np.array(self.places, dtype=float).reshape(-1, 2),
        )


_BLACK, _DARK, _GREY, _STEEL = (3, 2, 3), (30, 28, 30), (84, 82, 80), (150, 150, 150)
_WHITE, _CREAM, _WOOD, _CARTON = (236, 234, 230), (226, 218, 209), (112, 78, 50), (150, 112, 72)
_RED, _YELLOW, _BLUE, _SKIN = (150, 30, 32), (176, 158, 40), (70, 110, 144), (176, 128, 100)


def _chair(w: _Workshop) -> None:
    """An office chair on a star of castors."""
    seat = _RED if w.rng.random() < 0.25 else _BLACK
    metal = _STEEL if w.rng.random() < 0.5 else _DARK
    for x, y in ((-0.27, 0.1), (0.27, 0.1), (0.0, -0.2), (-0.17, 0.4), (0.17, 0.4)):
        w.limb([(0.0, 0.13), (x, 0.07)], 0.04, metal, 0.1 + y / 2)
        w.blob(x, 0.0, 0.06, 0.06, _BLACK, y)
    w.limb([(0.0, 0.1), (0.0, 0.43)], 0.06, _DARK, 0.1)
    w.box(0.0, 0.43, (0.48, 0.45, 0.08), seat, -0.12)
    w.blob(0.0, 0.58, 0.46, 0.52, _BLACK, 0.35)
    for z in np.arange(0.66, 1.05, 0.09):
        w.plate(0.0, z, 0.3, 0.025, (54, 53, 56), 0.34)
    for side in (-0.27, 0.27):
        w.limb([(side, 0.45), (side, 0.68), (side * 0.95, 0.68)], 0.04, _BLACK, 0.1)


def _desk(w: _Workshop) -> None:
    """A desk with computers, cables and bags below and screens on it."""
    top = _WOOD if w.rng.random() < 0.6 else (144, 139, 132)
    w.plate(0.0, 0.0, 1.5, 0.7, w.rng.choice([_BLACK, _DARK, (54, 53, 56)]), 0.62)
    for side in (-0.7, 0.7):
        w.box(side, 0.0, (0.08, 0.6, 0.70), _DARK)
        w.box(side, 0.0, (0.1, 0.7, 0.05), _BLACK)
    for x in w.rng.uniform(-0.55, 0.55, w.rng.integers(1, 4)):
        w.box(x, 0.0, (0.19, 0.42, w.rng.uniform(0.3, 0.46)), w.rng.choice([_BLACK, _DARK, _GREY]), 0.1)
    for x in w.rng.uniform(-0.6, 0.6, 3):
        w.limb(
            [(x, 0.7), (x + w.rng.normal(0, 0.1), 0.3), (x + w.rng.normal(0, 0.2), 0.02)], 0.015, _STEEL, 0.05
        )
    w.box(0.0, 0.70, (1.6, 0.75, 0.04), top)
    for x in w.rng.uniform(-0.55, 0.55, w.rng.integers(1, 4)):
        w.limb([(x, 0.74), (x, 0.86)], 0.06, _BLACK, 0.4)
        w.plate(x, 0.84, 0.48, 0.33, _BLACK, 0.39)
        w.plate(x, 0.86, 0.44, 0.28, w.rng.choice([(80, 125, 160), _DARK, _BLACK, (121, 130, 140)]), 0.38)
    for x in w.rng.uniform(-0.7, 0.7, w.rng.integers(2, 7)):
        tone = w.rng.choice([_WHITE, _STEEL, _DARK, _BLACK, _RED, _BLUE])
        w.plate(x, 0.74, w.rng.uniform(0.05, 0.22), w.rng.uniform(0.03, 0.2), tone, 0.1)


def _sitter(w: _Workshop) -> None:
    """A person on a chair, seen from the front or the side."""
    _chair(w)
    trousers = w.rng.choice([_DARK, (40, 44, 60), (121, 110, 89)])
    shirt = w.rng.choice([_RED, _DARK, (150, 148, 140), _WHITE, (44, 60, 104)])
    lean = w.rng.uniform(-0.15, 0.15)
    for side in (-0.12, 0.12):
        knee = side + lean
        w.limb([(side, 0.52), (knee, 0.50), (knee * 1.3, 0.10)], 0.14, trousers, -0.2)
        w.blob(knee * 1.3, 0.0, 0.13, 0.11, _WHITE if w.rng.random() < 0.4 else _BLACK, -0.25)
    w.blob(0.0, 0.5, 0.42, 0.62, shirt, 0.05)
    for side in (-0.24, 0.24):
        w.limb([(side * 0.8, 1.0), (side, 0.78), (side * 0.4, 0.72)], 0.1, shirt, 0.0)
    w.blob(0.0, 1.1, 0.19, 0.26, _SKIN, 0.05)
    w.blob(0.0, 1.24, 0.21, 0.14, _DARK, 0.04)


def _stander(w: _Workshop) -> None:
    """A person's legs, and what is above them."""
    trousers = w.rng.choice([_DARK, (36, 42, 62), (121, 110, 89)])
    for side in (-0.1, 0.1):
        w.limb([(side, 0.85), (side * 1.2, 0.45), (side * 1.4, 0.08)], 0.15, trousers)
        w.blob(side * 1.5, 0.0, 0.14, 0.1, _WHITE if w.rng.random() < 0.4 else _BLACK, -0.03)
    w.blob(0.0, 0.8, 0.46, 0.7, w.rng.choice([_RED, _DARK, _BLUE, _BLACK]), 0.02)


def _bag(w: _Workshop) -> None:
    """A bag on the floor."""
    colour = w.rng.choice([_RED, _BLUE, _DARK, _BLACK, _BLACK, _RED])
    width = w.rng.uniform(0.3, 0.6)
    height = w.rng.uniform(0.2, 0.42)
    w.blob(0.0, 0.0, width, height, np.array(colour) * 0.7)
    for x, z in w.rng.uniform((-0.25, 0.1), (0.25, 0.45), (4, 2)):  # folds
        tone = np.array(colour) * w.rng.uniform(0.5, 1.4) + w.rng.uniform(0, 18)
        w.blob(x * width, z * height, width * 0.45, height * 0.4, tone, -0.01)
    w.limb([(-width / 4, 0.12), (width / 5, 0.24)], 0.04, _BLACK if w.rng.random() < 0.6 else _YELLOW, -0.02)


def _oddments(w: _Workshop) -> None:
    """Small things in a heap: boxes, bottles, tools, chargers."""
    tones = [_WHITE, _WHITE, _BLACK, _BLACK, _STEEL, _CARTON, _BLUE, _RED, _CREAM, _GREY]
    for x in w.rng.uniform(-0.4, 0.4, w.rng.integers(4, 9)):
        size, height = w.rng.uniform(0.03, 0.16), w.rng.uniform(0.03, 0.2)
        w.plate(x, 0.0, size, height, w.rng.choice(tones), w.rng.uniform(-0.1, 0.1))
        w.plate(x, height * 0.4, size * 0.6, height * 0.3, w.rng.choice(tones), -0.11)


def _coats(w: _Workshop) -> None:
    """Coats that hang from a rack or a chair."""
    w.limb([(-0.5, 1.5), (0.5, 1.5)], 0.03, _STEEL)
    for x in np.arange(-0.45, 0.46, 0.18):
        w.blob(
            x,
            w.rng.uniform(0.2, 0.6),
            0.26,
            w.rng.uniform(0.8, 1.2),
            w.rng.choice([_BLACK, _DARK, (40, 44, 60)]),
        )
    for side in (-0.5, 0.5):
        w.limb([(side, 0.0), (side, 1.5)], 0.03, _STEEL, -0.02)


def _papers(w: _Workshop) -> None:
    """White things on the floor: paper, plastic bags, parts of robots."""
    for x in w.rng.uniform(-0.35, 0.35, w.rng.integers(1, 4)):
        light = w.rng.uniform(200, 250)
        w.blob(x, 0.0, w.rng.uniform(0.08, 0.28), w.rng.uniform(0.04, 0.16), (light, light, light - 4))
    if w.rng.random() < 0.3:
        w.blob(0.1, 0.0, 0.25, 0.09, (96, 190, 180), -0.05)


def _robot(w: _Workshop) -> None:
    """A robot that lies on the floor: white shells with grey joints."""
    for x, size in ((-0.2, 0.14), (0.0, 0.17), (0.2, 0.13)):
        w.blob(x, 0.0, size, size, _WHITE, 0.02)
        w.blob(x + 0.1, 0.01, 0.08, 0.1, (121, 120, 122))
    w.blob(0.32, 0.0, 0.12, 0.12, (226, 226, 226))


def _cartons(w: _Workshop) -> None:
    """Boxes, or a printer."""
    colour = _CARTON if w.rng.random() < 0.6 else (191, 192, 190)
    z = 0.0
    for _ in range(w.rng.integers(1, 4)):
        height = w.rng.uniform(0.16, 0.34)
        w.box(w.rng.normal(0, 0.04), z, (w.rng.uniform(0.35, 0.6), 0.4, height), colour)
        w.plate(w.rng.normal(0, 0.1), z + height * 0.4, 0.2, 0.05, np.array(colour) * 0.5, -0.01)
        z += height
    w.plate(0.0, 0.04, 0.3, 0.08, (60, 96, 160), -0.01)


def _shelf(w: _Workshop) -> None:
    """A dark bookcase."""
    w.box(0.0, 0.0, (1.2, 0.35, 1.9), _DARK)
    for level in (0.12, 0.5, 0.88, 1.26):
        w.plate(0.0, level, 1.1, 0.32, _BLACK, -0.01)
        x = -0.52
        while x < 0.45 and level > 0.2:
            width = w.rng.uniform(0.05, 0.11)
            tone = w.rng.choice([(191, 190, 184), (121, 116, 110), _BLUE, _DARK, _BLACK, (112, 44, 34)])
            w.plate(x, level, width * 0.85, w.rng.uniform(0.2, 0.29), tone, -0.02)
            x += width + (w.rng.exponential(0.2) if w.rng.random() < 0.15 else 0)


def _cable(w: _Workshop) -> None:
    """A cable along the floor."""
    x = np.linspace(-0.7, 0.7, 8)
    y = 0.1 * np.cumsum(w.rng.normal(0, 0.5, 8))
    path = np.column_stack([x, y, np.full(8, 0.005)])
    back = path[::-1] + (0.0, 0.02, 0.0)
    w.polygon(np.concatenate([path, back]), _BLACK if w.rng.random() < 0.7 else _WHITE)


# What stands in the room: how often, and how far from the carpet's edge in metres.
_PIECES = {
    _chair: (6.0, (0.05, 0.7)),
    _desk: (6.0, (0.35, 0.8)),
    _sitter: (3.0, (0.1, 0.6)),
    _stander: (1.0, (0.1, 0.6)),
    _bag: (3.0, (0.1, 0.7)),
    _coats: (3.0, (0.25, 1.0)),
    _papers: (1.5, (0.1, 0.6)),
    _oddments: (3.0, (0.1, 0.7)),
    _robot: (0.8, (0.1, 0.5)),
    _cartons: (2.0, (0.2, 0.9)),
    _shelf: (2.5, (0.8, 1.0)),
    _cable: (2.5, (0.05, 0.5)),
}
# What lies on the carpet beyond the lines, and how often.
_LITTER = {_papers: 3.0, _robot: 2.5, _bag: 1.5, _chair: 1.5, _cable: 1.5}


def _chosen(rng: np.random.Generator, often: list[float]) -> int:
    weights = np.array(often)
    return int(rng.choice(len(weights), p=weights / weights.sum()))


def _sides(rectangle: Rectangle) -> Iterator[tuple[FloatArray, FloatArray, FloatArray, float, float]]:
    """Each side of a rectangle: start, direction, outwards, length, and the angle that looks inwards."""
    x0, y0, x1, y1 = rectangle
    corners = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        length = float(np.linalg.norm(end - start))
        along = (end - start) / length
        outwards = np.array([along[1], -along[0]])
        yield start, along, outwards, length, float(np.arctan2(-outwards[1], -outwards[0]))


@dataclass(frozen=True)
class Curtain:
    """A stage set: pieces painted on an upright plane along one side of the carpet.

    Parameters
    ----------
    start, along, outwards : ndarray, shape (2,)
        Its left end seen from outside, and the unit directions along it and away from the carpet; field frame.
    paint : tuple of ndarray of uint8, shape (rows, columns, 4)
        Colours times the area they cover, from the upper edge down; the fourth channel is idle. Then the same at
        half the size, for a look from afar.
    shows : tuple of ndarray of uint8, shape (rows, columns, 4)
        How much of what is behind shows through: 255 is all.
    """

    start: FloatArray
    along: FloatArray
    outwards: FloatArray
    paint: tuple[Bytes, Bytes]
    shows: tuple[Bytes, Bytes]


_PIXEL = 0.008  # metres a curtain's pixel is wide
_TOP, _BOTTOM = 2.2, -0.06  # metres above the ground; below it, shadows fall
_CURTAINS = (0.8, 0.3)  # metres behind the carpet at which pieces are painted, farthest first
_EVERY = 8  # pixels between those whose rays are computed
_GRAZING = np.float32(0.02)  # a curtain seen at a smaller slope is not seen
_DEPTH = (
    0.16  # what lies a metre farther back is painted so much higher, as from a NAO's eyes three metres off
)


@lru_cache(maxsize=4)
def furnish(carpet: Rectangle, amount: float, seed: int) -> tuple[Curtain, ...]:
    """Put walls and furniture around a carpet (x_min, y_min, x_max, y_max); `amount` 1 is a crowded laboratory.

    Curtains come in the order in which they are to be painted.
    """
    rng = np.random.default_rng([seed, 2])
    texture = 0.6 * _cloud((600, 600), 0.25, rng) + 0.5 * _cloud((600, 600), 0.05, rng)
    texture += 0.5 * _cloud((600, 600), 0.015, rng)
    builders = list(_PIECES)
    often = [_PIECES[each][0] for each in builders]
    walls, layers = [], []
    for start, along, outwards, length, facing in _sides(carpet):
        distance = rng.uniform(1.15, 1.5)
        wall, tone = _wall(_Workshop(rng), start, along, outwards, distance, length, facing)
        canvas = _Canvas(start - along * 2 + outwards * distance, along, outwards, length + 4, texture, rng)
        canvas.fill(tone)
        canvas.add(wall)
        walls.append(canvas.done())
        pieces = [_Workshop(rng) for _ in _CURTAINS]
        crowd = rng.choice([0.2, 0.5, 1.1, 2.4])  # some sides are nearly free, others dark with things
        for _ in range(rng.poisson(3.0 * crowd * amount * length)):
            build = builders[_chosen(rng, often)]
            away = rng.uniform(*_PIECES[build][1])
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
    """Paints polygons of a room on a curtain, shaded, with the shadows at their feet."""

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
        shape = (round((_TOP - _BOTTOM) / _PIXEL), round(length / _PIXEL))
        self.paint = np.zeros((*shape, 3), dtype=np.float32)
        self.covered = np.zeros(shape, dtype=np.float32)

    def fill(self, colour: npt.ArrayLike) -> None:
        """Cover everything, with light that fades towards the floor and to the sides."""
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
        across = flat @ self.along / _PIXEL
        up = (_TOP - furniture.points[:, 2] - _DEPTH * depth) / _PIXEL
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
        """Darken the floor, and what stands behind, around a piece's foot."""
        low, high = points.min(axis=0), points.max(axis=0)
        half = (high[0] - low[0]) / 2 + 6
        middle, foot = (low[0] + high[0]) / 2, min(high[1], _TOP / _PIXEL)
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
        """Paint one polygon: lighter above, darker to one side, rounded if it has no corners, and never quite even."""
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
        """Whole pixels between two corners, as far as they are on the canvas: x0, y0, x1, y1 and the slices."""
        rows, columns = self.covered.shape
        x0, y0 = np.maximum(np.floor(low), 0).astype(int).tolist()
        x1, y1 = np.minimum(np.ceil(high), (columns, rows)).astype(int).tolist()
        return ((x0, y0, x1, y1), (slice(y0, y1), slice(x0, x1))) if x0 < x1 and y0 < y1 else None

    def _blend(self, part: tuple[slice, slice], area: Float32, colour: Float32) -> None:
        paint, covered = self.paint[part], self.covered[part]
        paint += area[..., None] * (colour - paint)
        covered += area * (1 - covered)

    def done(self) -> Curtain:
        """Return the curtain."""
        shows = np.repeat(cv2.convertScaleAbs(1 - self.covered, alpha=255)[..., None], 4, axis=2)
        paint = with_fourth(cv2.convertScaleAbs(self.paint))
        (paint, paint_half), (shows, shows_half) = ((each, _half(each)) for each in (paint, shows))
        return Curtain(self.start, self.along, self.outwards, (paint, paint_half), (shows, shows_half))


def _with_rim(grid: Float32) -> Float32:
    """Continue a grid (3, h, w) by one point on each side, linearly."""
    for axis in (1, 2):
        n = grid.shape[axis]
        first, second, before, last = (
            np.take(grid, [min(i, n - 1)], axis) for i in (0, 1, max(n - 2, 0), n - 1)
        )
        grid = np.concatenate([2 * first - second, grid, 2 * last - before], axis)
    return grid


def paint_curtains(eye: Eye, curtains: tuple[Curtain, ...], picture: Bytes) -> None:
    """Paint a room over the upper rows of a picture (rows, W, 4).

    Where a ray meets a curtain is found for every 8th pixel, and beyond the picture's rim, and between them linearly.
    """
    rays = _with_rim(eye.field_rays(_EVERY))
    for curtain in curtains:
        offset = eye.ground_position - curtain.start
        distance = np.float32(-offset @ curtain.outwards)
        towards = np.tensordot(curtain.outwards.astype(np.float32), rays[:2], axes=1)
        if distance <= 0 or towards.max() < _GRAZING:
            continue
        reach = distance / np.maximum(towards, _GRAZING)
        sideways = np.tensordot(curtain.along.astype(np.float32), rays[:2], axes=1)
        level = int(distance / eye.view.focal[0] > 0.6 * _PIXEL)
        paint, shows, pixel = curtain.paint[level], curtain.shows[level], np.float32(_PIXEL * 2**level)
        across = (reach * sideways + np.float32(offset @ curtain.along)) / pixel
        down = (np.float32(_TOP - eye.view.height) - reach * rays[2]) / pixel
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
        through = cv2.remap(shows, u, v, cv2.INTER_LINEAR, borderValue=(255, 255, 255, 255))
        cv2.multiply(part, through, dst=part, scale=1 / 255)
        cv2.add(part, cv2.remap(paint, u, v, cv2.INTER_LINEAR), dst=part)


@lru_cache(maxsize=4)
def scatter(lines: Rectangle, border: float, amount: float, seed: int) -> Furniture:
    """Leave things on the carpet beyond the outer lines (x_min, y_min, x_max, y_max), `amount` for each metre."""
    w = _Workshop(np.random.default_rng([seed, 4]))
    builders, often = list(_LITTER), list(_LITTER.values())
    for start, along, outwards, length, facing in _sides(lines):
        for _ in range(w.rng.poisson(amount * length)):
            away = w.rng.uniform(0.45, 1.0) * border
            w.place(start + along * w.rng.uniform(0, length) + outwards * away, facing + w.rng.normal(0, 0.8))
            builders[_chosen(w.rng, often)](w)
    return w.done()


def _wall(
    w: _Workshop,
    start: FloatArray,
    along: FloatArray,
    outwards: FloatArray,
    distance: float,
    length: float,
    facing: float,
) -> tuple[Furniture, FloatArray]:
    """A wall's colour, and its cupboards, boards, windows and posters."""
    w.place(start + along * length / 2 + outwards * distance, facing)
    wide = length + 2 * 1.7
    tone = np.array([(236, 236, 233), (250, 250, 248), (214, 212, 206)][w.rng.integers(3)])
    w.plate(0.0, 0.0, wide, 0.08, _GREY, -0.01)
    x = -wide / 2
    while x < wide / 2:  # cupboards, or panels
        x += w.rng.uniform(0.35, 0.8)
        w.plate(x, 0.08, 0.02, w.rng.choice([0.75, 1.1, 2.1]), tone * 0.45, -0.005)
        w.plate(x + 0.06, 0.6, 0.025, 0.09, _GREY, -0.005)
    x = -wide / 2
    while x < wide / 2:
        width = w.rng.uniform(0.6, 1.4)
        middle, kind = x + width / 2, w.rng.integers(8)
        if kind == 0:
            w.plate(middle, 0.95, width * 0.95, 1.0, (250, 252, 254), -0.01)  # a bright window
            w.plate(middle, 0.92, width * 0.95, 0.05, _GREY, -0.02)
        elif kind == 1:
            for part in (-0.25, 0.25):  # cupboards
                w.plate(middle + part * width, 0.02, width * 0.47, 1.1, tone * 1.08, -0.01)
                w.plate(middle + part * width * 0.2, 0.6, 0.02, 0.1, _GREY, -0.02)
        elif kind == 2:
            w.plate(middle, 0.85, width * 0.9, 0.9, (236, 238, 240), -0.02)  # a whiteboard
            w.plate(middle, 0.83, width * 0.9, 0.03, _STEEL, -0.03)
            for at in w.rng.uniform((-0.4, 0.9), (0.4, 1.6), (14, 2)):
                w.plate(middle + at[0] * width, at[1], 0.08, 0.02, w.rng.choice([_RED, _BLUE, _DARK]), -0.03)
        elif kind == 3:
            w.plate(middle, 0.7, 0.4, 0.6, w.rng.choice([_RED, _BLUE, _DARK, _CARTON, _YELLOW, _GREY]), -0.02)
        elif kind == 4:
            w.plate(middle, 0.0, 0.85, 2.0, w.rng.choice([(144, 139, 132), (84, 66, 50)]), -0.01)  # a door
        elif kind == 5:
            w.plate(middle, 0.0, width, 1.6, _DARK, -0.01)  # a dark curtain
            for fold in np.arange(-0.4, 0.41, 0.16):
                w.plate(middle + fold * width, 0.0, 0.04 * width, 1.6, _BLACK, -0.02)
        x += width + w.rng.uniform(0.0, 0.4)
    return w.done(), tone


def outlines_in_view(
    eye: Eye, furniture: Furniture, between: tuple[float, float]
) -> list[tuple[npt.NDArray[np.int32], Bytes]]:
    """Outlines (N, 2) in sixteenths of pixels, and colours, of the pieces in view, the farthest first.

    Only pieces whose distance from the camera is within `between` (m) count.
    """
    away = np.hypot(*(furniture.places - eye.ground_position).T)
    near_enough = (away > between[0]) & (away <= between[1])
    if not near_enough.any():
        return []
    seen, starts = eye.to_camera(furniture.points), furniture.starts
    reached, inside = eye.reached(seen, starts[:-1])
    wanted = np.flatnonzero(reached & near_enough[furniture.piece])
    found = []
    for i in wanted[np.argsort(-away[furniture.piece[wanted]], kind="stable")]:
        polygon = seen[starts[i] : starts[i + 1]]
        if inside[i]:
            outline = np.rint(eye.pixels(polygon) * 16).astype(np.int32)
        else:
            clipped = eye.outlines([polygon])[0]
            if clipped is None:
                continue
            outline = clipped * 16
        found.append((outline, furniture.colours[i]))
    return found


__all__ = [
    "TEXEL",
    "Curtain",
    "Furniture",
    "Wear",
    "carpet_levels",
    "furnish",
    "outlines_in_view",
    "paint_curtains",
    "scatter",
]
