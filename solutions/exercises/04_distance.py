"""Exercises of lesson 04, distance, with common mistakes and alternative correct solutions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.optimize import minimize_scalar

from nao_course.exercises import All, Case, Close, Exercise, LessonPlan, Property, Question, Sibling, Written
from nao_course.instructor.authoring.mistakes import catalogue
from nao_course.lessons.distance import personal_numbers
from nao_course.lessons.distance.calibration import small_angle
from nao_course.sim import NAO_V4, CameraView

Array = npt.NDArray[Any]


# --- cameras and pixels for the cases ---
def view_of(degrees: float, **values: Any) -> CameraView:
    """Return a NAO's bottom camera with this pitch in degrees and without a lens term."""
    given = {"size": (320, 240), "hfov": 1.04, "vfov": 0.82, "height": 0.48} | values
    return CameraView(pitch=float(np.radians(degrees)), **given)


def any_view(rng: np.random.Generator, size: tuple[int, int] = (320, 240)) -> CameraView:
    """Return a view with random values for all parameters."""
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
    """Return random pixels in a picture, without its upper part `top`."""
    width, height = view.size
    return np.column_stack([rng.uniform(0, width - 1, number), rng.uniform(top * height, height - 1, number)])


def ground_in_view(rng: np.random.Generator, view: CameraView, number: int) -> Array:
    """Return visible points (number, 2) of the ground in the robot frame, 0.8 to 5 m away."""
    found = np.zeros((0, 2))
    while len(found) < number:
        bearing, away = view.yaw + rng.uniform(-0.5, 0.5, 400), rng.uniform(0.8, 5.0, 400)
        points = away[:, None] * np.column_stack([np.cos(bearing), np.sin(bearing)])
        found = np.vstack([found, points[view.contains(view.project(points))]])
    return found[:number]


def in_view(rng: np.random.Generator, view: CameraView, number: int) -> Array:
    """Return pixels (number, 2) of points on the ground."""
    return view.project(ground_in_view(rng, view, number))


def single(function: Callable[..., Any]) -> Callable[..., Any]:
    """Return the same function in single precision."""
    return lambda *given: np.float32(function(*given))


# --- 4.1 ground_to_measurement ---
def _measured(points: Any) -> Array:
    points = np.asarray(points, dtype=float)
    return np.array([[np.arctan2(y, x), np.sqrt(x * x + y * y)] for x, y in points]).reshape(-1, 2)


MEASUREMENT = Exercise(
    name="ground_to_measurement",
    points=1,
    public=lambda: [
        Case((np.array([[1.0, 0.0], [0.0, 2.0], [3.0, 4.0]]),), "ahead, to the left, and both"),
        Case((np.array([[1.0, -1.0], [-1.0, 0.5], [-2.0, -2.0]]),), "to the right, and behind the robot"),
        Case((np.array([[-3.0, 0.0]]),), "straight behind the robot"),
        Case((np.array([[2.0, 1.0], [np.nan, np.nan]]),), "a row of NaN stays NaN"),
        Case((np.random.default_rng(41).uniform(-4, 4, (12, 2)),), "random points"),
        Case((np.zeros((0, 2)),), "no points"),
    ],
    hidden=lambda rng: [
        Case((rng.uniform(-5, 5, (40, 2)),)),
        Case((np.array([rng.uniform([1, -2], [2, -1]), [np.nan, np.nan], [-1.0, rng.uniform(0.1, 1)]]),)),
        Case((rng.uniform(0.5, 3, (1, 2)),)),
        Case((np.array([[-float(rng.uniform(1, 4)), 0.0], [2.0, 1.0]]),)),
        Case((np.zeros((0, 2)),)),
    ],
    comparison=Close(rtol=1e-4, atol=1e-5, names=("your bearing", "your range")),
    hints=(
        "points[:, 0] is x (ahead) and points[:, 1] is y (to the left). np.arctan2 and np.hypot accept whole columns.",
        "np.arctan2 takes y first. np.column_stack puts two columns side by side.",
    ),
    sibling=Sibling(
        "Two columns become an angle and a length; the second argument of np.arctan2 is the axis at which the angle is 0, here north, because a compass counts from there.",
        """
        import numpy as np

        wind = np.array([[3.0, 4.0], [0.0, -2.0], [-1.0, 0.0]])  # east and north, m/s
        east, north = wind.T
        print(np.stack([np.degrees(np.arctan2(east, north)), np.hypot(east, north)], axis=1).round(1))
        """,
        """
        [[ 36.9   5. ]
         [180.    2. ]
         [-90.    1. ]]
        """,
    ),
    mistakes=catalogue("""
        range first: ])]) => ])])[:, ::-1]
            Your columns are (range, bearing). A measurement in this course is (bearing, range).
        degrees: np.arctan2(points[:, 1], points[:, 0]) => np.degrees(np.arctan2(points[:, 1], points[:, 0]))
            Your bearings are in degrees. Return radians.
        positive to the right: arctan2(points => arctan2(-points
            Your bearings have the wrong sign. They are positive to the left, where y is positive.
        arctan of the quotient: arctan2(points[:, 1], points[:, 0]) => arctan(points[:, 1] / points[:, 0])
            arctan(y / x) gives the same angle for (x, y) and (-x, -y). Use np.arctan2(y, x), which distinguishes them.
        x and y exchanged: arctan2(points[:, 1], points[:, 0]) => arctan2(points[:, 0], points[:, 1])
            Your bearings are measured from the y axis. np.arctan2 takes y first, then x.
        root forgotten: np.hypot(points[:, 0], points[:, 1]) => points[:, 0] ** 2 + points[:, 1] ** 2
            Your range is the squared distance. Take the square root.
        x for the range: np.hypot(points[:, 0], points[:, 1]) => points[:, 0]
            Your range is x. It should be the distance, the square root of x * x + y * y.
        all round: points[:, 0]), => points[:, 0]) % (2 * np.pi),
            Your bearings are between 0 and 2 pi. They should be in (-pi, pi], negative to the right of the robot, as np.arctan2 returns them.
        the sign of y times arccos: np.arctan2(points[:, 1], points[:, 0]) => np.sign(points[:, 1]) * np.arccos(points[:, 0] / np.hypot(*points.T))
            Your bearing is 0 if y is 0, because np.sign(0) is 0. A point straight behind the robot is at pi: use np.arctan2(y, x).
        arcsin: np.arctan2(points[:, 1], points[:, 0]) => np.arcsin(points[:, 1] / np.hypot(*points.T))
            arcsin(y / r) does not depend on the sign of x, so points ahead and behind get the same angle. Use np.arctan2(y, x).
        one range for all: np.hypot(points[:, 0], points[:, 1]) => np.full(len(points), np.linalg.norm(points))
            Your range is a single number for all points. np.linalg.norm(points) needs axis=1, or use np.hypot(x, y).
        two rows: ])]) => ])]).T
            Your answer has shape (2, N). Return one row for each point, shape (N, 2).
        an empty list: return => found =
            + return np.array(found.tolist())
            Without points your answer is an empty list, shape (0,). It should have shape (0, 2): compute with whole columns, or add .reshape(-1, 2).
        rows of NaN removed: + points = points[~np.isnan(points).any(axis=1)]
            You remove the rows of NaN, so rows and points no longer correspond. Keep these rows; np.arctan2 and np.hypot return NaN for them.
        rows for columns: points[:, 0] =>> points[0]
            points[:, 1] =>> points[1]
            points[0] is the first point, not all x. The columns are points[:, 0] and points[:, 1].
        one number beside a column: np.hypot(points[:, 0], points[:, 1]) => np.linalg.norm(points)
            np.linalg.norm(points) is a single number for the whole array. Use axis=1, or np.hypot(x, y).
    """),
    alternatives={
        "complex numbers": lambda points: np.stack([np.angle(points @ [1, 1j]), abs(points @ [1, 1j])], 1),
        "point by point": _measured,
        "float32": single(_measured),
    },
    equivalents={
        "return np.column_stack([np.arctan2(points[:, 1], points[:, 0]), np.hypot(points[:, 1], points[:, 0])])": "a sum does not depend on its order"
    },
)


