"""Rendering of pictures of the field, with their ground truth.

The geometry of lines and goals is exact for the ray of each pixel (shapes.py). The carpet and the room behind it are
textures (carpet.py, room.py). Colours are blended in linear light, in proportion to the areas that they cover, as in a
real lens; the tone curve of the camera is applied afterwards (light.py).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields

import cv2
import numpy as np
import numpy.typing as npt

from nao_course.codec import register
from nao_course.geometry import FloatArray, Pose, finite
from nao_course.sim.camera import CameraView
from nao_course.sim.carpet import TEXEL, Wear, carpet_levels
from nao_course.sim.field import Field, Landmark
from nao_course.sim.furniture import Furniture, outlines_in_view, scatter, strew
from nao_course.sim.light import Lamps, develop
from nao_course.sim.reality import Reality
from nao_course.sim.room import furnish, paint_curtains
from nao_course.sim.shapes import Covered, Eye, Float32, cross

Labels = npt.NDArray[np.uint8]

OTHER, GREEN, YELLOW, WHITE = 0, 1, 2, 3
LABELS = ("other", "green", "yellow", "white")

# Typical colours (0..255) in the real pictures of 2013.
SHOWN = {
    "carpet": (99, 152, 90),
    "line": (245, 248, 247),
    "yellow": (212, 204, 54),
    "white": (245, 248, 247),
    "floor": (240, 233, 225),
    "wall": (186, 186, 184),
}
# The tone curve of the camera is not published. A square root is plausible, and fast to compute.
_LINEAR = (np.arange(256, dtype=np.float32) / 255) ** 2
COLOURS = {name: _LINEAR[np.array(rgb)] for name, rgb in SHOWN.items()}
# Margin (m) around the carpet and brightness of the floor up to there. It is dark below the furniture.
_FLOOR = ((1.5, 1.0), (1.1, 0.75), (0.8, 0.87), (0.55, 0.95), (0.3, 1.03))


@register
@dataclass(frozen=True)
class VisibleLandmark:
    """A landmark in a picture.

    Parameters
    ----------
    landmark : Landmark
        Landmark, in the field frame.
    pixel : (float, float)
        Position (u, v) in the picture, px.
    distance : float
        True distance from the robot on the ground, m.
    bearing : float
        True bearing in the robot frame, rad; positive to the left.
    occluded : bool
        Whether the landmark is hidden by a goal post or by a thing on the carpet.
    """

    landmark: Landmark
    pixel: tuple[float, float]
    distance: float
    bearing: float
    occluded: bool

    def __post_init__(self) -> None:
        """Check the values."""
        if not isinstance(self.landmark, Landmark):
            raise ValueError(f"VisibleLandmark: landmark must be a Landmark, got {self.landmark!r}")
        object.__setattr__(self, "occluded", bool(self.occluded))
        for name in ("distance", "bearing"):
            finite(f"VisibleLandmark: {name}", getattr(self, name))
        u, v = self.pixel
        object.__setattr__(self, "pixel", (finite("pixel u", u), finite("pixel v", v)))


@dataclass(frozen=True, eq=False)
class PictureTruth:
    """The ground truth of a picture.

    Parameters
    ----------
    labels : ndarray of uint8, shape (H, W)
        Class that covers at least half of each pixel: 0 other, 1 green, 2 yellow, 3 white.
    landmarks : tuple of VisibleLandmark
        Landmarks inside the picture, including occluded landmarks.
    pose : Pose
        True pose of the robot in the world frame.
    view : CameraView
        True view of the camera, with the body tilt.
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
    turning: npt.ArrayLike = (0.0, 0.0, 0.0),
) -> tuple[npt.NDArray[np.uint8], PictureTruth]:
    """Render a picture of a field.

    Parameters
    ----------
    field : Field
        Field to render.
    pose : Pose
        True pose of the robot in the world frame.
    view : CameraView
        True view of the camera in the robot frame while the middle row is read out.
    reality : Reality, optional
        Appearance of the picture; by default the preset `lab`.
    rng : numpy.random.Generator, optional
        Source of the sensor noise; required unless the noise is off.
    turning : array_like, shape (3,)
        Rotation of the camera about its own axes (ahead, left, up) from the first row to the last, rad. It causes the
        distortion of a rolling shutter, and motion blur.

    Returns
    -------
    pixels : ndarray of uint8, shape (H, W, 3)
        RGB picture.
    truth : PictureTruth
        Ground truth, which is exact also for a rotating camera.

    Raises
    ------
    ValueError
        If the noise is on and `rng` is missing.
    """
    reality = Reality() if reality is None else reality
    if reality.noise and rng is None:
        raise ValueError("a picture with noise needs rng, such as numpy.random.default_rng(0)")
    eye = Eye(_relative(field, pose), view, turning)
    light, labels = _paint(field, eye, reality)
    pixels = develop(light, eye, reality, rng)
    return pixels, PictureTruth(labels, _visible(field, eye, labels), pose, view)


