"""The room a field lies in: a worn carpet, and the furniture, people and bags that stand behind it.

Everything is made from one seed. The carpet is a picture in the field frame with smaller copies for distance (a
mipmap); what stands behind it is flat polygons in space. None of it needs to be exact, for it is all labelled
"other" or "green": what is exact, lines and goals, is in shapes.py.
"""

from __future__ import annotations

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

TEXEL = 0.006  # metres a pixel of the carpet's finest copy is wide
_LEVELS = 6


# --- the carpet ---


@dataclass(frozen=True)
class Wear:
    """What is on a carpet.

    Parameters
    ----------
    mottle : float
        Standard deviation of its brightness over patches of some decimetres and of some centimetres, in levels.
    seams : float
        How dark the joints between its strips are: 1 is black.
    specks, crumbs : float
        Light specks of a centimetre, and clusters of crumbs, a square metre.
    tape : float
        Dark patches of tape on the whole carpet.
    """

    mottle: float
    seams: float
    specks: float
    crumbs: float
    tape: float


@lru_cache(maxsize=4)
def carpet_levels(extent: Rectangle, colour: Colour, wear: Wear, seed: int) -> tuple[Bytes, ...]:
    """Make a carpet as pictures (rows along y, columns along x, RGB), each half the size of the one before."""
    rng = np.random.default_rng([seed, 1])
    x0, y0, x1, y1 = extent
    shape = (int(np.ceil((y1 - y0) / TEXEL)), int(np.ceil((x1 - x0) / TEXEL)))
    light = np.zeros(shape, dtype=np.float32)
    for scale, share in ((0.45, 0.7), (0.12, 0.5), (0.02, 0.5)):
        light += share * _cloud(shape, scale, rng)
    light *= wear.mottle
    warm = 0.3 * wear.mottle * _cloud(shape, 0.5, rng)
    carpet = np.stack([light + warm, light, light - 0.5 * warm], axis=2) + np.array(colour, dtype=np.float32)
    for add in (_add_seams, _add_tape, _add_crumbs, _add_specks):
        add(carpet, wear, rng)
    finest = np.clip(np.rint(carpet), 0, 255).astype(np.uint8)
    levels = [finest]
    while len(levels) < _LEVELS:
        levels.append(cv2.resize(levels[-1], None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA))
    return tuple(levels)


def _cloud(shape: tuple[int, int], scale: float, rng: np.random.Generator) -> Float32:
    """Smooth random field with unit deviation whose patches are `scale` metres wide."""
    cells = max(scale / TEXEL, 1.0)
    small = rng.standard_normal([int(n / cells) + 3 for n in shape], dtype=np.float32)
    field = cv2.resize(small, shape[::-1], interpolation=cv2.INTER_CUBIC)
    return np.asarray(field / max(float(field.std()), 1e-6), dtype=np.float32)


def _add_seams(carpet: Float32, wear: Wear, rng: np.random.Generator) -> None:
    """Dark, broken joints of strips that lie along the field, and one across."""
    if not wear.seams:
        return
    rows, columns = carpet.shape[:2]
    mask = np.zeros((rows, columns), dtype=np.uint8)
    for row in np.arange(0.13, 1.0, 0.27) * rows:
        _draw_seam(mask, (0, row), (columns, row), rng)
    column = rng.uniform(0.3, 0.7) * columns
    _draw_seam(mask, (column, 0), (column, rows), rng)
    carpet *= 1 - wear.seams * cv2.GaussianBlur(mask, (3, 3), 0)[..., None] / np.float32(255)


def _draw_seam(
    mask: Bytes, start: tuple[float, float], end: tuple[float, float], rng: np.random.Generator
) -> None:
    """A wavering line in pieces, faint in most places and open in some."""
    pieces = 40
    t = np.linspace(0, 1, pieces + 1)[:, None]
    path = np.array(start) + t * (np.array(end) - start) + rng.normal(0, 1.5, (pieces + 1, 2))
    open_here = np.convolve(rng.standard_normal(pieces), np.ones(4) / 2, "same")
    for a, b, how in zip(path[:-1], path[1:], open_here, strict=True):
        strength = int(np.clip(60 + 110 * how, 0, 255))
        thickness = 1 if how < 1 else 2
        cv2.line(mask, _point(a), _point(b), strength, thickness)


def _point(xy: FloatArray) -> tuple[int, int]:
    return round(float(xy[0])), round(float(xy[1]))


