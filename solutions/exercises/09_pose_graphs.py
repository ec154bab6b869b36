"""Lesson 09, pose graphs: its exercises, what students get wrong in them, and other right ways to write them."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy.sparse
import scipy.sparse.linalg

from nao_course.exercises import Case, Close, Exercise, LessonPlan, Mistake, Question, Written
from nao_course.geometry import rotation_2d, wrap_angle
from nao_course.graphs import LANDMARK, POSE, Graph, matrices
from nao_course.lessons.pose_graphs.judging.comparing import SolvedStates
from nao_course.lessons.pose_graphs.worlds import (
    building,
    disturbed,
    drifting_loop,
    field_drive,
    loop,
    with_false_closures,
)

Array = npt.NDArray[np.float64]
Pair = tuple[Array, Array]
DRIVERS = "nao_course.lessons.pose_graphs.judging.drivers"
BLOCKS, AS_ARRAY = f"{DRIVERS}:blocks_of_inverse", f"{DRIVERS}:as_array"
FINE = Close(rtol=1e-6, atol=1e-7)


# --- the functions, with something changed: what they hold without a change is right ---


def _parts(values: Any) -> Array:
    """The columns of (3,) or (E, 3): numbers, or arrays (E,)."""
    return np.asarray(values, dtype=float).T


def _seen(pose: Any, place: Any, sign: float = 1.0) -> Pair:
    """A place (2,) or (E, 2) in a pose's frame, x and y; `sign` -1 turns the wrong way."""
    x, y, theta = _parts(pose)
    px, py = _parts(place)[:2]
    c, s = np.cos(theta), sign * np.sin(theta)
    return c * (px - x) + s * (py - y), -s * (px - x) + c * (py - y)


def _landmark(change: str = "") -> Callable[..., Any]:
    def function(pose: Any, landmark: Any, z: Any) -> Any:
        x, y, theta = _parts(pose)
        lx, ly = _parts(landmark)
        zx, zy = _parts(z)
        if change == "one":
            x, y, theta = pose
        if change == "three" and len(pose) == 3 and np.ndim(pose) == 2:
            lx, ly = landmark
        if change == "degrees":
            theta = np.radians(theta)
        here = np.stack([x, y, theta], axis=-1)
        ahead, left = _seen(here, landmark, -1.0 if change == "turn" else 1.0)
        c, s = np.cos(theta), np.sin(theta)
        if change == "no shift":
            ahead, left = c * lx + s * ly, -s * lx + c * ly
        if change == "shift last":
            ahead, left = c * lx + s * ly - x, -s * lx + c * ly - y
        if change == "no turn":
            ahead, left = lx - x, ly - y
        e = [ahead - zx, left - zy]
        if change == "sign":
            e = [zx - ahead, zy - left]
        if change == "no z":
            e = [ahead, left]
        if change == "world":
            e = [lx - x - (c * zx - s * zy), ly - y - (s * zx + c * zy)]
        if change == "polar":
            gone = np.hypot(ahead, left) - np.hypot(zx, zy)
            e = [wrap_angle(np.arctan2(left, ahead) - np.arctan2(zy, zx)), gone]
        return _shaped(change, e)

    return function


def _shaped(change: str, e: Sequence[Any]) -> Any:
    """The numbers of a residual as (E, d); or with one edge, or none, in another shape."""
    rows = np.stack(np.broadcast_arrays(*e), axis=-1)
    if change == "columns":
        return np.array(e)
    if change == "list":
        return list(e)
    if change == "squeezed":
        return np.squeeze(rows)
    return np.array(list(rows)) if change == "loop" else rows


def _landmark_complex(pose: Any, landmark: Any, z: Any) -> Any:
    x, y, theta = np.asarray(pose).T
    away = (np.asarray(landmark) @ [1, 1j] - x - 1j * y) * np.exp(-1j * theta) - np.asarray(z) @ [1, 1j]
    return np.array([away.real, away.imag]).T


def _landmark_rotations(pose: Any, landmark: Any, z: Any) -> Any:
    theta = np.asarray(pose)[..., 2]
    turn = matrices([[np.cos(theta), np.sin(theta)], [-np.sin(theta), np.cos(theta)]])
    return np.einsum("...ij,...j->...i", turn, np.asarray(landmark) - np.asarray(pose)[..., :2]) - z


def _landmark_polar(pose: Any, landmark: Any, z: Any) -> Any:
    away = np.asarray(landmark) - np.asarray(pose)[..., :2]
    angle = np.arctan2(away[..., 1], away[..., 0]) - np.asarray(pose)[..., 2]
    return np.hypot(away[..., :1], away[..., 1:]) * np.stack([np.cos(angle), np.sin(angle)], axis=-1) - z


def _landmark_slopes(change: str = "") -> Callable[..., Any]:
    def function(pose: Any, landmark: Any, z: Any) -> Any:
        theta = _parts(pose)[2]
        c, s = np.cos(theta), np.sin(theta)
        if change == "turn":
            s = -s
        ahead, left = _seen(pose, landmark)
        if change == "less z":
            ahead, left = ahead - _parts(z)[0], left - _parts(z)[1]
        if change == "in the field":
            ahead, left = _parts(landmark)[0] - _parts(pose)[0], _parts(landmark)[1] - _parts(pose)[1]
        by_theta = {"theta 0": (0 * ahead, 0 * left), "theta sign": (-left, ahead)}.get(
            change, (left, -ahead)
        )
        if change == "theta order":
            by_theta = (-ahead, left)
        pose_rows = [[-c, -s, by_theta[0]], [s, -c, by_theta[1]]]
        mark_rows = [[c, s], [-s, c]]
        if change == "sign":
            pose_rows, mark_rows = (
                [[-each for each in row] for row in rows] for rows in (pose_rows, mark_rows)
            )
        if change == "pose sign":
            pose_rows = [[c, s, by_theta[0]], [-s, c, by_theta[1]]]
        both = matrices(pose_rows), matrices(mark_rows)
        if change == "swapped":
            return both[::-1]
        if change == "transposed":
            return tuple(each.swapaxes(-1, -2) for each in both)
        if change == "one matrix":
            return np.concatenate(both, axis=-1)
        if change == "last":
            return tuple(np.moveaxis(each, 0, -1) if each.ndim == 3 else each for each in both)
        return both

    return function


def _each(function: Callable[..., Any]) -> Callable[..., Any]:
    """A function of one pair, for many too, one after the other."""

    def for_all(first: Any, second: Any, z: Any) -> Any:
        if np.ndim(first) == 1:
            return function(first, second, z)
        rows = z.shape[1]
        found = [np.empty((len(z), rows, 3)), np.empty((len(z), rows, rows))]
        for k, pair in enumerate(zip(first, second, z, strict=True)):
            found[0][k], found[1][k] = function(*pair)
        return tuple(found)

    return for_all


def _differences(residual: Callable[..., Array]) -> Callable[..., Any]:
    """Central differences of a residual, for one pair."""

    def slopes(first: Any, second: Any, z: Any) -> tuple[Array, ...]:
        ends, found = [np.array(first, dtype=float), np.array(second, dtype=float)], []
        for which in (0, 1):
            columns = []
            for number in range(len(ends[which])):
                step = np.zeros(len(ends[which]))
                step[number] = 1e-5
                high, low = (
                    residual(*[end + sign * step if k == which else end for k, end in enumerate(ends)], z)
                    for sign in (1, -1)
                )
                columns.append((high - low) / 2e-5)
            found.append(np.stack(columns, axis=1))
        return tuple(found)

    return slopes


def _landmark_slopes_one(pose: Any, landmark: Any, z: Any) -> Any:
    c, s = np.cos(pose[2]), np.sin(pose[2])
    turn = np.array([[c, s], [-s, c]])
    slope = np.array([[-s, c], [-c, -s]]) @ (np.asarray(landmark) - np.asarray(pose)[:2])
    return np.column_stack([-turn, slope]), turn


def _pose(change: str = "") -> Callable[..., Any]:
    def function(first: Any, second: Any, z: Any) -> Any:
        if change == "order":
            first, second = second, first
        zx, zy, turn = _parts(z)
        theta = _parts(second)[2] - _parts(first)[2]
        if change == "one":
            _, _, _ = first
        if change == "three" and len(first) == 3 and np.ndim(first) == 2:
            first, second, z = (np.asarray(each).T for each in (first, second, z))
            return _pose()(first, second, z).T
        ahead, left = _seen(first, second, -1.0 if change == "turn" else 1.0)
        ahead, left = ahead - zx, left - zy
        c, s = np.cos(turn), np.sin(turn)
        if change == "z turn":
            s = -s
        if change == "z rotated late":
            ahead, left = ahead + zx, left + zy
        if change != "frame":
            ahead, left = c * ahead + s * left, -s * ahead + c * left
        if change == "z rotated late":
            ahead, left = ahead - zx, left - zy
        angle = theta + turn if change == "plus z" else theta - turn
        wrapped = {
            "unwrapped": angle,
            "0 to 2 pi": angle % (2 * np.pi),
            "degrees": np.degrees(wrap_angle(angle)),
            "z unwrapped": wrap_angle(theta) - turn,
            "sine": np.sin(angle),
            "no turn": wrap_angle(theta),
        }.get(change, wrap_angle(angle))
        e = [ahead, left, wrapped]
        if change == "sign":
            e = [-each for each in e]
        if change == "difference":
            e = [*(_parts(second) - _parts(first) - _parts(z))[:2], wrapped]
        if change == "wrapped all":
            e = [wrap_angle(each) for each in e]
        if change == "z last":
            goal = _pose()(np.zeros(3), np.stack([-zx, -zy, -turn], axis=-1), np.zeros(3))
            back = _seen(np.stack([0 * zx, 0 * zx, turn], axis=-1), goal)
            apart, ahead, left = theta, *_seen(first, second)
            c, s = np.cos(apart), np.sin(apart)
            e = [ahead + c * back[0] - s * back[1], left + s * back[0] + c * back[1], e[2]]
        return _shaped(change, e)

    return function


