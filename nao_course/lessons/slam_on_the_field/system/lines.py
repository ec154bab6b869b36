"""Middles of the field's lines in a picture, to a fraction of a pixel, and the corners where they meet."""

from __future__ import annotations

from functools import cache
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray
from nao_course.sim import CameraView

Pixels = npt.NDArray[np.uint8]
Mask = npt.NDArray[np.bool_]

LINE_WIDTH, FARTHEST = 0.05, 12.0  # m, by the rules; beyond it no line is looked for
GREEN = (
    (28, 40, 25),
    (100, 255, 255),
)  # hue in half degrees, lightness, saturation: wide, for any venue's carpet
SHORTEST = 7.0  # px at 320, of an edge, and of a middle
BESIDE, SAMPLES, SHARE = (
    2.5,
    7,
    0.5,
)  # px at 320 beside an edge, where carpet must be at that part of some samples
CONTRAST = 15.0  # levels that a line is lighter than the carpet beside it
PARALLEL = float(np.cos(np.radians(12)))  # the two edges of a line, which run together far away
WIDER, SLACK = 1.5, 2.0  # how much wider a line may seem than it is: a factor, and px at 320
ASIDE, GAP = 1.2, 20.0  # px at 320: how far beside a line, and how far from its end, a piece of it may be
SQUARE = float(np.radians(15))  # how far from a right angle lines may meet
REACH, ARM = (
    (0.08, 0.03),
    (0.09, 0.03),
)  # m, and m for each metre: beyond a line's end, and along an arm at least
DOUBLES = 8.0  # px at 320: corners that are nearer to each other are one


def read_lines(picture: Pixels, view: CameraView) -> FloatArray:
    """Find the middles of straight lines: between two edges that face each other, with carpet on either side.

    Parameters
    ----------
    picture : ndarray of uint8, shape (H, W, 3)
        RGB, of the view's size.
    view : CameraView
        What the robot believes of its camera.

    Returns
    -------
    ndarray, shape (N, 4)
        (u1, v1, u2, v2), px to a fraction of one, where they would be without the lens; the longest first.

    Raises
    ------
    ValueError
        If the picture is not of the view's size.
    """
    if picture.shape != (view.size[1], view.size[0], 3):
        raise ValueError(f"the picture must be RGB of the size {view.size}, got shape {picture.shape}")
    flat = cv2.remap(picture, *_lens_map(view), cv2.INTER_LINEAR)
    hls = cv2.cvtColor(flat, cv2.COLOR_RGB2HLS)
    lightness, scale = cv2.extractChannel(hls, 1), view.size[0] / 320
    carpet = cv2.dilate(cv2.inRange(hls, *GREEN), np.ones((3, 3), np.uint8)) > 0
    top = _first_row(view)
    edges = _edges_of_carpet(lightness[top:], carpet[top:], scale) + (0, top, 0, top)
    return _merge(_middles(edges, view, scale), scale)


def corners_of_lines(lines: FloatArray, view: CameraView) -> FloatArray:
    """Find where lines meet at right angles on the ground, near an end of one of them.

    Parameters
    ----------
    lines : ndarray, shape (N, 4)
        As `read_lines` gives them.
    view : CameraView
        How the camera looks, its lean taken in.

    Returns
    -------
    ndarray, shape (K, 2)
        (u, v), px, as the lens made them.
    """
    ground = to_ground(lines.reshape(-1, 2), view).reshape(-1, 4)
    ground = ground[np.isfinite(ground).all(axis=1)]
    start, way = ground[:, :2], ground[:, 2:] - ground[:, :2]
    length = np.maximum(np.hypot(*way.T), 1e-9)
    way = way / length[:, None]
    i, j = np.triu_indices(len(ground), 1)
    sine = _cross(way[i], way[j])
    square = np.abs(sine) >= np.cos(SQUARE)
    i, j, sine = i[square], j[square], sine[square]
    between = start[j] - start[i]
    along_i, along_j = _cross(between, way[j]) / sine, _cross(between, way[i]) / sine
    points = start[i] + along_i[:, None] * way[i]
    far = np.hypot(*points.T)
    reach, arm = REACH[0] + REACH[1] * far + LINE_WIDTH, ARM[0] + ARM[1] * far
    met = np.ones(len(points), dtype=bool)
    through = met.copy()
    for along, whole in ((along_i, length[i]), (along_j, length[j])):
        met &= (along >= -reach) & (along <= whole + reach) & (np.maximum(along, whole - along) >= arm)
        through &= np.minimum(along, whole - along) >= arm
    kept = met & ~through  # four arms are a crossing, not a corner
    pixels = view.project(points[kept] + view.offset)
    inside = view.contains(pixels)
    return _without_doubles(
        pixels[inside], np.minimum(length[i], length[j])[kept][inside], DOUBLES * view.size[0] / 320
    )


