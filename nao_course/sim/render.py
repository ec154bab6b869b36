"""Pictures of the field: every pixel's ray against the exact geometry, anti-aliased exactly, with the truth beside it.

How it works. A pixel sees a cone of rays. A line on the carpet is a rectangle, a post a cylinder; seen from the
camera their edges are planes and cones through the camera's centre, so how much of a pixel lies inside is found
without sampling: the signed distance to each edge, and the exact area of a unit square cut by a straight edge.
Colours are blended by these areas in linear light, as a lens does, and only then given the camera's tone curve.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from functools import lru_cache

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, Pose, finite
from nao_course.sim.camera import CameraView
from nao_course.sim.field import Field, Landmark

Float32 = npt.NDArray[np.float32]
Indices = npt.NDArray[np.intp]

OTHER, GREEN, YELLOW, WHITE = 0, 1, 2, 3
LABELS = ("other", "green", "yellow", "white")

# Colours as the camera shows them (0..255): medians of the real pictures of 2013, see docs/real_data.md.
_SHOWN = {
    "carpet": (49, 115, 62),
    "line": (236, 240, 238),
    "yellow": (222, 196, 22),
    "white": (236, 240, 238),
    "floor": (196, 190, 182),
    "wall": (206, 206, 204),
}
# The camera's tone curve is not published; a square root is within its plausible range and quick to apply.
_COLOURS = {name: (np.array(rgb, dtype=np.float32) / 255) ** 2 for name, rgb in _SHOWN.items()}
_ROOM_MARGIN = 1.5  # metres of floor between the carpet and the wall
_EDGE_PIECES = 16  # pieces a straight edge is cut into, to follow the lens


@dataclass(frozen=True)
class Reality:
    """How real a picture looks: every effect is a number, and zero switches it off.

    Parameters
    ----------
    noise : float
        Standard deviation of the sensor's noise in levels of 255 (3.3 on the real pictures' carpet).
    """

    noise: float = 3.3

    def __post_init__(self) -> None:
        """Refuse what is no strength of an effect."""
        for each in fields(self):
            if finite(f"Reality: {each.name}", getattr(self, each.name)) < 0:
                raise ValueError(f"Reality: {each.name} must be 0 (off) or more, got {getattr(self, each.name)}")

    @classmethod
    def clean(cls) -> Reality:
        """Every effect off."""
        return cls(**{each.name: 0.0 for each in fields(cls)})


@dataclass(frozen=True)
class VisibleLandmark:
    """A landmark in a picture.

    Parameters
    ----------
    landmark : Landmark
        Which one, in the field frame.
    pixel : (float, float)
        Where it is, (u, v).
    distance : float
        Over the ground from the robot, metres.
    bearing : float
        In the robot frame, radians, positive left.
    occluded : bool
        Whether a goal post stands before it.
    """

    landmark: Landmark
    pixel: tuple[float, float]
    distance: float
    bearing: float
    occluded: bool


@dataclass(frozen=True)
class PictureTruth:
    """What a picture really shows.

    Parameters
    ----------
    labels : ndarray of uint8, shape (H, W)
        0 other, 1 green, 2 yellow, 3 white: what covers at least half of the pixel.
    landmarks : tuple of VisibleLandmark
        Those inside the picture, also the occluded ones.
    pose : Pose
        The robot's, in the world.
    view : CameraView
        The camera's true view, with the torso's tilt.
    """

    labels: npt.NDArray[np.uint8]
    landmarks: tuple[VisibleLandmark, ...]
    pose: Pose
    view: CameraView


def render(
    field: Field,
    pose: Pose,
    view: CameraView,
    reality: Reality | None = None,
    rng: np.random.Generator | None = None,
) -> tuple[npt.NDArray[np.uint8], PictureTruth]:
    """Take a picture of a field.

    Parameters
    ----------
    field : Field
        What stands there.
    pose : Pose
        The robot's pose in the world.
    view : CameraView
        The camera's true view from the robot.
    reality : Reality, optional
        How real the picture looks; the default has every effect at its measured strength.
    rng : numpy.random.Generator, optional
        Of everything random; needed unless every effect is off.

    Returns
    -------
    pixels : ndarray of uint8, shape (H, W, 3)
        RGB.
    truth : PictureTruth
        What it shows.

    Raises
    ------
    ValueError
        If the picture needs random numbers and there is no generator.
    """
    reality = Reality() if reality is None else reality
    if rng is None and reality != Reality.clean():
        raise ValueError("a picture with noise needs rng, such as numpy.random.default_rng(0)")
    seen_from = _relative(field, pose)
    scene = _Scene(field, seen_from, view)
    canvas = _Canvas(scene)
    shown = np.sqrt(canvas.light).reshape(view.size[1], view.size[0], 3) * np.float32(255)
    if reality.noise and rng is not None:
        shown += rng.standard_normal(shown.shape, dtype=np.float32) * np.float32(reality.noise)
    pixels = np.clip(np.rint(shown), 0, 255).astype(np.uint8)
    labels = canvas.labels.reshape(view.size[1], view.size[0])
    return pixels, PictureTruth(labels, visible_landmarks(field, pose, view), pose, view)


def visible_landmarks(field: Field, pose: Pose, view: CameraView) -> tuple[VisibleLandmark, ...]:
    """Landmarks of the field that fall inside a picture.

    Parameters
    ----------
    field : Field
        What stands there.
    pose : Pose
        The robot's pose in the world.
    view : CameraView
        The camera's true view from the robot.

    Returns
    -------
    tuple of VisibleLandmark
        In the order of ``field.landmarks``.
    """
    seen_from = _relative(field, pose)
    positions = np.array([(mark.x, mark.y) for mark in field.landmarks])
    pixels = view.project(positions, seen_from)
    local = seen_from.to_local(positions)
    inside = view.contains(pixels)
    hidden = _behind_posts(field, positions, seen_from.to_parent([view.offset])[0], view.height)
    return tuple(
        VisibleLandmark(
            landmark=field.landmarks[i],
            pixel=(float(pixels[i, 0]), float(pixels[i, 1])),
            distance=float(np.hypot(*local[i])),
            bearing=float(np.arctan2(local[i, 1], local[i, 0])),
            occluded=bool(hidden[i]),
        )
        for i in np.flatnonzero(inside)
    )


def _relative(field: Field, pose: Pose) -> Pose:
    """The robot's pose in the field frame, to the nanometre, so that a moved world gives the same bytes."""
    relative = (field.pose.inverse() @ pose).as_array()
    return Pose.from_array(np.round(relative, 9))