# --- 4.2 paper_distance and 4.3 paper_bearing ---
def _distance_loop(pixels: Array, view: CameraView) -> list[float]:
    (width, height), found = view.size, []
    for u, v in pixels:
        down = view.pitch + ((v + 0.5) / height - 0.5) * view.vfov  # below the horizon
        found.append(float(view.height / np.tan(down) / np.cos(((u + 0.5) / width - 0.5) * view.hfov)))
    return found


def _distance_sines(pixels: Array, view: CameraView) -> Array:
    right, below = ((pixels - view.centre) / view.size * [view.hfov, view.vfov]).T
    return view.height * np.cos(view.pitch + below) / (np.sin(view.pitch + below) * np.cos(right))


def _bearing_interpolated(pixels: Array, view: CameraView) -> Array:
    width, half = view.size[0], view.hfov / 2
    return np.interp(pixels[:, 0], [-0.5, width - 0.5], [half, -half])


def _paper_public() -> list[Case]:
    small, unknown = (
        view_of(35.0, size=(64, 32)),
        "a turned and tilted head, with a lens, which the paper ignores",
    )
    turned = view_of(30.0, yaw=0.6, roll=0.1, offset=(0.05, 0.02), k1=-0.08)
    cases = [
        ("the middle of a picture, 45 degrees down", [[159.5, 119.5]], view_of(45.0)),
        ("corners at the bottom", [[0.0, 239.0], [319.0, 239.0], [40.0, 130.0]], view_of(25.0)),
        (unknown, [[100.0, 150.0], [250.0, 200.0]], turned),
        ("a picture of 64 x 32", pixels_in(np.random.default_rng(42), small, 6), small),
        ("above the horizon", [[60.0, 5.0], [300.0, 20.0]], view_of(5.0)),
        ("a picture of 65 x 49", [[12.0, 30.0], [60.0, 45.0]], view_of(40.0, size=(65, 49))),
        ("no pixels", np.zeros((0, 2)), view_of(25.0)),
    ]
    return [Case((np.array(pixels), view), name) for name, pixels, view in cases]


def _paper_hidden(rng: np.random.Generator) -> list[Case]:
    views = [any_view(rng), any_view(rng, (640, 480)), view_of(rng.uniform(30, 50))]
    return [
        *(Case((pixels_in(rng, view, 15, top=0.3), view)) for view in views),
        Case((np.array([[rng.uniform(0, 300), 10.0]]), view_of(rng.uniform(3, 6)))),
        Case((rng.uniform(20, 200, (3, 2)), view_of(rng.uniform(35, 45), size=(321, 241)))),
        Case((np.zeros((0, 2)), views[0])),
    ]


DISTANCE = Exercise(
    name="paper_distance",
    points=2,
    public=_paper_public,
    hidden=_paper_hidden,
    comparison=Close(rtol=1e-4, atol=1e-6),
    hints=(
        "Write equation 4.1 in parts, each with its own name: x and y, the two angles, the distance. Start with columns, rows = view.size; view.height is something else, the height of the camera in metres.",
        "The camera's angle from straight down is np.pi / 2 - view.pitch. The paper's y counts from the lower edge of the picture: y = n_v - 1 / 2 - v, with the number of rows n_v and v = pixels[:, 1].",
    ),
    sibling=Sibling(
        "Rows are counted from the top, but the scale begins at the lower edge, and a pixel shows the value at its middle, half a row from its edge.",
        """
        import numpy as np

        rows, lowest, highest = 50, -10.0, 40.0  # a picture of a thermometer's scale
        step = (highest - lowest) / rows  # degrees of one row
        v = np.array([0, 24, 49])
        from_below = rows - v - 0.5
        print(lowest + step * from_below)
        """,
        "[39.5 15.5 -9.5]",
    ),
    mistakes=catalogue("""
        horizon for nadir: np.pi / 2 - view.pitch => view.pitch
            You use view.pitch as the paper's camera angle. The pitch is measured from the horizon, but the paper's angle from straight down: np.pi / 2 - view.pitch.
        v counted from the top: height - 0.5 - pixels[:, 1] => pixels[:, 1] + 0.5
            Your distances increase downwards in the picture. v counts from the top, but the paper's y from the bottom.
        pixels as they are: height - 0.5 - pixels[:, 1] => pixels[:, 1]
            pixels[:, 0] + 0.5 => pixels[:, 0]
            You use u and v as x and y. The paper's y counts from the lower edge of the picture: x = u + 1/2, y = height - 1/2 - v.
        columns half a pixel off: pixels[:, 0] + 0.5 => pixels[:, 0]
            Your columns are half a pixel off. Use x = u + 1/2.
        rows half a pixel off: height - 0.5 => height - 1
            Your rows are half a pixel off. The centre of row v is half a pixel below its upper edge, so y = height - 1/2 - v.
        rows half a pixel too high: height - 0.5 => height
            Your rows are half a pixel off. y counts from the lower edge of the picture to the centre of row v, so y = height - 1/2 - v and not height - v.
        y is v: height - 0.5 - pixels[:, 1] => pixels[:, 1]
            You use v as the paper's y. v counts from the upper edge of the picture, but y from the lower edge: y = height - 1/2 - v, with the height in pixels.
        pi / 2 plus the pitch: np.pi / 2 - view.pitch => np.pi / 2 + view.pitch
            You add the pitch. A camera that is pitched down by view.pitch looks at the angle np.pi / 2 - view.pitch from straight down.
        90 degrees: np.pi / 2 - view.pitch => 90 - view.pitch
            You subtract radians from 90 degrees. A right angle is np.pi / 2 in radians.
        divided by the tangent: view.height * np.tan(vertical) / np => view.height / np.tan(vertical) / np
            You divide by the tangent. The angle is measured from straight down, so multiply the height by its tangent.
        sine for tangent: np.tan(vertical) => np.sin(vertical)
            You use a sine. The distance over the ground is the height times the tangent of the angle from straight down.
        hfov twice: view.vfov =>> view.hfov
            You use hfov for the rows as well. view.vfov belongs to v and the height of the picture.
        the picture's height: view.height * np.tan => height * np.tan
            You multiply by the height of the picture in pixels. Multiply by view.height, the height of the camera in metres.
        width and height exchanged: width, height => height, width
            You exchanged width and height. view.size is (width, height), unlike the shape of an array.
        half the field not taken off: view.pitch - view.vfov / 2 => view.pitch
            You measure angles from the optical axis. The paper starts at the bottom of the picture, half a field of view below it.
        half the field added: - view.vfov / 2 => + view.vfov / 2
            You add half the field of view. The bottom of the picture is nearer to straight down, so subtract it.
        half a pixel: height - 0.5 => height
            pixels[:, 0] + 0.5 => pixels[:, 0]
            You are half a pixel off. The centre of pixel 0 is half a pixel from the edge of the picture, so x = u + 1/2 and y = height - 1/2 - v.
        absolute values: return view.height * np.tan(vertical) / np.cos(horizontal) => return np.abs(view.height * np.tan(vertical) / np.cos(horizontal))
            You return absolute values. Above the horizon the paper's formula gives a negative distance; return it as it is.
        NaN above the horizon: return view.height => distance = view.height
            + return np.where(distance > 0, distance, np.nan)
            You return NaN above the horizon. The paper's formula gives a negative distance there; return it as it is.
        cosine forgotten: np.tan(vertical) / np.cos(horizontal) => np.tan(vertical)
            Your distances are right only in the middle column. To the sides a point is farther away: divide by the cosine.
        times the cosine: / np.cos => * np.cos
            You multiply by the cosine, so points at the sides become nearer. Divide by it.
        fields of view exchanged: + view = replace(view, hfov=view.vfov, vfov=view.hfov)
            You exchanged the two fields of view. hfov belongs to u and the width, vfov to v and the height.
        degrees: np.tan(vertical) / np.cos(horizontal) => np.tan(np.degrees(vertical)) / np.cos(np.degrees(horizontal))
            You compute in degrees. The angles of the view are in radians, and np.tan and np.cos need radians.
        height forgotten: view.height * np.tan => np.tan
            Your distances are in units of the camera's height. Multiply by view.height.
        a pinhole's angles: + right, below = np.arctan((pixels - view.centre) / view.focal).T
            + return view.height * np.tan(np.pi / 2 - view.pitch - below) / np.cos(right)
            You compute the angles of a pinhole camera, which are exact. The paper's angles are proportional to pixels, so use equation 4.1 here. The exact geometry follows in exercise 4.4.
        the lens removed: + pixels = view.undistort(pixels)
            You remove the lens distortion, but the paper does not. Use the pixels as they are.
        the head's yaw: np.cos(horizontal) => np.cos(horizontal - view.yaw)
            You use the head's yaw. The paper's horizontal angle is measured from the middle of the picture.
        rows for columns: pixels[:, 0] => pixels[0]
            pixels[:, 1] => pixels[1]
            pixels[0] is the first pixel, not all u. The columns are pixels[:, 0] and pixels[:, 1].
        taken for degrees: np.tan(vertical) / np.cos(horizontal) => np.tan(np.radians(vertical)) / np.cos(np.radians(horizontal))
            You convert the angles to radians, but all angles of the view are in radians already.
    """),
    alternatives={"a loop": _distance_loop, "sines": _distance_sines, "float32": single(_distance_sines)},
    equivalents={
        "horizontal = (width / 2 - (pixels[:, 0] + 0.5)) * view.hfov / width": "the cosine is symmetric"
    },
)

