"""Pieces of lines: edges with line on one side, and carpet again beyond it, within the width that a line can have."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from benchmarks.challenges.corners.carpet import Planes
from nao_course.geometry import FloatArray

SAMPLES, FEWEST = 9, 3  # of a piece, along it; of them, to be one
STEPS = 28  # of a profile, across it
# All px at 320: which sides of an edge are compared, where carpet is looked for before an edge and beyond a line, and
# by how much a sample's width may differ from the others' whatever the width.
ACROSS, BESIDE, BEYOND, ODD = 1.5, 2.5, 2.0, 0.7
MARGIN = 3.0  # px at 320 that a profile reaches beyond the widest line on each side

# (points (N, 2) px, unit normals (N, 2)) -> how wide (N,) a line may be there, px, across the normal
Widest = Callable[[FloatArray, FloatArray], FloatArray]


@dataclass(frozen=True)
class PieceSettings:
    """What counts as a piece of a line.

    Parameters
    ----------
    shortest : float
        Of an edge, px at 320.
    lighter : float
        How much lighter a line's middle is than the carpet beside it, in levels.
    most_chroma : float
        Of a line's middle, in levels: a goal post has 150.
    share : float
        Of a piece's samples that must have carpet on both sides.
    uneven : float
        How far a sample's width may differ from the piece's median, as a fraction: where another line joins, it does.
    both_sides : bool
        Whether carpet is asked for on both sides, or on one.
    """

    shortest: float = 7.0
    lighter: float = 22.0
    most_chroma: float = 90.0
    share: float = 0.4
    uneven: float = 0.15
    both_sides: bool = True


@dataclass(frozen=True, eq=False)
class Pieces:
    """Middles of pieces of lines.

    Parameters
    ----------
    middles : ndarray, shape (N, SAMPLES, 2)
        Points on the line's middle, px, to a fraction of one.
    good : ndarray of bool, shape (N, SAMPLES)
        Which of them are.
    width : ndarray, shape (N,)
        Of the line there, px.
    edges : ndarray, shape (N, 2, 2)
        Ends of the edges at which they were found, px.
    """

    middles: FloatArray
    good: npt.NDArray[np.bool_]
    width: FloatArray
    edges: FloatArray

    @classmethod
    def none(cls) -> Pieces:
        """Return an empty set of segments."""
        good = np.zeros((0, SAMPLES), dtype=bool)
        return cls(np.zeros((0, SAMPLES, 2)), good, np.zeros(0), np.zeros((0, 2, 2)))

    def where(self, wanted: npt.NDArray[np.bool_]) -> Pieces:
        """Return the segments that are selected by a mask (N,)."""
        return Pieces(self.middles[wanted], self.good[wanted], self.width[wanted], self.edges[wanted])

    def __len__(self) -> int:
        """Return the number of segments."""
        return len(self.width)


@cache
def _detector() -> Any:
    return cv2.createLineSegmentDetector(cv2.LSD_REFINE_STD)


def edges(lightness: npt.NDArray[np.uint8], first_row: int, shortest: float) -> FloatArray:
    """Find straight edges (N, 4) below a row that are longer than `shortest` px, by OpenCV's line segment detector."""
    if len(lightness) - first_row < 16:
        return np.zeros((0, 4))
    found = _detector().detect(np.ascontiguousarray(lightness[first_row:]))[0]
    if found is None:
        return np.zeros((0, 4))
    each = np.asarray(found, dtype=float).reshape(-1, 4) + (0, first_row, 0, first_row)
    return each[np.hypot(each[:, 2] - each[:, 0], each[:, 3] - each[:, 1]) >= shortest]


def _look_up(plane: npt.NDArray[np.uint8], points: FloatArray) -> npt.NDArray[np.int64]:
    """Return the values (...) of a plane (H, W) of bytes at the pixels nearest to points (..., 2), clipped."""
    columns, rows = np.moveaxis(np.rint(points).astype(np.intp), -1, 0)
    inside = np.clip(rows, 0, plane.shape[0] - 1), np.clip(columns, 0, plane.shape[1] - 1)
    return plane[inside].astype(np.int64)


