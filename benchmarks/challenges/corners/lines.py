"""Lines: pieces that lie on one straight line, put together, longest first."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from benchmarks.challenges.corners.pieces import Pieces
from nao_course.geometry import FloatArray


@dataclass(frozen=True)
class LineSettings:
    """When pieces are one line.

    Parameters
    ----------
    aside : float
        How far a piece's middle may lie beside the line, px at 320.
    angle : float
        Between piece and line, rad, for a long piece; a short one may differ by what `aside` makes at its ends.
    gap : float
        Between them along the line, px at 320.
    merged : bool
        Whether pieces are put together at all.
    """

    aside: float = 1.4
    angle: float = float(np.radians(4.0))
    gap: float = 20.0
    merged: bool = True


@dataclass(frozen=True, eq=False)
class Lines:
    """Straight middles of lines.

    Parameters
    ----------
    ends : ndarray, shape (M, 4)
        (u1, v1, u2, v2), px.
    width : ndarray, shape (M,)
        Of the lines, px.
    bend : ndarray, shape (M,)
        How far the middle of the best parabola lies beside its ends, px.
    """

    ends: FloatArray
    width: FloatArray
    bend: FloatArray

    @classmethod
    def none(cls) -> Lines:
        """Return an empty set of lines."""
        return cls(np.zeros((0, 4)), np.zeros(0), np.zeros(0))

    @property
    def length(self) -> FloatArray:
        """From end to end (M,), px."""
        return np.asarray(np.hypot(self.ends[:, 2] - self.ends[:, 0], self.ends[:, 3] - self.ends[:, 1]))

    def __len__(self) -> int:
        """Return the number of lines."""
        return len(self.width)

    def where(self, wanted: npt.NDArray[np.bool_]) -> Lines:
        """Return the lines that are selected by a mask (M,)."""
        return Lines(self.ends[wanted], self.width[wanted], self.bend[wanted])


@dataclass(frozen=True, eq=False)
class _Moments:
    """Sums (N, 6) over the good points of pieces: 1, x, y, xx, xy, yy; those of a line are the sum of its pieces'."""

    sums: FloatArray

    @classmethod
    def of(cls, pieces: Pieces) -> _Moments:
        """Fit a line through the points of each segment, as long as its edge."""
        x, y = np.moveaxis(pieces.middles, -1, 0)
        terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
        return cls((terms * pieces.good[..., None]).sum(axis=1))

    def together(self, mine: npt.NDArray[np.bool_]) -> _Moments:
        """Return the sums of all segments of `mine` (N,), as for a single line."""
        return _Moments(self.sums[mine].sum(axis=0, keepdims=True))

    def fit(self) -> tuple[FloatArray, FloatArray]:
        """Return the centres (N, 2) and unit directions (N, 2) of the lines fitted by total least squares."""
        n, x, y, xx, xy, yy = self.sums.T
        x, y = x / n, y / n
        angle = 0.5 * np.arctan2(2 * (xy / n - x * y), xx / n - x * x - yy / n + y * y)
        return np.column_stack([x, y]), np.column_stack([np.cos(angle), np.sin(angle)])


def bend_of(along: FloatArray, beside: FloatArray) -> float:
    """Return the distance of the midpoint of the best parabola through points from the line between its ends."""
    half = (along.max() - along.min()) / 2
    if half < 1e-6 or len(along) < 4:
        return 0.0
    x = (along - along.mean()) / half
    square = x**2 - (x**2).mean()
    square = square - (square @ x) / (x @ x) * x  # what neither place nor slope of the line can explain
    return float(abs(square @ beside) / max(square @ square, 1e-9))


@dataclass(frozen=True)
class _Line:
    """A straight line through `point` along the unit vector `way`, from `first` to `last` along it (px)."""

    point: FloatArray
    way: FloatArray
    first: float
    last: float

    @classmethod
    def through(cls, pieces: Pieces, moments: _Moments, mine: npt.NDArray[np.bool_]) -> _Line:
        """Fit the line of some of the pieces (N,)."""
        point, way = (each[0] for each in moments.together(mine).fit())
        along = (pieces.edges[mine] - point) @ way
        return cls(point, way, float(along.min()), float(along.max()))

    @property
    def ends(self) -> FloatArray:
        """Both ends (4,), px."""
        return np.concatenate([self.point + self.first * self.way, self.point + self.last * self.way])

    def bend(self, points: FloatArray) -> float:
        """Return by how much the parabola through points (N, 2) bends, px."""
        away = points - self.point
        return bend_of(away @ self.way, away @ np.array([-self.way[1], self.way[0]]))


@dataclass(frozen=True, eq=False)
class _Straight:
    """Each piece as a segment: its middle (N, 2), unit direction (N, 2), length (N,) and ends (N, 2, 2)."""

    centre: FloatArray
    way: FloatArray
    length: FloatArray
    ends: FloatArray

    @classmethod
    def of(cls, pieces: Pieces, moments: _Moments) -> _Straight:
        """Lay a line through each piece's points, as long as its edge."""
        centre, way = moments.fit()
        along = ((pieces.edges - centre[:, None]) * way[:, None]).sum(axis=-1)
        low, high = along.min(axis=1), along.max(axis=1)
        ends = np.stack([centre + low[:, None] * way, centre + high[:, None] * way], axis=1)
        return cls(centre, way, high - low, ends)

    def line(self, i: int) -> _Line:
        """Return the line of one segment."""
        first, last = np.sort((self.ends[i] - self.centre[i]) @ self.way[i]).tolist()
        return _Line(self.centre[i], self.way[i], first, last)

    def on(self, line: _Line, settings: LineSettings, scale: float) -> npt.NDArray[np.bool_]:
        """Return which segments (N,) lie on a line or its extension."""
        normal = np.array([-line.way[1], line.way[0]])
        aside, slope = np.abs((self.centre - line.point) @ normal), np.abs(self.way @ normal)
        along = (self.ends - line.point) @ line.way
        gap = np.maximum(along.min(axis=1) - line.last, line.first - along.max(axis=1))
        limit = settings.aside * scale
        straight = slope <= np.sin(settings.angle) + limit / np.maximum(self.length, limit)
        return np.asarray((aside <= limit) & straight & (gap <= settings.gap * scale))


def merge(pieces: Pieces, scale: float, settings: LineSettings, shortest: float) -> Lines:
    """Put pieces together that lie on one straight line.

    Parameters
    ----------
    pieces : Pieces
        In the picture, or where the lens would not bend them.
    scale : float
        Pixels of this picture in one of a picture 320 wide.
    settings : LineSettings
        When pieces are one line.
    shortest : float
        Lines that are shorter are left out, px of a picture 320 wide.

    Returns
    -------
    Lines
        The longest piece's first.
    """
    if not len(pieces):
        return Lines.none()
    moments = _Moments.of(pieces)
    straight = _Straight.of(pieces, moments)
    free = np.ones(len(pieces), dtype=bool)
    ends, width, bend = [], [], []
    for i in np.argsort(-straight.length, kind="stable"):
        if not free[i]:
            continue
        mine = np.arange(len(pieces)) == i
        line = straight.line(int(i))
        while settings.merged:
            joined = mine | (free & straight.on(line, settings, scale))
            if (joined == mine).all():
                break
            mine = joined
            line = _Line.through(pieces, moments, mine)
        free &= ~mine
        if line.last - line.first < shortest * scale:
            continue
        ends.append(line.ends)
        width.append(np.median(pieces.width[mine]))
        bend.append(line.bend(pieces.middles[mine][pieces.good[mine]]))
    return Lines(np.array(ends).reshape(-1, 4), np.array(width), np.array(bend))