def _matrix_of(pose: Any) -> Array:
    x, y, theta = _parts(pose)
    c, s = np.cos(theta), np.sin(theta)
    return matrices([[c, -s, x], [s, c, y], [0, 0, 1]])


def _pose_matrices(first: Any, second: Any, z: Any) -> Any:
    e = np.linalg.inv(_matrix_of(z)) @ np.linalg.inv(_matrix_of(first)) @ _matrix_of(second)
    return np.stack([e[..., 0, 2], e[..., 1, 2], np.arctan2(e[..., 1, 0], e[..., 0, 0])], axis=-1)


def _pose_complex(first: Any, second: Any, z: Any) -> Any:
    x, y, theta = (np.asarray(each).T for each in (first, second, z))
    place = [each[0] + 1j * each[1] for each in (x, y, theta)]
    away = ((place[1] - place[0]) * np.exp(-1j * x[2]) - place[2]) * np.exp(-1j * theta[2])
    return np.array([away.real, away.imag, np.angle(np.exp(1j * (y[2] - x[2] - theta[2])))]).T


def _pose_goal(first: Any, second: Any, z: Any) -> Any:
    """Where z puts the second pose, and the second pose in that frame."""
    x, y, theta = _parts(first)
    zx, zy, turn = _parts(z)
    c, s = np.cos(theta), np.sin(theta)
    goal = np.stack(np.broadcast_arrays(x + c * zx - s * zy, y + s * zx + c * zy, theta + turn), axis=-1)
    ahead, left = _seen(goal, second)
    delta = _parts(second)[2] - goal[..., 2]
    return np.stack([ahead, left, np.arctan2(np.sin(delta), np.cos(delta))], axis=-1)


def _pose_slopes(change: str = "") -> Callable[..., Any]:
    def function(first: Any, second: Any, z: Any) -> Any:
        theta, turn = _parts(first)[2], _parts(z)[2]
        angle = {"no z": theta, "only z": turn + 0 * theta, "minus z": theta - turn}.get(change, theta + turn)
        c, s = np.cos(angle), np.sin(angle)
        if change == "turn":
            s = -s
        dx, dy = (_parts(second) - _parts(first))[:2]
        column = [-s * dx + c * dy, -c * dx - s * dy, -1.0]
        if change == "theta 0":
            column = [0.0, 0.0, -1.0]
        if change == "theta sign":
            column = [-column[0], -column[1], -1.0]
        if change == "less z":
            zx, zy = _parts(z)[:2]
            cz, sz = np.cos(turn), np.sin(turn)
            column = [column[0] - (-sz * zx + cz * zy), column[1] - (-cz * zx - sz * zy), -1.0]
        if change == "less z as it stands":
            zx, zy = _parts(z)[:2]
            column = [column[0] - zy, column[1] + zx, -1.0]
        last = {"plus 1": 1.0, "no -1": 0.0}.get(change, -1.0)
        first_rows = [[-c, -s, column[0]], [s, -c, column[1]], [0, 0, last]]
        second_rows = [[c, s, 0], [-s, c, 0], [0, 0, 1]]
        if change == "sign":
            first_rows, second_rows = (
                [[-each for each in row] for row in rows] for rows in (first_rows, second_rows)
            )
        if change == "second too":
            second_rows = [[c, s, -column[0]], [-s, c, -column[1]], [0, 0, 1]]
        both = matrices(first_rows), matrices(second_rows)
        if change == "swapped":
            return both[::-1]
        if change == "transposed":
            return tuple(each.swapaxes(-1, -2) for each in both)
        if change == "one matrix":
            return np.concatenate(both, axis=-1)
        if change == "last":
            return tuple(np.moveaxis(each, 0, -1) if each.ndim == 3 else each for each in both)
        return both

    return function


def _pose_slopes_products(first: Any, second: Any, z: Any) -> Any:
    """The second by rotations; the first is minus the second times a pose's move."""
    angle = np.asarray(first)[..., 2] + np.asarray(z)[..., 2]
    zero, one = np.zeros_like(angle), np.ones_like(angle)
    by_second = matrices(
        [[np.cos(angle), np.sin(angle), zero], [-np.sin(angle), np.cos(angle), zero], [0, 0, one]]
    )
    dx, dy = (_parts(second) - _parts(first))[:2]
    lever = matrices([[1, 0, -dy], [0, 1, dx], [0, 0, one]])
    return -(by_second @ lever), by_second


def _pose_slopes_one(first: Any, second: Any, z: Any) -> Any:
    turn = _matrix_of([0.0, 0.0, first[2] + z[2]]).T
    away = np.array([second[0] - first[0], second[1] - first[1], 0.0])
    slope = np.array([[0.0, 1, 0], [-1, 0, 0], [0, 0, 0]]) @ turn @ away - [0, 0, 1]
    return np.column_stack([-turn[:, :2], slope]), turn


# --- 9.1 to 9.4: pairs to try them on ---


def _any(rng: np.random.Generator, count: int, width: int = 3, spread: float = 4.0) -> Array:
    """Poses (count, 3) with headings all round, or places (count, 2)."""
    values = rng.normal(0.0, spread, (count, width))
    if width == 3:
        values[:, 2] = rng.uniform(-np.pi, np.pi, count)
    return values


def _landmark_public() -> list[Case]:
    rng = np.random.default_rng(91)
    ahead = np.array([1.0, 2.0, np.pi / 2])
    return [
        Case((ahead, np.array([0.0, 5.0]), np.array([2.5, 1.0])), "the robot looks along y"),
        Case((np.array([1.0, 0.0, 0.0]), np.array([3.0, 1.0]), np.array([2.0, 1.0])), "measured exactly"),
        Case((_any(rng, 1)[0], _any(rng, 1, 2)[0], _any(rng, 1, 2)[0]), "a crooked heading"),
        Case((_any(rng, 4), _any(rng, 4, 2), _any(rng, 4, 2)), "four edges at once"),
        Case((_any(rng, 3), _any(rng, 3, 2), _any(rng, 3, 2)), "three edges, as many as a pose has numbers"),
        Case((_any(rng, 1), _any(rng, 1, 2), _any(rng, 1, 2)), "an array of one edge"),
        Case((_any(rng, 0), _any(rng, 0, 2), _any(rng, 0, 2)), "an array of no edge"),
    ]


def _landmark_hidden(rng: np.random.Generator) -> list[Case]:
    one = [Case((_any(rng, 1)[0], _any(rng, 1, 2)[0], _any(rng, 1, 2)[0])) for _ in range(3)]
    return [*one, *(Case((_any(rng, n), _any(rng, n, 2), _any(rng, n, 2))) for n in (1, 3, 2, 50, 0))]


def _pose_public() -> list[Case]:
    rng = np.random.default_rng(93)
    return [
        Case(
            (np.array([1.0, 2.0, np.pi / 2]), np.array([1.0, 4.0, np.pi]), np.array([1.5, 0.0, np.pi / 2])),
            "two steps where 1.5 were measured, then a left turn",
        ),
        Case(
            (np.array([0.0, 0.0, 3.0]), np.array([-1.0, 0.2, -3.1]), np.array([1.0, 0.0, 0.1])),
            "headings on both sides of pi",
        ),
        Case((_any(rng, 1)[0], _any(rng, 1)[0], _any(rng, 1)[0]), "crooked headings"),
        Case((_any(rng, 5), _any(rng, 5), _any(rng, 5)), "five edges at once"),
        Case((_any(rng, 3), _any(rng, 3), _any(rng, 3)), "three edges, as many as a pose has numbers"),
        Case((_any(rng, 1), _any(rng, 1), _any(rng, 1)), "an array of one edge"),
        Case((_any(rng, 0), _any(rng, 0), _any(rng, 0)), "an array of no edge"),
    ]


def _pose_hidden(rng: np.random.Generator) -> list[Case]:
    near = np.array([0.0, 0.0, np.pi - 1e-3])
    cases = [Case((_any(rng, 1)[0], _any(rng, 1)[0], _any(rng, 1)[0])) for _ in range(3)]
    cases += [Case((near, _any(rng, 1)[0] * [1, 1, 0] - near, _any(rng, 1)[0] * [1, 1, 0.1]))]
    return [*cases, *(Case((_any(rng, n), _any(rng, n), _any(rng, n))) for n in (1, 3, 60, 0))]


