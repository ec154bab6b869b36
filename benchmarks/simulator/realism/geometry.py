"""Where a picture shows the field: its lines, posts, carpet and background, from the camera's view and pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import cv2
import numpy as np
import numpy.typing as npt
from scipy.spatial import cKDTree

from nao_course.geometry import FloatArray, Pose
from nao_course.sim import DIMENSIONS, Field
from nao_course.sim.camera import CameraView

Pixels = npt.NDArray[np.uint8]
Mask = npt.NDArray[np.bool_]


# The field of the real pictures: that of the 2012 rules, except for the width of the lines, which are 3.95 cm wide as
# measured ("line width cm": 3.9 to 4.1 in all pictures, at both sizes).
FIELD = Field(replace(DIMENSIONS[2012], line_width=0.0395), half=False)
SMALL = 320  # px: lengths in pixels below are meant at this width, and grow with the picture


@dataclass(frozen=True)
class Lines:
    """Points along the field's lines as a picture shows them.

    Parameters
    ----------
    point : ndarray, shape (N, 2)
        On a line's middle, field frame, metres.
    pixel, normal : ndarray, shape (N, 2)
        Half way between the line's edges in the picture, and the direction across it there (unit length).
    half_width : ndarray, shape (N,)
        From the middle to the edge along the normal, pixels.
    distance : ndarray, shape (N,)
        Over the ground from the camera, metres.
    across : ndarray, shape (N,)
        Whether the line lies across the view (its normal within 30 degrees of upright).
    clear : ndarray, shape (N,)
        Whether no other line, mark or post is near, on the field or in the picture.
    """

    point: FloatArray
    pixel: FloatArray
    normal: FloatArray
    half_width: FloatArray
    distance: FloatArray
    across: Mask
    clear: Mask

    def chosen(self, keep: Mask) -> Lines:
        """Return some of the points."""
        return Lines(*(getattr(self, name)[keep] for name in self.__dataclass_fields__))


class Geometry:
    """Where lines, posts, carpet and background fall in a picture."""

    def __init__(self, view: CameraView, pose: Pose, field: Field = FIELD) -> None:
        self.view, self.pose, self.field = view, pose, field
        self.scale = view.size[0] / SMALL

    @cached_property
    def eye(self) -> FloatArray:
        """The camera over the ground (2,), field frame, metres."""
        return self.pose.to_parent([self.view.offset])[0]

    @cached_property
    def lines(self) -> Lines:
        """Points along all lines that are well inside the picture."""
        points, ways, clear, line = _line_points(self.field)
        middle = self.view.project(points, self.pose)
        margin = 4 * self.scale
        u, v = middle.T
        width, height = self.view.size
        with np.errstate(invalid="ignore"):
            keep = (u > margin) & (v > margin) & (u < width - 1 - margin) & (v < height - 1 - margin)
        clear = clear & (_to_other_lines(middle, line) > 5.5 * self.scale)
        points, ways, clear, middle = points[keep], ways[keep], clear[keep], middle[keep]
        along = self.view.project(points + 0.01 * ways, self.pose) - self.view.project(
            points - 0.01 * ways, self.pose
        )
        along /= np.maximum(np.hypot(*along.T), 1e-9)[:, None]
        normal = np.column_stack([-along[:, 1], along[:, 0]])
        half = self.field.dimensions.line_width / 2 * np.column_stack([-ways[:, 1], ways[:, 0]])
        edges = [self.view.project(points + sign * half, self.pose) - middle for sign in (1, -1)]
        first, second = ((edge * normal).sum(axis=1) for edge in edges)
        half_width = np.abs(first - second) / 2
        middle = middle + (first + second)[:, None] / 2 * normal  # the nearer half of a line looks wider
        distance = np.hypot(*(points - self.eye).T)
        good = np.isfinite(half_width)
        if len(middle):
            row, column = np.rint(middle[:, ::-1]).astype(int).T
            clear = clear & ~self.near_posts[row, column]
        return Lines(
            points, middle, normal, half_width, distance, np.abs(normal[:, 1]) > 0.866, clear
        ).chosen(good)

    @cached_property
    def ground(self) -> FloatArray:
        """What each pixel shows of the ground (H, W, 2), field frame in metres; NaN above the horizon."""
        width, height = self.view.size
        u, v = np.meshgrid(np.arange(width), np.arange(height))
        flat = self.view.undistort(np.column_stack([u.ravel(), v.ravel()]))
        right, down = ((flat - self.view.centre) / self.view.focal).T
        rays = np.column_stack([np.ones_like(right), -right, -down]) @ self.view.rotation.T
        with np.errstate(divide="ignore", invalid="ignore"):
            scale = np.where(rays[:, 2] < -1e-6, -self.view.height / rays[:, 2], np.nan)
        robot = rays[:, :2] * scale[:, None] + self.view.offset
        return self.pose.to_parent(robot).reshape(height, width, 2)

    def outside(self) -> FloatArray:
        """Return how far each pixel's ground is outside the lines' rectangle (H, W), m; infinite above the horizon."""
        (x0, x1), (y0, y1) = self.field.x_range, self.field.y_range
        x, y = self.ground[..., 0], self.ground[..., 1]
        far = np.maximum(np.maximum(x0 - x, x - x1), np.maximum(y0 - y, y - y1))
        return np.where(np.isnan(far), np.inf, far)

    @cached_property
    def distance(self) -> FloatArray:
        """From the camera to each pixel's ground (H, W), metres."""
        away = np.hypot(self.ground[..., 0] - self.eye[0], self.ground[..., 1] - self.eye[1])
        return np.where(np.isnan(away), np.inf, away)

    def _posts(self, wider: float = 0.0, part: float = 1.0, foot: float = 0.0) -> Pixels:
        """Paint posts and bars: `part` of their width and `wider` metres on each side, from `foot` m above ground."""
        d = self.field.dimensions
        mask = np.zeros(self.view.size[::-1], np.uint8)
        for x, y in self.field.posts:
            towards = np.array([x, y]) - self.eye
            aside = np.array([-towards[1], towards[0]]) / max(np.hypot(*towards), 1e-9)
            half = aside * (d.post_diameter / 2 * part + wider)
            self._strip(
                mask, np.array([[x, y, z] for z in np.linspace(foot, d.post_height, 24)]), [*half, 0.0]
            )
        if part == 1.0:
            for start, end in self.field.bars:
                self._strip(mask, np.linspace(start, end, 24), [0.0, 0.0, d.bar_diameter / 2 + wider])
        return mask

    def _strip(self, mask: Pixels, axis: FloatArray, half: Sequence[float]) -> None:
        """Paint a strip along an axis (N, 3)."""
        sides = [self.view.project(axis + sign * np.asarray(half), self.pose) for sign in (1, -1)]
        outline = np.concatenate([sides[0], sides[1][::-1]])
        outline = outline[np.isfinite(outline).all(axis=1)]
        if len(outline) >= 3 and np.abs(outline).max() < 20000:
            cv2.fillPoly(mask, [np.rint(outline).astype(np.int32)], 1)

    @cached_property
    def near_posts(self) -> Mask:
        """Pixels of posts and bars, and some around them."""
        size = int(np.ceil(4 * self.scale)) * 2 + 1
        return np.asarray(cv2.dilate(self._posts(0.02), np.ones((size, size), np.uint8)) > 0)

    @cached_property
    def near_lines(self) -> Mask:
        """Pixels of lines and marks, and some around them."""
        mask = np.zeros(self.view.size[::-1], np.uint8)
        margin = 4 * self.scale
        d = self.field.dimensions
        points = _line_points(self.field)[0]
        marks = np.array([(x + dx, y + dy) for x, y in self.field.marks for dx in _MARK for dy in _MARK])
        points = np.concatenate([points, marks])
        pixels = self.view.project(points, self.pose)
        away = np.maximum(np.hypot(*(points - self.eye).T), 0.1)
        radius = self.view.focal[0] * d.line_width / 2 / np.hypot(away, self.view.height) + margin
        inside = np.isfinite(pixels).all(axis=1) & (np.abs(pixels) < 4 * self.view.size[0]).all(axis=1)
        for (u, v), r in zip(pixels[inside], radius[inside], strict=True):
            cv2.circle(mask, (round(u), round(v)), int(np.ceil(r)), 1, -1)
        return np.asarray(mask > 0)

    @cached_property
    def carpet(self) -> Mask:
        """Pixels that are plain carpet, up to 0.25 m outside the lines and 4.5 m away."""
        return (self.outside() < 0.25) & (self.distance < 4.5) & ~self.near_lines & ~self.near_posts

    @cached_property
    def border(self) -> Mask:
        """Pixels of the ground from 0.3 to 0.65 m outside the lines, up to 5 m away."""
        outside = self.outside()
        return (outside > 0.3) & (outside < 0.65) & (self.distance < 5) & ~self.near_posts

    @cached_property
    def background(self) -> Mask:
        """Pixels above or beyond the carpet: the ground more than 0.95 m outside the lines, and all above it."""
        return np.asarray(self.outside() > 0.95) & ~self.near_posts

    @cached_property
    def post_core(self) -> Mask:
        """The middle three fifths of the posts, from 5 cm above the ground."""
        return np.asarray(self._posts(part=0.6, foot=0.05) > 0)


