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
    covered : ndarray, shape (M,)
        Sum of the pieces' lengths, px; both edges of a line may be two pieces of it.
    bend : ndarray, shape (M,)
        How far the middle of the best parabola lies beside its ends, px.
    """

    ends: FloatArray
    width: FloatArray
    covered: FloatArray
    bend: FloatArray

    @classmethod
    def none(cls) -> Lines:
        """No line at all."""
        return cls(np.zeros((0, 4)), np.zeros(0), np.zeros(0), np.zeros(0))

    def __len__(self) -> int:
        """How many."""
        return len(self.width)

    def where(self, wanted: npt.NDArray[np.bool_]) -> Lines:
        """Only those that are wanted (M,)."""
        return Lines(self.ends[wanted], self.width[wanted], self.covered[wanted], self.bend[wanted])


@dataclass(frozen=True, eq=False)
class _Moments:
    """Sums (N, 6) over the good points of pieces: 1, x, y, xx, xy, yy; those of a line are the sum of its pieces'."""

    sums: FloatArray

    @classmethod
    def of(cls, pieces: Pieces) -> _Moments:
        """Add up each piece's points."""
        x, y = np.moveaxis(pieces.middles, -1, 0)
        terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
        return cls((terms * pieces.good[..., None]).sum(axis=1))

    def together(self, mine: npt.NDArray[np.bool_]) -> _Moments:
        """Those of all of `mine` (N,), as one line's."""
        return _Moments(self.sums[mine].sum(axis=0, keepdims=True))

    def fit(self) -> tuple[FloatArray, FloatArray]:
        """Middles (N, 2) and unit directions (N, 2) of the nearest lines, by total least squares."""
        n, x, y, xx, xy, yy = self.sums.T
        x, y = x / n, y / n
        angle = 0.5 * np.arctan2(2 * (xy / n - x * y), xx / n - x * x - yy / n + y * y)
        return np.column_stack([x, y]), np.column_stack([np.cos(angle), np.sin(angle)])


def bend_of(along: FloatArray, beside: FloatArray) -> float:
    """How far the middle of the best parabola through points lies beside its ends."""
    half = (along.max() - along.min()) / 2
    if half < 1e-6 or len(along) < 4:
        return 0.0
    x = (along - along.mean()) / half
    square = x**2 - (x**2).mean()
    square = square - (square @ x) / (x @ x) * x  # what neither place nor slope of the line can explain
    return float(abs(square @ beside) / max(square @ square, 1e-9))


def merge(
    pieces: Pieces,
    scale: float,
    settings: LineSettings,
) -> Lines:
    """Put pieces together that lie on one straight line.

    Parameters
    ----------
    pieces : Pieces
        In the picture, or where the lens would not bend them.
    scale : float
        Pixels of this picture in one of a picture 320 wide.
    settings : LineSettings
        When pieces are one line.

    Returns
    -------
    Lines
        The longest piece's first.
    """
    if not len(pieces):
        return Lines.none()
    moments = _Moments.of(pieces)
    centre, way = moments.fit()
    along = ((pieces.edges - centre[:, None]) * way[:, None]).sum(axis=-1)
    low, high = along.min(axis=1), along.max(axis=1)
    length = high - low
    ends = np.stack([centre + low[:, None] * way, centre + high[:, None] * way], axis=1)  # (N, 2, 2)
    free = np.ones(len(pieces), dtype=bool)
    rows = []
    for i in np.argsort(-length, kind="stable"):
        if not free[i]:
            continue
        mine = np.arange(len(pieces)) == i
        o, u, t0, t1 = centre[i], way[i], low[i], high[i]
        while settings.merged:
            joined = mine | (free & _on_line(ends, centre, way, length, (o, u, t0, t1), scale, settings))
            if (joined == mine).all():
                break
            mine = joined
            o, u = (each[0] for each in moments.together(mine).fit())
            t = (pieces.edges[mine] - o) @ u
            t0, t1 = t.min(), t.max()
        free &= ~mine
        points = pieces.middles[mine][pieces.good[mine]] - o
        bend = bend_of(points @ u, points @ np.array([-u[1], u[0]]))
        rows.append((*(o + t0 * u), *(o + t1 * u), np.median(pieces.width[mine]), length[mine].sum(), bend))
    table = np.array(rows)
    return Lines(table[:, :4], table[:, 4], table[:, 5], table[:, 6])


def _on_line(
    ends: FloatArray,
    centre: FloatArray,
    way: FloatArray,
    length: FloatArray,
    line: tuple[FloatArray, FloatArray, float, float],
    scale: float,
    settings: LineSettings,
) -> npt.NDArray[np.bool_]:
    """Which pieces (N,) belong to a line (point, direction, where it begins and ends along it)."""
    o, u, t0, t1 = line
    normal = np.array([-u[1], u[0]])
    aside, slope = np.abs((centre - o) @ normal), np.abs(way @ normal)
    t = (ends - o) @ u
    gap = np.maximum(t.min(axis=1) - t1, t0 - t.max(axis=1))
    limit = settings.aside * scale
    straight = slope <= np.sin(settings.angle) + limit / np.maximum(length, limit)
    return np.asarray((aside <= limit) & straight & (gap <= settings.gap * scale))
