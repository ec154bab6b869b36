"""The same drives mapped by an EKF and by a pose graph: error, honesty and time by the length of the drive."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from nao_course.geometry import FloatArray, wrap_angle
from nao_course.graphs import LANDMARK, POSE, Graph
from nao_course.metrics import squared_distances

# The hall: lanes of ten metres, three metres apart, a stop a metre; every landmark within four metres is measured.
LANE, BETWEEN_LANES, SIGHT = 10, 3, 4.0
LANDMARKS_PER_M2 = 0.1
ITERATIONS = 6  # of Gauss-Newton from what the EKF says; after four nothing moves


class Noise(NamedTuple):
    """Standard deviations of one step of a metre, along and across (m) and of the turn (rad), and of one look."""

    along: float
    across: float
    turn: float
    bearing: float
    range: float

    @property
    def control_covariance(self) -> FloatArray:
        """Of (along, across, turn), (3, 3)."""
        return np.diag([self.along, self.across, self.turn]) ** 2

    @property
    def measurement_covariance(self) -> FloatArray:
        """Of (bearing, range), (2, 2)."""
        return np.diag([self.bearing, self.range]) ** 2


NOISES = {
    "a careful NAO": Noise(0.03, 0.02, np.radians(1.0), np.radians(1.5), 0.05),
    "3° a step, 5° bearing": Noise(0.05, 0.05, np.radians(3.0), np.radians(5.0), 0.10),
}


@dataclass(frozen=True, eq=False)
class Drive:
    """Controls and looks along the lanes of a hall, and what is true.

    Parameters
    ----------
    poses : ndarray, shape (M + 1, 3)
        Where the robot truly is, m and rad; it begins at 0.
    landmarks : ndarray, shape (k, 2)
        Where those that are seen truly are, in the order in which they are seen first.
    controls : ndarray, shape (M, 2)
        (distance, turn) as commanded, m and rad.
    looks : list of (ndarray, shape (m,), ndarray, shape (m, 2))
        For each pose the landmarks' numbers, and their (bearing, range) as measured.
    noise : Noise
        What the errors were drawn from, and what both methods are told.
    """

    poses: FloatArray
    landmarks: FloatArray
    controls: FloatArray
    looks: list[tuple[Any, FloatArray]]
    noise: Noise


def hall_drive(seed: int, steps: int, noise: Noise) -> Drive:
    """Drive up and down the lanes of a hall with landmarks, the longer the drive, the larger the hall.

    Parameters
    ----------
    seed : int
        Of the hall, and of all errors.
    steps : int
        M, a metre each.
    noise : Noise
        Of steps and looks.

    Returns
    -------
    Drive
    """
    rng = np.random.default_rng([seed, steps])
    controls = _lanes(steps)
    poses = np.zeros((steps + 1, 3))
    for step, (distance, turn) in enumerate(controls):
        along, across, turned = rng.normal(0.0, noise[:3])
        x, y, theta = poses[step]
        c, s = np.cos(theta), np.sin(theta)
        along += distance
        poses[step + 1] = (
            x + c * along - s * across,
            y + s * along + c * across,
            wrap_angle(theta + turn + turned),
        )
    low, high = poses[:, :2].min(axis=0) - 2.0, poses[:, :2].max(axis=0) + 2.0
    marks = rng.uniform(low, high, (int(LANDMARKS_PER_M2 * np.prod(high - low)), 2))
    marks, looks = _look_around(poses, marks, noise, rng)
    return Drive(poses, marks, controls, looks, noise)


def _lanes(steps: int) -> FloatArray:
    """(distance, turn) of each step: ten metres, a quarter turn, three metres, a quarter turn, and back."""
    controls = np.zeros((steps, 2))
    controls[:, 0] = 1.0
    round_trip = 2 * (LANE + BETWEEN_LANES)
    for step in range(steps):
        at = (step + 1) % round_trip
        if at in (LANE, LANE + BETWEEN_LANES):
            controls[step, 1] = np.pi / 2
        elif at in (2 * LANE + BETWEEN_LANES, 0):
            controls[step, 1] = -np.pi / 2
    return controls


def _look_around(
    poses: FloatArray, marks: FloatArray, noise: Noise, rng: np.random.Generator
) -> tuple[FloatArray, list[tuple[Any, FloatArray]]]:
    """Measure what is near each pose; landmarks are numbered as they are seen first, and the others are left out."""
    number_of: dict[int, int] = {}
    looks = []
    for x, y, theta in poses:
        away = marks - (x, y)
        ranges = np.hypot(*away.T)
        near = np.flatnonzero((ranges < SIGHT) & (ranges > 0.3))
        bearings = np.arctan2(away[near, 1], away[near, 0]) - theta
        measured = np.column_stack([bearings, ranges[near]])
        measured += rng.normal(0.0, (noise.bearing, noise.range), measured.shape)
        measured[:, 0] = wrap_angle(measured[:, 0])
        looks.append(
            (
                np.array([number_of.setdefault(int(each), len(number_of)) for each in near], dtype=int),
                measured,
            )
        )
    return marks[list(number_of)], looks


# --- both methods ---


class Filter(NamedTuple):
    """Lesson 07's functions."""

    predict: Callable[..., tuple[FloatArray, FloatArray]]
    update_landmarks: Callable[..., tuple[FloatArray, FloatArray]]
    add_landmark: Callable[..., tuple[FloatArray, FloatArray]]


