"""Lesson 04, distance: its exercises, what students get wrong in them, and other right ways to write them."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares, minimize_scalar

from nao_course.exercises import Case, Close, Exercise, LessonPlan, Mistake, Question, Written
from nao_course.geometry import rotation_3d
from nao_course.sim import NAO_V4, CameraView

Array = npt.NDArray[Any]
ROUND = 2 * np.pi


# --- cameras and pixels to try things on ---


def view_of(degrees: float, **values: Any) -> CameraView:
    """A NAO's lower camera whose axis is so many degrees below the horizon, without a lens term."""
    given = {"size": (320, 240), "hfov": 1.04, "vfov": 0.82, "height": 0.48} | values
    return CameraView(pitch=float(np.radians(degrees)), **given)


def any_view(rng: np.random.Generator, size: tuple[int, int] = (320, 240)) -> CameraView:
    """A view with everything that a camera can have."""
    return CameraView(
        size,
        hfov=rng.uniform(0.9, 1.1),
        vfov=rng.uniform(0.7, 0.85),
        height=rng.uniform(0.4, 0.6),
        pitch=rng.uniform(0.35, 0.7),
        yaw=rng.uniform(0.3, 0.9) * rng.choice([-1, 1]),
        roll=rng.uniform(0.03, 0.12) * rng.choice([-1, 1]),
        offset=(rng.uniform(0.03, 0.08), rng.uniform(0.01, 0.03) * rng.choice([-1, 1])),
        k1=rng.uniform(-0.09, -0.05),
    )


def pixels_in(rng: np.random.Generator, view: CameraView, number: int, top: float = 0.0) -> Array:
    """Pixels anywhere in a picture, but for the upper part `top` of it."""
    width, height = view.size
    return np.column_stack([rng.uniform(0, width - 1, number), rng.uniform(top * height, height - 1, number)])


def ground_in_view(rng: np.random.Generator, view: CameraView, number: int) -> Array:
    """Points (number, 2) of the ground in the robot frame, 0.8 to 5 m away, that fall into the picture."""
    found = np.zeros((0, 2))
    while len(found) < number:
        bearing, away = view.yaw + rng.uniform(-0.5, 0.5, 400), rng.uniform(0.8, 5.0, 400)
        points = away[:, None] * np.column_stack([np.cos(bearing), np.sin(bearing)])
        found = np.vstack([found, points[view.contains(view.project(points))]])
    return found[:number]


# --- 4.1 ground_to_measurement ---


def _measured(points: Any) -> Array:
    points = np.asarray(points, dtype=float)
    return np.array([[np.arctan2(y, x), np.sqrt(x * x + y * y)] for x, y in points]).reshape(-1, 2)


def _columns(bearing: Any, away: Any) -> Any:
    """The exercise as a function, from what is done for each column."""
    return lambda points: np.column_stack([bearing(*points.T), away(*points.T)])


def _quotient(x: Array, y: Array) -> Array:
    with np.errstate(all="ignore"):
        return np.arctan(y / x)


def _signed_arccos(x: Array, y: Array) -> Array:
    return np.sign(y) * np.arccos(x / np.hypot(x, y))


def _complex(points: Array) -> Array:
    numbers = points[:, 0] + 1j * points[:, 1]
    return np.stack([np.angle(numbers), np.abs(numbers)], axis=1).astype(np.float32)


def _by_arccos(points: Array) -> Array:
    away = np.linalg.norm(points, axis=1)
    bearing = np.copysign(np.arccos(points[:, 0] / away), points[:, 1])
    return np.stack([bearing, away], axis=-1)


def _measurement_public() -> list[Case]:
    rng = np.random.default_rng(41)
    return [
        Case((np.array([[1.0, 0.0], [0.0, 2.0], [3.0, 4.0]]),), "ahead, to the left, and both"),
        Case((np.array([[1.0, -1.0], [-1.0, 0.5], [-2.0, -2.0]]),), "to the right, and behind the robot"),
        Case((np.array([[-3.0, 0.0]]),), "straight behind the robot"),
        Case((np.array([[2.0, 1.0], [np.nan, np.nan]]),), "a point that is none: NaN stays NaN"),
        Case((rng.uniform(-4, 4, (12, 2)),), "points by chance"),
        Case((np.zeros((0, 2)),), "no point"),
    ]


def _measurement_hidden(rng: np.random.Generator) -> list[Case]:
    return [
        Case((rng.uniform(-5, 5, (40, 2)),)),
        Case(
            (
                np.array(
                    [[rng.uniform(1, 2), rng.uniform(-2, -1)], [np.nan, np.nan], [-1.0, rng.uniform(0.1, 1)]]
                ),
            )
        ),
        Case((rng.uniform(0.5, 3, (1, 2)),)),
        Case((np.array([[-float(rng.uniform(1, 4)), 0.0], [2.0, 1.0]]),)),
        Case((np.zeros((0, 2)),)),
    ]


GROUND_TO_MEASUREMENT = Exercise(
    name="ground_to_measurement",
    points=1,
    stars=1,
    public=_measurement_public,
    hidden=_measurement_hidden,
    comparison=Close(rtol=1e-4, atol=1e-5, names=("your bearing", "your range")),
    hints=(
        "points[:, 0] is x, ahead; points[:, 1] is y, to the left. np.arctan2 and np.hypot take whole columns.",
        "np.arctan2 wants y first. np.column_stack sets two columns side by side.",
    ),
    mistakes=[
        Mistake(
            "range first",
            lambda points: _measured(points)[:, ::-1],
            "Your columns are (range, bearing). In this course a measurement is (bearing, range).",
        ),
        Mistake(
            "degrees",
            _columns(lambda x, y: np.degrees(np.arctan2(y, x)), np.hypot),
            "Your bearings are in degrees. Angles are in radians throughout the course.",
        ),
        Mistake(
            "positive to the right",
            _columns(lambda x, y: np.arctan2(-y, x), np.hypot),
            "Your bearings have the wrong sign: positive is to the left, where y is positive.",
        ),
        Mistake(
            "arctan of the quotient",
            _columns(_quotient, np.hypot),
            "arctan(y / x) cannot tell ahead from behind: -y / -x is the same quotient. np.arctan2(y, x) can.",
        ),
        Mistake(
            "x and y exchanged",
            _columns(lambda x, y: np.arctan2(x, y), np.hypot),
            "Your bearings are measured from the y axis: np.arctan2 takes y first, then x.",
        ),
        Mistake(
            "root forgotten",
            _columns(lambda x, y: np.arctan2(y, x), lambda x, y: x**2 + y**2),
            "Your range is the squared distance: the root is missing.",
        ),
        Mistake(
            "x for the range",
            _columns(lambda x, y: np.arctan2(y, x), lambda x, y: x),
            "Your range is x alone, how far ahead the point is. It is the distance: the root of x * x + y * y.",
        ),
        Mistake(
            "all round",
            _columns(lambda x, y: np.arctan2(y, x) % ROUND, np.hypot),
            "Your bearings go from 0 to 2 pi. To the right of the robot they are negative, in (-pi, pi]: np.arctan2 gives them so.",
        ),
        Mistake(
            "the sign of y times arccos",
            _columns(_signed_arccos, np.hypot),
            "Your bearing is 0 where y is 0, for np.sign(0) is 0: a point straight behind the robot is at pi. np.arctan2(y, x) knows.",
        ),
        Mistake(
            "arcsin",
            _columns(lambda x, y: np.arcsin(y / np.hypot(x, y)), np.hypot),
            "arcsin(y / r) cannot tell ahead from behind: it knows nothing of the sign of x. np.arctan2(y, x) does.",
        ),
        Mistake(
            "one range for all",
            _columns(
                lambda x, y: np.arctan2(y, x),
                lambda x, y: np.full_like(x, np.hypot(x, y).dot(np.hypot(x, y)) ** 0.5),
            ),
            "Your range is one number for all points together: np.linalg.norm(points) needs axis=1, or take np.hypot(x, y).",
        ),
        Mistake(
            "two rows",
            lambda points: _measured(points).T,
            "Your answer lies on its side: it is (2, N). One row for each point is wanted, (N, 2).",
        ),
    ],
    alternatives={
        "complex numbers, float32": _complex,
        "point by point": _measured,
        "arccos with the sign of y": _by_arccos,
    },
    equivalents={
        "return np.column_stack([np.arctan2(points[:, 1], points[:, 0]), np.hypot(points[:, 1], points[:, 0])])": "the root of a sum does not depend on its order",
    },
)


