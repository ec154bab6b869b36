"""Detection of the field's lines in a picture with subpixel accuracy, and of the corners where they meet."""

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

LINE_WIDTH = 0.05  # m, by the rules
FARTHEST = 12.0  # m: lines that are farther away are not searched for
# Lowest and highest hue (in half degrees), lightness and saturation of a carpet: wide enough for any venue.
GREEN = ((28, 40, 25), (100, 255, 255))
SHORTEST = 7.0  # px at 320: least length of an edge, and of a centre line
# At BESIDE px (at 320) beside an edge, a SHARE of SAMPLES points must show carpet.
BESIDE, SAMPLES, SHARE = (2.5, 7, 0.5)
CONTRAST = 15.0  # levels by which a line is at least lighter than the carpet beside it
# The two edges of a line converge with distance, so their directions may differ by up to 12 degrees.
PARALLEL = float(np.cos(np.radians(12)))
WIDER, SLACK = 1.5, 2.0  # how much wider than expected a line may appear: a factor, and px at 320
# How far beside a line, and beyond its end, a segment of the same line may be, px at 320.
ASIDE, GAP = (1.2, 20.0)
SQUARE = float(np.radians(15))  # largest difference from a right angle at a corner
# REACH is how far a corner may lie beyond the end of a line, ARM the least length of each arm of a corner. Each of them
# is given in m, and in m per metre of distance.
REACH, ARM = ((0.08, 0.03), (0.09, 0.03))
DUPLICATES = 8.0  # px at 320: of corners that are nearer to each other, one is kept


def read_lines(picture: Pixels, view: CameraView, line_width: float = LINE_WIDTH) -> FloatArray:
    """Find the centre lines of the field's straight lines: two facing edges with carpet on both outer sides.

    The RGB picture (H, W, 3) has the view's size, or a ValueError is raised; `line_width` is in m. Return end points
    (N, 4), (u1, v1, u2, v2) in px, with subpixel accuracy and without lens distortion, the longest line first.
    """
    if picture.shape != (view.size[1], view.size[0], 3):
        width, height = view.size
        raise ValueError(f"the picture must have the shape ({height}, {width}, 3), got {picture.shape}")
    flat = cv2.remap(picture, *_lens_map(view), cv2.INTER_LINEAR)
    hls = cv2.cvtColor(flat, cv2.COLOR_RGB2HLS)
    lightness, scale = cv2.extractChannel(hls, 1), view.size[0] / 320
    carpet = cv2.dilate(cv2.inRange(hls, *GREEN), np.ones((3, 3), np.uint8)) > 0
    top = _first_row(view)
    edges = _edges_of_carpet(lightness[top:], carpet[top:], scale) + (0, top, 0, top)
    return _merge(_centre_lines(edges, view, scale, line_width), scale)


def corners_of_lines(lines: FloatArray, view: CameraView) -> FloatArray:
    """Find the corners: points where lines meet at right angles on the ground, near an end of one of them.

    Lines (N, 4) are as returned by `read_lines`, px, and the view is corrected by the body tilt. Return (u, v) (K, 2)
    in px of the picture, with lens distortion.
    """
    ground = to_ground(lines.reshape(-1, 2), view).reshape(-1, 4)
    ground = ground[np.isfinite(ground).all(axis=1)]
    start, direction = ground[:, :2], ground[:, 2:] - ground[:, :2]
    length = np.maximum(np.hypot(*direction.T), 1e-9)
    direction = direction / length[:, None]
    i, j = np.triu_indices(len(ground), 1)
    sine = _cross(direction[i], direction[j])
    square = np.abs(sine) >= np.cos(SQUARE)
    i, j, sine = i[square], j[square], sine[square]
    between = start[j] - start[i]
    along_i, along_j = _cross(between, direction[j]) / sine, _cross(between, direction[i]) / sine
    points = start[i] + along_i[:, None] * direction[i]
    far = np.hypot(*points.T)
    reach, arm = REACH[0] + REACH[1] * far + LINE_WIDTH, ARM[0] + ARM[1] * far
    at_corner = np.ones(len(points), dtype=bool)
    through = at_corner.copy()
    for along, whole in ((along_i, length[i]), (along_j, length[j])):
        at_corner &= (along >= -reach) & (along <= whole + reach) & (np.maximum(along, whole - along) >= arm)
        through &= np.minimum(along, whole - along) >= arm
    kept = at_corner & ~through  # a point with four arms is a crossing, not a corner
    pixels = view.project(points[kept] + view.offset)
    inside = view.contains(pixels)
    return _without_duplicates(
        pixels[inside], np.minimum(length[i], length[j])[kept][inside], DUPLICATES * view.size[0] / 320
    )


