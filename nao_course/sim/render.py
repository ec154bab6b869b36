"""Pictures of the field with the truth beside them.

Every pixel's ray is held against the exact geometry (shapes.py), over a carpet and before a room (room.py). Colours
are blended by the areas they cover in linear light, as a lens does, and only then given the camera's tone curve.
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
from nao_course.sim.room import (
    TEXEL,
    Furniture,
    Wear,
    carpet_levels,
    furnish,
    outlines_in_view,
    paint_curtains,
    scatter,
)
from nao_course.sim.shapes import Covered, Eye, Float32, middles

Labels = npt.NDArray[np.uint8]

OTHER, GREEN, YELLOW, WHITE = 0, 1, 2, 3
LABELS = ("other", "green", "yellow", "white")

# Colours as the camera shows them (0..255): typical of the real pictures of 2013, see docs/real_data.md.
_SHOWN = {
    "carpet": (99, 152, 90),
    "line": (245, 248, 247),
    "yellow": (212, 204, 54),
    "white": (245, 248, 247),
    "floor": (240, 233, 225),
    "wall": (186, 186, 184),
}
# The camera's tone curve is not published; a square root is within its plausible range and quick to apply.
_LINEAR = (np.arange(256, dtype=np.float32) / 255) ** 2
_COLOURS = {name: _LINEAR[np.array(rgb)] for name, rgb in _SHOWN.items()}
# The floor around the carpet: to which distance (m), how bright. Under the furniture it is dark.
_FLOOR = ((1.5, 1.0), (1.1, 0.75), (0.8, 0.87), (0.55, 0.95), (0.3, 1.03))
_COARSE = 8  # light changes so slowly over the picture that every 8th pixel is enough
_MEAN_LIGHTNESS = 117.0  # of 255: what the real camera's automatic exposure holds, whatever it sees
_BLUR_SMALL, _BLUR_WIDE = 0.38, 0.38  # px: sigma of the picture's scaling, and of the lens at 320 wide
_FALL_OFF = (1.3, 1.0, 0.75)  # of red, green, blue towards the corners, beside green's: measured
_TAPE = np.float32(
    12
)  # how much more lines are overexposed the steeper they are seen: 255 even in dark corners
# Noise of red, green and blue, beside their mean: measured.
_CHANNEL_NOISE: Float32 = np.array([1.05, 0.78, 1.17], dtype=np.float32)


@dataclass(frozen=True)
class Reality:
    """How real a picture looks: each effect has a strength, and zero switches it off.

    The defaults are the preset `lab`, fitted to the real pictures of 2013 (benchmarks/realism.py).

    Parameters
    ----------
    grain : float
        Carpet: standard deviation of its brightness from fibre to fibre, in levels of 255.
    mottle : float
        Carpet: the same from patch to patch, some decimetres wide.
    seams : float
        Carpet: how open the joints between its strips are, 0 to 1.
    specks : float
        Carpet: pale and dark specks a square metre.
    crumbs : float
        Carpet: clusters of crumbs a square metre.
    tape : float
        Carpet: dark patches of tape a metre along the outer lines.
    pile : float
        Carpet: how much darker and greener it is seen from above than from the side; 1 is a real one.
    glare : float
        How bright lamps and windows shine back from the ground, as a fraction of full light.
    clutter : float
        How crowded the room behind the field is; 1 is a laboratory.
    litter : float
        Things that lie on the carpet beyond the lines, a metre of the outer lines.
    gradient : float
        How much the light falls off across the field, as a fraction.
    white_balance : float
        Standard deviation of the colour channels' gains from room to room.
    exposure : float
        How far the camera corrects its exposure so that every picture is equally bright on average; 1 is fully.
    overexposure : float
        How far white lines lie beyond the brightest light the camera can show, as a fraction.
    vignette : float
        How much darker the picture's corners are than its middle, as a fraction of lightness.
    blur : float
        Of lens and sensor, in units of the real camera's.
    noise : float
        Standard deviation of the sensor's noise in levels of 255, mean over the channels.
    motion : float
        How much the camera shakes in pictures taken while walking, in units of a NAO's.
    seed : int
        Which room, carpet and lamps; not an effect.

    Raises
    ------
    ValueError
        If a strength is negative or no number.
    """

    grain: float = 8.2
    mottle: float = 3.5
    seams: float = 0.6
    specks: float = 9.0
    crumbs: float = 0.15
    tape: float = 0.7
    pile: float = 1.0
    glare: float = 0.05
    clutter: float = 1.0
    litter: float = 0.35
    gradient: float = 0.1
    white_balance: float = 0.03
    exposure: float = 1.0
    overexposure: float = 0.17
    vignette: float = 0.29
    blur: float = 1.0
    noise: float = 1.4
    motion: float = 1.0
    seed: int = 0

    def __post_init__(self) -> None:
        """Refuse what is no strength of an effect."""
        for name in self.effects():
            if finite(f"Reality: {name}", getattr(self, name)) < 0:
                raise ValueError(f"Reality: {name} must be 0 (off) or more, got {getattr(self, name)}")
        for name in ("seams", "gradient", "exposure", "vignette"):
            if getattr(self, name) > 1:
                raise ValueError(f"Reality: {name} is a fraction, at most 1; got {getattr(self, name)}")
        if finite("Reality: seed", self.seed) < 0 or int(self.seed) != self.seed:
            raise ValueError(f"Reality: seed must be a whole number from 0, got {self.seed!r}")

    @classmethod
    def effects(cls) -> tuple[str, ...]:
        """Names of all effects."""
        return tuple(each.name for each in fields(cls) if each.name != "seed")

    @classmethod
    def clean(cls, seed: int = 0) -> Reality:
        """Every effect off."""
        return cls(**dict.fromkeys(cls.effects(), 0.0), seed=seed)

    @classmethod
    def lab(cls, seed: int = 0) -> Reality:
        """A laboratory like that of the real pictures: the default."""
        return cls(seed=seed)

    @classmethod
    def dark(cls, seed: int = 0) -> Reality:
        """An evening with few lamps: uneven light and a noisy sensor."""
        return cls(
            gradient=0.6,
            exposure=0.5,
            vignette=0.45,
            noise=6.0,
            white_balance=0.08,
            overexposure=0,
            blur=1.4,
            seed=seed,
        )

    @classmethod
    def harsh(cls, seed: int = 0) -> Reality:
        """Sun through the windows of a crowded hall: glare, worn carpet, wrong colours."""
        return cls(
            glare=0.35,
            gradient=0.35,
            white_balance=0.1,
            specks=15.0,
            crumbs=1.5,
            seams=0.8,
            clutter=1.6,
            seed=seed,
        )


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
        Whether a goal post, or a thing on the carpet, is before it.
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
    turning: npt.ArrayLike = (0.0, 0.0, 0.0),
) -> tuple[npt.NDArray[np.uint8], PictureTruth]:
    """Take a picture of a field.

    Parameters
    ----------
    field : Field
        What stands there.
    pose : Pose
        The robot's pose in the world.
    view : CameraView
        The camera's true view from the robot, when the middle row is read.
    reality : Reality, optional
        How real the picture looks; by default like the laboratory's.
    rng : numpy.random.Generator, optional
        Of the sensor's noise; needed unless that is off.
    turning : array_like, shape (3,)
        How the camera turns about its own axes (ahead, left, up) from the first row to the last, in rad: rolling
        shutter, and the blur of the shutter's time.

    Returns
    -------
    pixels : ndarray of uint8, shape (H, W, 3)
        RGB.
    truth : PictureTruth
        What it shows; exact also for a turning camera.

    Raises
    ------
    ValueError
        If the picture needs random numbers and there is no generator.
    """
    reality = Reality() if reality is None else reality
    if reality.noise and rng is None:
        raise ValueError("a picture with noise needs rng, such as numpy.random.default_rng(0)")
    eye = Eye(_relative(field, pose), view, turning)
    light, labels = _paint(field, eye, reality)
    pixels = _develop(light, eye, reality, rng)
    return pixels, PictureTruth(labels, _visible(field, eye, labels), pose, view)


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
    return _visible(field, Eye(_relative(field, pose), view))


def _visible(field: Field, eye: Eye, labels: Labels | None = None) -> tuple[VisibleLandmark, ...]:
    positions = np.array([(mark.x, mark.y) for mark in field.landmarks])
    seen = eye.to_camera(np.column_stack([positions, np.zeros(len(positions))]))
    pixels = eye.pixels(seen)
    inside = eye.view.contains(pixels) & (seen[:, 0] > 1e-6)
    local = eye.seen_from.to_local(positions)
    hidden = _behind_posts(field, positions, eye.ground_position, eye.view.height)
    if labels is not None:  # only what lies on the carpet makes a landmark's own pixel "other"
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


# --- from the background forwards ---


def _paint(field: Field, eye: Eye, reality: Reality) -> tuple[Float32, Labels]:
    """Light (H, W, 3) under even lighting, and labels (H, W)."""
    picture = _carpet(field, eye, reality)
    mask, rim = eye.large_quad(_rectangle(eye, *field.carpet))
    behind = _room(field, eye, reality, mask)
    under, edge = (_LINEAR[each.reshape(-1, 4)[rim.rim, :3]] for each in (behind, picture))
    cv2.copyTo(behind, 1 - mask[: len(behind)], picture[: len(behind)])
    light = cv2.LUT(cv2.cvtColor(picture, cv2.COLOR_RGBA2RGB), _LINEAR)
    flat, labels = light.reshape(-1, 3), mask.reshape(-1)  # an inside pixel's mask is 1, the label of green
    flat[rim.rim] = under + rim.area[:, None] * (edge - under)
    labels[rim.rim[rim.area >= 0.5]] = GREEN
    lamps = _Lamps(field, eye, reality)
    lamps.light_ground(light)
    _paint_lines(field, eye, flat, labels, lamps)
    _paint_standing(field, eye, light, mask, lamps)
    return light, mask


def _room(field: Field, eye: Eye, reality: Reality, carpet: Labels) -> npt.NDArray[np.uint8]:
    """The picture's upper rows (rows, W, 4), as far down as the carpet does not cover them, without the carpet."""
    rows = 1 + int(np.flatnonzero(cv2.reduce(carpet, 1, cv2.REDUCE_MIN) == 0).max(initial=0))
    behind = _plain(rows, eye.view.size[0], "wall")
    x0, y0, x1, y1 = field.carpet
    for margin, light in _FLOOR if reality.clutter else _FLOOR[:1]:
        m = margin
        floor = eye.outlines([_rectangle(eye, x0 - m, y0 - m, x1 + m, y1 + m)])[0]
        if floor is not None:
            cv2.fillPoly(behind, [floor], [light * shade for shade in _SHOWN["floor"]], cv2.LINE_AA)
    if reality.clutter:
        paint_curtains(eye, furnish(field.carpet, reality.clutter, reality.seed), behind)
    return behind


