"""Drives whose truth is known: through a building's corridors, round one loop, and over the half field."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, wrap_angle
from nao_course.graphs import LANDMARK, POSE, Graph
from nao_course.sim import Field

ODOMETRY_SIGMA = (0.05, 0.03, np.radians(1.0))  # m along and across the metre that was driven, rad
CLOSURE_SIGMA = (0.05, 0.05, np.radians(1.0))  # of a pose that is recognised
SIGHT_SIGMA = 0.05  # m, of a landmark
CORRIDOR = 6  # m between two junctions
NEAR = 1.5  # m within which an old pose is recognised
APART = 20  # poses at least between a pose and the old one that it is matched with

_HEADINGS = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])


@dataclass(frozen=True, eq=False)
class World:
    """A graph, the states that are true, and those that odometry alone gives.

    Parameters
    ----------
    graph : Graph
        What was measured.
    truth, odometry : ndarray, shape (3 P + 2 L,)
        States: x, y, theta of each pose, then x, y of each landmark; m, rad. The first pose is the same in both.
    """

    graph: Graph
    truth: FloatArray
    odometry: FloatArray

    def closures(self) -> npt.NDArray[np.bool_]:
        """Which edges lead from a pose to one that does not follow it: (E,)."""
        first, second = self.graph.edges.T
        return (self.graph.kinds[second] == POSE) & (second != first + 1)


def between(first: FloatArray, second: FloatArray) -> FloatArray:
    """Poses (E, 3) in the frames of others (E, 3): (E, 3)."""
    c, s = np.cos(first[:, 2]), np.sin(first[:, 2])
    dx, dy = (second - first)[:, :2].T
    return np.stack([c * dx + s * dy, -s * dx + c * dy, wrap_angle(second[:, 2] - first[:, 2])], axis=1)


def moved(poses: FloatArray, motions: FloatArray) -> FloatArray:
    """Poses (E, 3) after motions (E, 3) in their own frames: (E, 3); the inverse of `between`."""
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    turned = np.einsum("ijk,kj->ki", np.array([[c, -s], [s, c]]), motions[:, :2])
    return np.column_stack([poses[:, :2] + turned, wrap_angle(poses[:, 2] + motions[:, 2])])


def chained(start: FloatArray, steps: FloatArray) -> FloatArray:
    """Add up steps (N, 3), each in the frame of the pose before it, from a pose (3,): (N + 1, 3)."""
    headings = start[2] + np.concatenate([[0.0], np.cumsum(steps[:, 2])])
    c, s = np.cos(headings[:-1]), np.sin(headings[:-1])
    moves = np.stack([c * steps[:, 0] - s * steps[:, 1], s * steps[:, 0] + c * steps[:, 1]], axis=1)
    places = start[:2] + np.concatenate([[[0.0, 0.0]], np.cumsum(moves, axis=0)])
    return np.column_stack([places, wrap_angle(headings)])


def building(seed: int = 1, poses: int = 400, noise: float = 1.0, size: tuple[int, int] = (5, 4)) -> World:
    """Drive through a building's corridors, a pose a metre, and recognise places that were passed before.

    Parameters
    ----------
    seed : int
        Of the way and of the noise.
    poses : int
        How many.
    noise : float
        Factor on all standard deviations; 0 measures the truth.
    size : (int, int)
        Junctions along x and y, six metres apart.

    Returns
    -------
    World
    """
    rng = np.random.default_rng([seed, 9])
    truth = _walk(rng, poses, size)
    pairs = _recognised(truth, rng)
    return _measured(truth, pairs, np.empty((0, 2)), [], noise, rng)


def loop(seed: int = 1, side: int = 6, noise: float = 1.0, closed: bool = True) -> World:
    """Drive once round a square, a pose a metre, and recognise the first pose at the end."""
    rng = np.random.default_rng([seed, 91])
    corners = np.repeat(np.arange(4), side)
    places = np.concatenate([[[0, 0]], np.cumsum(_HEADINGS[corners], axis=0)])
    headings = np.concatenate([corners, [3]]) * np.pi / 2
    truth = np.column_stack([places, wrap_angle(headings)]).astype(float)
    return _measured(truth, [(len(truth) - 1, 0)] if closed else [], np.empty((0, 2)), [], noise, rng)


def drifting_loop(drift: float, side: int = 10) -> World:
    """Drive once round a square with odometry that drifts evenly, and no other error.

    Parameters
    ----------
    drift : float
        By how much the odometry's heading is off at the end, rad.
    side : int
        Metres, and poses, a side.

    Returns
    -------
    World
        Its last edge closes the loop, exactly.
    """
    exact = loop(1, side, noise=0.0)
    steps = exact.graph.poses - 1
    z = exact.graph.measurements.copy()
    z[:steps, 2] += drift / steps
    path = chained(exact.truth[:3], z[:steps])
    return World(replace(exact.graph, measurements=z), exact.truth, path.ravel())


def field_drive(seed: int = 1, stops: int = 25, noise: float = 1.0) -> World:
    """Drive a circle over the half field, and see at each stop what lies ahead, at most 2.5 m away.

    Parameters
    ----------
    seed : int
        Of the noise.
    stops : int
        Poses; the last stands where the first stood.
    noise : float
        As in `building`.

    Returns
    -------
    World
    """
    rng = np.random.default_rng([seed, 92])
    marks = np.array([(each.x, each.y) for each in Field(2012, half=True).landmarks if each.kind != "cross"])
    angles = np.linspace(-np.pi / 2, 1.5 * np.pi, stops)
    places = [1.5, 0.0] + 0.9 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    truth = np.column_stack([places, wrap_angle(angles + np.pi / 2)])
    sights = [
        (pose, number)
        for pose, at in enumerate(truth)
        for number, mark in enumerate(marks)
        if _in_view(at, mark)
    ]
    return _measured(truth, [], marks, sights, noise, rng)


def _in_view(pose: FloatArray, mark: FloatArray) -> bool:
    away = mark - pose[:2]
    return bool(np.hypot(*away) < 2.5 and abs(wrap_angle(np.arctan2(away[1], away[0]) - pose[2])) < np.pi / 3)


def with_false_closures(world: World, count: int, seed: int = 0) -> World:
    """Add closures between places that only look alike: same corridor, another one in truth.

    Parameters
    ----------
    world : World
        With poses.
    count : int
        How many false ones.
    seed : int
        Of which poses are taken for each other.

    Returns
    -------
    World
        Its last `count` edges are false.
    """
    rng = np.random.default_rng([seed, 93])
    graph, (poses, _) = world.graph, world.graph.split(world.truth)
    pairs: list[tuple[int, int]] = []
    while len(pairs) < count:
        late, early = sorted(rng.choice(graph.poses, 2, replace=False).tolist(), reverse=True)
        if late - early > APART and np.hypot(*(poses[late] - poses[early])[:2]) > 2 * CORRIDOR:
            pairs.append((late, early))
    z = np.column_stack([rng.normal(0.0, 0.5, (count, 2)), rng.normal(0.0, 0.1, count)])
    information = np.broadcast_to(np.diag(1 / np.square(CLOSURE_SIGMA)), (count, 3, 3))
    return replace(
        world,
        graph=replace(
            graph,
            edges=np.concatenate([graph.edges, np.array(pairs, dtype=int).reshape(-1, 2)]),
            measurements=np.concatenate([graph.measurements, z]),
            information=np.concatenate([graph.information, information]),
        ),
    )


def disturbed(world: World, position: float, heading: float, rng: np.random.Generator) -> FloatArray:
    """The truth with each pose but the first, and each landmark, moved at random (m) and each pose turned (rad)."""
    poses, marks = (each.copy() for each in world.graph.split(world.truth))
    poses[1:, :2] += position * rng.standard_normal((len(poses) - 1, 2))
    poses[1:, 2] += heading * rng.standard_normal(len(poses) - 1)
    marks += position * rng.standard_normal(marks.shape)
    return np.concatenate([poses.ravel(), marks.ravel()])


def position_error(world: World, states: npt.ArrayLike) -> float:
    """Root mean square distance (m) of all poses from the truth; the first pose is the truth's."""
    poses, truth = world.graph.split(states)[0], world.graph.split(world.truth)[0]
    with np.errstate(over="ignore", invalid="ignore"):
        return float(np.sqrt(np.mean(np.sum((poses - truth)[:, :2] ** 2, axis=1))))