# --- 4.2 paper_distance and 4.3 paper_bearing ---


def _paper_angles(pixels: Any, view: CameraView, **changed: Any) -> tuple[Array, Array]:
    """The paper's two angles, with one thing done in another way."""
    pixels = np.asarray(pixels, dtype=float)
    if changed.get("without_lens"):
        pixels = view.undistort(pixels)
    (width, height), (hfov, vfov) = view.size, (view.hfov, view.vfov)
    if changed.get("fields_exchanged"):
        hfov, vfov = vfov, hfov
    if changed.get("size_exchanged"):
        width, height = height, width
    half = 0.0 if changed.get("no_half") else 0.5
    below = {
        "from_the_top": pixels[:, 1] + 0.5,
        "as_they_are": pixels[:, 1],
        "row_before": height - 1 - pixels[:, 1],
    }
    y = next((rows for name, rows in below.items() if changed.get(name)), height - half - pixels[:, 1])
    half = 0.0 if changed.get("as_they_are") or changed.get("column_before") else half
    x = pixels[:, 0] + half - width / 2
    camera = view.pitch if changed.get("from_the_horizon") else np.pi / 2 - view.pitch
    bottom = camera - changed.get("field", 0.5) * vfov
    if changed.get("true_angles"):
        up = (height / 2 - y) / (height / 2) * np.tan(vfov / 2)
        return camera - np.arctan(up), np.arctan(x / (width / 2) * np.tan(hfov / 2))
    if changed.get("degrees"):
        return np.degrees(bottom + y * vfov / height), np.degrees(x * hfov / width)
    return bottom + y * vfov / height, x * hfov / width


def _distance(**changed: Any) -> Any:
    def function(pixels: Any, view: CameraView) -> Array:
        up, side = _paper_angles(pixels, view, **changed)
        side = side - view.yaw if changed.get("head_turned") else side
        cosine = 1.0 if changed.get("no_cosine") else np.cos(side)
        over = np.tan(up) * (cosine if changed.get("times_cosine") else 1 / cosine)
        return (1.0 if changed.get("no_height") else view.height) * over

    return function


def _bearing(sign: float = -1.0, factor: float = 1.0, yaw: float = 0.0, **changed: Any) -> Any:
    def function(pixels: Any, view: CameraView) -> Array:
        return factor * sign * _paper_angles(pixels, view, **changed)[1] + yaw * view.yaw

    return function


def _distance_loop(pixels: Array, view: CameraView) -> list[float]:
    found = []
    for u, v in pixels:
        down = view.pitch + ((v + 0.5) / view.size[1] - 0.5) * view.vfov  # below the horizon
        side = ((u + 0.5) / view.size[0] - 0.5) * view.hfov
        found.append(float(view.height / (np.tan(down) * np.cos(side))))
    return found


def _distance_sines(pixels: Array, view: CameraView) -> Array:
    up, side = _paper_angles(pixels, view)
    return view.height * np.sin(up) / (np.cos(up) * np.cos(side))


def _distance_float32(pixels: Array, view: CameraView) -> Array:
    return np.array(_distance()(pixels, view), dtype=np.float32)


def _bearing_loop(pixels: Array, view: CameraView) -> list[float]:
    return [float((0.5 - (u + 0.5) / view.size[0]) * view.hfov) for u, _ in pixels]


def _bearing_interpolated(pixels: Array, view: CameraView) -> Array:
    width, half = view.size[0], view.hfov / 2
    return np.interp(pixels[:, 0], [-0.5, width - 0.5], [half, -half])


def _bearing_float32(pixels: Array, view: CameraView) -> Array:
    return ((view.centre[0] - pixels[:, 0]) * np.float32(view.hfov / view.size[0])).astype(np.float32)


def _paper_public() -> list[Case]:
    rng = np.random.default_rng(42)
    level = view_of(25.0)
    return [
        Case((np.array([[159.5, 119.5]]), view_of(45.0)), "the middle of a picture, 45 degrees down"),
        Case((np.array([[0.0, 239.0], [319.0, 239.0], [40.0, 130.0]]), level), "corners at the bottom"),
        Case(
            (
                np.array([[100.0, 150.0], [250.0, 200.0]]),
                view_of(30.0, yaw=0.6, roll=0.1, offset=(0.05, 0.02), k1=-0.08),
            ),
            "a head that is turned and tilted, with a lens: the paper knows none of these",
        ),
        Case(
            (pixels_in(rng, view_of(35.0, size=(64, 32)), 6), view_of(35.0, size=(64, 32))),
            "a picture of 64 x 32",
        ),
        Case(
            (np.array([[60.0, 5.0], [300.0, 20.0]]), view_of(5.0)),
            "above the horizon: what the formula gives",
        ),
        Case((np.array([[12.0, 30.0], [60.0, 45.0]]), view_of(40.0, size=(65, 49))), "a picture of 65 x 49"),
        Case((np.zeros((0, 2)), level), "no pixel"),
    ]


def _paper_hidden(rng: np.random.Generator) -> list[Case]:
    views = [any_view(rng), any_view(rng, (640, 480)), view_of(rng.uniform(30, 50))]
    return [
        *(Case((pixels_in(rng, view, 15, top=0.3), view)) for view in views),
        Case((np.array([[rng.uniform(0, 300), 10.0]]), view_of(rng.uniform(3, 6)))),
        Case((rng.uniform(20, 200, (3, 2)), view_of(rng.uniform(35, 45), size=(321, 241)))),
        Case((np.zeros((0, 2)), views[0])),
    ]


_LENS = "You remove the lens. The paper does not: its angles are those of the pixels as they are."
_FIELDS = "You exchanged the two fields of view: hfov goes with u and the width, vfov with v and the height."
_DEGREES = "You compute in degrees. The view's angles are radians, and so is what np.tan and np.cos want."
_TRUE = (
    "Your angles are those of a pinhole camera. That is right, and not what the paper says: there an angle grows in "
    "proportion to the pixel. You get to do better in exercise 4.4."
)

PAPER_DISTANCE = Exercise(
    name="paper_distance",
    points=2,
    stars=1,
    public=_paper_public,
    hidden=_paper_hidden,
    comparison=Close(rtol=1e-4, atol=1e-6),
    hints=(
        "Write equation 4.1 part by part, each with a name of its own: x and y, the two angles, the distance. width, height = view.size.",
        "The camera's angle from straight down is np.pi / 2 - view.pitch. The paper's y counts from the picture's lower "
        "edge: y = height - 1 / 2 - v, where v is pixels[:, 1].",
    ),
    mistakes=[
        Mistake(
            "horizon for nadir",
            _distance(from_the_horizon=True),
            "You take view.pitch for the paper's camera angle. The pitch is measured from the horizon, the paper's angle "
            "from straight down: np.pi / 2 - view.pitch.",
        ),
        Mistake(
            "v counted from the top",
            _distance(from_the_top=True),
            "Your distances grow downwards in the picture. v counts from the top, the paper's y from the bottom.",
        ),
        Mistake(
            "pixels as they are",
            _distance(as_they_are=True),
            "You take u and v for x and y. The paper's y begins at the picture's lower edge: x = u + 1/2, y = height - 1/2 - v.",
        ),
        Mistake(
            "columns half a pixel off",
            _distance(column_before=True),
            "Right down the middle, and half a pixel off to the sides: x = u + 1/2.",
        ),
        Mistake(
            "rows half a pixel off",
            _distance(row_before=True),
            "Nearly. Your rows are half a pixel off: row v has its middle half a pixel below its upper edge, so y = height - 1/2 - v.",
        ),
        Mistake(
            "width and height exchanged",
            _distance(size_exchanged=True),
            "You exchanged width and height: view.size is (width, height), other than an array's shape.",
        ),
        Mistake(
            "the offset added",
            lambda pixels, view: _distance()(pixels, view) + view.offset[0],
            "You add the camera's offset. The paper has no word for it: its distance is that from the point below the camera.",
        ),
        Mistake(
            "half the field not taken off",
            _distance(field=0.0),
            "You count the angles from the optical axis. The paper begins at the bottom of the picture, half a field of "
            "view below it.",
        ),
        Mistake(
            "half the field added",
            _distance(field=-0.5),
            "You add half the field of view. The bottom of the picture is nearer to straight down, so it is taken off.",
        ),
        Mistake(
            "half a pixel",
            _distance(no_half=True),
            "Nearly. You are half a pixel off: pixel 0 has its middle half a pixel from the picture's edge, so "
            "x = u + 1/2 and y = height - 1/2 - v.",
        ),
        Mistake(
            "cosine forgotten",
            _distance(no_cosine=True),
            "Right in the middle column only. To the sides a point is farther away: divide by the cosine.",
        ),
        Mistake(
            "times the cosine",
            _distance(times_cosine=True),
            "You multiply by the cosine, so that points at the sides come nearer. The paper divides.",
        ),
        Mistake("fields of view exchanged", _distance(fields_exchanged=True), _FIELDS),
        Mistake("degrees", _distance(degrees=True), _DEGREES),
        Mistake(
            "height forgotten",
            _distance(no_height=True),
            "Your distances are in camera heights: multiply by view.height.",
        ),
        Mistake("a pinhole's angles", _distance(true_angles=True), _TRUE),
        Mistake("the lens removed", _distance(without_lens=True), _LENS),
        Mistake(
            "the head's yaw",
            _distance(head_turned=True),
            "You let the head's yaw take part. The paper's horizontal angle counts from the picture's middle.",
        ),
    ],
    alternatives={
        "angles below the horizon, pixel by pixel": _distance_loop,
        "sine over cosine": _distance_sines,
        "float32": _distance_float32,
    },
    equivalents={
        "horizontal = (width / 2 - (pixels[:, 0] + 0.5)) * view.hfov / width": "the cosine of an angle is that of its opposite",
    },
)