# --- edges ---


@cache
def _lens_map(view: CameraView) -> tuple[Any, Any]:
    """Where each pixel of a picture without the lens is in the one with it."""
    width, height = view.size
    u, v = np.meshgrid(np.arange(width), np.arange(height))
    seen = view.distort(np.column_stack([u.ravel(), v.ravel()])).astype(np.float32).reshape(height, width, 2)
    return seen[..., 0], seen[..., 1]


def _first_row(view: CameraView) -> int:
    """The row above which lines are too far away; a picture of some rows at least is left."""
    down = np.clip(view.pitch - np.arctan(view.height / FARTHEST), -1.5, 1.5)
    row = view.centre[1] - view.focal[1] * np.tan(down)
    return int(np.clip(row, 0, view.size[1] - 24))


@cache
def _detector() -> Any:
    return cv2.createLineSegmentDetector(cv2.LSD_REFINE_STD)


def _edges_of_carpet(lightness: Pixels, carpet: Mask, scale: float) -> FloatArray:
    """Straight edges (N, 4) with carpet on their dark side, turned so that the light side is to the left."""
    found = _detector().detect(np.ascontiguousarray(lightness))[0]
    edges = np.reshape([] if found is None else found, (-1, 4)).astype(float)
    edges = edges[_lengths(edges) >= SHORTEST * scale]
    points = (
        edges[:, None, :2] + np.linspace(0.1, 0.9, SAMPLES)[:, None] * (edges[:, 2:] - edges[:, :2])[:, None]
    )
    aside = BESIDE * scale * _left_of(edges)[:, None]
    left, right = (_look_up(lightness, points + sign * aside).mean(axis=1) for sign in (1, -1))
    edges = np.where((left < right)[:, None], edges[:, [2, 3, 0, 1]], edges)
    aside = np.where((left < right)[:, None, None], -aside, aside)
    beside = _look_up(carpet, points - aside).mean(axis=1) >= SHARE
    return np.asarray(edges[beside & (np.abs(left - right) >= CONTRAST)])


def _look_up(plane: npt.NDArray[Any], points: FloatArray) -> npt.NDArray[Any]:
    """Values (...) of a plane (H, W) at the pixels nearest to points (..., 2), or at its rim."""
    u, v = np.moveaxis(np.rint(points).astype(np.intp), -1, 0)
    return plane[np.clip(v, 0, plane.shape[0] - 1), np.clip(u, 0, plane.shape[1] - 1)]


# --- middles ---


def _middles(edges: FloatArray, view: CameraView, scale: float) -> FloatArray:
    """Middles (M, 4) between two edges (N, 4) that face each other, no farther apart than a line is wide."""
    way, left = _ways(edges), _left_of(edges)
    i, j = np.nonzero(np.triu(way @ way.T <= -PARALLEL))
    middle_of_j = (edges[j, :2] + edges[j, 2:]) / 2
    width = ((middle_of_j - edges[i, :2]) * left[i]).sum(axis=1)
    faced = (width > 0.5 * scale) & (width <= _widest(middle_of_j, view, scale))
    i, j = i[faced], j[faced]
    axis = way[i] - way[j]
    axis = axis / np.linalg.norm(axis, axis=1, keepdims=True)
    begin_i, end_i = ((edges[i, k : k + 2] * axis).sum(axis=1) for k in (0, 2))
    begin_j, end_j = ((edges[j, k : k + 2] * axis).sum(axis=1) for k in (2, 0))
    begin, end = np.maximum(begin_i, begin_j), np.minimum(end_i, end_j)
    both = end - begin >= SHORTEST * scale
    i, j, axis, begin, end = i[both], j[both], axis[both], begin[both], end[both]
    ends = [(_point_at(edges[i], axis, at) + _point_at(edges[j], axis, at)) / 2 for at in (begin, end)]
    return np.hstack(ends).reshape(-1, 4)


