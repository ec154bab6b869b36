"""Lesson 11, SLAM on the field: its exercises, what students get wrong in them, and other right ways to write them."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.optimize import linear_sum_assignment

from nao_course.exercises import (
    All,
    Case,
    Close,
    Each,
    Exact,
    Exercise,
    LessonPlan,
    Methods,
    Mistake,
    Property,
    Question,
    Unordered,
    calls,
)
from nao_course.geometry import Pose, rotation_2d, wrap_angle
from nao_course.graphs import LANDMARK, POSE, Graph
from nao_course.lessons.slam_on_the_field import GREEN, POST_RADIUS, VAGUE, YELLOW
from nao_course.lessons.slam_on_the_field.laws import whole_numbers
from nao_course.lessons.slam_on_the_field.system.association import associate_jointly
from nao_course.lessons.slam_on_the_field.system.drives import FieldOdometry
from nao_course.lessons.slam_on_the_field.system.observation import Observation, as_observation
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

(
    rgb_to_hsl,
    white_threshold,
    color_labels,
    find_goalposts,
    find_corners,
    pixel_to_ground,
    ground_to_measurement,
    paper_distance,
    paper_bearing,
    predict,
    update_landmarks,
    add_landmark,
    linearize,
    gauss_newton,
) = map(
    earlier,
    (
        "01:rgb_to_hsl",
        "01:white_threshold",
        "01:color_labels",
        "02:find_goalposts",
        "03:find_corners",
        "04:pixel_to_ground",
        "04:ground_to_measurement",
        "04:paper_distance",
        "04:paper_bearing",
        "07:predict",
        "07:update_landmarks",
        "07:add_landmark",
        "09:linearize",
        "09:gauss_newton",
    ),
)


# --- 11.1 measurements_from_pixels ---


def _measured(posts: Any, corners: Any, view: CameraView, **changed: Any) -> Any:
    radius = changed.get("radius", POST_RADIUS)
    made = []
    for pixels, kind in ((posts, "post"), (corners, "corner")):
        points = pixel_to_ground(np.asarray(pixels, dtype=float), view)
        values = ground_to_measurement(points)
        if changed.get("paper"):
            values = np.stack([function(pixels, view) for function in (paper_bearing, paper_distance)], axis=1)
        for (bearing, away), point in zip(values, points, strict=True):
            if not changed.get("horizon_kept") and not np.isfinite(point).all():
                continue
            if changed.get("along_x"):
                bearing, away = np.arctan2(point[1], point[0] + radius), np.hypot(point[0] + radius, point[1]) - radius
            grown = away + radius * (kind == "post" or bool(changed.get("all_grow")))
            if changed.get("cartesian"):
                bearing, grown = point
            if changed.get("turned"):
                bearing = -bearing
            if changed.get("degrees"):
                bearing = np.degrees(bearing)
            if changed.get("exchanged"):
                made.append(Measurement(float(grown), float(bearing), kind))  # type: ignore[arg-type]
                continue
            named = {"post": "corner", "corner": "post"}[kind] if changed.get("swapped") else kind
            named = "corner" if changed.get("all_corners") else named
            made.append(Measurement(float(bearing), abs(float(grown)), named))  # type: ignore[arg-type]
    return made


def _changed_measured(**changed: Any) -> Any:
    return lambda posts, corners, view: _measured(posts, corners, view, **changed)


def _measured_at_once(posts: Any, corners: Any, view: CameraView) -> Any:
    """All points together, the kinds beside them."""
    points = pixel_to_ground(np.vstack([np.reshape(posts, (-1, 2)), np.reshape(corners, (-1, 2))]), view)
    kinds: list[LandmarkKind] = ["post"] * len(posts) + ["corner"] * len(corners)
    return [
        Measurement(float(np.arctan2(y, x)), float(np.hypot(x, y)) + (POST_RADIUS if kind == "post" else 0.0), kind)
        for (x, y), kind in zip(points, kinds, strict=True)
        if not np.isnan(x)
    ]


def _measured_corners_first(posts: Any, corners: Any, view: CameraView) -> Any:
    by_kind = _measured(posts, corners, view)
    return tuple(sorted(by_kind, key=lambda each: (each.kind, -each.bearing)))


def _measured_by_complex(posts: Any, corners: Any, view: CameraView) -> Any:
    made = []
    for kind, pixels in {"corner": corners, "post": posts}.items():
        x, y = pixel_to_ground(np.asarray(pixels, dtype=float), view).T
        toward = (x + 1j * y)[np.isfinite(x)]
        away = np.abs(toward) + (kind == "post") * POST_RADIUS
        made += [
            Measurement(float(b), float(r), kind)  # type: ignore[arg-type]
            for b, r in zip(np.angle(toward), away, strict=True)
        ]
    return made


def _a_view(yaw: float = 0.0, pitch: float = -24.6, size: tuple[int, int] = (320, 240)) -> CameraView:
    """What the robot believes of its bottom camera; degrees of its head."""
    return NAO_V4.view("bottom", float(np.radians(yaw)), float(np.radians(pitch)), size)


NO_PIXELS: Array = np.zeros((0, 2))


def _pixels_public() -> list[Case]:
    post, corners = np.array([[200.0, 110.0]]), np.array([[60.0, 150.0], [250.0, 200.0]])
    high = np.array([[100.0, 2.0], [150.0, 120.0]])
    return [
        Case((NO_PIXELS, corners, _a_view()), "two corners, no post"),
        Case((post, NO_PIXELS, _a_view()), "a post, no corner"),
        Case((post, corners, _a_view(yaw=30.0)), "a post and two corners, the head turned to the left"),
        Case((np.array([[40.0, 90.0], [260.0, 95.0]]), corners[:1], _a_view(yaw=-20.0)), "both posts and a corner"),
        Case((high, high + (20.0, 30.0), _a_view(pitch=-38.0)), "one point of four above the horizon"),
        Case((NO_PIXELS, NO_PIXELS, _a_view()), "nothing found"),
    ]


def _pixels_hidden(rng: np.random.Generator) -> list[Case]:
    cases = []
    for posts, corners, pitch in ((1, 0, -24.0), (0, 2, -20.0), (2, 3, -31.0), (1, 2, -37.0), (2, 2, -38.0)):
        pixels = rng.uniform((5, 20), (315, 235), (posts + corners, 2))
        if pitch < -36:
            pixels[:: 2, 1] = rng.uniform(0, 6, len(pixels[::2]))  # there the horizon is in the picture
        cases.append(Case((pixels[:posts], pixels[posts:], _a_view(rng.uniform(-60, 60), pitch))))
    return cases


AS_MEASURED = Unordered(Close(atol=1e-6, period=(TURN, 0)))

MEASUREMENTS_FROM_PIXELS = Exercise(
    name="measurements_from_pixels",
    points=1,
    stars=1,
    uses=("04:pixel_to_ground", "04:ground_to_measurement"),
    public=_pixels_public,
    hidden=_pixels_hidden,
    comparison=AS_MEASURED,
    hints=(
        "Two calls of lesson 04 turn pixels into bearings and ranges. What is above the horizon has come through them as NaN.",
        "Loop over the two kinds, and over the rows of ground_to_measurement(pixel_to_ground(pixels, view)); make a Measurement of each row whose range is finite.",
    ),
    mistakes=[
        Mistake(
            "the horizon",
            _changed_measured(horizon_kept=True),
            "A point at or above the horizon has no place on the ground: pixel_to_ground says NaN, and a Measurement refuses that. Leave such points out.",
        ),
        Mistake(
            "kinds exchanged",
            _changed_measured(swapped=True),
            "Your kinds are exchanged: `posts` are of kind \"post\", `corners` of kind \"corner\".",
        ),
        Mistake(
            "all are corners",
            _changed_measured(all_corners=True),
            "All your measurements are corners, which is what Measurement takes unless you say more: posts are of kind \"post\".",
        ),
        Mistake(
            "the post's front",
            _changed_measured(radius=0.0),
            "Nearly. What the camera sees of a post is its front, POST_RADIUS before the middle that the map has. Add it to the range of posts.",
        ),
        Mistake(
            "too near",
            _changed_measured(radius=-POST_RADIUS),
            "You take the post's radius off. Its middle is farther away than its front.",
        ),
        Mistake(
            "corners have no radius",
            _changed_measured(all_grow=True),
            "You add the radius to corners as well. A corner is flat.",
        ),
        Mistake(
            "x and y",
            _changed_measured(cartesian=True),
            "You take x and y of the ground for bearing and range: ground_to_measurement has to come in between.",
        ),
        Mistake(
            "the paper's angles",
            _changed_measured(paper=True),
            "These are the paper's distances, from below the camera and without the head's yaw. Take pixel_to_ground.",
        ),
        Mistake(
            "to the right",
            _changed_measured(turned=True),
            "Your bearings have the other sign: they are positive to the left.",
        ),
        Mistake(
            "degrees",
            _changed_measured(degrees=True),
            "Your bearings are degrees; a Measurement wants radians.",
        ),
        Mistake(
            "corners forgotten",
            lambda posts, corners, view: _measured(posts, NO_PIXELS, view),
            "Your corners are missing.",
        ),
        Mistake(
            "posts forgotten",
            lambda posts, corners, view: _measured(NO_PIXELS, corners, view),
            "Your posts are missing.",
        ),
        Mistake(
            "range before bearing",
            _changed_measured(exchanged=True),
            "Range and bearing are exchanged: it is Measurement(bearing, range, kind).",
        ),
        Mistake(
            "along x",
            _changed_measured(along_x=True),
            "You move a post's foot along x. Its middle lies behind it as the robot looks at it: the radius goes onto the range.",
        ),
        Mistake(
            "one for all",
            lambda posts, corners, view: [
                each
                for pixels, found in ((posts, _measured(posts, NO_PIXELS, view)), (corners, _measured(NO_PIXELS, corners, view)))
                if len(found) == len(pixels)
                for each in found
            ],
            "Where one point lies above the horizon you leave the others out, too. Look at each row by itself.",
        ),
        Mistake(
            "bare tuples",
            lambda posts, corners, view: [(each.bearing, each.range, each.kind) for each in _measured(posts, corners, view)],
            "Your list holds tuples. Make a Measurement of each: Measurement(bearing, range, kind).",
        ),
        Mistake(
            "an array",
            lambda posts, corners, view: np.array(
                [(each.bearing, each.range) for each in _measured(posts, corners, view)]
            ).reshape(-1, 2),
            "That is an array of bearings and ranges. A list of Measurement is wanted: each also has its kind.",
        ),
    ],
    alternatives={
        "all at once": _measured_at_once,
        "another order, a tuple": _measured_corners_first,
        "complex numbers": _measured_by_complex,
    },
    equivalents={
        "for pixels, kind, radius in ((corners, 'corner', 0.0), (posts, 'post', POST_RADIUS)):": "any order will do",
    },
)


# --- 11.2 measure ---


def _seen(picture: Any, view: CameraView, **changed: Any) -> Any:
    green, yellow = changed.get("limits", (GREEN, YELLOW))
    mean = changed.get("mean", lambda one: rgb_to_hsl(one)[2].mean())(picture)
    labels = color_labels(picture, green, yellow, changed.get("threshold", white_threshold)(float(mean)))
    posts, corners = find_goalposts(labels.copy()), find_corners(labels.copy())
    if changed.get("rows"):
        posts, corners = posts[:, ::-1], corners[:, ::-1]
    if changed.get("exchanged"):
        posts, corners = corners, posts
    if changed.get("no_posts"):
        posts = NO_PIXELS
    if changed.get("no_corners"):
        corners = NO_PIXELS
    return _measured(posts, corners, changed.get("view", lambda one: one)(view))


def _changed_seen(**changed: Any) -> Any:
    return lambda picture, view: _seen(picture, view, **changed)


def _seen_by_numbers(picture: Any, view: CameraView) -> Any:
    """The mean lightness by NumPy alone."""
    return _measured(*_found(picture, np.mean([picture.max(axis=2), picture.min(axis=2)])), view)


def _found(picture: Any, lightness: float) -> tuple[Any, Any]:
    """Posts and corners at a mean lightness."""
    bands = (GREEN, YELLOW, white_threshold(lightness))
    labels = color_labels(picture, *bands)
    return find_goalposts(labels), find_corners(labels)


def _seen_by_a_sample(picture: Any, view: CameraView) -> Any:
    """The mean lightness of every seventh pixel."""
    return tuple(_measured(*_found(picture, rgb_to_hsl(picture)[2].ravel()[::7].mean()), view))


def _seen_corners_first(picture: Any, view: CameraView) -> Any:
    labels = color_labels(picture, GREEN, YELLOW, white_threshold(rgb_to_hsl(picture)[2].mean()), 0.16)
    corners, posts = find_corners(labels, 5, 40), find_goalposts(labels)
    return _measured(NO_PIXELS, corners, view) + _measured(posts, NO_PIXELS, view)


# From here the reference finds what is to be found: corners, posts, both of them.
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
    named = ("a post and two corners", "a post and four corners", "two posts", "one post, two corners")
    cases = [Case((Pose(*place), 0.0), name) for place, name in zip(PLACES, named, strict=False)]
    return [
        *cases,
        Case((Pose(1.77, 0.57, -1.31), 0.4), "the first again, the body turned to the right and the head to the left"),
        Case((Pose(0.6, 0.5, -0.25), 0.0, 0.6), "two posts in poor light"),
        Case((Pose(0.5, 0.0, 3.0), 0.0), "nothing to see"),
    ]


def _pictures_hidden(rng: np.random.Generator) -> list[Case]:
    cases = []
    for number in rng.permutation(len(PLACES))[:6]:
        x, y, theta = PLACES[number] + rng.normal(0.0, 0.01, 3)
        yaw = float(rng.uniform(-0.5, 0.5))
        cases.append(Case((Pose(x, y, theta - yaw), yaw, float(rng.uniform(0.7, 1.0)), int(rng.integers(100)))))
    return cases


MEASURE = Exercise(
    name="measure",
    points=2,
    stars=1,
    uses=(
        "measurements_from_pixels",
        "01:rgb_to_hsl",
        "01:white_threshold",
        "01:color_labels",
        "02:find_goalposts",
        "03:find_corners",
    ),
    public=_pictures_public,
    hidden=_pictures_hidden,
    driver="nao_course.lessons.slam_on_the_field.drivers:on_taken_picture",
    comparison=Unordered(Close(rtol=0.0, atol=(0.02, 0.15), period=(TURN, 0))),
    hints=(
        "The order of the paper's section 4: lightness, threshold, labels; feet and corners in the labels; then exercise 11.1.",
        "rgb_to_hsl(picture) returns hue, saturation, lightness. Its mean goes into white_threshold, and that with GREEN and YELLOW into color_labels.",
    ),
    mistakes=[
        Mistake(
            "rows for columns",
            _changed_seen(rows=True),
            "Your points are (row, column). Lessons 02 and 03 give (u, v), which is what pixel_to_ground wants: hand them on as they are.",
        ),
        Mistake(
            "posts for corners",
            _changed_seen(exchanged=True),
            "Your posts are corners, and your corners posts: look at the order of the arguments of measurements_from_pixels.",
        ),
        Mistake("no posts", _changed_seen(no_posts=True), "Your posts are missing: find_goalposts finds their feet in the labels."),
        Mistake("no corners", _changed_seen(no_corners=True), "Your corners are missing: find_corners finds them in the labels."),
        Mistake(
            "a fixed threshold",
            _changed_seen(threshold=lambda mean: 120.0),
            "Your threshold is 120 or little more, and that is carpet: white_threshold takes the picture's mean lightness, from 0 to 255.",
        ),
        Mistake(
            "the mean of all numbers",
            _changed_seen(mean=np.mean),
            "You average red, green and blue. The threshold wants the mean lightness: the third answer of rgb_to_hsl.",
        ),
        Mistake(
            "the mean hue",
            _changed_seen(mean=lambda picture: rgb_to_hsl(picture)[0].mean()),
            "You average the hue. rgb_to_hsl returns hue, saturation, lightness; the threshold wants the last.",
        ),
        Mistake(
            "the median",
            _changed_seen(mean=lambda picture: np.median(rgb_to_hsl(picture)[2])),
            "You take the median of the lightness. Equation 1.4 has the mean.",
        ),
        Mistake(
            "the largest channel",
            _changed_seen(mean=lambda picture: picture.max(axis=2).mean()),
            "You average the largest of red, green and blue. Lightness is the middle between the largest and the smallest.",
        ),
        Mistake(
            "a threshold of its own",
            _changed_seen(threshold=lambda mean: 180.0),
            "Your threshold is a constant. It follows the picture's mean lightness, so that it holds in poor light, too.",
        ),
        Mistake(
            "the mean as threshold",
            _changed_seen(threshold=lambda mean: mean),
            "You take the mean lightness itself for the threshold. white_threshold makes one of it.",
        ),
        Mistake(
            "nothing at all",
            lambda picture, view: [],
            "Nothing is found anywhere. Do green and yellow stand in this order in your call of color_labels? Are the labels handed on, and is the list returned?",
        ),
    ],
    alternatives={
        "NumPy's lightness": _seen_by_numbers,
        "every seventh pixel": _seen_by_a_sample,
        "corners first": _seen_corners_first,
    },
)


# --- 11.3 joint_distance ---


def _expected(pose: Any, landmark: Any) -> tuple[Array, Array]:
    """Bearing and range (2,) of a landmark, and their slopes by pose and landmark, (2, 5)."""
    dx, dy = landmark[0] - pose[0], landmark[1] - pose[1]
    r = max(np.hypot(dx, dy), 1e-9)
    by_landmark = np.array([[-dy / r**2, dx / r**2], [dx / r, dy / r]])
    values = np.array([wrap_angle(np.arctan2(dy, dx) - pose[2]), r])
    return values, np.column_stack([-by_landmark, [-1.0, 0.0], by_landmark])


def _distance(state: Any, covariance: Any, indices: Any, measurements: Any, R: Any, **changed: Any) -> float:
    """Mahalanobis distance of all pairs together, with one thing done in another way."""
    state, P, R = np.asarray(state), np.asarray(covariance), np.asarray(R)
    least = 1 if changed.get("zero_out") else 0
    paired = [i for i in range(len(indices)) if indices[i] >= least or changed.get("minus_one")]
    if changed.get("infinite") and not paired:
        return float("inf")
    innovation, H = np.zeros(2 * len(paired)), np.zeros((2 * len(paired), len(state)))
    for n, i in enumerate(paired):
        j = 3 + 2 * int(indices[i])
        j = j if j >= 3 else len(state) - 2
        landmark = state[j : j + 2]
        values, slopes = _expected(state[:3], landmark)
        rows, seen = slice(2 * n, 2 * n + 2), measurements[n if changed.get("first_seen") else i]
        innovation[rows] = np.array([seen.bearing, seen.range]) - values
        if changed.get("range_first"):
            innovation[rows], slopes = innovation[rows][::-1], slopes[::-1]
        if changed.get("other_sign"):
            innovation[2 * n] *= -1
        j = 3 + 2 * n if changed.get("packed") else j
        H[rows, :3], H[rows, j : j + 2] = slopes[:, :3], slopes[:, 3:]
    if not changed.get("unwrapped"):
        bearings = slice(1 if changed.get("range_first") else 0, None, 2)
        innovation[bearings] = wrap_angle(innovation[bearings])
    if changed.get("no_pose"):
        H[:, :3] = 0
    if changed.get("no_landmark"):
        H[:, 3:] = 0
    if changed.get("no_cross"):
        P = P.copy()
        P[:3, 3:] = P[3:, :3] = 0
    own = np.array([2 * i + c for i in paired for c in (0, 1)], dtype=int)
    first = np.arange(2 * len(paired))
    noise = R[np.ix_(first, first)] if changed.get("first_rows") else R[np.ix_(own, own)]
    if changed.get("R_by_blocks"):
        noise = noise * np.kron(np.eye(len(paired)), np.ones((2, 2)))
    if changed.get("R_diagonal"):
        noise = np.diag(np.diag(noise))
    S = H @ P @ H.T + (0 if changed.get("no_R") else noise)
    if changed.get("R_alone"):
        S = noise
    if changed.get("apart"):
        S = S * np.kron(np.eye(len(paired)), np.ones((2, 2)))
    if changed.get("diagonal"):
        S = np.diag(np.diag(S))
    if changed.get("times"):
        return float(np.sqrt(innovation @ S @ innovation))
    square = float(innovation @ np.linalg.solve(S, innovation))
    if changed.get("mean"):
        square /= max(len(paired), 1)
    return square if changed.get("squared") else float(np.sqrt(square))


def _changed_distance(**changed: Any) -> Any:
    return lambda state, covariance, indices, measurements, measurement_covariance: _distance(
        state, covariance, indices, measurements, measurement_covariance, **changed
    )


def _distance_by_cholesky(state: Any, covariance: Any, indices: Any, measurements: Any, measurement_covariance: Any) -> Any:
    """Only the columns of P that count; whitened."""
    rows, columns, off, slopes = [], [0, 1, 2], [], []
    for i, j in enumerate(indices):
        if j == -1:
            continue
        values, own = _expected(state[:3], state[3 + 2 * j : 5 + 2 * j])
        rows += [2 * i, 2 * i + 1]
        columns += [3 + 2 * j, 4 + 2 * j]
        off += [wrap_angle(measurements[i].bearing - values[0]), measurements[i].range - values[1]]
        slopes.append(own)
    if not slopes:
        return 0.0
    H = np.zeros((len(rows), len(columns)))
    for n, own in enumerate(slopes):
        H[2 * n : 2 * n + 2, :3], H[2 * n : 2 * n + 2, 3 + 2 * n : 5 + 2 * n] = own[:, :3], own[:, 3:]
    S = H @ covariance[columns][:, columns] @ H.T + measurement_covariance[rows][:, rows]
    return np.linalg.norm(np.linalg.solve(np.linalg.cholesky(S), np.array(off)))


def _distance_by_inverse(state: Any, covariance: Any, indices: Any, measurements: Any, measurement_covariance: Any) -> Any:
    pairs = [(i, int(j)) for i, j in enumerate(indices) if j >= 0]
    if not pairs:
        return 0
    known = [_expected(state[:3], state[3 + 2 * j : 5 + 2 * j]) for _, j in pairs]
    H = np.zeros((len(pairs), 2, len(state)))
    for n, (_, j) in enumerate(pairs):
        H[n][:, [0, 1, 2, 3 + 2 * j, 4 + 2 * j]] = known[n][1]
    chosen = np.array([measurements[i].bearing for i, _ in pairs]), np.array([measurements[i].range for i, _ in pairs])
    off = np.column_stack(chosen) - [values for values, _ in known]
    off[:, 0] = np.angle(np.exp(1j * off[:, 0]))
    rows = np.ravel([(2 * i, 2 * i + 1) for i, _ in pairs])
    flat = H.reshape(-1, len(state))
    information = np.linalg.inv(flat @ covariance @ flat.T + measurement_covariance[np.ix_(rows, rows)])
    return float(np.einsum("i,ij,j->", off.ravel(), information, off.ravel()) ** 0.5)


def _distance_with_unknown_ones(state: Any, covariance: Any, indices: Any, measurements: Any, measurement_covariance: Any) -> Any:
    """All measurements stay; those without a partner get an enormous noise."""
    m = len(indices)
    H, off = np.zeros((2 * m, len(state))), np.zeros(2 * m)
    R = np.array(measurement_covariance, dtype=float).reshape(2 * m, 2 * m)
    for i, j in enumerate(indices):
        rows = np.s_[2 * i : 2 * (i + 1)]
        if j < 0:
            R[rows], R[:, rows] = 0, 0
            R[rows, rows] = np.eye(2)
            continue
        values, slopes = _expected(state[:3], state[3 + 2 * j : 5 + 2 * j])
        off[rows] = wrap_angle(measurements[i].bearing - values[0]), measurements[i].range - values[1]
        H[rows, :3], H[rows, 3 + 2 * j : 5 + 2 * j] = slopes[:, :3], slopes[:, 3:]
    return np.sqrt(off @ np.linalg.lstsq(H @ covariance @ H.T + R, off)[0]) if m else 0.0


def spread(rng: np.random.Generator, size: int, scale: float) -> Array:
    """A covariance (size, size) whose values are correlated, with standard deviations around `scale`."""
    root = rng.normal(0.0, 0.35, (size, size)) + np.eye(size) * rng.uniform(0.6, 1.2, size)
    return scale**2 * (root @ root.T)


def _belief(rng: np.random.Generator, pose: Array, landmarks: Array, scale: float) -> tuple[Array, Array]:
    """A state and its covariance: the pose's error is in all landmarks, and each has one of its own."""
    n = 3 + landmarks.size
    away = landmarks - pose[:2]
    shared = np.zeros((n, 3))
    shared[:3] = np.eye(3)
    shared[3::2, 0], shared[4::2, 1] = 1.0, 1.0
    shared[3:, 2] = np.stack([-away[:, 1], away[:, 0]], axis=1).ravel()
    covariance = spread(rng, n, 0.04) + 0.8 * shared @ spread(rng, 3, scale) @ shared.T
    return np.concatenate([pose, landmarks.ravel()]), covariance