BEARING = Exercise(
    name="paper_bearing",
    points=1,
    public=_paper_public,
    hidden=_paper_hidden,
    comparison=Close(rtol=1e-4, atol=1e-6),
    hints=(
        "It is the paper's horizontal angle with one change: bearings in this course are positive to the left.",
        "u increases to the right, so a pixel left of the middle has a negative offset and a positive bearing.",
    ),
    sibling=Sibling(
        "Positions are counted from one edge, and their offsets from the middle are needed, positive in the opposite direction.",
        """
        import numpy as np

        shelf = np.arange(6)  # counted downwards from 0
        middle = (6 - 1) / 2  # between shelf 2 and shelf 3
        print((middle - shelf) * 0.3)  # metres above the middle
        """,
        "[ 0.75  0.45  0.15 -0.15 -0.45 -0.75]",
    ),
    mistakes=catalogue("""
        positive to the right: return (width => return -(width
            Your bearings are positive to the right, like the paper's angle. In this course they are positive to the left.
        degrees: * view.hfov => * np.degrees(view.hfov)
            Your bearings are in degrees. Return radians.
        half a pixel: width / 2 - 0.5 => width / 2
            You are half a pixel off. The centre of pixel 0 is half a pixel from the edge, so x = u + 1/2.
        fields of view exchanged: view.hfov => view.vfov
            You exchanged the two fields of view. hfov belongs to u and the width, vfov to v and the height.
        the height for the width: view.size[0] => view.size[1]
            You use the height of the picture. view.size is (width, height), unlike the shape of an array.
        the row: pixels[:, 0] => pixels[:, 1]
            You use v. A bearing depends on the column, u = pixels[:, 0].
        the head's yaw: view.hfov / width => view.hfov / width + view.yaw
            You add the head's yaw. That would be exact, but the paper ignores a turned head, so leave it out here.
        a pinhole's angles: + return -np.arctan((pixels[:, 0] - view.centre[0]) / view.focal[0])
            You compute the angles of a pinhole camera, which are exact. The paper's angles are proportional to pixels, so use equation 4.1 here. The exact geometry follows in exercise 4.4.
        the lens removed: + pixels = view.undistort(pixels)
            You remove the lens distortion, but the paper does not. Use the pixels as they are.
        from the left edge: width / 2 - 0.5 - pixels => -0.5 - pixels
            Your angle is 0 at the left edge of the picture. It should be 0 in the middle: subtract half the width first.
        without a sign: return (width / 2 - 0.5 - pixels[:, 0]) => return np.abs(width / 2 - 0.5 - pixels[:, 0])
            Your bearings have no sign, so left and right give the same value. They are negative to the right.
        one pixel too few: hfov / width => hfov / (width - 1)
            You divide by the width minus one. The field of view spans all pixels from edge to edge, so divide by the width.
        brackets: (width / 2 - 0.5 - pixels[:, 0]) => width / 2 - (0.5 + pixels[:, 0])
            Brackets are missing. Compute the difference of the pixels first, and then multiply it by the angle per pixel.
        a row for a column: pixels[:, 0] => pixels[0]
            pixels[0] is the first pixel, not all u. The columns are pixels[:, 0] and pixels[:, 1].
        a width of 320: width = view.size[0] => width = 320
            Your bearings are right only in pictures that are 320 pixels wide. The width is view.size[0].
        the middle at 159.5: width / 2 - 0.5 - pixels => 159.5 - pixels
            Your middle, 159.5, is right only in pictures that are 320 pixels wide. Compute it from view.size[0].
        twice the angle: view.hfov => 2 * view.hfov
            Your angles are twice as large as they should be. The field of view spans the whole width, not half of it.
    """),
    alternatives={
        "a loop": lambda pixels, view: [(0.5 - (u + 0.5) / view.size[0]) * view.hfov for u, _ in pixels],
        "interpolated": _bearing_interpolated,
        "float32": single(_bearing_interpolated),
    },
)


# --- 4.4 pixel_to_ground ---
def _rays(pixels: Array, view: CameraView) -> list[Array]:
    return [view.rotation @ (1.0, -u, -v) for u, v in (view.undistort(pixels) - view.centre) / view.focal]


def _by_angles(pixels: Array, view: CameraView) -> Array:
    """Compute the depression angle and direction of each ray."""
    found = []
    for x, y, z in _rays(pixels, view):
        down = np.arctan2(-z, np.hypot(x, y))
        away, along = view.height / np.tan(down) if down > 0 else np.nan, np.arctan2(y, x)
        found.append([view.offset[0] + away * np.cos(along), view.offset[1] + away * np.sin(along)])
    return np.array(found).reshape(-1, 2)


def _by_equations(pixels: Array, view: CameraView) -> Array:
    """Solve three equations for x, y and the length of the ray."""
    found = np.full((len(pixels), 2), np.nan)
    for point, ray in zip(found, _rays(pixels, view), strict=True):
        if ray[2] < 0:
            point[:] = np.linalg.solve(np.column_stack([np.eye(3)[:, :2], -ray]), view.position)[:2]
    return found


def _level_rows() -> tuple[Array, CameraView]:
    """Return pixels above, at and below the horizon of a level camera, in rows 119, 120 and 121."""
    return np.array([[30.0, 60.0], [80.0, 119.0], [200.0, 120.0], [50.0, 121.0], [160.0, 200.0]]), view_of(
        0.0, size=(321, 241), vfov=0.8
    )


def _ground_public() -> list[Case]:
    rng = np.random.default_rng(44)
    two, lens = [[60.0, 180.0], [250.0, 100.0]], view_of(28.0, k1=-0.08)
    everything = any_view(np.random.default_rng(5))
    walking = NAO_V4.view("bottom", 0.4, -0.4, torso_pitch=0.03, torso_roll=-0.04)
    shoulder = view_of(12.0, yaw=1.95, offset=(0.05, 0.01))
    cases = [
        ("the middle of a picture, 45 degrees down", [[159.5, 119.5]], view_of(45.0)),
        ("left, right and near", [*two, [30.0, 230.0]], view_of(25.0)),
        ("the head turned to the left", two, view_of(25.0, yaw=0.7)),
        ("the head tilted sideways", two, view_of(25.0, roll=0.12)),
        ("with a lens", [[10.0, 230.0], [300.0, 60.0]], lens),
        ("the camera beside the robot's centre", two, view_of(25.0, offset=(0.06, 0.02))),
        ("a larger picture, a higher camera", two[:1], view_of(30.0, height=0.6, size=(640, 480))),
        ("above, at and below the horizon", *_level_rows()),
        ("the head turned past the shoulder", [two[0], [150.0, 30.0], [250.0, 120.0]], shoulder),
        ("all at once", pixels_in(rng, everything, 6), everything),
        ("a tilted NAO", pixels_in(rng, walking, 5), walking),
        ("no pixels", np.zeros((0, 2)), lens),
    ]
    return [Case((np.array(pixels), view), name) for name, pixels, view in cases]


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


