"""Do the simulator's pictures look like the real ones? The same instruments measure both.

Every instrument takes a picture and its geometry, so that it knows where lines, posts and carpet are. The real
pictures' geometry is fitted (benchmarks/reality.py) and then moved, a little, onto the white lines themselves; the
simulator renders the whole field from the same view and pose (`simulated_twin`), and one table compares the two.

``python -m benchmarks realism`` measures all 94 pictures, ``python -m benchmarks.realism --quick`` some of them;
`compare` is for a script that tunes the renderer.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, get_args

import cv2
import numpy as np
import numpy.typing as npt
from scipy import ndimage
from scipy.optimize import least_squares
from scipy.spatial import cKDTree

from benchmarks import BUILD, Result, Table, reality
from benchmarks import paper_detector as paper
from nao_course.datasets import PictureSet, RealPicture, read_pictures
from nao_course.geometry import FloatArray, Pose
from nao_course.sim.camera import CameraView
from nao_course.sim.field import Field, FieldDimensions
from nao_course.sim.reality import Reality
from nao_course.sim.render import PictureTruth, render, visible_landmarks

Pixels = npt.NDArray[np.uint8]
Mask = npt.NDArray[np.bool_]


class AmsterdamField(Field):
    """The field of the real pictures: that of the 2012 rules, but for lines that are as wide as they measure."""

    @property
    def dimensions(self) -> FieldDimensions:
        """The rules' row, with lines 3.95 cm wide ("line width cm": 3.9 to 4.1 in all pictures, at both sizes)."""
        return replace(super().dimensions, line_width=0.0395)


FIELD = AmsterdamField(2012, half=False)
SMALL = 320  # px: lengths in pixels below are meant at this width, and grow with the picture

# --- what is measured, in the tables' order ---

GROUPS: dict[str, tuple[str, ...]] = {
    "carpet's colour": (
        *(f"hue {q} %" for q in (1, 5, 50, 95, 99)),
        *(f"lightness {q} %" for q in (5, 25, 50, 75, 95)),
        *("saturation mean", "red", "green", "blue", "picture's mean lightness", "foreign on carpet %"),
    ),
    "carpet's light": (
        *("left / centre", "right / centre", "sides / centre", "far / near lightness"),
        *("bottom corners / bottom", "patch contrast 8 px", "patch contrast 24 px"),
    ),
    "noise and texture on carpet": (
        *(f"noise sd, {where}, {block}x{block}" for where in ("near", "far") for block in (1, 2, 4, 8)),
        *("grain sd", "grain sd, near", "grain sd, far"),
        *(f"noise sd {channel}" for channel in ("red", "green", "blue", "luma", "Cb", "Cr")),
        *("correlation next column", "correlation next row", "correlation 2 columns", "correlation 2 rows"),
        *("correlation red-green", "correlation green-blue", "correlation red-blue"),
        *("bright specks per 10000 px", "dark specks per 10000 px"),
    ),
    "line edges": (
        *("rise px", "rise px, across columns", "rise px, across rows", "chroma rise px"),
        *("overshoot on the line", "undershoot on the carpet", "line width cm"),
        *("red edge outwards, px", "blue edge outwards, px"),
    ),
    "lines by distance": tuple(
        f"{what}, {low:g}-{high:g} m"
        for what in ("width px", "true width px", "peak", "peak sd", "contrast", "above threshold %")
        for low, high in ((1, 1.5), (1.5, 2), (2, 3), (3, 4), (4, 5), (5, 6.5))
    ),
    "lines and posts": (
        *(f"line {c}" for c in ("red", "green", "blue", "lightness", "lightness sd")),
        *(f"post {c}" for c in ("red", "green", "blue", "hue", "lightness", "saturation")),
        *("post left / centre", "post right / centre", "post width cm"),
    ),
    "behind the field": (
        *(f"background lightness {q} %" for q in (5, 25, 50, 75, 95)),
        *("background saturation", "background white %", "background green %", "background yellow %"),
        *("background edges %", "border green %", "threshold of eq. 4.1"),
        *("white left off lines, px", "false segments"),
    ),
}
STATISTICS = tuple(name for names in GROUPS.values() for name in names)
BINS = ((1, 1.5), (1.5, 2), (2, 3), (3, 4), (4, 5), (5, 6.5))  # metres


# --- where everything is ---


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
        """Some of the points."""
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
        """How far each pixel's ground lies outside the lines' rectangle (H, W), metres; infinite above the horizon."""
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
    """Points (N, 2) every 2 cm on the lines' middles, unit ways along them, whether nothing is near, which line."""
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
    """Distance (N,) of each point in the picture to the nearest point of another line."""
    near = np.full(len(pixels), np.inf)
    known = np.isfinite(pixels).all(axis=1)
    for this in np.unique(line[known]):
        own, others = known & (line == this), known & (line != this)
        if others.any():
            near[own] = cKDTree(pixels[others]).query(pixels[own])[0]
    return near


# --- profiles across lines ---

_STEP = 0.125  # px at 320 wide, between the places where a profile is read
_REACH = 8.0  # px at 320 wide, how far a profile reaches beyond the line's edge


class Picture:
    """A picture's channels, read between pixels by cubic splines."""

    def __init__(self, pixels: Pixels) -> None:
        self.pixels = pixels
        self.hls = np.asarray(cv2.cvtColor(pixels, cv2.COLOR_RGB2HLS))
        self.lightness = self.hls[..., 1].astype(float)
        hue, saturation = self.hls[..., 0], self.hls[..., 2]
        self.greenish = (saturation > 0.16 * 255) & (hue > 35) & (hue < 90)

    @cached_property
    def _lightness_spline(self) -> FloatArray:
        return np.asarray(ndimage.spline_filter(self.lightness, order=3))

    @cached_property
    def _chroma_spline(self) -> FloatArray:
        red, green, blue = (self.pixels[..., i].astype(float) for i in range(3))
        return np.asarray(ndimage.spline_filter(green - (red + blue) / 2, order=3))

    def read(self, places: FloatArray, chroma: bool = False) -> FloatArray:
        """Lightness, or green minus the mean of red and blue, at places (..., 2) as (u, v)."""
        spline = self._chroma_spline if chroma else self._lightness_spline
        where = np.moveaxis(places[..., ::-1], -1, 0)
        return np.asarray(ndimage.map_coordinates(spline, where, order=3, mode="nearest", prefilter=False))

    @cached_property
    def _channel_splines(self) -> list[FloatArray]:
        return [
            np.asarray(ndimage.spline_filter(self.pixels[..., i].astype(float), order=3)) for i in range(3)
        ]

    def read_channel(self, places: FloatArray, channel: int) -> FloatArray:
        """Red, green or blue (0, 1, 2) at places (..., 2) as (u, v)."""
        where = np.moveaxis(places[..., ::-1], -1, 0)
        spline = self._channel_splines[channel]
        return np.asarray(ndimage.map_coordinates(spline, where, order=3, mode="nearest", prefilter=False))

    def is_greenish(self, places: FloatArray) -> Mask:
        """Whether the pixel at each place has the colour of any carpet."""
        height, width = self.greenish.shape
        column = np.clip(np.rint(places[..., 0]).astype(int), 0, width - 1)
        row = np.clip(np.rint(places[..., 1]).astype(int), 0, height - 1)
        return np.asarray(self.greenish[row, column])


