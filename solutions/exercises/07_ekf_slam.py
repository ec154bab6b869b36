"""Lesson 07, EKF SLAM: its exercises, what students get wrong in them, and other right ways to write them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.linalg import block_diag

from nao_course.exercises import (
    All,
    Case,
    Close,
    Each,
    Exact,
    Exercise,
    LessonPlan,
    Mistake,
    Property,
    Question,
    Written,
)
from nao_course.geometry import Pose, rotation_2d, wrap_angle
from nao_course.lessons.ekf_slam.filters.many_looks import even_after_all
from nao_course.lessons.ekf_slam.noise import in_one_turn, joint_noise

Array = npt.NDArray[Any]
TURN = 2 * np.pi


# --- what several exercises need ---


def expected(pose: Any, landmark: Any) -> Array:
    """Bearing and range (2,) of a landmark."""
    dx, dy = landmark[0] - pose[0], landmark[1] - pose[1]
    return np.array([wrap_angle(np.arctan2(dy, dx) - pose[2]), np.hypot(dx, dy)])


def slopes(pose: Any, landmark: Any) -> tuple[Array, Array]:
    """Slopes of bearing and range by the pose (2, 3) and by the landmark (2, 2)."""
    dx, dy = landmark[0] - pose[0], landmark[1] - pose[1]
    r = max(np.hypot(dx, dy), 1e-9)  # a mistake looks at its own place
    by_landmark = np.array([[-dy / r**2, dx / r**2], [dx / r, dy / r]])
    return np.column_stack([-by_landmark, [-1.0, 0.0]]), by_landmark


def motion_slopes(pose: Any, control: Any) -> tuple[Array, Array]:
    """F (3, 3) by the pose, and G (3, 3) by the errors along, across and of the turn."""
    c, s = np.cos(pose[2]), np.sin(pose[2])
    F, G = np.eye(3), np.eye(3)
    F[:2, 2] = -control[0] * s, control[0] * c
    G[:2, :2] = [[c, -s], [s, c]]
    return F, G


def place(pose: Any, measurement: Any) -> tuple[Array, Array, Array]:
    """Where a measurement puts its landmark (2,); slopes of that by the pose (2, 3) and the measurement (2, 2)."""
    bearing, r = measurement
    c, s = np.cos(pose[2] + bearing), np.sin(pose[2] + bearing)
    by_pose = np.array([[1.0, 0.0, -r * s], [0.0, 1.0, r * c]])
    return np.array([pose[0] + r * c, pose[1] + r * s]), by_pose, np.array([[-r * s, c], [r * c, s]])


def spread(rng: np.random.Generator, size: int, *, scale: float = 0.2) -> Array:
    """A covariance (size, size) whose values are correlated, with standard deviations around `scale`."""
    root = rng.normal(0.0, 0.35, (size, size)) + np.eye(size) * rng.uniform(0.6, 1.2, size)
    return scale**2 * (root @ root.T)


def noise(rng: np.random.Generator, k: int, form: str) -> Array:
    """R in one of its three forms: "each" (2, 2), "own" (k, 2, 2) or "joint" (2k, 2k)."""
    if form == "each":
        return spread(rng, 2, scale=0.06)
    return (
        np.array([spread(rng, 2, scale=0.06) for _ in range(k)])
        if form == "own"
        else spread(rng, 2 * k, scale=0.07)
    )


def wrapped(angle: Any, sides: str) -> Any:
    """An angle, or several, wrapped where it leaves one turn on "both" sides, "above" or "below" only, on "neither"."""
    angle = np.asarray(angle, dtype=float)
    if sides == "both":
        return wrap_angle(angle)
    out = {"above": angle > np.pi, "below": angle < -np.pi, "neither": np.zeros(angle.shape, dtype=bool)}
    return np.where(out[sides], wrap_angle(angle), angle)[()]


FORMS = ("each", "own", "joint")


def around(rng: np.random.Generator, pose: Array, k: int) -> Array:
    """k landmarks (k, 2) in all directions, 0.8 to 4 m from a pose."""
    r, direction = rng.uniform(0.8, 4, k), rng.uniform(-np.pi, np.pi, k)
    return pose[:2] + np.column_stack([r * np.cos(direction), r * np.sin(direction)])


def random_pose(rng: np.random.Generator) -> Array:
    """A pose (3,) some metres around the origin."""
    return np.array([*rng.uniform(-3, 3, 2), rng.uniform(-3, 3)])


# --- 7.1 warp2pi ---


def _wrapped_by_loop(angle: Any) -> Any:
    values = np.array(angle, dtype=float)
    while np.any(values > np.pi):
        values = np.where(values > np.pi, values - TURN, values)
    while np.any(values < -np.pi):
        values = np.where(values < -np.pi, values + TURN, values)
    return values if values.ndim else float(values)


def _once(angle: Any) -> Any:
    values = np.array(angle, dtype=float)
    values = np.where(values > np.pi, values - TURN, values)
    return np.where(values < -np.pi, values + TURN, values)[()]


def _angles_public() -> list[Case]:
    return [
        Case((3.5,), "one angle, a little more than half a turn"),
        Case((-4.0,), "one angle to the right"),
        Case((0.3,), "one that is right already"),
        Case((np.array([0.5, 7.0, -7.0, 3.2]),), "four angles"),
        Case((np.array([20.0, -20.0, 200.0]),), "several turns"),
        Case((np.array([[1.0, 4.0], [-2.0, -5.0]]),), "a table of angles"),
    ]


def _angles_hidden(rng: np.random.Generator) -> list[Case]:
    return [
        *(Case((float(angle),)) for angle in rng.uniform(-9, 9, 3)),
        Case((rng.uniform(3.3, 4.3) * rng.choice([-1.0, 1.0], 6),)),
        Case((rng.uniform(-40, 40, 5),)),
        Case((rng.uniform(-12, 12, (2, 3)),)),
    ]


WARP2PI = Exercise(
    name="warp2pi",
    in_place=True,
    points=1,
    stars=1,
    public=_angles_public,
    hidden=_angles_hidden,
    comparison=All((Property(in_one_turn), Close(atol=1e-8, period=TURN))),
    hints=(
        "What is left of an angle when whole turns are taken away? The operator % does that, also for arrays; it gives 0 to a full turn.",
        "Shift by half a turn before the % and back behind it.",
    ),
    mistakes=[
        Mistake(
            "unchanged",
            lambda angle: np.asarray(angle)[()],
            "You return the angle as it came: whole turns are still in it.",
        ),
        Mistake(
            "0 to a full turn",
            lambda angle: np.asarray(angle) % TURN,
            "Your angles are from 0 to 2 pi. A landmark a little to the right must be a little below 0: shift by pi before the remainder, and back.",
        ),
        Mistake(
            "one turn only",
            _once,
            "Right for angles that are one turn off. 20 rad are three turns: take away as many as there are.",
        ),
        Mistake(
            "degrees",
            lambda angle: (np.asarray(angle) + 180.0) % 360.0 - 180.0,
            "You wrap at 180: the angles are in radians, and half a turn is np.pi.",
        ),
        Mistake(
            "half turns",
            lambda angle: (np.asarray(angle) + np.pi / 2) % np.pi - np.pi / 2,
            "You take away half turns: ahead and behind become the same. A turn is 2 pi.",
        ),
        Mistake(
            "shift kept",
            lambda angle: (np.asarray(angle) + np.pi) % TURN,
            "You shift by pi and do not shift back: straight ahead comes out as half a turn.",
        ),
        Mistake(
            "C's remainder",
            lambda angle: np.fmod(np.asarray(angle) + np.pi, TURN) - np.pi,
            "Right for positive angles. np.fmod keeps the sign of what it divides; % (or np.mod) does not.",
        ),
        Mistake(
            "one angle only",
            lambda angle: (
                float((angle + np.pi) % TURN - np.pi) if np.ndim(angle) == 0 else (angle > np.pi) and angle
            ),
            "Right for one angle; an array raises. Where you write `if` or `while` about an angle, an array of them has no one answer: % works on each.",
        ),
    ],
    alternatives={
        "sine and cosine": lambda angle: np.arctan2(np.sin(angle), np.cos(angle)),
        "complex numbers": lambda angle: np.angle(np.exp(1j * np.asarray(angle))),
        "turn by turn": _wrapped_by_loop,
        "the library's": wrap_angle,
    },
    equivalents={
        "return (np.asarray(angle) - np.pi) % (2 * np.pi) - np.pi": "a full turn less, which the remainder takes out",
        "return (angle + np.pi) % (2 * np.pi) - np.pi": "numbers and arrays can both be added to",
    },
)


# --- 7.2 init_landmarks ---


def _initial(
    measurements: Any, measurement_covariance: Any, pose: Any, pose_covariance: Any, **changed: Any
) -> Any:
    k = len(measurements) // 2
    R = joint_noise(measurement_covariance, k)
    pairs = np.reshape(measurements, (k, 2))
    if changed.get("swapped"):
        pairs = pairs[:, ::-1]
    at = np.array(pose, dtype=float)
    if changed.get("no_heading"):
        at[2] = 0.0
    if changed.get("clockwise"):
        pairs = pairs * (-1.0, 1.0)
    if changed.get("in_robot_frame"):
        at = np.zeros(3)
    if changed.get("six"):
        pairs = pairs * (np.arange(k) < 6)[:, None]
    placed = [place(at, pair) for pair in pairs]
    landmarks = np.concatenate([position for position, _, _ in placed])
    G = block_diag(*(slope for _, _, slope in placed))
    if changed.get("slopes_without_heading"):
        G = block_diag(*(place((*at[:2], 0.0), pair)[2] for pair in pairs))
    if changed.get("six"):
        landmarks[12:], G[12:] = 0, 0
    covariance = G @ R @ G.T
    if changed.get("transposed"):
        covariance = G.T @ R @ G
    if changed.get("raw"):
        covariance = R
    if changed.get("one_slope"):
        first = np.kron(np.eye(k), placed[0][2])
        covariance = first @ R @ first.T
    if changed.get("one_sided"):
        covariance = G @ R
    if changed.get("roots"):
        covariance = G @ np.sqrt(np.abs(R)) @ G.T
    if changed.get("textbook"):
        J = np.vstack([slope for _, slope, _ in placed])
        covariance = covariance + J @ pose_covariance @ J.T
    if changed.get("own_pose_part"):
        J = block_diag(*(slope for _, slope, _ in placed))
        covariance = covariance + J @ np.kron(np.eye(k), pose_covariance) @ J.T
    if changed.get("flat"):
        return k, landmarks.reshape(k, 2), covariance
    return (2 * k if changed.get("numbers") else k), landmarks, covariance


def _changed_start(**changed: Any) -> Any:
    def function(measurements: Any, measurement_covariance: Any, pose: Any, pose_covariance: Any) -> Any:
        return _initial(measurements, measurement_covariance, pose, pose_covariance, **changed)

    return function


def _initial_by_landmark(
    measurements: Any, measurement_covariance: Any, pose: Any, pose_covariance: Any
) -> Any:
    """Positions by frames, covariances turned block by block."""
    k = len(measurements) // 2
    bearings, ranges = np.asarray(measurements)[::2], np.asarray(measurements)[1::2]
    in_robot = (ranges * [np.cos(bearings), np.sin(bearings)]).T
    R = joint_noise(measurement_covariance, k)
    turned = [
        rotation_2d(pose[2] + b) @ np.array([[0, 1], [r, 0]]) for b, r in zip(bearings, ranges, strict=True)
    ]
    covariance = np.zeros((2 * k, 2 * k))
    for i in range(k):
        for j in range(k):
            covariance[2 * i : 2 * i + 2, 2 * j : 2 * j + 2] = (
                turned[i] @ R[2 * i : 2 * i + 2, 2 * j : 2 * j + 2] @ turned[j].T
            )
    return [k, Pose(*pose).to_parent(in_robot).ravel(), covariance]


def _initial_by_differences(
    measurements: Any, measurement_covariance: Any, pose: Any, pose_covariance: Any
) -> Any:
    k = len(measurements) // 2

    def all_places(flat: Array) -> Array:
        return np.concatenate([place(pose, pair)[0] for pair in flat.reshape(k, 2)])

    z = np.array(measurements, dtype=float)
    steps = 1e-6 * np.eye(2 * k)
    G = np.column_stack([(all_places(z + e) - all_places(z - e)) / 2e-6 for e in steps])
    return k, all_places(z), G @ joint_noise(measurement_covariance, k) @ G.T


def _initial_by_roots(measurements: Any, measurement_covariance: Any, pose: Any, pose_covariance: Any) -> Any:
    k = len(measurements) // 2
    z = np.reshape(measurements, (k, 2))
    direction = pose[2] + z[:, 0]
    c, s, r = np.cos(direction), np.sin(direction), z[:, 1]
    G = np.zeros((2 * k, 2 * k))
    even, odd = np.arange(0, 2 * k, 2), np.arange(1, 2 * k, 2)
    G[even, even], G[even, odd], G[odd, even], G[odd, odd] = -r * s, c, r * c, s
    half = G @ np.linalg.cholesky(joint_noise(measurement_covariance, k))
    return k, np.column_stack([pose[0] + r * c, pose[1] + r * s]).ravel(), half @ half.T


def _start_case(rng: np.random.Generator, k: int, form: str, name: str = "", pose: Any = None) -> Case:
    z = np.column_stack([rng.uniform(-3, 3, k), rng.uniform(0.6, 5, k)]).ravel()
    at = random_pose(rng) if pose is None else np.array(pose, dtype=float)
    return Case((z, noise(rng, k, form), at, spread(rng, 3, scale=0.1)), name)


def _start_public() -> list[Case]:
    rng = np.random.default_rng(72)
    simple = (
        np.array([0.0, 2.0, 1.2, 3.0]),
        np.diag([0.0004, 0.01]),
        np.zeros(3),
        np.diag([0.0004, 0.0004, 0.01]),
    )
    return [
        Case(simple, "two landmarks, seen from the origin"),
        _start_case(rng, 1, "each", "one landmark", (1.0, 2.0, 0.7)),
        _start_case(rng, 3, "own", "three landmarks, each with its own R", (1.0, -2.0, 2.0)),
        _start_case(rng, 2, "joint", "two landmarks with a common error: R is (4, 4)", (-1.0, 0.5, -1.1)),
        _start_case(rng, 8, "each", "eight landmarks", (0.5, 1.0, 0.4)),
    ]


def _start_hidden(rng: np.random.Generator) -> list[Case]:
    return [
        _start_case(rng, k, form)
        for k, form in ((1, "each"), (2, "each"), (4, "own"), (3, "joint"), (9, "each"))
    ]


INIT_LANDMARKS = Exercise(
    name="init_landmarks",
    in_place=True,
    points=2,
    stars=1,
    uses=("05:landmark_position", "05:landmark_jacobians"),
    public=_start_public,
    hidden=_start_hidden,
    comparison=Each((Exact(), Close(atol=1e-8), Close(atol=1e-8))),
    hints=(
        "k is half the number of values. Landmark i has measurements[2 * i : 2 * i + 2]; its place goes to the same places of the answer.",
        "Put the second matrix of landmark_jacobians for each landmark as a block on the diagonal of a (2k, 2k) matrix of zeros; then one product, "
        "blocks @ joint_noise(measurement_covariance, k) @ blocks.T.",
    ),
    mistakes=[
        Mistake(
            "how many numbers",
            _changed_start(numbers=True),
            "Your k counts numbers. Each landmark has two, a bearing and a range.",
        ),
        Mistake(
            "raw R",
            _changed_start(raw=True),
            "Your covariance is R itself: of bearing and range, in rad^2 and m^2. It has to be of x and y: turn it with the slopes of the place by the measurement.",
        ),
        Mistake(
            "slopes transposed",
            _changed_start(transposed=True),
            "You have Jᵀ R J; the measurement's covariance has to meet the columns of the slopes: J R Jᵀ.",
        ),
        Mistake(
            "one side only",
            _changed_start(one_sided=True),
            "A covariance meets the slopes from both sides: J R Jᵀ. Yours is J R, and not even symmetric.",
        ),
        Mistake(
            "the first one's slopes",
            _changed_start(one_slope=True),
            "All your landmarks have the slopes of the first. Each has a bearing and range of its own, and so slopes of its own.",
        ),
        Mistake(
            "the pose's part, too",
            _changed_start(textbook=True),
            "That is more than is asked: the doubt of the pose with all it brings. It is right, and exercise 7.7 does it. Here it is the homework's: J_z R J_zᵀ alone.",
        ),
        Mistake(
            "the pose's part in each block",
            _changed_start(own_pose_part=True),
            "You add the doubt of the pose to each landmark. That is half of what is right (the landmarks then belong together, too), and not what the "
            "homework does: J_z R J_zᵀ alone.",
        ),
        Mistake(
            "heading forgotten",
            _changed_start(no_heading=True),
            "You leave the heading out: a bearing counts from where the robot looks.",
        ),
        Mistake(
            "slopes without the heading",
            _changed_start(slopes_without_heading=True),
            "Your landmarks are right, their covariance is not turned with the robot: the slopes are taken at the pose, heading included.",
        ),
        Mistake(
            "six landmarks only",
            _changed_start(six=True),
            "Right for six landmarks and fewer; those behind the sixth are zeros. The log has six, a look may have any number: k = len(measurements) // 2.",
        ),
        Mistake(
            "in the robot frame",
            _changed_start(in_robot_frame=True),
            "Your landmarks lie in the robot's frame. On the map they lie at landmark_position(pose, measurement).",
        ),
        Mistake(
            "bearing's sign",
            _changed_start(clockwise=True),
            "Left and right are exchanged: a bearing is positive to the left, and adds to the heading.",
        ),
        Mistake(
            "range, bearing",
            _changed_start(swapped=True),
            "You take the range for the bearing: they come as (bearing, range, bearing, range, ...).",
        ),
        Mistake(
            "roots of R",
            _changed_start(roots=True),
            "You take the root of R. It has variances in it, and so has what comes out.",
        ),
        Mistake(
            "(k, 2)",
            _changed_start(flat=True),
            "Your landmarks are a table (k, 2). The state is one column of numbers: (2k,), x and y in turn.",
        ),
    ],
    alternatives={
        "block by block": _initial_by_landmark,
        "central differences": _initial_by_differences,
        "all at once": _initial_by_roots,
    },
    equivalents={
        "landmarks, slopes = (np.ones(2 * k), np.zeros((2 * k, 2 * k)))": "each of the ones is written over",
    },
)


# --- 7.3 predict ---


def _predicted(
    state: Any, covariance: Any, control: Any, control_covariance: Any, k: int, **changed: Any
) -> tuple[Array, Array]:
    at = np.array(state[:3], dtype=float)
    if changed.get("turned_first"):
        at[2] += control[1]
    F, G = motion_slopes(at, control)
    if changed.get("late_slopes"):
        c, s = np.cos(at[2]), np.sin(at[2])
        F, G = motion_slopes(at + (control[0] * c, control[0] * s, control[1]), control)
    new, P = (np.array(each, dtype=float) for each in (state, covariance))
    new[:3] += control[0] * np.cos(at[2]), control[0] * np.sin(at[2]), control[1]
    new[2] = wrapped(new[2], changed.get("wrap", "both"))
    if changed.get("moves_all"):
        new[3:] += np.tile(new[:2] - state[:2], k)
    Q = np.asarray(control_covariance)
    added = G @ Q @ G.T
    if changed.get("world"):
        added = Q
    if changed.get("wrong_side"):
        added = G.T @ Q @ G
    if changed.get("no_noise"):
        added = np.zeros((3, 3))
    if changed.get("F_transposed"):
        F = F.T
    if changed.get("no_F"):
        F = np.eye(3)
    P[:3, :3] = F @ P[:3, :3] @ F.T + added
    rows, columns = F @ P[:3, 3:], P[3:, :3] @ F.T
    if changed.get("cross_wrong_side"):
        rows, columns = F.T @ P[:3, 3:], P[3:, :3] @ F
    if changed.get("cross_zero"):
        rows, columns = 0 * rows, 0 * columns
    if not changed.get("pose_only"):
        P[:3, 3:] = rows
        P[3:, :3] = P[3:, :3] if changed.get("rows_only") else columns
    if changed.get("noise_everywhere"):
        P[3:, 3:] += np.kron(np.eye(k), added[:2, :2])
    if changed.get("a_little_noise"):
        P[3:, 3:] += changed["a_little_noise"] * np.eye(2 * k)
    return new, P


def _changed_motion(**changed: Any) -> Any:
    def function(state: Any, covariance: Any, control: Any, control_covariance: Any, k: int) -> Any:
        return _predicted(state, covariance, control, control_covariance, k, **changed)

    return function


def _predicted_whole(state: Any, covariance: Any, control: Any, control_covariance: Any, k: int) -> Any:
    """With slopes of the whole state."""
    F, G = motion_slopes(state[:3], control)
    whole, added = block_diag(F, np.eye(2 * k)), np.vstack([G, np.zeros((2 * k, 3))])
    shift = np.concatenate([control[0] * rotation_2d(state[2])[:, 0], [control[1]], np.zeros(2 * k)])
    new = state + shift
    new[2] = np.angle(np.exp(1j * new[2]))
    return new, whole @ covariance @ whole.T + added @ control_covariance @ added.T


def _predicted_in_blocks(state: Any, covariance: Any, control: Any, control_covariance: Any, k: int) -> Any:
    F, G = motion_slopes(state[:3], control)
    pose, cross, rest = covariance[:3, :3], covariance[:3, 3:], covariance[3:, 3:]
    x, y, theta = (Pose(*state[:3]) @ Pose(control[0], 0.0, control[1])).as_array()
    new = [x, y, theta, *state[3:]]
    return [
        new,
        np.block([[F @ pose @ F.T + G @ control_covariance @ G.T, F @ cross], [cross.T @ F.T, rest]]),
    ]


def _predicted_by_differences(
    state: Any, covariance: Any, control: Any, control_covariance: Any, k: int
) -> Any:
    def moved(values: Array, errors: Array) -> Array:
        c, s = np.cos(values[2]), np.sin(values[2])
        along = control[0] + errors[0]
        shift = [along * c - errors[1] * s, along * s + errors[1] * c, control[1] + errors[2]]
        return np.concatenate([values[:3] + shift, values[3:]])

    state, nothing, h = np.asarray(state, dtype=float), np.zeros(3), 1e-6
    F = np.column_stack(
        [
            (moved(state + h * e, nothing) - moved(state - h * e, nothing)) / (2 * h)
            for e in np.eye(len(state))
        ]
    )
    G = np.column_stack([(moved(state, h * e) - moved(state, -h * e)) / (2 * h) for e in np.eye(3)])
    new = moved(state, nothing)
    new[2] = wrap_angle(new[2])
    return new, F @ covariance @ F.T + G @ control_covariance @ G.T


def _motion_case(
    rng: np.random.Generator,
    k: int,
    control: Any,
    name: str = "",
    heading: float | None = None,
    plain: bool = False,
) -> Case:
    pose = random_pose(rng)
    if heading is not None:
        pose[2] = heading
    state = np.concatenate([pose, around(rng, pose, k).ravel()])
    Q = np.diag([0.25, 0.1, 0.1]) ** 2 if plain else spread(rng, 3, scale=0.1)
    return Case((state, spread(rng, 3 + 2 * k), np.array(control, dtype=float), Q, k), name)


def _motion_public() -> list[Case]:
    rng = np.random.default_rng(73)
    return [
        _motion_case(rng, 0, (1.0, 0.5), "no landmark yet", 0.4, plain=True),
        _motion_case(rng, 1, (0.8, -0.3), "one landmark", 1.2, plain=True),
        _motion_case(rng, 2, (1.0, 1.5), "two landmarks, and a turn past 180 degrees", 2.4),
        _motion_case(rng, 3, (-0.5, 0.2), "backwards, three landmarks", -0.8),
        _motion_case(rng, 1, (0.0, 0.0), "standing still", -2.0),
        _motion_case(rng, 1, (0.6, -1.5), "a turn past -180 degrees", -2.4),
    ]


def _motion_hidden(rng: np.random.Generator) -> list[Case]:
    cases = [
        _motion_case(rng, k, (rng.uniform(0.3, 1.5), rng.uniform(-1, 1)), plain=plain)
        for k, plain in ((1, True), (2, False), (4, True), (3, False), (0, False))
    ]
    cases += [
        _motion_case(rng, 2, (0.7, turn), heading=heading) for turn, heading in ((0.9, 2.9), (-0.9, -2.9))
    ]
    return cases


PREDICT = Exercise(
    name="predict",
    in_place=True,
    points=3,
    stars=2,
    uses=("warp2pi", "05:predict_pose", "05:motion_jacobians"),
    public=_motion_public,
    hidden=_motion_hidden,
    comparison=Each((Close(atol=1e-8), Close(rtol=1e-7, atol=1e-9))),
    hints=(
        "Copy both, and change only what a motion changes: the first three of the state, and the three blocks of equation 7.3 that have a p in their name.",
        "covariance[3:, :3] is P_lp: it becomes P_lp Fᵀ. The block [:3, 3:] is its transpose. The block [3:, 3:] stays.",
    ),
    mistakes=[
        Mistake(
            "cross-covariances left",
            _changed_motion(pose_only=True),
            "The pose's block is right. But the pose's errors change, so what they have in common with the map changes, too: P_pl becomes F P_pl, and P_lp its transpose.",
        ),
        Mistake(
            "rows without columns",
            _changed_motion(rows_only=True),
            "You change P_pl and forget P_lp below the diagonal: your covariance is not symmetric any more.",
        ),
        Mistake(
            "cross-covariances dropped",
            _changed_motion(cross_zero=True),
            "You set the pose's covariance with the map to zero. A motion does not make the robot forget where it measured the landmarks from: F P_pl.",
        ),
        Mistake(
            "cross-covariances from the wrong side",
            _changed_motion(cross_wrong_side=True),
            "Fᵀ P_pl: the slopes are transposed. It is F P_pl above the diagonal, and P_lp Fᵀ below it.",
        ),
        Mistake(
            "F transposed",
            _changed_motion(F_transposed=True),
            "All your F are transposed: F P Fᵀ, with the plain F on the left.",
        ),
        Mistake(
            "F left out",
            _changed_motion(no_F=True),
            "F is missing: while the robot drives, a doubt of its heading becomes one of its place.",
        ),
        Mistake(
            "noise in the world frame",
            _changed_motion(world=True),
            "You add Q as it is. It is along and across the robot: G Q Gᵀ turns it into the field's frame.",
        ),
        Mistake(
            "Gᵀ Q G",
            _changed_motion(wrong_side=True),
            "You have Gᵀ Q G, which turns the noise backwards: G Q Gᵀ.",
        ),
        Mistake(
            "no noise",
            _changed_motion(no_noise=True),
            "The motion's own errors are missing: add G Q Gᵀ.",
        ),
        Mistake(
            "noise on the landmarks",
            _changed_motion(noise_everywhere=True),
            "Your landmarks become less certain while the robot moves. They stand still: P_ll stays as it is.",
        ),
        Mistake(
            "a little noise on the landmarks",
            _changed_motion(a_little_noise=1e-7),
            "You add a little to the landmarks' variances, to be safe. They stand still: P_ll stays as it is, and what is added at each step adds up.",
        ),
        Mistake(
            "a millionth of noise on the landmarks",
            _changed_motion(a_little_noise=1e-6),
            "You add a millionth to the landmarks' variances, to be safe. They stand still: P_ll stays as it is, and what is added at each step adds up.",
        ),
        Mistake(
            "slopes at the new pose",
            _changed_motion(late_slopes=True),
            "Your F and G are taken where the robot arrives. Take them at the pose that comes in: before state[:3] is written over.",
        ),
        Mistake(
            "landmarks move along",
            _changed_motion(moves_all=True),
            "Your landmarks move along with the robot. Only the first three values of the state change.",
        ),
        Mistake(
            "turned first",
            _changed_motion(turned_first=True),
            "You turn first. The robot drives along its old heading, then turns; F and G are taken there, too.",
        ),
        Mistake(
            "heading not wrapped",
            _changed_motion(wrap="neither"),
            "Right, but the heading runs out of -pi to pi: give it to warp2pi.",
        ),
        Mistake(
            "heading wrapped above pi only",
            _changed_motion(wrap="above"),
            "Right for turns to the left; a heading below -pi stays as it is. warp2pi mends both sides.",
        ),
        Mistake(
            "heading wrapped below -pi only",
            _changed_motion(wrap="below"),
            "Right for turns to the right; a heading above pi stays as it is. warp2pi mends both sides.",
        ),
    ],
    alternatives={
        "slopes of the whole state": _predicted_whole,
        "np.block, a list": _predicted_in_blocks,
        "central differences": _predicted_by_differences,
    },
)


# --- 7.4 update_landmarks, 7.5 update ---


def linearised(state: Any, indices: Any, measurements: Any) -> tuple[Array, Array]:
    """H (2m, n) of some landmarks, and the innovation (2m,)."""
    m, n = len(indices), len(state)
    H, nu = np.zeros((2 * m, n)), np.array(measurements, dtype=float)
    for j, i in enumerate(indices):
        there = state[3 + 2 * i : 5 + 2 * i]
        H[2 * j : 2 * j + 2, :3], H[2 * j : 2 * j + 2, 3 + 2 * i : 5 + 2 * i] = slopes(state[:3], there)
        nu[2 * j : 2 * j + 2] -= expected(state[:3], there)
    nu[::2] = np.angle(np.exp(1j * nu[::2]))
    return H, nu


def _looked(
    state: Any, covariance: Any, indices: Any, measurements: Any, measurement_covariance: Any, **changed: Any
) -> tuple[Array, Array]:
    state, P, z = (
        np.array(state, dtype=float),
        np.array(covariance, dtype=float),
        np.array(measurements, dtype=float),
    )
    m, n = len(indices), len(state)
    H, surprise = np.zeros((2 * m, n)), np.zeros(2 * m)
    for j, i in enumerate(indices):
        i = i - 1 if changed.get("from_one") else j if changed.get("indices_ignored") else i
        first = 2 * i if changed.get("no_offset") else 3 + i if changed.get("one_number_each") else 3 + 2 * i
        there = state[first : first + 2]
        by_pose, by_landmark = slopes(state[:3], there)
        H[2 * j : 2 * j + 2, :3] += by_pose
        if not changed.get("pose_only"):
            H[2 * j : 2 * j + 2, first : first + 2] += by_landmark * (
                -1 if changed.get("sign_of_landmark") else 1
            )
        surprise[2 * j : 2 * j + 2] = z[2 * j : 2 * j + 2] - expected(state[:3], there)
    if changed.get("no_pose"):
        H[:, :3] = 0
    surprise[::2] = wrapped(surprise[::2], changed.get("wrap", "both"))
    if changed.get("ranges_wrapped"):
        surprise = wrap_angle(surprise)
    if changed.get("minus"):
        surprise = -surprise
    R = joint_noise(measurement_covariance, m)
    if changed.get("R_blocks"):
        R = R * np.kron(np.eye(m), np.ones((2, 2)))
    if changed.get("R_everywhere"):
        R = np.kron(np.ones((m, m)), R[:2, :2])
    if changed.get("roots"):
        R = np.sqrt(np.abs(R))
    if changed.get("no_R"):
        R = 1e-9 * np.eye(2 * m)
    used = P.copy()
    if changed.get("no_cross"):
        used[:3, 3:], used[3:, :3] = 0, 0
    if changed.get("blocks"):
        used = used * block_diag(np.ones((3, 3)), np.kron(np.eye((n - 3) // 2), np.ones((2, 2))))
    K = used @ H.T @ np.linalg.inv(H @ used @ H.T + R)
    shift = K @ surprise
    if changed.get("seen_only"):
        seen = [0, 1, 2, *(3 + 2 * i + c for i in indices for c in (0, 1))]
        shift[np.setdiff1d(np.arange(n), seen)] = 0
    new = state + shift
    new[2] = wrapped(new[2], changed.get("wrap_heading", "both"))
    left = used - K @ H @ used
    left = (left + left.T) / 2
    if changed.get("seen_block"):
        rest = np.setdiff1d(np.arange(n), [0, 1, 2, *(3 + 2 * i + c for i in indices for c in (0, 1))])
        new[rest], left[rest], left[:, rest] = state[rest], P[rest], P[:, rest]
    if changed.get("tidied"):
        left[np.abs(left) < 1e-6] = 0
    if changed.get("same"):
        left = P
    if changed.get("gain_minus"):
        new, left = state - shift, used + K @ H @ used
    if changed.get("added"):
        left = used + K @ H @ used
    if changed.get("behind"):
        left = used @ (np.eye(n) - K @ H)
    if changed.get("no_P"):
        left = np.eye(n) - K @ H
    return new, left


def _changed_look(**changed: Any) -> Any:
    def function(
        state: Any, covariance: Any, indices: Any, measurements: Any, measurement_covariance: Any
    ) -> Any:
        return _looked(state, covariance, indices, measurements, measurement_covariance, **changed)

    return function


def _one_by_one(
    state: Any, covariance: Any, indices: Any, measurements: Any, measurement_covariance: Any
) -> Any:
    """Landmark after landmark, each linearised where the one before has led."""
    R = joint_noise(measurement_covariance, len(indices))
    for j, i in enumerate(indices):
        rows = np.s_[2 * j : 2 * j + 2]
        state, covariance = _looked(state, covariance, [i], measurements[rows], R[rows, rows])
    return state, covariance


def _in_order(
    state: Any, covariance: Any, indices: Any, measurements: Any, measurement_covariance: Any
) -> Any:
    return _looked(state, covariance, sorted(indices), measurements, measurement_covariance)


def _carried(form: Any) -> Any:
    """A look whose covariance is `form(P, K, H, S, R)`, all of them whole."""

    def function(
        state: Any, covariance: Any, indices: Any, measurements: Any, measurement_covariance: Any
    ) -> Any:
        H, nu = linearised(state, indices, measurements)
        R = joint_noise(measurement_covariance, len(indices))
        S = H @ covariance @ H.T + R
        K = covariance @ H.T @ np.linalg.inv(S)
        new = state + K @ nu
        new[2] = wrap_angle(new[2])
        return new, form(covariance, K, H, S, R)

    return function


def _keep(K: Array, H: Array) -> Array:
    return np.eye(len(K)) - K @ H


def _gain_transposed(
    state: Any, covariance: Any, indices: Any, measurements: Any, measurement_covariance: Any
) -> Any:
    raise ValueError("operands could not be broadcast together: the gain is transposed")


def _by_information(
    state: Any, covariance: Any, indices: Any, measurements: Any, measurement_covariance: Any
) -> Any:
    """The same in information form."""
    H, z = linearised(state, indices, measurements)
    weight = np.linalg.inv(joint_noise(measurement_covariance, len(indices)))
    left = np.linalg.inv(np.linalg.inv(covariance) + H.T @ weight @ H)
    left = (left + left.T) / 2
    new = state + left @ H.T @ weight @ z
    new[2] = wrap_angle(new[2])
    return [new, left]


def _by_roots(
    state: Any, covariance: Any, indices: Any, measurements: Any, measurement_covariance: Any
) -> Any:
    """What is known is taken off, by Cholesky, from the columns that it touches."""
    state, m = np.array(state, dtype=float), len(indices)
    touched = [0, 1, 2, *(column for i in indices for column in (3 + 2 * i, 4 + 2 * i))]
    H = np.zeros((2 * m, len(touched)))
    z = []
    for j, i in enumerate(indices):
        there = state[3 + 2 * i : 5 + 2 * i]
        H[2 * j : 2 * j + 2, :3], H[2 * j : 2 * j + 2, 3 + 2 * j : 5 + 2 * j] = slopes(state[:3], there)
        bearing, distance = measurements[2 * j : 2 * j + 2] - expected(state[:3], there)
        z += [(bearing + np.pi) % TURN - np.pi, distance]
    shared = covariance[:, touched] @ H.T
    root = np.linalg.cholesky(H @ shared[touched] + joint_noise(measurement_covariance, m))
    W = np.linalg.solve(root, shared.T).T
    new = state + W @ np.linalg.solve(root, np.array(z))
    new[2] = wrap_angle(new[2])
    return new, covariance - W @ W.T


def _joseph(state: Any, covariance: Any, indices: Any, measurements: Any, measurement_covariance: Any) -> Any:
    """Slopes by central differences, and Joseph's form."""
    state, m = np.asarray(state, dtype=float), len(indices)

    def look(values: Array) -> Array:
        return np.concatenate([expected(values[:3], values[3 + 2 * i : 5 + 2 * i]) for i in indices])

    def less(first: Array, second: Array) -> Array:
        change = first - second
        change[::2] = wrap_angle(change[::2])
        return change

    H = np.column_stack([less(look(state + e), look(state - e)) / 2e-6 for e in 1e-6 * np.eye(len(state))])
    R = joint_noise(measurement_covariance, m)
    K = covariance @ H.T @ np.linalg.inv(H @ covariance @ H.T + R)
    keep = np.eye(len(state)) - K @ H
    new = state + K @ less(np.asarray(measurements, dtype=float), look(state))
    new[2] = wrap_angle(new[2])
    left = keep @ covariance @ keep.T + K @ R @ K.T
    return new, (left + left.T) / 2