GROUND = Exercise(
    name="pixel_to_ground",
    points=4,
    stars=2,
    public=_ground_public,
    hidden=_ground_hidden,
    comparison=Close(rtol=1e-4, atol=1e-5),
    hints=(
        "There are three steps, each for all pixels at once: seen = view.undistort(pixels); the rays (1, -(u - cu) / fu, -(v - cv) / fv) as an array (N, 3); the rays in the robot frame, rays @ view.rotation.T.",
        "A ray (x, y, z) goes down if z < 0, and it reaches the ground at t = view.height / -z. Replace z by NaN where it is not negative before you divide, and then add view.offset.",
    ),
    sibling=Sibling(
        "Each ray is multiplied by the factor that brings it to a plane, here a wall at x = 4, and a ray that never gets there becomes NaN before the division.",
        """
        import numpy as np

        lamp = np.array([1.0, 0.0, 2.0])
        rays = np.array([[1.0, 0.5, -0.2], [-1.0, 0.3, 0.0], [2.0, 0.0, 1.0]])
        towards = np.where(rays[:, 0] > 0, rays[:, 0], np.nan)
        factor = (4 - lamp[0]) / towards
        print(lamp + factor[:, None] * rays)
        """,
        """
        [[4.  1.5 1.4]
         [nan nan nan]
         [4.  0.  3.5]]
        """,
    ),
    mistakes=catalogue("""
        the head's yaw forgotten: + view = replace(view, yaw=0.0)
            You do not use the camera's yaw, so your points are wrong if the head is turned. view.rotation contains all three angles.
        roll forgotten: + view = replace(view, roll=0.0)
            You do not use view.roll, so your points are wrong if the camera is tilted sideways. view.rotation contains all three angles.
        offset forgotten: np.array(view.offset) + view.height => view.height
            Your points are relative to the point below the camera. In the robot frame the camera is at view.offset, so add it.
        the lens left in: view.undistort(pixels) => pixels
            Your points are right only without lens distortion. Remove it first with view.undistort(pixels).
        the lens the wrong way round: undistort => distort
            view.distort adds lens distortion, which the pixels already have. view.undistort removes it.
        the ray's sign: view.height * rays[:, :2] / falling => view.height * rays[:, :2] / -falling
            Your points are on the opposite side of the camera. The ray goes down by -d_z, so divide the height by -d_z and not by d_z.
        behind the robot: np.where(rays[:, 2] < 0, -rays[:, 2], np.nan) => -rays[:, 2]
            Above the horizon you return points behind the robot, although the ray never reaches the ground. Return NaN there.
        the condition reversed: rays[:, 2] < 0 => rays[:, 2] > 0
            You return NaN for the pixels that show the ground. A ray goes down if its third component is negative.
        (y, x): return => ground =
            + return ground[:, ::-1]
            Your points are (y, x). Return (x, y): x is ahead, y to the left.
        offset swapped: np.array(view.offset) => np.array(view.offset)[::-1]
            You exchanged the two numbers of view.offset. It is (ahead, left), like the points.
        only ahead: rays[:, 2] < 0 => (rays[:, 2] < 0) & (rays[:, 0] >= 0)
            You return NaN for points behind the robot's centre, but the robot sees them if its head is turned past the shoulder. Only rays whose third component is not negative become NaN.
        a level ray: rays[:, 2] < 0 => rays[:, 2] <= 0
            At the horizon the third component of the ray is 0, so it never reaches the ground either. Return NaN there, too.
        focal lengths exchanged: view.focal => view.focal[::-1]
            You exchanged the focal lengths. view.focal is (fu, fv), and fu belongs to u.
        offset taken off: np.array(view.offset) => -np.array(view.offset)
            You subtract view.offset. The camera is there, so add it.
        offset turned: np.array(view.offset) => replace(view, pitch=0.0, roll=0.0).rotation[:2, :2] @ view.offset
            You rotate view.offset with the head. It is given in the robot frame, so add it without rotation.
        zero above the horizon: np.nan => np.inf
            Above the horizon you return the point below the camera, but there is no point. Return NaN.
        left out above the horizon: np.nan => np.nan
            + rays, falling = rays[falling > 0], falling[falling > 0]
            You remove pixels above the horizon, so rows and pixels no longer correspond. Keep their rows, with NaN.
        rotated back: view.rotation.T => view.rotation
            You rotate the rays in the wrong direction. If the rays are rows, use rays @ view.rotation.T.
        v upwards: -below => below
            A minus sign is missing: v increases downwards, but the third component of the ray upwards.
        positive to the right: -right => right
            A minus sign is missing: u increases to the right, but y to the left.
        half a pixel: view.centre => np.array(view.size) / 2
            You are half a pixel off. The centre of the picture is view.centre, half a pixel less than half its size.
        one focal length: view.focal => view.focal[0]
            You use one focal length for both directions. view.focal has two, which differ if pixels are not square.
        height forgotten: view.height * rays => rays
            You do not use view.height, so your points are right only for a camera 1 m above the ground.
        three coordinates: np.array(view.offset) + view.height * rays[:, :2] => view.position + view.height * rays
            You return (x, y, z). Return x and y only, shape (N, 2), because z is 0 for every point of the ground.
        an empty list: return => found =
            + return np.array(found.tolist())
            Without pixels your answer is an empty list, shape (0,). It should have shape (0, 2): add .reshape(-1, 2), or compute with whole columns.
        height along the ray: -rays[:, 2], np.nan => np.linalg.norm(rays, axis=1), np.nan
            You move by view.height along the ray. The ray has to go down by this height, so divide by -z.
        u and v exchanged: right, below = => below, right =
            You exchanged u and v. The second component of the ray depends on u, and the third on v.
        rotations in another order: view.rotation.T => (replace(view, yaw=0.0, roll=0.0).rotation @ replace(view, pitch=0.0, roll=0.0).rotation @ replace(view, pitch=0.0, yaw=0.0).rotation).T
            You multiply the rotations in the wrong order. view.rotation is their product in the right order.
    """),
    alternatives={"angles": _by_angles, "equations": _by_equations, "float32": single(_by_angles)},
    equivalents={
        "return view.offset + view.height * rays[:, :2] / falling[:, None]": "NumPy converts a tuple to an array"
    },
)


