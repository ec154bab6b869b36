"""A canvas for pictures of a scene in space: flat shapes, textures, lines, and triangles with a depth buffer."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from matplotlib.colors import to_rgb

from nao_course.geometry import FloatArray
from nao_course.widgets.world.scene import FIELD_OF_VIEW

Pixels = npt.NDArray[np.uint8]

BACKGROUND = "#e9edf2"
SUPERSAMPLING = 2
NEAR = 0.05  # m
_SUN = np.array([0.35, -0.45, 0.82])  # direction to the light, not normalised
_BATCH = 1_000_000  # pixels that are tested at once
_PIECE = 0.02  # of a line in space: what lies in front of a piece hides it


class Canvas:
    """A picture that is being painted, seen by a pinhole camera."""

    def __init__(self, seen: tuple[FloatArray, FloatArray], size: tuple[int, int]) -> None:
        self.eye, target = seen
        width, height = size
        self.pixels: Any = np.empty((height, width, 3), dtype=np.uint8)
        self.depth = np.full((height, width), np.inf)
        shade = np.linspace(1.0, 0.86, height)[:, None, None]
        self.pixels[:] = np.rint(rgb(BACKGROUND) * shade)
        ahead = (target - self.eye) / np.linalg.norm(target - self.eye)
        right = np.cross(ahead, (0.0, 0.0, 1.0))
        right /= np.linalg.norm(right)
        focal = height / 2 / np.tan(FIELD_OF_VIEW / 2)
        self._axes = np.stack([right, -np.cross(right, ahead), ahead])
        self._camera = np.array([[focal, 0.0, width / 2], [0.0, focal, height / 2], [0.0, 0.0, 1.0]])

    def distance(self, point: FloatArray) -> float:
        """Return the distance of a point (3,) along the line of sight, m."""
        return float(self._axes[2] @ (point - self.eye))

    def project(self, points: FloatArray) -> FloatArray:
        """Return pixels and distances (..., 3) of points (..., 3) in front of the viewer."""
        seen = (points - self.eye) @ self._axes.T
        image = seen @ self._camera.T
        return np.concatenate([image[..., :2] / seen[..., 2:], seen[..., 2:]], axis=-1)

    def outline(self, polygon: FloatArray) -> npt.NDArray[np.int32] | None:
        """Return the outline of a polygon (N, 3) in sixteenths of pixels, cut off in front of the viewer."""
        seen = (polygon - self.eye) @ self._axes.T
        kept = []
        for here, before in zip(seen, np.roll(seen, 1, axis=0), strict=True):
            if (here[2] > NEAR) != (before[2] > NEAR):
                kept.append(before + (here - before) * (NEAR - before[2]) / (here[2] - before[2]))
            if here[2] > NEAR:
                kept.append(here)
        if len(kept) < 3:
            return None
        image = np.array(kept) @ self._camera.T
        pixels = np.clip(image[:, :2] / image[:, 2:], -30000, 30000)
        return np.rint(pixels * 16).astype(np.int32)

    def flat(self, polygons: FloatArray, colour: str) -> None:
        """Paint polygons (M, N, 3) of one colour."""
        for polygon in polygons:
            if (outline := self.outline(polygon)) is not None:
                cv2.fillPoly(self.pixels, [outline], rgb(colour).tolist(), cv2.LINE_AA, 4)

    def blend(self, polygons: FloatArray, colour: str, opacity: float) -> None:
        """Paint polygons (M, N, 3) of one colour over what is there, which shines through."""
        mask = np.zeros(self.pixels.shape[:2], dtype=np.uint8)
        for polygon in polygons:
            if (outline := self.outline(polygon)) is not None:
                cv2.fillPoly(mask, [outline], 255, cv2.LINE_AA, 4)
        self._blend(mask, np.broadcast_to(rgb(colour), self.pixels.shape), opacity)

    def stroke(
        self, points: FloatArray, colour: str, width: float, opacity: float = 1.0, hidden: bool = False
    ) -> None:
        """Draw a line through points (N, 3) that is `width` pixels of the finished picture wide.

        If `hidden` is true, nearer surfaces hide the line.
        """
        mask = np.zeros(self.pixels.shape[:2], dtype=np.uint8)
        seen = (points - self.eye) @ self._axes.T
        steps = np.linspace(0, 1, round(1 / _PIECE) + 1 if hidden else 2)[:, None]
        thick = max(1, round(width * SUPERSAMPLING))
        for start, end in pairwise(seen):
            low, high = (start, end) if start[2] <= end[2] else (end, start)
            if high[2] <= NEAR:
                continue
            if low[2] < NEAR:
                low = high + (low - high) * (high[2] - NEAR) / (high[2] - low[2])
            pieces = low + steps * (high - low)
            image = pieces @ self._camera.T
            pixels = np.rint(np.clip(image[:, :2] / image[:, 2:], -2000, 8000) * 16).astype(int)
            for i in range(len(pieces) - 1):
                if not hidden or self._is_nearest((pieces[i] + pieces[i + 1]) / 2):
                    cv2.line(mask, pixels[i].tolist(), pixels[i + 1].tolist(), 255, thick, cv2.LINE_AA, 4)
        self._blend(mask, np.broadcast_to(rgb(colour), self.pixels.shape), opacity)

    def _is_nearest(self, seen: FloatArray) -> bool:
        """Return whether no painted triangle is in front of a point (3,) of the viewer's frame."""
        u, v, w = self._camera @ seen
        column, row = int(u / w), int(v / w)
        height, width = self.depth.shape
        return not (0 <= column < width and 0 <= row < height) or bool(
            seen[2] < self.depth[row, column] + 0.01
        )

    def texture(
        self, corner: FloatArray, across: FloatArray, down: FloatArray, paint: Pixels, opacity: float = 1.0
    ) -> None:
        """Paint a picture (rows, columns, 4) on a parallelogram in space, behind nearer triangles."""
        outline = self.outline(np.stack([corner, corner + across, corner + across + down, corner + down]))
        if outline is None:
            return
        rows, columns = paint.shape[:2]
        plane = np.column_stack([across / columns, down / rows, corner - self.eye])
        homography = self._camera @ self._axes @ plane
        height, width = self.pixels.shape[:2]
        warped = cv2.warpPerspective(paint, homography, (width, height), flags=cv2.INTER_LINEAR)
        mask = np.zeros((height, width), dtype=np.uint8)
        cv2.fillPoly(mask, [outline], 255, cv2.LINE_AA, 4)
        mask = cv2.multiply(mask, warped[..., 3], scale=1 / 255)
        # On a plane, the reciprocal of the distance is linear in the pixels.
        normal = self._axes @ np.cross(across, down)
        offset = normal @ (self._axes @ (corner - self.eye))
        a, b, c = (normal / offset) @ np.linalg.inv(self._camera)
        u, v = np.arange(width) + 0.5, np.arange(height)[:, None] + 0.5
        mask[(a * u + b * v + c) * self.depth < 1] = 0
        self._blend(mask, warped[..., :3], opacity)

    def triangles(self, parts: list[tuple[FloatArray, FloatArray]], opacity: float = 1.0) -> None:
        """Paint the fronts of triangles (M, 3, 3) with colours (M, 3), lit from above, with a depth buffer.

        Translucent triangles show only their nearest surface, and leave the depth buffer as it is.
        """
        corners = np.concatenate([each for each, _ in parts])
        colours = np.concatenate([each for _, each in parts])
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        seen = self.project(corners)
        front = ((normals * (self.eye - corners[:, 0])).sum(axis=1) > 0) & (seen[..., 2] > NEAR).all(axis=1)
        seen = seen[front]
        lit = np.clip(colours[front] * _light(normals[front])[:, None], 0, 255).round().astype(np.uint8)
        depth, nearest = self.depth.copy(), np.full(self.depth.shape, -1)
        for number, pixel, distance in _covered(seen, self.depth.shape):
            order = np.lexsort((distance, pixel))
            first = order[np.unique(pixel[order], return_index=True)[1]]
            nearer = first[distance[first] < depth.flat[pixel[first]]]
            depth.flat[pixel[nearer]] = distance[nearer]
            nearest.flat[pixel[nearer]] = number[nearer]
        mask = np.where(nearest >= 0, 255, 0).astype(np.uint8)
        layer = np.vstack([lit, np.zeros((1, 3), dtype=np.uint8)])[nearest]
        self._blend(mask, layer, opacity)
        if opacity == 1.0:
            self.depth = depth

    def _blend(self, mask: Pixels, layer: Any, opacity: float) -> None:
        rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
        if not len(rows):
            return
        part = np.s_[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
        share = mask[part][..., None].astype(np.float32) * np.float32(opacity / 255)
        below = self.pixels[part].astype(np.float32)
        self.pixels[part] = np.rint(below + share * (layer[part].astype(np.float32) - below))


def _covered(
    seen: FloatArray, shape: tuple[int, int]
) -> Iterator[tuple[npt.NDArray[np.intp], npt.NDArray[np.intp], FloatArray]]:
    """Yield the pixels that triangles (M, 3, 3) cover: numbers of triangles, flat indices of pixels, distances.

    The corners are given as pixels and distances. Every pixel of a triangle's bounding box is tested, in batches.
    """
    height, width = shape
    low = np.clip(np.floor(seen[..., :2].min(axis=1)), 0, (width, height)).astype(int)
    high = np.clip(np.ceil(seen[..., :2].max(axis=1)), 0, (width, height)).astype(int)
    columns, rows = (high - low).T
    tested = columns * rows
    batches = np.cumsum(tested) // _BATCH
    (a, b, c) = (seen[:, i, :2] for i in range(3))
    doubled = (b[:, 0] - a[:, 0]) * (c[:, 1] - a[:, 1]) - (b[:, 1] - a[:, 1]) * (c[:, 0] - a[:, 0])
    for batch in np.unique(batches):
        these = np.flatnonzero((batches == batch) & (tested > 0) & (np.abs(doubled) > 1e-9))
        number = np.repeat(these, tested[these])
        inside_box = np.arange(len(number)) - np.repeat(
            np.cumsum(tested[these]) - tested[these], tested[these]
        )
        v, u = np.divmod(inside_box, columns[number])
        u, v = u + low[number, 0], v + low[number, 1]
        point = np.column_stack([u, v]) + 0.5
        weights = []
        for start, end in ((b, c), (c, a), (a, b)):
            edge, towards = end[number] - start[number], point - start[number]
            weights.append((edge[:, 0] * towards[:, 1] - edge[:, 1] * towards[:, 0]) / doubled[number])
        inside = np.flatnonzero((np.stack(weights) >= 0).all(axis=0))
        share = np.stack(weights, axis=-1)[inside]
        distance = 1 / (share / seen[number[inside], :, 2]).sum(axis=1)
        yield number[inside], v[inside] * width + u[inside], distance


def _light(normals: FloatArray) -> FloatArray:
    """Return the brightness of surfaces with outward normals (M, 3): sky from above, and a lamp."""
    unit = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    sun = np.maximum(unit @ (_SUN / np.linalg.norm(_SUN)), 0.0)
    return np.asarray(0.56 + 0.16 * unit[:, 2] + 0.36 * sun)


def rgb(colour: str) -> FloatArray:
    """Return a colour such as "#ffffff" as red, green and blue (3,), 0 to 255."""
    return np.array(to_rgb(colour)) * 255