class Smoother(NamedTuple):
    """Lesson 09's functions."""

    linearize: Callable[[Graph, FloatArray], tuple[Any, FloatArray]]
    gauss_newton: Callable[[Graph, FloatArray, int], tuple[FloatArray, FloatArray]]
    marginal_covariances: Callable[..., Sequence[FloatArray]]


class Mapped(NamedTuple):
    """What a method says of a drive: all poses (M + 1, 3), landmarks (k, 2), the last pose's covariance, seconds."""

    poses: FloatArray
    landmarks: FloatArray
    covariance: FloatArray
    seconds: float


def run_filter(drive: Drive, ekf: Filter) -> Mapped:
    """Map a drive by the EKF: predict, update what is known, add what is new."""
    Q, R = drive.noise.control_covariance, drive.noise.measurement_covariance
    state, covariance, known = np.zeros(3), np.zeros((3, 3)), 0
    path = []
    begin = time.process_time()
    for number, (indices, measured) in enumerate(drive.looks):
        if number:
            state, covariance = ekf.predict(state, covariance, drive.controls[number - 1], Q, known)
        old = indices < known
        if old.any():
            state, covariance = ekf.update_landmarks(
                state, covariance, indices[old], measured[old].ravel(), R
            )
        for measurement in measured[~old][np.argsort(indices[~old])]:
            state, covariance = ekf.add_landmark(state, covariance, measurement, R)
        known = (len(state) - 3) // 2
        path.append(state[:3])
    seconds = time.process_time() - begin
    return Mapped(np.array(path), state[3:].reshape(-1, 2), covariance[:3, :3], seconds)


def drive_graph(drive: Drive) -> Graph:
    """The graph of a drive: an edge for each step, and one for each look at a landmark."""
    count = len(drive.poses)
    steps = np.column_stack([np.arange(count - 1), np.arange(1, count)])
    z = np.column_stack([drive.controls[:, 0], np.zeros(count - 1), drive.controls[:, 1]])
    c, s = np.cos(z[:, 2]), np.sin(z[:, 2])
    turn = np.zeros((count - 1, 3, 3))
    turn[:, 0, 0], turn[:, 0, 1], turn[:, 1, 0], turn[:, 1, 1], turn[:, 2, 2] = c, s, -s, c, 1.0
    covariance = (
        turn @ drive.noise.control_covariance @ turn.mT
    )  # the residual stands in the measured pose's frame
    sights = np.array([(pose, count + each) for pose, (seen, _) in enumerate(drive.looks) for each in seen])
    b, r = np.concatenate([measured for _, measured in drive.looks]).T
    c, s = np.cos(b), np.sin(b)
    slopes = np.stack([np.stack([-r * s, c], axis=-1), np.stack([r * c, s], axis=-1)], axis=-2)
    information = np.zeros((len(sights), 3, 3))
    information[:, :2, :2] = np.linalg.inv(slopes @ drive.noise.measurement_covariance @ slopes.mT)
    return Graph(
        np.concatenate([steps, sights]),
        np.concatenate([z, np.column_stack([r * c, r * s, np.zeros(len(r))])]),
        np.concatenate([np.linalg.inv(covariance), information]),
        np.repeat([POSE, LANDMARK], [count, len(drive.landmarks)]),
    )


