"""The same drives mapped by an EKF and by a pose graph: error, consistency and time by the length of the drive."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from nao_course.geometry import FloatArray, Pose, pose_errors
from nao_course.graphs import LANDMARK, POSE, Graph
from nao_course.metrics import squared_distances
from nao_course.sim.drives import Drive, FieldOfView, NamedEkf, Sigmas, Step, measure_in_view, true_path
from nao_course.slam import Motion

# The hall: lanes of ten metres, three metres apart, with a stop every metre. Landmarks within four metres are measured.
LANE, BETWEEN_LANES = 10, 3
VIEW = FieldOfView(np.pi, 4.0, nearest=0.3)
LANDMARKS_PER_M2 = 0.1
ITERATIONS = 6  # of Gauss-Newton from the EKF's estimate; after four nothing moves


NOISES = {
    "a careful NAO": Sigmas(0.03, 0.02, np.radians(1.0), np.radians(1.5), 0.05),
    "3° a step, 5° bearing": Sigmas(0.05, 0.05, np.radians(3.0), np.radians(5.0), 0.10),
}


def hall_drive(seed: int, steps: int, noise: Sigmas) -> Drive:
    """Drive up and down the lanes of a hall with landmarks; a longer drive has a larger hall.

    A step is one metre long.
    """
    rng, motions = np.random.default_rng([seed, steps]), _lanes(steps)
    poses = [pose.as_array() for pose in true_path(motions, noise, rng)]
    positions = np.array(poses)[:, :2]
    low, high = positions.min(axis=0) - 2.0, positions.max(axis=0) + 2.0
    marks = rng.uniform(low, high, (int(LANDMARKS_PER_M2 * np.prod(high - low)), 2))
    number_of: dict[int, int] = {}
    made = []
    for pose, motion in zip(poses, [None, *motions], strict=True):
        found, seen = measure_in_view(pose, marks, noise, VIEW, rng)
        numbers = np.array(
            [number_of.setdefault(each, len(number_of)) for each in found.tolist()], dtype=np.intp
        )
        covariance = noise.control_covariance if motion else np.zeros((3, 3))
        made.append(Step(pose, motion, covariance, numbers, seen, noise.covariances(seen)))
    return Drive(marks[list(number_of)], tuple(made))


def _lanes(steps: int) -> list[Motion]:
    """Return the command of each step: ten metres, a quarter turn, three metres, a quarter turn, and back."""
    round_trip = 2 * (LANE + BETWEEN_LANES)
    turns = dict.fromkeys((LANE, LANE + BETWEEN_LANES), np.pi / 2)
    turns |= dict.fromkeys((2 * LANE + BETWEEN_LANES, 0), -np.pi / 2)
    return [Motion(1.0, turns.get(step % round_trip, 0.0)) for step in range(1, steps + 1)]


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
    """The result of a method: all poses (M + 1, 3), landmarks (k, 2), the last pose's covariance, seconds."""

    poses: FloatArray
    landmarks: FloatArray
    covariance: FloatArray
    seconds: float


def run_filter(drive: Drive, ekf: Filter) -> Mapped:
    """Map a drive with the EKF: predict, update known landmarks, add new ones."""
    slam, path = NamedEkf(Pose(), *ekf), []
    begin = time.process_time()
    for step in drive.steps:
        if step.motion is not None:
            slam.move(step.control, step.control_covariance)
        slam.observe(step.numbers, step.measurements, step.covariances)
        path.append(slam.state[:3])
    seconds = time.process_time() - begin
    return Mapped(np.array(path), slam.state[3:].reshape(-1, 2), slam.covariance[:3, :3], seconds)


def drive_graph(drive: Drive) -> Graph:
    """Return the graph of a drive, with an edge for each step and for each measurement of a landmark."""
    count, controls = len(drive.steps), drive.controls
    edges = np.column_stack([np.arange(count - 1), np.arange(1, count)])
    z = np.column_stack([controls[:, 0], np.zeros(count - 1), controls[:, 1]])
    c, s = np.cos(z[:, 2]), np.sin(z[:, 2])
    turn = np.zeros((count - 1, 3, 3))
    turn[:, 0, 0], turn[:, 0, 1], turn[:, 1, 0], turn[:, 1, 1], turn[:, 2, 2] = c, s, -s, c, 1.0
    noise = np.array([step.control_covariance for step in drive.steps[1:]])
    covariance = turn @ noise @ turn.mT  # the residual is in the measured pose's frame
    seen = np.array([(pose, count + each) for pose, step in enumerate(drive.steps) for each in step.numbers])
    b, r = np.concatenate([step.measurements for step in drive.steps]).T
    c, s = np.cos(b), np.sin(b)
    jacobians = np.stack([np.stack([-r * s, c], axis=-1), np.stack([r * c, s], axis=-1)], axis=-2)
    noise = np.concatenate([step.covariances for step in drive.steps])
    information = np.zeros((len(seen), 3, 3))
    information[:, :2, :2] = np.linalg.inv(jacobians @ noise @ jacobians.mT)
    return Graph(
        np.concatenate([edges, seen]),
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


# --- scores ---


def scores(drive: Drive, mapped: Mapped) -> dict[str, float]:
    """Return errors of all poses, of the last one and of the landmarks (m, RMS), the last pose's NEES, and seconds."""
    error = pose_errors(mapped.poses[-1], drive.steps[-1].pose)
    away = {
        "path": mapped.poses[:, :2] - drive.poses[:, :2],
        "last": error[None, :2],
        "landmarks": mapped.landmarks - drive.landmarks,
    }
    found = {name: float(np.sqrt(np.mean(np.sum(each**2, axis=1)))) for name, each in away.items()}
    nees = float(squared_distances(error[None], mapped.covariance[None])[0])
    return found | {"nees": nees, "seconds": mapped.seconds}


def compare(
    ekf: Filter, smoother: Smoother, noise: Sigmas, steps: Sequence[int], seeds: Sequence[int]
) -> dict[str, dict[str, FloatArray]]:
    """Map the same drives with the filter of lesson 07 and the graph of lesson 09.

    For "ekf" and "graph", return the `scores` by name, arrays of shape (lengths, seeds).
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
    """Return the seconds of a graph that is solved anew at each stop, one iteration from the previous estimate."""
    graph, seconds = drive_graph(drive), 0.0
    known = np.maximum.accumulate([max(step.numbers, default=-1) + 1 for step in drive.steps])
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