# --- 4.5 range_sigma ---
SIGMA = Exercise(
    name="range_sigma",
    points=2,
    stars=2,
    public=lambda: [
        Case((2.0, 0.5, 0.02), "2 m away, half a metre up"),
        Case((0.5, 0.5, 0.02), "45 degrees down"),
        Case((4.0, 0.48, float(np.radians(1.0))), "4 m away, one degree"),
        Case((0.0, 0.6, 0.01), "straight below"),
        Case((1.0, 1.6, 0.01), "a camera that is higher than the range"),
        Case((1.0, 0.5, 0.3), "a large angle, still to first order"),
    ],
    hidden=lambda rng: [
        *(Case(tuple(map(float, rng.uniform([0.1, 0.3, 0.001], [6, 1.8, 0.05])))) for _ in range(8)),
        Case((0.0, float(rng.uniform(0.4, 2)), 0.02)),
        Case((float(rng.uniform(1, 2)), 0.5, float(rng.uniform(0.2, 0.4)))),
    ],
    comparison=Close(rtol=1e-4),
    hints=(
        "The derivative of 1 / tan(x) is -1 / sin(x) ** 2. Use its absolute value, because a standard deviation has no sign.",
        "Eliminate the angle: in the right triangle of the camera, the point below it and the landmark, its sine is the height divided by the length of the line of sight. Check the example of the docstring on paper.",
    ),
    sibling=Sibling(
        "A standard deviation is multiplied by the size of a derivative, and the measured quantity, here the time, is eliminated with the formula itself.",
        """
        metres, speed, time_sigma = 100.0, 8.0, 0.1  # speed = metres / time, the time is measured
        time = metres / speed
        by_difference = (metres / (time - 1e-4) - metres / (time + 1e-4)) / 2e-4
        by_formula = speed**2 / metres  # metres / time**2, with time = metres / speed
        print(f"{by_difference * time_sigma:.4f} and {by_formula * time_sigma:.4f} m/s")
        """,
        "0.0640 and 0.0640 m/s",
    ),
    mistakes=catalogue("""
        r squared not divided: (height**2 + range_m**2) / height => (height + range_m**2)
            You add h and r squared, a length and an area. Both terms of the sum are squares, and the whole sum is divided by h.
        r squared over h alone: (height**2 + range_m**2) => range_m**2
            You leave out h squared. r squared over h is accurate only far away; straight below the camera a tilt still moves the point by h times the angle.
        one over the cosine squared: (height**2 + range_m**2) / height => height / np.cos(np.arctan2(height, range_m)) ** 2
            You divide by the squared cosine, which belongs to the derivative of tan. The derivative of 1 / tan(x) is -1 / sin(x) ** 2.
        times the height: / height => * height
            You multiply by the height. Divide by it: in h / sin(x) ** 2, the squared sine is h squared divided by h squared plus r squared.
        root of the sum: (height**2 + range_m**2) => np.hypot(height, range_m)
            You take a square root of h squared plus r squared. The squared sine contains this sum itself, so there is no root.
        h squared alone: (height**2 + range_m**2) => height**2
            You leave out r squared. Your result does not depend on the range, but the same tilt moves a distant point farther.
        a variance: return (height**2 + range_m**2) / height * tilt_sigma => return ((height**2 + range_m**2) / height * tilt_sigma) ** 2
            You return the variance in square metres. Return its square root.
        the angle in degrees: * tilt_sigma => * np.degrees(tilt_sigma)
            You convert tilt_sigma to degrees. The derivative is in metres per radian.
        the line of sight: (height**2 + range_m**2) / height => np.hypot(height, range_m)
            Your result is the movement across the line of sight. The line of sight meets the ground at an angle, so the point moves farther along the ground.
        divided by r: / height => / range_m
            You divide by the range. Divide by the height: the lower the camera, the larger the error.
        tilt forgotten: / height * tilt_sigma => / height
            You return the derivative in metres per radian. Multiply it by tilt_sigma.
        brackets: (height**2 + range_m**2) => height**2 + range_m**2
            Brackets are missing. Divide the whole sum by the height.
        taken for degrees: * tilt_sigma => * np.radians(tilt_sigma)
            You convert tilt_sigma to radians, but it is in radians already.
        tilt squared: * tilt_sigma => * tilt_sigma**2
            You square tilt_sigma. A standard deviation is multiplied by the derivative; only variances are multiplied by its square.
        the sine of the tilt: * tilt_sigma => * np.sin(tilt_sigma)
            You use the sine of tilt_sigma. To first order, multiply by tilt_sigma itself.
        one exact tilt: + return height / np.tan(np.arctan2(height, range_m) - tilt_sigma) - range_m
            You tilt the camera by tilt_sigma and return the exact movement of the point. To first order it is the derivative times tilt_sigma.
        negative: return => return -
            Your result is negative, but a standard deviation is not. Use the absolute value of the derivative.
        one over the sine squared: / height => / height**2
            A factor of the height is missing. r is the height over tan(x), so its derivative is the height over sin(x) ** 2.
        without squares: (height**2 + range_m**2) => (height + range_m)
            You add h and r themselves. The squared length of the line of sight is h squared plus r squared.
        two exact tilts: + down = np.arctan2(height, range_m)
            + return abs(height / np.tan(down - tilt_sigma) - height / np.tan(down + tilt_sigma)) / 2
            You tilt the camera by tilt_sigma in both directions and return half of the exact difference. To first order the result is the derivative times tilt_sigma.
    """),
    alternatives={
        "by the sine": lambda r, h, s: h / np.sin(np.arctan2(h, r)) ** 2 * s,
        "h and r apart": lambda r, h, s: s * h + s * r * r / h,
        "differences": lambda r, h, s: (
            h * s * np.diff(1 / np.tan(np.arctan2(h, r) + np.array([1e-6, -1e-6])))[0] / 2e-6
        ),
    },
)


# --- 4.6 measurement_covariance ---
def _errors(pixels: Array, view: CameraView, pixel_sigma: float, tilt_sigma: float) -> Array:
    """Return a row of errors (bearing, range, ...) for one sigma of the pitch and of each u and v."""

    def measured(values: Array) -> Array:
        tilted = replace(view, pitch=float(values[0]))
        return _measured(_by_equations(values[1:].reshape(-1, 2), tilted)).ravel()

    at, steps = np.append(view.pitch, pixels), np.append(1e-6, np.full(pixels.size, 1e-3))
    sigmas = np.append(tilt_sigma, np.full(pixels.size, pixel_sigma))
    return (
        sigmas / (2 * steps) * np.transpose([measured(at + s) - measured(at - s) for s in np.diag(steps)])
    ).T


def _covariance_public() -> list[Case]:
    rng = np.random.default_rng(46)
    plain, everything = view_of(25.0), any_view(np.random.default_rng(6))
    side = np.array([[60.0, 180.0], [250.0, 100.0], [120.0, 70.0]])
    return [
        Case((np.array([[80.0, 150.0]]), plain, 1.0, 0.0), "one landmark, no tilt"),
        Case((np.array([[80.0, 150.0]]), plain, 0.0, 0.02), "one landmark, only tilt"),
        Case((side, plain, 0.7, 0.02), "three landmarks"),
        Case((side, view_of(25.0, yaw=0.5, offset=(0.1, 0.03)), 1.5, 0.01), "the head turned"),
        Case((in_view(rng, everything, 4), everything, 1.0, 0.015), "a camera with all parameters"),
        Case((np.zeros((0, 2)), plain, 1.0, 0.01), "no landmarks"),
    ]


def _covariance_hidden(rng: np.random.Generator) -> list[Case]:
    views = [any_view(rng), any_view(rng, (640, 480)), view_of(rng.uniform(20, 30), k1=-0.08)]
    cases = [
        Case((in_view(rng, view, n), view, float(rng.uniform(0.4, 2)), float(rng.uniform(0.008, 0.02))))
        for view, n in zip(views, (2, 3, 5), strict=True)
    ]
    one = in_view(rng, views[0], 2)
    rest = [(one, 0.0, 0.02), (one, 1.3, 0.0), (np.zeros((0, 2)), 1.0, 0.01)]
    return [*cases, *(Case((pixels, views[0], *sigmas)) for pixels, *sigmas in rest)]


