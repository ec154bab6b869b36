"""Pictures of the field with the truth beside them.

Every pixel's ray is held against the exact geometry (shapes.py). Colours are blended by the areas they cover in
linear light, as a lens does, and only then given the camera's tone curve.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, Pose, finite
from nao_course.sim.camera import CameraView
from nao_course.sim.field import Field, Landmark
from nao_course.sim.shapes import Covered, Eye, Float32

OTHER, GREEN, YELLOW, WHITE = 0, 1, 2, 3
LABELS = ("other", "green", "yellow", "white")

# Colours as the camera shows them (0..255): typical of the real pictures of 2013, see docs/real_data.md.
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
    canvas = _Canvas(field, Eye(seen_from, view))
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


class _Canvas:
    """Light (H * W, 3) and labels (H * W,) of a field seen from somewhere, painted from the background forwards."""

    def __init__(self, field: Field, eye: Eye) -> None:
        x0, y0, x1, y1 = field.carpet
        m = _ROOM_MARGIN
        floor = eye.quad_map(_rectangle(eye, x0 - m, y0 - m, x1 + m, y1 + m))[:, None]
        carpet = eye.quad_map(_rectangle(eye, x0, y0, x1, y1))
        self.light = _COLOURS["wall"] + floor * (_COLOURS["floor"] - _COLOURS["wall"])
        self.light += carpet[:, None] * (_COLOURS["carpet"] - self.light)
        self.labels = np.where(carpet >= 0.5, GREEN, OTHER).astype(np.uint8)
        self._paint_lines(field, eye)
        self._paint_goals(field, eye)

    def _paint_lines(self, field: Field, eye: Eye) -> None:
        bare = np.ones(len(self.labels), dtype=np.float32)
        for shape in _line_shapes(field, eye):
            shape.add_to(bare)
        touched = np.flatnonzero(bare < 1)
        area = 1 - bare[touched]
        self.light[touched] += area[:, None] * (_COLOURS["line"] - self.light[touched])
        self.labels[touched[area >= 0.5]] = WHITE

    def _paint_goals(self, field: Field, eye: Eye) -> None:
        colour = field.dimensions.goal_colour
        bare = np.ones(len(self.labels), dtype=np.float32)
        for shape, facing_inside, facing_rim in _goal_shapes(field, eye):
            for pixels, facing in ((shape.inside, facing_inside), (shape.rim, facing_rim)):
                paint = _COLOURS[colour] * (0.55 + 0.45 * facing[:, None])
                area = np.float32(1) if pixels is shape.inside else shape.area[:, None]
                self.light[pixels] += area * (paint - self.light[pixels])
            shape.add_to(bare)
        self.labels[bare <= 0.5] = YELLOW if colour == "yellow" else WHITE


# --- the field's shapes ---


def _rectangle(eye: Eye, x0: float, y0: float, x1: float, y1: float) -> FloatArray:
    """Corners (4, 3) of a rectangle on the ground, in the camera's axes."""
    return eye.to_camera([(x0, y0, 0.0), (x1, y0, 0.0), (x1, y1, 0.0), (x0, y1, 0.0)])


def _line_shapes(field: Field, eye: Eye) -> Iterator[Covered]:
    """Every line, mark and circle."""
    half = field.dimensions.line_width / 2
    x0, y0, x1, y1 = field.lines.T
    boxes = [(x0 - half, y0 - half, x1 + half, y1 + half)]  # ends run to the crossing line's far edge
    x0, y0, x1, y1 = field.mark_lines.T
    dx, dy = np.where(y0 == y1, 0.0, half), np.where(y0 == y1, half, 0.0)
    boxes.append((x0 - dx, y0 - dy, x1 + dx, y1 + dy))
    x0, y0, x1, y1 = np.concatenate(boxes, axis=1)
    ground = np.zeros_like(x0)
    corners = np.stack([(x0, y0, ground), (x1, y0, ground), (x1, y1, ground), (x0, y1, ground)])
    yield from eye.quads(eye.to_camera(corners.transpose(2, 0, 1)))
    for x, y, radius, first, last in field.arcs:
        centre, above, beyond, south, north = eye.to_camera(
            [(x, y, 0.0), (x, y, 1.0), (x + 1.0, y, 0.0), (x, y - 1.0, 0.0), (x, y + 1.0, 0.0)]
        )
        plane = np.cross(south, north)  # through the camera and the halfway line
        plane = plane * np.sign(plane @ beyond) if last - first < 2 * np.pi else None
        yield eye.ring(centre, above - centre, (radius - half, radius + half), plane)


def _goal_shapes(field: Field, eye: Eye) -> Iterator[tuple[Covered, Float32, Float32]]:
    """Every bar and post, the farthest first."""
    d = field.dimensions
    solids = [(*eye.to_camera(ends), d.bar_diameter / 2) for ends in field.bars]
    for x, y in field.posts:
        solids.append((*eye.to_camera([(x, y, 0.0), (x, y, d.post_height)]), d.post_diameter / 2))
    solids.sort(key=lambda solid: -float(np.linalg.norm(solid[0] + solid[1])))
    for start, end, radius in solids:
        yield eye.cylinder(start, end, radius)