def _point_at(edges: FloatArray, axis: FloatArray, at: FloatArray) -> FloatArray:
    """Points (N, 2) of edges where their coordinate along an axis is `at`."""
    first, last = edges[:, :2], edges[:, 2:]
    a, b = (first * axis).sum(axis=1), (last * axis).sum(axis=1)
    return np.asarray(first + ((at - a) / (b - a))[:, None] * (last - first))


def _widest(points: FloatArray, view: CameraView, scale: float) -> FloatArray:
    """How wide (N,) a line may be at points (N, 2), px; nothing above the horizon."""
    away = np.hypot(view.height, np.hypot(*to_ground(points, view).T))
    return np.nan_to_num(WIDER * view.focal[0] * LINE_WIDTH / away + SLACK * scale, nan=0.0)


def to_ground(points: FloatArray, view: CameraView) -> FloatArray:
    """Points on the ground (N, 2) that pixels without the lens show, m from below the camera; NaN at the horizon."""
    right, below = ((points - view.centre) / view.focal).T
    rays = (view.rotation @ [np.ones(len(right)), -right, -below]).T
    falling = np.where(rays[:, 2] < -0.03, -rays[:, 2], np.nan)
    return np.asarray(view.height * rays[:, :2] / falling[:, None])


def _merge(middles: FloatArray, scale: float) -> FloatArray:
    """Put middles together that lie on one straight line, the longest first."""
    lines, free = [], middles[np.argsort(-_lengths(middles), kind="stable")]
    while len(free):
        mine = np.arange(len(free)) == 0
        line = free[0]
        while True:
            joined = mine | _on(free, line, scale)
            if (joined == mine).all():
                break
            mine, line = joined, _fit(free[joined])
        lines.append(line)
        free = free[~mine]
    return np.array(lines).reshape(-1, 4)


def _on(middles: FloatArray, line: FloatArray, scale: float) -> Mask:
    """Which middles (N, 4) lie on a line (4,) or just beyond its ends."""
    way, left = _ways(line[None])[0], _left_of(line[None])[0]
    ends = middles.reshape(-1, 2, 2) - line[:2]
    along, beside = ends @ way, np.abs(ends @ left)
    gap = np.maximum(along.min(axis=1) - _lengths(line[None])[0], -along.max(axis=1))
    return np.asarray((beside.max(axis=1) <= ASIDE * scale) & (gap <= GAP * scale))


def _fit(middles: FloatArray) -> FloatArray:
    """Return the line (4,) nearest to some middles, each as heavy as it is long, from end to end of them."""
    ends, weight = middles.reshape(-1, 2), np.repeat(_lengths(middles), 2)
    centre = weight @ ends / weight.sum()
    away = ends - centre
    way = np.linalg.svd(away * np.sqrt(weight)[:, None], full_matrices=False)[2][0]
    along = away @ way
    return np.concatenate([centre + along.min() * way, centre + along.max() * way])


def _without_doubles(points: FloatArray, strength: FloatArray, radius: float) -> FloatArray:
    """Keep of points (K, 2) within `radius` of each other the strongest."""
    kept: list[FloatArray] = []
    for point in points[np.argsort(-strength, kind="stable")]:
        if not any(np.linalg.norm(point - other) <= radius for other in kept):
            kept.append(point)
    return np.array(kept).reshape(-1, 2)


def _lengths(lines: FloatArray) -> FloatArray:
    """From end to end (N,), px."""
    return np.asarray(np.hypot(lines[:, 2] - lines[:, 0], lines[:, 3] - lines[:, 1]))


def _ways(lines: FloatArray) -> FloatArray:
    """Unit vectors (N, 2) from the first end to the second."""
    return np.asarray((lines[:, 2:] - lines[:, :2]) / np.maximum(_lengths(lines), 1e-9)[:, None])


def _left_of(lines: FloatArray) -> FloatArray:
    """Unit vectors (N, 2) across, to the left of the way in a picture whose rows count downwards."""
    return _ways(lines)[:, ::-1] * (1, -1)


def _cross(first: FloatArray, second: FloatArray) -> FloatArray:
    """Cross products (N,) of vectors (N, 2)."""
    return np.asarray(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