ONE_ONLY = (
    "Right for one edge, and not for many at once: with arrays (E, 3) your unpacking takes rows for columns. Unpack the transpose, as in "
    "the worked example: x, y, theta = pose.T"
)
THREE_EDGES = (
    "Right but for three edges at once: len(pose) == 3 does not tell three edges from one pose. No question is needed: pose.T unpacks both, "
    "as in the worked example."
)
SQUEEZED = (
    "Right but for an array of one edge: (1, 3) stays an array of one row. A squeeze takes that row away."
)
NO_EDGE = (
    "Right but for an array of no edge: what comes back has no columns. A graph without landmarks has no edge to one. Calculate with whole "
    "arrays, without a loop, and it comes out by itself."
)
A_LIST = "Return one array, np.array([...]).T: linearize calculates with it, and a list cannot be indexed by columns."
BY_COLUMNS = "Your answer has one column an edge; wanted is one row an edge. End with .T, which changes nothing for a single edge."


LANDMARK_RESIDUAL = Exercise(
    name="landmark_residual",
    points=1,
    stars=1,
    public=_landmark_public,
    hidden=_landmark_hidden,
    comparison=FINE,
    driver=AS_ARRAY,
    in_place=True,
    hints=(
        "First the way from the pose to the landmark, then turn it into the robot's frame, then take away what was measured.",
        "With dx, dy from pose to landmark, c and s of the heading: ahead is c dx + s dy, left is -s dx + c dy. End as the worked example does.",
    ),
    mistakes=[
        Mistake(
            "turned the wrong way",
            _landmark("turn"),
            "You turn into the field's frame, not into the robot's: the signs of the two sines are exchanged.",
        ),
        Mistake(
            "sign",
            _landmark("sign"),
            "Your sign is opposite: expected minus measured, as equation 9.1 has it.",
        ),
        Mistake(
            "z left out",
            _landmark("no z"),
            "That is where the landmark should be seen. Take away z, where it was seen.",
        ),
        Mistake(
            "position left out",
            _landmark("no shift"),
            "You turn the landmark's place in the field. First comes the way from the robot to it: landmark minus position.",
        ),
        Mistake(
            "turned before it was shifted",
            _landmark("shift last"),
            "You turn first and subtract the position after that. The position is in the field's frame: subtract it before you turn.",
        ),
        Mistake(
            "heading left out",
            _landmark("no turn"),
            "The difference is still in the field's frame, and z is in the robot's. Turn it by minus the heading.",
        ),
        Mistake(
            "in the field's frame",
            _landmark("world"),
            "You turned z into the field's frame and compare there. The length of the residual is the same; wanted is the robot's frame, in which "
            "z and its information are given.",
        ),
        Mistake(
            "bearing and range",
            _landmark("polar"),
            "You compare bearings and ranges. Here z is Cartesian: metres ahead and metres to the left.",
        ),
        Mistake("degrees", _landmark("degrees"), "The heading is in radians already. Do not convert it."),
        Mistake("one edge only", _landmark("one"), ONE_ONLY),
        Mistake("three edges for one", _landmark("three"), THREE_EDGES),
        Mistake("squeezed", _landmark("squeezed"), SQUEEZED),
        Mistake("a list of no rows", _landmark("loop"), NO_EDGE),
        Mistake("a list", _landmark("list"), A_LIST),
        Mistake("columns", _landmark("columns"), BY_COLUMNS),
    ],
    alternatives={
        "complex numbers": _landmark_complex,
        "rotation matrices": _landmark_rotations,
        "by way of the bearing": _landmark_polar,
    },
)

LANDMARK_RESIDUAL_JACOBIANS = Exercise(
    name="landmark_residual_jacobians",
    points=2,
    stars=2,
    public=_landmark_public,
    hidden=_landmark_hidden,
    comparison=Close(
        rtol=1e-6, atol=1e-7, names=("the Jacobian by the pose", "the Jacobian by the landmark")
    ),
    hints=(
        "By the landmark it is the rotation itself. By x and y of the pose it is minus that. By theta: derive both rows on the sheet above.",
        "Derived by theta, the first row becomes the second one without z: -s dx + c dy. The second becomes minus the first one without z. matrices(...) takes numbers and arrays.",
    ),
    mistakes=[
        Mistake(
            "sign",
            _landmark_slopes("sign"),
            "All signs are opposite: this is the Jacobian of measured minus expected. The residual is expected minus measured.",
        ),
        Mistake(
            "sign by the pose",
            _landmark_slopes("pose sign"),
            "Check the columns of x and y: when the robot goes ahead, the landmark comes nearer, so what it sees gets smaller.",
        ),
        Mistake(
            "theta forgotten",
            _landmark_slopes("theta 0"),
            "The column of theta is 0 in yours. When the robot turns, everything that it sees moves.",
        ),
        Mistake(
            "sign of theta",
            _landmark_slopes("theta sign"),
            "The column of theta has the opposite sign: when the robot turns left, what it sees moves to the right.",
        ),
        Mistake(
            "rows of theta",
            _landmark_slopes("theta order"),
            "The column of theta: turning moves a point at right angles to where it is seen. By turning, ahead changes with how far left the "
            "landmark is, and left with how far ahead.",
        ),
        Mistake(
            "theta from the residual",
            _landmark_slopes("less z"),
            "In the column of theta you use the residual, with z taken away. z does not turn with the robot: only the landmark as it should be seen does.",
        ),
        Mistake(
            "theta in the field's frame",
            _landmark_slopes("in the field"),
            "In the column of theta you use the way to the landmark in the field's frame. It has to be turned into the robot's.",
        ),
        Mistake(
            "turned the wrong way",
            _landmark_slopes("turn"),
            "The sines have the wrong signs: the rotation here leads from the field's frame into the robot's.",
        ),
        Mistake(
            "order",
            _landmark_slopes("swapped"),
            "The Jacobian by the pose comes first, then the one by the landmark.",
        ),
        Mistake(
            "transposed",
            _landmark_slopes("transposed"),
            "Both are transposed: a row for each number of the residual, a column for each number that it is derived by.",
        ),
        Mistake(
            "one matrix",
            _landmark_slopes("one matrix"),
            "Return two matrices, (2, 3) and (2, 2), not one beside the other.",
        ),
        Mistake(
            "edges last",
            _landmark_slopes("last"),
            "Right for one edge. For E of them the shape is (E, 2, 3), edges first: matrices(...) of the worked example makes that.",
        ),
    ],
    alternatives={
        "central differences": _each(_differences(_landmark())),
        "edge by edge": _each(_landmark_slopes_one),
        "products": lambda pose, landmark, z: _landmark_slopes_by_lever(pose, landmark),
    },
)


def _landmark_slopes_by_lever(pose: Any, landmark: Any) -> Any:
    theta = np.asarray(pose)[..., 2]
    turn = matrices([[np.cos(theta), np.sin(theta)], [-np.sin(theta), np.cos(theta)]])
    dx, dy = _parts(landmark) - _parts(pose)[:2]
    return -turn @ matrices([[1, 0, -dy], [0, 1, dx]]), turn


POSE_RESIDUAL = Exercise(
    name="pose_residual",
    points=2,
    stars=2,
    public=_pose_public,
    hidden=_pose_hidden,
    comparison=FINE,
    driver=AS_ARRAY,
    in_place=True,
    hints=(
        "Two changes of frame, one after the other, each like that of exercise 9.1: the second pose in the frame of the first, and that in the frame of z.",
        "After the first change subtract z's x and y and turn by z's own angle. The headings simply subtract: second - first - z, and then "
        "wrap_angle.",
    ),
    mistakes=[
        Mistake(
            "unwrapped",
            _pose("unwrapped"),
            "The angle is not wrapped: headings of 3.1 and -3.1 are nearly the same direction, and your residual says 6.2 rad. wrap_angle is loaded.",
        ),
        Mistake(
            "wrapped too early",
            _pose("z unwrapped"),
            "You wrap the difference of the headings and subtract z's angle after that: the result can leave (-pi, pi] again. Wrap last.",
        ),
        Mistake(
            "from 0 to 2 pi",
            _pose("0 to 2 pi"),
            "Your angle goes from 0 to 2 pi: an error of -0.1 becomes 6.18, as far from 0 as can be. wrap_angle has 0 in its middle.",
        ),
        Mistake("degrees", _pose("degrees"), "The angle has to stay in radians."),
        Mistake(
            "the sine of it",
            _pose("sine"),
            "The third number is the angle itself, wrapped; you return its sine.",
        ),
        Mistake(
            "not in z's frame",
            _pose("frame"),
            "Nearly: x and y are in the first pose's frame, second minus z. inv(Z) also turns them by minus z's angle. Both forms exist in books, "
            "with other Jacobians, and with the information in another frame; ours is equation 9.4.",
        ),
        Mistake(
            "Z at the end",
            _pose("z last"),
            "You multiply inv(X_first) X_second inv(Z). Equation 9.3 has inv(Z) in front: what is, seen from where z leads.",
        ),
        Mistake(
            "turned by plus z",
            _pose("z turn"),
            "inv(Z) turns by minus z's angle; yours turns by plus.",
        ),
        Mistake(
            "z turned first",
            _pose("z rotated late"),
            "z's x and y are in the first pose's frame: subtract them before you turn by z's angle, not after.",
        ),
        Mistake(
            "turned the wrong way",
            _pose("turn"),
            "The first change of frame turns the wrong way: into the first pose's frame by minus its heading, as in exercise 9.1.",
        ),
        Mistake(
            "difference",
            _pose("difference"),
            "You subtract x and y as they stand. z is measured in the first pose's frame: first bring the second pose there.",
        ),
        Mistake("plus z", _pose("plus z"), "The angle of z has to be taken away: second - first - z."),
        Mistake(
            "angle without z",
            _pose("no turn"),
            "The third number lacks z: how much the robot turned minus what was measured of that.",
        ),
        Mistake(
            "sign",
            _pose("sign"),
            "Your sign is opposite: equation 9.4 is what is, seen from what was measured.",
        ),
        Mistake(
            "order",
            _pose("order"),
            "First and second pose are exchanged: z is where the second is, seen from the first.",
        ),
        Mistake(
            "all wrapped",
            _pose("wrapped all"),
            "You wrap all three numbers. Only the third is an angle; x and y are metres.",
        ),
        Mistake("one edge only", _pose("one"), ONE_ONLY),
        Mistake("three edges for one", _pose("three"), THREE_EDGES),
        Mistake("squeezed", _pose("squeezed"), SQUEEZED),
        Mistake("a list of no rows", _pose("loop"), NO_EDGE),
        Mistake("a list", _pose("list"), A_LIST),
        Mistake("columns", _pose("columns"), BY_COLUMNS),
    ],
    alternatives={
        "matrices": _pose_matrices,
        "complex numbers": _pose_complex,
        "where z leads": _pose_goal,
    },
)