COVARIANCE = Exercise(
    name="measurement_covariance",
    points=5,
    stars=3,
    uses=("pixel_to_ground", "ground_to_measurement"),
    public=_covariance_public,
    hidden=_covariance_hidden,
    comparison=Close(rtol=0.01, atol=1e-8),
    hints=(
        "Compute derivatives as differences: (measured((0.01, 0), 0) - measured((-0.01, 0), 0)) / 0.02 is the derivative with respect to u, for all landmarks at once.",
        "g is the same with a tilt instead of a shift, and np.outer(g, g) is g gᵀ. For D, put the derivatives by u and by v into two columns, (2k, 2). Rows 2i and 2i + 1 are the Jacobian J of landmark i, and its block is pixel_sigma ** 2 * J @ J.T.",
    ),
    sibling=Sibling(
        "Two volumes are measured with the same ruler: its wrong scale changes both together (an outer product), each reading changes only one (the diagonal), and the derivatives are differences.",
        """
        import numpy as np

        edges, reading_sigma, scale_sigma = np.array([0.2, 0.5]), 0.001, 0.01


        def volumes(scale, shift):
            return (scale * edges + shift) ** 3


        by_scale = (volumes(1.001, 0) - volumes(0.999, 0)) / 0.002
        by_reading = (volumes(1, 1e-5) - volumes(1, -1e-5)) / 2e-5
        own = np.diag((by_reading * reading_sigma) ** 2)
        shared = scale_sigma**2 * by_scale[:, None] * by_scale
        print(((own + shared) * 1e8).round(1))
        """,
        """
        [[   7.2   90. ]
         [  90.  1462.5]]
        """,
    ),
    mistakes=catalogue("""
        tilt forgotten: tilt_sigma**2 => 0
            The part of the tilt is missing or much too small. It is tilt_sigma ** 2 * np.outer(g, g), and g is a difference divided by the whole step, 2e-4.
        pixels forgotten: pixel_sigma**2 => 0
            The part of the pixels is missing: a block pixel_sigma ** 2 J Jᵀ for each landmark.
        each landmark's own tilt: np.outer(g, g) => np.outer(g, g) * np.kron(np.eye(len(pixels)), np.ones((2, 2)))
            You treat the tilts of the landmarks as independent. All landmarks of a picture share one tilt, so the off-diagonal blocks are not zero.
        a diagonal: np.outer(g, g) => np.diag(g**2)
            You keep only the diagonal of the tilt's part. g gᵀ is a full matrix, because one tilt changes all measurements.
        one pixel error for all: return R => J = np.column_stack([by_u, by_v])
            + return tilt_sigma**2 * np.outer(g, g) + pixel_sigma**2 * J @ J.T
            You use the same pixel error for all landmarks. D has a block for each landmark and zeros between the blocks; only the tilt is shared.
        deviations not squared: tilt_sigma**2 => tilt_sigma
            pixel_sigma**2 => pixel_sigma
            You multiply by the standard deviations. Multiply by their squares.
        the pixel's deviation not squared: pixel_sigma**2 => pixel_sigma
            You multiply J Jᵀ by pixel_sigma. Multiply by its square.
        the tilt's deviation not squared: tilt_sigma**2 => tilt_sigma
            You multiply g gᵀ by tilt_sigma. Multiply by its square.
        half the way for the tilt: / 2e-4 => / 1e-4
            Your g is twice as large as it should be. The difference spans two steps, so divide by 2e-4.
        both coordinates moved: (measured((0.01, 0), 0) - measured((-0.01, 0), 0)) => (measured(0.01, 0) - measured(-0.01, 0))
            You move u and v together. The first argument of measured is a pair: (0.01, 0) moves u alone.
        overlapping blocks: range(0, len(g), 2) => range(len(pixels))
            Your blocks overlap. The block of landmark i begins at row 2 i, so use range(0, len(g), 2).
        blocks at i: R[i : i + 2, i : i + 2] += => R[i // 2 : i // 2 + 2, i // 2 : i // 2 + 2] +=
            Your blocks overlap. The block of landmark i begins at row and column 2 i of R, not at i.
        blocks at i, the later one kept: R = tilt_sigma**2 * np.outer(g, g) => R = np.zeros((len(g), len(g)))
            R[i : i + 2, i : i + 2] += => R[i // 2 : i // 2 + 2, i // 2 : i // 2 + 2] =
            return R => return R + tilt_sigma**2 * np.outer(g, g)
            Your blocks overlap, and each replaces a part of the one before. The block of landmark i begins at row and column 2 i of R, not at i.
        overlapping blocks, the later one kept: R = tilt_sigma**2 * np.outer(g, g) => R = np.zeros((len(g), len(g)))
            range(0, len(g), 2) => range(len(pixels))
            R[i : i + 2, i : i + 2] += => R[i : i + 2, i : i + 2] =
            return R => return R + tilt_sigma**2 * np.outer(g, g)
            Your blocks overlap, and each replaces a part of the one before. The block of landmark i begins at row 2 i, so use range(0, len(g), 2).
        blocks replaced: R[i : i + 2, i : i + 2] += => R[i : i + 2, i : i + 2] =
            Your blocks replace the part of the tilt on the diagonal. Add them to it.
        differences not divided: / 0.02 =>> / 1
            You do not divide the differences by the step. J is the change of the measurement divided by the whole step, 0.02.
        half the way: 0.02 =>> 0.01
            Your J is twice as large as it should be. The difference spans two steps, so divide by 0.02.
        element by element: np.outer(g, g) => np.full((len(g), len(g)), g * g)
            g * g multiplies element by element, and with g.T it is the same for a vector. Use np.outer(g, g) for the matrix g gᵀ.
        g as a row: np.outer(g, g) => g * g.T
            R is a vector in your code, because g has one dimension and g.T is the same as g. Use np.outer(g, g) for the matrix g gᵀ.
        an inner product: np.outer(g, g) => np.full((len(g), len(g)), g @ g)
            g @ g is a single number. Use np.outer(g, g) for the matrix g gᵀ.
        variances of a block alone: J @ J.T => np.diag(np.diag(J @ J.T))
            You keep only the diagonal of each J Jᵀ. A pixel error changes bearing and range together, so the block is full.
        equation 4.5 for g: 2e-4 => 2e-4
            + g[::2], g[1::2] = 0, range_sigma(measured((0, 0), 0)[1::2], view.height, 1)
            You use equation 4.5 for g. It is right only straight ahead of the camera, and it has no sign. Use differences.
        range first: .ravel() => [:, ::-1].ravel()
            Your order is (range, bearing). Use bearing, range, bearing, range, ...
        all bearings first: return R => order = np.arange(len(g)).reshape(-1, 2).T.ravel()
            + return R[np.ix_(order, order)]
            Your order is all bearings, then all ranges. Use bearing, range, bearing, range, ... instead.
        of points: ground_to_measurement(pixel_to_ground(pixels + shift, tilted)) => pixel_to_ground(pixels + shift, tilted)
            You return the covariance of the points (x, y). Return the covariance of (bearing, range).
        tilt in degrees: tilt_sigma**2 => np.degrees(tilt_sigma) ** 2
            You convert tilt_sigma to degrees. Leave it in radians, because g is per radian.
        no tilt in the bearing: 2e-4 => 2e-4
            + g[::2] = 0
            You ignore the effect of the tilt on bearings. Beside the middle column it changes them, too.
        the Jacobian transposed: J @ J.T => J.T @ J
            You compute Jᵀ J. The rows of J belong to the measurement and its columns to the pixel, so a block is J Jᵀ.
        the Jacobian element by element: J @ J.T => J * J.T
            J * J.T multiplies element by element. The matrix product is J @ J.T.
        tilt taken for degrees: tilt_sigma**2 => np.radians(tilt_sigma) ** 2
            You convert tilt_sigma to radians, but it is in radians already.
        v alone: np.column_stack([by_u[i : i + 2], by_v[i : i + 2]]) => by_v[i : i + 2, None]
            You use only errors of v. The errors of u cause most of the bearing's error.
        diagonal of the Jacobian: J @ J.T => np.diag(np.diag(J) ** 2)
            You use only the diagonal of J. To the sides, an error of v also changes the bearing, and an error of u the range.
        the first Jacobian for all: by_u[i : i + 2], by_v[i : i + 2] => by_u[:2], by_v[:2]
            You use the Jacobian of the first landmark for all of them. Landmark i has the rows 2 i and 2 i + 1.
    """),
    alternatives={
        "product of a square root": lambda *given: _errors(*given).T @ _errors(*given),
        "a sum of outer products": lambda *given: sum(np.outer(each, each) for each in _errors(*given)),
        "einsum, float32": single(lambda *given: np.einsum("ki,kj->ij", _errors(*given), _errors(*given))),
    },
    equivalents=dict.fromkeys(
        (
            "tilted = replace(view, pitch=view.pitch - tilt)",
            "return ground_to_measurement(pixel_to_ground(pixels - shift, tilted)).ravel()",
            "by_u = (measured((-0.01, 0), 0) - measured((0.01, 0), 0)) / 0.02",
            "by_v = (measured((0, -0.01), 0) - measured((0, 0.01), 0)) / 0.02",
            "g = (measured((0, 0), -0.0001) - measured((0, 0), 0.0001)) / 0.0002",
        ),
        "the sign of a derivative cancels in J Jᵀ and g gᵀ",
    )
    | {
        "J = np.column_stack([by_v[i:i + 2], by_u[i:i + 2]])": "u and v are equally uncertain, so their order in J Jᵀ does not matter"
    },
)


# --- 4.7 estimate_pitch ---
def _search(power: float, pixels: Array, ground_points: Array, view: CameraView) -> Any:
    """Minimise the sum of a power of the errors in pixels."""

    def cost(offset: float) -> Any:
        seen = replace(view, pitch=view.pitch + float(offset)).project(ground_points)
        return (np.abs(np.nan_to_num(seen - pixels, nan=1e4)) ** power).sum()

    return minimize_scalar(cost, bounds=(-0.3, 0.3), method="bounded", options={"xatol": 1e-6}).x


def _tilted(pixels: Array, ground_points: Array, view: CameraView) -> float:
    """Return the median angle about the camera's own axis by which points appear too low."""
    left = view.rotation[:, 1]
    points = np.column_stack([ground_points, np.zeros(len(ground_points))]) - view.position
    ahead = np.cross(left, [0, 0, 1.0])
    down = [[np.arctan2(-each[2], each @ ahead) for each in way] for way in (points, _rays(pixels, view))]
    return float(np.median(np.subtract(*down)))