def visible_landmarks(field: Field, pose: Pose, view: CameraView) -> tuple[VisibleLandmark, ...]:
    """Return the landmarks of the field that are inside a picture.

    Parameters
    ----------
    field : Field
        Field with the landmarks.
    pose : Pose
        True pose of the robot in the world frame.
    view : CameraView
        True view of the camera in the robot frame.

    Returns
    -------
    tuple of VisibleLandmark
        Landmarks in the order of ``field.landmarks``.
    """
    return _visible(field, Eye(_relative(field, pose), view))


def _visible(field: Field, eye: Eye, labels: Labels | None = None) -> tuple[VisibleLandmark, ...]:
    positions = np.array([(mark.x, mark.y) for mark in field.landmarks])
    seen = eye.to_camera(np.column_stack([positions, np.zeros(len(positions))]))
    pixels = eye.pixels(seen)
    inside = eye.view.contains(pixels) & (seen[:, 0] > 1e-6)
    local = eye.seen_from.to_local(positions)
    hidden = _behind_posts(field, positions, eye.ground_position, eye.view.height)
    if labels is not None:  # because a landmark's own pixel has the label "other" only if a thing hides it
        columns, rows = np.clip(np.rint(pixels), 0, np.array(eye.view.size) - 1).astype(int).T
        hidden |= labels[rows, columns] == OTHER
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
    """Return the pose in the field frame, rounded to nanometres so that a moved world gives identical pictures."""
    relative = (field.pose.inverse() @ pose).as_array()
    return Pose.from_array(np.round(relative, 9))


def _behind_posts(field: Field, points: FloatArray, eye: FloatArray, height: float) -> npt.NDArray[np.bool_]:
    """Return for each point on the ground whether a post hides it from the camera."""
    hidden = np.zeros(len(points), dtype=bool)
    radius, top = field.dimensions.post_diameter / 2, field.dimensions.post_height
    ray = points - eye
    for post in field.posts:
        along = ((post - eye) * ray).sum(axis=1) / np.maximum((ray**2).sum(axis=1), 1e-12)
        beside = np.hypot(*(eye + along[:, None] * ray - post).T)
        own = np.hypot(*(points - post).T) <= radius
        below_top = height * (1 - along) <= top
        hidden |= (along > 0) & (along < 1) & (beside < radius) & below_top & ~own
    return hidden


# --- painting, from the background to the front ---


def _paint(field: Field, eye: Eye, reality: Reality) -> tuple[Float32, Labels]:
    """Return the linear light (H, W, 3) and the labels (H, W)."""
    picture = _carpet(field, eye, reality)
    mask, rim = eye.large_quad(_rectangle(eye, *field.carpet))
    behind = _room(field, eye, reality, mask)
    under, edge = (_LINEAR[each.reshape(-1, 4)[rim.rim, :3]] for each in (behind, picture))
    cv2.copyTo(behind, 1 - mask[: len(behind)], picture[: len(behind)])
    light = cv2.LUT(cv2.cvtColor(picture, cv2.COLOR_RGBA2RGB), _LINEAR)
    flat, labels = light.reshape(-1, 3), mask.reshape(-1)  # the mask inside is 1, which is the label of green
    flat[rim.rim] = under + rim.area[:, None] * (edge - under)
    labels[rim.rim[rim.area >= 0.5]] = GREEN
    lamps = Lamps(field, eye, reality)
    lamps.light_ground(light)
    _paint_lines(field, eye, flat, labels, lamps)
    _paint_standing(field, eye, light, mask, lamps)
    return light, mask


def _room(field: Field, eye: Eye, reality: Reality, carpet: Labels) -> npt.NDArray[np.uint8]:
    """Paint the room into the upper rows (rows, W, 4) of a picture, as far down as the carpet leaves pixels free."""
    rows = 1 + int(np.flatnonzero(carpet.min(axis=1) == 0).max(initial=0))
    behind = _plain(rows, eye.view.size[0], "wall")
    x0, y0, x1, y1 = field.carpet
    shades = _FLOOR if reality.clutter else _FLOOR[:1]
    floors = eye.outlines(_rectangle(eye, x0 - m, y0 - m, x1 + m, y1 + m) for m, _ in shades)
    for floor, (_, light) in zip(floors, shades, strict=True):
        if floor is not None:
            cv2.fillPoly(behind, [floor], [light * shade for shade in SHOWN["floor"]], cv2.LINE_AA)
    if reality.clutter:
        paint_curtains(eye, furnish(field.carpet, reality.clutter, reality.seed), behind)
    return behind


