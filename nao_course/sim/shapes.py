"""Exact areas that shapes cover in each pixel, computed from the shapes' edges without sampling.

A line on the carpet is a rectangle, and a post is a cylinder. As seen from the camera, their edges are planes and cones
through the centre of the camera. The ray of a pixel therefore has a signed distance to each edge, and the area of a
unit square that is cut by a straight edge has a closed form. Only pixels near an edge are computed; the inside is
filled.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, Pose
from nao_course.sim.camera import CameraView

Float32 = npt.NDArray[np.float32]
Indices = npt.NDArray[np.intp]

_EDGE_PIECES = 12  # segments of a straight edge, which the lens bends
_INSIDE, _RIM = 1, 2
_STEPS = np.linspace(0, 1, _EDGE_PIECES, endpoint=False)[:, None]
_X_AXIS, _Y_AXIS = np.eye(3)[:2]
_NEXT, _BEFORE = [1, 2, 0], [2, 0, 1]  # indices of the coordinates in a cross product


@dataclass(frozen=True, eq=False)
class Covered:
    """Flat indices of pixels that a shape covers: `inside` (K,) completely, `rim` (M,) by an `area` (M,) of 0 to 1."""

    inside: Indices
    rim: Indices
    area: Float32

    def add_to(self, uncovered: Float32) -> None:
        """Multiply the uncovered areas (H * W,) by the areas that this shape leaves uncovered."""
        uncovered[self.inside] = 0
        uncovered[self.rim] *= 1 - self.area


class Grid:
    """Rays (1, -right, -down) through the centres of all pixels (H, W), and their changes along a row and a column.

    `flat` (6, H * W) holds all arguments in their order, so that one call returns what a pixel needs.
    """

    def __init__(self, *parts: npt.ArrayLike) -> None:
        stacked = np.array(parts, dtype=np.float32)
        self.flat = stacked.reshape(len(parts), -1)
        self.right, self.down = stacked[:2]


def _turned(grid: Grid, size: tuple[int, int], turning: FloatArray) -> Grid:
    """Return the rays of a camera that rotates by small angles (3,) while its rows are read out."""
    height = size[1]
    about_ahead, about_left, about_up = turning.astype(np.float32)
    left, up = -grid.right, -grid.down
    when = ((np.arange(height, dtype=np.float32) - (height - 1) / 2) / max(height - 1, 1))[:, None]
    ahead = 1 + when * (about_left * up - about_up * left)
    right = -(left + when * (about_up - about_ahead * up)) / ahead
    down = -(up + when * (about_ahead * left - about_left)) / ahead

    def derivative(a: Float32, axis: int) -> FloatArray:
        return np.asarray(np.gradient(a, axis=axis)) if a.shape[axis] > 1 else np.zeros_like(a)

    changes = (derivative(part, axis) for part in (right, down) for axis in (1, 0))
    return Grid(right, down, *changes)


@lru_cache(maxsize=6)
def _lens_grid(lens: CameraView) -> Grid:
    """Return the rays of a camera at rest; `lens` has a standard position and angles, so that the cache is shared."""
    width, height = lens.size
    # The differences need one more pixel on each side.
    u, v = np.meshgrid(np.arange(-1.0, width + 1), np.arange(-1.0, height + 1))
    flat = (lens.undistort(np.column_stack([u.ravel(), v.ravel()])) - lens.centre) / lens.focal
    right, down = (flat[:, i].reshape(height + 2, width + 2) for i in (0, 1))
    changes = (
        change
        for part in (right, down)
        for change in ((part[1:-1, 2:] - part[1:-1, :-2]) / 2, (part[2:, 1:-1] - part[:-2, 1:-1]) / 2)
    )
    return Grid(right[1:-1, 1:-1], down[1:-1, 1:-1], *changes)


@lru_cache(maxsize=6)
def _lens_reach(lens: CameraView) -> FloatArray:
    """Return the coordinates (right, down) of a ray beyond a camera's corner by a small margin."""
    width, height = lens.size
    corner = lens.undistort([[width + 3.0, height + 3.0]])[0]
    reach = (corner - lens.centre) / lens.focal
    return np.asarray(np.where(np.isfinite(reach), reach, lens.lens_limit / np.sqrt(2)))