# --- how they are made ---


def _walk(rng: np.random.Generator, poses: int, size: tuple[int, int]) -> FloatArray:
    """A random way along the corridors that turns back nowhere: (poses, 3)."""
    junction, heading = np.array([0, 0]), 0
    places, headings = [np.array([0.0, 0.0])], [0.0]
    while len(places) < poses:
        ways = [
            way
            for way in (heading, heading + 1, heading - 1)
            if ((junction + _HEADINGS[way % 4] >= 0) & (junction + _HEADINGS[way % 4] < size)).all()
        ]
        heading = int(rng.choice(ways)) % 4
        junction = junction + _HEADINGS[heading]
        for _ in range(CORRIDOR):
            places.append(places[-1] + _HEADINGS[heading])
            headings.append(heading * np.pi / 2)
    headings[0] = headings[1]
    return np.column_stack([places[:poses], wrap_angle(np.array(headings[:poses]))])


def _recognised(truth: FloatArray, rng: np.random.Generator, part: float = 0.5) -> list[tuple[int, int]]:
    """Pairs (late, early): some poses recognise one that they passed much earlier."""
    pairs = []
    for late in range(APART, len(truth)):
        away = np.hypot(*(truth[: late - APART + 1] - truth[late])[:, :2].T)
        near = np.flatnonzero(away < NEAR)
        if len(near) and rng.random() < part:
            pairs.append((late, int(rng.choice(near))))
    return pairs


