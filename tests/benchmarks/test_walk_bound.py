"""The bound of a walk's last pose: measurements make it smaller, and least squares reaches it."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.linalg import block_diag

from benchmarks.field.field_walk import pose_bound
from nao_course.field_slam.drives import OdometryNoisePerMove
from nao_course.field_slam.observation import observation
from nao_course.geometry import Pose
from nao_course.slam import Measurement, Motion, range_and_bearing

ODOMETRY, PLACES = OdometryNoisePerMove(factor=0.1), np.array([(2.0, 1.0), (2.5, -0.5)])
POSES = [Pose(), Pose(0.3, 0.0, 0.2), Pose(0.3, 0.0, 0.2) @ Pose(0.4, 0.0, -0.5)]


def stops(sigma=np.inf, marks=2, poses=POSES):
    """Yield a walk with measured landmarks and, after the first pose, a compass."""
    for n, pose in enumerate(poses):
        of = range_and_bearing(pose.as_array(), PLACES[:marks]).tolist()
        seen = observation([Measurement(*values) for values in of], (1e-3, 1e-3))
        yield pose, replace(seen, direction_sigma=sigma if n else np.inf), PLACES[:marks]


def test_without_measurements_the_bound_is_the_sum_of_the_errors_of_odometry():
    along, across, turn = np.diag(ODOMETRY.covariance(Motion(0.2, 0.0)))
    expected = [4 * along, 4 * across + 0.2**2 * (1 + 4 + 9) * turn, 4 * turn]
    straight = [*stops(marks=0, poses=[Pose(0.2 * n) for n in range(5)])]
    assert np.diag(pose_bound(straight, ODOMETRY, known_map=False)) == pytest.approx(expected)


def test_no_measurement_and_no_knowledge_of_the_map_makes_the_bound_larger():
    cases = [(np.inf, 0, False), (np.inf, 1, False), (np.inf, 2, False), (0.01, 2, False), (0.01, 2, True)]
    covariances = [pose_bound([*stops(s, k)], ODOMETRY, known) for s, k, known in cases]
    for less, more in pairwise(covariances):
        assert np.linalg.eigvalsh(less - more)[0] > -1e-12 and np.trace(more) < 0.999 * np.trace(less)


def test_least_squares_over_all_poses_and_the_map_errs_as_the_bound_states():
    def measured(state):
        poses = [POSES[0], *map(Pose.from_array, state[:6].reshape(2, 3))]
        steps = [(a.inverse() @ b).as_array() for a, b in pairwise(poses)]
        seen = [range_and_bearing(pose.as_array(), state[6:].reshape(2, 2)).ravel() for pose in poses]
        return np.concatenate([*steps, *seen, state[[2, 5]]])

    walk, true = [*stops(0.01)], np.concatenate([*(pose.as_array() for pose in POSES[1:]), PLACES.ravel()])
    J = np.column_stack([measured(true + d) - measured(true - d) for d in 1e-6 * np.eye(10)]) / 2e-6
    steps = [ODOMETRY.covariance(Motion(*step)) for step in measured(true)[:6].reshape(2, 3)[:, ::2]]
    R = block_diag(*steps, *(seen.covariance for _, seen, _ in walk), 1e-4 * np.eye(2))
    drawn = np.random.default_rng(1).multivariate_normal(np.zeros(len(R)), R, 20_000)
    errors = np.linalg.lstsq(*(np.linalg.solve(np.linalg.cholesky(R), of) for of in (J, drawn.T)))[0][3:6]
    whitened = np.linalg.solve(np.linalg.cholesky(pose_bound(walk, ODOMETRY, known_map=False)), errors)
    assert np.cov(whitened) == pytest.approx(np.eye(3), abs=0.04)
