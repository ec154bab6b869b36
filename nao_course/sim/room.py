"""The room a field lies in: a worn carpet, and the furniture, people and bags that stand behind it.

Everything is made from one seed. The carpet is a picture in the field frame with smaller copies for distance (a
mipmap); what stands behind it is flat polygons in space. None of it needs to be exact, for it is all labelled
"other" or "green": what is exact, lines and goals, is in shapes.py.
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
    """Make a carpet as pictures (rows along y, columns along x, RGB), each half the size of the one before.

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
    levels = [np.clip(np.rint(carpet), 0, 255).astype(np.uint8)]
    while len(levels) < _LEVELS:
        levels.append(cv2.resize(levels[-1], None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA))
    return tuple(levels)


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
            size = np.array([min(rng.exponential(0.11) + 0.02, 0.45), rng.uniform(0.012, 0.035)])
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


_BLACK, _DARK, _GREY, _STEEL = (8, 7, 8), (32, 30, 32), (84, 82, 80), (150, 150, 150)
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
    shirt = w.rng.choice([_RED, _DARK, (160, 156, 84), _WHITE, (44, 60, 104)])
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
    w.blob(0.0, 0.8, 0.46, 0.7, w.rng.choice([_RED, _DARK, _BLUE, _YELLOW]), 0.02)


def _bag(w: _Workshop) -> None:
    """A bag on the floor."""
    colour = w.rng.choice([_RED, _BLUE, _DARK, _BLACK, _BLACK, _RED])
    width = w.rng.uniform(0.3, 0.6)
    w.blob(0.0, 0.0, width, w.rng.uniform(0.2, 0.42), colour)
    w.blob(0.05, 0.03, width * 0.5, 0.15, np.array(colour) * 0.6, -0.02)
    w.limb([(-width / 4, 0.12), (width / 5, 0.24)], 0.04, _BLACK if w.rng.random() < 0.6 else _YELLOW, -0.02)


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
    _coats: (2.5, (0.5, 1.0)),
    _papers: (1.5, (0.1, 0.6)),
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


@lru_cache(maxsize=4)
def furnish(carpet: Rectangle, amount: float, seed: int) -> Furniture:
    """Put walls and furniture around a carpet (x_min, y_min, x_max, y_max); `amount` 1 is a crowded laboratory."""
    w = _Workshop(np.random.default_rng([seed, 2]))
    builders = list(_PIECES)
    often = [_PIECES[each][0] for each in builders]
    for start, along, outwards, length, facing in _sides(carpet):
        _wall(w, start, along, outwards, length, facing)
        for _ in range(w.rng.poisson(3.6 * amount * length)):
            build = builders[_chosen(w.rng, often)]
            away = w.rng.uniform(*_PIECES[build][1])
            w.place(
                start + along * w.rng.uniform(-0.6, length + 0.6) + outwards * away,
                facing + w.rng.normal(0, 0.3),
            )
            build(w)
    return w.done()


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
    w: _Workshop, start: FloatArray, along: FloatArray, outwards: FloatArray, length: float, facing: float
) -> None:
    """A wall with cupboards, boards, windows and posters."""
    distance = w.rng.uniform(1.15, 1.5)
    w.place(start + along * length / 2 + outwards * distance, facing)
    wide = length + 2 * 1.7
    tone = np.array([(167, 166, 163), (191, 192, 190), (150, 146, 138)][w.rng.integers(3)])
    w.plate(0.0, 0.0, wide, 3.0, tone)
    w.plate(0.0, 0.0, wide, 0.08, _GREY, -0.01)
    x = -wide / 2
    while x < wide / 2:
        width = w.rng.uniform(0.6, 1.4)
        middle, kind = x + width / 2, w.rng.integers(7)
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
        elif kind == 3:
            w.plate(middle, 0.7, 0.4, 0.6, w.rng.choice([_RED, _BLUE, _DARK, _CARTON, _YELLOW]), -0.02)
        elif kind == 4:
            w.plate(middle, 0.0, 0.85, 2.0, w.rng.choice([(144, 139, 132), (84, 66, 50)]), -0.01)  # a door
        elif kind == 5:
            w.plate(middle, 0.0, width, 1.6, _DARK, -0.01)  # a dark curtain
            for fold in np.arange(-0.4, 0.41, 0.16):
                w.plate(middle + fold * width, 0.0, 0.04 * width, 1.6, _BLACK, -0.02)
        x += width + w.rng.uniform(0.0, 0.4)


def paint_furniture(
    eye: Eye,
    furniture: Furniture,
    picture: Bytes,
    covered: Bytes | None = None,
    between: tuple[float, float] = (0.0, np.inf),
) -> None:
    """Paint furniture over a picture (H, W, 3), the farthest piece first.

    `covered` (H, W), where given, becomes 255 where something was painted, less at its edges; only pieces whose
    distance from the camera is within `between` (m) are painted.
    """
    if not len(furniture.colours):
        return
    seen, starts = eye.to_camera(furniture.points), furniture.starts
    pixels = np.rint(eye.pixels(seen) * 16).astype(np.int32)
    first = starts[:-1]
    all_ahead = np.minimum.reduceat(seen[:, 0], first) > 0.05
    some_ahead = np.maximum.reduceat(seen[:, 0], first) > 0.05
    low, high = np.minimum.reduceat(pixels, first), np.maximum.reduceat(pixels, first)
    in_view = np.all((high >= 0) & (low < np.array(eye.view.size) * 16), axis=1)
    away = np.hypot(*(furniture.places - eye.ground_position).T)
    wanted = (away > between[0]) & (away <= between[1])
    worth_painting = np.flatnonzero(some_ahead & (in_view | ~all_ahead) & wanted[furniture.piece])
    for i in worth_painting[np.argsort(-away[furniture.piece[worth_painting]], kind="stable")]:
        colour = furniture.colours[i].tolist()
        a, b = starts[i : i + 2]
        outline, fine = pixels[a:b], 4
        if not all_ahead[i]:
            clipped = eye.outlines([seen[a:b]])[0]
            if clipped is None:
                continue
            outline, fine = clipped, 0
        cv2.fillPoly(picture, [outline], colour, cv2.LINE_AA, fine)
        if covered is not None:
            cv2.fillPoly(covered, [outline], 255, cv2.LINE_AA, fine)


__all__ = ["TEXEL", "Furniture", "Wear", "carpet_levels", "furnish", "paint_furniture", "scatter"]