def _crowd(rng: np.random.Generator, k: int) -> tuple[Array, Array, list[LandmarkKind]]:
    """A pose, k landmarks of which some are near each other, and their kinds."""
    pose = np.array([*rng.uniform(-2, 2, 2), rng.uniform(-3, 3)])
    r, direction = rng.uniform(0.8, 3.0, k), rng.uniform(-np.pi, np.pi, k)
    landmarks = pose[:2] + np.column_stack([r * np.cos(direction), r * np.sin(direction)])
    for i in range(1, k, 2):
        landmarks[i] = landmarks[i - 1] + rng.normal(0.0, 0.25, 2)
    return pose, landmarks, [KINDS[int(rng.integers(2))] for _ in range(k)]


def _sight(rng: np.random.Generator, k: int, m: int, off: float = 1.0) -> tuple[Array, Array, Any, Any, Array, Array]:
    """State, covariance, kinds, measurements, R, and of which landmark each is; all off by as much as they say."""
    pose, landmarks, kinds = _crowd(rng, k)
    state, P = _belief(rng, pose, landmarks, 0.08)
    R = spread(rng, 2 * m, 0.06)
    true = state + off * np.linalg.cholesky(P) @ rng.standard_normal(len(state))
    numbers = rng.permutation(k)[:m] if m <= k else rng.integers(0, k, m)
    values = range_and_bearing(true[:3], true[3:].reshape(-1, 2)[numbers])
    values = values + (np.linalg.cholesky(R) @ rng.standard_normal(2 * m)).reshape(-1, 2)
    measurements = [
        Measurement(float(b), float(max(r, 0.1)), kinds[i]) for (b, r), i in zip(values, numbers, strict=True)
    ]
    return state, P, kinds, measurements, R, numbers