_MARK = (-0.1, -0.05, 0.0, 0.05, 0.1)


@lru_cache(maxsize=4)
def _line_points(field: Field) -> tuple[FloatArray, FloatArray, Mask, npt.NDArray[np.intp]]:
    """Return points (N, 2) every 2 cm on centre lines, their directions, whether they are isolated, and their line."""
    points, ways = [], []
    for x0, y0, x1, y1 in field.lines:
        length = float(np.hypot(x1 - x0, y1 - y0))
        steps = np.arange(0.0, length + 1e-9, 0.02)[:, None]
        way = np.array([x1 - x0, y1 - y0]) / length
        points.append((x0, y0) + steps * way)
        ways.append(np.tile(way, (len(steps), 1)))
    for x, y, radius, first, last in field.arcs:
        angle = np.arange(first, last, 0.02 / radius)
        points.append((x, y) + radius * np.column_stack([np.cos(angle), np.sin(angle)]))
        ways.append(np.column_stack([-np.sin(angle), np.cos(angle)]))
    clear = []
    for i, these in enumerate(points):
        others = [other for j, other in enumerate(points) if j != i]
        others.append(field.marks + 1e-9)
        rest = np.concatenate(others)
        apart = np.concatenate(
            [
                np.hypot(*(p[:, None] - rest).transpose(2, 0, 1)).min(axis=1)
                for p in np.array_split(these, max(1, len(these) // 100))
            ]
        )
        to_mark = np.hypot(*(these[:, None] - field.marks[None]).transpose(2, 0, 1)).min(axis=1)
        clear.append((apart > 0.12) & (to_mark > 0.2))
    line = np.repeat(np.arange(len(points)), [len(these) for these in points])
    return np.concatenate(points), np.concatenate(ways), np.concatenate(clear), line


def _to_other_lines(pixels: FloatArray, line: npt.NDArray[np.intp]) -> FloatArray:
    """Return the distance (N,) in the picture of each point from the nearest point of another line."""
    near = np.full(len(pixels), np.inf)
    known = np.isfinite(pixels).all(axis=1)
    for this in np.unique(line[known]):
        own, others = known & (line == this), known & (line != this)
        if others.any():
            near[own] = cKDTree(pixels[others]).query(pixels[own])[0]
    return near