def _behind_posts(field: Field, points: FloatArray, eye: FloatArray, height: float) -> npt.NDArray[np.bool_]:
    """Whether a post stands on the straight way from the camera to each point on the ground."""
    hidden = np.zeros(len(points), dtype=bool)
    radius, top = field.dimensions.post_diameter / 2, field.dimensions.post_height
    way = points - eye
    for post in field.posts:
        along = ((post - eye) * way).sum(axis=1) / np.maximum((way**2).sum(axis=1), 1e-12)
        beside = np.hypot(*(eye + along[:, None] * way - post).T)
        own = np.hypot(*(points - post).T) <= radius
        below_top = height * (1 - along) <= top
        hidden |= (along > 0) & (along < 1) & (beside < radius) & below_top & ~own
    return hidden


# --- the pixel grid ---


@dataclass(frozen=True)
class _Grid:
    """A camera's rays: (right, down) of each pixel's middle in focal lengths, and how they change by a pixel."""

    right: Float32
    down: Float32
    right_du: Float32
    right_dv: Float32
    down_du: Float32
    down_dv: Float32


@lru_cache(maxsize=8)
def _grid(size: tuple[int, int], focal: tuple[float, float], view: CameraView) -> _Grid:
    """Rays of a camera; `view` stands at a fixed place, so that only its lens matters to the cache."""
    width, height = size
    # One pixel more on each side, for the differences.
    u, v = np.meshgrid(np.arange(-1.0, width + 1), np.arange(-1.0, height + 1))
    flat = (view.undistort(np.column_stack([u.ravel(), v.ravel()])) - view.centre) / focal
    right, down = (flat[:, i].reshape(height + 2, width + 2) for i in (0, 1))

    def inner(array: FloatArray) -> Float32:
        return np.ascontiguousarray(array, dtype=np.float32).ravel()

    return _Grid(
        inner(right[1:-1, 1:-1]),
        inner(down[1:-1, 1:-1]),
        inner((right[1:-1, 2:] - right[1:-1, :-2]) / 2),
        inner((right[2:, 1:-1] - right[:-2, 1:-1]) / 2),
        inner((down[1:-1, 2:] - down[1:-1, :-2]) / 2),
        inner((down[2:, 1:-1] - down[:-2, 1:-1]) / 2),
    )