def _add_tape(carpet: Float32, wear: Wear, rng: np.random.Generator) -> None:
    rows, columns = carpet.shape[:2]
    for _ in range(rng.poisson(wear.tape) if wear.tape else 0):
        centre, angle = rng.uniform((0, 0), (columns, rows)), rng.choice([0.0, 90.0]) + rng.normal(0, 8)
        size = rng.uniform((0.10, 0.05), (0.22, 0.09)) / TEXEL
        box = cv2.boxPoints((tuple(centre), tuple(size), float(angle)))
        cv2.fillPoly(carpet, [np.rint(box).astype(np.int32)], (34, 48, 42))


def _add_crumbs(carpet: Float32, wear: Wear, rng: np.random.Generator) -> None:
    """Clusters of small yellowish and brown bits."""
    rows, columns = carpet.shape[:2]
    clusters = rng.poisson(wear.crumbs * rows * columns * TEXEL**2) if wear.crumbs else 0
    for _ in range(clusters):
        centre = rng.uniform((0, 0), (columns, rows))
        for bit in centre + rng.normal(0, 0.06 / TEXEL, (rng.integers(2, 9), 2)):
            colour = np.array([150, 150, 95], dtype=np.float32) + rng.normal(0, 22)
            cv2.circle(carpet, _point(bit), 1, colour.tolist(), -1)


def _add_specks(carpet: Float32, wear: Wear, rng: np.random.Generator) -> None:
    """Light specks: threads, paper, worn spots."""
    rows, columns = carpet.shape[:2]
    for _ in range(rng.poisson(wear.specks * rows * columns * TEXEL**2) if wear.specks else 0):
        x, y = rng.uniform((0, 0), (columns, rows))
        size = rng.exponential(0.005) + 0.003
        shade = rng.uniform(0.35, 1.0)
        axes = (max(round(size / TEXEL), 1), max(round(0.6 * size / TEXEL), 1))
        i, j = int(y), int(x)
        colour = carpet[i, j] + shade * (np.array([205, 222, 205], dtype=np.float32) - carpet[i, j])
        cv2.ellipse(carpet, (j, i), axes, float(rng.uniform(0, 180)), 0, 360, colour.tolist(), -1)


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


_DARK, _BLACK, _GREY, _STEEL = (42, 40, 42), (18, 18, 20), (120, 120, 122), (150, 152, 156)
_WHITE, _CREAM, _WOOD, _CARTON = (238, 238, 236), (222, 212, 196), (124, 88, 58), (172, 130, 88)
_RED, _YELLOW, _BLUE, _SKIN = (186, 34, 36), (206, 186, 40), (66, 96, 138), (196, 146, 118)


def _chair(w: _Workshop) -> None:
    """An office chair on a star of castors."""
    seat = _RED if w.rng.random() < 0.25 else _BLACK
    for x, y in ((-0.27, 0.1), (0.27, 0.1), (0.0, -0.2), (-0.17, 0.4), (0.17, 0.4)):
        w.limb([(0.0, 0.13), (x, 0.07)], 0.04, _STEEL, 0.1 + y / 2)
        w.blob(x, 0.0, 0.06, 0.06, _BLACK, y)
    w.limb([(0.0, 0.1), (0.0, 0.43)], 0.06, _DARK, 0.1)
    w.box(0.0, 0.43, (0.48, 0.45, 0.08), seat, -0.12)
    w.blob(0.0, 0.58, 0.44, 0.52, _DARK, 0.35)
    w.blob(0.0, 0.63, 0.36, 0.42, (70, 70, 74), 0.34)
    for side in (-0.27, 0.27):
        w.limb([(side, 0.45), (side, 0.68), (side * 0.95, 0.68)], 0.04, _BLACK, 0.1)


def _desk(w: _Workshop) -> None:
    """A desk with a computer below and a screen on it."""
    top = _WOOD if w.rng.random() < 0.6 else (196, 190, 182)
    for side in (-0.7, 0.7):
        w.box(side, 0.0, (0.08, 0.6, 0.70), _DARK)
        w.box(side, 0.0, (0.1, 0.7, 0.05), _BLACK)
    if w.rng.random() < 0.7:
        w.box(w.rng.uniform(-0.4, 0.4), 0.0, (0.2, 0.42, 0.44), _DARK, 0.1)
    w.plate(0.0, 0.35, 1.3, 0.33, (86, 84, 82), 0.55)
    w.box(0.0, 0.70, (1.6, 0.75, 0.04), top)
    for x in w.rng.uniform(-0.55, 0.55, w.rng.integers(1, 3)):
        w.limb([(x, 0.74), (x, 0.86)], 0.06, _BLACK, 0.4)
        w.plate(x, 0.84, 0.48, 0.33, _BLACK, 0.39)
        w.plate(x, 0.86, 0.44, 0.28, w.rng.choice([(92, 140, 190), (40, 44, 50), (150, 170, 190)]), 0.38)
    if w.rng.random() < 0.6:
        w.plate(w.rng.uniform(-0.5, 0.5), 0.74, 0.3, 0.06, _WHITE, 0.1)


