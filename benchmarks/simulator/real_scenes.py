"""The real pictures with their geometry, profiles across their lines, and the simulator's twin of each."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property, lru_cache
from typing import get_args

import cv2
import numpy as np
import numpy.typing as npt
from scipy import ndimage
from scipy.optimize import least_squares
from scipy.spatial import cKDTree

from benchmarks import BUILD
from benchmarks.simulator import reality
from nao_course.datasets import PictureSet, RealPicture, read_pictures
from nao_course.geometry import FloatArray, Pose
from nao_course.sim import DIMENSIONS, Field
from nao_course.sim.camera import CameraView
from nao_course.sim.reality import Reality
from nao_course.sim.render import PictureTruth, render

Pixels = npt.NDArray[np.uint8]
Mask = npt.NDArray[np.bool_]

# The field of the real pictures: that of the 2012 rules, except for the lines, which are 3.95 cm wide as measured.
FIELD = Field(replace(DIMENSIONS[2012], line_width=0.0395), half=False)
ROOMS = 4  # the twins are spread over so many of the simulator's rooms
STEP, REACH = 0.125, 8.0  # px at 320 wide: between the values of a profile, and beyond a line's edge
# What a picture's geometry may deviate from its set's: pitch, roll, heading (rad) and x, y (m).
PRIOR = np.array([np.radians(1.3), np.radians(1.0), np.radians(2.5), 0.06, 0.06])
CACHE = BUILD / "realism_geometry.json"


# --- where a picture shows what ---


@dataclass(frozen=True)
class Lines:
    """Points along the field's lines as a picture shows them."""

    point: FloatArray  # (N, 2): on a line's middle, field frame, m
    # (N, 2): half way between the line's edges in the picture, and the unit vector across the line there
    pixel: FloatArray
    normal: FloatArray
    half_width: FloatArray  # (N,): from the middle to the edge along the normal, px
    distance: FloatArray  # (N,): over the ground from the camera, m
    across: Mask  # (N,): whether the line lies across the view (its normal within 30 degrees of upright)
    clear: Mask  # (N,): whether no other line, mark or post is near, on the field or in the picture

    def chosen(self, keep: Mask) -> Lines:
        """Return some of the points."""
        return Lines(*(getattr(self, name)[keep] for name in self.__dataclass_fields__))


