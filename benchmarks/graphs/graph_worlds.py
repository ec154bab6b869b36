"""Large simulated graphs: a random walk through the streets of a town, with loop closures or with landmarks."""

from __future__ import annotations

import numpy as np
import scipy.spatial

from nao_course.geometry import FloatArray
from nao_course.graphs import LANDMARK, POSE, Graph
from nao_course.lessons.pose_graphs.worlds import between

STEP_SIGMA = np.array([0.02, 0.02, 0.01])  # m, m, rad; as large along as across, so the frame does not matter
SIGHT_SIGMA = np.array([0.001, 0.001])  # rad, m: so good that bearing and range have the optimum of x and y
NEAREST, FARTHEST = 1.0, 3.5  # m within which a landmark is seen
HEADINGS = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])


def streets(poses: int, rng: np.random.Generator) -> FloatArray:
    """Return a random walk on a grid inside a square, with steps of a metre, as (poses, 3)."""
    side = max(int(np.sqrt(poses) / 2), 3)
    at, heading = np.zeros(2, dtype=int), 0
    truth = np.zeros((poses, 3))
    draws = rng.random(poses)
    for step in range(1, poses):
        while draws[step] < 0.25 or np.abs(at + HEADINGS[heading]).max() > side:
            heading, draws[step] = int(rng.integers(4)), 1.0
        at = at + HEADINGS[heading]
        truth[step] = *at, heading * np.pi / 2
    return truth


def town(poses: int, seed: int = 9) -> tuple[Graph, FloatArray]:
    """Return a graph of poses that revisit places, and states near the truth.

    What is measured is time, so nobody has to find the way from far off: odometry over 100,000 m would be too far.
    """
    rng = np.random.default_rng([seed, poses])
    truth = streets(poses, rng)
    steps = np.column_stack([np.arange(poses - 1), np.arange(1, poses)])
    pairs = np.concatenate([steps, _met_again(truth, rng)])
    z = between(truth[pairs[:, 0]], truth[pairs[:, 1]]) + rng.normal(0.0, STEP_SIGMA, (len(pairs), 3))
    information = np.broadcast_to(np.diag(STEP_SIGMA**-2.0), (len(pairs), 3, 3))
    return Graph(pairs, z, information, np.full(poses, POSE)), _near(truth, rng).ravel()


def _met_again(truth: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return pairs (late, early): half of the poses on a crossing that was passed before recognise it."""
    last: dict[tuple[float, float], int] = {}
    pairs = []
    for late, (x, y, _) in enumerate(truth):
        early = last.get((x, y))
        if early is not None and late - early > 3 and rng.random() < 0.5:
            pairs.append((late, early))
        last[x, y] = late
    return np.array(pairs, dtype=int).reshape(-1, 2)


def town_with_landmarks(poses: int = 5000, landmarks: int = 500, seed: int = 9) -> tuple[Graph, FloatArray]:
    """Return a graph of poses that measure bearing and range of all landmarks nearby, and states near the truth."""
    rng = np.random.default_rng([seed, poses, landmarks])
    truth = streets(poses, rng)
    marks = rng.uniform(truth[:, :2].min(axis=0) - 1, truth[:, :2].max(axis=0) + 1, (landmarks, 2))
    tree = scipy.spatial.cKDTree(marks)
    far, too_near = (tree.query_ball_point(truth[:, :2], distance) for distance in (FARTHEST, NEAREST))
    near = [sorted(set(each) - set(less)) for each, less in zip(far, too_near, strict=True)]
    pose = np.repeat(np.arange(poses), [len(each) for each in near])
    seen, mark = np.unique(np.concatenate([np.array(each, dtype=int) for each in near]), return_inverse=True)
    away = between(truth[pose], np.column_stack([marks[seen][mark], np.zeros(len(mark))]))[:, :2]
    bearing = np.arctan2(away[:, 1], away[:, 0]) + rng.normal(0.0, SIGHT_SIGMA[0], len(mark))
    distance = np.hypot(*away.T) + rng.normal(0.0, SIGHT_SIGMA[1], len(mark))
    sight, information = cartesian(bearing, distance)
    z = between(truth[:-1], truth[1:]) + rng.normal(0.0, STEP_SIGMA, (poses - 1, 3))
    graph = Graph(
        np.concatenate(
            [
                np.column_stack([np.arange(poses - 1), np.arange(1, poses)]),
                np.column_stack([pose, poses + mark]),
            ]
        ),
        np.concatenate([z, sight]),
        np.concatenate([np.broadcast_to(np.diag(STEP_SIGMA**-2.0), (poses - 1, 3, 3)), information]),
        np.repeat([POSE, LANDMARK], [poses, len(seen)]),
    )
    return graph, np.concatenate(
        [_near(truth, rng).ravel(), (marks[seen] + rng.normal(0.0, 0.1, (len(seen), 2))).ravel()]
    )


def _near(truth: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return poses near the true ones; the first is exact."""
    away = rng.normal(0.0, (0.1, 0.1, 0.03), truth.shape)
    away[0] = 0.0
    return np.asarray(truth + away)


def cartesian(bearing: FloatArray, distance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Convert bearings and ranges (N,) to measurements (N, 3) and information (N, 3, 3) of a graph's edges."""
    c, s = np.cos(bearing), np.sin(bearing)
    z = np.column_stack([distance * c, distance * s, np.zeros(len(bearing))])
    across, along = np.stack([-s, c], axis=-1), np.stack([c, s], axis=-1)
    weights = (distance * SIGHT_SIGMA[0]) ** -2.0, np.full(len(bearing), SIGHT_SIGMA[1] ** -2.0)
    information = np.zeros((len(bearing), 3, 3))
    for weight, axis in zip(weights, (across, along), strict=True):
        information[:, :2, :2] += weight[:, None, None] * axis[:, :, None] * axis[:, None, :]
    return z, information