POSE_RESIDUAL_JACOBIANS = Exercise(
    name="pose_residual_jacobians",
    points=3,
    stars=2,
    public=_pose_public,
    hidden=_pose_hidden,
    comparison=Close(
        rtol=1e-6, atol=1e-7, names=("the Jacobian by the first pose", "the Jacobian by the second pose")
    ),
    hints=(
        "Both turns together are one by theta + z's angle. With it, x and y are as in exercise 9.2; the headings add a third row.",
        "By the second pose: the rotation, and a 1. By the first: minus the rotation, a column by theta as in exercise 9.2, and a -1. z's x and y are in none of them.",
    ),
    mistakes=[
        Mistake(
            "z's angle left out",
            _pose_slopes("no z"),
            "You turn by the first pose's heading only. The residual is in z's frame: the angle is theta plus that of z.",
        ),
        Mistake(
            "only z's angle",
            _pose_slopes("only z"),
            "You turn by z's angle only. From the field's frame it is theta plus that of z.",
        ),
        Mistake(
            "minus z's angle",
            _pose_slopes("minus z"),
            "The two turns add up: theta plus z's angle, not minus.",
        ),
        Mistake(
            "sign",
            _pose_slopes("sign"),
            "All signs are opposite. Move the second pose a little ahead: its x, seen from anywhere behind, grows.",
        ),
        Mistake(
            "theta forgotten",
            _pose_slopes("theta 0"),
            "The column by theta of the first pose has only its -1. When the first pose turns, the second moves in its view.",
        ),
        Mistake(
            "sign of theta",
            _pose_slopes("theta sign"),
            "The column by theta of the first pose has the opposite sign in its first two rows.",
        ),
        Mistake(
            "theta from the residual",
            _pose_slopes("less z"),
            "In the column by theta you use the residual's x and y. z does not turn with the first pose: only the way to the second pose does.",
        ),
        Mistake(
            "theta less z as it stands",
            _pose_slopes("less z as it stands"),
            "In the column by theta you take z's x and y away. They do not turn with the first pose: the column has only the way to the second.",
        ),
        Mistake(
            "plus 1",
            _pose_slopes("plus 1"),
            "The angle falls when the first pose turns left: its slope is -1, not 1.",
        ),
        Mistake(
            "angle by theta forgotten",
            _pose_slopes("no -1"),
            "The third row of the Jacobian by the first pose is not all 0: the angle changes with theta.",
        ),
        Mistake(
            "theta of the second",
            _pose_slopes("second too"),
            "The second pose's place does not change when it turns: its column by theta has only the 1 of the angle.",
        ),
        Mistake(
            "turned the wrong way",
            _pose_slopes("turn"),
            "The sines have the wrong signs: the rotation leads from the field's frame into that of z.",
        ),
        Mistake(
            "order",
            _pose_slopes("swapped"),
            "The Jacobian by the first pose comes first, then the one by the second pose.",
        ),
        Mistake(
            "transposed",
            _pose_slopes("transposed"),
            "The two matrices are transposed: rows belong to the residual's three numbers, columns to what it is derived by.",
        ),
        Mistake(
            "one matrix", _pose_slopes("one matrix"), "Return two matrices of (3, 3), not one of (3, 6)."
        ),
        Mistake(
            "edges last",
            _pose_slopes("last"),
            "For one edge this is right. For E edges the shape is (E, 3, 3), edges first, as matrices(...) makes it.",
        ),
    ],
    alternatives={
        "central differences": _each(_differences(_pose())),
        "edge by edge": _each(_pose_slopes_one),
        "products": _pose_slopes_products,
    },
)


# --- 9.5 linearize ---


def _assembled(change: str = "") -> Callable[..., Any]:
    def function(graph: Graph, states: Any) -> Any:
        poses, landmarks = graph.split(states)
        H, b = np.zeros((graph.size, graph.size)), np.zeros(graph.size)
        groups = [
            (graph.pose_edges, poses, _pose(), _pose_slopes()),
            (graph.landmark_edges, landmarks, _landmark(), _landmark_slopes()),
        ]
        if change == "poses only":
            groups = groups[:1]
        for edges, ends, residual, slopes in groups:
            b = np.zeros(graph.size) if change == "b of the last kind" else b
            for k, places in enumerate(edges.places):
                pair = poses[edges.first[k]], ends[edges.second[k]], edges.z[k]
                e, J, omega = residual(*pair), np.hstack(slopes(*pair)), edges.information[k]
                if change == "covariance":
                    omega = np.linalg.inv(omega)
                if change == "no weights":
                    omega = np.eye(len(e))
                if change == "diagonal":
                    omega = np.diag(np.diag(omega))
                if change == "root":
                    omega = np.linalg.cholesky(omega)
                if change == "swapped":
                    J = np.hstack([J[:, 3:], J[:, :3]]) if J.shape[1] == 6 else J
                share, part = J.T @ omega @ J, J.T @ omega @ e
                if change == "b unweighted":
                    part = J.T @ e
                if change == "no mixed":
                    share[:3, 3:], share[3:, :3] = 0, 0
                if change == "upper":
                    share[3:, :3] = 0
                if change == "mixed sign":
                    share[:3, 3:], share[3:, :3] = -share[:3, 3:], -share[3:, :3]
                if change == "assigned":
                    H[np.ix_(places, places)], b[places] = share, part
                    continue
                H[np.ix_(places, places)] += share
                if change == "last of b":
                    b[places] = part
                else:
                    b[places] += part
        if change == "sign":
            b = -b
        if change == "twice":
            H, b = 2 * H, 2 * b
        if change == "fixed":
            H, b = H[3:, 3:], b[3:]
        if change == "held":
            H[:3, :3] += np.eye(3)
        if change == "dense":
            return H, b
        if change == "column":
            return scipy.sparse.csc_array(H), b[:, None]
        if change == "b first":
            return b, scipy.sparse.csc_array(H)
        return scipy.sparse.csc_array(H), b

    return function


def _lost_repeats(graph: Graph, states: Any) -> Any:
    """NumPy's += with repeated places, which adds only once."""
    poses, landmarks = graph.split(states)
    b = np.zeros(graph.size)
    for edges, ends, residual, slopes in (
        (graph.pose_edges, poses, _pose(), _pose_slopes()),
        (graph.landmark_edges, landmarks, _landmark(), _landmark_slopes()),
    ):
        pair = poses[edges.first], ends[edges.second], edges.z
        J = np.concatenate(slopes(*pair), axis=-1)
        b[edges.places] += np.einsum("kji,kjl,kl->ki", J, edges.information, residual(*pair))
    return _assembled()(graph, states)[0], b


def _whole_jacobian(graph: Graph, states: Any) -> Any:
    """One tall Jacobian, whitened, and its square."""
    poses, landmarks = graph.split(states)
    tall, right = [], []
    for edges, ends, residual, slopes in (
        (graph.pose_edges, poses, _pose(), _pose_slopes()),
        (graph.landmark_edges, landmarks, _landmark(), _landmark_slopes()),
    ):
        for k, places in enumerate(edges.places):
            pair = poses[edges.first[k]], ends[edges.second[k]], edges.z[k]
            root = np.linalg.cholesky(edges.information[k]).T
            rows = np.zeros((len(root), graph.size))
            rows[:, places] = root @ np.hstack(slopes(*pair))
            tall.append(scipy.sparse.csr_array(rows))
            right.append(root @ residual(*pair))
    J = scipy.sparse.vstack(tall)
    return J.T @ J, J.T @ np.concatenate(right)


def _einsum(graph: Graph, states: Any) -> Any:
    """Sums over edges by np.add.at."""
    poses, landmarks = graph.split(states)
    H, b = np.zeros((graph.size, graph.size)), np.zeros(graph.size)
    for edges, ends, residual, slopes in (
        (graph.pose_edges, poses, _pose(), _pose_slopes()),
        (graph.landmark_edges, landmarks, _landmark(), _landmark_slopes()),
    ):
        pair = poses[edges.first], ends[edges.second], edges.z
        J = np.concatenate(slopes(*pair), axis=-1)
        np.add.at(b, edges.places, np.einsum("kji,kjl,kl->ki", J, edges.information, residual(*pair)))
        shares = np.einsum("kji,kjl,klm->kim", J, edges.information, J)
        np.add.at(H, (edges.places[:, :, None], edges.places[:, None, :]), shares)
    return scipy.sparse.csr_array(H), b