def look_case(
    rng: np.random.Generator,
    k: int,
    indices: Sequence[int],
    form: str,
    name: str = "",
    *,
    heading: float | None = None,
    behind: bool = False,
    far: bool = False,
    turned: float = 0.0,
    side: float = 1.0,
    scale: float = 1.0,
) -> tuple[Case, int]:
    """A map of k landmarks, and what is measured of some of them."""
    pose = random_pose(rng)
    if heading is not None:
        pose[2] = heading
    landmarks = around(rng, pose, k)
    if behind:  # where a bearing passes the half turn
        direction = pose[2] + side * (np.pi - 0.03)
        landmarks[indices[0]] = pose[:2] + 2.0 * np.array([np.cos(direction), np.sin(direction)])
    state = np.concatenate([pose, landmarks.ravel()])
    z = np.concatenate([expected(pose, landmarks[i]) for i in indices]) + rng.normal(
        0, 0.08, 2 * len(indices)
    )
    if behind:
        z[0] = side * (np.pi - 0.03 + 0.12)
    z[::2] = wrap_angle(z[::2] - turned)
    if far:
        z[1] += 4.0
    P, R = spread(rng, 3 + 2 * k), noise(rng, len(indices), form)
    return Case((state, scale * P, list(indices), z, scale * R), name), k


