"""A corner detector that needs nothing but the picture: an entry of lessons 03 and 10.

Edges become pieces of lines (carpet on both sides, within the width that a line can have), pieces become lines, and two
lines that end where they meet make a corner. All lengths in px are those of a picture 320 wide. The values are frozen:
they were chosen on the simulator's sets "tune" and "whole_tune" (also with other seeds) and on the 8 real scenes that
are also there at 1280 x 960, on no other picture.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from benchmarks.challenges.pictures import check_picture
from nao_course.field_slam.lines import _cross, _detector, _values_at, _without_duplicates
from nao_course.geometry import FloatArray

Pixels = npt.NDArray[np.uint8]
Mask = npt.NDArray[np.bool_]

SMALLEST = 24  # px, unscaled: a picture with fewer rows or columns shows no line
LEAST_CARPET = 0.004  # of the picture's pixels
# Hue in half degrees; lightness; saturation: 0.16 of 255, as in lesson 01.
GREEN, DARKEST, PALEST = (32, 100), 25, 41
SPREAD = 14  # half degrees about the carpet's most frequent hue

SAMPLES, FEWEST = 9, 3  # of a piece, along it; of them, to be one
STEPS = 28  # of a profile, across it
# px: length of an edge; which sides of it are compared; where carpet is looked for before an edge and beyond a line; by
# how much a sample's width may differ whatever the width; how far a profile goes beyond the widest line on each side
EDGE, ACROSS, BESIDE, BEYOND, ODD, MARGIN = 7.0, 1.5, 2.5, 2.0, 0.7, 3.0
# levels of a line's middle: above the carpet; and chroma, which a post has 150 of
LIGHTER, MOST_CHROMA = (22.0, 90.0)
SHARE = 0.4  # of a piece's samples that must have carpet on both sides
UNEVEN = 0.15  # part by which a sample's width may differ from the piece's median: where another line joins, it does
# The horizon lies this part of the picture's height above the first carpet. Below it a line may widen by so many px a
# row (over flat ground a line of 0.05 m seen from 0.48 m has 0.104, whatever the lens); lens and light add SLACK px.
HORIZON, WIDENING, SLACK = 0.12, 0.16, 2.0

# px, rad, px: of a piece beside, across and along its line
ASIDE, ANGLE, GAP = (2.0, float(np.radians(4.0)), 20.0)
SHORTEST, SLENDER = 12.0, 3.0  # px; and times its width: a sheet of paper is 1.4
BEND, BEND_LENGTH = 0.5, 0.01  # px, and part of its length: a line's points beside it
FOCAL = 0.87  # of the picture's width: a camera that sees 60 degrees
# Sines of the angle between two lines: at least this, and this part of the least that a right angle on the ground has;
# below PARALLEL they do not meet, and at HIDING an edge is hidden beside the other line for longest.
FLATTEST, SQUARE, PARALLEL, HIDING = 0.2, 0.5, 0.05, 0.35
REACH, ARM, DOUBLES = 4.5, 11.0, 10.0  # px: a line is extended; an arm has at least; nearer corners are one


def find_corners_better(picture: npt.ArrayLike) -> FloatArray:
    """Find the corners (K, 2), (u, v) px, of the field's lines in a picture (H, W, 3).

    Raise a ValueError if it is not RGB of uint8.
    """
    planes = take_apart(check_picture(picture))
    if planes is None:
        return np.zeros((0, 2))
    scale, (rows, columns) = planes.scale, planes.carpet.shape
    ends, width = straight_lines(line_pieces(planes), scale)
    points, strength = crossings(ends, width, planes.top, columns)
    inside = ((points >= 0) & (points <= (columns - 1, rows - 1))).all(axis=1)
    return _without_duplicates(points[inside], strength[inside], DOUBLES * scale)


@dataclass(frozen=True, eq=False)
class Planes:
    """A picture's lightness (mean of the largest and smallest channel), their difference, and 1 where carpet is."""

    lightness: Pixels
    chroma: Pixels
    carpet: Pixels

    @property
    def scale(self) -> float:
        """How many pixels of this picture are one of a picture 320 wide."""
        return self.carpet.shape[1] / 320

    @property
    def first_row(self) -> int:
        """The first row with a tenth of carpet."""
        rows = np.flatnonzero(cv2.reduce(self.carpet, 1, cv2.REDUCE_AVG, dtype=cv2.CV_32F).ravel() > 0.1)
        return int(rows[0]) if len(rows) else len(self.carpet)

    @property
    def top(self) -> float:
        """The row of the horizon."""
        return self.first_row - HORIZON * len(self.carpet)


