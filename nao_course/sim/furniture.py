"""The furniture, people and bags of a room, as flat polygons in space, made from a seed.

None of it needs to be exact, for it is all labelled "other"; what is exact, lines and goals, is in shapes.py.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, rotation_2d
from nao_course.sim.carpet import Bytes, Colour, Rectangle
from nao_course.sim.shapes import Eye


@dataclass(frozen=True, eq=False)
class Furniture:
    """Flat polygons in space, back to front within each piece.

    The corners (P, 3) of all polygons are in the field frame, m, `starts` (N + 1,) are the indices of each polygon's
    first corner, `colours` (N, 3) are RGB, `piece` (N,) is the piece that each polygon belongs to, and `places`
    (pieces, 2) are the pieces' positions in the field frame, m.
    """

    points: FloatArray
    starts: npt.NDArray[np.intp]
    colours: Bytes
    piece: npt.NDArray[np.intp]
    places: FloatArray


class Workshop:
    """A builder that collects the polygons of pieces of furniture, which are built in their own frames."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        self.polygons: list[tuple[FloatArray, Colour, int]] = []
        self.places: list[tuple[float, float]] = []
        self._at, self._facing = np.zeros(2), 0.0

    def place(self, at: FloatArray, facing: float) -> None:
        """Start a piece at a point of the field frame; its front (negative y) points in the direction `facing`, rad."""
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
        """Add an upright rectangle whose lower edge has its midpoint at (x, z)."""
        left, right = x - width / 2, x + width / 2
        self.polygon(
            np.array([(left, y, z), (right, y, z), (right, y, z + height), (left, y, z + height)]), colour
        )

    def table(
        self, x: float, z: float, width: float, depth: float, colour: npt.ArrayLike, y: float = 0.0
    ) -> None:
        """Add a level rectangle whose front edge has its midpoint at (x, y)."""
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
        """Add an upright rounded patch whose lowest point is at (x, z)."""
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
        """Return all pieces."""
        lengths = [len(points) for points, _, _ in self.polygons]
        return Furniture(
            points=np.concatenate([p for p, _, _ in self.polygons]) if lengths else np.empty((0, 3)),
            starts=np.concatenate([[0], np.cumsum(lengths)]).astype(np.intp),
            colours=np.array([c for _, c, _ in self.polygons], dtype=np.uint8).reshape(-1, 3),
            piece=np.array([k for _, _, k in self.polygons], dtype=np.intp),
            places=np.array(self.places, dtype=float).reshape(-1, 2),
        )


Builder = Callable[[Workshop], None]

_A4 = (0.210, 0.297)  # m

_BLACK, _DARK, _GREY, _STEEL = (3, 2, 3), (30, 28, 30), (84, 82, 80), (150, 150, 150)
_WHITE, _CREAM, _WOOD, _CARTON = (236, 234, 230), (226, 218, 209), (112, 78, 50), (150, 112, 72)
_RED, _YELLOW, _BLUE, _SKIN = (150, 30, 32), (176, 158, 40), (70, 110, 144), (176, 128, 100)


def _chair(w: Workshop) -> None:
    """Build an office chair on castors."""
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


def _desk(w: Workshop) -> None:
    """Build a desk with screens, and with computers, cables and bags below it."""
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


def _sitter(w: Workshop) -> None:
    """Build a person on a chair."""
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


def _stander(w: Workshop) -> None:
    """Build a standing person."""
    trousers = w.rng.choice([_DARK, (36, 42, 62), (121, 110, 89)])
    for side in (-0.1, 0.1):
        w.limb([(side, 0.85), (side * 1.2, 0.45), (side * 1.4, 0.08)], 0.15, trousers)
        w.blob(side * 1.5, 0.0, 0.14, 0.1, _WHITE if w.rng.random() < 0.4 else _BLACK, -0.03)
    w.blob(0.0, 0.8, 0.46, 0.7, w.rng.choice([_RED, _DARK, _BLUE, _BLACK]), 0.02)


def _bag(w: Workshop) -> None:
    """Build a bag on the floor."""
    colour = w.rng.choice([_RED, _BLUE, _DARK, _BLACK, _BLACK, _RED])
    width = w.rng.uniform(0.3, 0.6)
    height = w.rng.uniform(0.2, 0.42)
    w.blob(0.0, 0.0, width, height, np.array(colour) * 0.7)
    for x, z in w.rng.uniform((-0.25, 0.1), (0.25, 0.45), (4, 2)):  # folds
        tone = np.array(colour) * w.rng.uniform(0.5, 1.4) + w.rng.uniform(0, 18)
        w.blob(x * width, z * height, width * 0.45, height * 0.4, tone, -0.01)
    w.limb([(-width / 4, 0.12), (width / 5, 0.24)], 0.04, _BLACK if w.rng.random() < 0.6 else _YELLOW, -0.02)