class Geometry:
    """Where lines, posts, carpet and background fall in a picture; lengths in px are meant at a width of 320."""

    def __init__(self, view: CameraView, pose: Pose, field: Field = FIELD) -> None:
        self.view, self.pose, self.field = view, pose, field
        self.scale = view.size[0] / 320
        self.eye = pose.to_parent([view.offset])[0]  # the camera over the ground, field frame, m

    @cached_property
    def lines(self) -> Lines:
        """Points along all lines that are well inside the picture."""
        points, ways, clear, line = _line_points(self.field)
        middle = self.view.project(points, self.pose)
        margin = 4 * self.scale
        with np.errstate(invalid="ignore"):
            keep = ((middle > margin) & (middle < np.array(self.view.size) - 1 - margin)).all(axis=1)
        clear = clear & (_to_other_lines(middle, line) > 5.5 * self.scale)
        points, ways, clear, middle = points[keep], ways[keep], clear[keep], middle[keep]
        ahead, behind = (self.view.project(points + sign * 0.01 * ways, self.pose) for sign in (1, -1))
        along = (ahead - behind) / np.maximum(np.hypot(*(ahead - behind).T), 1e-9)[:, None]
        normal = np.column_stack([-along[:, 1], along[:, 0]])
        half = self.field.dimensions.line_width / 2 * np.column_stack([-ways[:, 1], ways[:, 0]])
        edges = [self.view.project(points + sign * half, self.pose) - middle for sign in (1, -1)]
        first, second = ((edge * normal).sum(axis=1) for edge in edges)
        half_width = np.abs(first - second) / 2
        middle = middle + (first + second)[:, None] / 2 * normal  # the nearer half of a line looks wider
        distance = np.hypot(*(points - self.eye).T)
        if len(middle):
            row, column = np.rint(middle[:, ::-1]).astype(int).T
            clear = clear & ~self.near_posts[row, column]
        lines = Lines(points, middle, normal, half_width, distance, np.abs(normal[:, 1]) > 0.866, clear)
        return lines.chosen(np.isfinite(half_width))

    @cached_property
    def ground(self) -> FloatArray:
        """What each pixel shows of the ground (H, W, 2), field frame in m; NaN above the horizon."""
        width, height = self.view.size
        u, v = np.meshgrid(np.arange(width), np.arange(height))
        flat = self.view.undistort(np.column_stack([u.ravel(), v.ravel()]))
        right, down = ((flat - self.view.centre) / self.view.focal).T
        rays = np.column_stack([np.ones_like(right), -right, -down]) @ self.view.rotation.T
        with np.errstate(divide="ignore", invalid="ignore"):
            scale = np.where(rays[:, 2] < -1e-6, -self.view.height / rays[:, 2], np.nan)
        robot = rays[:, :2] * scale[:, None] + self.view.offset
        return self.pose.to_parent(robot).reshape(height, width, 2)

    @cached_property
    def outside(self) -> FloatArray:
        """How far each pixel's ground is outside the lines' rectangle (H, W), m; infinite above the horizon."""
        (x0, x1), (y0, y1) = self.field.x_range, self.field.y_range
        x, y = self.ground[..., 0], self.ground[..., 1]
        far = np.maximum(np.maximum(x0 - x, x - x1), np.maximum(y0 - y, y - y1))
        return np.where(np.isnan(far), np.inf, far)

    @cached_property
    def distance(self) -> FloatArray:
        """From the camera to each pixel's ground (H, W), m."""
        away = np.hypot(*np.moveaxis(self.ground - self.eye, -1, 0))
        return np.where(np.isnan(away), np.inf, away)

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
        steps = (-0.1, -0.05, 0.0, 0.05, 0.1)
        marks = np.array([(x + dx, y + dy) for x, y in self.field.marks for dx in steps for dy in steps])
        points = np.concatenate([_line_points(self.field)[0], marks])
        pixels = self.view.project(points, self.pose)
        away = np.hypot(np.maximum(np.hypot(*(points - self.eye).T), 0.1), self.view.height)
        radius = self.view.focal[0] * self.field.dimensions.line_width / 2 / away + 4 * self.scale
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
    line = np.repeat(np.arange(len(points)), [len(these) for these in points])
    every = np.concatenate(points)
    to_mark = cKDTree(field.marks).query(every)[0]
    clear = (np.minimum(_to_other_lines(every, line), to_mark) > 0.12) & (to_mark > 0.2)
    return every, np.concatenate(ways), clear, line


def _to_other_lines(points: FloatArray, line: npt.NDArray[np.intp]) -> FloatArray:
    """Return the distance (N,) of each point from the nearest point of another line."""
    near = np.full(len(points), np.inf)
    known = np.isfinite(points).all(axis=1)
    for this in np.unique(line[known]):
        own, others = known & (line == this), known & (line != this)
        if others.any():
            near[own] = cKDTree(points[others]).query(points[own])[0]
    return near


# --- profiles across lines ---


class Picture:
    """A picture's lightness, read between pixels by cubic splines."""

    def __init__(self, pixels: Pixels) -> None:
        self.pixels = pixels
        self.hls = np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGB2HLS))
        self.lightness = self.hls[..., 1].astype(float)
        hue, saturation = self.hls[..., 0], self.hls[..., 2]
        self.greenish = (saturation > 0.16 * 255) & (hue > 35) & (hue < 90)

    @cached_property
    def _spline(self) -> FloatArray:
        return np.asarray(ndimage.spline_filter(self.lightness, order=3))

    def read(self, places: FloatArray) -> FloatArray:
        """Return the lightness at positions (..., 2) as (u, v)."""
        where = np.moveaxis(places[..., ::-1], -1, 0)
        return np.asarray(
            ndimage.map_coordinates(self._spline, where, order=3, mode="nearest", prefilter=False)
        )

    def nearest(self, plane: npt.NDArray[np.generic], places: FloatArray) -> npt.NDArray[np.generic]:
        """Return the values of a plane (H, W) at the pixels that are nearest to positions (..., 2)."""
        height, width = plane.shape
        u, v = np.moveaxis(np.rint(places).astype(int), -1, 0)
        return plane[np.clip(v, 0, height - 1), np.clip(u, 0, width - 1)]


@dataclass(frozen=True)
class Profiles:
    """Profiles (N, K) across lines, and what follows from each."""

    # (N,): middle and full width at half height of the bright peak, px from where the line should be
    centre: FloatArray
    width: FloatArray
    base: FloatArray  # (N,): lightness of the carpet on both sides, and the greatest within the peak
    peak: FloatArray
    on_carpet: Mask  # (N,): whether there is carpet on both sides; and between them a peak
    good: Mask


