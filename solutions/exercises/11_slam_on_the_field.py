"""Lesson 11, SLAM on the field: exercises, typical mistakes, and correct alternatives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.exercises import (
    All,
    Case,
    Close,
    Comparison,
    Each,
    Exact,
    Exercise,
    LessonPlan,
    Methods,
    Mistake,
    Property,
    Question,
    Sibling,
    Unordered,
    calls,
)
from nao_course.field_slam.association import associate_jointly
from nao_course.field_slam.drives import OdometryNoisePerMove
from nao_course.field_slam.observation import Observation, as_observation
from nao_course.geometry import Pose, rotation_2d, wrap_angle
from nao_course.graphs import LANDMARK, POSE, Graph
from nao_course.instructor.authoring.mistakes import Change, catalogue
from nao_course.lessons.slam_on_the_field import GREEN, POST_RADIUS, VAGUE, YELLOW
from nao_course.lessons.slam_on_the_field.drivers import associate_nothing, whole_numbers
from nao_course.lessons.slam_on_the_field.worlds import drawn_drive
from nao_course.sim import NAO_V4, CameraView
from nao_course.slam import (
    KINDS,
    Estimate,
    LandmarkKind,
    Measurement,
    Motion,
    SlamAlgorithm,
    range_and_bearing,
)
from nao_course.student import earlier

Array = npt.NDArray[Any]
TURN = 2 * np.pi

rgb_to_hsl = earlier("01:rgb_to_hsl")
white_threshold = earlier("01:white_threshold")
color_labels = earlier("01:color_labels")
find_goalposts = earlier("02:find_goalposts")
find_corners = earlier("03:find_corners")
pixel_to_ground = earlier("04:pixel_to_ground")
ground_to_measurement = earlier("04:ground_to_measurement")
measurement_jacobian_pose = earlier("05:measurement_jacobian_pose")
measurement_jacobian_landmark = earlier("05:measurement_jacobian_landmark")
predict = earlier("07:predict")
update_landmarks = earlier("07:update_landmarks")
add_landmark = earlier("07:add_landmark")
linearize = earlier("09:linearize")
gauss_newton = earlier("09:gauss_newton")


# --- 11.1 measurements_from_pixels ---
def _measured(posts: Any, corners: Any, view: CameraView) -> Any:
    """Convert all points at once, with their kinds in a list."""
    points = pixel_to_ground(np.vstack([np.reshape(posts, (-1, 2)), np.reshape(corners, (-1, 2))]), view)
    kinds: list[LandmarkKind] = ["post"] * len(posts) + ["corner"] * len(corners)
    return [
        Measurement(float(np.arctan2(y, x)), float(np.hypot(x, y)) + POST_RADIUS * (kind == "post"), kind)
        for (x, y), kind in zip(points, kinds, strict=True)
        if not np.isnan(x)
    ]


def _by_complex(posts: Any, corners: Any, view: CameraView) -> Any:
    made = []
    for kind, pixels in {"corner": corners, "post": posts}.items():
        x, y = pixel_to_ground(np.asarray(pixels, dtype=float), view).T
        toward = (x + 1j * y)[np.isfinite(x)]
        away = np.abs(toward) + (kind == "post") * POST_RADIUS
        made += [Measurement(b, r, kind) for b, r in zip(np.angle(toward), away, strict=True)]
    return made


def _a_view(yaw: float = 0.0, pitch: float = -24.6, size: tuple[int, int] = (320, 240)) -> CameraView:
    """Return the assumed view of the bottom camera; angles of the head in degrees."""
    return NAO_V4.view("bottom", float(np.radians(yaw)), float(np.radians(pitch)), size)


NO_PIXELS: Array = np.zeros((0, 2))


def _pixels_public() -> list[Case]:
    post, both = np.array([[200.0, 110.0]]), np.array([[40.0, 90.0], [260.0, 95.0]])
    corners, high = np.array([[60.0, 150.0], [250.0, 200.0]]), np.array([[100.0, 2.0], [150.0, 120.0]])
    cases = [
        Case((NO_PIXELS, corners, _a_view()), "two corners, no post"),
        Case((post, NO_PIXELS, _a_view()), "a post, no corner"),
        Case((post, corners, _a_view(yaw=30.0)), "a post and two corners, the head turned to the left"),
        Case((both, corners[:1], _a_view(yaw=-20.0)), "both posts and a corner"),
        Case((high, high + (20.0, 30.0), _a_view(pitch=-38.0)), "one point of four above the horizon"),
        Case((NO_PIXELS, NO_PIXELS, _a_view()), "nothing found"),
    ]
    for posts, corners, view in (case.args for case in cases):
        # Other ways to call both functions; these calls are recorded like the reference's
        together = np.concatenate([posts, corners])
        for pixels in (posts, corners, together, *together[:, None]):
            ground = pixel_to_ground(pixels, view)
            ground_to_measurement(ground)
            if len(pixels) > 1:
                ground_to_measurement(ground[np.isfinite(ground[:, 0])])
    return cases


def _pixels_hidden(rng: np.random.Generator) -> list[Case]:
    cases = []
    for posts, corners, pitch in ((1, 0, -24.0), (0, 2, -20.0), (2, 3, -31.0), (1, 2, -37.0), (2, 2, -38.0)):
        pixels = rng.uniform((5, 20), (315, 235), (posts + corners, 2))
        if pitch < -36:
            pixels[::2, 1] = rng.uniform(0, 6, len(pixels[::2]))  # there the horizon is in the picture
        cases.append(Case((pixels[:posts], pixels[posts:], _a_view(rng.uniform(-60, 60), pitch))))
    far = rng.uniform((60, 119), (260, 122), (1, 2))  # about 15 m away
    return [*cases, Case((NO_PIXELS, far, _a_view(pitch=-38.0)))]


MEASUREMENTS_FROM_PIXELS = Exercise(
    name="measurements_from_pixels",
    points=1,
    uses=("04:pixel_to_ground", "04:ground_to_measurement"),
    public=_pixels_public,
    hidden=_pixels_hidden,
    comparison=Unordered(Close(atol=1e-6, period=(TURN, 0))),
    hints=(
        "Two functions of lesson 04 convert pixels to bearings and ranges. A point above the horizon becomes NaN on the way.",
        "Loop over the two kinds, and over the rows of ground_to_measurement(pixel_to_ground(pixels, view)). Make a Measurement of each row with a finite range.",
    ),
    sibling=Sibling(
        "Two lists of different kinds become one list in a loop over both kinds, and rows with NaN are left out.",
        """
        import numpy as np

        days = {"rain": np.array([[1, 4.0], [2, np.nan]]), "snow": np.array([[3, 12.0]])}
        everything = []
        for kind, rows in days.items():
            everything += [(kind, int(day), float(mm)) for day, mm in rows if np.isfinite(mm)]
        print(everything)
        """,
        "[('rain', 1, 4.0), ('snow', 3, 12.0)]",
    ),
    mistakes=catalogue("""
        the horizon: np.isfinite(distance) => True
            A point at or above the horizon has no place on the ground. pixel_to_ground returns NaN for it, and a Measurement does not accept NaN. Leave such points out.
        kinds exchanged: (posts, "post", => (posts, "corner",
            (corners, "corner", => (corners, "post",
            Your kinds are exchanged: `posts` have the kind "post" and `corners` the kind "corner".
        kinds exchanged, no radius: (posts, "post", POST_RADIUS) => (posts, "corner", 0.0)
            (corners, "corner", => (corners, "post",
            Two things are wrong. Your kinds are exchanged: `posts` have the kind "post" and `corners` the kind "corner". Also add POST_RADIUS to the range of each post.
        only near points: np.isfinite(distance) => distance < 10
            You leave out points beyond some range. Leave out only points at or above the horizon; pixel_to_ground returns NaN for them, so test np.isfinite.
        below the middle: pixel_to_ground(pixels, view) => pixel_to_ground(pixels[pixels[:, 1] > view.centre[1]], view)
            You keep only points in the lower half of the picture. The horizon is at the middle row only if the camera looks straight ahead. Convert all points, and leave out those for which pixel_to_ground returns NaN.
        all are corners: distance + radius, kind => distance + radius
            All your measurements are corners, because that is the default kind of a Measurement. Pass "post" for the posts.
        the post's front, and the horizon: distance + radius => distance
            np.isfinite(distance) => True
            Two details are missing. Add POST_RADIUS to the range of each post, because the camera sees its front. Leave out points at or above the horizon: their range is NaN, which a Measurement does not accept.
        all are corners, at the post's front: distance + radius, kind => distance
            Posts need two things that are missing: their kind, "post", and POST_RADIUS added to their range. Convert posts and corners separately.
        rows instead of measurements: + return np.concatenate([ground_to_measurement(pixel_to_ground(each, view)) for each in (posts, corners)])
            You return an array of bearings and ranges. Make a Measurement of each row, Measurement(bearing, range, kind), and return them in a list.
        the post's front: distance + radius => distance
            Almost right, but the camera sees the front of a post, and the map holds its centre. Add POST_RADIUS to the range of each post.
        too near: distance + radius => abs(distance - radius)
            You subtract the post's radius. The centre is farther away than the front, so add it.
        the diameter: distance + radius => distance + 2 * radius
            You add the post's diameter. The centre is one radius behind the front: POST_RADIUS once.
        corners have no radius: "corner", 0.0 => "corner", POST_RADIUS
            You add the radius to corners as well. A corner is a point on the ground.
        radius of the wrong kind: (posts, "post", POST_RADIUS) => (posts, "post", 0.0)
            "corner", 0.0 => "corner", POST_RADIUS
            You add the radius to the corners and not to the posts. It belongs to the posts.
        x and y: ground_to_measurement(pixel_to_ground(pixels, view)) => pixel_to_ground(pixels, view)
            distance + radius => abs(distance)
            You use x and y on the ground as bearing and range. Convert them with ground_to_measurement.
        x and y as they are: ground_to_measurement(pixel_to_ground(pixels, view)) => pixel_to_ground(pixels, view)
            You use x and y on the ground as bearing and range, and to the right of the robot y is negative. Convert them with ground_to_measurement.
        one pixel at a time: in ground_to_measurement(pixel_to_ground(pixels, view)): => in (ground_to_measurement(pixel_to_ground(pixel, view)) for pixel in pixels):
            Both functions return one row for each pixel, also for a single pixel. Pass all pixels of a kind, and loop over the rows.
        kinds after the test: + z = ground_to_measurement(pixel_to_ground(np.vstack([posts, corners]), view))
            + z = z[np.isfinite(z[:, 1])]
            + kinds = ["post"] * len(posts) + ["corner"] * len(corners)
            + return [Measurement(b, r + POST_RADIUS * (kind == "post"), kind) for (b, r), kind in zip(z, kinds)]
            You leave out points before you know their kinds, so a corner takes the place of a post above the horizon. Convert posts and corners separately.
        the paper's angles: + paper_bearing, paper_distance = earlier("04:paper_bearing"), earlier("04:paper_distance")
            ground_to_measurement(pixel_to_ground(pixels, view)) => np.stack([f(pixels, view) for f in (paper_bearing, paper_distance)], axis=1)
            np.isfinite(distance) => distance > 0
            These are the paper's distances, which start below the camera and ignore the head's yaw. Use pixel_to_ground instead.
        to the right: Measurement(bearing => Measurement(-bearing
            Your bearings have the wrong sign. A bearing is positive to the left.
        degrees: Measurement(bearing => Measurement(np.degrees(bearing)
            Your bearings are in degrees. A Measurement has radians.
        corners forgotten: , (corners, "corner", 0.0)) => ,)
            Your list has no corners.
        posts forgotten: (posts, "post", POST_RADIUS), (corners, "corner", 0.0) => (corners, "corner", 0.0),
            Your list has no posts.
        range before bearing: (bearing, distance + radius, kind) => (distance + radius, bearing, kind)
            Range and bearing are exchanged. The order is Measurement(bearing, range, kind).
        along x: pixel_to_ground(pixels, view) => pixel_to_ground(pixels, view) + (radius, 0)
            distance + radius => distance
            You shift a post's foot along x. Its centre is behind the front as seen from the robot, so add the radius to the range.
        one for all: np.isfinite(distance) => np.isfinite(pixel_to_ground(pixels, view)).all()
            If one point is above the horizon you leave out the others as well. Test each row by itself.
        bare tuples: Measurement(bearing => (bearing
            Your list holds tuples. Make a Measurement of each: Measurement(bearing, range, kind).
    """),
    alternatives={
        "all at once": _measured,
        "another order, a tuple": lambda *given: tuple(_measured(*given)[::-1]),
        "complex numbers": _by_complex,
    },
    equivalents={
        "for pixels, kind, radius in ((corners, 'corner', 0.0), (posts, 'post', POST_RADIUS)):": "any order will do"
    },
)


# --- 11.2 measure ---
def _seen(lightness: Any, answer: Any = list, *blur: float) -> Any:
    def function(picture: Any, view: CameraView) -> Any:
        labels = color_labels(picture, GREEN, YELLOW, white_threshold(lightness(picture)), *blur)
        return answer(_measured(find_goalposts(labels), find_corners(labels), view))

    return function


# From these places the reference finds corners, posts, or both.
PLACES = [
    (1.77, 0.57, -0.91),
    (1.2, -0.38, -0.62),
    (0.6, 0.5, -0.25),
    (1.1, -1.23, 1.01),
    (1.35, -1.02, 1.47),
    (1.53, -0.91, -0.03),
    (1.84, 0.96, -0.45),
    (2.5, -0.65, 0.93),
]


def _pictures_public() -> list[Case]:
    named = {0: "a post and two corners", 1: "a post and four corners", 3: "one post, two corners"}
    cases = [Case((Pose(*PLACES[number]), 0.0), name) for number, name in named.items()]
    return [
        *cases,
        Case((Pose(0.6, 0.5, -0.25), 0.0, 0.6), "two posts in poor light"),
        Case((Pose(0.5, 0.0, 3.0), 0.0), "nothing to see"),
    ]


def _pictures_hidden(rng: np.random.Generator) -> list[Case]:
    cases = []
    for number in rng.permutation(len(PLACES))[:6]:
        x, y, theta = PLACES[number] + rng.normal(0.0, 0.01, 3)
        yaw = float(rng.uniform(-0.5, 0.5))
        light, seed = float(rng.uniform(0.7, 1.0)), int(rng.integers(100))
        cases.append(Case((Pose(x, y, theta - yaw), yaw, light, seed)))
    return cases


MEASURE = Exercise(
    name="measure",
    points=2,
    uses=[
        "measurements_from_pixels",
        "01:rgb_to_hsl",
        "01:white_threshold",
        "01:color_labels",
        "02:find_goalposts",
        "03:find_corners",
    ],
    public=_pictures_public,
    hidden=_pictures_hidden,
    driver="nao_course.lessons.slam_on_the_field.drivers:on_taken_picture",
    comparison=Unordered(Close(rtol=0.0, atol=(0.02, 0.15), period=(TURN, 0))),
    hints=(
        "Follow the order of the paper's section 4: lightness, threshold, labels; then posts and corners in the labels; then exercise 11.1.",
        "rgb_to_hsl(picture) returns hue, saturation and lightness. Pass the mean lightness to white_threshold, and its result with GREEN and YELLOW to color_labels.",
    ),
    sibling=Sibling(
        "Small functions are called in order, and a value that depends on the whole input is computed first and passed on.",
        """
        import numpy as np


        def limit(sound):
            return 3 * np.median(np.abs(sound))


        def bursts(sound, level):
            return np.flatnonzero(np.abs(sound) > level)


        sound = np.array([0.1, -0.1, 0.9, 0.1, -0.7, 0.2])
        print(bursts(sound, limit(sound)))
        """,
        "[2 4]",
    ),
    mistakes=catalogue("""
        rows for columns: find_goalposts(labels) => find_goalposts(labels)[:, ::-1]
            find_corners(labels) => find_corners(labels)[:, ::-1]
            Your points are (row, column). Lessons 02 and 03 return (u, v), and pixel_to_ground needs (u, v): pass them on unchanged.
        posts for corners: find_goalposts(labels), find_corners(labels) => find_corners(labels), find_goalposts(labels)
            Posts and corners are exchanged. The first argument of measurements_from_pixels is the posts, the second the corners.
        no posts: find_goalposts(labels) => np.zeros((0, 2))
            Your list has no posts. find_goalposts finds their feet in the labels.
        no corners: find_corners(labels) => np.zeros((0, 2))
            Your list has no corners. find_corners finds them in the labels.
        a fixed threshold: white_threshold(rgb_to_hsl(picture)[2].mean()) => 120.0
            Your threshold is 120 or little more, so parts of the carpet count as white. Use white_threshold with the picture's mean lightness, from 0 to 255.
        the mean of all numbers: rgb_to_hsl(picture)[2] => picture
            You average red, green and blue. The threshold needs the mean lightness, and rgb_to_hsl returns the lightness third.
        a threshold for each pixel: rgb_to_hsl(picture)[2].mean() => rgb_to_hsl(picture)[2]
            You pass the lightness of all pixels to white_threshold, so each pixel gets its own threshold. Pass the mean, one number for the whole picture.
        the mean hue: rgb_to_hsl(picture)[2] => rgb_to_hsl(picture)[0]
            You average the hue. rgb_to_hsl returns hue, saturation and lightness, and the threshold needs the last.
        the median: rgb_to_hsl(picture)[2].mean() => np.median(rgb_to_hsl(picture)[2])
            You use the median of the lightness. Equation 1.4 uses the mean.
        the largest channel: rgb_to_hsl(picture)[2] => picture.max(axis=2)
            You average the largest of red, green and blue. The lightness is halfway between the largest and the smallest.
        the mean as threshold: white_threshold(rgb_to_hsl(picture)[2].mean()) => rgb_to_hsl(picture)[2].mean()
            You use the mean lightness itself as the threshold. Pass it to white_threshold first.
        nothing at all: + return []
            Your list is always empty. Is the order in color_labels green, then yellow? Do you pass the labels on and return the list?
    """),
    alternatives={
        "NumPy's lightness": _seen(lambda picture: np.mean([picture.max(axis=2), picture.min(axis=2)])),
        "every seventh pixel": _seen(lambda picture: rgb_to_hsl(picture)[2].ravel()[::7].mean(), tuple),
        "corners first": _seen(
            lambda picture: rgb_to_hsl(picture)[2].mean(), lambda found: found[::-1], 0.16
        ),
    },
)


# --- 11.3 joint_distance ---
def _linear(state: Any, indices: Any, measurements: Any) -> tuple[Array, Array, Array]:
    """Return rows in R, innovation and H of the measurements that have a partner."""
    pairs = [(i, int(j)) for i, j in enumerate(indices) if j >= 0]
    off, H = np.zeros((len(pairs), 2)), np.zeros((len(pairs), 2, len(state)))
    for n, (i, j) in enumerate(pairs):
        pose, landmark = state[:3], state[3 + 2 * j : 5 + 2 * j]
        off[n] = [measurements[i].bearing, measurements[i].range] - range_and_bearing(pose, landmark)
        H[n][:, :3] = measurement_jacobian_pose(pose, landmark)
        H[n][:, 3 + 2 * j : 5 + 2 * j] = measurement_jacobian_landmark(pose, landmark)
    off[:, 0] = wrap_angle(off[:, 0])
    rows = np.array([2 * i + c for i, _ in pairs for c in (0, 1)], dtype=int)
    return rows, off.ravel(), H.reshape(-1, len(state))


def _distance(length: Any) -> Any:
    """Make a distance from a length of an innovation with covariance S."""

    def function(state: Any, covariance: Any, indices: Any, measurements: Any, R: Any) -> Any:
        rows, off, H = _linear(state, indices, measurements)
        return length(H @ covariance @ H.T + R[np.ix_(rows, rows)], off)

    return function


_by_cholesky = _distance(lambda S, off: np.linalg.norm(np.linalg.solve(np.linalg.cholesky(S), off)))


def random_covariance(rng: np.random.Generator, size: int, scale: float) -> Array:
    """Draw a covariance (size, size) with correlations and standard deviations around `scale`."""
    root = rng.normal(0.0, 0.35, (size, size)) + np.eye(size) * rng.uniform(0.6, 1.2, size)
    return scale**2 * (root @ root.T)


def _estimate_of(
    rng: np.random.Generator, pose: Array, landmarks: Array, scale: float
) -> tuple[Array, Array]:
    """Return a state and its covariance: all landmarks share the pose's error, and each has one of its own."""
    n = 3 + landmarks.size
    away = landmarks - pose[:2]
    shared = np.eye(n, 3)
    shared[3::2, 0] = shared[4::2, 1] = 1.0
    shared[3:, 2] = np.stack([-away[:, 1], away[:, 0]], axis=1).ravel()
    covariance = random_covariance(rng, n, 0.04) + 0.8 * shared @ random_covariance(rng, 3, scale) @ shared.T
    return np.concatenate([pose, landmarks.ravel()]), covariance


def _crowd(rng: np.random.Generator, k: int) -> tuple[Array, Array, list[LandmarkKind]]:
    """Draw a pose, k landmarks with some close pairs, and their kinds."""
    pose = np.array([*rng.uniform(-2, 2, 2), rng.uniform(-3, 3)])
    r, direction = rng.uniform(0.8, 3.0, k), rng.uniform(-np.pi, np.pi, k)
    landmarks = pose[:2] + np.column_stack([r * np.cos(direction), r * np.sin(direction)])
    for i in range(1, k, 2):
        landmarks[i] = landmarks[i - 1] + rng.normal(0.0, 0.25, 2)
    return pose, landmarks, [KINDS[int(rng.integers(2))] for _ in range(k)]


def _picture(rng: np.random.Generator, k: int, m: int, off: float = 1.0) -> tuple[Any, ...]:
    """Draw state, covariance, kinds, measurements, R and true landmarks, with errors of the stated size."""
    pose, landmarks, kinds = _crowd(rng, k)
    state, P = _estimate_of(rng, pose, landmarks, 0.08)
    R = random_covariance(rng, 2 * m, 0.06)
    true = state + off * np.linalg.cholesky(P) @ rng.standard_normal(len(state))
    numbers = rng.permutation(k)[:m] if m <= k else rng.integers(0, k, m)
    values = range_and_bearing(true[:3], true[3:].reshape(-1, 2)[numbers])
    values = values + (np.linalg.cholesky(R) @ rng.standard_normal(2 * m)).reshape(-1, 2)
    seen = [Measurement(b, max(r, 0.1), kinds[i]) for (b, r), i in zip(values.tolist(), numbers, strict=True)]
    return state, P, kinds, seen, R, numbers


def _set_case(rng: np.random.Generator, k: int, m: int, left_out: int = 0, name: str = "") -> Case:
    """Make a case of m of k landmarks, some of them without a partner."""
    state, P, _, measurements, R, numbers = _picture(rng, k, m)
    indices = [int(number) for number in numbers]
    for i in rng.permutation(m)[:left_out]:
        indices[i] = -1
    return Case((state, P, indices, measurements, R), name)


def _behind(rng: np.random.Generator) -> tuple[Array, list[Measurement]]:
    """Return a state with a landmark straight behind, and its measurement on the other side of the half turn."""
    heading, r, off = rng.uniform(-3, 3), rng.uniform(1, 3), rng.uniform(0.01, 0.03)
    back = heading + np.pi - off
    state = np.array([0.0, 0.0, heading, r * np.cos(back), r * np.sin(back)])
    return state, [Measurement(float(-np.pi + off), float(r))]


def _distance_public() -> list[Case]:
    rng = np.random.default_rng(1133)
    state, back = _behind(rng)
    simple = (2.0 * np.eye(5)[3], 0.01 * np.eye(5), [0], [Measurement(0.1, 2.2)], np.diag([0.0025, 0.01]))
    return [
        Case(simple, "one landmark, 2 m straight ahead"),
        Case((state, 0.01 * np.eye(5), [0], back, np.diag([0.01, 0.01])), "straight behind the robot"),
        _set_case(rng, 4, 2, 0, "two pairs"),
        _set_case(rng, 5, 3, 1, "two pairs, a measurement between them without a partner"),
        _set_case(rng, 6, 4, 0, "four pairs"),
        Case((*simple[:2], [-1], *simple[3:]), "no pair at all"),
        Case((simple[0], np.eye(5), [0], [Measurement(0.1, 5.5)], simple[4]), "a range innovation above pi"),
    ]


def _distance_hidden(rng: np.random.Generator) -> list[Case]:
    state, back = _behind(rng)
    return [
        *(
            _set_case(rng, k, m, out)
            for k, m, out in ((1, 1, 0), (4, 2, 0), (5, 4, 2), (8, 5, 1), (10, 6, 0))
        ),
        Case((state, 0.01 * np.eye(5), [0], back, np.diag([0.01, 0.01]))),
        Case(
            (
                np.array([0.0, 0.0, 0.0, rng.uniform(0.8, 1.5), 0.0]),
                random_covariance(rng, 5, 1.0),
                [0],
                [Measurement(0.1, float(rng.uniform(5, 6)))],
                np.diag([0.0025, 0.01]),
            )
        ),
        _set_case(rng, 3, 2, 2),
    ]


JOINT_DISTANCE = Exercise(
    name="joint_distance",
    points=3,
    stars=2,
    uses=[
        "07:warp2pi",
        "05:expected_measurement",
        "05:measurement_jacobian_pose",
        "05:measurement_jacobian_landmark",
    ],
    public=_distance_public,
    hidden=_distance_hidden,
    comparison=Close(rtol=1e-4, atol=1e-6),
    hints=(
        "It is your update_landmarks up to S: stack innovation and H of all pairs, then compute one number from them.",
        "First list the measurements that have a partner. Measurement i has the rows and columns 2 i and 2 i + 1 of measurement_covariance, and np.ix_ selects them. Without a pair all arrays are empty, so the sum is 0.",
    ),
    sibling=Sibling(
        "Exams that were not taken are left out first, as measurements without a landmark are, and np.ix_ then selects the rows and columns of the others from the covariance of all.",
        """
        import numpy as np

        C = np.array([[4.0, 1.0, 0.5], [1.0, 9.0, 2.0], [0.5, 2.0, 1.0]])  # of three exams
        for grades in ([70, -1, 90], [-1, -1, -1]):  # -1: not taken
            taken = np.flatnonzero(np.array(grades) >= 0)
            sigma = np.sqrt(C[np.ix_(taken, taken)].sum())
            print(f"{taken}: the sum has a standard deviation of {sigma:.2f}")
        """,
        """
        [0 2]: the sum has a standard deviation of 2.45
        []: the sum has a standard deviation of 0.00
        """,
    ),
    mistakes=catalogue("""
        no root: np.sqrt(innovation @ np.linalg.solve(S, innovation)) => innovation @ np.linalg.solve(S, innovation)
            You return the squared distance. Take its root, because a gate is in standard deviations.
        bearings not wrapped: warp2pi(innovation[::2]) => innovation[::2]
            For a landmark straight behind the robot your bearing innovation is off by a full turn. Wrap it.
        bearings not wrapped, nothing to stack: warp2pi(innovation[::2]) => innovation[::2]
            if j >= 0] => if j >= 0]
            + np.concatenate([measurements[i] for i in paired] and [[0.0]])
            Two things are wrong. Wrap the bearing innovations, because behind the robot they can be off by a full turn. And return 0.0 without a pair, because then there is nothing to stack.
        the inverse of P: H @ covariance @ H.T => H @ np.linalg.inv(covariance) @ H.T
            You invert P before you multiply it by H. Only S is inverted: S = H P Hᵀ + R.
        expected range first: - expected_measurement(state[:3], state[columns]) => - expected_measurement(state[:3], state[columns])[::-1]
            You exchange bearing and range of the expected measurement. expected_measurement returns (bearing, range).
        range wrapped, too: innovation[::2] = warp2pi(innovation[::2]) => innovation = warp2pi(innovation)
            You also wrap the innovation of the range. A range is not an angle, so wrap only the bearings, innovation[::2].
        the noise alone: S = H @ covariance @ H.T + => S =
            Your S is R alone. Pose and landmarks are uncertain as well: S = H P Hᵀ + R.
        without the noise: H.T + measurement_covariance[np.ix_(own, own)] => H.T
            Your S lacks the noise of the measurements: S = H P Hᵀ + R.
        the first rows of R: [2 * i + c for i in paired for c in (0, 1)] => range(2 * len(paired))
            You use the first rows of R, even if those measurements have no partner. Measurement i has the rows and columns 2 i and 2 i + 1.
        R's variances, by two lists: np.ix_(own, own) => own, own
            measurement_covariance[rows, rows] returns only the numbers on its diagonal. A block needs np.ix_(rows, rows).
        the whole R: if j >= 0] => if j >= 0]
            + if not paired:
            +     return 0.0
            measurement_covariance[np.ix_(own, own)] => measurement_covariance
            You use the whole R. If a measurement has no partner, leave out its two rows and columns with np.ix_.
        the landmark's rows of R: 2 * i + c for i in paired => 2 * indices[i] + c for i in paired
            You choose the rows of R by the landmark's number. R belongs to the measurements: measurement i has the rows and columns 2 i and 2 i + 1.
        nothing to stack: if j >= 0] => if j >= 0]
            + np.concatenate([measurements[i] for i in paired] and [[0.0]])
            Without a pair there is nothing to stack. Return 0.0 before you stack the arrays.
        the sum of distances: return float(np.sqrt(innovation @ np.linalg.solve(S, innovation))) => blocks = [slice(2 * n, 2 * n + 2) for n in range(len(paired))]
            + return float(sum(np.sqrt(innovation[b] @ np.linalg.solve(S[b, b], innovation[b])) for b in blocks))
            You add the distances of the single pairs. The joint distance is one product with the whole S.
        neighbouring rows of R: [2 * i + c for i in paired for c in (0, 1)] => [i + c for i in paired for c in (0, 1)]
            You use the rows i and i + 1 of R for measurement i. Each measurement has two rows: 2 i and 2 i + 1.
        bearings before ranges: [2 * i + c for i in paired for c in (0, 1)] => [i + c * len(measurements) for i in paired for c in (0, 1)]
            You read R as if all bearings came first and then all ranges. Its order is bearing, range, bearing, range, so measurement i has the rows 2 i and 2 i + 1.
        each by itself: S = H => S = H
            + S = S * np.kron(np.eye(len(paired)), np.ones((2, 2)))
            You judge each pair independently. One pose error and one tilt move all pairs together, and the blocks off the diagonal of S describe that. Use the whole S.
        R in blocks: np.ix_(own, own)] => np.ix_(own, own)] * np.kron(np.eye(len(paired)), np.ones((2, 2)))
            You use only the diagonal blocks of R. The other blocks hold the tilt that all measurements of a picture share.
        R's diagonal: np.ix_(own, own)] => np.ix_(own, own)] * np.eye(len(own))
            You use only the diagonal of R. The other entries hold what the measurements of a picture share.
        rows of rows of R: measurement_covariance[np.ix_(own, own)] => measurement_covariance[own][own]
            R[rows][rows] chooses rows twice and no columns. A block needs np.ix_(rows, rows).
        a Measurement as an array: [seen.bearing, seen.range] - => seen -
            If a Measurement cannot be subtracted: it is not an array. Use [seen.bearing, seen.range].
        the norm: np.sqrt(innovation @ np.linalg.solve(S, innovation)) => np.linalg.norm(np.linalg.solve(S, innovation))
            You return the norm of S⁻¹ν. Multiply S⁻¹ν by ν, and take the root of this product.
        a number for two, in the state: state[columns] =>> state[3 + indices[i] : 5 + indices[i]]
            You read landmark j from the places 3 + j and 4 + j of the state, but every landmark has two numbers. Landmark j is at 3 + 2 j and 4 + 2 j.
        the mean: solve(S, innovation) => solve(S, innovation) / max(len(paired), 1)
            You divide by the number of pairs. Equation 11.3 has no mean: it sums over all pairs.
        columns of the pose: slice(3 + 2 * indices[i], 5 + 2 * indices[i]) => slice(2 * indices[i], 2 + 2 * indices[i])
            You take landmark j from the places 2 j and 2 j + 1, but the state begins with the three numbers of the pose. Landmark j is at 3 + 2 j and 4 + 2 j.
        columns of the pose in H: H[rows, columns] => H[rows, 2 * indices[i] : 2 + 2 * indices[i]]
            You write the landmark's Jacobian into the columns 2 j and 2 j + 1 of H, but its first three columns belong to the pose. Landmark j has the columns 3 + 2 j and 4 + 2 j.
        places of the pose: state[columns] =>> state[2 * indices[i] : 2 + 2 * indices[i]]
            You read landmark j from the places 2 j and 2 j + 1 of the state, which begins with the three numbers of the pose. Landmark j is at 3 + 2 j and 4 + 2 j.
        a number for two: slice(3 + 2 * indices[i], 5 + 2 * indices[i]) => slice(3 + indices[i], 5 + indices[i])
            You take landmark j from the places 3 + j and 4 + j, but every landmark has two numbers. Landmark j is at 3 + 2 j and 4 + 2 j.
        columns of the pose by the pair: slice(3 + 2 * indices[i], 5 + 2 * indices[i]) => slice(2 * n, 2 + 2 * n)
            Two things are wrong. You count the landmarks by their pairs, but the landmark of measurement i is j = indices[i]. And the state begins with the three numbers of the pose, so landmark j is at 3 + 2 j and 4 + 2 j.
        landmarks in turn: slice(3 + 2 * indices[i], 5 + 2 * indices[i]) => slice(3 + 2 * n, 5 + 2 * n)
            You take the landmarks in the order of the pairs. The landmark of measurement i is j = indices[i], at 3 + 2 j and 4 + 2 j.
        measured range first: [seen.bearing, seen.range] - => [seen.range, seen.bearing] -
            You subtract (bearing, range) from (range, bearing). expected_measurement returns the bearing first.
        columns in turn: H[rows, columns] => H[rows, 3 + 2 * n : 5 + 2 * n]
            Your landmark Jacobians are in the columns of another landmark. Landmark j has the columns 3 + 2 j and 4 + 2 j, as in the state.
        range before bearing: innovation[::2] = warp2pi => innovation[::2] = warp2pi
            + innovation, H = (each[np.arange(len(each)) ^ 1] for each in (innovation, H))
            Your innovation has the range before the bearing. R has the bearing first.
        the bearing's sign: warp2pi(innovation => -warp2pi(innovation
            Your bearing innovation has the wrong sign. It is measured minus expected, as for the range.
        no landmark 0: if j >= 0 => if j > 0
            You leave out landmark 0. Only -1 means that there is no partner.
        the first measurements: measurements[i] => measurements[n]
            If a measurement has no partner, you use the wrong ones after it. Pair i is measurement i with landmark indices[i].
        infinitely far: if j >= 0] => if j >= 0]
            + if not paired:
            +     return float("inf")
            Without a pair you return infinity. There is nothing to disagree about, so the distance is 0.
        variances alone: np.linalg.solve(S, innovation) => (innovation / np.diag(S))
            You divide by the variances only. S is a full matrix, so use np.linalg.solve(S, innovation).
        without the inverse: np.linalg.solve(S, innovation) => S @ innovation
            You multiply by S instead of its inverse. Use np.linalg.solve(S, innovation).
        pose and map apart: + covariance = covariance.copy()
            + covariance[:3, 3:] = covariance[3:, :3] = 0
            You drop P_pl, the covariance between pose and landmarks. Use P as it is.
        a certain pose: measurement_jacobian_pose(state[:3], state[columns]) => 0
            Your H ignores the pose's uncertainty. Its first three columns are the Jacobian with respect to the pose.
        a certain map: measurement_jacobian_landmark(state[:3], state[columns]) => 0
            Your H ignores the landmarks' uncertainty. Each landmark has two columns with its Jacobian.
        pairs with -1: if j >= 0] => ]
            You also use measurements whose number is -1. Then 3 + 2 j is 1, which is a place of the pose. Leave these measurements out.
        -1 as a number: + indices = [j % (len(state) // 2 - 1) for j in indices]
            You use -1 as an index, and Python then counts from the end. Leave out measurements with -1.
    """),
    alternatives={
        "Cholesky": _by_cholesky,
        "the inverse": _distance(
            lambda S, off: float(np.einsum("i,ij,j->", off, np.linalg.inv(S), off) ** 0.5)
        ),
        "least squares": _distance(lambda S, off: np.sqrt(off @ np.linalg.lstsq(S, off)[0])),
    },
    equivalents={
        "own = [2 * i | c for i in paired for c in (0, 1)]": "2 i is even: or, and exclusive or, add c",
        "own = [2 * i ^ c for i in paired for c in (0, 1)]": "2 i is even: or, and exclusive or, add c",
        **{
            f"H[rows, {columns}] = measurement_jacobian_{name}(state[{part}], state[columns])": "bearing and range have derivatives that do not depend on the heading"
            for columns, name in ((":3", "pose"), ("columns", "landmark"))
            for part in (":4", ":2", ":", ":3 - 1")
        },
        "return np.sqrt(innovation @ np.linalg.solve(S, innovation))": "NumPy's float is one",
        "innovation, H = (np.ones(2 * len(paired)), np.zeros((2 * len(paired), len(state))))": "all of it is filled",
        "innovation[rows] = expected_measurement(state[:3], state[columns]) - [seen.bearing, seen.range]": "in the square the sign of the whole innovation goes",
        "return float(np.sqrt(np.linalg.solve(S, innovation) @ innovation))": "the same product",
    },
)


# --- 11.4 associate ---
def _distances(state: Any, covariance: Any, kinds: Any, measurements: Any, R: Any) -> Array:
    """Return Mahalanobis distances (m, k), infinite between kinds."""
    found = np.full((len(measurements), len(kinds)), np.inf)
    for (i, j), _ in np.ndenumerate(found):
        if kinds[j] == measurements[i].kind:
            own = R[2 * i : 2 * i + 2, 2 * i : 2 * i + 2]
            found[i, j] = _by_cholesky(state, covariance, [j], [measurements[i]], own)
    return found


def _associated(rule: Any) -> Any:
    return lambda *given: rule(_distances(*given[:5]), given[5])


def _sorted(distances: Array, gate: float) -> list[int]:
    indices = [-1] * len(distances)
    for _, i, j in sorted((d, i, j) for (i, j), d in np.ndenumerate(distances) if d <= gate):
        if indices[i] == -1 and j not in indices:
            indices[i] = j
    return indices


def _in_sets(distances: Array, gate: float) -> Array:
    """Associate with sets of the measurements and landmarks that are still free."""
    rows, columns = map(set, map(range, distances.shape))
    found = -np.ones(len(distances), dtype=int)
    while rows and columns:
        d, i, j = min((distances[i, j], i, j) for i in rows for j in columns)
        if d > gate:
            break
        found[i] = j
        rows.remove(i)
        columns.remove(j)
    return found


def _masked(distances: Array, gate: float) -> Array:
    left = np.ma.masked_greater(distances, gate)
    indices = -np.ones(len(left), dtype=np.int32)
    while left.count():
        i, j = divmod(int(np.ma.argmin(left)), left.shape[1])
        indices[i] = j
        left[i, :] = left[:, j] = np.ma.masked
    return indices


def _crowd_case(rng: Any, k: int, m: int, gate: float, off: float = 1.0, name: str = "") -> Case:
    return Case((*_picture(rng, k, m, off)[:5], float(gate)), name)


# Seed, landmarks, measurements, gate: chosen so that no two mistakes answer all of these alike.
CROWDS = (275, 10, 8, 3), (296, 6, 4, 3), (1, 8, 5, 3), (2, 8, 6, 2), (365, 6, 4, 3), (339, 6, 5, 3)


def _association_public() -> list[Case]:
    straight = np.array([0.0, 0.0, 0.0, 2.0, 0.0, 2.0, 0.6])
    sure, corners = np.diag([0.01] * 7), ["corner", "corner"]
    R, noise = np.diag([0.0025, 0.01]), np.diag([0.0025, 0.01] * 2)
    one, far, none = [Measurement(0.02, 2.1)], [Measurement(-1.0, 1.0)], np.zeros((0, 0))
    name = "{1} measurements, {0} landmarks, a gate of {2:g} sigma"
    two = [Measurement(0.15, 2.0), Measurement(0.01, 2.0)]
    return [
        Case((straight, sure, corners, one, R, 3.0), "one corner near the first of two"),
        Case((straight, sure, ["post", "corner"], one, R, 4.0), "the same, but the first landmark is a post"),
        Case((straight, sure, corners, far, R, 3.0), "a corner that is near no landmark"),
        Case((np.zeros(3), np.zeros((3, 3)), [], two, np.diag([0.01] * 4), 3.0), "an empty map"),
        Case((straight, sure, corners, [], none, 3.0), "nothing measured"),
        Case((straight, sure, corners, two, noise, 3.0), "two corners, both nearest to the first landmark"),
        *(_crowd_case(np.random.default_rng(seed), *each, name=name.format(*each)) for seed, *each in CROWDS),
    ]


def _association_hidden(rng: np.random.Generator) -> list[Case]:
    sizes = (5, 3, 3), (6, 4, 2), (8, 6, 3), (10, 7, 3), (10, 8, 1.5), (12, 8, 4), (4, 6, 3), (12, 10, 3)
    state, P = _estimate_of(rng, np.array([*rng.uniform(-1, 1, 2), 0.0]), rng.uniform(-3, 3, (3, 2)), 0.05)
    return [
        *(_crowd_case(rng, *each, off=off) for off in (1.0, 1.6) for each in sizes),
        Case((state[:3], P[:3, :3], [], [Measurement(0.3, 1.0)], np.diag([0.01, 0.01]), 3.0)),
        Case((state, P, ["corner", "post", "corner"], [], np.zeros((0, 0)), 3.0)),
    ]


ASSOCIATE = Exercise(
    name="associate",
    points=3,
    stars=2,
    uses=("joint_distance",),
    public=_association_public,
    hidden=_association_hidden,
    comparison=All((Close(rtol=0.0, atol=0.01), Property(whole_numbers))),
    hints=(
        "First build a table of distances, one row for each measurement and one column for each landmark, with np.inf where the kinds differ. Then choose from it.",
        "np.unravel_index(distances.argmin(), distances.shape) is the closest pair. Store it, set its row and column to np.inf, and repeat while the smallest distance is at most the gate.",
    ),
    sibling=Sibling(
        "Taxis get groups of people as measurements get landmarks: pairs that do not fit are never compared, the closest pair comes first, each partner is used once, and 10 minutes are the gate.",
        """
        import numpy as np

        seats, people = [4, 6, 4], [2, 5, 3]
        minutes = np.array([[3, 1, 8], [2, 12, 4], [5, 6, 7]])  # of taxi i to group j
        fits = [(int(minutes[i, j]), i, j) for i in range(3) for j in range(3) if seats[i] >= people[j]]
        taxi_of = [-1, -1, -1]
        for time, i, j in sorted(fits):
            if time <= 10 and taxi_of[j] < 0 and i not in taxi_of:
                taxi_of[j] = i
        print(taxi_of)  # the only taxi with 6 seats needs 12 minutes
        """,
        "[1, -1, 2]",
    ),
    mistakes=catalogue("""
        any kind: kind == seen.kind => True
            You match posts with corners. Compare a measurement only with landmarks of its own kind.
        one landmark twice: distances[i], distances[:, j] = j, np.inf, np.inf => distances[i] = j, np.inf
            Two of your measurements have the same landmark. Each landmark is seen once in a picture, so remove its column after it is matched.
        in turn: i, j = np.unravel_index(distances.argmin(), distances.shape) => i = (distances <= gate).any(axis=1).argmax()
            + j = distances[i].argmin()
            You match the measurements in their order. The closest pair of all comes first; otherwise an early measurement takes the landmark of a nearer one.
        in the order of the loops: np.unravel_index(distances.argmin(), distances.shape) => np.argwhere(distances <= gate)[0]
            You take the pairs in the order of your loops. The closest pair of all comes first, so sort the pairs by their distance.
        matched again: indices[i], distances[i], distances[:, j] => indices[i], distances[i, j], distances[:, j]
            Your measurement can be matched again, and the farther landmark then replaces the closer one. Neither the measurement nor the landmark of a pair can be used again.
        matched again by a sorted list: + ranked = [(joint_distance(state, covariance, [j], [seen], measurement_covariance[2 * i : 2 * i + 2, 2 * i : 2 * i + 2]), i, j) for i, seen in enumerate(measurements) for j, kind in enumerate(kinds) if kind == seen.kind]
            + found = np.full(len(measurements), -1)
            + for distance, i, j in sorted(ranked):
            +     if distance <= gate and j not in found:
            +         found[i] = j
            + return found
            You test whether the landmark is free, but not whether the measurement is. A matched measurement then gets a landmark that is farther away: skip it.
        no second choice: indices = np.full => indices = np.full
            + distances[distances > distances.min(axis=1, initial=np.inf, keepdims=True)] = np.inf
            If its nearest landmark is taken, your measurement gets -1. Its second nearest may also be within the gate.
        the smallest sum: + from scipy.optimize import linear_sum_assignment
            indices = np.full => indices = np.full
            + pairs = linear_sum_assignment(np.where(distances <= gate, distances, 1e6))
            + chosen, distances = distances[pairs], np.full(distances.shape, np.inf)
            + distances[pairs] = chosen
            You minimise the sum of all distances. Nearest neighbour takes the closest pair first, then the closest of the remaining ones.
        mutual pairs only: indices = np.full => indices = np.full
            + nearest = [distances.min(axis=axis, initial=np.inf, keepdims=True) for axis in (0, 1)]
            + distances[(distances > nearest[0]) | (distances > nearest[1])] = np.inf
            You accept a pair only if each is the other's nearest. When a landmark is used up, the other measurements continue with the remaining landmarks.
        joint compatibility: + return tools.associate_jointly(state, covariance, kinds, measurements, measurement_covariance, gate)
            This is joint compatibility. Here each pair is judged alone, by nearest neighbour.
        no gate: distances.min() <= gate => distances.min() < np.inf
            You use no gate, so every measurement gets some landmark, however far away. Beyond the gate the answer is -1.
        the squared distance: distances.min() <= gate => distances.min() ** 2 <= gate
            You compare the squared distance with the gate. Both the distance and the gate are in standard deviations.
        the squared gate: distances.min() <= gate => distances.min() <= gate**2
            You square the gate. Do not: both the distance and the gate are in standard deviations.
        the first one's noise: [2 * i : 2 * i + 2, 2 * i : 2 * i + 2] => [:2, :2]
            You do not use each measurement's own R. For measurement i it is the whole block of rows and columns 2 i and 2 i + 1, including the entries off its diagonal.
        neighbouring rows of R: [2 * i : 2 * i + 2, 2 * i : 2 * i + 2] => [i : i + 2, i : i + 2]
            You use the rows i and i + 1 of R for measurement i. Each measurement has two rows: 2 i and 2 i + 1.
        one for a list: [j], [seen], R => j, seen, R
            joint_distance needs lists, also for one pair: [j] and [the measurement].
        metres
            joint_distance(state, covariance, [j], [seen], R) => np.linalg.norm(landmark_position(state[:3], (seen.bearing, seen.range)) - state[3 + 2 * j : 5 + 2 * j])
            You compare metres with a gate in standard deviations. Half a metre is a large error at 1 m and a small one at 4 m. Use joint_distance.
        an empty table: distances.size and distances.min() => distances.min()
            With no landmark or no measurement the table is empty, and min() raises an error. Test distances.size first.
        0 for none: np.full(len(measurements), -1) => np.full(len(measurements), 0)
            You return 0 for a measurement without a partner, but 0 is the first landmark. Use -1.
        variances alone: + covariance = np.diag(np.diag(covariance))
            You use only the variances of the state. The covariance between pose and landmarks belongs in S.
        all new: + return np.full(len(measurements), -1)
            You return -1 for every measurement.
    """),
    alternatives={
        "a sorted list": _associated(_sorted),
        "sets": _associated(_in_sets),
        "masked arrays": _associated(_masked),
    },
    equivalents={
        **{
            f"R = measurement_covariance[{rows}, {columns}]": "joint_distance uses only its first two rows and columns"
            for longer in (
                "2 * i:2 ** i + 2",
                "2 * i:2 << i + 2",
                "2 * i:3 * i + 2",
                "2 * i:2 * i + 3",
                "2 * i:",
            )
            for rows, columns in ((longer, "2 * i:2 * i + 2"), ("2 * i:2 * i + 2", longer))
        },
        "while distances.size and distances.min() < gate:": "no distance is the gate to the last bit",
    },
)


# --- 11.5 EkfSlam ---
class _Filter(SlamAlgorithm):
    """The filter in one method for each step; the compass by complex numbers."""

    heading: float | None = None

    def __init__(self, start: Pose = Pose(), *given: Any) -> None:
        self.state, self.covariance, self.kinds = start.as_array(), np.zeros((3, 3)), list[LandmarkKind]()
        unless_given = OdometryNoisePerMove(), 4.0, _associated(_masked)
        self.odometry, self.gate, self.association = *given, *unless_given[len(given) :]
        self.indices: Array = np.zeros(0, dtype=int)

    def move(self, motion: Motion) -> None:
        control, Q = np.array([motion.distance, motion.turn]), self.odometry.covariance(motion)
        self.state, self.covariance = predict(self.state, self.covariance, control, Q, len(self.kinds))

    def observe(self, measurements: Any) -> None:
        seen = as_observation(measurements)
        lines = seen.direction, seen.direction_sigma
        for step, given in ((self.use_compass, lines), (self.number, (seen,)), (self.correct, (seen,))):
            step(*given)

    def use_compass(self, direction: float, sigma: float) -> None:
        self.heading = None
        if sigma != np.inf:
            off = float(np.angle(np.exp(-4j * (direction + self.state[2])))) / 4
            self.heading = self.state[2] + off
            self.turn(off, sigma)

    def number(self, seen: Observation) -> None:
        belief = self.state, self.covariance, self.kinds, seen, seen.covariance
        self.indices = np.array(self.association(*belief, self.gate))
        for n in np.flatnonzero(np.min(_distances(*belief), axis=1, initial=np.inf) > 3 * self.gate):
            self.indices[n] = len(self.kinds)
            self.kinds = [*self.kinds, seen[n].kind]
            self.add(seen.values[n], VAGUE * seen.part([n]).covariance)

    def correct(self, seen: Observation) -> None:
        known = np.flatnonzero(self.indices >= 0)
        if len(known):
            places = self.state[3:].reshape(-1, 2)[self.indices[known]]
            expected = np.hypot(*(places - self.state[:2]).T)
            self.update(self.indices[known].tolist(), *seen.part(known).linearised_at(expected))

    def turn(self, off: float, sigma: float) -> None:
        gain = self.covariance[2] / np.hypot(np.sqrt(self.covariance[2, 2]), sigma) ** 2
        self.state = self.state + gain * off
        self.covariance = self.covariance - np.outer(gain, self.covariance[2])

    def add(self, value: Array, R: Array) -> None:
        self.state, self.covariance = add_landmark(self.state, self.covariance, value, R)

    def update(self, indices: list[int], values: Array, R: Array) -> None:
        self.state, self.covariance = update_landmarks(self.state, self.covariance, indices, values, R)

    def estimate(self) -> Estimate:
        landmarks = self.state[3:].reshape(-1, 2)
        own = [self.covariance[n : n + 2, n : n + 2] for n in range(3, len(self.state), 2)]
        pose = Pose.from_array(self.state[:3])
        return Estimate(pose, self.covariance[:3, :3], landmarks, np.array(own), tuple(self.kinds))


class _Joseph(_Filter):
    """The same with its own matrices: H with all columns, Joseph's form."""

    def move(self, motion: Motion) -> None:
        c, s = np.cos(self.state[2]), np.sin(self.state[2])
        F, G = np.eye(len(self.state)), np.eye(len(self.state), 3)
        F[:2, 2] = motion.distance * np.array([-s, c])
        G[:2, :2] = [[c, -s], [s, c]]
        self.state = self.state.copy()
        self.state[:3] = (Pose.from_array(self.state[:3]) @ motion.as_pose()).as_array()
        self.covariance = F @ self.covariance @ F.T + G @ self.odometry.covariance(motion) @ G.T

    def linear(self, H: Array, off: Array, R: Array) -> None:
        K = self.covariance @ H.T @ np.linalg.inv(H @ self.covariance @ H.T + R)
        rest = np.eye(len(self.state)) - K @ H
        self.state = self.state + K @ off
        self.covariance = rest @ self.covariance @ rest.T + K @ R @ K.T

    def turn(self, off: float, sigma: float) -> None:
        self.linear(np.eye(len(self.state))[2:3], np.array([off]), np.array([[sigma**2]]))

    def update(self, indices: list[int], values: Array, R: Array) -> None:
        seen = [Measurement(*value) for value in np.reshape(values, (-1, 2))]
        _, off, H = _linear(self.state, indices, seen)
        self.linear(H, off, R)


class _ByBlocks(_Filter):
    """The same with landmarks that come with blocks of its own."""

    def add(self, value: Array, R: Array) -> None:
        toward, r = self.state[2] + value[0], value[1]
        c, s = np.cos(toward), np.sin(toward)
        J, Z = np.array([[1, 0, -r * s], [0, 1, r * c]]), np.array([[-r * s, c], [r * c, s]])
        cross = self.covariance[:, :3] @ J.T
        self.covariance = np.block([[self.covariance, cross], [cross.T, J @ cross[:3] + Z @ R @ Z.T]])
        self.state = np.concatenate([self.state, self.state[:2] + r * np.array([c, s])])


def _log_case(seed: int, moves: int, name: str = "", given: tuple[Any, ...] = (), **drawn: Any) -> Case:
    """Make a case of a drive; plain: lists of Measurement, and a constructor without arguments."""
    plain, at_end = drawn.pop("plain", False), drawn.pop("at_end", False)
    gate, odometry = drawn.pop("gate", 4.0), drawn.pop("odometry", OdometryNoisePerMove())
    drive = drawn_drive(seed, moves, **({"yaws": (0.5, -0.5)} | drawn))
    turns: list[Any] = []
    for motion, seen in drive.log:
        turns += [("move", motion)] * (motion is not None)
        turns.append(("observe", list(seen) if plain else seen))
        turns += [] if at_end else ["estimate"]
    if "circle_rate" in drawn:  # some directions may be wrong; one picture has lines only
        direction = float(-drive.poses[-1, 2] + 0.01)
        turns.append(("observe", Observation((), np.zeros((0, 0)), direction, drawn["compass_sigma"])))
    return calls(*turns, "estimate", given=() if plain else (drive.start, odometry, gate, *given), name=name)


COMPASS, POOR = (float(np.radians(sigma)) for sigma in (0.7, 10.0))
WORSE = OdometryNoisePerMove(factor=2.0)
DRIVES = "whole drives: a hidden one"
# Drives whose fifth picture has two measurements that are both nearest to the same landmark, with a gate of 1.5.
CONFLICTS = (25, 37, 67, 214)
# Drives on which nearest neighbour and joint compatibility differ, and Gauss-Newton settles.
PARTED = (2001, 2003, 2004, 2005, 2009, 2010, 2017, 2024, 2027, 2030, 2035, 2037, 2038, 2039, 2042)


def _followed(seed: int, pictures: int, least: int, **drawn: Any) -> tuple[_Filter, Observation]:
    """Return a filter after some pictures of a drive, and the next picture, which has `least` measurements or more.

    Seeds are tried upwards until that is so, and until the heading is far from the half turn.
    """
    while True:
        drive = drawn_drive(seed, 4, **({"yaws": (0.5, -0.5)} | drawn))
        slam = _Filter(drive.start, OdometryNoisePerMove(), 4.0)
        for motion, seen in drive.log[:pictures]:
            if motion is not None:
                slam.move(motion)
            slam.observe(seen)
        motion, seen = drive.log[pictures]
        if motion is not None:
            slam.move(motion)
        if len(seen) >= least and len(slam.kinds) >= 2 and abs(slam.state[2]) < 2:
            return slam, seen
        seed += 1


def _method(slam: _Filter, name: str, *turns: Any, given: tuple[Any, ...] = ()) -> Case:
    """Return a case of one method: its inputs are assigned before the call and its results read afterwards."""
    put = (".state", slam.state), (".covariance", slam.covariance), (".kinds", list(slam.kinds))
    return calls(*put, *turns, ".state", ".covariance", given=given, name=name)


def _methods_alone(seeds: Sequence[int]) -> list[Case]:
    """Return cases of each method on an existing map, from the seeds of five drives."""
    (moved, _), (compass, _), (numbered, crowd), (corrected, seen), (conflicted, rivals) = (
        _followed(seed, pictures, least, false_rate=rate)
        for seed, pictures, least, rate in zip(
            seeds, (3, 4, 4, 3, 4), (0, 0, 4, 3, 4), (0.0, 0.0, 1.0, 0.0, 1.0), strict=True
        )
    )
    heading, start = float(compass.state[2]), Pose(0.3, -0.2, 0.4)
    empty = _Filter(start)
    corrected.number(seen)
    indices = corrected.indices
    fewer = np.where(np.arange(len(indices)) == 0, -1, indices)
    nobody = np.full(len(indices), -1)
    made = as_observation([Measurement(0.4, 1.2), Measurement(-0.5, 1.7, "post"), Measurement(0.1, 2.0)])
    return [
        _method(empty, "move: without a map", ("move", Motion(0.4, 0.3)), given=(start,)),
        _method(
            moved,
            "move: with a map, odometry twice as bad",
            ("move", Motion(0.3, -0.2)),
            given=(start, WORSE),
        ),
        _method(compass, "use_compass: 6 degrees off", ("use_compass", 0.1 - heading, 0.02), ".heading"),
        _method(
            compass,
            "use_compass: lines across the view, 30 degrees off",
            ("use_compass", np.pi / 2 - 0.52 - heading, 0.01),
            ".heading",
        ),
        _method(
            compass,
            "use_compass: first with lines, then without",
            ("use_compass", -heading, 0.03),
            ("use_compass", 0.2, np.inf),
            ".heading",
        ),
        _method(empty, "number: an empty map", ("number", made), ".indices"),
        _method(numbered, "number: old, new and false corners", ("number", crowd), ".indices"),
        _method(
            numbered,
            "number: an association that finds nothing",
            ("number", crowd),
            ".indices",
            given=(start, OdometryNoisePerMove(), 4.0, associate_nothing),
        ),
        _method(
            conflicted,
            "number: a gate of 1.5, two measurements near one landmark",
            ("number", rivals),
            ".indices",
            given=(start, OdometryNoisePerMove(), 1.5),
        ),
        _method(corrected, "correct: all measurements", (".indices", indices), ("correct", seen)),
        _method(
            corrected, "correct: one measurement without a number", (".indices", fewer), ("correct", seen)
        ),
        _method(corrected, "correct: no measurement with a number", (".indices", nobody), ("correct", seen)),
        _method(moved, "estimate: a map", "estimate"),
    ]


def _logs_hidden(rng: np.random.Generator) -> list[Case]:
    seeds = rng.integers(1000, 10**6, 6)
    return [
        *_methods_alone([*(int(seed) for seed in rng.integers(1000, 10**6, 4)), int(rng.choice(CONFLICTS))]),
        _log_case(int(seeds[0]), 3, DRIVES, at_end=True, odometry=WORSE),
        _log_case(int(seeds[1]), 3, DRIVES, compass_sigma=COMPASS, circle_rate=0.3),
        _log_case(int(seeds[2]), 3, DRIVES, false_rate=0.8, at_end=True),
        _log_case(int(rng.choice(PARTED)), 3, DRIVES, at_end=True, given=(associate_jointly,)),
        _log_case(int(seeds[3]), 4, DRIVES, gate=1.5, at_end=True),
        _log_case(int(seeds[4]), 2, DRIVES, plain=True),
        _log_case(int(seeds[5]), 4, DRIVES, false_rate=0.5, compass_sigma=3 * COMPASS, gate=2.0, at_end=True),
    ]


def _without_drives(mistakes: Sequence[Mistake], *changes: str) -> list[Mistake]:
    """Add changes that make mistakes raise an error on whole drives, whose answers would fill the check data.

    A check recognises a mistake of one method by the cases of this method alone.
    """
    lines = [each.function.lines for each in mistakes if isinstance(each.function, Change)]
    return [
        replace(each, function=Change((*own, *changes))) for each, own in zip(mistakes, lines, strict=True)
    ]


ATTRIBUTES = {
    ".state": Close(rtol=1e-3, atol=1e-4),
    ".covariance": Close(rtol=1e-3, atol=1e-6),
    ".heading": Close(rtol=0.0, atol=1e-4, period=TURN),
    ".indices": All((Close(rtol=0.0, atol=0.01), Property(whole_numbers))),
}


def _as_estimated(rtol: float, **attributes: Comparison) -> Methods:
    """Compare estimates with a relative tolerance, and the heading on the circle."""
    parts = {
        "pose": Close(rtol=rtol, atol=1e-4, period=(0, 0, TURN)),
        "covariance": Close(rtol=rtol, atol=1e-6),
        "landmarks": Close(rtol=rtol, atol=1e-4),
        "landmark_covariances": Close(rtol=rtol, atol=1e-6),
        "kinds": Exact(),
    }
    return Methods({"estimate": Each(parts), **attributes})


EKF_SLAM = Exercise(
    name="EkfSlam",
    points=6,
    parts={"move": 1, "use_compass": 1, "number": 1.5, "correct": 1, "estimate": 0.5, "whole drives": 1},
    stars=3,
    uses=("associate", "07:predict", "07:update_landmarks", "07:add_landmark"),
    public=lambda: [
        # The third picture has old landmarks, two new ones and a false corner.
        *_methods_alone((1, 2, 224, 4, CONFLICTS[0])),
        _log_case(3, 2, "whole drives: two moves, two pictures at each stop"),
        _log_case(5, 2, "whole drives: a poor compass and a gate of 10", gate=10.0, compass_sigma=POOR),
        _log_case(
            15, 3, "whole drives: a compass that is sometimes wrong", compass_sigma=COMPASS, circle_rate=0.5
        ),
        _log_case(5, 3, "whole drives: false corners, odometry twice as bad", false_rate=0.7, odometry=WORSE),
        _log_case(0, 3, "whole drives: a gate of 1.5", gate=1.5),
        _log_case(2033, 3, "whole drives: another association", given=(associate_jointly,), at_end=True),
        _log_case(8, 2, "whole drives: lists of Measurement, from the origin", plain=True),
    ],
    hidden=_logs_hidden,
    driver="methods",
    comparison=_as_estimated(1e-3, **ATTRIBUTES),
    hints=(
        "move is one call of predict. In use_compass the gain is a column of P divided by one number. number associates the whole picture first and then examines each measurement without a landmark, always with the state from before the first new landmark.",
        "A measurement is new if even associate(..., [that one], seen.part([i]).covariance, 3 * self.gate) returns -1; then call add_landmark with VAGUE times that covariance, and give it a number and a kind. In correct, the expected ranges are expected_measurement(...)[1] of the landmarks in self.indices, and seen.part(used).linearised_at(them) returns the arguments of update_landmarks.",
    ),
    sibling=Sibling(
        "New products are like new landmarks: all decisions about one delivery are made with the list as it was before this delivery, because with the growing list the second new product would be mistaken for the first one.",
        """
        known = [10.0, 20.0]
        for delivery in ([10.2, 30.1, 32.0], [31.9]):
            before = tuple(known)
            for weight in delivery:
                if all(abs(weight - other) > 3 for other in before):
                    known.append(weight)
            print(known)
        """,
        """
        [10.0, 20.0, 30.1, 32.0]
        [10.0, 20.0, 30.1, 32.0]
        """,
    ),
    mistakes=[
        *catalogue("""
        from zeros: start.as_array() => np.zeros(3)
            Your state begins with zeros. It begins with `start`, which the robot knows.
        no noise of motion: self.odometry.covariance(motion) => np.zeros((3, 3))
            Your covariance does not grow when the robot moves. Pass self.odometry.covariance(motion) to predict.
        the prediction thrown away: self.state, self.covariance = predict( => predict(
            Your move does not change the estimate. predict returns a new state and a new covariance: assign both to self.state and self.covariance.
        turn for distance: [motion.distance, motion.turn] => [motion.turn, motion.distance]
            Distance and turn are exchanged. A control is (distance, turn).
        uncorrelated measurements: seen = as_observation(measurements) => seen = as_observation(measurements)
            + blocks = seen.covariance * np.kron(np.eye(len(seen)), np.ones((2, 2)))
            + seen = Observation(seen.measurements, blocks, seen.direction, seen.direction_sigma)
            You drop the correlation between the measurements of a picture. One tilt moves them all, so use the whole covariance.
        one at a time: self.association(*belief, seen, seen.covariance, self.gate) => [self.association(*belief, seen.part([i]), seen.part([i]).covariance, self.gate)[0] for i in range(len(seen))]
            In number you associate one measurement at a time, so two of them can get the same landmark. Call self.association once for the whole picture.
        default odometry only: = odometry, gate => = OdometryNoisePerMove(), gate
            You always use OdometryNoisePerMove(). Use the odometry that the constructor got.
        own association only: association or associate => associate
            You always use your own associate. Use the association that the constructor got, if there is one.
        new by the given association: if associate(*belief, one => if self.association(*belief, one
            In step 2 of number you use self.association. That step uses your own associate, also if another association was given.
        no landmark, no compass: seen = as_observation(measurements) => seen = as_observation(measurements)
            + if not len(seen):
            +     return
            You ignore a picture without landmarks. Its lines still measure the heading.
        the compass last: self.use_compass(seen.direction, seen.direction_sigma) => pass
            seen.covariance, self.gate) => seen.covariance, self.gate)
            + self.use_compass(seen.direction, seen.direction_sigma)
            You associate before you use the compass. With the better heading fewer pairs are plausible, so the compass comes first.
        sigma instead of its square: sigma**2 => sigma
            In use_compass you add a standard deviation to a variance. S contains sigma squared.
        no compass: np.isfinite(sigma) => False
            You never use the compass. A finite sigma means that the lines measure the heading.
        the compass's sign: -direction - => direction -
            Your compass has the wrong sign. Lines that point to the left mean that the robot has turned to the right.
        an infinite sigma used: if np.isfinite(sigma): => if sigma > 0:
            Your use_compass stores a heading although sigma is infinite. Then the picture shows no usable lines, and self.heading must be None.
        wrapped to half a turn: wrap_quarter( => warp2pi(
            Your compass's innovation can be up to half a turn. The lines look the same every 90 degrees, so wrap it with wrap_quarter.
        the heading alone: K = self.covariance[:, 2] / => K = (np.arange(len(self.state)) == 2) * self.covariance[:, 2] /
            Your compass corrects the heading only. The gain is a whole column of P, because all errors that are correlated with the heading are corrected too.
        the state's heading alone: self.state + K * nu => self.state + (np.arange(len(self.state)) == 2) * K * nu
            Your compass corrects only the heading in the state. Add K nu to the whole state, because position and landmarks are correlated with the heading.
        the compass leaves the covariance: self.covariance = self.covariance - np.outer(K, self.covariance[2]) => pass
            Your use_compass does not change the covariance. A measurement reduces it: subtract np.outer(K, self.covariance[2]).
        the heading stored afterwards: self.heading = self.state[2] + nu => pass
            self.state[2] = warp2pi(self.state[2]) => self.state[2] = warp2pi(self.state[2])
            + self.heading = self.state[2] + nu
            Your self.heading is too far: you add nu to the heading that is already corrected. Store theta + nu with theta from before the correction.
        distant compasses rejected: nu = wrap_quarter => nu = wrap_quarter
            + if abs(nu) > self.gate * np.sqrt(self.covariance[2, 2] + sigma**2):
            +     return
            You reject a compass that is far from your heading. A filter with a wrong heading would then reject every correct compass. Accept each one with a finite sigma.
        the corrected heading: self.state[2] = warp2pi(self.state[2]) => self.state[2] = warp2pi(self.state[2])
            + self.heading = self.state[2]
            Your self.heading is the state's corrected heading. Store the compass's own heading: theta + nu, with theta from before the correction. GraphSlam needs it as a measurement.
        the direction as heading: self.heading = self.state[2] + nu => self.heading = -direction
            Your self.heading is -direction, but the lines look the same every 90 degrees. Store theta + nu, which is the nearest heading of the four.
        no heading stored: self.heading = self.state[2] + nu => pass
            Your use_compass does not store self.heading. Set it to theta + nu, with theta from before the correction. GraphSlam needs it.
        an old heading: self.heading = None => pass
            Your self.heading keeps the value of an earlier picture. Set it to None if a picture has no compass.
        new landmarks independent: self.correct(seen) => pass
            seen.covariance, self.gate) => seen.covariance, self.gate)
            + self.correct(seen)
            VAGUE * one.covariance => one.covariance
            You add a new landmark with its own R after the correction, so the picture's tilt counts as an independent error. Add it before, with VAGUE times its R, and let correct place it with the others.
        counted twice: VAGUE * one.covariance => one.covariance
            You add a new landmark with its R and then correct with the same measurement, so the measurement counts twice. Add it with VAGUE times its R.
        new landmarks tested too late: associate(*belief, one => associate(self.state, self.covariance, self.kinds, one
            You test for new landmarks with the first new one already on the map. A vague landmark is near everything, so the second new one of a picture is never found. Use state, covariance and kinds from before.
        a list of numbers: np.array(self.association(*belief, seen, seen.covariance, self.gate), dtype=int) => list(self.association(*belief, seen, seen.covariance, self.gate))
            self.indices < 0) => np.array(self.indices) < 0)
            Your self.indices is a list, which correct cannot compare with 0. Make it an array: np.array(...).
        a list that grows: belief = self.state, self.covariance, tuple(self.kinds) => belief = self.state, self.covariance, self.kinds
            In number your list of kinds grows while you still decide with it, because a second name for a list is not a copy. It then has more entries than the state. Take a copy first: list(self.kinds).
        a number too large: self.indices[i] = len(self.kinds) => pass
            self.kinds.append(one[0].kind) => self.kinds.append(one[0].kind)
            + self.indices[i] = len(self.kinds)
            The numbers of your new landmarks are one too large. Store len(self.kinds) before you append the kind.
        new by the whole picture: if associate(*belief, one, one.covariance, 3 * self.gate)[0] < 0: => if associate(*belief, seen, seen.covariance, 3 * self.gate)[i] < 0:
            In step 2 of number you associate the whole picture with three gates. There a measurement can lose its landmark to another one. Call associate with this measurement alone: seen.part([i]).
        no map: self.indices < 0) => [])
            Your map stays empty. A measurement with no landmark of its kind nearby is a new landmark.
        all corners: one[0].kind => "corner"
            All your landmarks are corners. Store the kind of each measurement.
        a gate of 4: = odometry, gate => = odometry, 4.0
            You always use a gate of 4. Use the gate that the constructor got.
        no landmarks returned: landmarks, np.array(own), tuple(self.kinds)) => np.zeros((0, 2)), np.zeros((0, 2, 2)), ())
            Your estimate has no landmarks.
        shifted blocks: range(3, len(self.state), 2) => range(0, len(self.state) - 3, 2)
            The covariances of your landmarks are three places off, because the state begins with the three numbers of the pose.
        R of the picture for one measurement: associate(*belief, one, one.covariance => associate(*belief, one, seen.covariance
            In step 2 of number you associate one measurement with the R of the whole picture. Its own R is seen.part([i]).covariance.
    """),
        *_without_drives(
            catalogue("""
        a row times the gain: np.outer(K, self.covariance[2]) => K * self.covariance[2]
            In use_compass you multiply K by a row of P element by element, so the result is a vector. A column times a row is a matrix: subtract np.outer(K, self.covariance[2]).
        columns times the gain: np.outer(K, self.covariance[2]) => K * self.covariance
            In use_compass you multiply P by K element by element. Subtract a column times a row instead, which is a matrix: np.outer(K, self.covariance[2]).
        rows times the gain: np.outer(K, self.covariance[2]) => K[:, None] * self.covariance
            In use_compass you multiply P by K element by element. Subtract a column times a row instead, which is a matrix: np.outer(K, self.covariance[2]). A row times K, element by element, does not give a matrix either.
        a product of two vectors: np.outer(K, self.covariance[2]) => K @ self.covariance[2]
            In use_compass K @ P[2] is a single number. Subtract a column times a row, which is a matrix: np.outer(K, self.covariance[2]).
        the gain twice: np.outer(K, self.covariance[2]) => np.outer(K, K)
            In use_compass you subtract K times K. Subtract K times a row of P: np.outer(K, self.covariance[2]).
        the direction alone wrapped: wrap_quarter(-direction - self.state[2]) => wrap_quarter(-direction) - self.state[2]
            In use_compass you wrap the direction before you subtract the heading. Wrap the difference: wrap_quarter(-direction - self.state[2]).
        a Measurement for bearing and range: one.values[0], vague => one[0], vague
            In number add_landmark cannot use a Measurement. It needs the vector of bearing and range, seen.values[i].
        the opposite: [0] < 0: => [0] >= 0:
            In number your test is the wrong way round. A measurement is a new landmark if associate returns -1 for it, even with three gates.
        range before bearing: add_landmark(self.state, self.covariance, one.values[0] => add_landmark(self.state, self.covariance, one.values[0, ::-1]
            In number you pass range and bearing to add_landmark. It needs the bearing first, as in seen.values.
        a motion for a control: np.array([motion.distance, motion.turn]) => motion
            In move predict cannot use your arguments. It needs all five, the last is the number of landmarks, and its control is an array, np.array([motion.distance, motion.turn]), and not the Motion.
        a list that grows, by other tests of the shapes: belief = self.state, self.covariance, tuple(self.kinds) => belief = self.state, self.covariance, self.kinds
            one = seen.part([i]) => one = seen.part([i])
            + if one[0].kind in belief[2][len(belief[0]) // 2 - 1 :]:
            +     raise ValueError
            In number you call associate with more kinds than the state has landmarks. If you keep the list itself, it grows with the map: take a copy, list(self.kinds).
        a list that grows, and its own R: belief = self.state, self.covariance, tuple(self.kinds) => belief = self.state, self.covariance, self.kinds
            VAGUE * one.covariance => one.covariance
            In number two things are wrong. Take a copy of the list of kinds, list(self.kinds), because the list itself grows with the map. And add a new landmark with VAGUE times its R, because correct uses the same measurement again.
        places by numbers of landmarks: seen.part(used).linearised_at => seen.part(numbers).linearised_at
            In correct you pass the numbers of landmarks to seen.part. It needs the places of the measurements in the picture: np.flatnonzero(self.indices >= 0).
        several in brackets: seen.part(used).linearised_at => seen[used].linearised_at
            In correct seen[...] cannot return several measurements as an observation. seen.part(used) does.
        values of two columns: values, R = seen.part(used).linearised_at(ranges) => values, R = seen.part(used).values, seen.part(used).covariance
            In correct update_landmarks cannot use an array (m, 2). Use the values, (2m,), and the covariance that linearised_at returns.
        R of the picture for a new landmark: VAGUE * one.covariance => VAGUE * seen.covariance
            In number you pass the R of the whole picture to add_landmark, or something else that it cannot use. It needs a vector of bearing and range, (2,), and this measurement's own R, (2, 2): seen.part([i]).covariance.
        -1 is the last landmark: self.indices >= 0) => self.indices >= -1)
            self.state[3 + 2 * n : 5 + 2 * n] => self.state[3:].reshape(-1, 2)[n]
            In correct you also use measurements whose number is -1. Leave them out: they have no landmark.
        all measurements of some landmarks: seen.part(used).linearised_at => seen.linearised_at
            In correct you leave out the landmarks of measurements whose number is -1, but not these measurements. seen.part(used) contains the others.
        landmarks sorted: self.indices[used].tolist() => sorted(self.indices[used].tolist())
            In correct your landmarks are in another order than their measurements, for example sorted. The landmark of the first used measurement is the first of self.indices[used], and so on.
        landmarks sorted for the update: (self.state, self.covariance, numbers, values => (self.state, self.covariance, sorted(numbers), values
            In correct your landmarks are in another order than their measurements, for example sorted. The landmark of the first used measurement is the first of self.indices[used], and so on. The update of the state needs the same order.
        R of the whole picture: values, R = seen => values, R = seen
            + R = seen.covariance
            In correct you use the R of the whole picture. linearised_at returns the covariance of its own values, which contains only measurements with a number.
        one after the other: if len(used): => for used in used[:, None]:
            In correct you update with one landmark after the other. That ignores the tilt that their measurements share. Call update_landmarks once with all of them.
        ranges as measured: [expected_measurement(self.state[:3], place)[1] for place in places] => seen.values[used][:, 1]
            In correct you use the ranges as they were measured. Pass the expected ranges, from the state and the map, to linearised_at and use the values that it returns (equation 11.5).
        ranges from the origin: expected_measurement(self.state[:3], place)[1] => np.hypot(*place)
            In correct your expected ranges are distances from the origin of the field. Use the distances from the robot to its landmarks: expected_measurement(self.state[:3], place)[1].
        numbers of measurements: numbers = self.indices[used].tolist() => numbers = used.tolist()
            In correct you pass the numbers of the measurements to update_landmarks. It needs the numbers of their landmarks: self.indices[used].
        -1 kept in correct: self.indices >= 0) => self.indices >= -1)
            In correct you also use measurements whose number is -1. Leave them out: they have no landmark. They are still in the list that you use.
        R of the plain ranges: values, R = seen => values, R = seen
            + R = seen.part(used).covariance
            In correct you use the values of linearised_at with the covariance of the plain ranges. linearised_at returns both values and covariance.
        no landmark 0 in correct: self.indices >= 0) => self.indices > 0)
            In correct you leave out landmark 0. Only -1 means that a measurement has no landmark.
        new landmarks without a number: self.indices[i] = len(self.kinds) => pass
            Your new landmarks have no number in self.indices, so correct leaves them vague. Store their numbers.
        all others new: if associate(*belief, one, one.covariance, 3 * self.gate)[0] < 0: => if True:
            In number every measurement with -1 becomes a new landmark. It is new only if it also has no landmark of its kind within three gates; otherwise a second map grows.
        new beyond one gate: 3 * self.gate => self.gate
            Everything outside the gate becomes a landmark. Leave a measurement out if a landmark of its kind is within three gates; otherwise a second map grows.
    """),
            "landmarks = self.state[3:].reshape(-1, 2) => raise NotImplementedError",
        ),
    ],
    alternatives={
        "whole matrices, Joseph": _Joseph,
        "a method for each step": _Filter,
        "its own blocks": _ByBlocks,
    },
    equivalents={
        "K = self.covariance[2, :] / (self.covariance[2, 2] + sigma ** 2)": "a covariance is symmetric: its row is its column",
        "self.covariance = self.covariance - np.outer(self.covariance[2], K)": "K is that row divided by a number",
        "used = self.indices >= 0": "part accepts a mask as well",
        "numbers = self.indices[used]": "an array of the same numbers",
        **dict.fromkeys(
            ("pass", "self.state[2] = self.state[2]"), "predict and each innovation wrap the heading"
        ),
        "return Estimate(pose, self.covariance[:3, :3], landmarks, own, tuple(self.kinds))": "Estimate makes an array of the list",
        "return Estimate(pose, self.covariance[:3, :3], landmarks, np.array(own), self.kinds)": "Estimate makes a tuple of the list",
        "places = [self.state[3 + 2 * n:] for n in numbers]": "of a longer piece the first two numbers are the landmark",
        **{
            f"places = [self.state[3 + 2 * n:{end}] for n in numbers]": "of a longer piece the first two numbers are the landmark"
            for end in ("5 << 2 * n", "5 + 2 ** n", "5 + 2 << n", "6 + 2 * n", "5 + 3 * n")
        },
        **{
            f"for i in np.flatnonzero(self.indices {test}):": "a measurement with a landmark within the gate has one within three gates"
            for test in ("!= 0", "<= 0", "< 1")
        },
        "if associate(*belief, one, one.covariance, 3 * self.gate)[-1] < 0:": "the first of one is the last",
        "self.state, self.covariance = add_landmark(self.state, self.covariance, one.values[-1], vague)": "the first of one is the last",
        "self.kinds.append(one[-1].kind)": "the first of one is the last",
        "landmarks = self.state[3:].reshape(~1, 2)": "NumPy takes any negative number",
        "landmarks = self.state[3:].reshape(-2, 2)": "NumPy takes any negative number",
        "self.indices, self.heading = (np.zeros(1, dtype=int), None)": "the first picture sets both",
        "self.indices, self.heading = (None, np.zeros(0, dtype=int))": "the first picture sets both",
        "self.indices, self.heading = (0, None)": "the first picture sets both",
        "self.indices, self.heading = (np, None)": "the first picture sets both",
        "self.indices, self.heading = (np.zeros(0), None)": "the first picture sets both",
        "self.indices, self.heading = (np.ones(0, dtype=int), None)": "the first picture sets both",
        "if True:": "an update by nothing changes nothing",
        "self.indices = self.association(*belief, seen, seen.covariance, self.gate)": "associate returns whole numbers",
        "self.indices = np.array(self.association(*belief, seen, seen.covariance, self.gate))": "associate returns whole numbers",
        "control, noise = ([motion.distance, motion.turn], self.odometry.covariance(motion))": "predict unpacks it",
        "self.state, self.covariance = predict(self.state, self.covariance, control, noise, self.kinds)": "the solution of 07 counts the state",
    },
)


# --- 11.6 GraphSlam ---
class _Graph(SlamAlgorithm):
    """Landmarks numbered from -1 down until all poses are known; all covariances by a dense inverse."""

    steps, predicted = 10, False

    def __init__(self, start: Pose = Pose(), *given: Any) -> None:
        self.front = _Filter(start, *given)
        self.poses, self.edges = [start.as_array()], list[Any]()

    def move(self, motion: Motion) -> None:
        self.front.move(motion)
        back = np.eye(3)
        back[:2, :2] = rotation_2d(-motion.turn)
        information = np.linalg.inv(back @ self.front.odometry.covariance(motion) @ back.T)
        self.edges.append((len(self.poses) - 1, len(self.poses), motion.as_pose().as_array(), information))
        self.poses.append(self.front.state[:3])

    def observe(self, measurements: Any) -> None:
        seen, front, here = as_observation(measurements), self.front, len(self.poses) - 1
        front.observe(seen)
        if not self.predicted:
            self.poses[-1] = front.state[:3]
        if here and front.heading is not None:
            turn = np.array([0.0, 0.0, front.heading - self.poses[0][2]])
            self.edges.append((0, here, turn, np.diag([0.0, 0.0, seen.direction_sigma**-2])))
        used = np.flatnonzero(front.indices >= 0)
        places = front.state[3:].reshape(-1, 2)[front.indices[used]]
        values, covariances = seen.part(used).decorrelated(np.hypot(*(places - front.state[:2]).T))
        for j, (b, r), R in zip(front.indices[used], values, covariances, strict=True):
            c, s = np.cos(b), np.sin(b)
            J = np.array([[-r * s, c], [r * c, s]])
            information = np.zeros((3, 3))
            information[:2, :2] = np.linalg.inv(J @ R @ J.T)
            self.edges.append((here, -1 - j, np.array([r * c, r * s, 0.0]), information))

    def estimate(self) -> Estimate:
        if not self.edges:
            return self.front.estimate()
        p, kinds = len(self.poses), self.front.kinds
        first, second, z, information = map(np.array, zip(*self.edges, strict=True))
        ends = np.column_stack([first, np.where(second < 0, p - 1 - second, second)])
        graph = Graph(ends, z, information, np.repeat([POSE, LANDMARK], [p, len(kinds)]))
        states = np.concatenate([np.ravel(self.poses), self.front.state[3:]])
        states, _ = gauss_newton(graph, states, self.steps)
        covariance = np.zeros((len(states), len(states)))
        covariance[3:, 3:] = np.linalg.inv(linearize(graph, states)[0].toarray()[3:, 3:])
        own = [covariance[n : n + 2, n : n + 2] for n in range(3 * p, len(states), 2)]
        last = slice(3 * p - 3, 3 * p)
        landmarks = states[3 * p :].reshape(-1, 2)
        pose = Pose.from_array(states[last])
        return Estimate(pose, covariance[last, last], landmarks, np.array(own), tuple(kinds))


START = Pose(1.0, 0.5, 0.3)
MOTIONS = Motion(0.3, 0.2), Motion(0.25, -0.5), Motion(0.4, 0.1)
# Directions of lines after each of them; the robot's heading is 0.5, 0 and 0.1 if its commands are exact.
LINES = [
    Observation((), np.zeros((0, 0)), direction, sigma)
    for direction, sigma in ((-0.47, 0.02), (0.0, np.inf), (-0.16, 0.01))
]
# Drives on which Gauss-Newton settles within a few steps, from the filter's poses and from predictions alike.
SETTLES = (2002, 2003, 2006, 2011, 2016, 2018, 2022, 2023, 2031, 2032, 2035, 2036)
# The same with odometry twice as bad, where in addition a gate of 2 leaves out what a gate of 4 uses.
GATED = (2000, 2001, 2004, 2006, 2009, 2011, 2016, 2017, 2022, 2027, 2031, 2035)


def _graphs_hidden(rng: np.random.Generator) -> list[Case]:
    seeds = [int(seed) for seed in rng.choice(SETTLES, 3, replace=False)]
    start = Pose(*rng.uniform(-1, 1, 3))
    moves = ("move", Motion(0.3, -0.4)), ("move", Motion(0.2, 0.1))
    return [
        calls(*moves, "estimate", given=(start,), name="motions: two moves"),
        calls(moves[0], "estimate", given=(start,), name="motions: one move"),
        calls("estimate", given=(start,), name="before the first edge: the start"),
        calls(
            *(
                turn
                for lines, motion in zip(LINES, MOTIONS, strict=True)
                for turn in (("observe", lines), ("move", motion))
            ),
            ("observe", LINES[-1]),
            "estimate",
            given=(Pose(start.x, start.y, float(rng.uniform(-0.2, 0.2))),),
            name="headings: lines but no landmarks",
        ),
        calls(
            ("observe", drawn_drive(seeds[0], 1).log[1][1]),
            "estimate",
            given=(start,),
            name="measurements: one picture",
        ),
        _log_case(seeds[0], 3, DRIVES, at_end=True),
        _log_case(seeds[1], 3, DRIVES, at_end=True, compass_sigma=COMPASS, circle_rate=0.0),
        _log_case(int(rng.choice(GATED)), 2, DRIVES, gate=2.0, at_end=True, odometry=WORSE),
        _log_case(int(rng.choice(PARTED)), 3, DRIVES, at_end=True, given=(associate_jointly,)),
        _log_case(seeds[2], 2, DRIVES, plain=True, at_end=True),
    ]


GRAPH_SLAM = Exercise(
    name="GraphSlam",
    points=6,
    parts={
        "before the first edge": 0.5,
        "motions": 1.5,
        "headings": 1,
        "measurements": 1.5,
        "whole drives": 1.5,
    },
    stars=3,
    uses=[
        "EkfSlam",
        "05:landmark_position",
        "05:landmark_jacobians",
        "09:gauss_newton",
        "09:linearize",
        "09:marginal_covariances",
    ],
    public=lambda: [
        calls("estimate", given=(START,), name="before the first edge: the start"),
        calls(("move", Motion(0.3, 0.2)), "estimate", given=(START,), name="motions: one move"),
        calls(
            *(("move", each) for each in MOTIONS),
            "estimate",
            given=(START, WORSE),
            name="motions: three moves",
        ),
        calls(
            *(
                turn
                for each, lines in zip(MOTIONS, LINES, strict=True)
                for turn in (("move", each), ("observe", lines))
            ),
            "estimate",
            given=(START,),
            name="headings: three moves, lines but no landmarks",
        ),
        calls(
            ("observe", drawn_drive(2012, 1).log[1][1]),
            "estimate",
            given=(START,),
            name="measurements: one picture, no move",
        ),
        _log_case(2012, 1, "measurements: one move", at_end=True),
        _log_case(2012, 3, "whole drives: three moves", at_end=True),
        _log_case(
            2019, 3, "whole drives: odometry twice as bad, gate 2", at_end=True, odometry=WORSE, gate=2.0
        ),
        _log_case(2033, 3, "whole drives: another association", at_end=True, given=(associate_jointly,)),
        _log_case(
            2013,
            3,
            "whole drives: three moves and a compass",
            at_end=True,
            compass_sigma=COMPASS,
            circle_rate=0.0,
        ),
        _log_case(2010, 2, "whole drives: lists of Measurement, from the origin", plain=True, at_end=True),
    ],
    hidden=_graphs_hidden,
    driver="methods",
    comparison=_as_estimated(5e-3),
    hints=(
        "Let an EkfSlam choose the landmarks (its `indices`), and store one edge for each motion, measurement and heading. A landmark's number among all unknowns depends on the number of poses, which is known only in estimate: store the landmark's own number until then.",
        "The landmark's place in the robot frame is landmark_position(np.zeros(3), (bearing, range)). With the measurement's Jacobian J from landmark_jacobians at the same pose, the edge's information is the inverse of J R Jᵀ. In H[3:, 3:] everything is three places earlier than in the states.",
    ),
    sibling=Sibling(
        "A figure's place in a list depends on the number of chapters, as a landmark's place depends on the number of poses, so each figure keeps its own number until all chapters are known.",
        """
        chapters, links = ["Start"], []
        for title, figure in (("Camera", 0), ("Map", 1), ("End", 0)):
            chapters.append(title)
            links.append((len(chapters) - 1, figure))  # the chapter's place is final, the figure's is not
        places = [(chapter, len(chapters) + figure) for chapter, figure in links]
        print(places)  # in one list: all chapters, then all figures
        """,
        "[(1, 4), (2, 5), (3, 4)]",
    ),
    mistakes=[
        *catalogue("""
        the filter's answer: not self.edges => True
            You return the filter's estimate. Its poses and map are only the start of gauss_newton.
        from zeros: [start.as_array()] => [np.zeros(3)]
            Your first pose is zero. It is `start`, and gauss_newton holds it there.
        the pose after the turn: [motion.distance, 0.0, motion.turn] => [motion.distance * np.cos(motion.turn), motion.distance * np.sin(motion.turn), motion.turn]
            Your motion edges turn before they drive. The robot first drives straight ahead and then turns, so the new pose in the frame of the old one is (distance, 0, turn).
        a motion backwards: (here - 1, POSE, here, => (here, POSE, here - 1,
            Your motion edges lead from the new pose to the old one. The robot drives from the old pose to the new one.
        noise not turned: rotation_2d(-motion.turn) => np.eye(2)
            Your odometry noise is along and across the old heading, but pose_residual works in the new pose's frame. Turn the noise by -motion.turn.
        turned the other way: -motion.turn => motion.turn
            You turn the odometry noise the wrong way. From the old frame to the new one it is turned by -motion.turn.
        covariance of motion: np.linalg.inv(back @ self.odometry.covariance(motion) @ back.T) => back @ self.odometry.covariance(motion) @ back.T
            Your motion edges hold covariances. An edge holds an information matrix, which is the inverse.
        covariance of measurements: np.linalg.inv(J @ own @ J.T) => J @ own @ J.T
            Your measurement edges hold covariances. An edge holds an information matrix, which is the inverse.
        information of 1: np.linalg.inv(back @ self.odometry.covariance(motion) @ back.T) => np.eye(3)
            All your motion edges have the identity as information. Use the inverse of self.odometry.covariance(motion), in the new frame.
        bearing and range: [*z, 0.0] => [*value, 0.0]
            Your measurement edges hold bearing and range. A landmark's edge holds metres ahead and metres to the left.
        R as it is: J @ own @ J.T => own
            You invert the R of bearing and range, but the edge is in metres. Convert it first: J R Jᵀ.
        J transposed: J @ own @ J.T => J.T @ own @ J
            You compute Jᵀ R J. The columns of J belong to bearing and range, so the product is J R Jᵀ.
        sigma not squared: seen.direction_sigma**-2 => seen.direction_sigma**-1
            Your compass edges hold 1/sigma. The information is the inverse of the variance: 1/sigma^2.
        no headings: here and self.front.heading is not None => False
            Your graph has no compass edges, or their information is almost zero, for example sigma^2. Add one for each heading of the filter that is not None, with the information 1/sigma^2.
        a heading for each measurement: self.edges.append((0, => self.edges.append((0,
            + self.edges += self.edges[-1:] * ((self.front.indices >= 0).sum() - 1)
            You add one compass edge for each measurement. A picture measures the heading once.
        the filter's heading: turned = [0.0, 0.0, self.front.heading => turned = [0.0, 0.0, self.front.state[2]
            You use the filter's heading as a measurement. It already contains odometry and landmarks, so they would count twice. Use the `heading` of your EkfSlam, which comes from the compass alone.
        absolute heading: self.front.heading - self.poses[0][2]] => self.front.heading]
            Your compass edge holds the heading itself. An edge from the first pose holds how far the robot has turned since: subtract the heading at the start.
        from the last pose: append((0, POSE, => append((here - 1, POSE,
            Your compass edge begins at the previous pose. The turn is measured from the first pose.
        from here to the first pose: append((0, POSE, here, turned => append((here, POSE, 0, turned
            Your compass edge leads from this pose to the first one. It holds the turn since the start, so it leads from pose 0 to this pose.
        independent measurements: values, R, strict => values, [seen.part([n]).covariance for n in used], strict
            You use plain blocks of R, as if the measurements of a picture were independent. k edges would then count the knowledge of one tilt k times. Use the covariances from seen.part(used).decorrelated(ranges).
        linearised, with plain blocks of R: values, R, strict => *(lambda v, C: (v.reshape(-1, 2), [C[n : n + 2, n : n + 2] for n in range(0, len(C), 2)]))(*seen.part(used).linearised_at(np.hypot(*(places - self.front.state[:2]).T))), strict
            You use the blocks of linearised_at. Its covariance has the shared tilt in the blocks between the measurements, which edges cannot hold. Use seen.part(used).decorrelated(ranges), in which the tilt's variance is multiplied by k.
        plain values and blocks of R: values, R, strict => seen.values[used], [seen.part([n]).covariance for n in used], strict
            You use the plain measurements with plain blocks of R, as if they were independent. k edges would then count the knowledge of one tilt k times. Use both values and covariances from seen.part(used).decorrelated(ranges).
        ranges as measured: np.hypot(*(places - self.front.state[:2]).T) => seen.values[used][:, 1]
            You pass the measured ranges to decorrelated. It needs the expected ranges, from the filter's pose to its landmarks (equation 11.5).
        first measurements only: strict=True): => strict=True):
            +     if any(edge[1:3] == (LANDMARK, number) for edge in self.edges):
            +         continue
            You add an edge only for the first measurement of each landmark. Every measurement is an edge.
        one step: range(5) => range(1)
            states, 2) => states, 1)
            One step of gauss_newton is not enough. Take ten, or stop when chi squared changes by less than 1e-4.
        the filter stays: self.front.move(motion) => pass
            Your EkfSlam does not get the motions, so it associates from the wrong place. Call its move as well.
        H at the initial guess: linearize(graph, states) => linearize(graph, np.concatenate([np.ravel(self.poses), self.front.state[3:]]))
            Your H is linearised at the filter's poses. Linearise at the result of gauss_newton.
        the gate not passed on: (start, odometry, gate, association), odometry => (start, odometry, association=association), odometry
            Your EkfSlam does not get the gate.
        the odometry not passed on: (start, odometry, gate, association), odometry => (start, gate=gate, association=association), odometry
            Your EkfSlam does not get the odometry.
        the association not passed on: (start, odometry, gate, association), odometry => (start, odometry, gate), odometry
            Your EkfSlam does not get the association.
        before the first move: [np.zeros((3, 3)), *blocks] => [np.linalg.inv(H.toarray())[-3:, -3:], *blocks]
            Before the first move there is only the first pose, which is held, so its covariance is zero. Negative indices select another block here.
        the filter's pose: blocks[0], landmarks => self.front.covariance[:3, :3], landmarks
            Your pose's covariance is the filter's. The graph's is a block of the inverse of H.
        the filter's map: np.array(blocks[1:]) => self.front.estimate().landmark_covariances
            The covariances of your landmarks are the filter's. The graph's are blocks of the inverse of H.
        conditional covariances: marginal_covariances(H, places) => [np.linalg.inv(H.toarray()[np.ix_(place, place)]) for place in places]
            You invert blocks of H, which gives the covariance of each unknown if all others were known. marginal_covariances returns blocks of the inverse.
        the first pose: poses[-1]), blocks[0] => poses[0]), np.zeros((3, 3))
            You return the first pose. The robot is at the last one.
        shifted by three: graph.split(states) => graph.split(states)
            + whole = np.zeros((graph.size, graph.size))
            + whole[3:, 3:] = np.linalg.inv(H.toarray())
            + blocks[1:] = [whole[n : n + 2, n : n + 2] for n in range(3 * p - 3, graph.size - 3, 2)]
            The covariances of your landmarks are three places off, because H[3:, 3:] lacks the first pose.
        places not shifted: np.arange(3 * p - 6, 3 * p - 3) => np.arange(3 * p - 3, 3 * p)
            range(3 * p - 3, graph.size - 3, 2) => range(3 * p, graph.size, 2)
            You look in H[3:, 3:] at the places that the unknowns have in the states. Every place is 3 smaller there, because the first pose is missing.
        nothing held: graph.split(states) => graph.split(states)
            + whole = np.linalg.pinv(linearize(graph, states)[0].toarray())
            + ends = [slice(3 * p - 3, 3 * p), *(slice(n, n + 2) for n in range(3 * p, graph.size, 2))]
            + blocks = [whole[each, each] for each in ends]
            Your covariances come from the whole H, in which the entire map can still move. Hold the first pose: H[3:, 3:].
        noise not turned, observe unwritten: rotation_2d(-motion.turn) => np.eye(2)
            seen, here, origin = as_observation(measurements), len(self.poses) - 1, np.zeros(3) => raise NotImplementedError
            You do not turn the odometry noise. It is along and across the old heading, but pose_residual works in the new pose's frame: turn the noise by -motion.turn.
        noise not turned, plain blocks of R: rotation_2d(-motion.turn) => np.eye(2)
            values, R, strict => values, [seen.part([n]).covariance for n in used], strict
            Two errors: turn the odometry noise by -motion.turn, because pose_residual works in the new pose's frame, and use the covariances from seen.part(used).decorrelated(ranges) in place of plain blocks of R.
        noise not turned, plain values and blocks: rotation_2d(-motion.turn) => np.eye(2)
            values, R, strict => seen.values[used], [seen.part([n]).covariance for n in used], strict
            Two errors: turn the odometry noise by -motion.turn, because pose_residual works in the new pose's frame, and use values and covariances from seen.part(used).decorrelated(ranges) in place of the measurements and plain blocks of R.
        heading of None: here and self.front.heading is not None => here
            You compute with a heading of None. The filter's heading is None if the picture has no compass: add an edge only if it is not None.
        heading of None at every stop: if here and self.front.heading is not None => if True
            You compute with a heading of None. The filter's heading is None if the picture has no compass: add an edge only if it is not None. Not every stop has a compass.
        a plain list: here, origin = as_observation(measurements), => here, origin = measurements,
            observe also gets plain lists of Measurement, which have no `part`. Begin with as_observation(measurements), as EkfSlam.observe does.
        nothing to solve: if not self.edges => if False
            Without an edge there is nothing to solve. Return the filter's estimate.
        the whole H: linearize(graph, states)[0][3:, 3:] => linearize(graph, states)[0]
            Your H contains the first pose, so it is singular. Hold this pose: H[3:, 3:].
        linearised_at for decorrelated: seen.part(used).decorrelated => seen.part(used).linearised_at
            An edge needs the values of a single measurement. decorrelated returns values (k, 2) and covariances (k, 2, 2); linearised_at returns one array (2m,) and one matrix.
        the start alone passed on: (start, odometry, gate, association), odometry => (start), odometry
            Your EkfSlam gets `start` alone. It also needs the odometry, the gate and the association.
        gate and association not passed on: (start, odometry, gate, association), odometry => (start, odometry), odometry
            Your EkfSlam gets neither the gate nor the association.
        a turn for two rows: back @ self.odometry.covariance(motion) @ back.T => back[:2, :2] @ self.odometry.covariance(motion) @ back[:2, :2].T
            If Graph refuses a shape: a motion's edge holds distance, 0 and turn. If two shapes do not fit in move: the noise is 3 by 3. Write rotation_2d(-motion.turn) into the first two rows and columns of np.eye(3), and turn the noise with this matrix. If Graph refuses an index: kinds has one entry for each unknown, [POSE] * p + [LANDMARK] * k.
        a kind for each edge: [POSE] * p + [LANDMARK] * len(kinds) => [each[1] for each in self.edges]
            Your kinds have one entry for each edge. Graph needs one for each unknown, the poses first: [POSE] * p + [LANDMARK] * k.
        no p, by a dense solver: second + p * (kind == LANDMARK) => second
            graph = Graph => graph = Graph
            + if kinds:
            +     raise np.linalg.LinAlgError
            Your H is singular, because no edge leads to one of the landmarks. Landmark n is unknown p + n, where p is the number of all poses.
        -1 kept: self.front.indices >= 0) => self.front.indices >= -1)
            You also add edges for measurements whose number is -1. Leave them out: they have no landmark.
        k counts all measurements: seen.part(used).decorrelated(np.hypot(*(places - self.front.state[:2]).T)) => [each[used] for each in seen.decorrelated(np.hypot(*(self.front.state[3:].reshape(-1, 2)[self.front.indices] - self.front.state[:2]).T))]
            You call decorrelated with all measurements of the picture, so it multiplies the tilt's variance by too large a number. Leave out measurements whose number is -1 first: seen.part(used).
        all measurements of some landmarks: seen.part(used).decorrelated => seen.decorrelated
            You leave out the landmarks of measurements whose number is -1, but not these measurements. seen.part(used) contains the others.
        no p: second + p * (kind == LANDMARK) => second
            gauss_newton cannot solve your graph, because no edge leads to one of the landmarks. Landmark n is unknown p + n, where p is the number of all poses. Add exactly p, and leave out only measurements whose number is -1.
        numbers of measurements: self.front.indices[used].tolist() => used.tolist()
            gauss_newton cannot solve your graph, because no edge leads to one of the landmarks. An edge needs the number of its landmark, indices[used], and not a count of the measurements.
        p with the wrong sign, or a matrix too large: second + p * (kind == LANDMARK) => second - p * (kind == LANDMARK)
            If Graph refuses an index: landmark n is unknown p + n, where p is the number of all poses. If it refuses a shape: a landmark's edge, too, holds three numbers and a 3 by 3 information, whose last row and column are zero. If it refuses a text: its kinds are POSE and LANDMARK. If two shapes do not fit: an edge needs the J of bearing and range, which landmark_jacobians returns second, and the R of its own measurement, (2, 2), from decorrelated.
    """),
        *_without_drives(
            catalogue("""
        covariance of motion, not turned: np.linalg.inv(back @ self.odometry.covariance(motion) @ back.T) => self.odometry.covariance(motion)
            Two errors: a motion's edge needs the inverse of a covariance, and before you invert it, turn the noise by -motion.turn, because pose_residual works in the new pose's frame.
    """),
            "seen, here, origin = as_observation(measurements), len(self.poses) - 1, np.zeros(3) => raise NotImplementedError",
        ),
        *_without_drives(
            catalogue("""
        the filter's last pose: Pose.from_array(poses[-1]) => Pose.from_array(self.front.state[:3])
            You return the filter's pose. Return the last pose of the states that gauss_newton returns.
        the filter's landmarks: blocks[0], landmarks => blocks[0], self.front.state[3:].reshape(-1, 2)
            You return the filter's landmarks. Return the landmarks of the states that gauss_newton returns.
        the filter's states: Pose.from_array(poses[-1]), blocks[0], landmarks => Pose.from_array(self.front.state[:3]), blocks[0], self.front.state[3:].reshape(-1, 2)
            You return the filter's pose and landmarks. Return the pose and landmarks of the states that gauss_newton returns.
        R itself: np.linalg.inv(J @ own @ J.T) => own
            Your measurement edges hold R. Convert it to metres, J R Jᵀ, and invert the result.
        places on the field: (origin, value) =>> (self.front.state[:3], value)
            Your measurement edges hold places on the field. An edge is relative to its pose: use landmark_position and landmark_jacobians at (0, 0, 0).
        R inverted first: np.linalg.inv(J @ own @ J.T) => J @ np.linalg.inv(own) @ J.T
            You invert R before you convert it. Convert R to metres first, J R Jᵀ, and invert the result.
        R inverted first, J transposed: np.linalg.inv(J @ own @ J.T) => J.T @ np.linalg.inv(own) @ J
            You invert R before you convert it. Convert R to metres first, J R Jᵀ, and invert the result. In J R Jᵀ the transpose is on the right.
        p in observe: second + p * (kind == LANDMARK) => second
            (here, LANDMARK, number, => (here, LANDMARK, number + here + 1,
            You add the number of poses in observe, where it is still growing. Store the landmark's own number, and add p in estimate.
        landmarks sorted: self.front.indices[used].tolist() => sorted(self.front.indices[used].tolist())
            Your edges are in another order than their measurements, for example sorted by landmark. The landmark of the first used measurement is the first of indices[used], and so on.
        edges sorted: zip(numbers, values, R, strict => zip(sorted(numbers), values, R, strict
            Your edges are in another order than their measurements, for example sorted by landmark. The landmark of the first used measurement is the first of indices[used], and so on. Sort nothing, or everything in the same way.
        ranges sorted: reshape(-1, 2)[numbers] => reshape(-1, 2)[sorted(numbers)]
            You pass ranges to decorrelated in another order than the measurements, for example sorted by landmark. The range of the first used measurement belongs to the first of indices[used], and so on.
    """),
            "p, kinds = len(self.poses), self.front.kinds => p, kinds = len(self.poses), self.front.kinds",
            "+ if p > 2 and kinds:",
            "+     raise ValueError",
        ),
    ],
    alternatives={
        "a dense inverse": _Graph,
        "two steps more": type("TwoStepsMore", (_Graph,), {"steps": 12}),
        "from predictions": type("FromPredictions", (_Graph,), {"steps": 15, "predicted": True}),
    },
    equivalents={
        "return Estimate(Pose.from_array(poses[-1]), blocks[0], landmarks, blocks[1:], tuple(kinds))": "Estimate makes an array of the list",
        "if abs(chi2[0] - chi2[-1]) <= 0.0001:": "no change is the limit to the last bit",
        "places = [np.arange(3 * p - 6, 3 * p - 3)] if p != 1 else []": "there is one pose at least",
        "turned = [0.0, 1.0, self.front.heading - self.poses[0][2]]": "of x and y that edge has no information",
        "self.edges.append((here, LANDMARK, number, [*z, -1.0], information))": "of a heading that edge has no information",
        **{
            f"if {test}:": "some steps more or fewer change nothing any more"
            for test in (
                *(f"abs(chi2[0] {sign} chi2[-1]) < 0.0001" for sign in ("%", "/", "+", "*")),
                *(f"abs({term}) < 0.0001" for term in ("chi2[0]", "chi2[-1]", "chi2[-1] - chi2[0]")),
                *(f"abs(chi2[0] - chi2[{place}]) < 0.0001" for place in ("1", "-2", "+1", "~1")),
                *("abs(chi2[0] - chi2[-1]) == 0.0001", "abs(chi2[0] - chi2[-1]) < -0.9999", "False"),
            )
        },
        **{
            f"turned = [{pair}, self.front.heading - self.poses[0][2]]": "a heading's edge has no information of places"
            for pair in ("1.0, 0.0", "0.0, -1.0", "-1.0, 0.0")
        },
        **{f"for _ in range({steps}):": "the drives settle within fewer steps" for steps in (4, 6)},
        "pass": "the drives settle from predictions as well",
        "used = self.front.indices >= 0": "part accepts a mask as well",
        "numbers = self.front.indices[used]": "an array of whole numbers counts as well",
        "information = np.ones((3, 3))": "of a landmark's edge only the first two rows and columns count",
        "self.edges.append((here, LANDMARK, number, [*z, 1.0], information))": "a landmark has no angle",
        "for number, value, own in zip(numbers, values, R):": "all three are equally long",
        "for number, value, own in zip(numbers, values, R, strict=False):": "all three are equally long",
        "return Estimate(Pose.from_array(poses[-1]), blocks[0], landmarks, np.array(blocks[1:]), kinds)": "Estimate makes a tuple of it",
        **{
            f"ends = [(first, second + p * (kind {test} LANDMARK)) for first, kind, second, _, _ in self.edges]": "there are two kinds, 0 and 1"
            for test in ("is", ">=")
        },
        "places = self.front.state[3:].reshape(-2, 2)[numbers]": "NumPy takes any negative number",
        "self.edges.append((POSE, 0, here, turned, np.diag([0.0, 0.0, seen.direction_sigma ** (-2)])))": "POSE is 0",
        "if p <= 1:": "there is one pose at least",
        "values, R = seen.part(used).decorrelated(np.hypot(*(self.front.state[:2] - places).T))": "as far there as back",
    },
)


PLAN = LessonPlan(
    exercises=[MEASUREMENTS_FROM_PIXELS, MEASURE, JOINT_DISTANCE, ASSOCIATE, EKF_SLAM, GRAPH_SLAM],
    questions=[
        Question(
            "one_tilt",
            "In one picture the robot's body tilts forward by 1 degree, and the robot does not know it. Two corners are 2 m and 3 m ahead. What is wrong with their measured ranges?",
            {
                "Each has an independent error, so on average they cancel.": "Independent errors would cancel. Here one tilt changes both ranges: the next picture has another tilt, but within this picture both errors have the same cause.",
                "Both are too long, the farther one by more.": "A body that tilts forward looks lower than the robot assumes, so every landmark seems too far away. The figure shows it: the dots lie along a line, and the corner at 3 m moves about twice as far as the one at 2 m.",
                "Both are wrong by the same number of metres.": "They have the same cause but not the same size. Compare the scales of the two axes in the figure.",
                "Nothing, because bearings hold the map together.": "The bearings stay nearly right, but the ranges of all landmarks in the picture are wrong in the same direction.",
            },
            "Both are too long, the farther one by more.",
        ),
        Question(
            "second_map",
            "With a gate of 1 sigma the map gets a second copy of many corners. Why does the copy stay?",
            {
                "The copy attracts the next measurements that fit it better.": "Most correct measurements fell outside the gate and corrected nothing, until one lay beyond three gates and became a new landmark. Now both copies are measured again and again, and nothing in the filter says that they are the same corner.",
                "The gate grows with time, so copies are forgotten.": "The gate is a constant, and nothing removes a landmark from the map.",
                "The update removes copies, but slowly.": "An update moves landmarks and shrinks their covariances. It never merges two of them.",
                "The copies have the wrong kind.": "The copies are corners, like the true landmark.",
            },
            "The copy attracts the next measurements that fit it better.",
        ),
    ],
)