def many_looks(rng: np.random.Generator, name: str = "", looks: int = 60, k: int = 3) -> Case:
    """Looks far from where the map begins, with the heading of all in doubt: there rounding grows quickly."""
    pose = np.array([100.0, 60.0, 0.7])
    state = np.concatenate([pose, around(rng, pose, k).ravel()])
    states = state + rng.normal(0, 0.1, (looks, len(state)))
    indices = [[look % k] for look in range(looks)]
    seen = [expected(at, at[3 + 2 * i : 5 + 2 * i]) for at, [i] in zip(states, indices, strict=True)]
    return Case(
        (
            states,
            turned_as_one(rng, state),
            indices,
            np.array(seen) + (0.02, 0.05),
            np.diag([0.02, 0.05]) ** 2,
        ),
        name,
    )


def turned_as_one(rng: np.random.Generator, state: Array) -> Array:
    """A covariance of a map whose place is in doubt by 1 m, and whose turn about the origin by 0.1 rad."""
    x, y = np.array([state[:2], *state[3:].reshape(-1, 2)]).T
    common = np.zeros((len(state), 3))
    common[2, 2] = 1.0
    at = np.array([0, *range(3, len(state), 2)])
    common[at, 0], common[at, 2] = 1.0, -y
    common[at + 1, 1], common[at + 1, 2] = 1.0, x
    common *= (1.0, 1.0, 0.1)
    return common @ common.T + spread(rng, len(state), scale=0.05)