def cut_square(distance: Float32, along_u: Float32, along_v: Float32) -> Float32:
    """Return the areas (N,) of unit squares where a linear function is positive, as the integral of a clipped ramp.

    Each function is given by its value at the square's centre and its gradient, (N,) each.
    """
    u, v = np.abs(along_u), np.abs(along_v)
    steep = np.maximum(np.maximum(u, v), np.float32(1e-20))
    level = np.float32(0.01)  # smaller gradients give the same area, and would divide by 0
    half = np.asarray(np.maximum(np.minimum(u, v) / steep, level) / 2, dtype=np.float32)
    middle = np.asarray(np.clip(distance / steep, -2, 2) + 0.5, dtype=np.float32)

    def ramp(x: Float32) -> Float32:
        inside = np.clip(x, 0, 1)
        return np.asarray(inside * inside / 2 + np.maximum(x - 1, 0), dtype=np.float32)

    return np.asarray((ramp(middle + half) - ramp(middle - half)) / (2 * half), dtype=np.float32)


class Eye:
    """A camera at a pose on a field, which computes the pixels that shapes cover.

    `seen_from` is the robot's pose in the field frame, and the view is the true one while the middle row is read out.
    `turning` (3,) is the rotation of the camera about its own axes (ahead, left, up) from the first row to the last,
    rad: with a rolling shutter, each row has another direction. `grid` has the rays in the camera frame, and
    `ground_position` (2,) is the point below the camera in the field frame, m.
    """

    def __init__(self, seen_from: Pose, view: CameraView, turning: npt.ArrayLike = (0.0, 0.0, 0.0)) -> None:
        """Compute the rays of the camera, or take them from the cache."""
        self.seen_from, self.view = seen_from, view
        self.turning = np.asarray(turning, dtype=float)
        if self.turning.shape != (3,) or not (np.abs(self.turning) <= 0.5).all():
            raise ValueError(f"turning must be three small angles, within -0.5..0.5 rad, got {turning!r}")
        self._lens = CameraView(view.size, view.hfov, view.vfov, height=1.0, pitch=0.0, k1=view.k1)
        still = _lens_grid(self._lens)
        self.grid = _turned(still, view.size, self.turning) if self.turning.any() else still
        self._planes = self._clip_planes()
        self._rotation, self._position = view.rotation, view.position
        self.ground_position: FloatArray = seen_from.to_parent([view.offset])[0]

    def field_rays(self, every: int = 1) -> Float32:
        """Return the directions (3, rows, columns), in the field frame, of the rays through every n-th pixel."""
        width, height = self.view.size
        right, down = self.grid.right, self.grid.down
        if every > 1:
            some = np.ix_(centre_pixels(height, every), centre_pixels(width, every))
            right, down = right[some], down[some]
        c, s = np.cos(self.seen_from.theta), np.sin(self.seen_from.theta)
        turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) @ self._rotation
        rays = np.empty((3, *right.shape), dtype=np.float32)
        for ray, (ahead, left, up) in zip(rays, turn.astype(np.float32), strict=True):
            np.subtract(ahead, left * right, out=ray)
            ray -= up * down
        return rays

    def to_camera(self, points: npt.ArrayLike) -> FloatArray:
        """Transform points (..., 3) from the field frame to the camera frame (ahead, left, up), m."""
        array = np.asarray(points, dtype=float)
        flat = array.reshape(-1, 3)
        robot = np.column_stack([self.seen_from.to_local(flat[:, :2]), flat[:, 2]])
        return np.asarray((robot - self._position) @ self._rotation).reshape(array.shape)

    # --- outlines ---

    def _clip_planes(self) -> FloatArray:
        """Return half-spaces n . p >= 0 that bound the view with a small margin, where the lens model is valid."""
        reach = _lens_reach(self._lens)
        # A rotating camera sees a larger region.
        a, b = reach + (1 + reach**2) * np.abs(self.turning).sum() / 2
        return np.array([[1, 0, 0], [a, 1, 0], [a, -1, 0], [b, 0, 1], [b, 0, -1]], dtype=float)

    def reached(
        self, points: FloatArray, starts: Indices
    ) -> tuple[npt.NDArray[np.bool_], npt.NDArray[np.bool_]]:
        """Return for each polygon, with points (N, 3) from `starts` (P,), whether it may be in view, or wholly is."""
        heights = points @ self._planes.T
        highest, lowest = (each.reduceat(heights, starts) for each in (np.maximum, np.minimum))
        return np.all(highest >= 0, axis=1), np.all(lowest >= 0, axis=1) & (lowest[:, 0] > 0.05)

    def outlines(self, polygons: Iterable[FloatArray]) -> list[npt.NDArray[np.int32] | None]:
        """Return outlines in integer pixels of convex polygons (N, 3) in the camera frame; None if out of view."""
        shapes = list(polygons)
        found: list[npt.NDArray[np.int32] | None] = [None] * len(shapes)
        areas = [i for i, shape in enumerate(shapes) if len(shape) >= 3]
        if not areas:
            return found
        starts = np.cumsum([0, *(len(shapes[i]) for i in areas[:-1])])
        reached, inside = self.reached(np.concatenate([shapes[i] for i in areas]), starts)
        paths, owners = [], []
        for i, seen, whole in zip(areas, reached.tolist(), inside.tolist(), strict=True):
            if not seen:
                continue
            clipped = shapes[i] if whole else clip_polygon(shapes[i], self._planes)
            if len(clipped) < 3:
                continue
            if len(clipped) <= 2 * _EDGE_PIECES:  # a circle already has enough points
                edges = clipped[[*range(1, len(clipped)), 0]] - clipped
                clipped = (clipped[:, None] + _STEPS * edges[:, None]).reshape(-1, 3)
            paths.append(clipped)
            owners.append(i)
        if not paths:
            return found
        pixels = np.rint(self.pixels(np.concatenate(paths))).astype(np.int32)
        start = 0
        for i, path in zip(owners, paths, strict=True):
            found[i] = pixels[start : start + len(path)]
            start += len(path)
        return found

    def pixels(self, points: FloatArray) -> FloatArray:
        """Project points (N, 3) of the camera frame to pixels (N, 2), far outside for points behind the camera."""
        uv = self._still_pixels(points)
        if self.turning.any():
            for _ in range(3):  # the time depends on the row, and the row on the rotation at that time
                when = (uv[:, 1:] - self.view.centre[1]) / max(self.view.size[1] - 1, 1)
                uv = self._still_pixels(points - cross(np.clip(when, -1, 1) * self.turning, points))
        return uv

    def _still_pixels(self, points: FloatArray) -> FloatArray:
        rays = -points[:, 1:] / np.where(points[:, :1] > 1e-6, points[:, :1], 1e-6)
        r2 = np.minimum((rays**2).sum(axis=1, keepdims=True), self.view.lens_limit**2)
        return np.clip(rays * (1 + self.view.k1 * r2) * self.view.focal + self.view.centre, -30000, 30000)

    def _regions(
        self, filled: Sequence[npt.NDArray[np.int32]], holes: Sequence[npt.NDArray[np.int32]] = ()
    ) -> tuple[Indices, Indices]:
        """Return flat indices of the pixels inside outlines but outside of holes, and of the pixels on the rims."""
        width, height = self.view.size
        nothing = np.empty(0, dtype=np.intp)
        if not filled:
            return nothing, nothing
        left, top, wide, high = cv2.boundingRect(filled[0] if len(filled) == 1 else np.concatenate(filled))
        first_row, first_column = max(top - 2, 0), max(left - 2, 0)
        rows, columns = min(top + high + 2, height) - first_row, min(left + wide + 2, width) - first_column
        if rows <= 0 or columns <= 0:
            return nothing, nothing
        mask = np.zeros((rows, columns), dtype=np.uint8)
        low = np.array([first_column, first_row], dtype=np.int32)
        for outline in filled:
            cv2.fillPoly(mask, [outline - low], _INSIDE)
        for outline in holes:
            cv2.fillPoly(mask, [outline - low], 0)
        for outline in (*filled, *holes):
            cv2.polylines(mask, [outline - low], True, _RIM, thickness=3)

        def flat(kind: int) -> Indices:
            found = np.flatnonzero(mask == kind)
            found += found // columns * (width - columns) + (first_row * width + first_column)
            return found

        return flat(_INSIDE), flat(_RIM)

    # --- exact areas ---

    def side(self, normals: FloatArray, pixels: Indices, owner: Indices | None = None) -> Float32:
        """Return the areas (..., M) of pixels (M,) on the positive side of planes through the centre of the camera.

        `normals` are planes (..., 3) for all pixels; or planes (..., N, 3), and `owner` (M,) has each pixel's index.
        """
        scale = np.maximum(np.hypot(normals[..., 1:2], normals[..., 2:3]), 1e-12)
        planes = np.moveaxis(np.asarray(normals / scale, dtype=np.float32), -1, 0)
        ahead, left, up = planes[..., None] if owner is None else planes[..., owner]
        right, down, right_du, right_dv, down_du, down_dv = self.grid.flat.take(pixels, axis=1)
        value = ahead - left * right - up * down
        return cut_square(value, left * right_du + up * down_du, left * right_dv + up * down_dv)

    def quad_area(self, corners: FloatArray, pixels: Indices, owner: Indices | None = None) -> Float32:
        """Return the area of pixels inside quadrilaterals (N, 4, 3) of the camera frame, with corners in order.

        `owner` has the index of each pixel's quadrilateral; without it there is only one.
        """
        normals = cross(corners, corners[:, [1, 2, 3, 0]])
        facing = np.sign((normals[:, 0] * corners[:, 2]).sum(axis=1))
        normals *= np.where(facing == 0, 1, facing)[:, None, None]
        sides = normals[0] if owner is None else normals.transpose(1, 0, 2)
        first, second, third, fourth = self.side(sides, pixels, owner)
        # Two opposite edges may cut the same pixel. The area between them is the sum of both areas minus 1.
        return np.maximum(first + third - 1, 0) * np.maximum(second + fourth - 1, 0)

    def quads(self, corners: FloatArray) -> Iterator[Covered]:
        """Yield the covered pixels of each quadrilateral (N, 4, 3) of the camera frame that is in view."""
        visible = [(i, o) for i, o in enumerate(self.outlines(corners)) if o is not None]
        regions = [self._regions([outline]) for _, outline in visible]
        if not regions:
            return
        pixels = np.concatenate([rim for _, rim in regions])
        owner = np.repeat([i for i, _ in visible], [len(rim) for _, rim in regions])
        area = self.quad_area(corners, pixels, owner)  # all at once, because each call has an overhead
        start = 0
        for inside, rim in regions:
            yield Covered(inside, rim, area[start : start + len(rim)])
            start += len(rim)

    def large_quad(self, corners: FloatArray) -> tuple[npt.NDArray[np.uint8], Covered]:
        """Return the pixels covered by a quadrilateral (4, 3) that may fill the picture.

        The mask (H, W) is not 0 for pixels that are wholly inside, and `rim` has no pixels in `inside`.
        """
        outline = self.outlines([corners])[0]
        mask = np.zeros(self.view.size[::-1], dtype=np.uint8)
        if outline is not None:
            cv2.fillPoly(mask, [outline], _INSIDE)
            cv2.polylines(mask, [outline], True, _RIM, thickness=3)
        rim = np.flatnonzero(mask == _RIM)
        mask[mask == _RIM] = 0
        area = self.quad_area(corners[None], rim)
        return mask, Covered(np.empty(0, dtype=np.intp), rim, area)

    def disc_area(self, centre: FloatArray, normal: FloatArray, radius: float, pixels: Indices) -> Float32:
        """Return the area of pixels inside a flat disc; `centre` and unit `normal` are in the camera frame."""
        right, down, right_du, right_dv, down_du, down_dv = self.grid.flat.take(pixels, axis=1)
        right, down = right.astype(float), down.astype(float)
        depth = float(normal @ centre)

        def away(
            slope: FloatArray, ahead: FloatArray | float, right: FloatArray, down: FloatArray
        ) -> list[FloatArray]:
            """Return the vector from the disc's centre to the ray's point on its plane, times normal . ray."""
            rays = (ahead, -right, -down)
            return [
                np.asarray(depth * ray - slope * middle) for ray, middle in zip(rays, centre, strict=True)
            ]

        slope = normal[0] - normal[1] * right - normal[2] * down
        here = away(slope, 1.0, right, down)
        value = radius**2 * slope**2 - sum(a * a for a in here)

        def change(right_d: Float32, down_d: Float32) -> FloatArray:
            slope_d = -normal[1] * right_d - normal[2] * down_d
            there = away(slope_d, 0.0, right_d.astype(float), down_d.astype(float))
            return np.asarray(
                2 * (radius**2 * slope * slope_d - sum(a * d for a, d in zip(here, there, strict=True)))
            )

        du, dv = change(right_du, down_du), change(right_dv, down_dv)
        scale = np.maximum(np.maximum(np.abs(du), np.abs(dv)), 1e-30)
        area = cut_square(*((x / scale).astype(np.float32) for x in (value, du, dv)))
        return np.where(slope * depth > 0, area, np.float32(0))

    def ring(
        self, centre: FloatArray, up: FloatArray, radii: tuple[float, float], half: FloatArray | None
    ) -> Covered:
        """Return the pixels of a flat ring between two radii, or of its half on the positive side of a plane (3,)."""
        outer, inner = self.outlines(
            self._round(centre, up, radius, half) for radius in (max(radii), min(radii))
        )
        if outer is None:
            return Covered(*self._regions([]), np.empty(0, dtype=np.float32))
        inside, rim = self._regions([outer], [] if inner is None else [inner])
        area = self.disc_area(centre, up, max(radii), rim) - self.disc_area(centre, up, min(radii), rim)
        if half is not None:
            area = area * self.side(half, rim)
        return Covered(inside, rim, np.clip(area, 0, 1))

    @staticmethod
    def _round(centre: FloatArray, up: FloatArray, radius: float, half: FloatArray | None) -> FloatArray:
        """Return a circle about an axis, or half of it, as a polygon (N, 3) in the camera frame."""
        points = circle_points(centre, up, radius, 96)
        return points if half is None else clip_polygon(points, half[None])

    def cylinder(self, start: FloatArray, end: FloatArray, radius: float) -> tuple[Covered, Float32, Float32]:
        """Return the pixels covered by a cylinder, and how directly its surface faces the camera (0 to 1)."""
        nothing = Covered(*self._regions([]), np.empty(0, dtype=np.float32))
        axis = (end - start) / np.linalg.norm(end - start)
        across = -start + (start @ axis) * axis  # perpendicular from the axis to the camera
        distance = float(np.linalg.norm(across))
        if distance <= radius:
            return nothing, nothing.area, nothing.area  # the camera is inside the cylinder
        towards = across / distance
        aside = cross(axis, towards)
        # The tangent planes through the camera touch the cylinder here.
        reach, wide = radius**2 / distance, radius * np.sqrt(1 - (radius / distance) ** 2)
        left, right = (reach * towards + s * wide * aside for s in (1, -1))
        corners = np.array([start + left, end + left, end + right, start + right])
        rims = [circle_points(point, axis, radius, 48) for point in (start, end)]
        inside, rim = self._regions([o for o in self.outlines([corners, *rims]) if o is not None])
        if not len(rim):
            return nothing, nothing.area, nothing.area
        area = self.quad_area(corners[None], rim)
        for point in (start, end):
            area = np.maximum(area, self.disc_area(point, axis, radius, rim))

        def facing(pixels: Indices) -> Float32:
            right, down = self.grid.flat[:2].take(pixels, axis=1)
            rays = np.stack([np.ones(len(pixels)), -right, -down], axis=1)
            sideways = (rays @ aside) / np.maximum(-(rays @ towards), 1e-6) * distance / wide
            return np.sqrt(np.clip(1 - sideways**2, 0, 1)).astype(np.float32)

        return Covered(inside, rim, area), facing(inside), facing(rim)


