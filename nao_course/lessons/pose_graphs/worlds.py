"""Drives with a known truth: through a building's corridors, around a loop, and over the half field."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, wrap_angle
from nao_course.graphs import LANDMARK, POSE, Graph
from nao_course.sim import Field

ODOMETRY_SIGMA = (0.05, 0.03, np.radians(1.0))  # m along and across each driven metre, rad
CLOSURE_SIGMA = (0.05, 0.05, np.radians(1.0))  # of a recognised pose
LANDMARK_SIGMA = 0.05  # m, of a measured landmark
CORRIDOR = 6  # m between two junctions
NEAR = 1.5  # m within which an old pose is recognised
APART = 20  # poses at least between a pose and the old pose that it is matched with

_HEADINGS = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])


@dataclass(frozen=True, eq=False)
class World:
    """A graph, its true states, and its states by odometry alone.

    Parameters
    ----------
    graph : Graph
        The measurements.
    truth, odometry : ndarray, shape (3 P + 2 L,)
        States: x, y, theta of each pose, then x, y of each landmark; m, rad. The first pose is the same in both.
    """

    graph: Graph
    truth: FloatArray
    odometry: FloatArray

    def closures(self) -> npt.NDArray[np.bool_]:
        """Return whether each edge connects two poses that do not follow each other: (E,)."""
        first, second = self.graph.edges.T
        return (self.graph.kinds[second] == POSE) & (second != first + 1)


def between(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return poses (E, 3) in the frames of other poses (E, 3)."""
    c, s = np.cos(first[:, 2]), np.sin(first[:, 2])
    dx, dy = (second - first)[:, :2].T
    return np.stack([c * dx + s * dy, -s * dx + c * dy, wrap_angle(second[:, 2] - first[:, 2])], axis=1)


def moved(poses: FloatArray, motions: FloatArray) -> FloatArray:
    """Return poses (E, 3) after motions (E, 3) in their own frames; the inverse of `between`."""
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
    """Drive through a building's corridors, with a pose every metre, and recognise places that were passed before.

    Parameters
    ----------
    seed : int
        Seed of the path and of the noise.
    poses : int
        Number of poses.
    noise : float
        Factor of all standard deviations; 0 gives exact measurements.
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
    """Drive once around a square, with a pose every metre, and recognise the first pose at the end."""
    rng = np.random.default_rng([seed, 91])
    corners = np.repeat(np.arange(4), side)
    places = np.concatenate([[[0, 0]], np.cumsum(_HEADINGS[corners], axis=0)])
    headings = np.concatenate([corners, [3]]) * np.pi / 2
    truth = np.column_stack([places, wrap_angle(headings)]).astype(float)
    return _measured(truth, [(len(truth) - 1, 0)] if closed else [], np.empty((0, 2)), [], noise, rng)


def small_world() -> World:
    """Drive once round a square of 2 m and measure two landmarks from some of the nine poses."""
    exact = loop(1, 2, noise=0.0)
    truth, marks = exact.graph.split(exact.truth)[0], np.array([[1.0, 0.7], [1.3, 1.4]])
    seen = [(1, 0), (4, 1), (6, 0), (6, 1)]
    return _measured(truth, [(len(truth) - 1, 0)], marks, seen, 1.0, np.random.default_rng(94))


def drifting_loop(drift: float, side: int = 10) -> World:
    """Drive once around a square with odometry that drifts evenly and has no other error.

    Parameters
    ----------
    drift : float
        Error of the odometry's heading at the end, rad.
    side : int
        Length of a side: metres and poses.

    Returns
    -------
    World
        Its last edge closes the loop exactly.
    """
    exact = loop(1, side, noise=0.0)
    steps = exact.graph.poses - 1
    z = exact.graph.measurements.copy()
    z[:steps, 2] += drift / steps
    path = chained(exact.truth[:3], z[:steps])
    return World(replace(exact.graph, measurements=z), exact.truth, path.ravel())


def field_drive(seed: int = 1, stops: int = 25, noise: float = 1.0) -> World:
    """Drive a circle over the half field and measure landmarks ahead, at most 2.5 m away.

    Parameters
    ----------
    seed : int
        Seed of the noise.
    stops : int
        Number of poses; the last one is at the position of the first one.
    noise : float
        As in `building`.

    Returns
    -------
    World
    """
    rng = np.random.default_rng([seed, 92])
    marks = Field(2012, half=True).detectable_positions
    angles = np.linspace(-np.pi / 2, 1.5 * np.pi, stops)
    places = [1.5, 0.0] + 0.9 * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    truth = np.column_stack([places, wrap_angle(angles + np.pi / 2)])
    observed = [
        (pose, number)
        for pose, at in enumerate(truth)
        for number, mark in enumerate(marks)
        if _in_view(at, mark)
    ]
    return _measured(truth, [], marks, observed, noise, rng)


def _in_view(pose: FloatArray, mark: FloatArray) -> bool:
    away = mark - pose[:2]
    return bool(np.hypot(*away) < 2.5 and abs(wrap_angle(np.arctan2(away[1], away[0]) - pose[2])) < np.pi / 3)


def with_false_closures(world: World, count: int, seed: int = 0) -> World:
    """Add closures between places that only look alike.

    Parameters
    ----------
    world : World
        With poses.
    count : int
        Number of false closures.
    seed : int
        Seed of the pairs of poses.

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
    """Return the truth with random errors in each position (m) and heading (rad), except for the first pose."""
    poses, marks = (each.copy() for each in world.graph.split(world.truth))
    poses[1:, :2] += position * rng.standard_normal((len(poses) - 1, 2))
    poses[1:, 2] += heading * rng.standard_normal(len(poses) - 1)
    marks += position * rng.standard_normal(marks.shape)
    return np.concatenate([poses.ravel(), marks.ravel()])