def take_apart(picture: Pixels) -> Planes | None:
    """Find the carpet in a picture (H, W, 3) by the most frequent of its greens; None if there is hardly any."""
    if min(picture.shape[:2]) < SMALLEST:
        return None
    hls = cv2.cvtColor(picture, cv2.COLOR_RGB2HLS)
    some_green = cv2.inRange(hls, (GREEN[0], DARKEST, PALEST), (GREEN[1], 255, 255))
    if cv2.countNonZero(some_green) < LEAST_CARPET * some_green.size:
        return None
    frequency: FloatArray = cv2.calcHist([hls], [0], some_green, [180], [0, 180]).ravel().astype(float)
    hue = int(np.convolve(frequency, np.ones(9), "same").argmax())
    carpet = cv2.inRange(hls, (hue - SPREAD, DARKEST, PALEST), (hue + SPREAD, 255, 255)) & 1
    chroma = picture.max(axis=2) - picture.min(axis=2)
    return Planes(cv2.extractChannel(hls, 1), chroma, carpet)


@dataclass(frozen=True, eq=False)
class Pieces:
    """Middles of pieces of lines."""

    middles: FloatArray  # (N, SAMPLES, 2): points on the line's middle, px, to a fraction of one
    good: Mask  # (N, SAMPLES): which of them are
    width: FloatArray  # (N,): of the line there, px
    edges: FloatArray  # (N, 2, 2): ends of the edges at which they were found, px

    def where(self, wanted: npt.NDArray[Any]) -> Pieces:
        """Return the pieces that a mask or indices select."""
        return Pieces(self.middles[wanted], self.good[wanted], self.width[wanted], self.edges[wanted])