def line_profiles(picture: Picture, lines: Lines, scale: float, search: float) -> Profiles:
    """Read a profile across every line point; a peak is looked for within `search` px (at 320) of the middle."""
    half = lines.half_width[:, None]
    reach = float(lines.half_width.max(initial=1.0)) + (REACH + search) * scale
    offsets = np.arange(-reach, reach + 1e-9, STEP * scale)
    places = lines.pixel[:, None] + offsets[:, None] * lines.normal[:, None]
    values = np.clip(picture.read(places), 0, 255)  # a spline overshoots beside what is overexposed
    height, width = picture.lightness.shape
    values[((places < 0) | (places > (width - 1, height - 1))).any(axis=2)] = np.nan
    green = picture.nearest(picture.greenish, places)
    # Carpet: from 1 to 3 px (at 320) beyond the edges, and as much more as the line may be off.
    beyond = np.abs(offsets)[None] - half
    beside = (beyond > (1.0 + search / 2) * scale) & (beyond < (3.0 + search / 2) * scale)
    sides = beside & (offsets < 0), beside & (offsets > 0)
    base = (masked_median(values, sides[0]) + masked_median(values, sides[1])) / 2
    left, right = ((green & side).sum(axis=1) > 0.7 * np.maximum(side.sum(axis=1), 1) for side in sides)
    candidates = np.where(np.abs(offsets)[None] <= search * scale + half, values, -np.inf)
    candidates[np.isnan(candidates)] = -np.inf
    top = candidates.argmax(axis=1)
    peak = values[np.arange(len(values)), top]
    level = (base + peak) / 2
    with np.errstate(invalid="ignore"):
        low, high = (crossing(offsets, values, top, level, way) for way in (-1, 1))
        good = (peak - base > 10) & left & right & np.isfinite(low + high)
    return Profiles((low + high) / 2, high - low, base, peak, left & right, good)