PAPER_BEARING = Exercise(
    name="paper_bearing",
    points=1,
    stars=1,
    public=_paper_public,
    hidden=_paper_hidden,
    comparison=Close(rtol=1e-4, atol=1e-6),
    hints=(
        "It is the paper's horizontal angle, with one change: the course's bearings are positive to the left.",
        "u grows to the right, so a pixel left of the middle has a negative offset and a positive bearing.",
    ),
    mistakes=[
        Mistake(
            "positive to the right",
            _bearing(sign=1.0),
            "Your bearings are positive to the right, as the paper's angle is. In this course they are positive to the left.",
        ),
        Mistake("degrees", _bearing(factor=180 / np.pi), "Your bearings are in degrees. Radians are wanted."),
        Mistake(
            "half a pixel",
            _bearing(no_half=True),
            "Nearly. You are half a pixel off: pixel 0 has its middle half a pixel from the edge, so x = u + 1/2.",
        ),
        Mistake("fields of view exchanged", _bearing(fields_exchanged=True), _FIELDS),
        Mistake(
            "the head's yaw",
            _bearing(yaw=1.0),
            "You add the head's yaw. That would be right, and the paper does not: it has no word for a turned head.",
        ),
        Mistake("a pinhole's angles", _bearing(true_angles=True), _TRUE),
        Mistake("the lens removed", _bearing(without_lens=True), _LENS),
        Mistake(
            "from the left edge",
            lambda pixels, view: -(pixels[:, 0] + 0.5) * view.hfov / view.size[0],
            "Your angle is 0 at the picture's left edge. It is 0 in the middle: take off half the width first.",
        ),
        Mistake(
            "half a pixel the other way",
            lambda pixels, view: (view.size[0] / 2 - pixels[:, 0] + 0.5) * view.hfov / view.size[0],
            "You are a pixel off: x = u + 1/2, so with the sign turned it is width / 2 - u - 1/2.",
        ),
        Mistake(
            "without a sign",
            lambda pixels, view: np.abs(_bearing()(pixels, view)),
            "Your bearings have no sign, so left and right are the same. To the right they are negative.",
        ),
        Mistake(
            "one pixel too few",
            lambda pixels, view: (view.centre[0] - pixels[:, 0]) * view.hfov / (view.size[0] - 1),
            "Nearly. The field of view spans all pixels of the width, edge to edge: divide by the width, not by the width less one.",
        ),
        Mistake(
            "brackets",
            lambda pixels, view: view.size[0] / 2 - (pixels[:, 0] + 0.5) * view.hfov / view.size[0],
            "Brackets are missing: take the difference of the pixels first, then turn it into an angle.",
        ),
        Mistake(
            "twice the angle",
            _bearing(factor=2.0),
            "Your angles are twice too large: the field of view spans the whole width, not half of it.",
        ),
    ],
    alternatives={
        "pixel by pixel": _bearing_loop,
        "interpolated between the edges": _bearing_interpolated,
        "from the middle, float32": _bearing_float32,
    },
)


# --- 4.4 pixel_to_ground ---


def _ground(pixels: Any, view: CameraView, **changed: Any) -> Array:
    """Follow the rays, with one thing done in another way."""
    pixels = np.asarray(pixels, dtype=float).reshape(-1, 2)
    seen = pixels if changed.get("no_lens") else view.undistort(pixels)
    if changed.get("lens_twice"):
        seen = view.distort(pixels)
    middle = np.array(view.size) / 2 if changed.get("half_pixel") else np.array(view.centre)
    right, below = ((seen - middle) / view.focal).T
    if changed.get("one_focal"):
        right, below = ((seen - middle) / view.focal[0]).T
    if changed.get("focal_exchanged"):
        right, below = ((seen - middle) / view.focal[::-1]).T
    if changed.get("v_up"):
        below = -below
    if changed.get("right_positive"):
        right = -right
    rotation = changed.get("rotation", lambda view: view.rotation)(view)
    rays = np.column_stack([np.ones(len(seen)), -right, -below]) @ rotation.T
    if changed.get("unit_rays"):
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    with np.errstate(all="ignore"):
        steps = (1.0 if changed.get("no_height") else view.height) / -rays[:, 2]
        if changed.get("unit_rays"):
            steps = np.where(rays[:, 2] < 0, view.height, np.nan)
        if not changed.get("behind"):
            steps = np.where(rays[:, 2] < 0, steps, np.nan)
        if changed.get("level"):
            steps = np.where(rays[:, 2] > 0, np.nan, view.height / -rays[:, 2])
        points = steps[:, None] * rays[:, :2]
    if changed.get("only_ahead"):
        points[points[:, 0] < 0] = np.nan
    if changed.get("clipped"):
        points = np.nan_to_num(points)
    if changed.get("dropped"):
        points = points[np.isfinite(points).all(axis=1)]
    offset = np.array(view.offset) * changed.get("offset", 1.0)
    if changed.get("offset_turned"):
        offset = rotation_3d(view.yaw, 0.0, 0.0)[:2, :2] @ offset
    return points if changed.get("no_offset") else points + offset


def _followed(**changed: Any) -> Any:
    return lambda pixels, view: _ground(pixels, view, **changed)


def _turned(yaw: float = 1.0, pitch: float = 1.0, roll: float = 1.0) -> Any:
    """Rays turned by other angles than the view's."""
    return _followed(rotation=lambda view: rotation_3d(yaw * view.yaw, pitch * view.pitch, roll * view.roll))


def _ground_by_angles(pixels: Array, view: CameraView) -> Array:
    """Depression angle and direction of each ray, pixel by pixel."""
    found = []
    for right, below in (view.undistort(pixels) - view.centre) / view.focal:
        x, y, z = view.rotation @ (1.0, -right, -below)
        down = np.arctan2(-z, np.hypot(x, y))
        away = view.height / np.tan(down) if down > 0 else np.nan
        along = np.arctan2(y, x)
        found.append([view.offset[0] + away * np.cos(along), view.offset[1] + away * np.sin(along)])
    return np.array(found).reshape(-1, 2)


