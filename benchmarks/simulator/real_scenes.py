"""The real pictures with their geometry, and the simulator's twin of each.

`real_geometry.json` has the camera of each set, and pitch, roll and pose (x, y, heading) of each picture, in m and rad.
They were fitted once to the marked points and to the white lines.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.datasets import RealPicture, read_pictures
from nao_course.field_slam.lines import to_ground
from nao_course.geometry import FloatArray, Pose
from nao_course.sim import DIMENSIONS, NAO_V4, Field
from nao_course.sim.camera import CameraView
from nao_course.sim.reality import Reality
from nao_course.sim.render import render

Pixels = npt.NDArray[np.uint8]
Mask = npt.NDArray[np.bool_]

# The field of the real pictures has the 2012 rules, but its lines are 3.95 cm wide as measured.
FIELD = Field(replace(DIMENSIONS[2012], line_width=0.0395), half=False)
ROOMS = 4  # the twins are spread over so many of the simulator's rooms
AROUND = 4  # px around lines and posts that count as theirs
GEOMETRY = Path(__file__).with_name("real_geometry.json")


class Geometry:
    """Where lines, posts, carpet and background are in a picture."""

    def __init__(self, view: CameraView, pose: Pose, field: Field = FIELD) -> None:
        self.view, self.pose, self.field = view, pose, field
        self.eye = pose.to_parent([view.offset])[0]  # the camera over the ground, field frame, m

    @cached_property
    def ground(self) -> FloatArray:
        """The point of the ground that each pixel shows (H, W, 2), field frame in m; NaN above the horizon."""
        width, height = self.view.size
        u, v = np.meshgrid(np.arange(width), np.arange(height))
        flat = self.view.undistort(np.column_stack([u.ravel(), v.ravel()]))
        robot = to_ground(flat, self.view) + self.view.offset
        return self.pose.to_parent(robot).reshape(height, width, 2)

    @cached_property
    def distance(self) -> FloatArray:
        """The distance from the camera to each pixel's ground (H, W), m; infinite above the horizon."""
        away = np.hypot(*np.moveaxis(self.ground - self.eye, -1, 0))
        return np.where(np.isnan(away), np.inf, away)

    @cached_property
    def outside(self) -> FloatArray:
        """How far each pixel's ground is outside the lines' rectangle (H, W), m; infinite above the horizon."""
        (x0, x1), (y0, y1) = self.field.x_range, self.field.y_range
        x, y = self.ground[..., 0], self.ground[..., 1]
        far = np.maximum(np.maximum(x0 - x, x - x1), np.maximum(y0 - y, y - y1))
        return np.where(np.isnan(far), np.inf, far)

    def _posts(self, wider: float = 0.0, part: float = 1.0, foot: float = 0.0) -> Pixels:
        """Paint posts and bars: `part` of their width and `wider` metres on each side, from `foot` m above ground."""
        d = self.field.dimensions
        mask = np.zeros(self.view.size[::-1], np.uint8)
        for x, y in self.field.posts:
            towards = np.array([x, y]) - self.eye
            aside = np.array([-towards[1], towards[0]]) / max(np.hypot(*towards), 1e-9)
            half = aside * (d.post_diameter / 2 * part + wider)
            axis = np.array([[x, y, z] for z in np.linspace(foot, d.post_height, 24)])
            self._strip(mask, axis, [*half, 0.0])
        for start, end in self.field.bars if part == 1.0 else ():
            self._strip(mask, np.linspace(start, end, 24), [0.0, 0.0, d.bar_diameter / 2 + wider])
        return mask

    def _strip(self, mask: Pixels, axis: FloatArray, half: Sequence[float]) -> None:
        sides = [self.view.project(axis + sign * np.asarray(half), self.pose) for sign in (1, -1)]
        outline = np.concatenate([sides[0], sides[1][::-1]])
        outline = outline[np.isfinite(outline).all(axis=1)]
        if len(outline) >= 3 and np.abs(outline).max() < 20000:
            cv2.fillPoly(mask, [np.rint(outline).astype(np.int32)], 1)

    @cached_property
    def near_posts(self) -> Mask:
        """Pixels of posts and bars, and some around them."""
        size = 2 * AROUND + 1
        return np.asarray(cv2.dilate(self._posts(0.02), np.ones((size, size), np.uint8)) > 0)

    @cached_property
    def near_lines(self) -> Mask:
        """Pixels of lines and marks, and some around them."""
        mask = np.zeros(self.view.size[::-1], np.uint8)
        points = _line_points(self.field)
        pixels = self.view.project(points, self.pose)
        away = np.hypot(np.maximum(np.hypot(*(points - self.eye).T), 0.1), self.view.height)
        radius = self.view.focal[0] * self.field.dimensions.line_width / 2 / away + AROUND
        inside = np.isfinite(pixels).all(axis=1) & (np.abs(pixels) < 4 * self.view.size[0]).all(axis=1)
        for (u, v), r in zip(pixels[inside], radius[inside], strict=True):
            cv2.circle(mask, (round(u), round(v)), int(np.ceil(r)), 1, -1)
        return np.asarray(mask > 0)

    @cached_property
    def carpet(self) -> Mask:
        """Pixels that are plain carpet, up to 0.25 m outside the lines and 4.5 m away."""
        return (self.outside < 0.25) & (self.distance < 4.5) & ~self.near_lines & ~self.near_posts

    @cached_property
    def background(self) -> Mask:
        """Pixels above or beyond the carpet: the ground more than 0.95 m outside the lines, and all above it."""
        return np.asarray(self.outside > 0.95) & ~self.near_posts

    @cached_property
    def post_core(self) -> Mask:
        """The middle three fifths of the posts, from 5 cm above the ground."""
        return np.asarray(self._posts(part=0.6, foot=0.05) > 0)