def _look_public() -> list[Case]:
    rng = np.random.default_rng(74)
    drawn = [
        look_case(rng, 1, [0], "each", "the only landmark", heading=0.3),
        look_case(rng, 3, [1], "each", "the second of three", heading=-1.0),
        look_case(rng, 3, [0, 2], "each", "two of three at once", heading=2.0),
        look_case(rng, 3, [2, 0], "own", "in another order, each with its own R", heading=1.0),
        look_case(rng, 2, [0, 1], "joint", "with a common error: R is (4, 4)", heading=-0.5),
        look_case(rng, 2, [1], "each", "a landmark behind the robot", heading=0.5, behind=True),
        look_case(rng, 2, [0, 1], "each", "a heading that passes 180 degrees", heading=3.12, turned=0.5),
        look_case(rng, 2, [1], "each", "a range 4 m longer than expected", heading=0.1, far=True),
        look_case(rng, 2, [1], "each", "behind, on the other side", heading=0.5, behind=True, side=-1.0),
        look_case(rng, 2, [0, 1], "each", "a heading that passes -180 degrees", heading=-3.12, turned=-0.5),
        look_case(rng, 2, [1], "each", "all known to a millimetre", heading=0.8, scale=1e-5),
    ]
    return [*(case for case, _ in drawn), many_looks(rng, "60 looks, one after the other")]