def _paint_standing(field: Field, eye: Eye, light: Float32, labels: Labels, lamps: Lamps) -> None:
    """Paint the goals and the things on the carpet, the farthest first."""
    (x0, x1), (y0, y1) = field.x_range, field.y_range
    amount, d = lamps.reality.litter, field.dimensions
    things = scatter((x0, y0, x1, y1), d.border, amount, lamps.reality.seed) if amount else None
    centres = field.bars[:, :, :2].mean(axis=1)
    distances = np.hypot(*(centres - eye.ground_position).T)
    beyond = np.inf
    if sheets := lamps.reality.sheets:  # flat, so everything else is in front of them
        paper = strew(field.carpet, sheets, lamps.reality.seed)
        _paint_litter(paper, (0.0, np.inf), eye, light, labels, lamps)
    for goal in np.argsort(-distances):
        if things is not None:
            _paint_litter(things, (distances[goal], beyond), eye, light, labels, lamps)
        _paint_goal(field, int(goal), eye, light, labels, lamps)
        beyond = distances[goal]
    if things is not None:
        _paint_litter(things, (0.0, beyond), eye, light, labels, lamps)


def _paint_litter(
    things: Furniture, between: tuple[float, float], eye: Eye, light: Float32, labels: Labels, lamps: Lamps
) -> None:
    """Paint the things on the carpet within a range of distances, with the label "other"."""
    outlines = outlines_in_view(eye, things, between)
    if not outlines:
        return
    corners = np.concatenate([outline for outline, _ in outlines]) // 16
    x0, y0 = np.clip(corners.min(axis=0) - 1, 0, eye.view.size)
    x1, y1 = np.clip(corners.max(axis=0) + 2, 0, eye.view.size)
    if x0 >= x1 or y0 >= y1:
        return
    picture, covered = np.zeros((y1 - y0, x1 - x0, 3), dtype=np.uint8), np.zeros((y1 - y0, x1 - x0), np.uint8)
    for outline, colour in outlines:
        here = [outline - np.array([16 * x0, 16 * y0], dtype=np.int32)]
        cv2.fillPoly(picture, here, colour.tolist(), cv2.LINE_AA, 4)
        cv2.fillPoly(covered, here, 255, cv2.LINE_AA, 4)
    rows, columns = np.nonzero(covered)
    pixels = (rows + y0) * eye.view.size[0] + columns + x0
    area = covered[rows, columns, None].astype(np.float32) / 255
    # The picture was black before, so its colours are already weighted by the area they cover.
    shown = np.minimum(picture[rows, columns] / np.maximum(area, 0.05), 255)
    paint = (shown / 255) ** 2 * lamps.at(pixels)
    flat = light.reshape(-1, 3)
    flat[pixels] += area * (paint - flat[pixels])
    labels.reshape(-1)[pixels[area[:, 0] >= 0.5]] = OTHER