@dataclass(frozen=True)
class Profiles:
    """Profiles (N, K) across lines at offsets (K,) px from where the line should be, and what follows from each.

    Parameters
    ----------
    offsets, values : ndarray, shape (K,) and (N, K)
        Where, and the lightness there.
    centre, width : ndarray, shape (N,)
        Middle and full width at half height of the bright peak, px.
    base, peak : ndarray, shape (N,)
        Lightness of the carpet on both sides, and the greatest within the peak.
    on_carpet, good : ndarray, shape (N,)
        Whether there is carpet on both sides; and between them a peak.
    """

    offsets: FloatArray
    values: FloatArray
    centre: FloatArray
    width: FloatArray
    base: FloatArray
    peak: FloatArray
    on_carpet: Mask
    good: Mask


def line_profiles(picture: Picture, lines: Lines, scale: float, search: float) -> Profiles:
    """Read a profile across every line point; a peak is looked for within `search` px (at 320) of the middle."""
    half = lines.half_width[:, None]
    reach = float(lines.half_width.max(initial=1.0)) + (_REACH + search) * scale
    offsets = np.arange(-reach, reach + 1e-9, _STEP * scale)
    places = lines.pixel[:, None] + offsets[:, None] * lines.normal[:, None]
    values = np.clip(picture.read(places), 0, 255)  # a spline overshoots beside what is overexposed
    height, width = picture.lightness.shape
    limit = (width - 1, height - 1)
    values[((places < 0) | (places > limit)).any(axis=2)] = np.nan
    green = picture.is_greenish(places)
    # Carpet: from 1 to 3 px (at 320) beyond the edges, and as much more as the line may be off.
    beyond = np.abs(offsets)[None] - half
    sides = (beyond > (1.0 + search / 2) * scale) & (beyond < (3.0 + search / 2) * scale)
    left, right = sides & (offsets < 0), sides & (offsets > 0)
    base = (_masked_median(values, left) + _masked_median(values, right)) / 2
    is_carpet = [(green & side).sum(axis=1) > 0.7 * np.maximum(side.sum(axis=1), 1) for side in (left, right)]
    candidates = np.where(np.abs(offsets)[None] <= search * scale + half, values, -np.inf)
    candidates[np.isnan(candidates)] = -np.inf
    top = candidates.argmax(axis=1)
    peak = values[np.arange(len(values)), top]
    level = (base + peak) / 2
    with np.errstate(invalid="ignore"):
        low, high = _crossing(offsets, values, top, level, -1), _crossing(offsets, values, top, level, 1)
        good = (peak - base > 10) & is_carpet[0] & is_carpet[1] & np.isfinite(low + high)
    on_carpet = is_carpet[0] & is_carpet[1]
    return Profiles(offsets, values, (low + high) / 2, high - low, base, peak, on_carpet, good)