def _look_hidden(rng: np.random.Generator) -> list[Case]:
    cases = [
        look_case(rng, k, list(rng.permutation(k)[:m].tolist()), form)[0]
        for k, m, form in (
            (1, 1, "each"),
            (4, 2, "own"),
            (3, 3, "each"),
            (5, 2, "joint"),
            (3, 1, "each"),
            (4, 3, "joint"),
        )
    ]
    cases += [look_case(rng, 2, [0], "each", behind=True, side=side)[0] for side in (1.0, -1.0)]
    cases += [look_case(rng, 3, [1], "own", far=True)[0], look_case(rng, 3, [2, 0], "each", scale=1e-5)[0]]
    cases += [
        look_case(rng, 2, [0, 1], "each", heading=heading, turned=turned)[0]
        for heading, turned in ((3.13, 0.5), (-3.13, -0.5))
    ]
    return [*cases, many_looks(rng)]


LOOK_MISTAKES = [
    Mistake(
        "innovation unwrapped",
        _changed_look(wrap="neither"),
        "Right, until a landmark is behind the robot: there the difference of two bearings is nearly a full turn. Give the innovation's bearings to warp2pi.",
    ),
    Mistake(
        "ranges wrapped, too",
        _changed_look(ranges_wrapped=True),
        "You wrap the whole innovation. Its ranges are metres: wrap innovation[::2] alone.",
    ),
    Mistake(
        "innovation's sign",
        _changed_look(minus=True),
        "You correct the wrong way: measured less expected.",
    ),
    Mistake(
        "R's blocks only",
        _changed_look(R_blocks=True),
        "Right, but for a full R: you use its 2 x 2 blocks on the diagonal and drop what the landmarks' errors have in common. joint_noise keeps it.",
    ),
    Mistake(
        "R everywhere",
        _changed_look(R_everywhere=True),
        "You repeat one R in every block, as if all landmarks had one common error. Different landmarks have different errors: blocks on the diagonal, as joint_noise makes them.",
    ),
    Mistake(
        "R as standard deviations",
        _changed_look(roots=True),
        "You take the root of R. It holds variances already.",
    ),
    Mistake(
        "S without R",
        _changed_look(no_R=True),
        "R is missing in S: you take measurements for exact.",
    ),
    Mistake(
        "one by one",
        _one_by_one,
        "You take one landmark after the other in, each linearised where the one before has led. All of one look belong into one update: every H and every innovation at the state that came in.",
    ),
    Mistake(
        "indices by size",
        _in_order,
        "You go through the map in its own order. indices says to which landmark each measurement belongs: the first pair to indices[0].",
    ),
    Mistake(
        "pose forgotten in the index",
        _changed_look(no_offset=True),
        "Landmark i begins at 3 + 2 i: the first three values are the pose.",
    ),
    Mistake(
        "counted from 1",
        _changed_look(from_one=True),
        "You count landmarks from 1. Index 0 is the first one, at state[3:5].",
    ),
    Mistake(
        "H of the pose only",
        _changed_look(pose_only=True),
        "H has the slopes by the pose only. The landmark's place is part of the state now: its slopes stand in the columns 3 + 2 i and 4 + 2 i.",
    ),
    Mistake(
        "H of the landmark only",
        _changed_look(no_pose=True),
        "H has the slopes by the landmark only: you take the pose for exact. Its slopes stand in the first three columns.",
    ),
    Mistake(
        "landmark's slopes with the wrong sign",
        _changed_look(sign_of_landmark=True),
        "The slopes by the landmark have the wrong sign: farther away makes the range longer.",
    ),
    Mistake(
        "only what is seen",
        _changed_look(seen_only=True),
        "You correct the pose and what is seen. The gain has rows for all others, too: what is learnt about the pose moves them.",
    ),
    Mistake(
        "no covariance between pose and map",
        _changed_look(no_cross=True),
        "You drop the covariance of pose and map. It is what carries a correction from one landmark to the others.",
    ),
    Mistake(
        "blocks of P only",
        _changed_look(blocks=True),
        "You use only the blocks on the diagonal of P: of the pose and of each landmark. The whole matrix counts.",
    ),
    Mistake(
        "gain transposed",
        _gain_transposed,
        "NumPy says that shapes do not fit. K is P Hᵀ S^-1, with a row for each value of the state; np.linalg.solve(S, H @ P) is its transpose.",
    ),
    Mistake(
        "covariance kept",
        _changed_look(same=True),
        "The state is right, the covariance is the old one: a look makes it smaller.",
    ),
    Mistake(
        "plus for minus",
        _changed_look(added=True),
        "Your covariance grows by a look: it is P - K H P.",
    ),
    Mistake(
        "wrong side",
        _changed_look(behind=True),
        "You multiply from the other side: (I - K H) P, not P (I - K H).",
    ),
    Mistake(
        "P forgotten behind",
        _changed_look(no_P=True),
        "You return I - K H, which is the part of P that is left: multiply by P.",
    ),
    Mistake(
        "heading not wrapped",
        _changed_look(wrap_heading="neither"),
        "Right, but the heading can leave -pi to pi by a correction: give it to warp2pi.",
    ),
    *(
        Mistake(
            f"innovation wrapped {side} only",
            _changed_look(wrap=side),
            f"You wrap bearings on one side only: an innovation {other} stays a whole turn too far. warp2pi mends both sides.",
        )
        for side, other in (("above", "below -pi"), ("below", "above pi"))
    ),
    *(
        Mistake(
            f"heading wrapped {side} only",
            _changed_look(wrap_heading=side),
            f"You wrap the heading on one side only: {other} it stays as it is. warp2pi mends both sides.",
        )
        for side, other in (("above", "below -pi"), ("below", "above pi"))
    ),
    Mistake(
        "only the block that is seen",
        _changed_look(seen_block=True),
        "You correct the pose and what is seen, with their block of P, and leave the rest. What is learnt about the pose is learnt about the whole map: all rows of K, all of P - K H P.",
    ),
    Mistake(
        "indices ignored",
        _changed_look(indices_ignored=True),
        "You take the measurements for those of the first landmarks of the map. indices says which they are: i = indices[j].",
    ),
    Mistake(
        "one number a landmark",
        _changed_look(one_number_each=True),
        "You step one number a landmark. Each has two, x and y: landmark i begins at 3 + 2 i.",
    ),
    Mistake(
        "gain's sign",
        _changed_look(gain_minus=True),
        "Your gain has the wrong sign: you move away from what was measured, and P grows. K = P Hᵀ S^-1, s + K nu, P - K H P.",
    ),
    Mistake(
        "small entries tidied away",
        _changed_look(tidied=True),
        "You set small entries of P to zero. A covariance of 1e-7 m^2 is one of two landmarks known to a third of a millimetre: what counts as small has a unit.",
    ),
    *(
        Mistake(
            name,
            _carried(form),
            f"Right for a look or ten. But rounding makes P a little lopsided, and {name.partition(',')[0]} lets that grow, look by look: return (P + P.T) / 2.",
        )
        for name, form in (
            ("P - K H P, never made symmetric", lambda P, K, H, S, R: P - K @ H @ P),
            ("(I - K H) P, never made symmetric", lambda P, K, H, S, R: (np.eye(len(P)) - K @ H) @ P),
            ("P - K S Kᵀ, never made symmetric", lambda P, K, H, S, R: P - K @ S @ K.T),
            (
                "Joseph's form, never made symmetric",
                lambda P, K, H, S, R: _keep(K, H) @ P @ _keep(K, H).T + K @ R @ K.T,
            ),
        )
    ),
]