def line_pieces(planes: Planes) -> Pieces:
    """Find pieces of lines: lighter than the carpet on both sides, and no wider than a line can be there."""
    scale, first_row = planes.scale, max(0, int(planes.first_row - 4 * planes.scale))
    found = _edges(planes.lightness, first_row, EDGE * scale)
    points, normal = _towards_light(planes, found)
    carpet = cv2.dilate(planes.carpet, np.ones((3, 3), np.uint8))
    outside = points - BESIDE * scale * normal
    beside = _look_up(carpet, outside) > 0
    wanted = beside.mean(axis=1) >= SHARE  # most edges are not of a line, and need no profile
    found, points, normal, outside, good = (each[wanted] for each in (found, points, normal, outside, beside))
    most = WIDENING * np.maximum(points[..., 1] - planes.top, 0.0) + SLACK * scale
    middle, width, is_line = _across(planes, points, normal, most)
    middles = points + middle[..., None] * normal
    good &= is_line & (_look_up(planes.chroma, middles) <= MOST_CHROMA)
    good &= _look_up(planes.lightness, middles) - _look_up(planes.lightness, outside) >= LIGHTER
    good &= _look_up(carpet, points + (middle + width / 2 + BEYOND * scale)[..., None] * normal) > 0
    pieces = Pieces(middles, good, np.zeros(len(found)), found.reshape(-1, 2, 2))
    kept = good.mean(axis=1) >= SHARE
    pieces, width = pieces.where(kept), width[kept]
    ordered = np.sort(np.where(pieces.good, width, np.inf), axis=1)
    typical = ordered[np.arange(len(width)), (pieces.good.sum(axis=1) - 1) // 2]
    odd = np.abs(width - typical[:, None]) > UNEVEN * typical[:, None] + ODD * scale
    even = Pieces(pieces.middles, pieces.good & ~odd, typical, pieces.edges)
    return even.where(even.good.sum(axis=1) >= FEWEST)


def _edges(lightness: Pixels, first_row: int, shortest: float) -> FloatArray:
    """Find straight edges (N, 4) below a row that are longer than `shortest` px, by OpenCV's line segment detector."""
    if len(lightness) - first_row < 16:
        return np.zeros((0, 4))
    found = _detector().detect(np.ascontiguousarray(lightness[first_row:]))[0]
    each = np.reshape([] if found is None else found, (-1, 4)).astype(float) + (0, first_row, 0, first_row)
    return each[np.hypot(each[:, 2] - each[:, 0], each[:, 3] - each[:, 1]) >= shortest]


def _look_up(plane: Pixels, points: FloatArray) -> npt.NDArray[np.int64]:
    """Return the values (...) of a plane (H, W) of bytes at the pixels nearest to points (..., 2), clipped."""
    return _values_at(plane, points).astype(np.int64)


def _towards_light(planes: Planes, found: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points (N, SAMPLES, 2) along edges (N, 4), and unit normals there that point to the light side."""
    way = (found[:, 2:] - found[:, :2])[:, None]
    points = found[:, None, :2] + np.linspace(0.06, 0.94, SAMPLES)[:, None] * way
    normal = np.stack([-way[..., 1], way[..., 0]], axis=-1) / np.linalg.norm(way, axis=-1, keepdims=True)
    step = ACROSS * planes.scale * normal
    rise = _look_up(planes.lightness, points + step) - _look_up(planes.lightness, points - step)
    normal = np.where(rise.mean(axis=1)[:, None, None] < 0, -normal, normal)
    return points, np.repeat(normal, SAMPLES, axis=1)


def _across(
    planes: Planes, points: FloatArray, normal: FloatArray, most: FloatArray
) -> tuple[FloatArray, FloatArray, Mask]:
    """Find the lines across edges from profiles along normals (N, M, 2) that point to the light side.

    Returns the line's middle and its width at half of the height (N, M), px along the normal from the point; and
    whether the profile goes up and, not farther than `most` from there, down.
    """
    n, m = points.shape[:2]
    if not n:
        return np.zeros((0, m)), np.zeros((0, m)), np.zeros((0, m), dtype=bool)
    margin = MARGIN * planes.scale
    offset = -margin + np.linspace(0.0, 1.0, STEPS) * (most[..., None] + 2 * margin)  # (N, M, STEPS)
    where = points[..., None, :] + offset[..., None] * normal[..., None, :]
    u, v = np.moveaxis(where.reshape(n, m * STEPS, 2).astype(np.float32), -1, 0)
    where_u, where_v = np.ascontiguousarray(u), np.ascontiguousarray(v)
    light = planes.lightness.astype(np.float32)
    read = cv2.remap(light, where_u, where_v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    profile = np.asarray(read, dtype=float).reshape(n, m, STEPS)
    carpet = np.min(profile[..., :4], axis=-1)
    peak = np.max(np.where(offset <= most[..., None], profile, 0.0), axis=-1)
    over = profile - ((carpet + peak) / 2)[..., None]
    first = np.argmax(over > 0, axis=-1)
    # 0: it does not go down again
    last = np.argmax((over <= 0) & (np.arange(STEPS) > first[..., None]), axis=-1)
    found = (first > 0) & (last > 0)
    rise, fall = (_crossing(over, offset, np.maximum(at, 1)) for at in (first, last))
    found &= (fall - rise <= most) & (np.abs(rise) <= 2.5 * planes.scale)
    return (rise + fall) / 2, fall - rise, found


def _crossing(over: FloatArray, offset: FloatArray, at: npt.NDArray[np.intp]) -> FloatArray:
    """Return the offsets (N, M) at which profiles (N, M, STEPS) pass through zero between steps `at` - 1 and `at`."""
    after, before = (np.take_along_axis(over, (at - k)[..., None], axis=-1)[..., 0] for k in (0, 1))
    end, start = (np.take_along_axis(offset, (at - k)[..., None], axis=-1)[..., 0] for k in (0, 1))
    share = before / np.where(before == after, 1.0, before - after)
    return np.asarray(start + np.clip(share, 0.0, 1.0) * (end - start))


def straight_lines(pieces: Pieces, scale: float) -> tuple[FloatArray, FloatArray]:
    """Put pieces together that lie on one straight line, longest first; return ends (M, 4) and widths (M,)."""
    sums = _moments(pieces)
    centre, way = _fit(sums)
    along = ((pieces.edges - centre[:, None]) * way[:, None]).sum(axis=-1)
    low, high = along.min(axis=1, initial=np.inf), along.max(axis=1, initial=-np.inf)
    tips, length = np.stack([centre + each[:, None] * way for each in (low, high)], axis=1), high - low
    free = np.ones(len(length), dtype=bool)
    ends, width = [], []
    for i in np.argsort(-length, kind="stable"):
        if not free[i]:
            continue
        mine = np.arange(len(free)) == i
        point, direction, first, last = centre[i], way[i], low[i], high[i]
        while True:
            normal = np.array([-direction[1], direction[0]])
            aside, slope = np.abs((centre - point) @ normal), np.abs(way @ normal)
            reached = (tips - point) @ direction
            gap = np.maximum(reached.min(axis=1) - last, first - reached.max(axis=1))
            limit = ASIDE * scale
            straight = slope <= np.sin(ANGLE) + limit / np.maximum(length, limit)
            joined = mine | (free & (aside <= limit) & straight & (gap <= GAP * scale))
            if (joined == mine).all():
                break
            mine = joined
            (point,), (direction,) = _fit(sums[mine].sum(axis=0, keepdims=True))
            both = (pieces.edges[mine] - point) @ direction
            first, last = both.min(), both.max()
        free &= ~mine
        away = pieces.middles[mine][pieces.good[mine]] - point
        wide, long = np.median(pieces.width[mine]), last - first
        bend = _bend(away @ direction, away @ np.array([-direction[1], direction[0]]))
        if long >= max(SHORTEST * scale, SLENDER * wide) and bend <= BEND * scale + BEND_LENGTH * long:
            ends.append(np.concatenate([point + first * direction, point + last * direction]))
            width.append(wide)
    return np.array(ends).reshape(-1, 4), np.array(width)


def _moments(pieces: Pieces) -> FloatArray:
    """Return sums (N, 6) over the good points of pieces: 1, x, y, xx, xy, yy; a line's are the sum of its pieces'."""
    x, y = np.moveaxis(pieces.middles, -1, 0)
    terms = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], axis=-1)
    return np.asarray((terms * pieces.good[..., None]).sum(axis=1))


def _fit(sums: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the centres (N, 2) and unit directions (N, 2) of the lines fitted by total least squares."""
    n, x, y, xx, xy, yy = sums.T
    x, y = x / n, y / n
    angle = 0.5 * np.arctan2(2 * (xy / n - x * y), xx / n - x * x - yy / n + y * y)
    return np.column_stack([x, y]), np.column_stack([np.cos(angle), np.sin(angle)])


def _bend(along: FloatArray, beside: FloatArray) -> float:
    """Return the distance of the midpoint of the best parabola through points from the line between its ends."""
    half = (along.max() - along.min()) / 2
    if half < 1e-6 or len(along) < 4:
        return 0.0
    x = (along - along.mean()) / half
    square = x**2 - (x**2).mean()
    square = square - (square @ x) / (x @ x) * x  # what neither place nor slope of the line can explain
    return float(abs(square @ beside) / max(square @ square, 1e-9))


def crossings(ends: FloatArray, width: FloatArray, top: float, columns: int) -> tuple[FloatArray, FloatArray]:
    """Return points (K, 2) where two lines meet near their ends, with no four arms, and the shorter line's length (K,).

    A point that is seen under the angle of depression d shows lengths along the line of sight shortened by f = sin d.
    Two perpendicular directions come nearest to each other when both are at 45 degrees to it: 2 f / (1 + f^2).
    """
    scale, start, way = columns / 320, ends[:, :2], ends[:, 2:] - ends[:, :2]
    length = np.hypot(*way.T)
    way = way / np.maximum(length, 1e-9)[:, None]
    i, j = np.triu_indices(len(ends), 1)
    sine = _cross(way[i], way[j])
    steep = np.abs(sine) >= PARALLEL
    i, j, sine = i[steep], j[steep], sine[steep]
    between = start[j] - start[i]
    along_i, along_j = _cross(between, way[j]) / sine, _cross(between, way[i]) / sine
    points = start[i] + along_i[:, None] * way[i]
    below = np.maximum(points[:, 1] - top, 0.0) / (FOCAL * columns)
    f = below / np.hypot(1.0, below)
    near = REACH * scale + (width[i] + width[j]) / 2 / np.maximum(np.abs(sine), HIDING)
    met, arms = np.abs(sine) >= np.maximum(FLATTEST, SQUARE * 2 * f / (1 + f**2)), []
    for k, along in ((i, along_i), (j, along_j)):
        met &= (along >= -near) & (along <= length[k] + near)
        arms.append(np.array([along >= ARM * scale, length[k] - along >= ARM * scale]))
    met &= arms[0].any(axis=0) & arms[1].any(axis=0) & ~(arms[0] & arms[1]).all(axis=0)
    return points[met], np.minimum(length[i], length[j])[met]