def _masked_median(values: FloatArray, mask: Mask) -> FloatArray:
    """Median of each row's chosen values; NaN where there is none."""
    chosen = np.sort(np.where(mask & ~np.isnan(values), values, np.inf), axis=1)
    count = np.isfinite(chosen).sum(axis=1)
    rows = np.arange(len(values))
    middle = (chosen[rows, np.maximum(count - 1, 0) // 2] + chosen[rows, np.maximum(count, 1) // 2]) / 2
    return np.where(count > 1, middle, np.nan)


def _crossing(
    offsets: FloatArray, values: FloatArray, start: npt.NDArray[np.intp], level: FloatArray, direction: int
) -> FloatArray:
    """Offset (N,) at which each row, followed from `start`, first falls to `level`; NaN if it does not."""
    if direction < 0:
        flipped = _crossing(-offsets[::-1], values[:, ::-1], values.shape[1] - 1 - start, level, 1)
        return -flipped
    columns = np.arange(values.shape[1])
    with np.errstate(invalid="ignore"):
        below = (values < level[:, None]) & (columns[None] > start[:, None])
    first = below.argmax(axis=1)
    rows = np.arange(len(values))
    after, before = values[rows, first], values[rows, np.maximum(first - 1, 0)]
    with np.errstate(divide="ignore", invalid="ignore"):
        part = (before - level) / (before - after)
        found = offsets[np.maximum(first - 1, 0)] + part * (offsets[1] - offsets[0])
    return np.where(below.any(axis=1), found, np.nan)


# --- instruments: each returns samples of named statistics ---

Samples = dict[str, FloatArray]


def measure(pixels: Pixels, geometry: Geometry) -> Samples:
    """Measure all statistics of one picture.

    Parameters
    ----------
    pixels : ndarray of uint8, shape (H, W, 3)
        RGB, real or simulated.
    geometry : Geometry
        What it shows.

    Returns
    -------
    dict of str to ndarray
        Samples by the statistics' names; those that the picture says nothing about are missing.
    """
    picture = Picture(pixels)
    carpet = geometry.carpet & ~foreign(picture, geometry)
    samples: Samples = {}
    for part in (
        carpet_colour(picture, geometry, carpet),
        carpet_light(picture, geometry, carpet),
        carpet_noise(picture, geometry, carpet),
        line_edges(picture, geometry),
        fringes(picture, geometry),
        lines_by_distance(picture, geometry),
        line_and_post_colours(picture, geometry),
        behind_the_field(picture, geometry),
    ):
        samples.update(part)
    return {name: np.atleast_1d(np.asarray(value, dtype=float)) for name, value in samples.items()}


def foreign(picture: Picture, geometry: Geometry) -> Mask:
    """Objects on the carpet: what is not greenish after a median over 5 px (at 320), and 3 px around it."""
    size = round(5 * geometry.scale) // 2 * 2 + 1
    odd = np.asarray(cv2.medianBlur((~picture.greenish).astype(np.uint8), min(size, 31)))
    rim = round(3 * geometry.scale) * 2 + 1
    return np.asarray(cv2.dilate(odd, np.ones((rim, rim), np.uint8)) > 0)


def carpet_colour(picture: Picture, geometry: Geometry, carpet: Mask) -> dict[str, Any]:
    """Hue (0..180), lightness and saturation (0..255) and colour of the carpet; mean lightness of all."""
    samples: dict[str, Any] = {"picture's mean lightness": picture.lightness.mean()}
    if carpet.sum() < 500 * geometry.scale**2:
        return samples
    hue, lightness, saturation = picture.hls[carpet].T
    samples.update({f"hue {q} %": np.percentile(hue, q) for q in (1, 5, 50, 95, 99)})
    samples.update({f"lightness {q} %": np.percentile(lightness, q) for q in (5, 25, 50, 75, 95)})
    samples["saturation mean"] = saturation.mean()
    samples.update(zip(("red", "green", "blue"), np.median(picture.pixels[carpet], axis=0), strict=True))
    samples["foreign on carpet %"] = 100 * (1 - carpet.sum() / geometry.carpet.sum())
    return samples


def carpet_light(picture: Picture, geometry: Geometry, carpet: Mask) -> dict[str, Any]:
    """How the carpet's lightness changes over the picture: sides to centre, far to near, and in patches."""
    samples: dict[str, Any] = {}
    height, width = carpet.shape
    fifth, band = width // 6, round(8 * geometry.scale)
    parts = {
        "left": slice(0, fifth),
        "centre": slice(width // 2 - fifth // 2, width // 2 + fifth // 2),
        "right": slice(width - fifth, width),
    }
    rows: list[dict[str, float]] = []
    for v in range(0, height - band + 1, band):
        light = picture.lightness[v : v + band]
        mask = carpet[v : v + band]
        rows.append(
            {
                n: float(np.median(light[:, s][mask[:, s]])) if mask[:, s].mean() > 0.5 else np.nan
                for n, s in parts.items()
            }
        )
    table = {name: np.array([row[name] for row in rows]) for name in parts}
    for name in ("left", "right"):
        ratio = table[name] / table["centre"]
        if np.isfinite(ratio).sum() >= 3:
            samples[f"{name} / centre"] = np.nanmedian(ratio)
    both = (table["left"] + table["right"]) / 2 / table["centre"]
    if np.isfinite(both).sum() >= 3:
        samples["sides / centre"] = np.nanmedian(both)
    bottom = slice(height - height // 8, height)
    edge, middle = (np.array(bounds) * width // 10 for bounds in ((0, 1, 9, 10), (4, 6)))
    corners = [picture.lightness[bottom, a:b][carpet[bottom, a:b]] for a, b in (edge[:2], edge[2:])]
    centre = picture.lightness[bottom, middle[0] : middle[1]][carpet[bottom, middle[0] : middle[1]]]
    if min(len(each) for each in (*corners, centre)) > 200 * geometry.scale**2:
        samples["bottom corners / bottom"] = np.mean([np.median(c) for c in corners]) / np.median(centre)
    near, far = (
        carpet & (geometry.distance > a) & (geometry.distance < b) for a, b in ((0.6, 1.2), (2.5, 4.0))
    )
    if min(near.sum(), far.sum()) > 300 * geometry.scale**2:
        samples["far / near lightness"] = np.median(picture.lightness[far]) / np.median(
            picture.lightness[near]
        )
    trend = _local_mean(picture.lightness, carpet, round(64 * geometry.scale))
    for size in (8, 24):
        n = round(size * geometry.scale)
        whole = cv2.blur(carpet.astype(np.float32), (n, n)) > 0.999
        patches = (cv2.blur(picture.lightness, (n, n)) / np.maximum(trend, 1))[whole]
        if whole.sum() > 2000 * geometry.scale**2:
            samples[f"patch contrast {size} px"] = 100 * _robust_sd(patches)
    return samples


def _local_mean(values: FloatArray, mask: Mask, size: int) -> FloatArray:
    """Mean of the masked values in a square window around each pixel."""
    weight = cv2.blur(mask.astype(float), (size, size))
    return np.asarray(cv2.blur(np.where(mask, values, 0.0), (size, size)) / np.maximum(weight, 1e-9))


def _robust_sd(values: FloatArray) -> float:
    """Standard deviation from the median absolute deviation."""
    return float(1.4826 * np.median(np.abs(values - np.median(values)))) if values.size else float("nan")


_LAPLACIAN = np.array(
    [[1.0, -2, 1], [-2, 4, -2], [1, -2, 1]]
)  # Immerkaer 1996: sees noise, not slopes or edges


def noise_sd(channel: FloatArray, mask: Mask, block: int = 1) -> float:
    """Standard deviation of white noise that would answer a Laplacian filter as strongly, after block averaging."""
    if block > 1:
        height, width = (n // block * block for n in channel.shape)
        shape = (height // block, block, width // block, block)
        channel = channel[:height, :width].reshape(shape).mean(axis=(1, 3))
        mask = np.asarray(mask[:height, :width].reshape(shape).all(axis=(1, 3)))
    whole = cv2.erode(mask.astype(np.uint8), np.ones((3, 3), np.uint8), borderValue=0) > 0
    if whole.sum() < 60:
        return float("nan")
    answer = cv2.filter2D(np.asarray(channel, dtype=float), -1, _LAPLACIAN)[whole]
    # Whole numbers make the median jump by whole steps: spread each over its step.
    spread = np.random.default_rng(0).uniform(-0.5, 0.5, answer.shape) if block == 1 else 0.0
    return _robust_sd(answer + spread) / 6.0


def carpet_noise(picture: Picture, geometry: Geometry, carpet: Mask) -> dict[str, Any]:
    """Noise of the sensor and grain of the carpet: strength by scale and channel, correlation, specks."""
    if carpet.sum() < 2000 * geometry.scale**2:
        return {}
    samples: dict[str, Any] = {}
    rest = picture.lightness - _local_mean(picture.lightness, carpet, round(15 * geometry.scale))
    samples["grain sd"] = _robust_sd(rest[carpet])
    for where, low, high in (("near", 0.5, 1.3), ("far", 2.0, 4.0)):
        part = carpet & (geometry.distance > low) & (geometry.distance < high)
        samples[f"grain sd, {where}"] = (
            _robust_sd(rest[part]) if part.sum() > 200 * geometry.scale**2 else np.nan
        )
        for block in (1, 2, 4, 8):
            samples[f"noise sd, {where}, {block}x{block}"] = noise_sd(picture.lightness, part, block)
    rgb = [picture.pixels[..., i].astype(float) for i in range(3)]
    red, green, blue = rgb
    luma = 0.299 * red + 0.587 * green + 0.114 * blue
    channels = {
        "red": red,
        "green": green,
        "blue": blue,
        "luma": luma,
        "Cb": 0.564 * (blue - luma),
        "Cr": 0.713 * (red - luma),
    }
    samples.update({f"noise sd {name}": noise_sd(channel, carpet) for name, channel in channels.items()})
    rest = np.clip(rest, *(np.array([-4, 4]) * _robust_sd(rest[carpet])))
    for name, (dv, du) in {
        "next column": (0, 1),
        "next row": (1, 0),
        "2 columns": (0, 2),
        "2 rows": (2, 0),
    }.items():
        samples[f"correlation {name}"] = _shifted_correlation(rest, carpet, dv, du)
    whole = cv2.erode(carpet.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    answers = [cv2.filter2D(channel, -1, _LAPLACIAN)[whole] for channel in rgb]
    for name, i, j in (("red-green", 0, 1), ("green-blue", 1, 2), ("red-blue", 0, 2)):
        samples[f"correlation {name}"] = _correlation(answers[i], answers[j])
    samples.update(_specks(picture, geometry, carpet))
    return samples


def _shifted_correlation(rest: FloatArray, mask: Mask, dv: int, du: int) -> float:
    """Correlation of pixels with those `dv` rows and `du` columns away."""
    height, width = rest.shape
    a, b = rest[: height - dv, : width - du], rest[dv:, du:]
    both = mask[: height - dv, : width - du] & mask[dv:, du:]
    return _correlation(a[both], b[both])


def _correlation(a: FloatArray, b: FloatArray) -> float:
    """Correlation; NaN where nothing varies."""
    return float(np.corrcoef(a, b)[0, 1]) if np.std(a) > 0 and np.std(b) > 0 else float("nan")


def _specks(picture: Picture, geometry: Geometry, carpet: Mask) -> dict[str, float]:
    """Spots that stand out of their surroundings by more than five standard deviations."""
    rest = picture.lightness - _local_mean(picture.lightness, carpet, round(11 * geometry.scale))
    sd = _robust_sd(rest[carpet])
    counts = {}
    for name, mask in (("bright", rest > 5 * sd), ("dark", rest < -5 * sd)):
        number, _ = cv2.connectedComponents((mask & carpet).astype(np.uint8), connectivity=8)
        counts[f"{name} specks per 10000 px"] = (number - 1) / carpet.sum() * 1e4 * geometry.scale**2
    return counts


def line_edges(picture: Picture, geometry: Geometry) -> dict[str, Any]:
    """Rise from 10 to 90 % across the edges of near lines (at least 7 px wide at 320), and what lies beside it."""
    scale = geometry.scale
    lines = geometry.lines
    lines = lines.chosen(lines.clear & (lines.half_width > 3.5 * scale) & (lines.distance < 3))
    samples: dict[str, Any] = {}
    if len(lines.pixel) < 10:
        return samples
    lines = lines.chosen(_thinned(len(lines.pixel), 600))
    profiles = line_profiles(picture, lines, scale, search=2.5)
    chosen = profiles.good
    width = geometry.field.dimensions.line_width
    if chosen.sum() >= 10:
        samples["line width cm"] = 100 * width * profiles.width[chosen] / (2 * lines.half_width[chosen])
    steep = np.abs(lines.normal[:, 0]) > np.abs(lines.normal[:, 1])
    for name, keep in (
        ("rise px", chosen),
        ("rise px, across columns", chosen & steep),
        ("rise px, across rows", chosen & ~steep),
    ):
        edge = _mean_edge(picture, lines.chosen(keep), scale, chroma=False)
        if edge is None:
            continue
        samples[name] = edge.rise
        if name == "rise px":
            samples["overshoot on the line"], samples["undershoot on the carpet"] = (
                edge.overshoot,
                edge.undershoot,
            )
            chroma = _mean_edge(picture, lines.chosen(keep), scale, chroma=True)
            if chroma is not None:
                samples["chroma rise px"] = chroma.rise
    return samples


def fringes(picture: Picture, geometry: Geometry) -> dict[str, Any]:
    """How far red and blue edges lie outwards of green ones, px, scaled to the middle of the picture's side."""
    scale, lines = geometry.scale, geometry.lines
    lines = lines.chosen(lines.clear & (lines.half_width > 1.2 * scale) & (lines.distance < 3))
    lines = lines.chosen(_thinned(len(lines.pixel), 150))
    if len(lines.pixel) < 5:
        return {}
    good = line_profiles(picture, lines, scale, search=2.5)
    lines = replace(lines, pixel=lines.pixel + np.nan_to_num(good.centre)[:, None] * lines.normal).chosen(
        good.good
    )
    offsets = np.arange(-2.5 * scale, 2.5 * scale, 0.05 * scale)
    found: dict[str, list[FloatArray]] = {"red": [], "blue": []}
    side_px = geometry.view.size[0] / 2
    for side in (-1, 1):
        edge = lines.pixel + side * lines.half_width[:, None] * lines.normal
        places = edge[:, None] + side * offsets[:, None] * lines.normal[:, None]
        crossings = [_half_way(offsets, np.clip(picture.read_channel(places, i), 0, 255)) for i in range(3)]
        away = edge - geometry.view.centre
        radius = np.hypot(*away.T)
        outwards = (away / np.maximum(radius, 1)[:, None] * side * lines.normal).sum(axis=1)
        use = (np.abs(outwards) > 0.7) & (radius > 0.25 * side_px)
        for name, i in (("red", 0), ("blue", 2)):
            shift = (crossings[i] - crossings[1])[use] / outwards[use] * side_px / radius[use]
            found[name].append(shift[np.isfinite(shift)])
    pooled = {f"{name} edge outwards, px": np.concatenate(parts) for name, parts in found.items()}
    return {name: values for name, values in pooled.items() if len(values) >= 5}


def _half_way(offsets: FloatArray, values: FloatArray) -> FloatArray:
    """Where each profile (N, K), which begins on a bright line, falls half way to the carpet at its end."""
    high, low = (
        values[:, : values.shape[1] // 5].max(axis=1),
        np.median(values[:, -values.shape[1] // 4 :], axis=1),
    )
    level = np.where(high - low > 60, (high + low) / 2, np.nan)
    return _crossing(offsets, values, np.full(len(values), 0), level, 1)


def _thinned(n: int, most: int) -> Mask:
    """Choose every k-th of n, no more than `most`."""
    return np.arange(n) % max(1, -(-n // most)) == 0


@dataclass(frozen=True)
class Edge:
    """A mean edge: rise in px, and how far it goes beyond its two levels (fractions of the contrast)."""

    rise: float
    overshoot: float
    undershoot: float


def _mean_edge(picture: Picture, lines: Lines, scale: float, chroma: bool) -> Edge | None:
    """Lay every edge of the lines onto one another by the place where it is half way up, and measure the mean."""
    if len(lines.pixel) < 10:
        return None
    step = 0.05 * scale
    offsets = np.arange(-4 * scale, 4 * scale + step / 2, step)
    shifted: list[FloatArray] = []
    for side in (-1, 1):
        # From the line's middle outwards: each edge is at half_width.
        middle = lines.pixel + side * lines.half_width[:, None] * lines.normal
        wide = np.arange(-6 * scale, 8 * scale, step)
        values = picture.read(middle[:, None] + side * wide[:, None] * lines.normal[:, None], chroma)
        inner = np.median(values[:, (wide > -3.4 * scale) & (wide < -2 * scale)], axis=1)
        outer = np.median(values[:, (wide > 2.5 * scale) & (wide < 5.5 * scale)], axis=1)
        level = (values - outer[:, None]) / np.where(np.abs(inner - outer) > 20, inner - outer, np.nan)[
            :, None
        ]
        start = np.full(len(level), int(np.argmin(np.abs(wide + 2.5 * scale))))
        half = _crossing(wide, level, start, np.full(len(level), 0.5), 1)
        for row, at in zip(level, half, strict=True):
            if np.isfinite(at) and abs(at) < 2.5 * scale:
                shifted.append(np.interp(offsets, wide - at, row))
    if len(shifted) < 10:
        return None
    # Levels again, from the mean: single profiles are noisy, and a shift moves their windows.
    mean = np.median(shifted, axis=0)
    plateau = float(np.median(mean[(offsets < -2 * scale) & (offsets > -3.4 * scale)]))
    ground = float(np.median(mean[offsets > 2.2 * scale]))
    mean = (mean - ground) / (plateau - ground)
    start = np.array([int(np.argmin(np.abs(offsets + 2.5 * scale)))])
    ends = [float(_crossing(offsets, mean[None], start, np.array([q]), 1)[0]) for q in (0.9, 0.1)]
    inside = mean[(offsets > -2 * scale) & (offsets < 0)]
    beyond = mean[(offsets < 2.2 * scale) & (offsets > 0)]
    return Edge(ends[1] - ends[0], float(inside.max() - 1), float(-beyond.min()))


def lines_by_distance(picture: Picture, geometry: Geometry) -> dict[str, Any]:
    """Width, peak and visibility of lines across the view in bins of distance."""
    threshold = paper.white_threshold(picture.hls[..., 1], 120.0)
    samples: dict[str, Any] = {}
    every = geometry.lines
    for low, high in BINS:
        keep = every.clear & every.across & (every.distance >= low) & (every.distance < high)
        lines = every.chosen(keep)
        if len(lines.pixel) < 5:
            continue
        lines = lines.chosen(_thinned(len(lines.pixel), 200))
        profiles = line_profiles(picture, lines, geometry.scale, search=2.5)
        g = profiles.good
        if g.sum() < 5:
            continue
        name = f"{low:g}-{high:g} m"
        samples[f"width px, {name}"] = profiles.width[g]
        samples[f"true width px, {name}"] = 2 * lines.half_width[g]
        samples[f"peak, {name}"] = profiles.peak[g]
        samples[f"peak sd, {name}"] = _robust_sd(profiles.peak[g])
        samples[f"contrast, {name}"] = (profiles.peak - profiles.base)[g]
        samples[f"above threshold %, {name}"] = (
            100.0 * _pixel_above(picture, lines, profiles, threshold)[profiles.on_carpet]
        )
    return samples


def _pixel_above(picture: Picture, lines: Lines, profiles: Profiles, threshold: float) -> FloatArray:
    """Whether the pixel in which each line's found middle lies is above the threshold (0 or 1)."""
    middle = lines.pixel + np.nan_to_num(profiles.centre)[:, None] * lines.normal
    height, width = picture.lightness.shape
    u = np.clip(np.rint(middle[:, 0]).astype(int), 0, width - 1)
    v = np.clip(np.rint(middle[:, 1]).astype(int), 0, height - 1)
    return np.asarray(picture.lightness[v, u] > threshold, dtype=float)


def line_and_post_colours(picture: Picture, geometry: Geometry) -> dict[str, Any]:
    """Colour of the middle of near lines, and of the posts' middles and sides."""
    samples: dict[str, Any] = {}
    scale = geometry.scale
    lines = geometry.lines
    lines = lines.chosen(lines.clear & (lines.half_width > 2 * scale) & (lines.distance < 2.5))
    if len(lines.pixel) >= 10:
        profiles = line_profiles(picture, lines, scale, search=2.5)
        middle = (lines.pixel + profiles.centre[:, None] * lines.normal)[profiles.good]
        if len(middle) >= 10:
            u, v = np.rint(middle).astype(int).T
            for name, values in zip(("red", "green", "blue"), picture.pixels[v, u].T, strict=True):
                samples[f"line {name}"] = np.median(values)
            samples["line lightness"] = np.median(picture.lightness[v, u])
            samples["line lightness sd"] = _robust_sd(picture.lightness[v, u])
    core = geometry.post_core
    hue, saturation = picture.hls[..., 0], picture.hls[..., 2]
    yellow = core & (hue > 18) & (hue < 40) & (saturation > 80)
    if yellow.sum() > 60 * scale**2 and yellow.sum() > 0.5 * core.sum():
        for name, values in zip(("red", "green", "blue"), picture.pixels[yellow].T, strict=True):
            samples[f"post {name}"] = np.median(values)
        for i, name in enumerate(("hue", "lightness", "saturation")):
            samples[f"post {name}"] = np.median(picture.hls[..., i][yellow])
        samples.update(_post_sides(picture, geometry, yellow))
    return samples


def _post_sides(picture: Picture, geometry: Geometry, yellow: Mask) -> dict[str, list[float]]:
    """Lightness at 40 % of the radius on each side of the axis, over that on the axis, for every wide post."""
    ratios: dict[str, list[float]] = {"left": [], "right": []}
    widths: list[float] = []
    d = geometry.field.dimensions
    for x, y in geometry.field.posts:
        towards = np.array([x, y]) - geometry.eye
        aside = np.array([-towards[1], towards[0]]) / max(np.hypot(*towards), 1e-9) * d.post_diameter / 2
        axis = np.array([[x, y, z] for z in np.linspace(0.08, d.post_height - 0.1, 60)])
        sides = {
            n: geometry.view.project(axis + [*(f * aside), 0.0], geometry.pose)
            for n, f in (("left", 0.45), ("centre", 0.0), ("right", -0.45))
        }
        inside = np.all([geometry.view.contains(np.nan_to_num(p, nan=-9)) for p in sides.values()], axis=0)
        if inside.sum() < 10 or np.nanmedian(sides["right"][:, 0] - sides["left"][:, 0]) < 5 * geometry.scale:
            continue
        light = {}
        widths.append(
            100 * d.post_diameter * 1.5 * _yellow_part(picture, geometry, axis[inside], 1.5 * aside)
        )
        for name, pixels in sides.items():
            u, v = np.rint(pixels[inside]).astype(int).T
            light[name] = picture.lightness[v, u][yellow[v, u]]
        if min(len(values) for values in light.values()) >= 10:
            for name, found in ratios.items():
                found.append(float(np.median(light[name]) / np.median(light["centre"])))
    named = {f"post {name} / centre": found for name, found in ratios.items() if found}
    return {**named, "post width cm": widths} if widths else named


def _yellow_part(picture: Picture, geometry: Geometry, axis: FloatArray, half: FloatArray) -> float:
    """Which part of a strip `half` (2,) m to each side of a post's axis (N, 3) is yellow: the median of its rows."""
    steps = np.linspace(-1, 1, 121)
    strip = axis[:, None] + steps[:, None] * np.array([*half, 0.0])
    u, v = np.rint(geometry.view.project(strip.reshape(-1, 3), geometry.pose)).T
    u, v = (
        np.clip(np.nan_to_num(x), 0, n - 1).astype(int)
        for x, n in zip((u, v), geometry.view.size, strict=True)
    )
    hue, _, saturation = picture.hls[v, u].T
    yellow = (hue > 18) & (hue < 40) & (saturation > 80)
    return float(np.median(yellow.reshape(len(axis), -1).mean(axis=1)))


def behind_the_field(picture: Picture, geometry: Geometry) -> dict[str, Any]:
    """What may confuse a detector: colours above the carpet, and white that is no line."""
    samples: dict[str, Any] = {}
    threshold = paper.white_threshold(picture.hls[..., 1], 120.0)
    labels = paper.color_labels(picture.hls, threshold, paper.Hues())
    samples["threshold of eq. 4.1"] = threshold
    background = geometry.background
    if background.sum() > 500 * geometry.scale**2:
        light = picture.lightness[background]
        samples.update({f"background lightness {q} %": np.percentile(light, q) for q in (5, 25, 50, 75, 95)})
        samples["background saturation"] = picture.hls[..., 2][background].mean()
        for name, label in (("white", paper.WHITE), ("green", paper.GREEN), ("yellow", paper.YELLOW)):
            samples[f"background {name} %"] = 100 * (labels[background] == label).mean()
        grey = cv2.cvtColor(picture.pixels, cv2.COLOR_RGB2GRAY)
        samples["background edges %"] = 100 * (cv2.Canny(grey, 80, 160)[background] > 0).mean()
    if geometry.border.sum() > 100 * geometry.scale**2:
        samples["border green %"] = 100 * (labels[geometry.border] == paper.GREEN).mean()
    kept = paper.erase_background(labels) == paper.WHITE
    known = geometry.near_lines | geometry.near_posts
    samples["white left off lines, px"] = (kept & ~known).sum() / geometry.scale**2
    segments = paper.hough_segments(paper.edges(labels), paper.BEST[1], paper.BEST[2])
    places = (
        segments[:, :2][:, None]
        + np.linspace(0, 1, 9)[:, None] * (segments[:, 2:] - segments[:, :2])[:, None]
    )
    u, v = np.rint(places).astype(int).transpose(2, 0, 1)
    samples["false segments"] = (known[v, u].mean(axis=1) < 0.5).sum()
    return samples


# --- the real pictures and their geometry ---


@dataclass(frozen=True)
class RealScene:
    """A real picture with its fitted geometry."""

    picture: RealPicture
    set_name: str
    view: CameraView
    pose: Pose

    @property
    def name(self) -> str:
        """The picture's file name."""
        return self.picture.name

    @property
    def corners(self) -> FloatArray:
        """The L and T points as they were marked (K, 2)."""
        return np.array([(p.u, p.v) for p in self.picture.points if p.kind in "LT"], dtype=float).reshape(
            -1, 2
        )

    def geometry(self, size: tuple[int, int] | None = None) -> Geometry:
        """Where things are, in a picture of another size if one is given."""
        return Geometry(self.view.at_size(size) if size else self.view, self.pose)


# What a picture's geometry may deviate from its set's: pitch, roll, heading (rad) and x, y (m).
_PRIOR = np.array([np.radians(1.3), np.radians(1.0), np.radians(2.5), 0.06, 0.06])
_CACHE = BUILD / "realism_geometry.json"


def real_scenes() -> tuple[RealScene, ...]:
    """All 94 real pictures with their geometry; it is kept in the build folder, for fitting takes half a minute."""
    scenes = []
    kept = json.loads(_CACHE.read_text()) if _CACHE.is_file() else {}
    for name in get_args(PictureSet):
        pictures = read_pictures(name)
        if set(kept.get(name, {})) != {picture.name for picture in pictures}:
            kept[name] = {s.name: _as_json(s) for s in _fit_geometry(name, pictures)}
            _CACHE.parent.mkdir(exist_ok=True)
            _CACHE.write_text(json.dumps(kept))
        for picture in pictures:
            values = kept[name][picture.name]
            view = CameraView(**{**values["view"], "size": tuple(values["view"]["size"])})
            scenes.append(RealScene(picture, name, view, Pose(*values["pose"])))
    return tuple(scenes)


def _as_json(scene: RealScene) -> dict[str, Any]:
    return {"view": asdict(scene.view), "pose": scene.pose.as_array().tolist()}


def _fit_geometry(name: str, pictures: Sequence[RealPicture]) -> list[RealScene]:
    """Fit a set's camera to the marked points, then move every picture's pose onto its lines."""
    moved = reality.corrected_walk(pictures) if name == "straightwalk" else tuple(pictures)
    fit = reality.fit_set(moved, reality.Freedom(position_sd=0.05))
    known = {item.picture.name: c for item, c in zip(fit.matched, fit.corrections, strict=True)}
    mean = np.median(fit.corrections, axis=0)
    scenes = []
    for original, picture in zip(pictures, moved, strict=True):
        correction = align(picture, fit.values, known.get(picture.name, mean), mean)
        view, pose = reality.fitted_view(picture, fit.values, correction)
        scenes.append(RealScene(original, name, view, pose))
    return scenes


def align(picture: RealPicture, values: FloatArray, start: FloatArray, mean: FloatArray) -> FloatArray:
    """Move a picture's pitch, roll, heading and position until the field's lines lie on the white ones.

    Parameters
    ----------
    picture : RealPicture
        The picture.
    values : ndarray, shape (5,)
        Of its set (`reality.SET_VALUES`).
    start, mean : ndarray, shape (5,)
        Where to begin, and the set's middle: pitch, roll, heading (rad), x, y (m).

    Returns
    -------
    ndarray, shape (5,)
        The corrections.
    """
    correction = np.clip(start, mean - 2 * _PRIOR, mean + 2 * _PRIOR)
    bounds = (mean - 3.5 * _PRIOR, mean + 3.5 * _PRIOR)
    seen = Picture(picture.pixels)
    for search in (0.0, 5.0, 3.0, 2.0):  # first by the marked points alone
        matched = (
            reality.match(picture, values, correction, 12.0 if search else 40.0) if picture.points else None
        )
        found = _found_lines(seen, *reality.fitted_view(picture, values, correction), search)
        weight = np.sqrt(min(1.0, 60 / max(len(found.lines.point), 1)))

        def residual(
            state: FloatArray,
            matched: reality.Matched | None = matched,
            found: _Found = found,
            weight: float = float(weight),
        ) -> FloatArray:
            view, pose = reality.fitted_view(picture, values, state)
            off = view.project(found.lines.point, pose) - found.pixel
            parts = [(off * found.lines.normal).sum(axis=1) / 0.5 * weight, (state - mean) / _PRIOR]
            if matched is not None:
                marked = view.project(matched.landmarks[matched.used], pose) - matched.pixels[matched.used]
                parts.append(marked.ravel() / 2.0)
            return np.nan_to_num(np.concatenate(parts), nan=20.0)

        moved = least_squares(residual, correction, bounds=bounds, loss="soft_l1", x_scale=_PRIOR)
        correction = np.asarray(moved.x)
    return correction


@dataclass(frozen=True)
class _Found:
    """Line points, and the pixels (N, 2) at which the picture shows the lines' middles."""

    lines: Lines
    pixel: FloatArray


def _found_lines(seen: Picture, view: CameraView, pose: Pose, search: float) -> _Found:
    """Find lines within `search` px of where they should be; none for 0."""
    lines = Geometry(view, pose).lines
    lines = lines.chosen(lines.clear & (lines.distance < 6) & (search > 0))
    lines = lines.chosen(_thinned(len(lines.pixel), 400))
    if not len(lines.pixel):
        return _Found(lines, np.empty((0, 2)))
    profiles = line_profiles(seen, lines, 1.0, search)
    good = profiles.good & (profiles.peak - profiles.base > 25)
    pixel = view.project(lines.point, pose) + np.nan_to_num(profiles.centre)[:, None] * lines.normal
    return _Found(lines.chosen(good), pixel[good])


# --- simulated twins and the comparison ---


ROOMS = 4  # the twins are spread over so many of the simulator's rooms


def simulated_twin(
    scene: RealScene, reality_: Reality, seed: int, size: tuple[int, int] | None = None
) -> tuple[Pixels, PictureTruth]:
    """Render the simulator's picture from a real picture's view and pose.

    Parameters
    ----------
    scene : RealScene
        The real picture's geometry.
    reality_ : Reality
        How real the simulator's pictures look.
    seed : int
        Of everything random in this picture; it also chooses one of four rooms.
    size : (int, int), optional
        Width and height in pixels, another than the real picture's.

    Returns
    -------
    pixels : ndarray of uint8, shape (H, W, 3)
        RGB.
    truth : PictureTruth
        What it shows.
    """
    view = scene.view.at_size(size) if size else scene.view
    room = replace(reality_, seed=reality_.seed + seed % ROOMS)
    return render(FIELD, scene.pose, view, room, np.random.default_rng(seed))


# Counts, fractions and lightness of what is mostly absent: the mean over pictures tells more than the median.
_BY_MEAN = ("%", "specks", "left off lines", "false segments")
_MOST_SAMPLES = 60  # of one picture, so that no picture outweighs the rest


@dataclass(frozen=True)
class Summary:
    """One statistic over a set of pictures: its middle, the 10 and 90 % of single pictures, and how many tell it."""

    middle: float
    low: float
    high: float
    pictures: int


def summarise(measured: Iterable[Samples]) -> dict[str, Summary]:
    """Pool the pictures' samples: their mean for counts and fractions, their median for all else."""
    found: dict[str, list[FloatArray]] = {}
    for samples in measured:
        for name, values in samples.items():
            values = values[np.isfinite(values)]
            if values.size:
                found.setdefault(name, []).append(values[_thinned(len(values), _MOST_SAMPLES)])
    return {name: _summary(name, found[name]) for name in STATISTICS if name in found}


def _summary(name: str, parts: list[FloatArray]) -> Summary:
    quantile = any(name.startswith(each) for each in ("hue", "lightness", "background lightness"))
    middle = np.mean if any(each in name for each in _BY_MEAN) and not quantile else np.median
    single = [float(middle(part)) for part in parts]
    low, high = np.percentile(single, [10, 90]).tolist()
    return Summary(float(middle(np.concatenate(parts))), low, high, len(parts))


QUICK = 7  # every so many pictures: not 8, for the scenes turn by an eighth each


@lru_cache(maxsize=4)
def _real_side(step: int = 1, large: bool = False) -> tuple[tuple[RealScene, ...], tuple[Geometry, ...], Any]:
    """Scenes, their geometry and their statistics; for a tuning script they are measured once."""
    scenes = tuple(s for s in real_scenes() if s.picture.has_large) if large else real_scenes()[::step]
    size = LARGE if large else None
    geometry = tuple(scene.geometry(size) for scene in scenes)
    pictures = [scene.picture.read(large=large) for scene in scenes]
    measured = [measure(p, g) for p, g in zip(pictures, geometry, strict=True)]
    return scenes, geometry, measured


LARGE = (1280, 960)


def compare(
    reality_: Reality | None = None, step: int = 1, seed: int = 0, large: bool = False
) -> dict[str, dict[str, Any]]:
    """Measure real pictures and their simulated twins.

    Parameters
    ----------
    reality_ : Reality, optional
        How real the simulator's pictures look; without it the default.
    step : int
        Every so many of the 94 pictures: 1 for all, 7 for a quick look.
    seed : int
        Of everything random.
    large : bool
        The 8 pictures of 1280 x 960 instead (lengths are then in their pixels).

    Returns
    -------
    dict
        By statistic: "real", "simulated" (the `Summary` of each as a dict) and "ratio" of their middles.
    """
    scenes, geometry, measured = _real_side(step, large)
    size = LARGE if large else None
    twins = (
        simulated_twin(scene, reality_ or Reality(), seed + i, size)[0] for i, scene in enumerate(scenes)
    )
    sides = (summarise(measured), summarise(measure(p, g) for p, g in zip(twins, geometry, strict=True)))
    return _side_by_side(*sides)


def _side_by_side(real: Mapping[str, Summary], simulated: Mapping[str, Summary]) -> dict[str, dict[str, Any]]:
    rows: dict[str, dict[str, Any]] = {}
    for name in STATISTICS:
        both = [side.get(name) for side in (real, simulated)]
        if any(both):
            row = {
                k: asdict(side) if side else None for k, side in zip(("real", "simulated"), both, strict=True)
            }
            a, b = (side.middle if side else float("nan") for side in both)
            rows[name] = {**row, "ratio": b / a if a and np.isfinite(a + b) else None}
    return rows


def compare_by_set(reality_: Reality | None = None, seed: int = 0) -> dict[str, dict[str, dict[str, Any]]]:
    """`compare` for each of the two sets, which differ in light, white balance and season."""
    scenes, geometry, measured = _real_side()
    results = {}
    for name in get_args(PictureSet):
        chosen = [i for i, scene in enumerate(scenes) if scene.set_name == name]
        twins = [
            measure(simulated_twin(scenes[i], reality_ or Reality(), seed + i)[0], geometry[i])
            for i in chosen
        ]
        results[name] = _side_by_side(summarise(measured[i] for i in chosen), summarise(twins))
    return results


# --- the paper's detector on both ---

REACH = 7.5  # metres


def annotation_reach(scenes: Sequence[RealScene]) -> dict[str, float]:
    """How far people marked corners: the farthest, and which fraction of those in view they marked by distance."""
    marked, shown = [], []
    for scene in scenes:
        for visible in _corners_in_view(scene):
            near = np.hypot(*(scene.corners - visible.pixel).T).min(initial=99.0) < 8
            shown.append(visible.distance)
            if near:
                marked.append(visible.distance)
    edges = np.array([0, 1, 2, 3, 4, 5, 6, 9])
    counts = [np.histogram(each, edges)[0] for each in (marked, shown)]
    values = {
        f"marked % of those in view, {a}-{b} m": 100 * m / n
        for a, b, m, n in zip(edges[:-1], edges[1:], *counts, strict=True)
        if n
    }
    return {"farthest marked m": float(max(marked)), **{k: float(v) for k, v in values.items()}}


def _corners_in_view(scene: RealScene) -> list[Any]:
    found = visible_landmarks(FIELD, scene.pose, scene.view)
    return [each for each in found if each.landmark.shape in ("L", "T") and not each.occluded]


def simulated_corners(truth: PictureTruth, reach: float = REACH) -> FloatArray:
    """L and T corners (K, 2) a person would mark in a twin: in view, nothing before them, not farther than `reach`."""
    found = [
        each.pixel
        for each in truth.landmarks
        if each.landmark.shape in ("L", "T") and not each.occluded and each.distance <= reach
    ]
    return np.array(found, dtype=float).reshape(-1, 2)


def detector_scenes(
    scenes: Sequence[RealScene], reality_: Reality | None, seed: int = 0
) -> tuple[list[paper.Scene], list[paper.Scene]]:
    """Real scenes with their annotations, and their twins with the renderer's truth."""
    real = [paper.Scene(scene.picture.pixels, scene.corners) for scene in scenes]
    twins = (simulated_twin(scene, reality_ or Reality(), seed + i) for i, scene in enumerate(scenes))
    return real, [paper.Scene(pixels, simulated_corners(truth)) for pixels, truth in twins]


def compare_detector(
    reality_: Reality | None = None, step: int = 1, seed: int = 0, min_saturation: float = 0.16
) -> dict[str, Any]:
    """Run the 27 settings of Table A.1 on real scenes and on their twins.

    Returns
    -------
    dict
        "rank correlation" of the mean costs; "real" and "simulated", each with what the paper's best setting
        finds, the 27 costs, and the loss funnel.
    """
    scenes = real_scenes()[::step]
    hues = paper.Hues(min_saturation=255 * min_saturation)
    values: dict[str, Any] = {}
    costs = {}
    for name, chosen in zip(("real", "simulated"), detector_scenes(scenes, reality_, seed), strict=True):
        grid = paper.run_grid(chosen, hues)
        costs[name] = grid.mean_costs
        values[name] = {
            **grid.at(),
            "rank correlation of halves": paper.reliability(grid),
            "costs": costs[name].tolist(),
            "funnel": paper.funnel(chosen, hues),
        }
    values["rank correlation"] = paper.rank_correlation(costs["real"], costs["simulated"])
    table_a1 = np.array(paper.PAPER_COSTS)
    for name, each in costs.items():
        values[name]["rank correlation with Table A.1"] = paper.rank_correlation(each, table_a1)
    return values


SETS_OF_ROOMS = 6  # a set of twins spreads over four rooms; single false corners decide the ranks of one set


def compare_detector_over_rooms(min_saturation: float = 0.16) -> dict[str, Any]:
    """Rank correlation with the real mean costs, of each set of twins and of the mean costs over all their rooms."""
    real = np.zeros(0)
    sets, each = [], []
    for number in range(SETS_OF_ROOMS):
        values = compare_detector(Reality(seed=4 * number), min_saturation=min_saturation)
        real = np.array(values["real"]["costs"])
        sets.append(values["simulated"]["costs"])
        each.append(values["rank correlation"])
    pooled = paper.rank_correlation(real, np.mean(sets, axis=0))
    return {"rooms": 4 * SETS_OF_ROOMS, "rank correlation": pooled, "of each set": each}


# --- tables and figures ---


def tables(rows: Mapping[str, Mapping[str, Any]], title: str = "") -> list[Table]:
    """One table for each group of statistics."""
    found = []
    for group, names in GROUPS.items():
        cells = tuple(_cells(name, rows[name]) for name in names if name in rows)
        if cells:
            columns = ("", "real", "10-90 %", "n", "simulated", "10-90 %", "n", "ratio")
            found.append(Table(f"{title}{group}", columns, cells))
    return found


def _cells(name: str, row: Mapping[str, Any]) -> tuple[object, ...]:
    cells: list[object] = [name]
    for side in (row["real"], row["simulated"]):
        if side:
            cells += [float(side["middle"]), f"{side['low']:.2f} .. {side['high']:.2f}", side["pictures"]]
        else:
            cells += ["-", "", ""]
    return (*cells, "-" if row["ratio"] is None else float(row["ratio"]))


def detector_table(values: Mapping[str, Any]) -> Table:
    """The paper's detector on real and simulated scenes."""
    names = (
        "corners",
        "hits",
        "false",
        "cost",
        "rank correlation with Table A.1",
        "rank correlation of halves",
    )
    rows = [(name, *(values[side][name] for side in ("real", "simulated"))) for name in names]
    rows += [
        (f"true corners {stage}", *(values[s]["funnel"][stage] for s in ("real", "simulated")))
        for stage in paper.FUNNEL
    ]
    costs = [values[side]["costs"] for side in ("real", "simulated")]
    rows += [
        ("lowest of 27 costs", *(min(c) for c in costs)),
        ("highest of 27 costs", *(max(c) for c in costs)),
    ]
    rho = values["rank correlation"]
    title = f"the paper's detector, beta 120, gap 5, length 40; rank correlation of the 27 costs {rho:.2f}"
    return Table(title, ("", "real", "simulated"), tuple(rows))


def save_pairs(
    path: Path,
    scenes: Sequence[RealScene],
    reality_: Reality | None = None,
    columns: int = 4,
    zoom: float = 1.0,
) -> Path:
    """Write one figure with all pairs, real left and simulated right; never into the repository: they are not ours."""
    pairs = []
    for i, scene in enumerate(scenes):
        pair = np.hstack([scene.picture.pixels, simulated_twin(scene, reality_ or Reality(), i)[0]])
        if zoom != 1:
            pair = np.asarray(cv2.resize(pair, None, fx=zoom, fy=zoom, interpolation=cv2.INTER_NEAREST))
        pair = np.pad(pair, ((0, 6), (0, 10), (0, 0)), constant_values=255)
        where = (4, pair.shape[0] - 12)
        pairs.append(cv2.putText(pair.copy(), scene.name[:-4], where, 0, 0.4, (255, 0, 0), 1, cv2.LINE_AA))
    pairs += [np.full_like(pairs[0], 255)] * (-len(pairs) % columns)
    grid = np.vstack([np.hstack(pairs[i : i + columns]) for i in range(0, len(pairs), columns)])
    path.parent.mkdir(parents=True, exist_ok=True)
    if not cv2.imwrite(str(path), grid[..., ::-1]):
        raise OSError(f"could not write {path}")
    return path


def quick(step: int = QUICK) -> Result:
    """Measure a few pictures, in some seconds."""
    rows = compare(step=step)
    detector = compare_detector(step=max(step // 2, 1))
    return Result("realism_quick", {}, (*tables(rows), detector_table(detector)))


def main() -> Result:
    """Measure all pictures, at both sizes, and both sets apart; draw the pairs."""
    rows, large = compare(), compare(large=True)
    by_set = compare_by_set()
    detector = {f"saturation floor {floor}": compare_detector(min_saturation=floor) for floor in (0.16, 0.0)}
    rooms = compare_detector_over_rooms()
    scenes = real_scenes()
    save_pairs(BUILD / "realism_all_pairs.png", scenes)
    save_pairs(BUILD / "realism_12_pairs.png", [scenes[i] for i in CLOSE_LOOK], columns=2, zoom=2.0)
    values = {
        "all 94 pictures": _brief(rows, spread=True),
        "8 pictures of 1280 x 960": _brief(large),
        **{name: _brief(each) for name, each in by_set.items()},
        "detector": detector,
        "detector over rooms": rooms,
        "annotations": annotation_reach(scenes),
    }
    shown = [*tables(rows), *tables(large, "1280 wide: ")]
    for name, each in detector.items():
        table = detector_table(each)
        shown.append(replace(table, title=f"{table.title}; {name}"))
    each = ", ".join(f"{rho:.2f}" for rho in rooms["of each set"])
    notes = (
        f"Rank correlation of the 27 mean costs over {rooms['rooms']} rooms: {rooms['rank correlation']:.2f}; "
        f"sets of four rooms: {each}.",
        "Pairs of pictures, real left: build/realism_all_pairs.png, build/realism_12_pairs.png (not ours to pass on).",
    )
    return Result("realism", values, tuple(shown), notes)


def _brief(rows: Mapping[str, Mapping[str, Any]], spread: bool = False) -> dict[str, dict[str, float | None]]:
    """What is worth keeping of a comparison: the middles, and if asked for the pictures' spread."""
    kept: dict[str, dict[str, float | None]] = {}
    for name, row in rows.items():
        sides = {side: row[side] for side in ("real", "simulated")}
        kept[name] = {side: values and values["middle"] for side, values in sides.items()}
        for side, values in sides.items():
            if spread and values:
                kept[name] |= {f"{side} 10 %": values["low"], f"{side} 90 %": values["high"]}
    return kept


CLOSE_LOOK = (0, 1, 6, 10, 16, 21, 29, 34, 46, 52, 65, 84)


if __name__ == "__main__":
    from rich.console import Console

    parser = argparse.ArgumentParser(prog="python -m benchmarks.realism", description=__doc__)
    parser.add_argument(
        "--quick", action="store_true", help="some of the pictures only, in some seconds; writes nothing"
    )
    chosen = parser.parse_args()
    outcome = quick() if chosen.quick else main()
    outcome.show(Console(width=130))
    if not chosen.quick:
        outcome.save()
    sys.exit(0)