def _far_marks(rng: np.random.Generator, view: CameraView, offset: float) -> tuple[Array, Array, CameraView]:
    """Return 27 near marks without a mean error, and three distant points, all a little low."""
    near = np.column_stack([rng.uniform(0.9, 1.6, 27), rng.uniform(-0.3, 0.3, 27)])
    points = np.vstack([near, np.column_stack([rng.uniform(4.6, 5.0, 3), rng.uniform(-1, 1, 3)])])
    # The mean error of the first marks is negative, however many they are; the mean error of all 27 is zero.
    near_errors = np.column_stack([rng.permutation(np.linspace(-1, 1, 27)), np.linspace(-1.8, 1.8, 27)])
    errors = np.vstack([near_errors, [[0.5, 1.5], [-0.5, 1.5], [0.0, 1.5]]])
    return view.project(points) + errors, points, replace(view, pitch=view.pitch - offset)


def _calibration(
    rng: np.random.Generator, view: CameraView, number: int, offset: float, noise: float = 0.0
) -> tuple[Array, Array, CameraView]:
    """Return pixels of points, their positions, and a view whose pitch is wrong by an offset."""
    points = ground_in_view(rng, view, number)
    errors = rng.standard_normal((number, 2))
    errors[:3, 1] = 2.0  # the first points alone give a wrong answer
    pixels = view.project(points) + noise * errors
    return pixels, points, replace(view, pitch=view.pitch - offset)


def _pitch_public() -> list[Case]:
    rng, plain, everything = np.random.default_rng(47), view_of(20.0), any_view(np.random.default_rng(8))
    cases = {
        "a camera that points lower than assumed": _calibration(rng, plain, 6, 0.06),
        "a camera that points higher than assumed": _calibration(rng, plain, 6, -0.05),
        "a single point": _calibration(rng, plain, 1, 0.0335),
        "turned, tilted and beside the robot's centre, with a lens": _calibration(rng, everything, 8, 0.08),
        "points above the assumed horizon": _calibration(rng, view_of(14.0), 12, 0.16),
        "a camera that points much higher than assumed": _calibration(rng, view_of(20.0), 8, -0.17),
        "a camera ahead of the robot's centre": _calibration(
            rng, view_of(25.0, offset=(0.09, 0.02)), 6, 0.04
        ),
        "a camera that is tilted sideways": _calibration(rng, view_of(25.0, roll=0.12), 4, 0.04),
        "thirty points with errors of a pixel": _calibration(rng, plain, 30, 0.05, noise=1.0),
        "thirty marks with errors of a pixel, three of them far away": _far_marks(rng, view_of(22.0), 0.05),
        "nothing to correct": _calibration(rng, plain, 5, 0.0),
    }
    return [Case(given, name) for name, given in cases.items()]