def _small_graph(rng: np.random.Generator, poses: int = 6, landmarks: int = 3) -> tuple[Graph, Array]:
    """A graph with full information matrices, edges in any order, and states that do not satisfy it."""
    pairs = [(k, k + 1) for k in range(poses - 1)] + [(poses - 1, 0), (3, 1)]
    sights = (
        [(int(rng.integers(poses)), poses + k % landmarks) for k in range(2 * landmarks)] if landmarks else []
    )
    edges = np.array(pairs + sights)
    z = rng.normal(0.0, 1.0, (len(edges), 3))
    roots = rng.normal(0.0, 1.0, (len(edges), 3, 3)) + 2 * np.eye(3)
    information = roots @ roots.mT
    z[len(pairs) :, 2] = 0
    information[len(pairs) :, 2], information[len(pairs) :, :, 2] = 0, 0
    order = rng.permutation(len(edges))
    kinds = np.repeat([POSE, LANDMARK], [poses, landmarks])
    states = rng.normal(0.0, 2.0, 3 * poses + 2 * landmarks)
    return Graph(edges[order], z[order], information[order], kinds), states


def _two(rng: np.random.Generator) -> tuple[Graph, Array]:
    graph = Graph([[0, 1]], [[1.0, 0.0, 0.5]], [np.diag([4.0, 9.0, 16.0])], [POSE, POSE])
    return graph, rng.normal(0.0, 1.0, 6)


def _linearize_public() -> list[Case]:
    rng = np.random.default_rng(95)
    return [
        Case(_two(rng), "two poses and one edge"),
        Case(_small_graph(rng, 5, 0), "five poses, with two closures"),
        Case(_small_graph(rng), "poses and landmarks"),
    ]


def _linearize_hidden(rng: np.random.Generator) -> list[Case]:
    drive = field_drive(int(rng.integers(1000)), 12)
    return [
        Case(_two(rng)),
        *(Case(_small_graph(rng, poses, marks)) for poses, marks in ((4, 0), (5, 2), (9, 4))),
        Case((drive.graph, drive.odometry)),
    ]


RESIDUALS = ["pose_residual", "landmark_residual"]
SLOPES = ["pose_residual_jacobians", "landmark_residual_jacobians"]

LINEARIZE = Exercise(
    name="linearize",
    points=4,
    stars=3,
    public=_linearize_public,
    hidden=_linearize_hidden,
    comparison=Close(rtol=1e-6, atol=1e-6, names=("your H", "your b")),
    uses=[*RESIDUALS, *SLOPES],
    hints=(
        "For each kind of edges: residuals e, the Jacobians side by side as J, then Jᵀ Omega J and Jᵀ Omega e for all edges at once with @. What is left is to "
        "add them up at their places.",
        "J.mT @ edges.information is Jᵀ Omega of all edges; times J it is their blocks, and graph.add_blocks puts those together. For b: residuals as columns, "
        "[:, :, None], and np.bincount over edges.places.",
    ),
    mistakes=[
        Mistake(
            "sign of b",
            _assembled("sign"),
            "H is right, and b has the opposite sign: b = Jᵀ Omega e. The minus stands in the equation H delta = -b.",
        ),
        Mistake(
            "covariance for information",
            _assembled("covariance"),
            "You use the inverse of the information, the covariance: then the worst measurements weigh most.",
        ),
        Mistake(
            "no weights",
            _assembled("no weights"),
            "That is J'J and J'e: every measurement weighs the same. Omega is missing between them.",
        ),
        Mistake(
            "b without weights",
            _assembled("b unweighted"),
            "H is right. In b the information is missing: b = Jᵀ Omega e.",
        ),
        Mistake(
            "a root of the information",
            _assembled("root"),
            "You use a root of the information where the matrix itself belongs: Jᵀ Omega J has it once, whole.",
        ),
        Mistake(
            "Jacobians exchanged",
            _assembled("swapped"),
            "The Jacobians by the first and the second pose are exchanged: that by the first belongs to the places of the first.",
        ),
        Mistake(
            "blocks off the diagonal left out",
            _assembled("no mixed"),
            "H has no blocks between the two ends of an edge: those are J_iᵀ Omega J_j and its transpose, the link itself.",
        ),
        Mistake(
            "one triangle",
            _assembled("upper"),
            "H must be symmetric: the block of (second, first) is missing. It is the transpose of that of (first, second).",
        ),
        Mistake(
            "sign off the diagonal",
            _assembled("mixed sign"),
            "The blocks between two ends have the wrong sign. The Jacobians bring their own signs: add Jᵀ Omega J as it comes.",
        ),
        Mistake(
            "assigned",
            _assembled("assigned"),
            "You assign where you should add: a pose has many edges, and only the last is left.",
        ),
        Mistake(
            "b assigned",
            _assembled("last of b"),
            "H is right. In b you assign where you should add: of each pose only the last edge is left.",
        ),
        Mistake(
            "b of the last kind",
            _assembled("b of the last kind"),
            "H is right. b has the edges to landmarks only: in the loop over both kinds it begins anew. Add each kind's share, b += ...",
        ),
        Mistake(
            "diagonal of the information",
            _assembled("diagonal"),
            "You use only the diagonal of the information. Where a residual's numbers are wrong together, the rest of it counts, too.",
        ),
        Mistake(
            "+= with repeated places",
            _lost_repeats,
            "H is right. b[places] += shares adds only once where a place stands in `places` many times: NumPy's known trap. Use np.bincount or np.add.at.",
        ),
        Mistake(
            "landmarks left out",
            _assembled("poses only"),
            "The edges to landmarks are missing: graph.landmark_edges.",
        ),
        Mistake(
            "twice",
            _assembled("twice"),
            "Both are twice as large: the 2 of the derivative cancels in H delta = -b and is left out of both.",
        ),
        Mistake(
            "first pose removed",
            _assembled("fixed"),
            "You removed the first pose's rows. Here H and b have all of them; gauss_newton is where it is held.",
        ),
        Mistake(
            "first pose held",
            _assembled("held"),
            "You added something to the first pose's block. linearize tells what the edges say, and nothing else; gauss_newton holds the pose.",
        ),
        Mistake("b first", _assembled("b first"), "Return H first, then b."),
        Mistake("b as a column", _assembled("column"), "b has to be flat, (n,): yours is a column (n, 1)."),
    ],
    alternatives={
        "edge by edge": _assembled(),
        "one tall Jacobian": _whole_jacobian,
        "np.add.at": _einsum,
    },
)


# --- 9.6 gauss_newton ---


def _squares(graph: Graph, states: Any) -> float:
    return float(graph.squared_errors(states, _pose(), _landmark()).sum())


def _system(graph: Graph, states: Any) -> tuple[scipy.sparse.csc_array, Array]:
    """H and b, all edges of a kind at once."""
    poses, landmarks = graph.split(states)
    H, b = scipy.sparse.csc_array((graph.size, graph.size)), np.zeros(graph.size)
    for edges, ends, residual, slopes in (
        (graph.pose_edges, poses, _pose(), _pose_slopes()),
        (graph.landmark_edges, landmarks, _landmark(), _landmark_slopes()),
    ):
        pair = poses[edges.first], ends[edges.second], edges.z
        J, wide = np.concatenate(slopes(*pair), axis=-1), edges.places.shape[1]
        at = np.repeat(edges.places, wide, axis=1).ravel(), np.tile(edges.places, wide).ravel()
        entries = (J.mT @ edges.information @ J).ravel()
        H = H + scipy.sparse.coo_array((entries, at), H.shape).tocsc()
        shares = np.einsum("kji,kjl,kl->ki", J, edges.information, residual(*pair))
        b += np.bincount(edges.places.ravel(), shares.ravel(), graph.size)
    return H, b


def _newton(change: str = "") -> Callable[..., Any]:
    def function(graph: Graph, states: Any, iterations: int) -> Any:
        states = np.array(states, dtype=float)
        history = [_squares(graph, states)]
        H, b = _system(graph, states)
        order = graph.elimination_order
        if change == "one step":
            iterations = min(iterations, 1)
        if change == "one more":
            iterations += 1
        for _ in range(iterations):
            if change != "once":
                H, b = _system(graph, states) if change != "H once" else (H, _system(graph, states)[1])
            A = H.toarray()
            if change == "none":
                step = -np.linalg.lstsq(A, b, rcond=None)[0]
            elif change == "last":
                step = np.zeros(len(b))
                step[:-3] = -np.linalg.solve(A[:-3, :-3], b[:-3])
            elif change == "place only":
                step = np.zeros(len(b))
                keep = np.r_[2 : len(b)]
                step[keep] = -np.linalg.lstsq(A[np.ix_(keep, keep)], b[keep], rcond=None)[0]
            elif change == "damped":
                step = np.zeros(len(b))
                step[3:] = -np.linalg.solve(A[3:, 3:] + 1e-3 * np.diag(np.diag(A)[3:]), b[3:])
            elif change == "order":
                step = np.zeros(len(b))
                step[3:] = -np.linalg.solve(A[np.ix_(order, order)], b[order])
            else:
                step = np.zeros(len(b))
                step[3:] = -np.linalg.solve(A[3:, 3:], b[3:])
            if change == "early" and np.abs(step).max() < 1e-9:
                break
            if change == "never up" and _squares(graph, states + step) > history[-1]:
                step = 0 * step
            if change == "uphill":
                step = -step
            if change == "half":
                step = step / 2
            if change == "composed":
                for k in range(1, graph.poses):
                    c, s = np.cos(states[3 * k + 2]), np.sin(states[3 * k + 2])
                    dx, dy = step[3 * k : 3 * k + 2]
                    step[3 * k : 3 * k + 2] = c * dx - s * dy, s * dx + c * dy
            states = states + step
            history.append(_squares(graph, states))
        if change == "wrapped":
            states = np.where(np.arange(len(states)) < 0, states, wrap_angle(states))
        told = {
            "no first": history[1:],
            "no last": history[:-1],
            "last only": history[-1],
            "late": [*history[:1], *history[:-1]],
            "half chi2": [each / 2 for each in history],
            "root": np.sqrt(history),
        }.get(change, history)
        if change == "history first":
            return np.array(told), states
        if change == "states only":
            return states
        return states, np.array(told)

    return function