def _line_points(field: Field) -> FloatArray:
    """Return points (N, 2) every 2 cm on lines and arcs, and a grid on each mark."""
    points = [
        (x0, y0) + np.arange(0.0, length + 1e-9, 0.02)[:, None] * np.array([x1 - x0, y1 - y0]) / length
        for x0, y0, x1, y1 in field.lines
        for length in (float(np.hypot(x1 - x0, y1 - y0)),)
    ]
    for x, y, radius, first, last in field.arcs:
        angle = np.arange(first, last, 0.02 / radius)
        points.append((x, y) + radius * np.column_stack([np.cos(angle), np.sin(angle)]))
    steps = np.linspace(-0.1, 0.1, 5)
    points += [np.array([(x + dx, y + dy) for dx in steps for dy in steps]) for x, y in field.marks]
    return np.concatenate(points)


@dataclass(frozen=True)
class RealScene:
    """A real picture with its fitted geometry."""

    picture: RealPicture
    view: CameraView
    pose: Pose

    def geometry(self) -> Geometry:
        """Return the geometry."""
        return Geometry(self.view, self.pose)

    def twin(self, look: Reality, seed: int) -> Pixels:
        """Render the simulator's picture from the same view and pose, in one of four rooms."""
        room = replace(look, seed=look.seed + seed % ROOMS)
        return render(FIELD, self.pose, self.view, room, np.random.default_rng(seed))[0]


def real_scenes() -> tuple[RealScene, ...]:
    """Return all 94 real pictures with their geometry."""
    scenes = []
    for name, fitted in json.loads(GEOMETRY.read_text(encoding="utf-8")).items():
        for picture in read_pictures(name):
            pitch, roll, *pose = fitted["pictures"][picture.name]
            specified = NAO_V4.view("bottom", picture.head_yaw, picture.head_pitch)
            view = replace(specified, **fitted["camera"], pitch=pitch, roll=roll)
            scenes.append(RealScene(picture, view, Pose(*pose)))
    return tuple(scenes)