def _interpolated(plane: npt.NDArray[np.uint8], points: FloatArray) -> FloatArray:
    """Return interpolated values of a plane (H, W) at points (N, M, 2)."""
    u, v = (np.ascontiguousarray(points[..., k], dtype=np.float32) for k in (0, 1))
    found = cv2.remap(plane.astype(np.float32), u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(found, dtype=float)


def _median(values: FloatArray, good: npt.NDArray[np.bool_]) -> FloatArray:
    """Return the median (N,) of the good values (N, M) of each row; of two central values, the lower one."""
    ordered = np.sort(np.where(good, values, np.inf), axis=1)
    return np.asarray(ordered[np.arange(len(values)), (good.sum(axis=1) - 1) // 2])


def line_pieces(planes: Planes, first_row: int, widest: Widest, settings: PieceSettings) -> Pieces:
    """Find the pieces of lines below a row of a picture.

    Each edge is crossed by profiles from its dark side to its light one: a line is lighter than the carpet beside it,
    begins at the edge, ends before it is wider than a line can be there, and has carpet on both sides.
    """
    scale = planes.scale
    found = edges(planes.lightness, first_row, settings.shortest * scale)
    points, normal = _towards_light(planes, found)
    # Most edges are not of a line: what has no carpet on its dark side needs no profile.
    carpet = cv2.dilate(planes.carpet, np.ones((3, 3), np.uint8))
    outside = points - BESIDE * scale * normal
    beside = _look_up(carpet, outside) > 0
    wanted = beside.mean(axis=1) >= settings.share
    if not wanted.any():
        return Pieces.none()
    found, points, normal, outside, good = (each[wanted] for each in (found, points, normal, outside, beside))
    most = widest(points.reshape(-1, 2), normal.reshape(-1, 2)).reshape(points.shape[:2])
    middle, width, is_line = _across(planes, points, normal, most)
    middles = points + middle[..., None] * normal
    good &= is_line & (_look_up(planes.chroma, middles) <= settings.most_chroma)
    good &= _look_up(planes.lightness, middles) - _look_up(planes.lightness, outside) >= settings.lighter
    if settings.both_sides:
        beyond = points + (middle + width / 2 + BEYOND * scale)[..., None] * normal
        good &= _look_up(carpet, beyond) > 0
    return _even(Pieces(middles, good, np.zeros(len(found)), found.reshape(-1, 2, 2)), width, scale, settings)


def _towards_light(planes: Planes, found: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points (N, SAMPLES, 2) along edges (N, 4), and unit normals there that point to the light side."""
    way = (found[:, 2:] - found[:, :2])[:, None]
    points = found[:, None, :2] + np.linspace(0.06, 0.94, SAMPLES)[:, None] * way
    normal = np.stack([-way[..., 1], way[..., 0]], axis=-1) / np.linalg.norm(way, axis=-1, keepdims=True)
    step = ACROSS * planes.scale * normal
    rise = _look_up(planes.lightness, points + step) - _look_up(planes.lightness, points - step)
    normal = np.where(rise.mean(axis=1)[:, None, None] < 0, -normal, normal)
    return points, np.repeat(normal, SAMPLES, axis=1)


def _even(pieces: Pieces, width: FloatArray, scale: float, settings: PieceSettings) -> Pieces:
    """Return the segments that are good over part of their length, without samples (N, M) of an unusual width."""
    kept = pieces.good.mean(axis=1) >= settings.share
    if not kept.any():
        return Pieces.none()
    pieces, width = pieces.where(kept), width[kept]
    typical = _median(width, pieces.good)
    odd = np.abs(width - typical[:, None]) > settings.uneven * typical[:, None] + ODD * scale
    even = Pieces(pieces.middles, pieces.good & ~odd, typical, pieces.edges)
    return even.where(even.good.sum(axis=1) >= FEWEST)


def _across(
    planes: Planes, points: FloatArray, normal: FloatArray, most: FloatArray
) -> tuple[FloatArray, FloatArray, npt.NDArray[np.bool_]]:
    """Find the lines across edges from profiles along the normals, which point to the light side.

    Parameters
    ----------
    planes : Planes
        The picture.
    points, normal : ndarray, shape (N, M, 2)
        On the edges, px.
    most : ndarray, shape (N, M)
        How wide a line may be there, px.

    Returns
    -------
    middle, width : ndarray, shape (N, M)
        Of the line, px along the normal from the point; width at half of the height.
    found : ndarray of bool, shape (N, M)
        Whether the profile goes up and, not too far from there, down.
    """
    margin = MARGIN * planes.scale
    fraction = np.linspace(0.0, 1.0, STEPS)
    offset = -margin + fraction * (most[..., None] + 2 * margin)  # (N, M, STEPS)
    where = points[..., None, :] + offset[..., None] * normal[..., None, :]
    n, m = points.shape[:2]
    profile = _interpolated(planes.lightness, where.reshape(n, m * STEPS, 2)).reshape(n, m, STEPS)
    carpet = np.min(profile[..., :4], axis=-1)
    peak = np.max(np.where(offset <= most[..., None], profile, 0.0), axis=-1)
    over = profile - ((carpet + peak) / 2)[..., None]
    index = np.arange(STEPS)
    first = np.argmax(over > 0, axis=-1)
    last = np.argmax((over <= 0) & (index > first[..., None]), axis=-1)  # 0: it does not go down again
    found = (first > 0) & (last > 0)
    rise = _crossing(over, offset, np.maximum(first, 1))
    fall = _crossing(over, offset, np.maximum(last, 1))
    found &= (fall - rise <= most) & (np.abs(rise) <= 2.5 * planes.scale)
    return (rise + fall) / 2, fall - rise, found


def _crossing(over: FloatArray, offset: FloatArray, at: npt.NDArray[np.intp]) -> FloatArray:
    """Return the offsets (N, M) at which profiles (N, M, STEPS) pass through zero between steps `at` - 1 and `at`."""
    after, before = (np.take_along_axis(over, (at - k)[..., None], axis=-1)[..., 0] for k in (0, 1))
    end, start = (np.take_along_axis(offset, (at - k)[..., None], axis=-1)[..., 0] for k in (0, 1))
    share = before / np.where(before == after, 1.0, before - after)
    return np.asarray(start + np.clip(share, 0.0, 1.0) * (end - start))