def _newton_unweighted(graph: Graph, states: Any, iterations: int) -> Any:
    found, _ = _newton()(graph, states, iterations)
    ones = dataclasses.replace(graph, information=np.sign(np.abs(graph.information)) * np.eye(3))
    return found, np.array([_squares(ones, _newton()(graph, states, n)[0]) for n in range(iterations + 1)])


def _newton_in_place(graph: Graph, states: Any, iterations: int) -> Any:
    found, history = _newton()(graph, states, iterations)
    states[:] = found
    return states, history


def _newton_anchored(graph: Graph, states: Any, iterations: int) -> Any:
    """The first pose held by an entry of its own."""
    states, history = np.array(states, dtype=float), []
    anchor = scipy.sparse.diags_array(np.where(np.arange(len(states)) < 3, 1.0, 0.0))
    for _ in range(iterations):
        history.append(_squares(graph, states))
        H, b = _system(graph, states)
        states = states - scipy.sparse.linalg.spsolve((H + anchor).tocsc(), b)
    return states, np.array([*history, _squares(graph, states)])


def _newton_dense(graph: Graph, states: Any, iterations: int) -> Any:
    """By QR of the whitened Jacobian, lists for the answer."""
    states, history = np.array(states, dtype=float), []
    for step in range(iterations + 1):
        history.append(_squares(graph, states))
        if step < iterations:
            H, b = _system(graph, states)
            L = np.linalg.cholesky(H.toarray()[3:, 3:])
            states[3:] -= np.linalg.solve(L.T, np.linalg.solve(L, b[3:]))
    return [states, history]


def _newton_wrapped(graph: Graph, states: Any, iterations: int) -> Any:
    """With headings brought into (-pi, pi] after each step."""
    states, history = np.array(states, dtype=float), []
    headings = np.arange(2, 3 * graph.poses, 3)
    history.append(_squares(graph, states))
    for _ in range(iterations):
        H, b = _system(graph, states)
        states[3:] = states[3:] + scipy.sparse.linalg.splu(H.tocsc()[3:, 3:]).solve(-b[3:])
        states[headings[1:]] = wrap_angle(states[headings[1:]])
        history.append(_squares(graph, states))
    return states, np.array(history)


def _turned(graph: Graph, states: Array) -> tuple[Graph, Array]:
    """The same states, begun at another place and heading: nothing measured changes."""
    poses, marks = (each.copy() for each in graph.split(states))
    turn = rotation_2d(2.5)
    poses[:, :2], marks = poses[:, :2] @ turn.T + (6.0, -4.5), marks @ turn.T + (6.0, -4.5)
    poses[:, 2] += 2.5
    return graph, np.concatenate([poses.ravel(), marks.ravel()])


def _newton_public() -> list[Case]:
    square, drive = loop(3, side=2), field_drive(2, 8)
    return [
        Case((square.graph, square.odometry, 1), "a small loop, one step"),
        Case((*_turned(square.graph, square.odometry), 2), "the same loop, begun elsewhere, two steps"),
        Case((square.graph, square.odometry, 0), "no step"),
        Case((_held_landmarks(drive), drive.odometry, 4), "landmarks, four steps"),
        Case((*_weak_drift(np.pi / 2), 3), "weak measurements, and a step that climbs"),
        Case((*_two_apart(), 3), "two poses that fit after one step"),
    ]


def _weak_drift(drift: float) -> tuple[Graph, Array]:
    """A loop whose first step makes chi2 larger; information so small that nothing can be added to H unseen."""
    world = drifting_loop(drift, 6)
    return dataclasses.replace(world.graph, information=1e-4 * world.graph.information), world.odometry


def _two_apart() -> tuple[Graph, Array]:
    graph = Graph([[0, 1]], [[1.0, 0.0, 0.0]], [np.eye(3)], [POSE, POSE])
    return graph, np.array([0.0, 0.0, 0.0, 5.0, 0.0, 0.0])


def _held_landmarks(drive: Any) -> Graph:
    """A field drive's graph with a weak sight of each landmark from the first pose, so that all are held."""
    graph, count = drive.graph, drive.graph.landmarks
    edges = np.column_stack([np.zeros(count, dtype=int), graph.poses + np.arange(count)])
    z = np.column_stack([graph.split(drive.truth)[1] - drive.truth[:2], np.zeros(count)])
    weak = np.broadcast_to(np.diag([1e-2, 1e-2, 0.0]), (count, 3, 3))
    return dataclasses.replace(
        graph,
        edges=np.concatenate([graph.edges, edges]),
        measurements=np.concatenate([graph.measurements, z]),
        information=np.concatenate([graph.information, weak]),
    )


def _newton_hidden(rng: np.random.Generator) -> list[Case]:
    walk = building(int(rng.integers(1000)), 60, size=(2, 2))
    square = loop(int(rng.integers(1000)), side=3)
    drive = field_drive(int(rng.integers(1000)), 14)
    return [
        Case((walk.graph, walk.odometry, 5)),
        Case((square.graph, disturbed(square, 0.3, 0.1, rng), 2)),
        Case((*_turned(square.graph, square.odometry), 3)),
        Case((_held_landmarks(drive), drive.odometry, 3)),
        Case((walk.graph, walk.odometry, 1)),
        Case((*_weak_drift(float(rng.uniform(1.4, 1.7))), 4)),
        Case((*_two_apart(), 4)),
    ]


GAUSS_NEWTON = Exercise(
    name="gauss_newton",
    points=4,
    stars=3,
    public=_newton_public,
    hidden=_newton_hidden,
    comparison=SolvedStates(),
    uses=["linearize", *RESIDUALS],
    in_place=True,
    hints=(
        "Copy the states. In each step linearise where you are now, leave out the first pose's three rows and columns, solve as in lesson 08's solve_sparse, and move. The history begins before the first step.",
        "The solution of H[3:, 3:] delta = b[3:] is what to take away from states[3:]. With free = graph.elimination_order the same stands between "
        "H[free][:, free], b[free] and states[free].",
    ),
    mistakes=[
        Mistake(
            "uphill",
            _newton("uphill"),
            "You go uphill: H delta = -b. Take the solution away, or give b a minus.",
        ),
        Mistake(
            "linearised once",
            _newton("once"),
            "You linearise once and solve the same system again and again. Each step needs H and b where it stands.",
        ),
        Mistake(
            "H once",
            _newton("H once"),
            "You compute H once, before the loop, and b anew. Both change with the states: linearize belongs into the loop.",
        ),
        Mistake(
            "order forgotten",
            _newton("order"),
            "The solution stands in the order in which you solved, and you add it in the order of the states. What was solved with b[free] belongs to states[free].",
        ),
        Mistake(
            "never uphill",
            _newton("never up"),
            "You refuse a step that makes chi2 larger. That is careful, and good in practice; here the plain step is wanted, also where it climbs: you will look at one that does.",
        ),
        Mistake(
            "stops early",
            _newton("early"),
            "You stop when nothing moves any more. Good in practice; here `iterations` steps are wanted, and so many numbers in the history.",
        ),
        Mistake(
            "chi2 too early",
            _newton("late"),
            "You note chi2 before each step moves anything: the first number stands there twice, and the last is missing. Append it after the step.",
        ),
        Mistake(
            "nothing held",
            _newton("none"),
            "Your first pose moves. H alone is singular: the whole map can be shifted and turned. Solve without the first pose's three rows and columns, and leave it where it is.",
        ),
        Mistake(
            "last pose held",
            _newton("last"),
            "You hold the last three numbers. The first pose is what has to stay: rows and columns 3 and on are solved for.",
        ),
        Mistake(
            "two of three held",
            _newton("place only"),
            "You hold two numbers of the first pose; it has three: x, y and the heading.",
        ),
        Mistake(
            "one step",
            _newton("one step"),
            "You make one step, whatever `iterations` says. Is there a return inside the loop?",
        ),
        Mistake(
            "one step more",
            _newton("one more"),
            "You make one step too many: the history has 1 + iterations numbers, the first before any step.",
        ),
        Mistake(
            "half steps",
            _newton("half"),
            "Your steps are half as long: plain Gauss-Newton takes the whole step.",
        ),
        Mistake(
            "damped",
            _newton("damped"),
            "You add something to H's diagonal. That is Levenberg and Marquardt's way, and a good one; here the plain step is wanted.",
        ),
        Mistake(
            "composed",
            _newton("composed"),
            "You turn the step by each pose's heading, as if it were a motion of the robot. Your Jacobians are by x, y and theta themselves, so the step is "
            "simply added to them.",
        ),
        Mistake(
            "everything wrapped",
            _newton("wrapped"),
            "You wrap all states into (-pi, pi], x and y too: those are metres.",
        ),
        Mistake(
            "history without its begin",
            _newton("no first"),
            "The history lacks the chi2 before the first step.",
        ),
        Mistake(
            "history without its end", _newton("no last"), "The history lacks the chi2 after the last step."
        ),
        Mistake(
            "last chi2 only",
            _newton("last only"),
            "The states are right. Of chi2 the whole history is wanted: before the first step and after each.",
        ),
        Mistake(
            "half chi2",
            _newton("half chi2"),
            "Your chi2 is half of it: here it is the sum of e' Omega e, without the 1/2 of some books.",
        ),
        Mistake("root of chi2", _newton("root"), "You take a root of chi2. It is the sum of squares itself."),
        Mistake(
            "chi2 without weights",
            _newton_unweighted,
            "The states are right. Your chi2 is a sum of squares without the information: e' Omega e.",
        ),
        Mistake("history first", _newton("history first"), "Return the states first, then the history."),
        Mistake(
            "no history", _newton("states only"), "Return two things: the states, and the history of chi2."
        ),
        Mistake(
            "in place",
            _newton_in_place,
            "You wrote into the states that you were given. Work on a copy: states = states.copy().",
        ),
    ],
    alternatives={
        "an anchor on the first pose": _newton_anchored,
        "Cholesky": _newton_dense,
        "headings wrapped": _newton_wrapped,
    },
)