def _measured(
    truth: FloatArray,
    closures: Sequence[tuple[int, int]],
    marks: FloatArray,
    sights: Sequence[tuple[int, int]],
    noise: float,
    rng: np.random.Generator,
) -> World:
    """Measure steps, closures (pairs of poses) and sights (pose, landmark), with noise.

    Noise moves the end of z in the frame at that end, in which the residual and its information are: what it does
    along and across is along and across the way even where the robot turns before it drives.
    """
    steps = np.column_stack([np.arange(len(truth) - 1), np.arange(1, len(truth))])
    old = np.array(closures, dtype=int).reshape(-1, 2)
    seen = np.array(sights, dtype=int).reshape(-1, 2)
    z = [between(truth[pairs[:, 0]], truth[pairs[:, 1]]) for pairs in (steps, old)]
    sigmas = [np.tile(ODOMETRY_SIGMA, (len(steps), 1)), np.tile(CLOSURE_SIGMA, (len(old), 1))]
    information = [np.eye(3) / each[:, None, :] ** 2 for each in sigmas]
    z = [
        moved(exact, noise * sigma * rng.standard_normal(sigma.shape))
        for exact, sigma in zip(z, sigmas, strict=True)
    ]
    headed = np.column_stack([marks, np.zeros(len(marks))])
    sight = between(truth[seen[:, 0]], headed[seen[:, 1]])
    sight[:, :2] += noise * SIGHT_SIGMA * rng.standard_normal((len(sight), 2))
    sight[:, 2] = 0.0
    flat = np.diag([1.0, 1.0, 0.0]) / SIGHT_SIGMA**2
    graph = Graph(
        np.concatenate([steps, old, seen + [0, len(truth)]]),
        np.concatenate([*z, sight]),
        np.concatenate([*information, np.broadcast_to(flat, (len(sight), 3, 3))]),
        np.repeat([POSE, LANDMARK], [len(truth), len(marks)]),
    )
    path = chained(truth[0], z[0])
    guess = _first_sights(path, seen, sight, len(marks))
    return World(
        graph, np.concatenate([truth.ravel(), marks.ravel()]), np.concatenate([path.ravel(), guess.ravel()])
    )


def _first_sights(path: FloatArray, seen: npt.NDArray[np.int64], sight: FloatArray, count: int) -> FloatArray:
    """Put each landmark where it was seen first, from a path: (count, 2)."""
    places = np.zeros((count, 2))
    for (pose, number), z in zip(seen[::-1], sight[::-1], strict=True):
        x, y, theta = path[pose]
        c, s = np.cos(theta), np.sin(theta)
        places[number] = x + c * z[0] - s * z[1], y + s * z[0] + c * z[1]
    return places