def _ground_by_homography(pixels: Array, view: CameraView) -> Array:
    """The plane's homography, inverted."""
    (fx, fy), (cx, cy) = view.focal, view.centre
    camera = np.array([[cx, -fx, 0.0], [cy, 0.0, -fy], [1.0, 0.0, 0.0]])  # of (ahead, left, up)
    corner = np.column_stack([np.eye(3)[:, :2], -np.array([*view.offset, view.height])])
    plane = np.linalg.inv(camera @ view.rotation.T @ corner)
    x, y, w = plane @ np.column_stack([view.undistort(pixels), np.ones(len(pixels))]).T
    with np.errstate(all="ignore"):
        points = np.stack([x / w, y / w], axis=1)
    points[w <= 1e-12] = np.nan
    return points


def _ground_by_search(pixels: Array, view: CameraView) -> Array:
    """Newton's method on `view.project`, from the foot of the optical axis."""
    found = np.full((len(pixels), 2), np.nan)
    direct = _ground_by_angles(pixels, view)
    for i, pixel in enumerate(pixels):
        if np.isfinite(direct[i]).all():
            start = direct[i] * 1.01 + 0.005
            found[i] = least_squares(
                lambda p, w=pixel: (view.project(p[None]) - w)[0], start, xtol=1e-12, ftol=1e-14, gtol=1e-14
            ).x
    return found


def _level_rows() -> tuple[Array, CameraView]:
    """Pixels above, at and below the horizon of a level camera, at its rows 119, 120 and 121."""
    return np.array([[30.0, 60.0], [80.0, 119.0], [200.0, 120.0], [50.0, 121.0], [160.0, 200.0]]), view_of(
        0.0, size=(321, 241), vfov=0.8
    )


def _ground_public() -> list[Case]:
    rng = np.random.default_rng(44)
    lens = view_of(28.0, k1=-0.08)
    everything = any_view(np.random.default_rng(5))
    walking = NAO_V4.view("bottom", 0.4, -0.4, torso_pitch=0.03, torso_roll=-0.04)
    return [
        Case((np.array([[159.5, 119.5]]), view_of(45.0)), "the middle of a picture, 45 degrees down"),
        Case(
            (np.array([[60.0, 180.0], [250.0, 100.0], [30.0, 230.0]]), view_of(25.0)), "left, right and near"
        ),
        Case(
            (np.array([[60.0, 180.0], [250.0, 100.0]]), view_of(25.0, yaw=0.7)), "the head turned to the left"
        ),
        Case(
            (np.array([[60.0, 180.0], [250.0, 100.0]]), view_of(25.0, roll=0.12)), "the head tilted sideways"
        ),
        Case((np.array([[10.0, 230.0], [300.0, 60.0]]), lens), "with a lens"),
        Case(
            (np.array([[60.0, 180.0], [250.0, 100.0]]), view_of(25.0, offset=(0.06, 0.02))),
            "the camera beside the robot's middle",
        ),
        Case(
            (np.array([[60.0, 180.0]]), view_of(30.0, height=0.6, size=(640, 480))),
            "a larger picture, a higher camera",
        ),
        Case(_level_rows(), "above, at and below the horizon"),
        Case(
            (
                np.array([[60.0, 180.0], [150.0, 30.0], [250.0, 120.0]]),
                view_of(12.0, yaw=1.95, offset=(0.05, 0.01)),
            ),
            "the head turned to behind the shoulder",
        ),
        Case((pixels_in(rng, everything, 6), everything), "all at once"),
        Case((pixels_in(rng, walking, 5), walking), "a NAO that leans"),
        Case((np.zeros((0, 2)), lens), "no pixel"),
    ]


def _ground_hidden(rng: np.random.Generator) -> list[Case]:
    views = [any_view(rng), any_view(rng, (640, 480)), any_view(rng, (1280, 960))]
    high = replace(any_view(rng), pitch=rng.uniform(0.0, 0.1))
    rows, level = _level_rows()
    return [
        *(Case((pixels_in(rng, view, 20), view)) for view in views),
        Case((np.array([[rng.uniform(0, 319), 2.0], [rng.uniform(0, 319), 235.0]]), high)),
        Case((rows, replace(level, yaw=rng.uniform(-1, 1)))),
        Case((pixels_in(rng, views[0], 12), replace(views[0], pitch=0.2, yaw=rng.uniform(1.8, 2.0)))),
        Case((np.zeros((0, 2)), views[0])),
    ]


PIXEL_TO_GROUND = Exercise(
    name="pixel_to_ground",
    points=4,
    stars=2,
    public=_ground_public,
    hidden=_ground_hidden,
    comparison=Close(rtol=1e-4, atol=1e-5),
    hints=(
        "Three steps, each for all pixels at once: seen = view.undistort(pixels); the rays (1, -(u - cu) / fu, -(v - cv) / fv) "
        "as an array (N, 3); the rays in the robot frame, rays @ view.rotation.T.",
        "A ray (x, y, z) goes down where z < 0 and meets the ground after view.height / -z of its own lengths. Put NaN for z where it "
        "is not negative, before you divide; then add view.offset.",
    ),
    mistakes=[
        Mistake(
            "the head's yaw forgotten",
            _turned(yaw=0.0),
            "Where the head is turned, your points are not: the camera's yaw is missing. view.rotation has all three angles.",
        ),
        Mistake(
            "roll forgotten",
            _turned(roll=0.0),
            "Where the camera is tilted sideways, your points are wrong: view.roll is missing. view.rotation has all three angles.",
        ),
        Mistake(
            "offset forgotten",
            _followed(no_offset=True),
            "Your points are measured from the point below the camera. In the robot frame the camera stands at view.offset.",
        ),
        Mistake(
            "the lens left in",
            _followed(no_lens=True),
            "Right for a camera without a lens term. Take the lens out of the pixels first: view.undistort(pixels).",
        ),
        Mistake(
            "the lens the wrong way round",
            _followed(lens_twice=True),
            "view.distort puts the lens in. The pixels have it already: view.undistort takes it out.",
        ),
        Mistake(
            "behind the robot",
            _followed(behind=True),
            "Above the horizon you return points behind the robot: there the ray never meets the ground. NaN is wanted.",
        ),
        Mistake(
            "only ahead",
            _followed(only_ahead=True),
            "You leave out what lies behind the robot's middle. With the head turned to behind the shoulder such points are real: NaN is for rays "
            "that do not go down, by their third part.",
        ),
        Mistake(
            "a level ray",
            _followed(level=True),
            "At the horizon the ray is level, its third part 0, and never meets the ground either: NaN where it is not negative.",
        ),
        Mistake(
            "focal lengths exchanged",
            _followed(focal_exchanged=True),
            "You exchanged the focal lengths: view.focal is (fu, fv), and u goes with fu.",
        ),
        Mistake(
            "offset taken off",
            _followed(offset=-1.0),
            "You take view.offset off. The camera stands there, so it is added to what the ray covers.",
        ),
        Mistake(
            "offset turned",
            _followed(offset_turned=True),
            "You turn view.offset with the head. It is in the robot frame already: add it as it is.",
        ),
        Mistake(
            "zero above the horizon",
            _followed(clipped=True, no_offset=False),
            "Above the horizon there is no point. Yours is the one below the camera; NaN is wanted.",
        ),
        Mistake(
            "left out above the horizon",
            _followed(dropped=True),
            "You leave out pixels above the horizon, so nobody knows any more which row belongs to which pixel. Keep the row, as NaN.",
        ),
        Mistake(
            "rotated back",
            _followed(rotation=lambda view: view.rotation.T),
            "You turn the rays the wrong way round, out of the robot frame. For rays in rows it is rays @ view.rotation.T.",
        ),
        Mistake(
            "v upwards",
            _followed(v_up=True),
            "Your picture stands on its head: v grows downwards, the ray's third part upwards. A minus is missing.",
        ),
        Mistake(
            "positive to the right",
            _followed(right_positive=True),
            "Left and right are exchanged: u grows to the right, y to the left. A minus is missing.",
        ),
        Mistake(
            "half a pixel",
            _followed(half_pixel=True),
            "Nearly. The middle of the picture is view.centre, half a pixel before half its size.",
        ),
        Mistake(
            "one focal length",
            _followed(one_focal=True),
            "You use one focal length for both directions. view.focal has two: they differ where the pixels are not square.",
        ),
        Mistake(
            "height forgotten",
            _followed(no_height=True),
            "Your points are those of a camera 1 m above the ground: view.height is missing.",
        ),
        Mistake(
            "height along the ray",
            _followed(unit_rays=True),
            "You go view.height along the ray. The ray has to come down by that height: divide by how much it falls, -z.",
        ),
    ],
    alternatives={
        "angles, pixel by pixel": _ground_by_angles,
        "the inverse of the ground's homography": _ground_by_homography,
        "a search on view.project": _ground_by_search,
    },
    equivalents={
        "return view.offset + view.height * rays[:, :2] / falling[:, None]": "NumPy takes a tuple for an array",
    },
)