# --- 9.7 marginal_covariances ---


def _information(graph: Graph, states: Array) -> scipy.sparse.csc_array:
    """H without the first pose."""
    return scipy.sparse.csc_array(_system(graph, states)[0][3:, 3:])


def _blocks(change: str = "") -> Callable[..., Any]:
    def function(H: Any, indices: Any) -> Any:
        if change == "dense":
            P = np.linalg.inv(H.toarray())
            return [P[np.ix_(each, each)] for each in indices]
        if change in ("conditional", "information"):
            own = [H.tocsr()[each][:, each].toarray() for each in indices]
            return [np.linalg.inv(each) for each in own] if change == "conditional" else own
        if change == "first rows":
            return _blocks_solved(H, [np.arange(len(each)) for each in indices])
        if change == "whole columns":
            units = [np.eye(1, H.shape[0], row)[0] for each in indices for row in each]
            columns = scipy.sparse.linalg.splu(H.tocsc()).solve(np.array(units).T)
            return np.split(columns, np.cumsum([len(each) for each in indices])[:-1], axis=1)
        if change == "sorted":
            return _blocks_solved(H, [np.sort(each) for each in indices])
        if change == "stacked":
            return _blocks_solved(H, [np.concatenate(indices)])[0]
        blocks = _blocks_solved(H, indices)
        if change == "marginal information":
            return [np.linalg.inv(each) for each in blocks]
        if change == "diagonal":
            return [np.diag(each) for each in blocks]
        if change == "diagonal matrix":
            return [np.diag(np.diag(each)) for each in blocks]
        if change == "deviations":
            return [np.sqrt(np.abs(each)) for each in blocks]
        return blocks[0] if change == "first" else blocks

    return function


def _blocks_solved(H: Any, indices: Sequence[Any]) -> Any:
    factor = scipy.sparse.linalg.splu(H.tocsc())
    every = np.unique(np.concatenate(indices))
    unit = np.zeros((H.shape[0], len(every)))
    unit[every, np.arange(len(every))] = 1
    columns = factor.solve(unit)
    return [columns[np.ix_(each, np.searchsorted(every, each))] for each in indices]


def _blocks_eliminated(H: Any, indices: Sequence[Any]) -> Any:
    """Lesson 08's marginalisation, and the inverse of what it leaves."""
    found = []
    H = H.tocsr()
    for each in indices:
        gone = np.setdiff1d(np.arange(H.shape[0]), each)
        rows = H[gone]
        between = rows[:, each].toarray()
        share = scipy.sparse.linalg.splu(rows[:, gone].tocsc(), permc_spec="MMD_AT_PLUS_A").solve(between)
        found.append(np.linalg.inv(H[each][:, each].toarray() - between.T @ share))
    return found


def _blocks_one_by_one(H: Any, indices: Sequence[Any]) -> Any:
    solve = scipy.sparse.linalg.factorized(H.tocsc())
    units = [[np.where(np.arange(H.shape[0]) == row, 1.0, 0.0) for row in each] for each in indices]
    return [np.array([solve(unit)[each] for unit in rows]) for each, rows in zip(indices, units, strict=True)]


def _of_poses(numbers: Sequence[int]) -> list[Any]:
    """Rows of some poses in an H without the first."""
    return [3 * (number - 1) + np.arange(3) for number in numbers]


def _blocks_public() -> list[Case]:
    square, walk = loop(1, side=2), building(4, 500)
    drive = field_drive(3, 6)
    graph = _held_landmarks(drive)
    begin = 3 * graph.poses - 3
    return [
        Case(
            (scipy.sparse.csc_array([[2.0, -1.0], [-1.0, 1.0]]), [np.array([0]), np.array([1])]),
            "two variables",
        ),
        Case((_information(square.graph, square.truth), _of_poses([1, 4, 8])), "three poses of a loop"),
        Case(
            (
                _information(graph, drive.truth),
                [begin + np.array([0, 1]), begin + np.array([7, 6]), np.array([4])],
            ),
            "landmarks, one of them with y before x, and one y",
        ),
        Case((_information(walk.graph, walk.truth), _of_poses([250, 499])), "1,497 variables"),
    ]


def _blocks_hidden(rng: np.random.Generator) -> list[Case]:
    walk, square = (
        building(int(rng.integers(1000)), 3000, size=(12, 12)),
        loop(int(rng.integers(1000)), side=4),
    )
    some = np.sort(rng.choice(np.arange(1, 3000), 12, replace=False)).tolist()
    mixed = [rng.permutation(45)[:4], rng.permutation(45)[:2], np.array([44])]
    return [
        Case((_information(walk.graph, walk.truth), _of_poses(some))),
        Case((_information(square.graph, square.truth), mixed)),
        Case((_information(square.graph, square.truth).tocsr(), _of_poses([1, 5, 16]))),
    ]


MARGINAL_COVARIANCES = Exercise(
    name="marginal_covariances",
    points=4,
    stars=3,
    public=_blocks_public,
    hidden=_blocks_hidden,
    comparison=Close(rtol=1e-7, atol=1e-11),
    driver=BLOCKS,
    hints=(
        "Column k of the inverse is the x that solves H x = unit vector k. Which columns does a block need?",
        "Factor H once (splu). For the rows of a block, a tall array of unit vectors is solved at once; of the columns that come back take the block's rows.",
    ),
    mistakes=[
        Mistake(
            "conditional",
            _blocks("conditional"),
            "You invert the block of H. That is the covariance if all other variables were known exactly, and much too small. The block has to come from the inverse of the whole.",
        ),
        Mistake(
            "information",
            _blocks("information"),
            "Those are blocks of H, the information. Wanted are blocks of its inverse.",
        ),
        Mistake(
            "inverted once more",
            _blocks("marginal information"),
            "You invert the blocks of the inverse: that is what lesson 08's marginalize gives. The covariance is the block itself.",
        ),
        Mistake(
            "diagonal",
            _blocks("diagonal"),
            "You return the variances only. A block has the covariances, too: (k, k).",
        ),
        Mistake(
            "off the diagonal zero",
            _blocks("diagonal matrix"),
            "Off the diagonal your blocks are 0: an ellipse drawn from them cannot lean.",
        ),
        Mistake(
            "deviations", _blocks("deviations"), "You take roots. Covariances are squares, m^2 and rad^2."
        ),
        Mistake(
            "always the first rows",
            _blocks("first rows"),
            "You return the upper left corner of the inverse each time. The rows are those of the indices.",
        ),
        Mistake(
            "whole columns",
            _blocks("whole columns"),
            "Those are whole columns of the inverse. Of them, take the rows of the block.",
        ),
        Mistake(
            "sorted",
            _blocks("sorted"),
            "You sort the indices. Rows and columns of a block come in the order given.",
        ),
        Mistake(
            "one matrix",
            _blocks("stacked"),
            "You return one matrix for all. Wanted is a list: a block for each of the indices.",
        ),
        Mistake(
            "first only",
            _blocks("first"),
            "You return the first block only: is there a return inside the loop?",
        ),
        Mistake(
            "dense inverse",
            _blocks("dense"),
            "You make H dense. Of a map with 3,000 poses that is 650 MB. Keep H sparse: a few columns of its inverse are enough.",
        ),
    ],
    alternatives={
        "all columns at once": _blocks_solved,
        "eliminating the others": _blocks_eliminated,
        "row by row": _blocks_one_by_one,
    },
)


# --- 9.8 reweight ---