def _set_case(rng: np.random.Generator, k: int, m: int, left_out: int = 0, name: str = "") -> Case:
    """A look at m of k landmarks, some of them left out."""
    state, P, _, measurements, R, numbers = _sight(rng, k, m)
    indices = [int(number) for number in numbers]
    for i in rng.permutation(m)[:left_out]:
        indices[i] = -1
    return Case((state, P, indices, measurements, R), name)


def _behind(rng: np.random.Generator) -> tuple[Array, list[Measurement]]:
    """A state with a landmark straight behind, and a look at it on the other side of the half turn."""
    heading, r, off = rng.uniform(-3, 3), rng.uniform(1, 3), rng.uniform(0.01, 0.03)
    back = heading + np.pi - off
    state = np.array([0.0, 0.0, heading, r * np.cos(back), r * np.sin(back)])
    return state, [Measurement(float(-np.pi + off), float(r))]


def _distance_public() -> list[Case]:
    rng = np.random.default_rng(1133)
    straight = np.array([0.0, 0.0, 0.0, 2.0, 0.0])
    state, back = _behind(rng)
    simple = (straight, 0.01 * np.eye(5), [0], [Measurement(0.1, 2.2)], np.diag([0.0025, 0.01]))
    return [
        Case(simple, "one landmark, 2 m straight ahead"),
        Case((state, 0.01 * np.eye(5), [0], back, np.diag([0.01, 0.01])), "straight behind the robot"),
        _set_case(rng, 4, 2, 0, "two pairs"),
        _set_case(rng, 5, 3, 1, "two pairs, a measurement between them without a partner"),
        _set_case(rng, 6, 4, 0, "four pairs"),
        Case((straight, 0.01 * np.eye(5), [-1], [Measurement(0.1, 2.2)], np.diag([0.0025, 0.01])), "no pair at all"),
    ]


def _distance_hidden(rng: np.random.Generator) -> list[Case]:
    state, back = _behind(rng)
    return [
        *(_set_case(rng, k, m, out) for k, m, out in ((1, 1, 0), (4, 2, 0), (5, 4, 2), (8, 5, 1), (10, 6, 0))),
        Case((state, 0.01 * np.eye(5), [0], back, np.diag([0.01, 0.01]))),
        _set_case(rng, 3, 2, 2),
    ]