def run_smoother(drive: Drive, smoother: Smoother, begin: Mapped) -> Mapped:
    """Map a drive by its graph, all of it at once, from what the EKF says."""
    graph = drive_graph(drive)
    states = np.concatenate([begin.poses.ravel(), begin.landmarks.ravel()])
    start = time.process_time()
    states, _ = smoother.gauss_newton(graph, states, ITERATIONS)
    seconds = time.process_time() - start
    poses, landmarks = graph.split(states)
    last = 3 * (graph.poses - 1) + np.arange(3)
    H, _ = smoother.linearize(graph, states)
    [covariance] = smoother.marginal_covariances(H[3:, 3:], [last - 3])
    return Mapped(poses, landmarks, covariance, seconds)


# --- what comes of it ---


def scores(drive: Drive, mapped: Mapped) -> dict[str, float]:
    """Errors of all poses, of the last one and of the landmarks (m, root mean square), NEES of the last, seconds."""
    error = mapped.poses[-1] - drive.poses[-1]
    error[2] = wrap_angle(error[2])
    away = {
        "path": mapped.poses[:, :2] - drive.poses[:, :2],
        "last": error[None, :2],
        "landmarks": mapped.landmarks - drive.landmarks,
    }
    found = {name: float(np.sqrt(np.mean(np.sum(each**2, axis=1)))) for name, each in away.items()}
    nees = float(squared_distances(error[None], mapped.covariance[None])[0])
    return found | {"nees": nees, "seconds": mapped.seconds}


def compare(
    ekf: Filter, smoother: Smoother, noise: Noise, steps: Sequence[int], seeds: Sequence[int]
) -> dict[str, dict[str, FloatArray]]:
    """Map the same drives by both methods.

    Parameters
    ----------
    ekf, smoother : Filter, Smoother
        The functions of lessons 07 and 09.
    noise : Noise
        Of all drives.
    steps, seeds : sequence of int
        Lengths of the drives, and their seeds.

    Returns
    -------
    dict
        "ekf" and "graph"; of each the `scores` by name, arrays of shape (lengths, seeds).
    """
    rows: dict[str, list[list[dict[str, float]]]] = {"ekf": [], "graph": []}
    for count in steps:
        drives = [hall_drive(seed, count, noise) for seed in seeds]
        filtered = [run_filter(drive, ekf) for drive in drives]
        smoothed = [
            run_smoother(drive, smoother, begin) for drive, begin in zip(drives, filtered, strict=True)
        ]
        for name, mapped in (("ekf", filtered), ("graph", smoothed)):
            rows[name].append([scores(drive, each) for drive, each in zip(drives, mapped, strict=True)])
    return {
        name: {score: np.array([[each[score] for each in row] for row in table]) for score in table[0][0]}
        for name, table in rows.items()
    }


def at_every_stop(drive: Drive, smoother: Smoother, begin: Mapped) -> float:
    """Seconds of a graph that is solved anew at each stop, one iteration from what was known before."""
    graph, seconds = drive_graph(drive), 0.0
    known = np.maximum.accumulate([max(seen, default=-1) + 1 for seen, _ in drive.looks])
    for poses in range(2, graph.poses + 1):
        landmarks = int(known[poses - 1])
        to_landmark = graph.edges >= graph.poses
        kept = ((graph.edges < poses) | to_landmark).all(axis=1)
        part = Graph(
            np.where(to_landmark, graph.edges - graph.poses + poses, graph.edges)[kept],
            graph.measurements[kept],
            graph.information[kept],
            np.repeat([POSE, LANDMARK], [poses, landmarks]),
        )
        states = np.concatenate([begin.poses[:poses].ravel(), begin.landmarks[:landmarks].ravel()])
        start = time.process_time()
        smoother.gauss_newton(part, states, 1)
        seconds += time.process_time() - start
    return seconds