UPDATE_LANDMARKS = Exercise(
    name="update_landmarks",
    in_place=True,
    points=5,
    stars=2,
    uses=(
        "warp2pi",
        "05:expected_measurement",
        "05:measurement_jacobian_pose",
        "05:measurement_jacobian_landmark",
    ),
    public=_look_public,
    hidden=_look_hidden,
    comparison=All((Property(even_after_all), Each((Close(atol=1e-7), Close(rtol=1e-6, atol=1e-8))))),
    driver="nao_course.lessons.ekf_slam.filters.many_looks:look_after_look",
    hints=(
        "First fill the innovation and H, two rows for each measured landmark: j counts the measurements, i = indices[j] the landmarks. Then wrap, then the lines of equation 7.5.",
        "Rows 2 j and 2 j + 1 of H: columns 0 to 2 are measurement_jacobian_pose, columns 3 + 2 i and 4 + 2 i are measurement_jacobian_landmark. Wrap "
        "innovation[::2] with warp2pi. S = H P Hᵀ + joint_noise(measurement_covariance, len(indices)).",
    ),
    mistakes=LOOK_MISTAKES,
    alternatives={
        "information form": _by_information,
        "what is known is taken off": _by_roots,
        "differences and Joseph's form": _joseph,
    },
    equivalents={
        "innovation, H = (np.ones(2 * m), np.zeros((2 * m, 3 + 2 * m)))": "each of the ones is written over",
    },
)


def _all_of(looked: Any, indices_of: Any = range) -> Any:
    def function(state: Any, covariance: Any, measurements: Any, measurement_covariance: Any, k: int) -> Any:
        return looked(state, covariance, list(indices_of(k)), measurements, measurement_covariance)

    return function


def _first_only(state: Any, covariance: Any, measurements: Any, measurement_covariance: Any, k: int) -> Any:
    R = joint_noise(measurement_covariance, k)
    return _looked(state, covariance, [0], measurements[:2], R[:2, :2])


def _without_last(state: Any, covariance: Any, measurements: Any, measurement_covariance: Any, k: int) -> Any:
    R = joint_noise(measurement_covariance, k)
    return _looked(state, covariance, range(k - 1), measurements[:-2], R[:-2, :-2])


def _not_copied(state: Any, covariance: Any, measurements: Any, measurement_covariance: Any, k: int) -> Any:
    return state, covariance


def _all_public() -> list[Case]:
    return [_all_case(case) for case in _all_looks(np.random.default_rng(75), named=True)]


def _all_looks(rng: np.random.Generator, named: bool = False) -> list[tuple[Case, int]]:
    names = (
        ("one landmark", "two", "three, each with its own R", "two with a common error")
        if named
        else ("",) * 4
    )
    sizes = ((1, "each"), (2, "each"), (3, "own"), (2, "joint"))
    return [look_case(rng, k, range(k), form, name) for (k, form), name in zip(sizes, names, strict=True)]


def _all_case(drawn: tuple[Case, int]) -> Case:
    case, k = drawn
    state, covariance, _, z, R = case.args
    return Case((state, covariance, z, R, k), case.name)


UPDATE = Exercise(
    name="update",
    in_place=True,
    points=1,
    stars=2,
    uses=("update_landmarks",),
    public=_all_public,
    hidden=lambda rng: [_all_case(drawn) for drawn in _all_looks(rng)],
    comparison=Each((Close(atol=1e-7), Close(atol=1e-7))),
    hints=(
        "update_landmarks does it already, if it is told that all k landmarks were measured, in their order.",
        "The indices of all k landmarks are range(k).",
    ),
    mistakes=[
        Mistake(
            "the first one only",
            _first_only,
            "You take in the first landmark only. All k are measured, in their order.",
        ),
        Mistake(
            "the last one forgotten",
            _without_last,
            "The last landmark is missing: range(k) has k numbers, 0 to k - 1.",
        ),
        Mistake(
            "one by one",
            _all_of(_one_by_one),
            "You call update_landmarks once for each landmark: then each is linearised where the one before has led. One call, with all indices.",
        ),
        Mistake(
            "backwards",
            _all_of(_looked, lambda k: range(k - 1, -1, -1)),
            "Your indices run backwards: the first pair of measurements is that of landmark 0.",
        ),
        Mistake(
            "nothing learnt",
            _not_copied,
            "You return what came in: nothing of the look is in it.",
        ),
    ],
    alternatives={
        "information form": _all_of(_by_information),
        "what is known is taken off": _all_of(_by_roots),
        "differences and Joseph's form": _all_of(_joseph),
    },
    equivalents={
        "return update_landmarks(state, covariance, range(k), measurements, measurement_covariance)": "the same numbers",
    },
)