def _oddments(w: Workshop) -> None:
    """Build a heap of small things: boxes, bottles, tools and chargers."""
    tones = [_WHITE, _WHITE, _BLACK, _BLACK, _STEEL, _CARTON, _BLUE, _RED, _CREAM, _GREY]
    for x in w.rng.uniform(-0.4, 0.4, w.rng.integers(4, 9)):
        size, height = w.rng.uniform(0.03, 0.16), w.rng.uniform(0.03, 0.2)
        w.plate(x, 0.0, size, height, w.rng.choice(tones), w.rng.uniform(-0.1, 0.1))
        w.plate(x, height * 0.4, size * 0.6, height * 0.3, w.rng.choice(tones), -0.11)


def _coats(w: Workshop) -> None:
    """Build coats on a rack or a chair."""
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


def _papers(w: Workshop) -> None:
    """Build white things on the floor: paper, plastic bags and parts of robots."""
    for x in w.rng.uniform(-0.35, 0.35, w.rng.integers(1, 4)):
        light = w.rng.uniform(200, 250)
        w.blob(x, 0.0, w.rng.uniform(0.08, 0.28), w.rng.uniform(0.04, 0.16), (light, light, light - 4))
    if w.rng.random() < 0.3:
        w.blob(0.1, 0.0, 0.25, 0.09, (96, 190, 180), -0.05)


def _robot(w: Workshop) -> None:
    """Build a robot that lies on the floor, with white shells and grey joints."""
    for x, size in ((-0.2, 0.14), (0.0, 0.17), (0.2, 0.13)):
        w.blob(x, 0.0, size, size, _WHITE, 0.02)
        w.blob(x + 0.1, 0.01, 0.08, 0.1, (121, 120, 122))
    w.blob(0.32, 0.0, 0.12, 0.12, (226, 226, 226))


def _cartons(w: Workshop) -> None:
    """Build boxes or a printer."""
    colour = _CARTON if w.rng.random() < 0.6 else (191, 192, 190)
    z = 0.0
    for _ in range(w.rng.integers(1, 4)):
        height = w.rng.uniform(0.16, 0.34)
        w.box(w.rng.normal(0, 0.04), z, (w.rng.uniform(0.35, 0.6), 0.4, height), colour)
        w.plate(w.rng.normal(0, 0.1), z + height * 0.4, 0.2, 0.05, np.array(colour) * 0.5, -0.01)
        z += height
    w.plate(0.0, 0.04, 0.3, 0.08, (60, 96, 160), -0.01)


def _shelf(w: Workshop) -> None:
    """Build a dark bookcase."""
    w.box(0.0, 0.0, (1.2, 0.35, 1.9), _DARK)
    for level in (0.12, 0.5, 0.88, 1.26):
        w.plate(0.0, level, 1.1, 0.32, _BLACK, -0.01)
        x = -0.52
        while x < 0.45 and level > 0.2:
            width = w.rng.uniform(0.05, 0.11)
            tone = w.rng.choice([(191, 190, 184), (121, 116, 110), _BLUE, _DARK, _BLACK, (112, 44, 34)])
            w.plate(x, level, width * 0.85, w.rng.uniform(0.2, 0.29), tone, -0.02)
            x += width + (w.rng.exponential(0.2) if w.rng.random() < 0.15 else 0)


def _cable(w: Workshop) -> None:
    """Build a cable on the floor."""
    x = np.linspace(-0.7, 0.7, 8)
    y = 0.1 * np.cumsum(w.rng.normal(0, 0.5, 8))
    path = np.column_stack([x, y, np.full(8, 0.005)])
    back = path[::-1] + (0.0, 0.02, 0.0)
    w.polygon(np.concatenate([path, back]), _BLACK if w.rng.random() < 0.7 else _WHITE)


def _sheet(w: Workshop) -> None:
    """Build a sheet of A4 paper, which may be printed or folded, or two overlapping sheets."""
    light = w.rng.uniform(205, 250)
    long = _A4[1] / 2 if w.rng.random() < 0.25 else _A4[1]
    w.table(0.0, 0.0, _A4[0], long, (light, light, light - 2))
    if w.rng.random() < 0.4:
        w.table(0.0, 0.0, _A4[0] - 0.05, long - 0.06, np.full(3, light - w.rng.uniform(20, 70)), 0.03)
    if w.rng.random() < 0.25:
        w.table(w.rng.normal(0, 0.12), 0.0, *_A4, (light, light, light - 2), w.rng.normal(0, 0.15))