# --- 4.5 range_sigma ---


def _sigma(formula: Any) -> Any:
    return lambda range_m, height, tilt_sigma: formula(range_m, height, tilt_sigma)


def _sigma_numeric(range_m: Any, height: float, tilt_sigma: float) -> Any:
    down = np.arctan2(height, range_m)
    return height * (1 / np.tan(down - 1e-6) - 1 / np.tan(down + 1e-6)) / 2e-6 * tilt_sigma


def _sigma_public() -> list[Case]:
    return [
        Case((2.0, 0.5, 0.02), "2 m away, half a metre up"),
        Case((0.5, 0.5, 0.02), "45 degrees down"),
        Case((4.0, 0.48, float(np.radians(1.0))), "4 m away, one degree"),
        Case((0.0, 0.6, 0.01), "straight below"),
        Case((1.0, 1.6, 0.01), "a camera higher than the point is far"),
        Case((1.0, 0.5, 0.3), "an angle that is not small: to first order all the same"),
    ]


def _sigma_hidden(rng: np.random.Generator) -> list[Case]:
    cases = [(rng.uniform(0.1, 6), rng.uniform(0.3, 1.8), rng.uniform(0.001, 0.05)) for _ in range(8)]
    return [
        *(Case(tuple(map(float, case))) for case in cases),
        Case((0.0, float(rng.uniform(0.4, 2)), 0.02)),
        Case((float(rng.uniform(1, 2)), 0.5, float(rng.uniform(0.2, 0.4)))),
    ]


RANGE_SIGMA = Exercise(
    name="range_sigma",
    points=2,
    stars=2,
    public=_sigma_public,
    hidden=_sigma_hidden,
    comparison=Close(rtol=1e-4),
    hints=(
        "The derivative of 1 / tan(x) is -1 / sin(x) ** 2. Its size is what counts: a deviation has no sign.",
        "Get rid of the angle: in the right triangle of camera, foot and point, its sine is the height over the line of sight. Try "
        "the example of the docstring on paper.",
    ),
    mistakes=[
        Mistake(
            "r squared over h alone",
            _sigma(lambda r, h, s: r**2 / h * s),
            "Right far away, too small near by: r squared over h is what is left where h is small beside r. Straight below, a "
            "tilt still moves the point by h times the angle.",
        ),
        Mistake(
            "a variance",
            _sigma(lambda r, h, s: ((h**2 + r**2) / h * s) ** 2),
            "That is the variance, in square metres. Its root is wanted.",
        ),
        Mistake(
            "the angle in degrees",
            _sigma(lambda r, h, s: (h**2 + r**2) / h * np.degrees(s)),
            "You turn tilt_sigma into degrees. The derivative is in metres per radian.",
        ),
        Mistake(
            "the line of sight",
            _sigma(lambda r, h, s: np.hypot(h, r) * s),
            "That is how far the point moves across the line of sight. The ground is hit at a slant, and so it moves farther along it.",
        ),
        Mistake(
            "divided by r",
            _sigma(lambda r, h, s: (h**2 + r**2) / max(r, 1e-9) * s),
            "You divide by the range. It is the height that is left below the fraction: the lower the camera, the worse.",
        ),
        Mistake(
            "tilt forgotten",
            _sigma(lambda r, h, s: (h**2 + r**2) / h),
            "That is the slope, in metres per radian. Times tilt_sigma it is a deviation in metres.",
        ),
        Mistake(
            "brackets",
            _sigma(lambda r, h, s: h**2 + r**2 / h * s),
            "Brackets are missing: the whole sum is divided by the height.",
        ),
        Mistake(
            "taken for degrees",
            _sigma(lambda r, h, s: (h**2 + r**2) / h * np.radians(s)),
            "You turn tilt_sigma into radians. It is in radians already.",
        ),
        Mistake(
            "tilt squared",
            _sigma(lambda r, h, s: (h**2 + r**2) / h * s**2),
            "You square tilt_sigma. A deviation goes through a straight line as it is; squares are for variances.",
        ),
        Mistake(
            "the sine of the tilt",
            _sigma(lambda r, h, s: (h**2 + r**2) / h * np.sin(s)),
            "To first order the tilt's deviation is multiplied as it is: no sine of it.",
        ),
        Mistake(
            "the tangent of the tilt",
            _sigma(lambda r, h, s: (h**2 + r**2) / h * np.tan(s)),
            "To first order the tilt's deviation is multiplied as it is: no tangent of it.",
        ),
        Mistake(
            "one exact tilt",
            _sigma(lambda r, h, s: h / np.tan(np.arctan2(h, r) - s) - r),
            "You move the camera by one tilt_sigma and look how far the point goes. To first order it is the slope at the point itself, times tilt_sigma.",
        ),
        Mistake(
            "sine not squared",
            _sigma(lambda r, h, s: np.hypot(h, r) / h * h * (1 + r / h) * s),
            "Look at the derivative again: 1 / tan(x) becomes -1 / sin(x) ** 2.",
        ),
        Mistake(
            "negative",
            _sigma(lambda r, h, s: -(h**2 + r**2) / h * s),
            "A standard deviation is not negative: of the derivative only its size counts.",
        ),
        Mistake(
            "one over the sine squared",
            _sigma(lambda r, h, s: (h**2 + r**2) / h**2 * s),
            "The height is missing: r is the height over tan(x), so its derivative is the height over sin(x) ** 2.",
        ),
    ],
    alternatives={
        "by the sine": _sigma(lambda r, h, s: h / np.sin(np.arctan2(h, r)) ** 2 * s),
        "h and r apart": _sigma(lambda r, h, s: s * h + s * r * r / h),
        "differences": _sigma_numeric,
    },
)


# --- 4.6 measurement_covariance ---


def _z(pixels: Any, view: CameraView) -> Array:
    return _measured(_ground(pixels, view)).ravel()


def _parts(pixels: Array, view: CameraView) -> tuple[Array, Array]:
    """Derivatives of (bearing, range, bearing, range, ...) by each pixel (k, 2, 2), and by the pitch (2k,)."""
    columns = []
    for step in np.eye(2) * 0.05:
        columns.append((_z(pixels + step, view) - _z(pixels - step, view)) / 0.1)
    up, down = (replace(view, pitch=view.pitch + step) for step in (1e-4, -1e-4))
    by_pitch = (_z(pixels, up) - _z(pixels, down)) / 2e-4
    return np.stack(columns, axis=1).reshape(-1, 2, 2), by_pitch


def _covariance(**changed: Any) -> Any:
    def function(pixels: Any, view: CameraView, pixel_sigma: float, tilt_sigma: float) -> Array:
        pixels = np.asarray(pixels, dtype=float).reshape(-1, 2)
        jacobians, by_pitch = _parts(pixels, view)
        k = len(pixels)
        if changed.get("only_range"):
            by_pitch = by_pitch * np.tile([0.0, 1.0], k)
        if changed.get("degrees"):
            tilt_sigma = float(np.degrees(tilt_sigma))
        if changed.get("absolute"):
            by_pitch = np.abs(by_pitch)
        if changed.get("by_formula"):
            away = _z(pixels, view)[1::2]
            by_pitch = np.column_stack([0.0 * away, (view.height**2 + away**2) / view.height]).ravel()
        if changed.get("slope_by_kind"):
            by_pitch = by_pitch.reshape(-1, 2).T.ravel()
        jacobians = jacobians * changed.get("times", 1.0)
        power = 1 if changed.get("not_squared") else 2
        outer = by_pitch @ by_pitch if changed.get("inner") else np.outer(by_pitch, by_pitch)
        tilt_power = 1 if changed.get("tilt_not_squared") else power
        full = tilt_sigma**tilt_power * outer * (0 if changed.get("no_tilt") else 1) * np.ones((2 * k, 2 * k))
        if changed.get("each_for_itself"):
            full *= np.kron(np.eye(k), np.ones((2, 2)))
        if changed.get("diagonal"):
            full = np.diag(np.diag(full))
        for i, each in enumerate(jacobians):
            square = each.T @ each if changed.get("transposed") else each @ each.T
            if changed.get("one_direction"):
                square = np.outer(each[:, 1], each[:, 1])
            if changed.get("variances_only"):
                square = np.diag(np.diag(square))
            full[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] += (
                0
                if changed.get("no_pixels")
                else pixel_sigma ** (1 if changed.get("pixel_not_squared") else power)
            ) * square
        order = {
            "range_first": np.arange(2 * k).reshape(-1, 2)[:, ::-1].ravel(),
            "by_kind": np.arange(2 * k).reshape(-1, 2).T.ravel(),
        }
        for name, places in order.items():
            if changed.get(name):
                full = full[np.ix_(places, places)]
        if changed.get("shared_pixels"):
            joint = jacobians.reshape(-1, 2)
            full = pixel_sigma**2 * joint @ joint.T + tilt_sigma**2 * np.outer(by_pitch, by_pitch)
        return full

    return function