def _sitter(w: _Workshop) -> None:
    """A person on a chair, seen from the front or the side."""
    _chair(w)
    trousers = w.rng.choice([_DARK, (52, 56, 74), (150, 138, 106)])
    shirt = w.rng.choice([_RED, (60, 60, 66), (196, 190, 96), _WHITE, (50, 70, 120)])
    lean = w.rng.uniform(-0.15, 0.15)
    for side in (-0.12, 0.12):
        knee = side + lean
        w.limb([(side, 0.52), (knee, 0.50), (knee * 1.3, 0.10)], 0.14, trousers, -0.2)
        w.blob(knee * 1.3, 0.0, 0.13, 0.11, _WHITE if w.rng.random() < 0.3 else _BLACK, -0.25)
    w.blob(0.0, 0.5, 0.42, 0.62, shirt, 0.05)
    for side in (-0.24, 0.24):
        w.limb([(side * 0.8, 1.0), (side, 0.78), (side * 0.4, 0.72)], 0.1, shirt, 0.0)
    w.blob(0.0, 1.1, 0.19, 0.26, _SKIN, 0.05)
    w.blob(0.0, 1.24, 0.21, 0.14, _DARK, 0.04)


def _stander(w: _Workshop) -> None:
    """A person's legs, and what is above them."""
    trousers = w.rng.choice([_DARK, (46, 52, 78), (134, 122, 96)])
    for side in (-0.1, 0.1):
        w.limb([(side, 0.85), (side * 1.2, 0.45), (side * 1.4, 0.08)], 0.15, trousers)
        w.blob(side * 1.5, 0.0, 0.14, 0.1, _WHITE if w.rng.random() < 0.4 else _BLACK, -0.03)
    w.blob(0.0, 0.8, 0.46, 0.7, w.rng.choice([_RED, _DARK, _BLUE, _YELLOW]), 0.02)


def _bag(w: _Workshop) -> None:
    """A bag or coat on the floor."""
    colour = w.rng.choice([_RED, _BLUE, _DARK, _BLACK, _BLACK, _RED])
    width = w.rng.uniform(0.3, 0.7)
    w.blob(0.0, 0.0, width, w.rng.uniform(0.2, 0.42), colour)
    w.limb([(-width / 4, 0.12), (width / 5, 0.24)], 0.05, _BLACK if w.rng.random() < 0.6 else _YELLOW, -0.02)


def _papers(w: _Workshop) -> None:
    """White things on the floor: paper, plastic bags, parts of robots."""
    for x in w.rng.uniform(-0.4, 0.4, w.rng.integers(1, 5)):
        light = w.rng.uniform(205, 250)
        w.blob(x, 0.0, w.rng.uniform(0.08, 0.3), w.rng.uniform(0.04, 0.16), (light, light, light - 4))
    if w.rng.random() < 0.4:
        w.blob(0.1, 0.0, 0.25, 0.09, (96, 190, 180), -0.05)


def _cartons(w: _Workshop) -> None:
    """Boxes, or a printer."""
    colour = _CARTON if w.rng.random() < 0.5 else (212, 212, 210)
    z = 0.0
    for _ in range(w.rng.integers(1, 4)):
        height = w.rng.uniform(0.16, 0.34)
        w.box(w.rng.normal(0, 0.04), z, (w.rng.uniform(0.35, 0.6), 0.4, height), colour)
        z += height
    w.plate(0.0, 0.04, 0.3, 0.08, (60, 96, 160), -0.01)


def _shelf(w: _Workshop) -> None:
    """A dark bookcase."""
    w.box(0.0, 0.0, (1.2, 0.35, 1.9), (38, 40, 48))
    for level in (0.12, 0.5, 0.88, 1.26):
        w.plate(0.0, level, 1.1, 0.32, (24, 24, 28), -0.01)
        x = -0.52
        while x < 0.45 and level > 0.2:
            width = w.rng.uniform(0.04, 0.09)
            tone = w.rng.choice(
                [(206, 204, 196), (150, 148, 140), _BLUE, _DARK, (168, 60, 50), (208, 188, 120)]
            )
            w.plate(x, level, width * 0.9, w.rng.uniform(0.2, 0.29), tone, -0.02)
            x += width + (w.rng.exponential(0.15) if w.rng.random() < 0.1 else 0)