# --- 7.6 evaluate_landmarks ---


def _distances(weigh: Any, root: bool = True) -> Any:
    """Both distances, the second of the squares that `weigh` gives."""

    def function(estimates: Any, covariances: Any, truth: Any) -> tuple[Array, Array]:
        errors = np.asarray(estimates) - truth
        squares = np.array([weigh(e, P) for e, P in zip(errors, covariances, strict=True)])
        return np.hypot(*errors.T), np.sqrt(np.abs(squares)) if root else squares

    return function


def _square(e: Array, P: Array) -> float:
    return float(e @ np.linalg.solve(P, e))


def _euclid(change: Any) -> Any:
    def function(estimates: Any, covariances: Any, truth: Any) -> Any:
        errors = np.asarray(estimates) - truth
        return change(errors), _distances(_square)(estimates, covariances, truth)[1]

    return function


def _by_cholesky(estimates: Any, covariances: Any, truth: Any) -> Any:
    errors = np.subtract(estimates, truth)
    scaled = np.linalg.solve(np.linalg.cholesky(covariances), errors[..., None])[..., 0]
    return np.linalg.norm(errors, axis=1), np.linalg.norm(scaled, axis=1)


def _by_einsum(estimates: Any, covariances: Any, truth: Any) -> Any:
    errors = np.subtract(estimates, truth)
    squares = np.einsum("ki,kij,kj->k", errors, np.linalg.inv(covariances), errors)
    return [np.sqrt((errors**2).sum(axis=1)), squares**0.5]


def _by_lists(estimates: Any, covariances: Any, truth: Any) -> Any:
    plain, weighed = [], []
    for (x, y), P, (u, v) in zip(estimates, covariances, truth, strict=True):
        dx, dy = x - u, y - v
        plain.append((dx * dx + dy * dy) ** 0.5)
        determinant = P[0, 0] * P[1, 1] - P[0, 1] * P[1, 0]
        weighed.append(((P[1, 1] * dx * dx - 2 * P[0, 1] * dx * dy + P[0, 0] * dy * dy) / determinant) ** 0.5)
    return plain, weighed


def _map_case(rng: np.random.Generator, k: int, name: str = "") -> Case:
    truth = rng.uniform(-4, 4, (k, 2))
    return Case(
        (
            truth + rng.normal(0, 0.3, (k, 2)),
            np.array([spread(rng, 2, scale=float(rng.uniform(0.1, 0.4))) for _ in range(k)]),
            truth,
        ),
        name,
    )


def _maps_public() -> list[Case]:
    rng = np.random.default_rng(76)
    axes = (
        np.array([[3.2, 6.0], [7.0, 8.2]]),
        np.array([np.diag([0.04, 0.01]), np.diag([0.04, 0.01])]),
        np.array([[3.0, 6.0], [7.0, 8.0]]),
    )
    along = np.array([[[0.09, 0.06], [0.06, 0.09]]] * 2)
    tilted = (np.array([[0.3, 0.3], [0.3, -0.3]]), along, np.zeros((2, 2)))
    return [
        Case(axes, "20 cm off, once where sigma is 20 cm and once where it is 10"),
        Case(tilted, "as far off along an ellipse and across it"),
        _map_case(rng, 6, "six landmarks"),
    ]


EVALUATE_LANDMARKS = Exercise(
    name="evaluate_landmarks",
    points=2,
    stars=2,
    public=_maps_public,
    hidden=lambda rng: [_map_case(rng, k) for k in (1, 3, 6, 8)],
    comparison=Close(atol=1e-8, names=("your Euclidean distance", "your Mahalanobis distance")),
    hints=(
        "The second distance is the root of lesson 06's NEES, for each landmark with its own covariance.",
        "For one landmark: error @ np.linalg.solve(covariance, error), then the root. Loop over the landmarks.",
    ),
    mistakes=[
        Mistake(
            "the homework's",
            _distances(lambda e, P: e @ P @ e),
            "That is the homework's own distance, sqrt(d' P d): without the inverse. It becomes larger where the filter is less certain. Divide by the covariance.",
        ),
        Mistake(
            "no root",
            _distances(_square, root=False),
            "Your second distance is squared. The Mahalanobis distance is its root: 1 is one standard deviation.",
        ),
        Mistake(
            "diagonal only",
            _distances(lambda e, P: np.sum(e**2 / np.diag(P))),
            "You use the variances alone. An ellipse that is tilted has a covariance, too: 0.3 along it and 0.3 across it are not the same.",
        ),
        Mistake(
            "standard deviations for variances",
            _distances(lambda e, P: np.sum((e / np.diag(P)) ** 2)),
            "The diagonal has variances: their roots are the standard deviations by which an error is divided.",
        ),
        Mistake(
            "each entry's inverse",
            _distances(lambda e, P: e @ (1 / np.where(P == 0, np.inf, P)) @ e),
            "You take one over each entry. The inverse of a matrix is another matrix: np.linalg.solve(P, d).",
        ),
        Mistake(
            "unweighed",
            _distances(lambda e, P: e @ e),
            "Both your distances are the same: the covariance is not in it.",
        ),
        Mistake(
            "squared metres",
            _euclid(lambda errors: (errors**2).sum(axis=1)),
            "Your Euclidean distance is squared: take the root.",
        ),
        Mistake(
            "sum of both axes",
            _euclid(lambda errors: np.abs(errors).sum(axis=1)),
            "You add the errors along x and y. The Euclidean distance is the root of the sum of their squares.",
        ),
        Mistake(
            "over the landmarks",
            _euclid(lambda errors: np.sqrt((errors**2).sum(axis=0))),
            "You sum over the landmarks and leave x and y apart. A distance belongs to each landmark: sum along axis 1.",
        ),
        Mistake(
            "exchanged",
            lambda estimates, covariances, truth: _distances(_square)(estimates, covariances, truth)[::-1],
            "The two are exchanged: the Euclidean distances come first.",
        ),
    ],
    alternatives={"Cholesky": _by_cholesky, "np.einsum": _by_einsum, "plain numbers": _by_lists},
    equivalents={
        "errors = truth - estimates": "a distance has no direction",
        "squares = [np.linalg.solve(P, error) @ error for error, P in zip(errors, covariances, strict=True)]": "a product of two "
        "vectors has no order",
        "return (np.hypot(errors[:, 1], errors[:, 0]), np.sqrt(squares))": "nor has a sum of squares",
    },
)


# --- 7.7 add_landmark ---


def _added(
    state: Any, covariance: Any, measurement: Any, measurement_covariance: Any, **changed: Any
) -> tuple[Array, Array]:
    state, P, R = (
        np.array(state, dtype=float),
        np.array(covariance, dtype=float),
        np.asarray(measurement_covariance),
    )
    n = len(state)
    at = np.zeros(3) if changed.get("robot_frame") else state[:3]
    position, J, Z = place(at, measurement)
    if changed.get("no_heading"):
        J = np.column_stack([J[:, :2], np.zeros(2)])
    cross = P[:, :3] @ J.T
    pose_part, noise_part = J @ P[:3, :3] @ J.T, Z @ R @ Z.T
    if changed.get("raw"):
        noise_part = R
    if changed.get("Z_transposed"):
        noise_part = Z.T @ R @ Z
    if changed.get("no_noise"):
        noise_part = np.zeros((2, 2))
    own = pose_part + noise_part
    if changed.get("no_pose_part"):
        own = noise_part
    if changed.get("homework"):
        own, cross = noise_part, 0 * cross
    if changed.get("no_cross"):
        cross = 0 * cross
    if changed.get("pose_cross_only"):
        cross[3:] = 0
    if changed.get("minus"):
        cross = -cross
    if changed.get("cross_with_noise"):
        cross[:3] += np.vstack([noise_part, np.zeros((1, 2))])
    left = 0 * cross.T if changed.get("upper_only") else cross.T
    if changed.get("first"):
        order = [0, 1, 2, n, n + 1, *range(3, n)]
        whole = np.block([[P, cross], [left, own]])
        return np.append(state, position)[order], whole[np.ix_(order, order)]
    if changed.get("polar"):
        position = np.asarray(measurement)
    return np.append(state, position), np.block([[P, cross], [left, own]])


def _changed_add(**changed: Any) -> Any:
    def function(state: Any, covariance: Any, measurement: Any, measurement_covariance: Any) -> Any:
        return _added(state, covariance, measurement, measurement_covariance, **changed)

    return function