# --- edges ---


@cache
def _lens_map(view: CameraView) -> tuple[Any, Any]:
    """Return for each pixel of an undistorted picture its column and its row in the distorted one."""
    width, height = view.size
    u, v = np.meshgrid(np.arange(width), np.arange(height))
    seen = view.distort(np.column_stack([u.ravel(), v.ravel()])).astype(np.float32).reshape(height, width, 2)
    return seen[..., 0], seen[..., 1]


def _first_row(view: CameraView) -> int:
    """Return the row above which lines are too far away; at least 24 rows remain below it."""
    down = np.clip(view.pitch - np.arctan(view.height / FARTHEST), -1.5, 1.5)
    row = view.centre[1] - view.focal[1] * np.tan(down)
    return int(np.clip(row, 0, view.size[1] - 24))


@cache
def _detector() -> Any:
    return cv2.createLineSegmentDetector(cv2.LSD_REFINE_STD)


def _edges_of_carpet(lightness: Pixels, carpet: Mask, scale: float) -> FloatArray:
    """Return straight edges (N, 4) with carpet on their dark side, directed so that the light side is on the left."""
    found = _detector().detect(np.ascontiguousarray(lightness))[0]
    edges = np.reshape([] if found is None else found, (-1, 4)).astype(float)
    edges = edges[_lengths(edges) >= SHORTEST * scale]
    points = (
        edges[:, None, :2] + np.linspace(0.1, 0.9, SAMPLES)[:, None] * (edges[:, 2:] - edges[:, :2])[:, None]
    )
    aside = BESIDE * scale * _left_of(edges)[:, None]
    left, right = (_values_at(lightness, points + sign * aside).mean(axis=1) for sign in (1, -1))
    edges = np.where((left < right)[:, None], edges[:, [2, 3, 0, 1]], edges)
    aside = np.where((left < right)[:, None, None], -aside, aside)
    beside = _values_at(carpet, points - aside).mean(axis=1) >= SHARE
    return np.asarray(edges[beside & (np.abs(left - right) >= CONTRAST)])


def _values_at(plane: npt.NDArray[Any], points: FloatArray) -> npt.NDArray[Any]:
    """Return the values (...) of a plane (H, W) at the pixels nearest to points (..., 2), clipped to the picture."""
    u, v = np.moveaxis(np.rint(points).astype(np.intp), -1, 0)
    return plane[np.clip(v, 0, plane.shape[0] - 1), np.clip(u, 0, plane.shape[1] - 1)]


# --- centre lines ---


def _centre_lines(edges: FloatArray, view: CameraView, scale: float, line_width: float) -> FloatArray:
    """Return the centre lines (M, 4) between edges (N, 4) that face each other at most the width of a line apart."""
    direction, left = _directions(edges), _left_of(edges)
    i, j = np.nonzero(np.triu(direction @ direction.T <= -PARALLEL))
    midpoint_j = (edges[j, :2] + edges[j, 2:]) / 2
    width = ((midpoint_j - edges[i, :2]) * left[i]).sum(axis=1)
    facing = (width > 0.5 * scale) & (width <= _widest(midpoint_j, view, scale, line_width))
    i, j = i[facing], j[facing]
    axis = direction[i] - direction[j]
    axis = axis / np.linalg.norm(axis, axis=1, keepdims=True)
    begin_i, end_i = ((edges[i, k : k + 2] * axis).sum(axis=1) for k in (0, 2))
    begin_j, end_j = ((edges[j, k : k + 2] * axis).sum(axis=1) for k in (2, 0))
    begin, end = np.maximum(begin_i, begin_j), np.minimum(end_i, end_j)
    both = end - begin >= SHORTEST * scale
    i, j, axis, begin, end = i[both], j[both], axis[both], begin[both], end[both]
    ends = [(_point_at(edges[i], axis, at) + _point_at(edges[j], axis, at)) / 2 for at in (begin, end)]
    return np.hstack(ends).reshape(-1, 4)