def _paint_standing(field: Field, eye: Eye, light: Float32, labels: Labels, lamps: _Lamps) -> None:
    """Goals and what lies on the carpet, the farthest first."""
    (x0, x1), (y0, y1) = field.x_range, field.y_range
    amount, d = lamps.reality.litter, field.dimensions
    things = scatter((x0, y0, x1, y1), d.border, amount, lamps.reality.seed) if amount else None
    middles = field.bars[:, :, :2].mean(axis=1)
    distances = np.hypot(*(middles - eye.ground_position).T)
    beyond = np.inf
    for goal in np.argsort(-distances):
        if things is not None:
            _paint_litter(things, (distances[goal], beyond), eye, light, labels, lamps)
        _paint_goal(field, int(goal), eye, light, labels, lamps)
        beyond = distances[goal]
    if things is not None:
        _paint_litter(things, (0.0, beyond), eye, light, labels, lamps)


def _paint_litter(
    things: Furniture, between: tuple[float, float], eye: Eye, light: Float32, labels: Labels, lamps: _Lamps
) -> None:
    """What lies on the carpet is "other", and hides what is behind it."""
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
    """The carpet's colours (H, W, 4) wherever a ray meets the ground."""
    width, height = eye.view.size
    wear = Wear(*(getattr(reality, each.name) for each in fields(Wear)))
    picture = _plain(height, width, "carpet")
    if wear == Wear(0, 0, 0, 0, 0, 0):
        return picture
    (x0, x1), (y0, y1) = field.x_range, field.y_range
    levels = carpet_levels(field.carpet, (x0, y0, x1, y1), _SHOWN["carpet"], wear, reality.seed)
    ahead, left, up = eye.field_rays()
    with np.errstate(divide="ignore"):
        reach = np.float32(eye.view.height) / np.maximum(-up, np.float32(1e-4))
    x, y = eye.ground_position - field.carpet[:2]
    columns = (ahead * reach + np.float32(x)) / np.float32(TEXEL)
    rows = (left * reach + np.float32(y)) / np.float32(TEXEL)
    # A pixel covers reach / focal metres across, and more along; but pile stands up, so that its grain shows from
    # the side too: the copy is chosen hardly coarser than a pixel is across.
    middle = np.minimum(reach[:, width // 2], 30.0)
    footprint = middle / eye.view.focal[0] * np.maximum(middle / eye.view.height, 1.0) ** 0.33 / TEXEL
    level = np.clip(np.round(np.log2(np.maximum(footprint, 1.0))), 0, len(levels) - 1).astype(int)
    edges = np.flatnonzero(np.diff(level)) + 1
    for first, last in zip([0, *edges], [*edges, height], strict=True):
        if middle[first:last].min() > 20:
            continue
        k = level[first]
        scale = np.float32(0.5**k)
        x, y = ((m[first:last] + np.float32(0.5)) * scale - np.float32(0.5) for m in (columns, rows))
        picture[first:last] = cv2.remap(levels[k], x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return picture


def _plain(rows: int, columns: int, name: str) -> npt.NDArray[np.uint8]:
    """A picture (rows, columns, 4) of one colour; filled by whole pixels, which is ten times quicker than by bytes."""
    colour = np.array([*_SHOWN[name], 255], dtype=np.uint8).view(np.uint32)[0]
    return np.full((rows, columns), colour).view(np.uint8).reshape(rows, columns, 4)


def _paint_lines(field: Field, eye: Eye, light: Float32, labels: Labels, lamps: _Lamps) -> None:
    bare = np.ones(len(labels), dtype=np.float32)
    for shape in _line_shapes(field, eye):
        shape.add_to(bare)
    touched = np.flatnonzero(bare < 1)
    area = 1 - bare[touched]
    paint = _COLOURS["line"] * lamps.at(touched) * lamps.overexposed(touched)
    light[touched] += area[:, None] * (paint - light[touched])
    labels[touched[area >= 0.5]] = WHITE


def _paint_goal(field: Field, goal: int, eye: Eye, light: Float32, labels: Labels, lamps: _Lamps) -> None:
    colour = field.dimensions.goal_colour
    flat, flat_labels = light.reshape(-1, 3), labels.reshape(-1)
    bare = np.ones(len(flat_labels), dtype=np.float32)
    for shape, facing_inside, facing_rim in _goal_shapes(field, goal, eye):
        for pixels, facing in ((shape.inside, facing_inside), (shape.rim, facing_rim)):
            paint = _COLOURS[colour] * lamps.at(pixels) * (0.8 + 0.2 * facing[:, None])
            area = np.float32(1) if pixels is shape.inside else shape.area[:, None]
            flat[pixels] += area * (paint - flat[pixels])
        shape.add_to(bare)
    flat_labels[bare <= 0.5] = YELLOW if colour == "yellow" else WHITE


# --- light, lens and sensor ---


class _Lamps:
    """How bright each part of the picture is, on a coarse grid: uneven light, colour cast, darker corners."""

    def __init__(self, field: Field, eye: Eye, reality: Reality) -> None:
        self.reality, self.width = reality, eye.view.size[0]
        rng = np.random.default_rng([reality.seed, 3])
        towards, cast = rng.uniform(-np.pi, np.pi), rng.normal(0, 1, 3)
        self._lamps = rng.uniform((-np.pi, 0.12, 0.25, 0.4), (np.pi, 0.40, 0.60, 1.0), (6, 4))
        rays = eye.field_rays(_COARSE)
        rays /= np.sqrt((rays**2).sum(axis=0))
        down = np.maximum(-rays[2], np.float32(0.02))
        gain = np.ones((*rays.shape[1:], 3), dtype=np.float32)
        if reality.gradient:
            where = eye.ground_position[:, None, None] + rays[:2] * (eye.view.height / down)
            across = where[0] * np.cos(towards) + where[1] * np.sin(towards)
            gain *= 1 + np.float32(reality.gradient) * np.tanh(across / 3).astype(np.float32)[..., None]
        if reality.vignette:  # quadratic in lightness, so squared in light
            side = (eye.view.size[1], eye.view.size[0])
            some = np.ix_(*(middles(n, _COARSE) for n in side))
            right, below = (a.reshape(side)[some] for a in (eye.grid.right, eye.grid.down))
            corner = np.tan(eye.view.hfov / 2) ** 2 + np.tan(eye.view.vfov / 2) ** 2
            fall = reality.vignette * ((right**2 + below**2) / corner)[..., None] * _FALL_OFF
            gain *= np.maximum(1 - fall, 0).astype(np.float32) ** 2
        if reality.white_balance:
            gain *= (1 + reality.white_balance * (cast - cast.mean())).astype(np.float32)
        self._gain, self._rays = gain, rays
        self._steep = np.maximum(down - np.float32(0.16), 0)[..., None]  # beyond 3 m nothing changes any more

    @property
    def even(self) -> bool:
        """Whether the light is the same everywhere."""
        r = self.reality
        return not (r.gradient or r.vignette or r.white_balance)

    def at(self, pixels: npt.NDArray[np.intp]) -> Float32:
        """Gains (N, 3) at flat pixels (N,)."""
        rows, columns = np.divmod(pixels, self.width)
        return self._gain[rows // _COARSE, columns // _COARSE]

    def overexposed(self, pixels: npt.NDArray[np.intp]) -> Float32:
        """How far (N, 1) lines at flat pixels (N,) are overexposed: least seen from the side, between the pile."""
        rows, columns = np.divmod(pixels, self.width)
        steep = self._steep[rows // _COARSE, columns // _COARSE]
        return 1 + np.float32(self.reality.overexposure) * (1 + _TAPE * steep)

    def light_ground(self, light: Float32) -> None:
        """Light a picture (H, W, 3) of ground and room: gains, the pile of the carpet, and what shines back."""
        r, size = self.reality, light.shape[1::-1]
        gain = self._gain
        if r.pile:  # from above one looks between the fibres: red and blue lose most
            gain = gain * np.maximum(1 - r.pile * self._steep * (1.25, 0.41, 0.9), 0.05).astype(np.float32)
        if r.pile or not self.even:
            cv2.multiply(light, _enlarged(gain, size), dst=light)
        if r.glare:
            azimuth = np.arctan2(self._rays[1], self._rays[0])
            dip = np.arcsin(np.clip(-self._rays[2], 0, 1))
            shine = np.zeros_like(dip)
            for where, low, wide, strength in self._lamps:
                off = (azimuth - where + np.pi) % (2 * np.pi) - np.pi
                shine += np.float32(strength) * np.exp(
                    -((off / wide) ** 2) - ((dip - low) / 0.2) ** 2
                ).astype(np.float32)
            shine *= np.clip(dip / 0.06, 0, 1) * np.float32(r.glare)  # only the ground shines
            cv2.add(light, _enlarged(np.repeat(shine[..., None], 3, axis=2), size), dst=light)


def _enlarged(coarse: Float32, size: tuple[int, ...]) -> Float32:
    """A coarse grid (h, w, 3), whose points are the middles of 8 by 8 pixels, at a picture's full (width, height)."""
    whole = (coarse.shape[1] * _COARSE, coarse.shape[0] * _COARSE)
    return cv2.resize(coarse, whole, interpolation=cv2.INTER_LINEAR)[: size[1], : size[0]]


def _develop(
    light: Float32, eye: Eye, reality: Reality, rng: np.random.Generator | None
) -> npt.NDArray[np.uint8]:
    """Blur, exposure, tone curve, noise and clipping, in the camera's order: from light (H, W, 3) to a picture."""
    gain = _exposure(light, reality, rng) if reality.exposure else 1.0
    if eye.turning.any():
        light = _smear(light, eye)
    if reality.blur:
        sigma = reality.blur * np.hypot(_BLUR_SMALL, _BLUR_WIDE * eye.view.size[0] / 320)
        light = cv2.GaussianBlur(light, (0, 0), float(sigma))
    shown = cv2.sqrt(light)
    if reality.noise and rng is not None:
        return _with_noise(shown, 255 * gain, reality.noise, rng)
    return cv2.convertScaleAbs(shown, alpha=255 * gain)


def _exposure(light: Float32, reality: Reality, rng: np.random.Generator | None) -> float:
    """Gain of the shown values that brings their mean lightness to what the camera's automatic exposure holds."""
    some = np.sqrt(light[_COARSE // 2 :: _COARSE, _COARSE // 2 :: _COARSE].reshape(-1, 3))
    if not len(some):
        return 1.0
    brightest, darkest = some.max(axis=1), some.min(axis=1)
    wanted = _MEAN_LIGHTNESS + (rng.normal(0, 4) if rng is not None else 0.0)
    low, high = 0.4, 1.8
    for _ in range(14):
        gain = (low + high) / 2
        mean = 127.5 * (np.minimum(gain * brightest, 1) + np.minimum(gain * darkest, 1)).mean()
        low, high = (gain, high) if mean < wanted else (low, gain)
    return float(gain**reality.exposure)


def _smear(light: Float32, eye: Eye) -> Float32:
    """Blur along the way the picture moves while a row is exposed, a quarter of the time it takes to read all."""
    _, about_left, about_up = eye.turning / 4
    way = np.array([about_up * eye.view.focal[0], -about_left * eye.view.focal[1]])
    reach = int(np.ceil(np.abs(way).max() / 2))
    if reach < 1:
        return light
    kernel = np.zeros((2 * reach + 1, 2 * reach + 1), dtype=np.float32)
    for u, v in np.linspace(-0.5, 0.5, 16 * reach + 1)[:, None] * way + reach:
        kernel[round(v), round(u)] += 1
    return cv2.filter2D(light, -1, kernel / kernel.sum(), borderType=cv2.BORDER_REPLICATE)


@lru_cache(maxsize=1)
def _noise_tile() -> Float32:
    """A tile (512, 512, 3) of noise with unit deviation, mean over the channels."""
    return np.random.default_rng(33).standard_normal((512, 512, 3), dtype=np.float32) * _CHANNEL_NOISE


def _with_noise(shown: Float32, gain: float, sigma: float, rng: np.random.Generator) -> npt.NDArray[np.uint8]:
    """Add noise from random places of the tile: drawing every number anew would take as long as all the rest."""
    tile, picture = _noise_tile(), np.empty(shown.shape, dtype=np.uint8)
    for row in range(0, shown.shape[0], 256):
        for column in range(0, shown.shape[1], 256):
            block = shown[row : row + 256, column : column + 256]
            i, j = rng.integers(0, 257, 2)
            noise = tile[i : i + block.shape[0], j : j + block.shape[1]]
            picture[row : row + 256, column : column + 256] = cv2.addWeighted(
                block, gain, noise, sigma, 0, dtype=cv2.CV_8U
            )
    return picture


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
        halfway = np.cross(south, north)  # the plane through the camera and the halfway line
        part = halfway * np.sign(halfway @ beyond) if last - first < 2 * np.pi else None
        yield eye.ring(centre, above - centre, (radius - half, radius + half), part)


def _goal_shapes(field: Field, goal: int, eye: Eye) -> Iterator[tuple[Covered, Float32, Float32]]:
    """A goal's bar and posts, the farthest first."""
    d = field.dimensions
    bar = field.bars[goal]
    top = d.post_height + d.bar_diameter / 2  # flush with the bar's upper side
    solids = [(*eye.to_camera(bar), d.bar_diameter / 2)]
    for x, y, _ in bar:
        solids.append((*eye.to_camera([(x, y, 0.0), (x, y, top)]), d.post_diameter / 2))
    solids.sort(key=lambda solid: -float(np.linalg.norm(solid[0] + solid[1])))
    for start, end, radius in solids:
        yield eye.cylinder(start, end, radius)