def _reweighted(change: str = "") -> Callable[..., Any]:
    def function(graph: Graph, states: Any, width: float) -> Any:
        squares = graph.squared_errors(states, _pose(), _landmark())
        weights = {
            "squared width": 1 / (1 + squares / width),
            "no width": 1 / (1 + squares),
            "inverse": 1 + squares / width**2,
            "root": 1 / np.sqrt(1 + squares / width**2),
            "square": 1 / (1 + squares / width**2) ** 2,
            "cut": np.where(squares > width**2, 0.0, 1.0),
            "huber": np.minimum(1, width / np.sqrt(np.maximum(squares, 1e-12))),
            "length": 1 / (1 + np.sqrt(squares) / width),
            "kernel": width**2 * np.log1p(squares / width**2),
            "kernel over q": np.log1p(squares / width**2) / np.maximum(squares / width**2, 1e-300),
        }.get(change, 1 / (1 + squares / width**2))
        if change == "closures":
            weights = np.where(graph.edges[:, 1] == graph.edges[:, 0] + 1, 1.0, weights)
        if change == "sum":
            weights = np.full(len(squares), 1 / (1 + squares.sum() / width**2))
        if change == "weights":
            return weights
        if change == "measurements":
            return dataclasses.replace(graph, measurements=graph.measurements * weights[:, None])
        if change == "assigned":
            graph.information = graph.information * weights[:, None, None]  # type: ignore[misc]
        if change == "in place":
            graph.information[:] *= weights[:, None, None]
            return graph
        if change == "replaced":
            return dataclasses.replace(
                graph,
                information=np.broadcast_to(np.eye(3), graph.information.shape) * weights[:, None, None],
            )
        return dataclasses.replace(graph, information=graph.information * weights[:, None, None])

    return function


def _reweighted_euclidean(graph: Graph, states: Any, width: float) -> Any:
    ones = dataclasses.replace(graph, information=np.sign(np.abs(graph.information)) * np.eye(3))
    squares = ones.squared_errors(states, _pose(), _landmark())
    return dataclasses.replace(graph, information=graph.information / (1 + squares / width**2)[:, None, None])


def _reweighted_by_hand(graph: Graph, states: Any, width: float) -> Any:
    """Edge by edge, into a new graph."""
    poses, landmarks = graph.split(states)
    information = []
    for (i, j), z, omega in zip(graph.edges, graph.measurements, graph.information, strict=True):
        if j < graph.poses:
            e = _pose()(poses[i], poses[j], z)
        else:
            e = np.append(_landmark()(poses[i], landmarks[j - graph.poses], z[:2]), 0.0)
        information.append(omega * width**2 / (width**2 + e @ omega @ e))
    return Graph(graph.edges, graph.measurements, np.array(information), graph.kinds, graph.ids)


def _reweighted_einsum(graph: Graph, states: Any, width: float) -> Any:
    squares = graph.squared_errors(states, _pose(), _landmark())
    return dataclasses.replace(
        graph, information=np.einsum("k,kij->kij", width**2 / (squares + width**2), graph.information)
    )


def _reweighted_float32(graph: Graph, states: Any, width: float) -> Any:
    weights = np.float32(1) / (
        1 + np.square(np.sqrt(graph.squared_errors(states, _pose(), _landmark())) / width)
    )
    return dataclasses.replace(graph, information=(graph.information.T * weights.astype(np.float32)).T)


def _reweight_public() -> list[Case]:
    rng = np.random.default_rng(98)
    square = with_false_closures(building(2, 40, size=(2, 2)), 0)
    return [
        Case((*_two(rng), 2.0), "one edge"),
        Case((square.graph, square.truth, 3.0), "the truth: hardly anything changes"),
        Case((*_small_graph(rng), 5.0), "poses and landmarks that fit badly"),
    ]


def _reweight_hidden(rng: np.random.Generator) -> list[Case]:
    walk = with_false_closures(building(int(rng.integers(1000)), 80), 3, 1)
    return [
        Case((*_small_graph(rng), 0.5)),
        Case((*_small_graph(rng, 5, 2), 8.0)),
        Case((walk.graph, walk.odometry, 3.0)),
        Case((walk.graph, walk.truth, float(rng.uniform(1, 4)))),
    ]


REWEIGHT = Exercise(
    name="reweight",
    points=2,
    stars=3,
    public=_reweight_public,
    hidden=_reweight_hidden,
    comparison=Close(rtol=1e-5, atol=1e-9),
    uses=RESIDUALS,
    in_place=True,
    hints=(
        "graph.squared_errors gives chi2 of every edge, (E,). The weight of each is equation 9.6; the information of each edge is multiplied by it.",
        "weights[:, None, None] multiplies (E, 3, 3) edge by edge; dataclasses.replace(graph, information=...) is the same graph with another information.",
    ),
    mistakes=[
        Mistake(
            "width not squared",
            _reweighted("squared width"),
            "chi2 is a square, so the width has to be squared, too.",
        ),
        Mistake(
            "the kernel itself",
            _reweighted("kernel"),
            "You multiply by the kernel, c^2 ln(1 + q / c^2). The weight is its slope rho'(q), equation 9.6.",
        ),
        Mistake(
            "the kernel over q",
            _reweighted("kernel over q"),
            "You divide the kernel by q: then chi2 itself is right, and not its slope. The weight is rho'(q), equation 9.6.",
        ),
        Mistake(
            "in place",
            _reweighted("in place"),
            "You write into the graph that you were given: the next step would weigh what is weighed already. graph.information * weights is a new array, "
            "and replace(graph, information=...) a new graph.",
        ),
        Mistake(
            "assigned",
            _reweighted("assigned"),
            "A graph cannot be changed by assigning to it. replace(graph, information=...) is a copy of it with another information.",
        ),
        Mistake("width left out", _reweighted("no width"), "The width is missing: chi2 / width^2."),
        Mistake(
            "the other way round",
            _reweighted("inverse"),
            "Your weights grow with the error: the worst edges pull hardest. It is 1 over that.",
        ),
        Mistake("root", _reweighted("root"), "Your weight is the root of the one wanted."),
        Mistake(
            "square",
            _reweighted("square"),
            "Your weight is squared: that is Geman and McClure's kernel, which is known to work, too. Here Cauchy's is wanted, equation 9.6.",
        ),
        Mistake(
            "cut off",
            _reweighted("cut"),
            "You cut edges off at the width. The kernel fades them out: an edge that fits again later must be able to come back.",
        ),
        Mistake(
            "Huber",
            _reweighted("huber"),
            "That is Huber's kernel. A false closure still pulls with a constant force there; wanted is Cauchy's, equation 9.6.",
        ),
        Mistake(
            "the error, not its square",
            _reweighted("length"),
            "You use the root of chi2 over the width; wanted is chi2 over the squared width.",
        ),
        Mistake(
            "closures only",
            _reweighted("closures"),
            "You leave the odometry's edges as they are. That is a sound idea; here all edges are weighted alike.",
        ),
        Mistake(
            "one weight for all",
            _reweighted("sum"),
            "All edges have the same weight in yours: it is computed from the sum of all squares, and each edge has its own.",
        ),
        Mistake(
            "without information",
            _reweighted_euclidean,
            "You take the length of the residual without its information: chi2 is e' Omega e.",
        ),
        Mistake(
            "weights only",
            _reweighted("weights"),
            "Those are the weights. Return a graph with them in its information.",
        ),
        Mistake(
            "measurements weighted",
            _reweighted("measurements"),
            "You multiply the measurements: then a metre becomes half a metre. The weight belongs into the information.",
        ),
        Mistake(
            "information lost",
            _reweighted("replaced"),
            "You replace the information by the weights. It is multiplied: what was exact before stays more exact than the others.",
        ),
    ],
    alternatives={
        "edge by edge": _reweighted_by_hand,
        "einsum": _reweighted_einsum,
        "roots": _reweighted_float32,
    },
)


PLAN = LessonPlan(
    exercises=[
        LANDMARK_RESIDUAL,
        LANDMARK_RESIDUAL_JACOBIANS,
        POSE_RESIDUAL,
        POSE_RESIDUAL_JACOBIANS,
        LINEARIZE,
        GAUSS_NEWTON,
        MARGINAL_COVARIANCES,
        REWEIGHT,
    ],
    questions=[
        Question(
            "which_frame",
            "A robot is lifted and put down elsewhere, with its whole map, and turned. Which of its residuals change?",
            {
                "All of them: their poses have changed.": "The poses have. A residual sees only one pose from another, and that is as before.",
                "Those of the first pose, which is fixed.": "Its edges, too, only say where others are, seen from it.",
                "None.": "Every residual is written in a frame that moves along. So nothing that was measured tells where the map is, and something must hold it.",
            },
            "None.",
        ),
        Question(
            "conditional",
            "You invert the 3 by 3 block of H that belongs to a pose. What do you get?",
            {
                "The covariance of that pose.": "That is a block of the inverse, which is another matrix than the inverse of a block.",
                "The covariance it would have if all other poses were known exactly.": "Right: it counts the direct links only. In the building its standard deviations are up to 27 times too small.",
                "Nothing that has a meaning.": "It has one, and is useful: all other poses known, this is what is left. It is not what you may say about the map.",
            },
            "The covariance it would have if all other poses were known exactly.",
        ),
    ],
    written=[
        Written(
            "explain_headings",
            points=2,
            question="Why does a wrong heading in the first guess spoil Gauss-Newton, and a wrong position does not?",
            rubric="1 point: with the headings given, the residuals are linear in the positions (x and y are only subtracted and turned by fixed angles), so one step puts "
            "positions right from anywhere. 1 point: headings stand in sines and cosines; a tangent is a good stand-in for an arc only over a small angle, so from far away steps "
            "point to a wrong place and can end in another minimum (or none).",
        )
    ],
)