def centre_pixels(pixels: int, every: int) -> Indices:
    """Return the central pixel of each group of `every` pixels in a row, including the last, incomplete group."""
    return np.minimum(np.arange(every // 2, pixels + every // 2, every), pixels - 1)


def circle_points(centre: FloatArray, axis: FloatArray, radius: float, count: int) -> FloatArray:
    """Return points (count, 3) on a circle about a unit axis (3,)."""
    first = cross(axis, _X_AXIS if abs(axis[0]) < 0.9 else _Y_AXIS)
    first /= np.linalg.norm(first)
    cosines, sines = _unit_circle(count)
    return np.asarray(centre + radius * (cosines * first + sines * cross(axis, first)))


@lru_cache(maxsize=4)
def _unit_circle(count: int) -> tuple[FloatArray, FloatArray]:
    angles = np.linspace(0, 2 * np.pi, count, endpoint=False)[:, None]
    return np.cos(angles), np.sin(angles)


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the cross products of vectors (..., 3); NumPy's own takes four times as long for a few vectors."""
    return np.asarray(a[..., _NEXT] * b[..., _BEFORE] - a[..., _BEFORE] * b[..., _NEXT])


def clip_polygon(polygon: FloatArray, planes: FloatArray) -> FloatArray:
    """Clip a convex polygon (N, 3) to half-spaces n . p >= 0 (Sutherland and Hodgman)."""
    outside = polygon @ planes.T < 0
    if outside.all(axis=0).any():
        return np.empty((0, 3))
    for normal in planes[outside.any(axis=0)]:
        # Lists, because they are three times as fast as arrays for four corners.
        heights, points = (polygon @ normal).tolist(), polygon.tolist()
        kept: list[list[float]] = []
        last, before = points[-1], heights[-1]
        for here, h in zip(points, heights, strict=True):
            if (h >= 0) != (before >= 0):
                kept.append([b + (a - b) * before / (before - h) for a, b in zip(here, last, strict=True)])
            if h >= 0:
                kept.append(here)
            last, before = here, h
        polygon = np.array(kept).reshape(-1, 3)
        if not kept:
            break
    return polygon