def _point_at(edges: FloatArray, axis: FloatArray, at: FloatArray) -> FloatArray:
    """Return the points (N, 2) of edges whose coordinate along an axis is `at`."""
    first, last = edges[:, :2], edges[:, 2:]
    a, b = (first * axis).sum(axis=1), (last * axis).sum(axis=1)
    return np.asarray(first + ((at - a) / (b - a))[:, None] * (last - first))


def _widest(points: FloatArray, view: CameraView, scale: float, line_width: float) -> FloatArray:
    """Return the largest apparent width (N,) of a line at points (N, 2), px; 0 above the horizon."""
    distance = np.hypot(view.height, np.hypot(*to_ground(points, view).T))
    return np.nan_to_num(WIDER * view.focal[0] * line_width / distance + SLACK * scale, nan=0.0)


def to_ground(points: FloatArray, view: CameraView) -> FloatArray:
    """Return the points on the ground (N, 2) that undistorted pixels show; NaN at the horizon.

    The points are in metres and relative to the point below the camera, with the axes of the robot frame.
    """
    right, below = ((points - view.centre) / view.focal).T
    rays = (view.rotation @ [np.ones(len(right)), -right, -below]).T
    falling = np.where(rays[:, 2] < -0.03, -rays[:, 2], np.nan)
    return np.asarray(view.height * rays[:, :2] / falling[:, None])


def _merge(segments: FloatArray, scale: float) -> FloatArray:
    """Merge the segments that lie on one straight line, starting with the longest segment."""
    lines, free = [], segments[np.argsort(-_lengths(segments), kind="stable")]
    while len(free):
        merged = np.arange(len(free)) == 0
        line = free[0]
        while True:
            joined = merged | _on(free, line, scale)
            if (joined == merged).all():
                break
            merged, line = joined, _fit(free[joined])
        lines.append(line)
        free = free[~merged]
    return np.array(lines).reshape(-1, 4)


def _on(segments: FloatArray, line: FloatArray, scale: float) -> Mask:
    """Return for each segment (N, 4) whether it lies on a line (4,) or just beyond one of its ends."""
    direction, left = _directions(line[None])[0], _left_of(line[None])[0]
    ends = segments.reshape(-1, 2, 2) - line[:2]
    along, beside = ends @ direction, np.abs(ends @ left)
    gap = np.maximum(along.min(axis=1) - _lengths(line[None])[0], -along.max(axis=1))
    return np.asarray((beside.max(axis=1) <= ASIDE * scale) & (gap <= GAP * scale))


def _fit(segments: FloatArray) -> FloatArray:
    """Fit a line (4,) to segments, weighted by their lengths; it ends at their outermost ends."""
    ends, weight = segments.reshape(-1, 2), np.repeat(_lengths(segments), 2)
    centre = weight @ ends / weight.sum()
    offset = ends - centre
    direction = np.linalg.svd(offset * np.sqrt(weight)[:, None], full_matrices=False)[2][0]
    along = offset @ direction
    return np.concatenate([centre + along.min() * direction, centre + along.max() * direction])


def _without_duplicates(points: FloatArray, strength: FloatArray, radius: float) -> FloatArray:
    """Return the points (K, 2) that are not within `radius` of a stronger point."""
    kept: list[FloatArray] = []
    for point in points[np.argsort(-strength, kind="stable")]:
        if not any(np.linalg.norm(point - other) <= radius for other in kept):
            kept.append(point)
    return np.array(kept).reshape(-1, 2)


def _lengths(lines: FloatArray) -> FloatArray:
    """Return the lengths (N,) of lines, px."""
    return np.asarray(np.hypot(lines[:, 2] - lines[:, 0], lines[:, 3] - lines[:, 1]))


def _directions(lines: FloatArray) -> FloatArray:
    """Return unit vectors (N, 2) from the first end of each line to the second."""
    return np.asarray((lines[:, 2:] - lines[:, :2]) / np.maximum(_lengths(lines), 1e-9)[:, None])


def _left_of(lines: FloatArray) -> FloatArray:
    """Return unit vectors (N, 2) to the left of each line's direction, in a picture whose rows count downwards."""
    return _directions(lines)[:, ::-1] * (1, -1)


def _cross(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the cross products (N,) of vectors (N, 2)."""
    return np.asarray(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