def masked_median(values: FloatArray, mask: Mask) -> FloatArray:
    """Return the median of the chosen values of each row; NaN if there are none."""
    chosen = np.sort(np.where(mask & ~np.isnan(values), values, np.inf), axis=1)
    count, rows = np.isfinite(chosen).sum(axis=1), np.arange(len(values))
    middle = (chosen[rows, np.maximum(count - 1, 0) // 2] + chosen[rows, np.maximum(count, 1) // 2]) / 2
    return np.where(count > 1, middle, np.nan)


def crossing(
    offsets: FloatArray,
    values: FloatArray,
    start: npt.NDArray[np.intp],
    level: FloatArray,
    direction: int = 1,
) -> FloatArray:
    """Return the offset (N,) at which each row, from `start` on, first falls to `level`; NaN if it does not."""
    if direction < 0:
        return -crossing(-offsets[::-1], values[:, ::-1], values.shape[1] - 1 - start, level)
    with np.errstate(divide="ignore", invalid="ignore"):
        below = (values < level[:, None]) & (np.arange(values.shape[1])[None] > start[:, None])
        first, rows = below.argmax(axis=1), np.arange(len(values))
        after, before = values[rows, first], values[rows, np.maximum(first - 1, 0)]
        part = (before - level) / (before - after)
    found = offsets[np.maximum(first - 1, 0)] + part * (offsets[1] - offsets[0])
    return np.where(below.any(axis=1), found, np.nan)


def thinned(n: int, most: int) -> Mask:
    """Choose every k-th of n, no more than `most`."""
    return np.arange(n) % max(1, -(-n // most)) == 0


# --- the pictures ---


@dataclass(frozen=True)
class RealScene:
    """A real picture with its fitted geometry."""

    picture: RealPicture
    view: CameraView
    pose: Pose

    @property
    def corners(self) -> FloatArray:
        """The L and T points as they were marked (K, 2)."""
        marked = [(p.u, p.v) for p in self.picture.points if p.kind in "LT"]
        return np.array(marked, dtype=float).reshape(-1, 2)

    def geometry(self, size: tuple[int, int] | None = None) -> Geometry:
        """Return the geometry, for a picture of another size if one is given."""
        return Geometry(self.view.at_size(size) if size else self.view, self.pose)


def real_scenes() -> tuple[RealScene, ...]:
    """Return all 94 real pictures with their geometry, which is cached because fitting takes half a minute."""
    scenes = []
    kept = json.loads(CACHE.read_text()) if CACHE.is_file() else {}
    for name in get_args(PictureSet):
        pictures = read_pictures(name)
        if set(kept.get(name, {})) != {picture.name for picture in pictures}:
            kept[name] = {
                scene.picture.name: {"view": asdict(scene.view), "pose": scene.pose.as_array().tolist()}
                for scene in _fit_geometry(name, pictures)
            }
            CACHE.parent.mkdir(exist_ok=True)
            CACHE.write_text(json.dumps(kept))
        for picture in pictures:
            values = kept[name][picture.name]
            view = CameraView(**{**values["view"], "size": tuple(values["view"]["size"])})
            scenes.append(RealScene(picture, view, Pose(*values["pose"])))
    return tuple(scenes)


def _fit_geometry(name: str, pictures: Sequence[RealPicture]) -> list[RealScene]:
    """Fit a set's camera to the marked points, then move every picture's pose onto its lines."""
    moved = reality.corrected_walk(pictures) if name == "straightwalk" else tuple(pictures)
    fit = reality.fit_set(moved, reality.Freedom(position_sd=0.05))
    known = {item.picture.name: c for item, c in zip(fit.matched, fit.corrections, strict=True)}
    mean = np.median(fit.corrections, axis=0)
    scenes = []
    for original, picture in zip(pictures, moved, strict=True):
        correction = _aligned(picture, fit.values, known.get(picture.name, mean), mean)
        scenes.append(RealScene(original, *reality.fitted_view(picture, fit.values, correction)))
    return scenes


def _aligned(picture: RealPicture, values: FloatArray, start: FloatArray, mean: FloatArray) -> FloatArray:
    """Move a picture's pitch, roll, heading (rad) and x, y (m) until the field's lines lie on the white ones."""
    correction = np.clip(start, mean - 2 * PRIOR, mean + 2 * PRIOR)
    bounds = (mean - 3.5 * PRIOR, mean + 3.5 * PRIOR)
    seen = Picture(picture.pixels)
    for search in (0.0, 5.0, 3.0, 2.0):  # first by the marked points alone
        gate = 12.0 if search else 40.0
        matched = reality.match(picture, values, correction, gate) if picture.points else None
        lines, found = _found_lines(seen, *reality.fitted_view(picture, values, correction), search)
        weight = np.sqrt(min(1.0, 60 / max(len(lines.point), 1)))

        def residual(
            state: FloatArray,
            matched: reality.Matched | None = matched,
            lines: Lines = lines,
            found: FloatArray = found,
            weight: float = float(weight),
        ) -> FloatArray:
            view, pose = reality.fitted_view(picture, values, state)
            off = view.project(lines.point, pose) - found
            parts = [(off * lines.normal).sum(axis=1) / 0.5 * weight, (state - mean) / PRIOR]
            if matched is not None:
                marked = view.project(matched.landmarks[matched.used], pose) - matched.pixels[matched.used]
                parts.append(marked.ravel() / 2.0)
            return np.nan_to_num(np.concatenate(parts), nan=20.0)

        correction = np.asarray(
            least_squares(residual, correction, bounds=bounds, loss="soft_l1", x_scale=PRIOR).x
        )
    return correction


def _found_lines(seen: Picture, view: CameraView, pose: Pose, search: float) -> tuple[Lines, FloatArray]:
    """Return the points of lines that are within `search` px of where they should be, and where (N, 2) they are."""
    lines = Geometry(view, pose).lines
    lines = lines.chosen(lines.clear & (lines.distance < 6) & (search > 0))
    lines = lines.chosen(thinned(len(lines.pixel), 400))
    if not len(lines.pixel):
        return lines, np.empty((0, 2))
    profiles = line_profiles(seen, lines, 1.0, search)
    good = profiles.good & (profiles.peak - profiles.base > 25)
    pixel = view.project(lines.point, pose) + np.nan_to_num(profiles.centre)[:, None] * lines.normal
    return lines.chosen(good), pixel[good]


def simulated_twin(
    scene: RealScene, look: Reality, seed: int, size: tuple[int, int] | None = None
) -> tuple[Pixels, PictureTruth]:
    """Render the simulator's picture and its truth from a real picture's view and pose, in one of four rooms."""
    view = scene.view.at_size(size) if size else scene.view
    room = replace(look, seed=look.seed + seed % ROOMS)
    return render(FIELD, scene.pose, view, room, np.random.default_rng(seed))