def _in_metres(pixels: Any, view: CameraView, pixel_sigma: float, tilt_sigma: float) -> Array:
    """The same of points (x, y)."""

    def flat(pixels: Array, view: CameraView) -> Array:
        return _ground(pixels, view).ravel()

    pixels = np.asarray(pixels, dtype=float)
    columns = [(flat(pixels + step, view) - flat(pixels - step, view)) / 0.1 for step in np.eye(2) * 0.05]
    up, down = (replace(view, pitch=view.pitch + step) for step in (1e-4, -1e-4))
    slope = (flat(pixels, up) - flat(pixels, down)) / 2e-4
    blocks = np.kron(np.eye(len(pixels)), np.ones((2, 2)))
    joint = np.stack(columns, axis=1)
    return pixel_sigma**2 * (joint @ joint.T) * blocks + tilt_sigma**2 * np.outer(slope, slope)


def _covariance_one_jacobian(pixels: Any, view: CameraView, pixel_sigma: float, tilt_sigma: float) -> Array:
    """All 2k + 1 unknowns in one Jacobian, by differences one of a time."""
    pixels = np.asarray(pixels, dtype=float)
    state = np.append(pixels.ravel(), view.pitch)

    def measured(values: Array) -> Array:
        return _z(values[:-1].reshape(-1, 2), replace(view, pitch=float(values[-1])))

    base = measured(state)
    steps = np.append(np.full(pixels.size, 1e-3), 1e-6)
    columns = [
        (measured(state + step * (np.arange(len(state)) == i)) - base) / step for i, step in enumerate(steps)
    ]
    jacobian = np.array(columns).T.reshape(len(base), len(state))
    variances = np.append(np.full(pixels.size, pixel_sigma**2), tilt_sigma**2)
    return (jacobian * variances) @ jacobian.T