def _rays(view: CameraView) -> _Grid:
    lens_only = CameraView(view.size, view.hfov, view.vfov, height=1.0, pitch=0.0, k1=view.k1)
    return _grid(view.size, view.focal, lens_only)


def _cut_square(distance: Float32, along_u: Float32, along_v: Float32) -> Float32:
    """Area of each unit square on the positive side of a straight edge.

    `distance` is a linear function's value at the square's middle, (`along_u`, `along_v`) its gradient. The
    area is the integral of a clipped ramp, written with that ramp's antiderivative.
    """
    u, v = np.abs(along_u), np.abs(along_v)
    steep = np.maximum(np.maximum(u, v), np.float32(1e-20))
    flat = np.maximum(np.minimum(u, v) / steep, np.float32(0.01))  # below 1 % the edge is level: no difference
    middle = np.clip(distance / steep, -2, 2) + np.float32(0.5)
    half = flat / 2

    def ramp(x: Float32) -> Float32:
        inside = np.clip(x, 0, 1)
        return inside * inside / 2 + np.maximum(x - 1, 0)

    return np.asarray((ramp(middle + half) - ramp(middle - half)) / flat, dtype=np.float32)


# --- shapes as the camera sees them ---


@dataclass(frozen=True)
class _Covered:
    """How much of which pixels a shape covers: flat indices, and areas from 0 to 1."""

    pixels: Indices
    area: Float32


_NOTHING = _Covered(np.empty(0, dtype=np.intp), np.empty(0, dtype=np.float32))