JOINT_DISTANCE = Exercise(
    name="joint_distance",
    in_place=True,
    points=3,
    stars=2,
    uses=(
        "07:warp2pi",
        "05:expected_measurement",
        "05:measurement_jacobian_pose",
        "05:measurement_jacobian_landmark",
    ),
    public=_distance_public,
    hidden=_distance_hidden,
    comparison=Close(rtol=1e-4, atol=1e-6),
    hints=(
        "It is your update_landmarks up to S: innovation and H of the pairs, then one number of them.",
        "First list the places that have a partner. Their rows of measurement_covariance are 2 i and 2 i + 1: np.ix_ takes them. Without a pair, the arrays are empty, and so is the sum.",
    ),
    mistakes=[
        Mistake("no root", _changed_distance(squared=True), "That is the square. The distance is its root: a gate is in standard deviations."),
        Mistake(
            "bearings not wrapped",
            _changed_distance(unwrapped=True),
            "Straight behind the robot your bearing is off by a full turn: the innovation has to be wrapped.",
        ),
        Mistake("the noise alone", _changed_distance(R_alone=True), "Your S is R alone. Pose and landmarks are doubtful, too: H P Hᵀ + R."),
        Mistake("without the noise", _changed_distance(no_R=True), "You leave the measurements' own noise out: S = H P Hᵀ + R."),
        Mistake(
            "the first rows of R",
            _changed_distance(first_rows=True),
            "Where a measurement has no partner, your R is that of others: take the rows and columns 2 i and 2 i + 1 of the measurements that have one.",
        ),
        Mistake(
            "each by itself",
            _changed_distance(apart=True),
            "You judge each pair by itself. One error of the pose, and one tilt, moves all of them together: that is what the blocks off the diagonal of S hold.",
        ),
        Mistake(
            "R in blocks",
            _changed_distance(R_by_blocks=True),
            "You take only the blocks on the diagonal of R. What lies beside them is the tilt that all measurements of a picture share.",
        ),
        Mistake(
            "R's diagonal",
            _changed_distance(R_diagonal=True),
            "You take only the diagonal of R. What lies beside it is what the measurements of a picture share.",
        ),
        Mistake(
            "the mean",
            _changed_distance(mean=True),
            "You take the mean over the pairs. Equation 11.3 adds up: many pairs together may lie farther away than one.",
        ),
        Mistake(
            "columns in turn",
            _changed_distance(packed=True),
            "Your slopes stand in the columns of another landmark. Those of landmark j are 3 + 2 j and 4 + 2 j, as in the state.",
        ),
        Mistake(
            "range before bearing",
            _changed_distance(range_first=True),
            "You put the range before the bearing, and R has the bearing first.",
        ),
        Mistake(
            "the bearing's sign",
            _changed_distance(other_sign=True),
            "Your bearing's innovation has the other sign: it is the measured bearing less the expected one, as for the range.",
        ),
        Mistake(
            "no landmark 0",
            _changed_distance(zero_out=True),
            "You leave landmark 0 out. It is one as well; only -1 means none.",
        ),
        Mistake(
            "the first measurements",
            _changed_distance(first_seen=True),
            "Where a measurement has no partner, you take the measurements in turn for the pairs. Pair i is measurement i with landmark indices[i].",
        ),
        Mistake(
            "infinitely far",
            _changed_distance(infinite=True),
            "Without a pair your distance is infinite. What is nowhere off has a distance of 0.",
        ),
        Mistake("variances alone", _changed_distance(diagonal=True), "You divide by the variances alone. S is a full matrix: np.linalg.solve(S, innovation)."),
        Mistake("without the inverse", _changed_distance(times=True), "You multiply by S. What is expected to be large counts less: np.linalg.solve(S, innovation)."),
        Mistake(
            "pose and map apart",
            _changed_distance(no_cross=True),
            "You leave out what pose and landmarks have in common, P_pl. Take P as it is.",
        ),
        Mistake("a certain pose", _changed_distance(no_pose=True), "Your pose is certain: the first three columns of H are its slopes."),
        Mistake("a certain map", _changed_distance(no_landmark=True), "Your landmarks are certain: H has two columns for each of them."),
        Mistake(
            "-1 as a number",
            _changed_distance(minus_one=True),
            "You look -1 up as if it were a landmark: Python counts from the end then. A measurement with -1 is left out.",
        ),
    ],
    alternatives={
        "few columns, Cholesky": _distance_by_cholesky,
        "the inverse": _distance_by_inverse,
        "all measurements kept": _distance_with_unknown_ones,
    },
    equivalents={
        **dict.fromkeys(
            ("own = [2 * i | c for i in paired for c in (0, 1)]", "own = [2 * i ^ c for i in paired for c in (0, 1)]"),
            "2 i is even: or, and exclusive or, add c",
        ),
        **{
            f"H[rows, {columns}] = measurement_jacobian_{name}(state[{part}], state[columns])": "slopes of bearing and range do not hang on the heading"
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


def _distances(state: Any, covariance: Any, kinds: Any, measurements: Any, R: Any, **changed: Any) -> Array:
    """Mahalanobis distances (m, k); infinite between kinds."""
    R = np.asarray(R)
    found = np.full((len(measurements), len(kinds)), np.inf)
    for i, seen in enumerate(measurements):
        own = R[:2, :2] if changed.get("first_R") else R[2 * i : 2 * i + 2, 2 * i : 2 * i + 2]
        for j, kind in enumerate(kinds):
            if kind != seen.kind and not changed.get("any_kind"):
                continue
            if changed.get("metres"):
                away = np.array([np.cos(state[2] + seen.bearing), np.sin(state[2] + seen.bearing)]) * seen.range
                found[i, j] = np.hypot(*(state[:2] + away - state[3 + 2 * j : 5 + 2 * j]))
                continue
            found[i, j] = _distance(state, covariance, [j], [seen], own)
    return found**2 if changed.get("squared") else found


def _nearest_first(distances: Array, gate: float) -> Array:
    """The reference's rule: the closest pair first, each landmark once."""
    distances = distances.copy()
    indices = np.full(len(distances), -1)
    while distances.size and distances.min() <= min(gate, 1e9):
        i, j = np.unravel_index(distances.argmin(), distances.shape)
        indices[i] = j
        distances[i], distances[:, j] = np.inf, np.inf
    return indices


def _shared(distances: Array, gate: float) -> Array:
    """Each measurement for itself: two may take one landmark."""
    return np.array(
        [int(row.argmin()) if len(row) and row.min() <= gate else -1 for row in distances], dtype=int
    )


def _in_turn(distances: Array, gate: float) -> Array:
    """One measurement after the other, each landmark once."""
    distances, indices = distances.copy(), np.full(len(distances), -1)
    for i in range(len(distances)):
        if distances.size and distances[i].min() <= gate:
            indices[i] = distances[i].argmin()
            distances[:, indices[i]] = np.inf
    return indices


def _no_second_choice(distances: Array, gate: float) -> Array:
    """Each measurement's nearest alone counts; a landmark's second one is new."""
    indices = np.full(len(distances), -1)
    if distances.size == 0:
        return indices
    for i in np.argsort(distances.min(axis=1)):
        j = int(distances[i].argmin())
        if distances[i, j] <= gate and j not in indices:
            indices[i] = j
    return indices


def _smallest_sum(distances: Array, gate: float) -> Array:
    """The pairs whose distances have the smallest sum."""
    indices = np.full(len(distances), -1)
    for i, j in zip(*linear_sum_assignment(np.where(distances <= gate, distances, 1e6)), strict=True):
        if distances[i, j] <= gate:
            indices[i] = j
    return indices


def _only_mutual(distances: Array, gate: float) -> Array:
    """Pairs of which each is the other's nearest."""
    indices = np.full(len(distances), -1)
    for i, row in enumerate(distances):
        j = int(row.argmin()) if len(row) else -1
        if j >= 0 and row[j] <= gate and distances[:, j].argmin() == i:
            indices[i] = j
    return indices


def _first_come(distances: Array, gate: float) -> Array:
    """Each measurement's nearest; who asks first keeps it."""
    indices = np.full(len(distances), -1)
    for i, wanted in enumerate(_shared(distances, gate)):
        if wanted not in indices[:i]:
            indices[i] = wanted
    return indices


def _together(state: Any, covariance: Any, kinds: Any, measurements: Any, measurement_covariance: Any, gate: float) -> Any:
    return associate_jointly(state, covariance, kinds, measurements, measurement_covariance, gate)


def _associated(rule: Any = _nearest_first, **changed: Any) -> Any:
    def function(
        state: Any, covariance: Any, kinds: Any, measurements: Any, measurement_covariance: Any, gate: float
    ) -> Any:
        distances = _distances(state, covariance, kinds, measurements, measurement_covariance, **changed)
        return rule(distances, changed.get("gate", lambda one: one)(gate))

    return function


def _by_sorting(state: Any, covariance: Any, kinds: Any, measurements: Any, measurement_covariance: Any, gate: float) -> Any:
    """A list of all pairs within the gate, sorted."""
    distances = _distances(state, covariance, kinds, measurements, measurement_covariance)
    indices = [-1] * len(measurements)
    for _, i, j in sorted((d, i, j) for (i, j), d in np.ndenumerate(distances) if d <= gate):
        if indices[i] == -1 and j not in indices:
            indices[i] = j
    return indices


def _by_dict(state: Any, covariance: Any, kinds: Any, measurements: Any, measurement_covariance: Any, gate: float) -> Any:
    """Landmarks and measurements that are still free, as sets."""
    table = _distances(state, covariance, kinds, measurements, measurement_covariance)
    free, found = (set(range(len(measurements))), set(range(len(kinds)))), dict[int, int]()
    while free[0] and free[1]:
        d, i, j = min((table[i, j], i, j) for i in free[0] for j in free[1])
        if not d <= gate:
            break
        found[i] = j
        free[0].remove(i)
        free[1].remove(j)
    return np.array([found.get(i, -1) for i in range(len(measurements))], dtype=int)


def _by_rounds(state: Any, covariance: Any, kinds: Any, measurements: Any, measurement_covariance: Any, gate: float) -> Any:
    """Masked arrays, a round for each pair."""
    distances = np.ma.masked_greater(_distances(state, covariance, kinds, measurements, measurement_covariance), gate)
    indices = -np.ones(len(measurements), dtype=np.int32)
    while distances.count():
        i, j = divmod(int(np.ma.argmin(distances)), distances.shape[1])
        indices[i] = j
        distances[i, :] = np.ma.masked
        distances[:, j] = np.ma.masked
    return indices


def _crowd_case(rng: np.random.Generator, k: int, m: int, gate: float, name: str = "", off: float = 1.0) -> Case:
    return Case((*_sight(rng, k, m, off)[:5], gate), name)


# Seed, landmarks, measurements, gate: chosen so that no two mistakes answer all of these alike.
CROWDS = ((275, 10, 8, 3.0), (296, 6, 4, 3.0), (1, 8, 5, 3.0), (2, 8, 6, 2.0), (365, 6, 4, 3.0), (339, 6, 5, 3.0))


def _association_public() -> list[Case]:
    straight = np.array([0.0, 0.0, 0.0, 2.0, 0.0, 2.0, 0.6])
    sure, corners, R = np.diag([0.01] * 7), ["corner", "corner"], np.diag([0.0025, 0.01])
    one, none = [Measurement(0.02, 2.1)], np.zeros((0, 0))
    two = [Measurement(0.15, 2.0), Measurement(0.01, 2.0)]
    return [
        Case((straight, sure, corners, one, R, 3.0), "one corner near the first of two"),
        Case((straight, sure, ["post", "corner"], one, R, 4.0), "the same, but the first landmark is a post"),
        Case((straight, sure, corners, [Measurement(-1.0, 1.0)], R, 3.0), "a corner that is near no landmark"),
        Case((np.zeros(3), np.zeros((3, 3)), [], two, np.diag([0.01] * 4), 3.0), "an empty map"),
        Case((straight, sure, corners, [], none, 3.0), "nothing measured"),
        Case(
            (straight, sure, corners, two, np.diag([0.0025, 0.01] * 2), 3.0),
            "two corners, both nearest to the first landmark",
        ),
        *(
            _crowd_case(
                np.random.default_rng(seed), k, m, gate, f"{m} measurements, {k} landmarks, a gate of {gate:g} sigma"
            )
            for seed, k, m, gate in CROWDS
        ),
    ]


def _association_hidden(rng: np.random.Generator) -> list[Case]:
    sizes = ((5, 3, 3.0), (6, 4, 2.0), (8, 6, 3.0), (10, 7, 3.0), (10, 8, 1.5), (12, 8, 4.0), (4, 6, 3.0), (12, 10, 3.0))
    state, P = _belief(rng, np.array([*rng.uniform(-1, 1, 2), 0.0]), rng.uniform(-3, 3, (3, 2)), 0.05)
    return [
        *(_crowd_case(rng, k, m, gate, off=off) for off in (1.0, 1.6) for k, m, gate in sizes),
        Case((state[:3], P[:3, :3], [], [Measurement(0.3, 1.0)], np.diag([0.01, 0.01]), 3.0)),
        Case((state, P, ["corner", "post", "corner"], [], np.zeros((0, 0)), 3.0)),
    ]


NUMBERS = All((Close(rtol=0.0, atol=0.01), Property(whole_numbers)))

ASSOCIATE = Exercise(
    name="associate",
    in_place=True,
    points=3,
    stars=2,
    uses=("joint_distance",),
    public=_association_public,
    hidden=_association_hidden,
    comparison=NUMBERS,
    hints=(
        "First a table of distances, measurements down and landmarks across, with np.inf where the kinds differ. Then choose in it.",
        "The closest pair is np.unravel_index(distances.argmin(), distances.shape). Note it, fill its row and its column with np.inf, and go on while the smallest is at most the gate.",
    ),
    mistakes=[
        Mistake(
            "any kind",
            _associated(any_kind=True),
            "You take a post for a corner. Only landmarks of the measurement's kind can be meant.",
        ),
        Mistake(
            "one landmark twice",
            _associated(_shared),
            "Two of your measurements are the same landmark. In one picture each landmark is seen once: the nearer one has it, and the other looks on.",
        ),
        Mistake(
            "in turn",
            _associated(_in_turn),
            "You serve one measurement after the other. The closest pair of all comes first: an earlier measurement may not take the landmark of a nearer one.",
        ),
        Mistake(
            "no second choice",
            _associated(_no_second_choice),
            "Where its nearest landmark is taken, your measurement is new. Its second nearest may also be within the gate.",
        ),
        Mistake(
            "the smallest sum",
            _associated(_smallest_sum),
            "You take the pairs with the smallest sum of distances. Here the closest pair of all comes first, then the closest of what is left.",
        ),
        Mistake(
            "mutual pairs only",
            _associated(_only_mutual),
            "You pair only those of which each is the other's nearest. When a landmark is used up, those who wanted it go on with what is left.",
        ),
        Mistake(
            "first come",
            _associated(_first_come),
            "You give a landmark to the measurement that asks first. The nearer one has it, and the other may take its second nearest.",
        ),
        Mistake(
            "joint compatibility",
            _together,
            "That is what judging all pairs together gives. Here each pair is judged by itself: nearest neighbour.",
        ),
        Mistake(
            "no gate",
            _associated(gate=lambda gate: np.inf),
            "You use no gate: every measurement finds some landmark, however far away. Beyond the gate it is new, -1.",
        ),
        Mistake(
            "the squared distance",
            _associated(squared=True),
            "You hold the squared distance against the gate. Both are in standard deviations.",
        ),
        Mistake(
            "the first one's noise",
            _associated(first_R=True),
            "You use the first measurement's R for all. That of measurement i are rows and columns 2 i and 2 i + 1.",
        ),
        Mistake(
            "metres",
            _associated(metres=True),
            "You compare metres with a gate in standard deviations. Half a metre is much 1 m ahead and little at 4 m: take joint_distance.",
        ),
        Mistake(
            "0 for none",
            lambda *given: np.maximum(_associated()(*given), 0),
            "You say 0 where there is no partner, and that is the first landmark's number: say -1.",
        ),
        Mistake(
            "variances alone",
            lambda state, covariance, *more: _associated()(state, np.diag(np.diag(covariance)), *more),
            "You take only the variances of state and map. What pose and landmarks share belongs into S.",
        ),
        Mistake(
            "all new",
            lambda state, covariance, kinds, measurements, measurement_covariance, gate: np.full(len(measurements), -1),
            "All your measurements are new landmarks.",
        ),
    ],
    alternatives={"a sorted list": _by_sorting, "sets": _by_dict, "masked arrays": _by_rounds},
    equivalents={
        **{
            f"R = measurement_covariance[{rows}, {columns}]": "joint_distance looks at the first two rows and columns of it"
            for longer in ("2 * i:2 ** i + 2", "2 * i:2 << i + 2", "2 * i:3 * i + 2", "2 * i:2 * i + 3", "2 * i:")
            for rows, columns in ((longer, "2 * i:2 * i + 2"), ("2 * i:2 * i + 2", longer))
        },
        "while distances.size and distances.min() < gate:": "no distance is the gate to the last bit",
    },
)


# --- 11.5 EkfSlam ---


def _estimated(state: Any, covariance: Any, kinds: Any) -> Estimate:
    landmarks = np.asarray(state)[3:].reshape(-1, 2)
    own = [covariance[n : n + 2, n : n + 2] for n in range(3, len(state), 2)]
    return Estimate(Pose.from_array(state[:3]), covariance[:3, :3], landmarks, np.array(own), tuple(kinds))


def _ekf(**changed: Any) -> type[SlamAlgorithm]:
    """The filter, with one thing done in another way."""

    class Changed(SlamAlgorithm):
        heading: float | None = None

        def __init__(
            self, start: Pose = Pose(), odometry: Any = FieldOdometry(), gate: float = 4.0, association: Any = None  # noqa: B008
        ) -> None:
            self.association = None if changed.get("own_association") else association
            if changed.get("own_odometry"):
                odometry = FieldOdometry()
            self.state = np.zeros(3) if changed.get("from_zeros") else start.as_array()
            self.covariance = 0.01 * np.eye(3) if changed.get("doubtful_start") else np.zeros((3, 3))
            self.kinds: list[Any] = []
            self.odometry, self.gate = odometry, changed.get("gate", gate)
            self.indices: Array = np.zeros(0, dtype=int)

        def move(self, motion: Motion) -> None:
            control, k = np.array([motion.distance, motion.turn]), len(self.kinds)
            Q = self.odometry.covariance(Motion(0.2, 0.1) if changed.get("one_Q") else motion)
            if changed.get("no_Q"):
                Q = np.zeros((3, 3))
            if changed.get("exchanged"):
                control = control[::-1]
            self.state, self.covariance = predict(self.state, self.covariance, control, Q, k)

        def observe(self, measurements: Any) -> None:
            seen = as_observation(measurements)
            if changed.get("own_R"):
                blocks = np.kron(np.eye(len(seen)), np.ones((2, 2)))
                seen = Observation(seen.measurements, seen.covariance * blocks, seen.direction, seen.direction_sigma)
            if changed.get("needs_landmarks") and not len(seen):
                return
            if np.isfinite(seen.direction_sigma) and not (changed.get("no_compass") or changed.get("compass_last")):
                self._turn(seen)
            elif not np.isfinite(seen.direction_sigma):
                self.heading = None
            belief = (self.state, self.covariance, tuple(self.kinds))
            which = self.association or _associated()
            self.indices = np.array(which(*belief, seen, seen.covariance, self.gate), dtype=int)
            if changed.get("compass_last") and np.isfinite(seen.direction_sigma):
                self._turn(seen)
            near = self._near(belief, seen)
            if changed.get("independent"):
                self._correct(seen)
                self._add(seen, near, 1.0)
            elif changed.get("not_placed"):
                known = self.indices.copy()
                self._add(seen, near)
                self.indices = known
                self._correct(seen)
            elif not changed.get("asks_anew"):
                self._add(seen, near, 1.0 if changed.get("twice") else VAGUE)
                self._correct(seen)
            else:
                for n in np.flatnonzero(self.indices < 0):
                    now = self._near((self.state, self.covariance, tuple(self.kinds)), seen)
                    self._add(seen, np.where(np.arange(len(seen)) == n, now, 0))
                self._correct(seen)

        def _near(self, belief: Any, seen: Any) -> Array:
            """The landmark within the ring about each measurement alone; -1: none."""
            ring = float(changed.get("ring", 3.0)) * self.gate
            alone = [_associated()(*belief, [one], seen.part([n]).covariance, ring)[0] for n, one in enumerate(seen)]
            return np.array(alone, dtype=int)

        def _turn(self, seen: Any) -> None:
            off = changed.get("sign", -1) * seen.direction - self.state[2]
            off = wrap_angle(off) if changed.get("no_quarter") else (off + np.pi / 4) % (np.pi / 2) - np.pi / 4
            variance = self.covariance[2, 2] + seen.direction_sigma ** (1 if changed.get("not_squared") else 2)
            self.heading = None
            if changed.get("refuses") and abs(off) > self.gate * np.sqrt(variance):
                return
            self.heading = float(self.state[2] + off)
            gain = self.covariance[:, 2] / variance
            if changed.get("heading_only"):
                gain = gain * (np.arange(len(gain)) == 2)
            self.state = self.state + gain * off
            self.covariance = self.covariance - np.outer(gain, self.covariance[2])
            self.state[2] = wrap_angle(self.state[2])

        def _correct(self, seen: Any) -> None:
            known = np.flatnonzero(self.indices >= 0)
            for some in [np.array([n]) for n in known] if changed.get("one_by_one") else [known]:
                if len(some):
                    self._update(seen, some)

        def _update(self, seen: Any, known: Array) -> None:
            indices = self.indices[known].tolist()
            away = self.state[3:].reshape(-1, 2)[indices] - self.state[:2]
            expected = seen.values[known][:, 1] if changed.get("as_measured") else np.hypot(*away.T)
            values, R = seen.part(known).about(expected)
            if changed.get("first_rows"):
                R = seen.part(range(len(known))).covariance
            if changed.get("plain_R"):
                R = seen.part(known).covariance
            self.state, self.covariance = update_landmarks(self.state, self.covariance, indices, values, R)

        def _add(self, seen: Any, near: Array, vague: float = VAGUE) -> None:
            for n in np.flatnonzero((near < 0) & (self.indices < 0)):
                if changed.get("never_new"):
                    continue
                R = vague * seen.part([n]).covariance
                self.state, self.covariance = add_landmark(self.state, self.covariance, seen.values[n], R)
                self.indices[n] = len(self.kinds)
                self.kinds.append("corner" if changed.get("all_corners") else seen[n].kind)

        def estimate(self) -> Estimate:
            found = _estimated(self.state, self.covariance, self.kinds)
            if changed.get("no_map"):
                return Estimate(found.pose, found.covariance, np.zeros((0, 2)), np.zeros((0, 2, 2)), ())
            if changed.get("pose_block"):
                own = [self.covariance[2 * n : 2 * n + 2, 2 * n : 2 * n + 2] for n in range(len(self.kinds))]
                return Estimate(found.pose, found.covariance, found.landmarks, np.array(own), found.kinds)
            if changed.get("variances"):
                return Estimate(found.pose, np.diag(np.diag(found.covariance)), found.landmarks, found.landmark_covariances, found.kinds)
            return found

    return Changed


class _WholeMatrices(SlamAlgorithm):
    """The same filter with its own matrices: H with all columns, Joseph's form, lists of landmarks."""

    def __init__(
        self, start: Pose = Pose(), odometry: Any = FieldOdometry(), gate: float = 4.0, association: Any = None  # noqa: B008
    ) -> None:
        self.pose, self.marks, self.P = start.as_array(), list[Any](), np.zeros((3, 3))
        self.odometry, self.gate, self.association = odometry, gate, association

    @property
    def x(self) -> Array:
        return np.concatenate([self.pose, *(place for place, _ in self.marks)])

    @x.setter
    def x(self, values: Array) -> None:
        self.pose = np.array([values[0], values[1], wrap_angle(values[2])])
        self.marks = [(values[3 + 2 * n : 5 + 2 * n], kind) for n, (_, kind) in enumerate(self.marks)]

    def move(self, motion: Motion) -> None:
        c, s = np.cos(self.pose[2]), np.sin(self.pose[2])
        F, G = np.eye(len(self.P)), np.zeros((len(self.P), 3))
        F[0, 2], F[1, 2] = -motion.distance * s, motion.distance * c
        G[:3] = [[c, -s, 0], [s, c, 0], [0, 0, 1]]
        self.pose = (Pose.from_array(self.pose) @ motion.as_pose()).as_array()
        self.P = F @ self.P @ F.T + G @ self.odometry.covariance(motion) @ G.T

    def _linear(self, H: Array, off: Array, R: Array) -> None:
        K = self.P @ H.T @ np.linalg.inv(H @ self.P @ H.T + R)
        rest = np.eye(len(self.P)) - K @ H
        self.x = self.x + K @ off
        self.P = rest @ self.P @ rest.T + K @ R @ K.T

    def observe(self, measurements: Any) -> None:
        seen = as_observation(measurements)
        off = (seen.direction + self.pose[2] + np.pi / 4) % (np.pi / 2) - np.pi / 4
        if np.isfinite(seen.direction_sigma):
            H = np.zeros((1, len(self.P)))
            H[0, 2] = -1
            self._linear(H, np.array([off]), np.array([[seen.direction_sigma**2]]))
        kinds = [kind for _, kind in self.marks]
        table = _distances(self.x, self.P, kinds, seen, seen.covariance)
        indices = _nearest_first(table, self.gate)
        if self.association is not None:
            indices = np.array(self.association(self.x, self.P, kinds, seen, seen.covariance, self.gate))
        far = [n for n, row in enumerate(table) if not (row <= 3 * self.gate).any()]
        for n in far:
            toward = self.pose[2] + seen[n].bearing
            c, s, r = np.cos(toward), np.sin(toward), seen[n].range
            J, Z = np.array([[1, 0, -r * s], [0, 1, r * c]]), np.array([[-r * s, c], [r * c, s]])
            cross = self.P[:, :3] @ J.T
            own = J @ cross[:3] + VAGUE * Z @ seen.part([n]).covariance @ Z.T
            self.P = np.block([[self.P, cross], [cross.T, own]])
            indices[n] = len(self.marks)
            self.marks.append((self.pose[:2] + r * np.array([c, s]), seen[n].kind))
        paired = [(n, int(j)) for n, j in enumerate(indices) if j >= 0]
        scale = np.ones(2 * len(seen))
        if paired:
            H, off = np.zeros((2 * len(paired), len(self.P))), np.zeros(2 * len(paired))
            for row, (n, j) in enumerate(paired):
                values, slopes = _expected(self.pose, self.marks[j][0])
                H[2 * row : 2 * row + 2, :3] = slopes[:, :3]
                H[2 * row : 2 * row + 2, 3 + 2 * j : 5 + 2 * j] = slopes[:, 3:]
                short = values[1] / seen[n].range
                off[2 * row : 2 * row + 2] = wrap_angle(seen[n].bearing - values[0]), values[1] * (1 - short)
                scale[2 * row + 1] = short**2
            scale = scale[: 2 * len(paired)]
            self._linear(H, off, np.outer(scale, scale) * seen.part([n for n, _ in paired]).covariance)

    def estimate(self) -> Estimate:
        return _estimated(self.x, self.P, [kind for _, kind in self.marks])


class _KeptAsAnEstimate(SlamAlgorithm):
    """State and covariance in one tuple; a list for each picture's decisions; compass by hand."""

    def __init__(
        self, start: Pose = Pose(), odometry: Any = FieldOdometry(), gate: float = 4.0, association: Any = None  # noqa: B008
    ) -> None:
        self.belief, self.kinds, self.told = (start.as_array(), np.zeros((3, 3))), tuple[Any, ...](), (odometry, gate)
        self.which = association or _associated()

    def move(self, motion: Motion) -> None:
        Q = self.told[0].covariance(motion)
        self.belief = predict(*self.belief, np.array([motion.distance, motion.turn]), Q, len(self.kinds))

    def observe(self, measurements: Any) -> None:
        seen, gate = as_observation(measurements), self.told[1]
        x, P = self.belief
        if seen.direction_sigma != np.inf:
            turns = np.round((x[2] + seen.direction) / (np.pi / 2))
            off = turns * np.pi / 2 - seen.direction - x[2]
            spread = np.hypot(np.sqrt(P[2, 2]), seen.direction_sigma)
            gain = P[2] / spread**2
            x, P = x + gain * off, P - np.outer(gain, P[2])
        table = _distances(x, P, self.kinds, seen, seen.covariance)
        chosen = dict(enumerate(self.which(x, P, self.kinds, seen, seen.covariance, gate).tolist()))
        nearest = np.min(table, axis=1, initial=np.inf)
        for n in sorted(chosen):
            if nearest[n] > 3 * gate:
                vague = seen.covariance[2 * n : 2 * n + 2, 2 * n : 2 * n + 2] * 1e4
                x, P = add_landmark(x, P, seen.values[n], vague)
                chosen[n] = len(self.kinds)
                self.kinds = (*self.kinds, seen[n].kind)
        again = [n for n in chosen if chosen[n] != -1]
        if again:
            numbers = [chosen[n] for n in again]
            expected = [_expected(x[:3], x[3 + 2 * j : 5 + 2 * j])[0][1] for j in numbers]
            x, P = update_landmarks(x, P, numbers, *seen.part(again).about(expected))
        self.belief = x, P

    def estimate(self) -> Estimate:
        return _estimated(*self.belief, self.kinds)


class _FromTheLibrary(_ekf()):  # type: ignore[misc]
    """Angles of the compass by complex numbers, and its gain by whole matrices."""

    def _turn(self, seen: Any) -> None:
        off = np.angle(np.exp(-4j * (seen.direction + self.state[2]))) / 4
        H = np.zeros((1, len(self.state)))
        H[0, 2] = 1
        S = H @ self.covariance @ H.T + seen.direction_sigma**2
        K = self.covariance @ H.T / S
        self.state = self.state + K[:, 0] * off
        self.covariance = (np.eye(len(H[0])) - K @ H) @ self.covariance


def _log_case(
    seed: int,
    moves: int,
    name: str = "",
    gate: float = 4.0,
    odometry: Any = FieldOdometry(),  # noqa: B008
    given: tuple[Any, ...] = (),
    plain: bool = False,
    at_end: bool = False,
    **kind: Any,
) -> Case:
    """A log over the half field; plain: lists of Measurement, and a constructor without arguments."""
    drive = drawn_drive(seed, moves, **({"yaws": (0.5, -0.5)} | kind))
    turns: list[Any] = []
    for motion, seen in drive.log:
        turns += [("move", motion)] * (motion is not None)
        turns.append(("observe", list(seen) if plain else seen))
        turns += [] if at_end else ["estimate"]
    if "circle_rate" in kind:  # none or more of them wrong; and a picture of lines alone
        direction = float(-drive.poses[-1, 2] + 0.01)
        turns.append(("observe", Observation((), np.zeros((0, 0)), direction, kind["compass_sigma"])))
    return calls(*turns, "estimate", given=() if plain else (drive.start, odometry, gate, *given), name=name)


COMPASS, POOR = (float(np.radians(sigma)) for sigma in (0.7, 10.0))
WORSE = FieldOdometry(factor=2.0)
# Drives on which nearest neighbour and joint compatibility differ, and Gauss-Newton settles.
PARTED = (2001, 2003, 2004, 2005, 2009, 2010, 2017, 2024, 2027, 2030, 2035, 2037, 2038, 2039, 2042)


def _logs_public() -> list[Case]:
    return [
        _log_case(3, 2, "two moves, two looks at each stop"),
        _log_case(5, 2, "with a poor compass and a gate of 10", gate=10.0, compass_sigma=POOR),
        _log_case(15, 3, "with a compass that is wrong now and then", compass_sigma=COMPASS, circle_rate=0.5),
        _log_case(5, 3, "with corners that are none, odometry twice as bad", false_rate=0.7, odometry=WORSE),
        _log_case(0, 3, "with a gate of 1.5", gate=1.5),
        _log_case(2033, 3, "with another association", given=(associate_jointly,), at_end=True),
        _log_case(8, 2, "lists of Measurement, from the origin", plain=True),
    ]


def _logs_hidden(rng: np.random.Generator) -> list[Case]:
    seeds = rng.integers(1000, 10**6, 6)
    return [
        _log_case(int(seeds[0]), 3, at_end=True, odometry=WORSE),
        _log_case(int(seeds[1]), 3, compass_sigma=COMPASS, circle_rate=0.3),
        _log_case(int(seeds[2]), 3, false_rate=0.8, at_end=True),
        _log_case(int(rng.choice(PARTED)), 3, at_end=True, given=(associate_jointly,)),
        _log_case(int(seeds[3]), 4, gate=1.5, at_end=True),
        _log_case(int(seeds[4]), 2, plain=True),
        _log_case(int(seeds[5]), 4, false_rate=0.5, compass_sigma=3 * COMPASS, gate=2.0, at_end=True),
    ]


def _as_estimated(rtol: float) -> Methods:
    """Estimates that agree to a fraction; the heading on the circle."""
    parts = {
        "pose": Close(rtol=rtol, atol=1e-4, period=(0, 0, TURN)),
        "covariance": Close(rtol=rtol, atol=1e-6),
        "landmarks": Close(rtol=rtol, atol=1e-4),
        "landmark_covariances": Close(rtol=rtol, atol=1e-6),
        "kinds": Exact(),
    }
    return Methods({"estimate": Each(parts)})


EKF_SLAM = Exercise(
    name="EkfSlam",
    points=6,
    stars=3,
    uses=("associate", "07:predict", "07:update_landmarks", "07:add_landmark"),
    public=_logs_public,
    hidden=_logs_hidden,
    driver="methods",
    comparison=_as_estimated(1e-3),
    hints=(
        "move is one call of predict. use_compass: the gain is a column of P, divided by one number. number: ask about all of the picture first, then about each that has no landmark, always with what was believed before any of them came onto the map.",
        "A measurement is new where even associate(..., [that one], seen.part([i]).covariance, 3 * self.gate) says -1; then add_landmark with VAGUE times that covariance, a number, a kind. "
        "correct: the expected ranges are expected_measurement(...)[1] of the landmarks in self.indices, and seen.part(used).about(them) gives what update_landmarks wants.",
    ),
    mistakes=[
        Mistake("from zeros", _ekf(from_zeros=True), "Your map begins at zeros. It begins at `start`, which the robot knows."),
        Mistake("a doubtful start", _ekf(doubtful_start=True), "Your first covariance is not zero: where the robot starts is known."),
        Mistake("no noise of motion", _ekf(no_Q=True), "Your robot becomes no less sure when it moves: predict wants self.odometry.covariance(motion)."),
        Mistake("one noise for all", _ekf(one_Q=True), "Every command has the same noise in your filter. It grows with the way: self.odometry.covariance(motion)."),
        Mistake("turn for distance", _ekf(exchanged=True), "Distance and turn are exchanged: a control is (distance, turn)."),
        Mistake("each its own R", _ekf(own_R=True), "You drop what the measurements of a picture share. One tilt moves them all: hand the whole covariance on, that of seen.part(used).about(...)."),
        Mistake("the first rows of R", _ekf(first_rows=True), "Your R is that of the first measurements, not of those that have a landmark: seen.part(used)."),
        Mistake("one after the other", _ekf(one_by_one=True), "You correct by one landmark after the other: what they share is lost. One call of update_landmarks for all that have a number."),
        Mistake("ranges as measured", _ekf(as_measured=True), "You take ranges in as they were measured, in which a tilt is no straight line (equation 11.5). about wants the ranges that are expected, from state and map."),
        Mistake("values without their R", _ekf(plain_R=True), "Your values are about the expected ranges, your covariance is not: about returns both."),
        Mistake("its own odometry", _ekf(own_odometry=True), "You take FieldOdometry() whatever was given: self.odometry knows how much the robot's commands err."),
        Mistake("its own association", _ekf(own_association=True), "You take your own associate whatever was given: self.association says which landmark it is."),
        Mistake("no landmark, no compass", _ekf(needs_landmarks=True), "You leave a picture without landmarks out. Its lines tell the heading all the same."),
        Mistake("the compass last", _ekf(compass_last=True), "You associate before you use the compass. With the better heading fewer pairs are in doubt: the compass comes first."),
        Mistake("sigma for its square", _ekf(not_squared=True), "You add a standard deviation to a variance: s has sigma squared."),
        Mistake("no compass", _ekf(no_compass=True), "You leave the compass out: where sigma is finite, the lines tell the heading."),
        Mistake("the compass's sign", _ekf(sign=1), "Your compass turns the wrong way: lines that lie to the left mean that the robot has turned to the right."),
        Mistake("whole turns only", _ekf(no_quarter=True), "You wrap the compass at half a turn. Lines look the same every 90 degrees: wrap_quarter."),
        Mistake("the heading alone", _ekf(heading_only=True), "Your compass corrects the heading alone. What shares its error is corrected, too: the gain is a column of P."),
        Mistake("refused where it is far", _ekf(refuses=True), "You refuse a compass that is far from your heading. A filter that is lost would refuse every right one: take each whose sigma is finite."),
        Mistake("its tilt for itself", _ekf(independent=True), "You add a new landmark with its own R after the correction: its picture's tilt is taken for an error of its own. Add it before, with VAGUE times its R, and let the correction place it with the others."),
        Mistake("counted twice", _ekf(twice=True), "You add a new landmark with its R and then correct by the same measurement: it counts twice. VAGUE times R says that nothing is known of it yet."),
        Mistake("vague for ever", _ekf(not_placed=True), "Your new landmarks stay vague: give them their number before the correction, which then places them."),
        Mistake("asked too late", _ekf(asks_anew=True), "A vague landmark is near everything: whoever asks again with it on the map finds no second new one in the same picture. Ask with state, covariance and kinds as they were before."),
        Mistake("no ring", _ekf(ring=1.0), "Everything outside the gate becomes a landmark in your filter. Within three gates of one of its kind it is left out: otherwise a second map grows."),
        Mistake("no map", _ekf(never_new=True), "Your map stays empty: what is near no landmark of its kind is new."),
        Mistake("all corners", _ekf(all_corners=True), "All your landmarks are corners. Note the kind of each."),
        Mistake("a gate of 4", _ekf(gate=4.0), "You use a gate of 4 whatever was given."),
        Mistake("the map kept back", _ekf(no_map=True), "Your estimate has no landmarks."),
        Mistake("shifted blocks", _ekf(pose_block=True), "Your landmarks' covariances are taken from the wrong place: the state begins with three numbers of the pose."),
        Mistake("variances alone", _ekf(variances=True), "Your pose's covariance has only its diagonal. What its numbers share belongs to it."),
    ],
    alternatives={"whole matrices, Joseph": _WholeMatrices, "tuples": _KeptAsAnEstimate, "complex angles": _FromTheLibrary},
    equivalents={
        "K = self.covariance[2, :] / (self.covariance[2, 2] + sigma ** 2)": "a covariance is symmetric: its row is its column",
        "self.covariance = self.covariance - np.outer(self.covariance[2], K)": "K is that row divided by a number",
        "numbers = self.indices[used]": "an array of the same numbers",
        "return Estimate(pose, self.covariance[:3, :3], landmarks, own, tuple(self.kinds))": "Estimate makes an array of the list",
        "return Estimate(pose, self.covariance[:3, :3], landmarks, np.array(own), self.kinds)": "Estimate makes a tuple of the list",
        "places = [self.state[3 + 2 * n:] for n in numbers]": "of a longer piece the first two numbers are the landmark",
        **dict.fromkeys(
            (
                f"places = [self.state[3 + 2 * n:{end}] for n in numbers]"
                for end in ("5 << 2 * n", "5 + 2 ** n", "5 + 2 << n", "6 + 2 * n", "5 + 3 * n")
            ),
            "of a longer piece the first two numbers are the landmark",
        ),
        **dict.fromkeys(
            (f"for i in np.flatnonzero(self.indices {test}):" for test in ("!= 0", "<= 0", "< 1")),
            "one that has a landmark within the gate has one within three",
        ),
        **dict.fromkeys(
            (
                "if associate(*belief, one, one.covariance, 3 * self.gate)[-1] < 0:",
                "self.state, self.covariance = add_landmark(self.state, self.covariance, one.values[-1], vague)",
                "self.kinds.append(one[-1].kind)",
            ),
            "the first of one is the last",
        ),
        **dict.fromkeys(
            (f"landmarks = self.state[3:].reshape({rows}, 2)" for rows in ("~1", "-2")), "NumPy takes any negative number"
        ),
        **dict.fromkeys(
            (
                f"self.indices, self.heading = {pair}"
                for pair in (
                    "(np.zeros(1, dtype=int), None)",
                    "(None, np.zeros(0, dtype=int))",
                    "(0, None)",
                    "(np, None)",
                    "(np.zeros(0), None)",
                    "(np.ones(0, dtype=int), None)",
                )
            ),
            "the first picture sets both",
        ),
        "if True:": "an update by nothing changes nothing",
        "self.indices = self.association(*belief, seen, seen.covariance, self.gate)": "associate returns whole numbers",
        "self.indices = np.array(self.association(*belief, seen, seen.covariance, self.gate))": "associate returns whole numbers",
        "control, noise = ([motion.distance, motion.turn], self.odometry.covariance(motion))": "predict unpacks it",
        "self.state, self.covariance = predict(self.state, self.covariance, control, noise, self.kinds)": "the solution of 07 counts the state",
    },
)


# --- 11.6 GraphSlam ---


def _graph(**changed: Any) -> type[SlamAlgorithm]:
    """The graph, with one thing done in another way."""

    class Changed(SlamAlgorithm):
        def __init__(
            self, start: Pose = Pose(), odometry: Any = FieldOdometry(), gate: float = 4.0, association: Any = None  # noqa: B008
        ) -> None:
            told = {"odometry": odometry, "gate": gate, "association": association}
            told.pop(changed.get("kept_back"), None)
            self.front, self.odometry = _ekf()(start, **told), odometry
            self.poses = [np.zeros(3) if changed.get("from_zeros") else start.as_array()]
            self.edges: list[Any] = []

        def move(self, motion: Motion) -> None:
            self.front.move(motion)
            here, Q = len(self.poses), self.odometry.covariance(motion)
            back = np.eye(3)
            if not changed.get("not_turned"):
                back[:2, :2] = rotation_2d(motion.turn if changed.get("other_way") else -motion.turn)
            Q = back @ Q @ back.T
            information = Q if changed.get("covariance") else np.linalg.inv(Q)
            if changed.get("units"):
                information = np.eye(3)
            self.edges.append((here - 1, here, (motion.distance, 0.0, motion.turn), information))
            self.poses.append(self.front.state[:3])  # type: ignore[attr-defined]

        def observe(self, measurements: Any) -> None:
            seen, front = as_observation(measurements), self.front
            front.observe(seen)
            if not changed.get("late"):
                self.poses[-1] = front.state[:3]  # type: ignore[attr-defined]
            used = np.flatnonzero(front.indices >= 0)  # type: ignore[attr-defined]
            self._note_headings(seen, max(len(used), 1) if changed.get("each_sight") else 1)
            picture, marks = seen.part(used), front.indices[used].tolist()  # type: ignore[attr-defined]
            expected = [_expected(front.state[:3], front.state[3 + 2 * j : 5 + 2 * j])[0][1] for j in marks]  # type: ignore[attr-defined]
            values, covariances = picture.apart(expected)
            if changed.get("as_independent"):
                covariances = [picture.part([n]).covariance for n in range(len(used))]
            if changed.get("as_measured"):
                values, covariances = picture.apart(picture.values[:, 1])
            for j, (b, r), R in zip(marks, values, covariances, strict=True):
                if changed.get("first_sights") and any(edge[1] == -1 - j for edge in self.edges):
                    continue
                ray = np.exp(1j * b)
                J = np.array([[-r * ray.imag, ray.real], [r * ray.real, ray.imag]])
                if changed.get("raw"):
                    J = np.eye(2)
                if changed.get("transposed"):
                    J = J.T
                z = (b, r) if changed.get("polar") else (r * ray.real, r * ray.imag)
                information = np.zeros((3, 3))
                information[:2, :2] = J @ R @ J.T if changed.get("covariance_seen") else np.linalg.inv(J @ R @ J.T)
                self.edges.append((len(self.poses) - 1, -1 - j, (*z, 0.0), information))

        def _note_headings(self, seen: Any, times: int) -> None:
            """The compass as an edge from the first pose."""
            heading, here = self.front.heading, len(self.poses) - 1  # type: ignore[attr-defined]
            if here == 0 or heading is None or changed.get("no_headings"):
                return
            if changed.get("filters_heading"):
                heading = self.front.state[2]  # type: ignore[attr-defined]
            turn = heading - (0.0 if changed.get("absolute") else self.poses[0][2])
            first, weight = here - 1 if changed.get("last_pose") else 0, seen.direction_sigma**-2
            self.edges += [(first, here, (0.0, 0.0, turn), np.diag([0.0, 0.0, weight]))] * times

        def estimate(self) -> Estimate:
            if not self.edges or changed.get("filter"):
                return self.front.estimate()
            poses, kinds = len(self.poses), self.front.kinds  # type: ignore[attr-defined]
            ends = [(a, b if b >= 0 else poses - 1 - b) for a, b, _, _ in self.edges]
            graph = Graph(
                np.array(ends),
                np.array([z for _, _, z, _ in self.edges]),
                np.array([information for *_, information in self.edges]),
                np.array([POSE] * poses + [LANDMARK] * len(kinds)),
            )
            states = np.concatenate([np.ravel(self.poses), self.front.state[3:]])  # type: ignore[attr-defined]
            guess = states
            states, _ = gauss_newton(graph, states, changed.get("steps", 10))
            H = linearize(graph, guess if changed.get("at_the_guess") else states)[0].toarray()
            covariance = np.zeros(H.shape)
            held = slice(3, None)
            covariance[held, held] = np.linalg.inv(H[held, held])
            if changed.get("conditional"):
                covariance = np.zeros(H.shape)
                for place in _places(poses, len(kinds)):
                    covariance[place, place] = np.linalg.inv(H[place, place])
            at = 3 * poses - 3
            if changed.get("first_pose"):
                at = 0
            if changed.get("free"):
                covariance = np.linalg.pinv(H)
            own = [covariance[n : n + 2, n : n + 2] for n in range(3 * poses, len(states), 2)]
            if changed.get("not_shifted"):
                own = [covariance[n : n + 2, n : n + 2] for n in range(3 * poses - 3, len(states) - 3, 2)]
            pose, spread = Pose.from_array(states[at : at + 3]), covariance[at : at + 3, at : at + 3]
            if changed.get("negative") and poses == 1:
                spread = covariance[-3:, -3:]
            if changed.get("filters_pose"):
                spread = self.front.covariance[:3, :3]  # type: ignore[attr-defined]
            if changed.get("filters_map"):
                own = list(self.front.estimate().landmark_covariances)
            return Estimate(
                pose, spread, states[3 * poses :].reshape(-1, 2), np.array(own), tuple(kinds)
            )

    return Changed


def _places(poses: int, landmarks: int) -> list[slice]:
    """Where each pose but the first, and each landmark, stands in the states."""
    begins = [*range(3, 3 * poses, 3), *range(3 * poses, 3 * poses + 2 * landmarks, 2)]
    return [slice(begin, begin + (3 if begin < 3 * poses else 2)) for begin in begins]


class _Once(_graph(late=True, steps=15)):  # type: ignore[misc]
    """Begins from poses as they were predicted."""


def _graphs_public() -> list[Case]:
    return [
        calls("estimate", given=(Pose(1.0, 0.5, 0.3),), name="before the first step"),
        calls(("move", Motion(0.3, 0.2)), "estimate", given=(Pose(1.0, 0.5, 0.3),), name="one move, nothing seen"),
        calls(("observe", drawn_drive(2012, 1).log[1][1]), "estimate", given=(Pose(1.0, 0.5, 0.3),), name="a look, no move"),
        _log_case(2012, 3, "three other moves", at_end=True),
        _log_case(2019, 3, "three moves, odometry twice as bad, gate 2", at_end=True, odometry=WORSE, gate=2.0),
        _log_case(2033, 3, "with another association", at_end=True, given=(associate_jointly,)),
        _log_case(2013, 3, "three moves and a compass", at_end=True, compass_sigma=COMPASS, circle_rate=0.0),
        _log_case(2010, 2, "lists of Measurement, from the origin", plain=True, at_end=True),
    ]


# Drives on which Gauss-Newton settles within a few steps, from the filter's poses and from predictions alike.
SETTLES = (2002, 2003, 2006, 2007, 2011, 2014, 2016, 2018, 2021, 2022, 2023, 2031, 2032, 2035, 2036)


def _graphs_hidden(rng: np.random.Generator) -> list[Case]:
    seeds = [int(seed) for seed in rng.choice(SETTLES, 4, replace=False)]
    start = Pose(*rng.uniform(-1, 1, 3))
    return [
        calls(("move", Motion(0.3, -0.4)), ("move", Motion(0.2, 0.1)), "estimate", given=(start,)),
        _log_case(seeds[0], 3, at_end=True),
        _log_case(seeds[1], 3, at_end=True, compass_sigma=COMPASS, circle_rate=0.0),
        _log_case(seeds[2], 2, gate=2.0, at_end=True, odometry=WORSE),
        _log_case(int(rng.choice(PARTED)), 3, at_end=True, given=(associate_jointly,)),
        calls(("observe", drawn_drive(seeds[0], 1).log[1][1]), "estimate", given=(start,)),
        _log_case(seeds[3], 2, plain=True, at_end=True),
    ]


GRAPH_SLAM = Exercise(
    name="GraphSlam",
    points=6,
    stars=3,
    uses=("EkfSlam", "05:landmark_position", "05:landmark_jacobians", "09:gauss_newton", "09:linearize", "09:marginal_covariances"),
    public=_graphs_public,
    hidden=_graphs_hidden,
    driver="methods",
    comparison=_as_estimated(5e-3),
    hints=(
        "Let EkfSlam decide which landmark is which (front.indices), and note an edge for each motion, each sight and each heading. Until estimate is called, a landmark's number among all unknowns is not known: note it apart.",
        "The landmark's place in the robot frame is landmark_position(np.zeros(3), (bearing, range)), and J of landmark_jacobians at the same zeros carries R there: its information is the inverse of J R Jᵀ. "
        "In H[3:, 3:] everything stands three places earlier than in states.",
    ),
    mistakes=[
        Mistake("the filter's answer", _graph(filter=True), "You return the filter's estimate. Its poses are only where gauss_newton begins."),
        Mistake("from zeros", _graph(from_zeros=True), "Your first pose is zeros. It is `start`, and gauss_newton holds it there."),
        Mistake("noise not turned", _graph(not_turned=True), "Your odometry's noise is along and across the old heading. pose_residual looks from where the motion ends: turn it by -motion.turn."),
        Mistake("turned the other way", _graph(other_way=True), "You turn odometry's noise the wrong way: from the old heading to the new one it is by -motion.turn."),
        Mistake("covariance of motion", _graph(covariance=True), "Your odometry's edges have covariances. An edge has an information, which is the inverse."),
        Mistake("covariance of sights", _graph(covariance_seen=True), "Your sights' edges have covariances. An edge has an information, which is the inverse."),
        Mistake("information of 1", _graph(units=True), "Your odometry's edges weigh 1. Their information is the inverse of self.odometry.covariance(motion)."),
        Mistake("bearing and range", _graph(polar=True), "Your sights are bearings and ranges. An edge to a landmark has metres ahead and metres left."),
        Mistake("R as it is", _graph(raw=True), "You invert R of bearing and range. The edge is in metres: J R Jᵀ first."),
        Mistake("J transposed", _graph(transposed=True), "You have Jᵀ R J: the measurement's covariance has to meet the columns of J."),
        Mistake("no headings", _graph(no_headings=True), "The compass is missing in your graph: every heading of the filter that is not None is an edge. Does your use_compass set self.heading?"),
        Mistake("a heading for each sight", _graph(each_sight=True), "You note the compass once for each measurement. A picture tells the heading once."),
        Mistake("the filter's heading", _graph(filters_heading=True), "You take the filter's heading for a measurement. It knows odometry and landmarks already, and they would count twice: front.heading is what the compass alone said."),
        Mistake("from east", _graph(absolute=True), "Your compass's edge has the heading itself. An edge from the first pose says how far the robot has turned since: take the start's heading off."),
        Mistake("from the last pose", _graph(last_pose=True), "Your compass's edge begins at the pose before. The turn is from the first pose, which is held."),
        Mistake("independent sights", _graph(as_independent=True), "You take the measurements of a picture for independent: k of them would know its tilt k times as well. seen.part(used).apart(ranges) has the covariances for that."),
        Mistake("ranges as measured", _graph(as_measured=True), "apart wants the ranges that are expected, from the filter's pose to its landmarks (equation 11.5)."),
        Mistake("first sights only", _graph(first_sights=True), "You note each landmark's first sight alone. Every sight is an edge."),
        Mistake("no step", _graph(steps=0), "Nothing is solved: gauss_newton takes no step."),
        Mistake("one step", _graph(steps=1), "One step of gauss_newton is not enough here: ten are."),
        Mistake("H at the guess", _graph(at_the_guess=True), "Your H is that of the filter's poses: linearize where gauss_newton has led."),
        Mistake("the gate kept back", _graph(kept_back="gate"), "Your EkfSlam is not given the gate."),
        Mistake("the odometry kept back", _graph(kept_back="odometry"), "Your EkfSlam is not given the odometry."),
        Mistake("the association kept back", _graph(kept_back="association"), "Your EkfSlam is not given the association."),
        Mistake("before the first move", _graph(negative=True), "Before the first move there is one pose alone, and it is held: its covariance is zero. Negative indices take somebody else's block."),
        Mistake("the filter's pose", _graph(filters_pose=True), "Your pose's covariance is the filter's. The graph's is a block of the inverse of H."),
        Mistake("the filter's map", _graph(filters_map=True), "Your landmarks' covariances are the filter's. The graph's are blocks of the inverse of H."),
        Mistake("conditional covariances", _graph(conditional=True), "You invert blocks of H: that is how sure each would be if all others were known. marginal_covariances takes blocks of the inverse."),
        Mistake("the first pose", _graph(first_pose=True), "You return the first pose. The robot is at the last one."),
        Mistake("shifted by three", _graph(not_shifted=True), "Your landmarks' covariances are three places off: H[3:, 3:] lacks the first pose, the whole H does not."),
        Mistake("nothing held", _graph(free=True), "Your covariances come from the whole H, in which the map may still slide. Hold the first pose: H[3:, 3:]."),
    ],
    alternatives={"a dense inverse": _graph(), "two steps more": _graph(steps=12), "from predictions": _Once},
    equivalents={
        "return Estimate(Pose.from_array(poses[-1]), blocks[0], landmarks, blocks[1:], tuple(kinds))": "Estimate makes an array of the list",
        "if abs(chi2[0] - chi2[-1]) <= 0.0001:": "no change is the limit to the last bit",
        "places = [np.arange(3 * p - 6, 3 * p - 3)] if p != 1 else []": "there is one pose at least",
        "turned = [0.0, 1.0, self.front.heading - self.poses[0][2]]": "of x and y that edge has no information",
        "self.edges.append((here, LANDMARK, number, [*z, -1.0], information))": "of a heading that edge has no information",
        **dict.fromkeys(
            (
                *(f"if abs(chi2[0] {sign} chi2[-1]) < 0.0001:" for sign in ("%", "/", "+", "*")),
                *(f"if abs({term}) < 0.0001:" for term in ("chi2[0]", "chi2[-1]", "chi2[-1] - chi2[0]")),
                *(f"if abs(chi2[0] - chi2[{place}]) < 0.0001:" for place in ("1", "-2", "+1", "~1")),
                "if abs(chi2[0] - chi2[-1]) == 0.0001:",
                "if abs(chi2[0] - chi2[-1]) < -0.9999:",
                "if False:",
            ),
            "some steps more or fewer change nothing any more",
        ),
        **dict.fromkeys(
            (f"turned = [{pair}, self.front.heading - self.poses[0][2]]" for pair in ("1.0, 0.0", "0.0, -1.0", "-1.0, 0.0")),
            "a heading's edge has no information of places",
        ),
        "numbers = self.front.indices[used]": "an array of whole numbers counts as well",
        "information = np.ones((3, 3))": "of a landmark's edge only the first two rows and columns count",
        "self.edges.append((here, LANDMARK, number, [*z, 1.0], information))": "a landmark has no angle",
        **dict.fromkeys(
            (
                "for number, value, own in zip(numbers, values, R):",
                "for number, value, own in zip(numbers, values, R, strict=False):",
            ),
            "all three are equally long",
        ),
        "return Estimate(Pose.from_array(poses[-1]), blocks[0], landmarks, np.array(blocks[1:]), kinds)": "Estimate makes a tuple of it",
        **dict.fromkeys(
            (
                f"ends = [(first, second + p * (kind {test} LANDMARK)) for first, kind, second, _, _ in self.edges]"
                for test in ("is", ">=")
            ),
            "there are two kinds, 0 and 1",
        ),
        "places = self.front.state[3:].reshape(-2, 2)[numbers]": "NumPy takes any negative number",
        "self.edges.append((POSE, 0, here, turned, np.diag([0.0, 0.0, seen.direction_sigma ** (-2)])))": "POSE is 0",
        "if p <= 1:": "there is one pose at least",
        "values, R = seen.part(used).apart(np.hypot(*(self.front.state[:2] - places).T))": "as far there as back",
    },
)


PLAN = LessonPlan(
    exercises=[MEASUREMENTS_FROM_PIXELS, MEASURE, JOINT_DISTANCE, ASSOCIATE, EKF_SLAM, GRAPH_SLAM],
    questions=[
        Question(
            "one_tilt",
            "In one picture the robot leans 1 degree forward and does not know it. Two corners are 2 m and 3 m ahead. What is wrong with their ranges?",
            {
                "Each has an error of its own; on average they cancel.": "Errors cancel where they are independent. Here one cause moves both: the next picture is another throw, but this one has been thrown.",
                "Both come out too far, the farther one by more.": "A robot that leans forward looks lower than it believes, so it puts everything too far; and by r squared over h, 2.3 times as far at 3 m as at 2 m. "
                "That is what the block off the diagonal of R says.",
                "Both are off by the same number of metres.": "They share the cause, not the size: it grows with r squared over h.",
                "Nothing, for bearings hold the map together.": "Bearings stay nearly right. But the ranges of all landmarks in the picture are wrong, in one direction.",
            },
            "Both come out too far, the farther one by more.",
        ),
        Question(
            "second_map",
            "With a gate of 1 sigma the map gets a second copy of many a corner. Why does it stay?",
            {
                "A copy near by has its own ellipse, and takes the next measurements that fit it better.": "Most right measurements fell outside the gate and corrected nothing, until one lay beyond three gates and was put on the map as new. Now there are two "
                "landmarks where one is, both are seen again, and nothing in the filter says that they are one.",
                "The gate grows with time, so they are forgotten.": "The gate is a constant, and nothing removes a landmark from a map.",
                "The update removes them, only slowly.": "An update moves landmarks and makes them surer. It never makes one of two.",
                "They have the wrong kind.": "They are corners, as the true one is.",
            },
            "A copy near by has its own ellipse, and takes the next measurements that fit it better.",
        ),
    ],
)