def _cable(w: _Workshop) -> None:
    """A cable along the floor."""
    x = np.linspace(-0.7, 0.7, 8)
    y = 0.1 * np.cumsum(w.rng.normal(0, 0.5, 8))
    path = np.column_stack([x, y, np.full(8, 0.005)])
    back = path[::-1] + (0.0, 0.015, 0.0)
    w.polygon(np.concatenate([path, back]), _BLACK)


_PIECES = (_chair, _desk, _sitter, _stander, _bag, _papers, _cartons, _shelf, _cable)
_OFTEN = np.array([5, 4, 3, 1.2, 3, 3, 2.5, 1.5, 2])
_FROM_CARPET = {
    _desk: (0.5, 0.9),
    _shelf: (0.9, 1.1),
    _cable: (0.1, 0.5),
    _papers: (0.08, 0.6),
    _bag: (0.2, 0.8),
}


@lru_cache(maxsize=4)
def furnish(extent: Rectangle, amount: float, seed: int) -> Furniture:
    """Put walls and furniture around a carpet (x_min, y_min, x_max, y_max); `amount` 1 is a crowded laboratory."""
    rng = np.random.default_rng([seed, 2])
    w = _Workshop(rng)
    x0, y0, x1, y1 = extent
    corners = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
    for i, start in enumerate(corners):
        end = corners[(i + 1) % 4]
        along = (end - start) / np.linalg.norm(end - start)
        outwards = np.array([along[1], -along[0]])
        facing = float(np.arctan2(*-outwards[::-1]))
        length = float(np.linalg.norm(end - start))
        _wall(w, start, along, outwards, length, facing)
        for _ in range(rng.poisson(2.6 * amount * length)):
            build = _PIECES[rng.choice(len(_PIECES), p=_OFTEN / _OFTEN.sum())]
            away = rng.uniform(*_FROM_CARPET.get(build, (0.25, 0.9)))
            at = start + along * rng.uniform(-0.6, length + 0.6) + outwards * away
            w.place(at, facing + rng.normal(0, 0.3))
            build(w)
    return w.done()


def _wall(
    w: _Workshop, start: FloatArray, along: FloatArray, outwards: FloatArray, length: float, facing: float
) -> None:
    """A wall with cupboards, boards, windows and posters."""
    distance = w.rng.uniform(1.25, 1.7)
    w.place(start + along * length / 2 + outwards * distance, facing)
    wide = length + 2 * 1.7
    w.plate(0.0, 0.0, wide, 3.0, w.rng.choice([_WHITE, (228, 226, 220), _CREAM]))
    w.plate(0.0, 0.0, wide, 0.1, (150, 146, 140), -0.01)
    x = -wide / 2
    while x < wide / 2:
        width = w.rng.uniform(0.7, 1.6)
        kind = w.rng.integers(6)
        middle = x + width / 2
        if kind == 0:
            w.plate(middle, 0.95, width * 0.95, 1.0, (250, 252, 254), -0.01)  # a bright window
            w.plate(middle, 0.92, width * 0.95, 0.05, _GREY, -0.02)
        elif kind == 1:
            w.plate(middle, 0.0, width * 0.95, 1.1, (240, 238, 232), -0.01)  # cupboards
            w.plate(middle, 0.1, 0.012, 0.95, (170, 168, 160), -0.02)
        elif kind == 2:
            w.plate(middle, 0.85, width * 0.9, 0.9, (242, 244, 246), -0.02)  # a whiteboard
            w.plate(middle, 0.83, width * 0.9, 0.03, _STEEL, -0.03)
        elif kind == 3:
            w.plate(middle, 0.9, 0.4, 0.6, w.rng.choice([_RED, _BLUE, _DARK, _CARTON, _YELLOW]), -0.02)
        elif kind == 4:
            w.plate(middle, 0.0, 0.85, 2.0, w.rng.choice([(206, 200, 186), (104, 84, 64)]), -0.01)  # a door
        x += width + w.rng.uniform(0.1, 0.6)


def paint_furniture(eye: Eye, furniture: Furniture, picture: Bytes) -> None:
    """Paint furniture over a picture (H, W, 3), the farthest piece first."""
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
    worth_painting = np.flatnonzero(some_ahead & (in_view | ~all_ahead))
    for i in worth_painting[np.argsort(-away[furniture.piece[worth_painting]], kind="stable")]:
        colour = furniture.colours[i].tolist()
        a, b = starts[i : i + 2]
        if all_ahead[i]:
            cv2.fillPoly(picture, [pixels[a:b]], colour, cv2.LINE_AA, 4)
        elif (outline := eye.outlines([seen[a:b]])[0]) is not None:
            cv2.fillPoly(picture, [outline], colour, cv2.LINE_AA)


__all__ = ["TEXEL", "Furniture", "Wear", "carpet_levels", "furnish", "paint_furniture"]