class _Scene:
    """The field's shapes in the camera's axes (ahead, left, up)."""

    def __init__(self, field: Field, seen_from: Pose, view: CameraView) -> None:
        self.field, self.seen_from, self.view = field, seen_from, view
        self.grid = _rays(view)

    def to_camera(self, points: npt.ArrayLike) -> FloatArray:
        """Points (N, 3) of the field frame, in the camera's axes."""
        array = np.asarray(points, dtype=float)
        robot = np.column_stack([self.seen_from.to_local(array[:, :2]), array[:, 2]])
        return np.asarray((robot - self.view.position) @ self.view.rotation)

    # --- outlines: which pixels to look at ---

    def outline(self, corners: FloatArray) -> npt.NDArray[np.int32] | None:
        """Pixels around a convex polygon (N, 3) of the camera's axes, clipped to a little more than the view."""
        clipped = _clip(corners, self._clip_planes())
        if len(clipped) < 3:
            return None
        steps = np.linspace(0, 1, _EDGE_PIECES, endpoint=False)[:, None]
        following = np.roll(clipped, -1, axis=0)
        path = np.concatenate([a + steps * (b - a) for a, b in zip(clipped, following, strict=True)])
        rays = -path[:, 1:] / path[:, :1]
        pixels = self.view.distort(rays * self.view.focal + self.view.centre)
        pixels = pixels[np.isfinite(pixels).all(axis=1)]
        return np.rint(pixels).astype(np.int32) if len(pixels) >= 3 else None

    def _clip_planes(self) -> FloatArray:
        """Half-spaces n . p >= 0 that bound the view, with a margin that keeps the lens model valid."""
        width, height = self.view.size
        corner = self.view.undistort([[width + 3.0, height + 3.0]])[0]
        reach = (corner - self.view.centre) / self.view.focal
        a, b = np.where(np.isfinite(reach), reach, self.view.lens_limit / np.sqrt(2))
        return np.array([[1, 0, 0], [a, 1, 0], [a, -1, 0], [b, 0, 1], [b, 0, -1]], dtype=float)

    def region(self, outline: npt.NDArray[np.int32] | None, rim_only: bool = False) -> Indices:
        """Flat indices of the pixels inside an outline and on its rim, or of the rim alone."""
        width, height = self.view.size
        if outline is None:
            return _NOTHING.pixels
        low = np.maximum(outline.min(axis=0) - 2, 0)
        high = np.minimum(outline.max(axis=0) + 3, (width, height))
        if (low >= high).any():
            return _NOTHING.pixels
        mask = np.zeros((high[1] - low[1], high[0] - low[0]), dtype=np.uint8)
        shifted = [(outline - low).astype(np.int32)]
        if not rim_only:
            cv2.fillPoly(mask, shifted, 1)
        cv2.polylines(mask, shifted, True, 1, thickness=3)
        rows, columns = np.nonzero(mask)
        return (rows + low[1]) * width + columns + low[0]

    # --- exact areas ---

    def side(self, normal: FloatArray, pixels: Indices) -> Float32:
        """Area of pixels on the positive side of a plane through the camera's centre."""
        n = np.asarray(normal / max(np.hypot(normal[1], normal[2]), 1e-12), dtype=np.float32)
        g = self.grid
        value = n[0] - n[1] * g.right[pixels] - n[2] * g.down[pixels]
        du = n[1] * g.right_du[pixels] + n[2] * g.down_du[pixels]
        dv = n[1] * g.right_dv[pixels] + n[2] * g.down_dv[pixels]
        return _cut_square(value, du, dv)

    def quad(self, corners: FloatArray, pixels: Indices | None = None) -> _Covered:
        """Area of pixels inside a quadrilateral (4, 3) of the camera's axes, given in order around it."""
        if pixels is None:
            pixels = self.region(self.outline(corners))
        if not len(pixels):
            return _NOTHING
        normals = np.cross(corners, np.roll(corners, -1, axis=0))
        if normals[0] @ corners[2] < 0:
            normals = -normals
        first, second, third, fourth = (self.side(n, pixels) for n in normals)
        # Opposite edges may cut the same pixel: a thin strip is one side less what the other leaves out.
        area = np.maximum(first + third - 1, 0) * np.maximum(second + fourth - 1, 0)
        return _Covered(pixels, area)

    def disc(self, centre: FloatArray, normal: FloatArray, radius: float, pixels: Indices) -> Float32:
        """Area of pixels inside a flat disc; `centre` and unit `normal` (3,) in the camera's axes."""
        g = self.grid
        right, down = g.right[pixels].astype(float), g.down[pixels].astype(float)
        slope = normal[0] - normal[1] * right - normal[2] * down  # normal . ray, for the ray (1, -right, -down)
        depth = float(normal @ centre)
        # The ray meets the disc's plane at ray * depth / slope; from the centre, times slope:
        away = [depth - slope * centre[0], -right * depth - slope * centre[1], -down * depth - slope * centre[2]]
        value = radius**2 * slope**2 - sum(a * a for a in away)

        def change(right_d: Float32, down_d: Float32) -> FloatArray:
            slope_d = -normal[1] * right_d - normal[2] * down_d
            away_d = [
                -slope_d * centre[0],
                -right_d * depth - slope_d * centre[1],
                -down_d * depth - slope_d * centre[2],
            ]
            return np.asarray(
                2 * radius**2 * slope * slope_d - 2 * sum(a * d for a, d in zip(away, away_d, strict=True))
            )

        du = change(g.right_du[pixels], g.down_du[pixels])
        dv = change(g.right_dv[pixels], g.down_dv[pixels])
        # Twice the root of the quadratic is nearer to a distance than the quadratic: scale to unit slope.
        scale = np.maximum(np.maximum(np.abs(du), np.abs(dv)), 1e-30)
        area = _cut_square(*((x / scale).astype(np.float32) for x in (value, du, dv)))
        return np.where(depth / np.where(slope == 0, np.inf, slope) > 0, area, np.float32(0))

    def ring_points(self, centre: FloatArray, axis: FloatArray, radius: float, n: int = 48) -> FloatArray:
        """Points (n, 3) on a circle about `axis`, all in the camera's axes."""
        first = np.cross(axis, [1.0, 0.0, 0.0] if abs(axis[0]) < 0.9 else [0.0, 1.0, 0.0])
        first /= np.linalg.norm(first)
        second = np.cross(axis, first)
        angles = np.linspace(0, 2 * np.pi, n, endpoint=False)[:, None]
        return np.asarray(centre + radius * (np.cos(angles) * first + np.sin(angles) * second))

    def cylinder(self, start: FloatArray, end: FloatArray, radius: float) -> tuple[_Covered, Float32]:
        """Area of pixels covered by a solid cylinder between two points, and how lit each is (0 to 1)."""
        axis = (end - start) / np.linalg.norm(end - start)
        across = -start + (start @ axis) * axis  # from the axis to the camera, at right angles
        distance = float(np.linalg.norm(across))
        if distance <= radius:
            return _NOTHING, _NOTHING.area  # the camera is inside: nothing to see
        towards = across / distance
        aside = np.cross(axis, towards)
        # The planes from the camera that touch the cylinder meet it here.
        reach, width = radius**2 / distance, radius * np.sqrt(1 - (radius / distance) ** 2)
        left, right = (reach * towards + s * width * aside for s in (1, -1))
        corners = np.array([start + left, end + left, end + right, start + right])
        rims = [self.ring_points(point, axis, radius) for point in (start, end)]
        hull = [self.region(self.outline(shape)) for shape in (corners, *rims)]
        pixels = np.unique(np.concatenate(hull))
        if not len(pixels):
            return _NOTHING, _NOTHING.area
        area = self.quad(corners, pixels).area
        for point in (start, end):
            area = np.maximum(area, self.disc(point, axis, radius, pixels))
        g = self.grid
        rays = np.stack([np.ones(len(pixels)), -g.right[pixels], -g.down[pixels]], axis=1)
        sideways = (rays @ aside) / np.maximum(-(rays @ towards), 1e-6) * distance / width
        return _Covered(pixels, area), np.sqrt(np.clip(1 - sideways**2, 0, 1)).astype(np.float32)

    # --- the field ---

    def rectangle(self, x0: float, y0: float, x1: float, y1: float) -> FloatArray:
        """Corners (4, 3) of a rectangle on the ground, in the camera's axes."""
        return self.to_camera([(x0, y0, 0.0), (x1, y0, 0.0), (x1, y1, 0.0), (x0, y1, 0.0)])

    def line_shapes(self) -> Iterator[_Covered]:
        """Every straight line and mark."""
        half = self.field.dimensions.line_width / 2
        for x0, y0, x1, y1 in self.field.lines:  # ends run to the crossing line's far edge
            yield self.quad(self.rectangle(x0 - half, y0 - half, x1 + half, y1 + half))
        for x0, y0, x1, y1 in self.field.mark_lines:
            dx, dy = (0.0, half) if y0 == y1 else (half, 0.0)
            yield self.quad(self.rectangle(x0 - dx, y0 - dy, x1 + dx, y1 + dy))

    def arc_shapes(self) -> Iterator[_Covered]:
        """Every circle of line."""
        half = self.field.dimensions.line_width / 2
        for x, y, radius, first, last in self.field.arcs:
            centre = self.to_camera([(x, y, 0.0)])[0]
            up = self.to_camera([(x, y, 1.0)])[0] - centre
            pixels = self._ring_region(x, y, radius, first, last)
            if not len(pixels):
                continue
            area = self.disc(centre, up, radius + half, pixels) - self.disc(centre, up, radius - half, pixels)
            if last - first < 2 * np.pi:  # the half that begins on the halfway line
                ends = self.to_camera([(x, y - radius, 0.0), (x, y + radius, 0.0)])
                normal = np.cross(ends[0], ends[1])
                beyond = self.to_camera([(x + 1.0, y, 0.0)])[0]
                area = area * self.side(normal * np.sign(normal @ beyond), pixels)
            yield _Covered(pixels, np.clip(area, 0, 1))

    def _ring_region(self, x: float, y: float, radius: float, first: float, last: float) -> Indices:
        """Pixels of an arc: cut into wedges, each a small quadrilateral."""
        angles = np.linspace(first, last, 49)
        half = self.field.dimensions.line_width / 2
        rims = [
            self.to_camera(
                np.column_stack([x + r * np.cos(angles), y + r * np.sin(angles), np.zeros(len(angles))])
            )
            for r in (radius - half, radius + half * 1.01)
        ]
        wedges = (np.array([rims[0][i], rims[1][i], rims[1][i + 1], rims[0][i + 1]]) for i in range(48))
        return np.unique(np.concatenate([self.region(self.outline(w)) for w in wedges]))

    def goal_shapes(self) -> Iterator[tuple[_Covered, Float32]]:
        """Every bar and post, the farthest first."""
        d = self.field.dimensions
        solids = []
        for ends in self.field.bars:
            solids.append((*self.to_camera(ends), d.bar_diameter / 2))
        for x, y in self.field.posts:
            solids.append((*self.to_camera([(x, y, 0.0), (x, y, d.post_height)]), d.post_diameter / 2))
        solids.sort(key=lambda solid: -float(np.linalg.norm(solid[0] + solid[1])))
        for start, end, radius in solids:
            yield self.cylinder(start, end, radius)

    def ground_area(self, x0: float, y0: float, x1: float, y1: float) -> Float32:
        """Area of every pixel inside a rectangle on the ground, flat (H * W,): for large ones."""
        width, height = self.view.size
        corners = self.rectangle(x0, y0, x1, y1)
        outline = self.outline(corners)
        mask = np.zeros((height, width), dtype=np.uint8)
        if outline is not None:
            cv2.fillPoly(mask, [outline], 1)
        area = mask.ravel().astype(np.float32)
        rim = self.quad(corners, self.region(outline, rim_only=True))
        area[rim.pixels] = rim.area
        return area