# Pieces in the room: weight, and limits of the distance from the edge of the carpet, m.
_PIECES: dict[Builder, tuple[float, tuple[float, float]]] = {
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
# Things on the carpet outside the lines, with their weights.
_LITTER: dict[Builder, float] = {_papers: 3.0, _robot: 2.5, _bag: 1.5, _chair: 1.5, _cable: 1.5}


def _choose(rng: np.random.Generator, often: Mapping[Builder, float]) -> Builder:
    """Choose a builder at random, with probabilities in proportion to its weight."""
    weights = np.array(list(often.values()))
    return list(often)[int(rng.choice(len(weights), p=weights / weights.sum()))]


def choose_piece(rng: np.random.Generator) -> tuple[Builder, tuple[float, float]]:
    """Choose a piece for the room; return its builder and the limits of its distance from the carpet, m."""
    build = _choose(rng, {each: often for each, (often, _) in _PIECES.items()})
    return build, _PIECES[build][1]


def sides(rectangle: Rectangle) -> Iterator[tuple[FloatArray, FloatArray, FloatArray, float, float]]:
    """Yield the start, direction, outward direction, length and inward angle (rad) of each side of a rectangle."""
    x0, y0, x1, y1 = rectangle
    corners = np.array([(x0, y0), (x1, y0), (x1, y1), (x0, y1)])
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        length = float(np.linalg.norm(end - start))
        along = (end - start) / length
        outwards = np.array([along[1], -along[0]])
        yield start, along, outwards, length, float(np.arctan2(-outwards[1], -outwards[0]))


@lru_cache(maxsize=4)
def scatter(lines: Rectangle, border: float, amount: float, seed: int) -> Furniture:
    """Put things on the carpet outside the lines (x_min, y_min, x_max, y_max), `amount` per metre of the lines."""
    w = Workshop(np.random.default_rng([seed, 4]))
    for start, along, outwards, length, facing in sides(lines):
        for _ in range(w.rng.poisson(amount * length)):
            away = w.rng.uniform(0.45, 1.0) * border
            w.place(start + along * w.rng.uniform(0, length) + outwards * away, facing + w.rng.normal(0, 0.8))
            _choose(w.rng, _LITTER)(w)
    return w.done()


@lru_cache(maxsize=4)
def strew(carpet: Rectangle, amount: float, seed: int) -> Furniture:
    """Put sheets of paper on a carpet (x_min, y_min, x_max, y_max), `amount` per square metre."""
    w = Workshop(np.random.default_rng([seed, 7]))
    x0, y0, x1, y1 = carpet
    for _ in range(w.rng.poisson(amount * (x1 - x0) * (y1 - y0))):
        w.place(w.rng.uniform((x0, y0), (x1, y1)), w.rng.uniform(-np.pi, np.pi))
        _sheet(w)
    return w.done()


def wall(
    w: Workshop,
    start: FloatArray,
    along: FloatArray,
    outwards: FloatArray,
    distance: float,
    length: float,
    facing: float,
) -> tuple[Furniture, FloatArray]:
    """Build a wall with cupboards, boards, windows and posters; return its furniture and its colour."""
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
    """Return the outlines (N, 2) in sixteenths of pixels and the colours of pieces in view, the farthest first.

    Only pieces at distances within `between` (m) from the camera are returned.
    """
    away = np.hypot(*(furniture.places - eye.ground_position).T)
    near_enough = (away > between[0]) & (away <= between[1])
    if not near_enough.any():
        return []
    seen, starts = eye.to_camera(furniture.points), furniture.starts
    reached, inside = eye.reached(seen, starts[:-1])
    wanted = np.flatnonzero(reached & near_enough[furniture.piece])
    wanted = wanted[np.argsort(-away[furniture.piece[wanted]], kind="stable")]
    polygons = {i: seen[starts[i] : starts[i + 1]] for i in wanted.tolist()}
    cut = [i for i in polygons if not inside[i]]
    clipped = dict(zip(cut, eye.outlines(polygons[i] for i in cut), strict=True))
    found = []
    for i, polygon in polygons.items():
        at_edge = clipped.get(i)
        if inside[i]:
            found.append((np.rint(eye.pixels(polygon) * 16).astype(np.int32), furniture.colours[i]))
        elif at_edge is not None:
            found.append((at_edge * 16, furniture.colours[i]))
    return found