PITCH = Exercise(
    name="estimate_pitch",
    points=5,
    stars=3,
    public=_pitch_public,
    hidden=lambda rng: [
        Case(_calibration(rng, any_view(rng), 10, float(rng.uniform(0.03, 0.1)))),
        Case(_calibration(rng, any_view(rng), 7, float(rng.uniform(-0.1, -0.03)))),
        Case(_calibration(rng, any_view(rng, (640, 480)), 5, float(rng.uniform(0.03, 0.1)))),
        Case(_calibration(rng, view_of(14.0), 12, float(rng.uniform(0.15, 0.17)))),
        Case(_far_marks(rng, view_of(rng.uniform(20, 24)), float(rng.uniform(0.03, 0.07)))),
        Case(_calibration(rng, view_of(20.0), 8, float(rng.uniform(-0.172, -0.165)))),
        Case(_calibration(rng, view_of(25.0, offset=(0.09, 0.02)), 6, 0.04)),
        Case(_calibration(rng, view_of(25.0, roll=0.12), 4, 0.04)),
        Case(_calibration(rng, view_of(rng.uniform(15, 25)), 40, float(rng.uniform(0.03, 0.08)), noise=1.0)),
    ],
    comparison=All((Property(small_angle), Close(rtol=0.0, atol=0.002))),
    hints=(
        "For a given offset, replace(view, pitch=view.pitch + offset).project(ground_points) returns where the points should appear in the picture. Compare this with the marked pixels, and find the offset with the smallest error.",
        "scipy.optimize.least_squares needs a function that returns all errors in one array (.ravel()), and a start: [0.0]. Or try many offsets and return the one with the smallest sum of squares.",
    ),
    sibling=Sibling(
        "The unknown offset is the number for which the predictions fit the measurements best, so you predict with many offsets and compare.",
        """
        import numpy as np

        hours = np.array([1.0, 4.0, 7.0, 10.0])
        tide = np.array([1.69, 0.35, 0.20, 1.56])  # metres; 1 + cos(hours / 2 + offset) is expected
        offsets = np.linspace(-1, 1, 2001)
        squares = [np.sum((1 + np.cos(hours / 2 + offset) - tide) ** 2) for offset in offsets]
        print(f"offset {offsets[np.argmin(squares)]:.2f} rad")
        """,
        "offset 0.30 rad",
    ),
    mistakes=catalogue("""
        the wrong sign: return float => return -float
            Your offset has the wrong sign. view.pitch + offset should be the true pitch.
        the whole pitch: return float => return view.pitch + float
            You return the camera's pitch. Return the angle that has to be added to view.pitch.
        degrees: return float( => return np.degrees(
            Your offset is in degrees. Return radians.
        one point alone: + pixels, ground_points = pixels[:1], ground_points[:1]
            You use only the first point or the first few points. With errors of a pixel this is inaccurate: use all points.
        an array of one number: return float(least_squares(misses, [0.0]).x[0]) => return least_squares(misses, [0.0]).x
            Your answer is an array with one number in it. Return the number itself: .x[0].
        first five points: + pixels, ground_points = pixels[:5], ground_points[:5]
            You use only a few of the points. With errors of a pixel this is inaccurate: use all points.
        a search that ends at 5 degrees: return float(least_squares(misses, [0.0]).x[0]) => return float(np.clip(least_squares(misses, [0.0]).x[0], -np.radians(5), np.radians(5)))
            Your search ends too early. The offset is up to 10 degrees, or 0.175 rad, in either direction.
        a search that ends at 9 degrees: return float(least_squares(misses, [0.0]).x[0]) => return float(np.clip(least_squares(misses, [0.0]).x[0], -np.radians(9), np.radians(9)))
            Your search ends just too early. The offset is up to 10 degrees, or 0.175 rad, in either direction.
        one linear step: return float(least_squares(misses, [0.0]).x[0]) => gradient = (misses([1e-4]) - misses([-1e-4])) / 2e-4
            + return -gradient @ misses([0.0]) / (gradient @ gradient)
            You take a single linear step. The projection is not linear in the angle, so linearise again at the result and repeat until nothing changes.
        least squares on the ground: .project(ground_points) - pixels).ravel() => )
            return (replace(view, => points = pixel_to_ground(pixels, replace(view,
            + return np.nan_to_num(points - ground_points, nan=1e3).ravel()
            You compare on the ground, where one pixel far away corresponds to decimetres, so a few distant marks dominate. Compare in the picture with view.project, where all marks are equally accurate.
        angles below the horizon: + right, below = ((view.undistort(pixels) - view.centre) / view.focal).T
            + rays = np.column_stack([np.ones(len(right)), -right, -below]) @ view.rotation.T
            + seen = np.arctan2(-rays[:, 2], np.hypot(rays[:, 0], rays[:, 1]))
            + return np.mean(np.arctan2(view.height, np.hypot(*(ground_points - view.offset).T)) - seen)
            You compare angles below the horizon. They change by the whole offset only straight ahead of the camera, and by less to the sides. Use view.project.
        the camera's offset forgotten: + view = replace(view, offset=(0.0, 0.0))
            You ignore view.offset. The ground points are in the robot frame, and the camera is at view.offset there.
        roll forgotten: + view = replace(view, roll=0.0)
            You ignore view.roll. A camera that is tilted sideways sees points on one side lower in the picture.
        median of angles below the horizon: + right, below = ((view.undistort(pixels) - view.centre) / view.focal).T
            + rays = np.column_stack([np.ones(len(right)), -right, -below]) @ view.rotation.T
            + seen = np.arctan2(-rays[:, 2], np.hypot(rays[:, 0], rays[:, 1]))
            + return np.nanmedian(np.arctan2(view.height, np.hypot(*(ground_points - view.offset).T)) - seen)
            You compare angles below the horizon, and take their median. These angles change by the whole offset only straight ahead of the camera, and by less to the sides. Use view.project.
        the lens left in: + view = replace(view, k1=0.0)
            You ignore the lens distortion, and your offset compensates for it. view.project includes it, and view.undistort removes it.
        the head's yaw forgotten: + view = replace(view, yaw=0.0)
            You ignore view.yaw, so your answer is right only if the head looks straight ahead. The ground points are in the robot frame.
        ranges from the robot: + below = np.arctan((view.undistort(pixels)[:, 1] - view.centre[1]) / view.focal[1])
            + return np.mean(np.arctan2(view.height, np.hypot(*ground_points.T)) - view.pitch - below)
            You treat each pixel as if it were in the middle column of a camera at the robot's centre. Use view.project or your pixel_to_ground, which are also right to the sides and with an offset.
        mean error in v: + return float(np.mean(view.project(ground_points)[:, 1] - pixels[:, 1]) / view.focal[1])
            You divide the mean error of v by the focal length. One pixel is an angle of 1 / f only near the middle of the picture, and a roll or a turn changes it too. Compare pixels with view.project for many offsets.
        mean error in v, the wrong sign: + return float(np.mean(pixels[:, 1] - view.project(ground_points)[:, 1]) / view.focal[1])
            Your offset has the wrong sign: if the camera looks lower than assumed, the points appear higher, at a smaller v. An error of v divided by the focal length is also accurate only near the middle of the picture. Compare pixels with view.project for many offsets.
        nothing: + return 0.0
            Your offset is always 0. Does your search end at its start?
        whole degrees: return float(least_squares(misses, [0.0]).x[0]) => return float(np.radians(np.round(np.degrees(least_squares(misses, [0.0]).x[0]))))
            Your offset is a whole number of degrees. Search in smaller steps, because it must be accurate to 0.1 degrees.
        half degrees: return float(least_squares(misses, [0.0]).x[0]) => return float(np.radians(np.round(2 * np.degrees(least_squares(misses, [0.0]).x[0])) / 2))
            Your offset is a multiple of half a degree. Search in steps of 0.1 degrees or less, or search again around the best one.
        hundredths of a radian: return float(least_squares(misses, [0.0]).x[0]) => return float(np.round(least_squares(misses, [0.0]).x[0], 2))
            Your offset is a multiple of 0.01 rad, which is 0.6 degrees. It must be accurate to 0.1 degrees, so search in smaller steps.
        angles below the horizon, without the offset: + right, below = ((view.undistort(pixels) - view.centre) / view.focal).T
            + rays = np.column_stack([np.ones(len(right)), -right, -below]) @ view.rotation.T
            + seen = np.arctan2(-rays[:, 2], np.hypot(rays[:, 0], rays[:, 1]))
            + return np.mean(np.arctan2(view.height, np.hypot(*ground_points.T)) - seen)
            You compare angles below the horizon, and compute them without view.offset. They also change by less than the whole offset to the sides of the camera. Use view.project.
        mean without NaN, from the robot: + below = [np.arctan2(view.height, np.hypot(*(each).T)) for each in (ground_points, pixel_to_ground(pixels, view))]
            + return float(np.nanmean(below[0] - below[1]))
            You compare the angles of ranges below the horizon, but from the robot's origin: the camera is at view.offset. Even with it, these angles change by less than the whole offset to the sides. Use view.project.
        median without NaN, from the robot: + below = [np.arctan2(view.height, np.hypot(*(each).T)) for each in (ground_points, pixel_to_ground(pixels, view))]
            + return float(np.nanmedian(below[0] - below[1]))
            You take the median of the angles of ranges, but from the robot's origin: the camera is at view.offset. Even with it, these angles change by less than the whole offset to the sides. Use view.project.
        mean with NaN, from the robot: + below = [np.arctan2(view.height, np.hypot(*(each).T)) for each in (ground_points, pixel_to_ground(pixels, view))]
            + return float(np.mean(below[0] - below[1]))
            Your mean is NaN as soon as a pixel is above the assumed horizon. You also measure from the robot's origin, but the camera is at view.offset, and to its sides the angle changes by less than the whole offset. Use view.project.
        mean with NaN, from the camera: + below = [np.arctan2(view.height, np.hypot(*(each - view.offset).T)) for each in (ground_points, pixel_to_ground(pixels, view))]
            + return float(np.mean(below[0] - below[1]))
            Your mean is NaN as soon as a pixel is above the assumed horizon. Angles below the horizon also change by less than the whole offset to the sides of the camera. Use view.project.
        angles below the horizon, where there are any: + below = [np.arctan2(view.height, np.hypot(*(each - view.offset).T)) for each in (ground_points, pixel_to_ground(pixels, view))]
            + return float(np.nanmean(below[0] - below[1]))
            You compare angles below the horizon and leave out pixels above it. These angles change by the whole offset only straight ahead of the camera, and by less to the sides. Use view.project.
        median of these: + below = [np.arctan2(view.height, np.hypot(*(each - view.offset).T)) for each in (ground_points, pixel_to_ground(pixels, view))]
            + return float(np.nanmedian(below[0] - below[1]))
            You take the median of angles below the horizon, without the pixels above it. These angles change by the whole offset only straight ahead of the camera, and by less to the sides. Use view.project.
    """),
    alternatives={
        "absolute errors": partial(_search, 1),
        "float32": single(partial(_search, 2)),
        "angles": _tilted,
    },
    equivalents={
        "return (replace(view, pitch=view.pitch + offset[-1]).project(ground_points) - pixels).ravel()": "an array of one number has one element",
        "return float(least_squares(misses, [0.0]).x[-1])": "an array of one number has one element",
        "return least_squares(misses, [0.0]).x[0]": "NumPy's float64 is a float",
        "return (pixels - replace(view, pitch=view.pitch + offset[0]).project(ground_points)).ravel()": "the square of a difference does not depend on its order",
    },
)


PLAN = LessonPlan(
    exercises=[MEASUREMENT, DISTANCE, BEARING, GROUND, SIGMA, COVARIANCE, PITCH],
    questions=[
        Question(
            "why_no_balance",
            "One tilt has a standard deviation of 3 degrees and another one of 4 degrees, and they are independent. What is the standard deviation of their sum?",
            {
                "1 degree, because they cancel.": "They would have to have opposite signs in every picture. Independent errors have opposite signs in only half of them.",
                "5 degrees.": "The variances 9 and 16 add up to 25. The result is less than 7, because the errors often have opposite signs, and more than 4, because otherwise they add up.",
                "7 degrees, because errors add up.": "Both errors would have to have the same sign in every picture. Variances add up, not standard deviations.",
                "3.5 degrees, the mean.": "A sum is not a mean. Each independent error increases the standard deviation of the sum.",
            },
            "5 degrees.",
        ),
        Question(
            "what_helps",
            "At 3 m a mark is 1 pixel off at 320 x 240, and the tilt has a standard deviation of 0.7 degrees. What makes the range much more accurate?",
            {
                "Pictures of 1280 x 960.": "They reduce the 7 cm of the pixel to 2 cm. The 23 cm of the tilt remain, so the total error is 23 instead of 24 cm.",
                "The mean of three landmarks in the same picture.": "They share the tilt of the picture. If all three ranges are too long, their mean is too long as well.",
                "The mean of three pictures.": "Each picture has its own tilt, so the mean of three is better by the square root of three: 14 cm. A calibration has to come first, because a constant error remains in the mean.",
            },
            "The mean of three pictures.",
        ),
    ],
    written=[
        Written(
            "explain_shared_tilt",
            points=2,
            question="Why would it be wrong to give each of three landmarks in one picture its own variance and to set the rest of R to zero? Give both numbers of your own picture.",
            rubric="1 point: the tilt of a picture is one error for all its landmarks, so their ranges are wrong in the same direction (correlated). 1 point: if they are treated as independent, they are averaged, and the result is assumed to be more accurate than it is (overconfident). Subtract half a point if the two numbers of the personal world are missing.",
            numbers=personal_numbers,
        )
    ],
)