class _Canvas:
    """Light (H * W, 3) and labels (H * W,) of a scene, painted from the background forwards."""

    def __init__(self, scene: _Scene) -> None:
        x0, y0, x1, y1 = scene.field.carpet
        m = _ROOM_MARGIN
        floor = scene.ground_area(x0 - m, y0 - m, x1 + m, y1 + m)[:, None]
        carpet = scene.ground_area(x0, y0, x1, y1)
        self.light = _COLOURS["wall"] + floor * (_COLOURS["floor"] - _COLOURS["wall"])
        self.light += carpet[:, None] * (_COLOURS["carpet"] - self.light)
        self.labels = np.where(carpet >= 0.5, GREEN, OTHER).astype(np.uint8)
        self._paint_lines(scene)
        self._paint_goals(scene)

    def _paint_lines(self, scene: _Scene) -> None:
        white = np.zeros(len(self.labels), dtype=np.float32)
        for shapes in (scene.line_shapes(), scene.arc_shapes()):
            for shape in shapes:
                white[shape.pixels] = 1 - (1 - white[shape.pixels]) * (1 - shape.area)
        touched = np.flatnonzero(white)
        area = white[touched, None]
        self.light[touched] += area * (_COLOURS["line"] - self.light[touched])
        self.labels[white >= 0.5] = WHITE

    def _paint_goals(self, scene: _Scene) -> None:
        colour = scene.field.dimensions.goal_colour
        label = YELLOW if colour == "yellow" else WHITE
        covered = np.zeros(len(self.labels), dtype=np.float32)
        for shape, lit in scene.goal_shapes():
            paint = _COLOURS[colour] * (0.55 + 0.45 * lit[:, None])
            self.light[shape.pixels] += shape.area[:, None] * (paint - self.light[shape.pixels])
            covered[shape.pixels] = 1 - (1 - covered[shape.pixels]) * (1 - shape.area)
        self.labels[covered >= 0.5] = label


def _clip(polygon: FloatArray, planes: FloatArray) -> FloatArray:
    """Clip a convex polygon (N, 3) to half-spaces n . p >= 0 (Sutherland and Hodgman)."""
    polygon = np.asarray(polygon, dtype=float)
    for normal in planes:
        if not len(polygon):
            break
        height = polygon @ normal
        if (height >= 0).all():
            continue
        kept: list[FloatArray] = []
        for i, here in enumerate(polygon):
            h, before = height[i], height[i - 1]
            if (h >= 0) != (before >= 0):
                kept.append(polygon[i - 1] + (here - polygon[i - 1]) * before / (before - h))
            if h >= 0:
                kept.append(here)
        polygon = np.array(kept).reshape(-1, 3)
    return polygon