def _covariance_scaled(pixels: Any, view: CameraView, pixel_sigma: float, tilt_sigma: float) -> Array:
    """Square roots: the covariance as a product of one matrix with itself."""
    jacobians, by_pitch = _parts(np.asarray(pixels, dtype=float), view)
    k = len(jacobians)
    root = np.zeros((2 * k, 2 * k + 1))
    for i, each in enumerate(jacobians):
        root[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = pixel_sigma * each
    root[:, -1] = tilt_sigma * by_pitch
    return root @ root.T


def _covariance_float32(pixels: Any, view: CameraView, pixel_sigma: float, tilt_sigma: float) -> Array:
    return _covariance()(pixels, view, pixel_sigma, tilt_sigma).astype(np.float32)


def _below_horizon(rng: np.random.Generator, view: CameraView, number: int) -> Array:
    """Pixels of points on the ground."""
    return view.project(ground_in_view(rng, view, number))


def _covariance_public() -> list[Case]:
    rng = np.random.default_rng(46)
    plain, everything = view_of(25.0), any_view(np.random.default_rng(6))
    side = np.array([[60.0, 180.0], [250.0, 100.0], [120.0, 70.0]])
    return [
        Case((np.array([[80.0, 150.0]]), plain, 1.0, 0.0), "one landmark, no tilt"),
        Case((np.array([[80.0, 150.0]]), plain, 0.0, 0.02), "one landmark, tilt alone"),
        Case((side, plain, 0.7, 0.02), "three landmarks"),
        Case((side, view_of(25.0, yaw=0.5, offset=(0.1, 0.03)), 1.5, 0.01), "the head turned"),
        Case((_below_horizon(rng, everything, 4), everything, 1.0, 0.015), "a camera with everything"),
        Case((np.zeros((0, 2)), plain, 1.0, 0.01), "no landmark"),
    ]


def _covariance_hidden(rng: np.random.Generator) -> list[Case]:
    views = [any_view(rng), any_view(rng, (640, 480)), view_of(rng.uniform(20, 30), k1=-0.08)]
    numbers = (2, 3, 5)
    cases = [
        Case(
            (
                _below_horizon(rng, view, number),
                view,
                float(rng.uniform(0.4, 2)),
                float(rng.uniform(0.008, 0.02)),
            )
        )
        for view, number in zip(views, numbers, strict=True)
    ]
    one = _below_horizon(rng, views[0], 2)
    return [
        *cases,
        Case((one, views[0], 0.0, 0.02)),
        Case((one, views[0], 1.3, 0.0)),
        Case((np.zeros((0, 2)), views[0], 1.0, 0.01)),
    ]


MEASUREMENT_COVARIANCE = Exercise(
    name="measurement_covariance",
    points=5,
    stars=3,
    uses=("pixel_to_ground", "ground_to_measurement"),
    public=_covariance_public,
    hidden=_covariance_hidden,
    comparison=Close(rtol=0.01, atol=1e-8),
    hints=(
        "Derivatives are differences: measured((0.01, 0), 0) minus measured((-0.01, 0), 0), over the way between them, is that by u of all landmarks at "
        "the same time.",
        "g is the same with a tilt in place of a shift, and np.outer(g, g) is g gᵀ. For D, the two columns by u and by v are (2k, 2): "
        "rows 2i and 2i + 1 are landmark i's Jacobian J, and J @ J.T times pixel_sigma ** 2 is its block.",
    ),
    mistakes=[
        Mistake(
            "tilt forgotten",
            _covariance(no_tilt=True),
            "The pixels' part is right. The tilt's is missing: tilt_sigma ** 2 * np.outer(g, g).",
        ),
        Mistake(
            "pixels forgotten",
            _covariance(no_pixels=True),
            "The tilt's part is right. The pixels' is missing: a block J Jᵀ pixel_sigma ** 2 for each landmark.",
        ),
        Mistake(
            "each landmark's own tilt",
            _covariance(each_for_itself=True),
            "You give each landmark a tilt of its own. All landmarks of one picture share one error: the blocks off the diagonal are not zero.",
        ),
        Mistake(
            "a diagonal",
            _covariance(diagonal=True),
            "You keep the diagonal of the tilt's part alone. g gᵀ is a full matrix: one error moves everything at once.",
        ),
        Mistake(
            "one pixel error for all",
            _covariance(shared_pixels=True),
            "You let all pixels err by the same: D has blocks for each landmark and zeros between them. Only the tilt is shared.",
        ),
        Mistake(
            "deviations not squared",
            _covariance(not_squared=True),
            "You multiply by the standard deviations. A covariance has their squares.",
        ),
        Mistake(
            "the pixel's deviation not squared",
            _covariance(pixel_not_squared=True),
            "You multiply J Jᵀ by pixel_sigma. A covariance has its square.",
        ),
        Mistake(
            "the tilt's deviation not squared",
            _covariance(tilt_not_squared=True),
            "You multiply g gᵀ by tilt_sigma. A covariance has its square.",
        ),
        Mistake(
            "half the way",
            _covariance(times=2.0),
            "Your J is twice too large: from one step to the left to one step to the right it is two steps.",
        ),
        Mistake(
            "an inner product",
            _covariance(inner=True),
            "g @ g of two vectors is one number. g gᵀ is a matrix: np.outer(g, g).",
        ),
        Mistake(
            "variances of a block alone",
            _covariance(variances_only=True),
            "You keep the diagonal of each J Jᵀ alone. One pixel moves bearing and range together, so the block is full.",
        ),
        Mistake(
            "slopes without a sign",
            _covariance(absolute=True),
            "You take the size of g. Its signs count: they say which errors go together and which against each other.",
        ),
        Mistake(
            "equation 4.5 for g",
            _covariance(by_formula=True),
            "You take equation 4.5 for g. It is right straight ahead, below the camera's own place, and its sign is lost: take the differences.",
        ),
        Mistake(
            "slopes by kind",
            _covariance(slope_by_kind=True),
            "Your g has all bearings first, then all ranges. It goes landmark by landmark: .ravel() of the (k, 2) array, without .T.",
        ),
        Mistake(
            "range first",
            _covariance(range_first=True),
            "Your order is (range, bearing). It is bearing, range, bearing, range, ...",
        ),
        Mistake(
            "all bearings first",
            _covariance(by_kind=True),
            "Your order is all bearings, then all ranges. It is landmark by landmark: bearing, range, bearing, range, ...",
        ),
        Mistake(
            "of points",
            _in_metres,
            "That is the covariance of the points (x, y) in square metres. Wanted is that of (bearing, range).",
        ),
        Mistake(
            "tilt in degrees",
            _covariance(degrees=True),
            "You turn tilt_sigma into degrees. It is in radians, as g is per radian.",
        ),
        Mistake(
            "no tilt in the bearing",
            _covariance(only_range=True),
            "You let the tilt change ranges only. Off the middle it changes the bearing, too.",
        ),
        Mistake(
            "the Jacobian transposed",
            _covariance(transposed=True),
            "A block is J Jᵀ, and you have Jᵀ J: J has the measurement in its rows, the pixel in its columns.",
        ),
        Mistake(
            "v alone",
            _covariance(one_direction=True),
            "You let v err alone. A pixel is off in u as well, and that is most of the bearing's error.",
        ),
    ],
    alternatives={
        "one Jacobian for all": _covariance_one_jacobian,
        "a square root times itself": _covariance_scaled,
        "float32": _covariance_float32,
    },
    equivalents=dict.fromkeys(
        (
            "leaning = replace(view, pitch=view.pitch - tilt)",
            "return ground_to_measurement(pixel_to_ground(pixels - shift, leaning)).ravel()",
            "by_u = (measured((-0.01, 0), 0) - measured((0.01, 0), 0)) / 0.02",
            "by_v = (measured((0, -0.01), 0) - measured((0, 0.01), 0)) / 0.02",
            "g = (measured((0, 0), -0.0001) - measured((0, 0), 0.0001)) / 0.0002",
        ),
        "a derivative with the other sign: in J Jᵀ and g gᵀ it is squared",
    )
    | {
        "J = np.column_stack([by_v[i:i + 2], by_u[i:i + 2]])": "u and v are equally uncertain, so their order in J Jᵀ does not matter",
    },
)


# --- 4.7 estimate_pitch ---


def _fitted(pixels: Any, ground_points: Any, view: CameraView, **changed: Any) -> float:
    """The offset with the least squared error in pixels."""
    marked, points = np.array(pixels), np.array(ground_points)
    if changed.get("one_point"):
        marked, points = marked[:1], points[:1]
    if changed.get("no_lens"):
        view = replace(view, k1=0.0)
    if changed.get("no_offset"):
        view = replace(view, offset=(0.0, 0.0))
    if changed.get("no_roll"):
        view = replace(view, roll=0.0)
    if changed.get("no_yaw"):
        view = replace(view, yaw=0.0)

    def misses(offset: Any) -> Array:
        seen = replace(view, pitch=view.pitch + float(offset[0])).project(points)
        return np.nan_to_num(seen - marked, nan=1e3).ravel()

    if changed.get("one_step"):
        slope = (misses([1e-4]) - misses([-1e-4])) / 2e-4
        return float(-slope @ misses([0.0]) / (slope @ slope))
    return float(least_squares(misses, [0.0]).x[0])


def _changed_fit(after: Any = None, **changed: Any) -> Any:
    def function(pixels: Any, ground_points: Any, view: CameraView) -> float:
        found = _fitted(pixels, ground_points, view, **changed)
        return float(after(found, view)) if after else found

    return function


def _depressions(pixels: Any, ground_points: Any, view: CameraView) -> float:
    """The median of how much lower each point is seen than it should be, by angles about the camera's own axis."""
    left, up = view.rotation[:, 1], np.array([*view.offset, view.height])
    to = np.column_stack([np.asarray(ground_points), np.zeros(len(ground_points))]) - up
    u, v = ((view.undistort(pixels) - view.centre) / view.focal).T
    rays = np.column_stack([np.ones(len(u)), -u, -v]) @ view.rotation.T
    flat = [
        np.arctan2(each @ np.array([0, 0, -1.0]), each @ np.cross(left, [0, 0, 1.0])) for each in (to, rays)
    ]
    return float(np.median(flat[0] - flat[1]))


def _scanned(pixels: Any, ground_points: Any, view: CameraView) -> float:
    """By looking: a coarse grid, then finer ones."""
    middle, width = 0.0, 0.3
    for _ in range(6):
        tried = middle + np.linspace(-width, width, 41)
        costs = []
        for offset in tried:
            seen = replace(view, pitch=view.pitch + float(offset)).project(ground_points)
            costs.append(float(np.nansum((seen - pixels) ** 2)) + 1e9 * float(np.isnan(seen).any()))
        middle, width = float(tried[int(np.argmin(costs))]), width / 10
    return middle


def _bounded(pixels: Any, ground_points: Any, view: CameraView) -> Any:
    """The sum of absolute errors down the picture, minimised."""

    def cost(offset: float) -> float:
        seen = replace(view, pitch=view.pitch + offset).project(ground_points)
        return float(np.abs(np.nan_to_num(seen - pixels, nan=1e4)).sum())

    return np.float32(minimize_scalar(cost, bounds=(-0.3, 0.3), method="bounded", options={"xatol": 1e-6}).x)


def _by_range(pixels: Any, ground_points: Any, view: CameraView) -> float:
    """Ranges from the robot's middle held against ranges from below the camera, by the pinhole's own angles."""
    v = (view.undistort(pixels)[:, 1] - view.centre[1]) / view.focal[1]
    should = np.arctan2(view.height, np.hypot(*np.asarray(ground_points).T))
    return float(np.mean(should - (view.pitch + np.arctan(v))))


def _on_ground(pixels: Any, ground_points: Any, view: CameraView) -> float:
    """The least squared error of the points on the ground."""
    middle, width = 0.0, 0.3
    for _ in range(4):
        tried, costs = middle + np.linspace(-width, width, 121), []
        for offset in tried:
            misses = _ground(pixels, replace(view, pitch=view.pitch + float(offset))) - np.asarray(
                ground_points
            )
            costs.append(float(np.nan_to_num(misses**2, nan=1e9).sum()))
        middle, width = float(tried[int(np.argmin(costs))]), width / 30
    return middle


def _mean_depression(pixels: Any, ground_points: Any, view: CameraView) -> float:
    """The mean of how much lower below the horizon the points are than their rays."""
    u, v = ((view.undistort(pixels) - view.centre) / view.focal).T
    rays = np.column_stack([np.ones(len(u)), -u, -v]) @ view.rotation.T
    to = np.asarray(ground_points) - view.offset
    seen = np.arctan2(-rays[:, 2], np.hypot(rays[:, 0], rays[:, 1]))
    return float(np.mean(np.arctan2(view.height, np.hypot(*to.T)) - seen))


def _far_marks(rng: np.random.Generator, view: CameraView, offset: float) -> tuple[Array, Array, CameraView]:
    """Twenty-seven near marks that are exact in the mean, and three far ones that are all a little low."""
    near = np.column_stack([rng.uniform(0.9, 1.6, 27), rng.uniform(-0.3, 0.3, 27)])
    points = np.vstack([near, np.column_stack([rng.uniform(4.6, 5.0, 3), rng.uniform(-1, 1, 3)])])
    errors = np.vstack(
        [
            np.column_stack([rng.permutation(np.linspace(-1, 1, 27)) for _ in range(2)]),
            [[0.5, 1.5], [-0.5, 1.5], [0.0, 1.5]],
        ]
    )
    return view.project(points) + errors, points, replace(view, pitch=view.pitch - offset)


def _calibration(
    rng: np.random.Generator, view: CameraView, number: int, offset: float, noise: float = 0.0
) -> tuple[Array, Array, CameraView]:
    """Pixels of points, their places, and a view whose pitch is wrong by an offset."""
    points = ground_in_view(rng, view, number)
    errors = rng.standard_normal((number, 2))
    errors[0, 1] = 2.0  # whoever takes the first point alone is wrong
    pixels = view.project(points) + noise * errors
    return pixels, points, replace(view, pitch=view.pitch - offset)


def _pitch_public() -> list[Case]:
    rng = np.random.default_rng(47)
    plain = view_of(20.0)
    everything = any_view(np.random.default_rng(8))
    return [
        Case(_calibration(rng, plain, 6, 0.06), "a camera that looks lower than it believes"),
        Case(_calibration(rng, plain, 6, -0.05), "one that looks higher"),
        Case(_calibration(rng, plain, 1, 0.03), "a single point"),
        Case(
            _calibration(rng, everything, 8, 0.08),
            "turned, tilted and beside the robot's middle, with a lens",
        ),
        Case(_calibration(rng, view_of(14.0), 12, 0.16), "points that lie above the believed horizon"),
        Case(_calibration(rng, plain, 30, 0.05, noise=1.0), "thirty points that are a pixel off"),
        Case(_far_marks(rng, view_of(22.0), 0.05), "thirty marks about a pixel off, three of them far away"),
        Case(_calibration(rng, plain, 5, 0.0), "nothing to correct"),
    ]


def _pitch_hidden(rng: np.random.Generator) -> list[Case]:
    return [
        Case(_calibration(rng, any_view(rng), 10, float(rng.uniform(0.03, 0.1)))),
        Case(_calibration(rng, any_view(rng), 7, float(rng.uniform(-0.1, -0.03)))),
        Case(_calibration(rng, any_view(rng, (640, 480)), 5, float(rng.uniform(0.03, 0.1)))),
        Case(_calibration(rng, view_of(14.0), 12, float(rng.uniform(0.15, 0.17)))),
        Case(_far_marks(rng, view_of(rng.uniform(20, 24)), float(rng.uniform(0.03, 0.07)))),
        Case(_calibration(rng, view_of(rng.uniform(15, 25)), 40, float(rng.uniform(0.03, 0.08)), noise=1.0)),
    ]


ESTIMATE_PITCH = Exercise(
    name="estimate_pitch",
    points=5,
    stars=3,
    public=_pitch_public,
    hidden=_pitch_hidden,
    comparison=Close(rtol=0.0, atol=0.002),
    hints=(
        "One number, and something that is small where it is right: for a given offset, replace(view, pitch=view.pitch + offset).project("
        "ground_points) says where the points should be in the picture. The marked pixels say where they are.",
        "scipy.optimize.least_squares wants a function that returns the misses as one long array (.ravel()), and a start: [0.0]. Or try "
        "many offsets, and take the one with the least sum of squares.",
    ),
    mistakes=[
        Mistake(
            "the wrong sign",
            _changed_fit(lambda found, view: -found),
            "The size is right, the sign is not: view.pitch + offset should be where the camera really looks.",
        ),
        Mistake(
            "the whole pitch",
            _changed_fit(lambda found, view: view.pitch + found),
            "That is the camera's pitch. Wanted is what has to be added to view.pitch.",
        ),
        Mistake(
            "degrees",
            _changed_fit(lambda found, view: np.degrees(found)),
            "That is the offset in degrees. Radians are wanted.",
        ),
        Mistake(
            "one point alone",
            _changed_fit(one_point=True),
            "Right where all points are marked exactly. With marks that are a pixel off, your answer hangs on the first of them: use all.",
        ),
        Mistake(
            "one linear step",
            _changed_fit(one_step=True),
            "Nearly. One linear step does not arrive, for the picture bends with the angle: begin again from where it led, until nothing changes.",
        ),
        Mistake(
            "least squares on the ground",
            _on_ground,
            "You compare on the ground, where one pixel is worth decimetres far away: a few far marks decide. Compare in the picture, by view.project: "
            "there all marks are equally good.",
        ),
        Mistake(
            "angles below the horizon",
            _mean_depression,
            "You compare angles below the horizon. They grow by the whole offset only straight ahead of the camera; to the side of it by less. Let view.project do the geometry.",
        ),
        Mistake(
            "the lens left in",
            _changed_fit(no_lens=True),
            "Right without a lens. With one your offset makes up for it; view.project knows the lens, and view.undistort removes it.",
        ),
        Mistake(
            "the head's yaw forgotten",
            _changed_fit(no_yaw=True),
            "Right while the head looks ahead. The ground points are in the robot frame, the camera may look to the side: view.yaw.",
        ),
        Mistake(
            "ranges from the robot",
            _by_range,
            "You treat each pixel as if it were in the middle column, below a camera at the robot's middle. To the sides, and with an offset, "
            "that is not so: let view.project or your pixel_to_ground do the geometry.",
        ),
        Mistake(
            "nothing",
            lambda pixels, ground_points, view: 0.0,
            "Your offset is 0, which leaves the camera where it is. Does a search begin and end at its start?",
        ),
    ],
    alternatives={
        "a grid that gets finer": _scanned,
        "absolute errors, float32": _bounded,
        "the median of the angles": _depressions,
    },
    equivalents={
        "return (replace(view, pitch=view.pitch + offset[-1]).project(ground_points) - pixels).ravel()": "of one number the last is the first",
        "return float(least_squares(misses, [0.0]).x[-1])": "of one number the last is the first",
        "return least_squares(misses, [0.0]).x[0]": "a number of NumPy's is a number",
        "return (pixels - replace(view, pitch=view.pitch + offset[0]).project(ground_points)).ravel()": "the square of a difference does not depend on its order",
    },
)


PLAN = LessonPlan(
    exercises=[
        GROUND_TO_MEASUREMENT,
        PAPER_DISTANCE,
        PAPER_BEARING,
        PIXEL_TO_GROUND,
        RANGE_SIGMA,
        MEASUREMENT_COVARIANCE,
        ESTIMATE_PITCH,
    ],
    questions=[
        Question(
            "why_no_balance",
            "One tilt has a standard deviation of 3 degrees, another of 4, and they are independent. What has their sum?",
            {
                "1 degree: they balance each other out.": "They would have to be opposite in every picture. Independent errors are opposite in half of "
                "them, and in the other half they add up.",
                "5 degrees.": "The variances 9 and 16 add up to 25. It is less than 7, for sometimes they are opposite, and more than 4, for in the other half "
                "they add up.",
                "7 degrees: errors add up.": "That is the worst case of one picture, both at their deviation and on the same side. The typical sum is "
                "smaller: variances add, not deviations.",
                "3.5 degrees, the mean.": "A sum is no mean. Even the smaller of two independent errors makes the sum worse than the larger one alone.",
            },
            "5 degrees.",
        ),
        Question(
            "what_helps",
            "At 3 m a mark is 1 pixel off at 320 x 240, and the tilt has a deviation of 0.7 degrees. What makes the range clearly better?",
            {
                "Pictures of 1280 x 960.": "They turn 7 cm into 2. The tilt's 23 cm stay, and the root of the squares' sum goes from 25 to 24 cm.",
                "The mean of three landmarks in the same picture.": "They share the picture's tilt: three ranges that are all too long have a mean that is too long.",
                "The mean of three pictures.": "Each picture has a lean of its own, so the mean of three is better by the root of three: 14 cm. A calibration has to "
                "come first, for what stays in all pictures stays in their mean.",
            },
            "The mean of three pictures.",
        ),
    ],
    written=[
        Written(
            "explain_shared_tilt",
            points=2,
            question="Why would it be wrong to give each of three landmarks in one picture its own variance, and leave the rest of R zero?",
            rubric="1 point: the tilt of a picture is one error for all its landmarks, so their ranges are wrong in the same direction (correlated). 1 point: "
            "taken for independent, they are averaged, and the result is believed to be better than it is (overconfident).",
        )
    ],
)