def _carpet(field: Field, eye: Eye, reality: Reality) -> npt.NDArray[np.uint8]:
    """Return the colours (H, W, 4) of an endless carpet."""
    width, height = eye.view.size
    wear = Wear(*(getattr(reality, each.name) for each in fields(Wear)))
    picture = _plain(height, width, "carpet")
    if wear == Wear(0, 0, 0, 0, 0, 0):
        return picture
    (x0, x1), (y0, y1) = field.x_range, field.y_range
    levels = carpet_levels(field.carpet, (x0, y0, x1, y1), SHOWN["carpet"], wear, reality.seed)
    ahead, left, up = eye.field_rays()
    with np.errstate(divide="ignore"):
        reach = np.float32(eye.view.height) / np.maximum(-up, np.float32(1e-4))
    x, y = eye.ground_position - field.carpet[:2]
    columns, rows = ahead, left
    for each, origin in ((columns, x), (rows, y)):
        each *= reach
        each += np.float32(origin)
        each /= np.float32(TEXEL)
        each += np.float32(0.5)
    # A pixel covers reach / focal metres across, and more along. But the fibres stand upright, so their grain is also
    # visible from the side. The resolution of the texture is therefore hardly coarser than the width of a pixel.
    middle = np.minimum(reach[:, width // 2], 30.0)
    footprint = middle / eye.view.focal[0] * np.maximum(middle / eye.view.height, 1.0) ** 0.33 / TEXEL
    level = np.clip(np.round(np.log2(np.maximum(footprint, 1.0))), 0, len(levels) - 1).astype(int)
    edges = np.flatnonzero(np.diff(level)) + 1
    for first, last in zip([0, *edges], [*edges, height], strict=True):
        if middle[first:last].min() > 20:
            continue
        k = level[first]
        scale = np.float32(0.5**k)
        x, y = (each[first:last] * scale - np.float32(0.5) for each in (columns, rows))
        picture[first:last] = cv2.remap(levels[k], x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return picture


def _plain(rows: int, columns: int, name: str) -> npt.NDArray[np.uint8]:
    """Return a picture (rows, columns, 4) of one colour; whole pixels are filled ten times faster than bytes."""
    colour = np.array([*SHOWN[name], 255], dtype=np.uint8).view(np.uint32)[0]
    return np.full((rows, columns), colour).view(np.uint8).reshape(rows, columns, 4)


def _paint_lines(field: Field, eye: Eye, light: Float32, labels: Labels, lamps: Lamps) -> None:
    bare = np.ones(len(labels), dtype=np.float32)
    for shape in _line_shapes(field, eye):
        shape.add_to(bare)
    touched = np.flatnonzero(bare < 1)
    area = 1 - bare[touched]
    paint = COLOURS["line"] * lamps.at(touched) * lamps.overexposed(touched)
    light[touched] += area[:, None] * (paint - light[touched])
    labels[touched[area >= 0.5]] = WHITE


def _paint_goal(field: Field, goal: int, eye: Eye, light: Float32, labels: Labels, lamps: Lamps) -> None:
    if not eye.reached(_goal_box(field, goal, eye), np.zeros(1, dtype=np.intp))[0].item():
        return
    colour = field.dimensions.goal_colour
    flat, flat_labels = light.reshape(-1, 3), labels.reshape(-1)
    bare = np.ones(len(flat_labels), dtype=np.float32)
    for shape, facing_inside, facing_rim in _goal_shapes(field, goal, eye):
        for pixels, facing in ((shape.inside, facing_inside), (shape.rim, facing_rim)):
            paint = COLOURS[colour] * lamps.at(pixels) * (0.8 + 0.2 * facing[:, None])
            area = np.float32(1) if pixels is shape.inside else shape.area[:, None]
            flat[pixels] += area * (paint - flat[pixels])
        shape.add_to(bare)
    flat_labels[bare <= 0.5] = YELLOW if colour == "yellow" else WHITE


# --- shapes of the field ---


def _rectangle(eye: Eye, x0: float, y0: float, x1: float, y1: float) -> FloatArray:
    """Return the corners (4, 3) of a rectangle on the ground, in the camera frame."""
    return eye.to_camera([(x0, y0, 0.0), (x1, y0, 0.0), (x1, y1, 0.0), (x0, y1, 0.0)])


def _line_shapes(field: Field, eye: Eye) -> Iterator[Covered]:
    """Yield the shapes of all lines, marks and circles."""
    half = field.dimensions.line_width / 2
    x0, y0, x1, y1 = field.lines.T
    # The ends of a line reach to the far edge of the line that it meets.
    boxes = [(x0 - half, y0 - half, x1 + half, y1 + half)]
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
        halfway = cross(south, north)  # the plane through the camera and the halfway line
        part = halfway * np.sign(halfway @ beyond) if last - first < 2 * np.pi else None
        yield eye.ring(centre, above - centre, (radius - half, radius + half), part)


def _goal_box(field: Field, goal: int, eye: Eye) -> FloatArray:
    """Return the corners (8, 3), in the camera frame, of an upright box around a goal."""
    d, bar = field.dimensions, field.bars[goal]
    around = max(d.post_diameter, d.bar_diameter)
    low, high = bar.min(axis=0) - around, bar.max(axis=0) + around
    return eye.to_camera(
        [(x, y, z) for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (0.0, high[2])]
    )


def _goal_shapes(field: Field, goal: int, eye: Eye) -> Iterator[tuple[Covered, Float32, Float32]]:
    """Yield the crossbar and the posts of a goal, the farthest first."""
    d = field.dimensions
    bar = field.bars[goal]
    top = d.post_height + d.bar_diameter / 2  # the posts end at the top of the bar
    solids = [(*eye.to_camera(bar), d.bar_diameter / 2)]
    for x, y, _ in bar:
        solids.append((*eye.to_camera([(x, y, 0.0), (x, y, top)]), d.post_diameter / 2))
    solids.sort(key=lambda solid: -float(np.linalg.norm(solid[0] + solid[1])))
    for start, end, radius in solids:
        yield eye.cylinder(start, end, radius)