def position_error(world: World, states: npt.ArrayLike) -> float:
    """Return the root mean square distance (m) of all poses from the truth, with the true first pose."""
    poses, truth = world.graph.split(states)[0], world.graph.split(world.truth)[0]
    with np.errstate(over="ignore", invalid="ignore"):
        return float(np.sqrt(np.mean(np.sum((poses - truth)[:, :2] ** 2, axis=1))))


# --- making the worlds ---


def _walk(rng: np.random.Generator, poses: int, size: tuple[int, int]) -> FloatArray:
    """Return a random path along the corridors that never turns back: (poses, 3)."""
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
    """Return pairs (late, early) of poses, in which the late one recognises a place that was passed much earlier."""
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
    observed: Sequence[tuple[int, int]],
    noise: float,
    rng: np.random.Generator,
) -> World:
    """Measure steps, closures (pairs of poses) and landmarks (pose, landmark), with noise.

    The noise moves the end of z in the frame at that end, because the residual and its information refer to this frame.
    So it is along and across the path even if the robot turns before it drives.
    """
    steps = np.column_stack([np.arange(len(truth) - 1), np.arange(1, len(truth))])
    old = np.array(closures, dtype=int).reshape(-1, 2)
    seen = np.array(observed, dtype=int).reshape(-1, 2)
    z = [between(truth[pairs[:, 0]], truth[pairs[:, 1]]) for pairs in (steps, old)]
    sigmas = [np.tile(ODOMETRY_SIGMA, (len(steps), 1)), np.tile(CLOSURE_SIGMA, (len(old), 1))]
    information = [np.eye(3) / each[:, None, :] ** 2 for each in sigmas]
    z = [
        moved(exact, noise * sigma * rng.standard_normal(sigma.shape))
        for exact, sigma in zip(z, sigmas, strict=True)
    ]
    headed = np.column_stack([marks, np.zeros(len(marks))])
    sight = between(truth[seen[:, 0]], headed[seen[:, 1]])
    sight[:, :2] += noise * LANDMARK_SIGMA * rng.standard_normal((len(sight), 2))
    sight[:, 2] = 0.0
    flat = np.diag([1.0, 1.0, 0.0]) / LANDMARK_SIGMA**2
    graph = Graph(
        np.concatenate([steps, old, seen + [0, len(truth)]]),
        np.concatenate([*z, sight]),
        np.concatenate([*information, np.broadcast_to(flat, (len(sight), 3, 3))]),
        np.repeat([POSE, LANDMARK], [len(truth), len(marks)]),
    )
    path = chained(truth[0], z[0])
    guess = _first_measured(path, seen, sight, len(marks))
    return World(
        graph, np.concatenate([truth.ravel(), marks.ravel()]), np.concatenate([path.ravel(), guess.ravel()])
    )


def _first_measured(
    path: FloatArray, seen: npt.NDArray[np.int64], sight: FloatArray, count: int
) -> FloatArray:
    """Return each landmark at the position of its first measurement from a path: (count, 2)."""
    places = np.zeros((count, 2))
    for (pose, number), z in zip(seen[::-1], sight[::-1], strict=True):
        x, y, theta = path[pose]
        c, s = np.cos(theta), np.sin(theta)
        places[number] = x + c * z[0] - s * z[1], y + s * z[0] + c * z[1]
    return places