def _added_by_one_jacobian(state: Any, covariance: Any, measurement: Any, measurement_covariance: Any) -> Any:
    n = len(state)
    position, J, Z = place(state[:3], measurement)
    slope = np.zeros((n + 2, n + 2))
    slope[:n, :n] = np.eye(n)
    slope[n:, :3], slope[n:, n:] = J, Z
    return np.concatenate([state, position]), slope @ block_diag(covariance, measurement_covariance) @ slope.T


def _added_in_place(state: Any, covariance: Any, measurement: Any, measurement_covariance: Any) -> Any:
    n = len(state)
    bearing, r = measurement
    toward = r * np.exp(1j * (state[2] + bearing))
    J = np.array([[1, 0, -toward.imag], [0, 1, toward.real]])
    Z = np.column_stack([[-toward.imag, toward.real], [toward.real / r, toward.imag / r]])
    larger = np.zeros((n + 2, n + 2))
    larger[:n, :n] = covariance
    larger[n:, :n] = J @ covariance[:3]
    larger[:n, n:] = larger[n:, :n].T
    larger[n:, n:] = J @ covariance[:3, :3] @ J.T + Z @ measurement_covariance @ Z.T
    return [[*state, state[0] + toward.real, state[1] + toward.imag], larger]


def _added_by_differences(state: Any, covariance: Any, measurement: Any, measurement_covariance: Any) -> Any:
    n, h = len(state), 1e-6
    both = np.concatenate([state, measurement])

    def grown(values: Array) -> Array:
        return np.concatenate([values[:n], place(values[:3], values[n:])[0]])

    slope = np.column_stack([(grown(both + h * e) - grown(both - h * e)) / (2 * h) for e in np.eye(n + 2)])
    return grown(both), slope @ block_diag(covariance, measurement_covariance) @ slope.T


def _new_case(rng: np.random.Generator, k: int, name: str = "", pose: Any = None) -> Case:
    at = random_pose(rng) if pose is None else np.array(pose, dtype=float)
    state = np.concatenate([at, around(rng, at, k).ravel()])
    z = np.array([rng.uniform(-3, 3), rng.uniform(0.7, 4)])
    return Case((state, spread(rng, 3 + 2 * k), z, spread(rng, 2, scale=0.08)), name)


def _new_public() -> list[Case]:
    rng = np.random.default_rng(77)
    start = (np.zeros(3), np.zeros((3, 3)), np.array([0.5, 2.0]), np.diag([0.0007, 0.01]))
    simple = (np.zeros(3), np.diag([0.01, 0.02, 0.04]), np.array([0.0, 2.0]), np.diag([0.01, 0.09]))
    return [
        Case(start, "the very first landmark, from a pose that is zeros and certain"),
        Case(simple, "2 m straight ahead of an uncertain pose"),
        _new_case(rng, 0, "the first landmark, from anywhere", (1.0, -1.0, 0.8)),
        _new_case(rng, 1, "a second landmark", (0.5, 2.0, -1.3)),
        _new_case(rng, 3, "a fourth landmark", (-1.0, 0.5, 2.2)),
    ]


ADD_LANDMARK = Exercise(
    name="add_landmark",
    in_place=True,
    points=5,
    stars=3,
    uses=("05:landmark_position", "05:landmark_jacobians"),
    public=_new_public,
    hidden=lambda rng: [_new_case(rng, k) for k in (0, 1, 2, 3, 5)],
    comparison=Each((Close(atol=1e-8), Close(atol=1e-8))),
    hints=(
        "How does an error of the whole old state, and one of the measurement, change the new state? Write that as one matrix, and carry a covariance through it as in lesson 05.",
        "The new landmark's error is J_p times the pose's error plus J_z times the measurement's. Its covariance with the old state is therefore P[:, :3] J_pᵀ, with all rows; "
        "its own is J_p P_pp J_pᵀ + J_z R J_zᵀ.",
    ),
    mistakes=[
        Mistake(
            "the homework's",
            _changed_add(homework=True),
            "That is init_landmarks again: J_z R J_zᵀ alone, and zeros beside it. A landmark that is put on the map from a doubtful pose shares that doubt.",
        ),
        Mistake(
            "no pose part",
            _changed_add(no_pose_part=True),
            "The covariances beside it are right, its own is too small: the pose's doubt belongs to it, J_p P_pp J_pᵀ + J_z R J_zᵀ.",
        ),
        Mistake(
            "no covariance with the rest",
            _changed_add(no_cross=True),
            "Its own covariance is right. But if the pose is wrong, the new landmark is wrong in the same way: it has a covariance with the pose, and with all that has one with the pose.",
        ),
        Mistake(
            "with the pose only",
            _changed_add(pose_cross_only=True),
            "You have its covariance with the pose, and zeros with the other landmarks. They share errors with the pose, so they share errors with the new one: use all rows, P[:, :3] J_pᵀ.",
        ),
        Mistake(
            "one side only",
            _changed_add(upper_only=True),
            "Your covariance is not symmetric: what stands above the diagonal has to stand below it, transposed.",
        ),
        Mistake(
            "sign",
            _changed_add(minus=True),
            "The covariances with the rest have the wrong sign: a pose too far to the left puts the landmark too far to the left.",
        ),
        Mistake(
            "raw R",
            _changed_add(raw=True),
            "You add R itself, of bearing and range: J_z R J_zᵀ is that of x and y.",
        ),
        Mistake(
            "J_z transposed",
            _changed_add(Z_transposed=True),
            "You have J_zᵀ R J_z: the measurement's covariance has to meet the columns of J_z.",
        ),
        Mistake(
            "no noise",
            _changed_add(no_noise=True),
            "The measurement's own noise is missing: + J_z R J_zᵀ.",
        ),
        Mistake(
            "heading left out",
            _changed_add(no_heading=True),
            "You leave the heading's doubt out. At 3 m, 5 degrees are 26 cm: J_p has three columns.",
        ),
        Mistake(
            "noise beside the diagonal",
            _changed_add(cross_with_noise=True),
            "Your covariances with the pose hold the measurement's noise. What was measured just now has nothing in common with errors of the pose.",
        ),
        Mistake(
            "in the robot frame",
            _changed_add(robot_frame=True),
            "Your landmark lies in the robot's frame. On the map it lies at landmark_position(pose, measurement).",
        ),
        Mistake(
            "bearing and range kept",
            _changed_add(polar=True),
            "You append bearing and range. The state has x and y of each landmark.",
        ),
    ],
    alternatives={
        "one Jacobian of all": _added_by_one_jacobian,
        "a larger matrix, filled": _added_in_place,
        "central differences": _added_by_differences,
    },
)


PLAN = LessonPlan(
    exercises=[
        WARP2PI,
        INIT_LANDMARKS,
        PREDICT,
        UPDATE_LANDMARKS,
        UPDATE,
        EVALUATE_LANDMARKS,
        ADD_LANDMARK,
    ],
    questions=[
        Question(
            "why_correlated",
            "Two landmarks lie on opposite sides of the field, and no measurement speaks of both. Why do their errors become "
            "correlated?",
            {
                "They are measured with the same sensor, so their noise is.": "Its noise is drawn anew for each measurement: R has blocks on its diagonal and zeros "
                "elsewhere. The correlation comes with R diagonal, too.",
                "H is dense, so everything is mixed with everything.": "H has two blocks in a row, of the pose and of one landmark, and zeros for all others.",
                "Both were measured from a pose that is uncertain: an error of it shifts both.": "What they share is the pose's error. P_lp H_pᵀ carries it into the gain's rows "
                "of every landmark, and a look at one then corrects the other.",
                "A motion adds the same noise to both.": "A motion adds nothing to a landmark: P_ll stays as it is. It carries on what pose and map share, F P_pl.",
            },
            "Both were measured from a pose that is uncertain: an error of it shifts both.",
        ),
        Question(
            "constant_time",
            "A robot has mapped 1,000 landmarks and sees one. Which of the report's ideas makes the update's time independent of the "
            "1,000, and leaves the result as it is?",
            {
                "Update only what is in range.": "The one that is seen has a covariance with all others, and P - K H P has four million entries. With one landmark in "
                "view instead of six the update is still of that size.",
                "Forget landmarks that are uncertain or old.": "That makes the map smaller, and throws away what they knew about the rest. It is another result.",
                "Local maps: update the neighbourhood, and the rest once, when it is left.": "That is the compressed filter. It notes what the rest has to be multiplied by, and "
                "does so once. The result is the same to rounding.",
                "Find matches with a KD-tree.": "That makes the search for a match quicker, and the update stays as it is.",
            },
            "Local maps: update the neighbourhood, and the rest once, when it is left.",
        ),
    ],
    written=[
        Written(
            "explain_inside",
            points=2,
            question="Every true landmark lies inside its ellipse. Why does it not follow that the covariances are reliable?",
            rubric="1 point: an ellipse that is too large holds every truth, so lying inside says nothing against a covariance that is too large. 1 point: what "
            "would be seen if it were right: errors as large as stated, a Mahalanobis distance of about 1.25 on average (or NEES 2), about one in twenty "
            "outside 95 %; here it is 0.07.",
        )
    ],
)
