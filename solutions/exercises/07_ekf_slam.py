"""Lesson 07, EKF SLAM: its exercises, what students get wrong in them, and other right ways to write them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[Any]
TURN = 2 * np.pi


# --- lesson 05's functions ---


def expected(pose: Any, landmark: Any) -> Array:
    """Bearing and range (2,) of a landmark."""
    dx, dy = landmark[0] - pose[0], landmark[1] - pose[1]
    return np.array([wrapped(np.arctan2(dy, dx) - pose[2]), np.hypot(dx, dy)])


def slopes(pose: Any, landmark: Any) -> tuple[Array, Array]:
    """Slopes of bearing and range by the pose (2, 3) and by the landmark (2, 2)."""
    dx, dy = landmark[0] - pose[0], landmark[1] - pose[1]
    r = np.hypot(dx, dy)
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
    """Where a measurement puts its landmark (2,), and the slopes of that by the pose (2, 3) and the measurement (2, 2)."""
    bearing, r = measurement
    c, s = np.cos(pose[2] + bearing), np.sin(pose[2] + bearing)
    by_pose = np.array([[1.0, 0.0, -r * s], [0.0, 1.0, r * c]])
    return np.array([pose[0] + r * c, pose[1] + r * s]), by_pose, np.array([[-r * s, c], [r * c, s]])


def wrapped(angle: Any) -> Any:
    """Angles in [-pi, pi)."""
    return (angle + np.pi) % TURN - np.pi


def joint_noise(measurement_covariance: Any, k: int) -> Array:
    """The noise of k landmarks (2k, 2k), from (2, 2) for each, (k, 2, 2) or (2k, 2k)."""
    R = np.asarray(measurement_covariance, dtype=float)
    if R.ndim == 2 and R.shape == (2 * k, 2 * k):
        return R
    joint = np.zeros((2 * k, 2 * k))
    for number, block in enumerate(np.broadcast_to(R, (k, 2, 2))):
        joint[2 * number : 2 * number + 2, 2 * number : 2 * number + 2] = block
    return joint


# --- the exercises' answers ---


def warp2pi(angle: Any) -> Any:
    return wrapped(np.asarray(angle, dtype=float))


def init_landmarks(
    measurements: Array, measurement_covariance: Array, pose: Array, pose_covariance: Array
) -> tuple[int, Array, Array]:
    k = len(measurements) // 2
    R = joint_noise(measurement_covariance, k)
    landmarks, by_measurement = np.zeros(2 * k), np.zeros((2 * k, 2 * k))
    for i in range(0, 2 * k, 2):
        landmarks[i : i + 2], _, by_measurement[i : i + 2, i : i + 2] = place(pose, measurements[i : i + 2])
    return k, landmarks, by_measurement @ R @ by_measurement.T


def predict(
    state: Array, covariance: Array, control: Array, control_covariance: Array, k: int
) -> tuple[Array, Array]:
    F, G = motion_slopes(state[:3], control)
    state, covariance = state.copy(), covariance.copy()
    state[:3] += control[0] * np.cos(state[2]), control[0] * np.sin(state[2]), control[1]
    state[2] = warp2pi(state[2])
    covariance[:3, :3] = F @ covariance[:3, :3] @ F.T + G @ control_covariance @ G.T
    covariance[3:, :3] = covariance[3:, :3] @ F.T
    covariance[:3, 3:] = covariance[3:, :3].T
    return state, covariance


def update_landmarks(
    state: Array,
    covariance: Array,
    indices: Sequence[int],
    measurements: Array,
    measurement_covariance: Array,
) -> tuple[Array, Array]:
    m, pose = len(indices), state[:3]
    columns = np.array([0, 1, 2, *(3 + 2 * i + c for i in indices for c in (0, 1))])
    surprise, H = np.zeros(2 * m), np.zeros((2 * m, 3 + 2 * m))
    for j, i in enumerate(indices):
        rows, landmark = slice(2 * j, 2 * j + 2), state[3 + 2 * i : 5 + 2 * i]
        surprise[rows] = measurements[rows] - expected(pose, landmark)
        H[rows, :3], H[rows, 3 + 2 * j : 5 + 2 * j] = slopes(pose, landmark)
    surprise[::2] = warp2pi(surprise[::2])
    cross = covariance[:, columns] @ H.T
    S = H @ cross[columns] + joint_noise(measurement_covariance, m)
    K = np.linalg.solve(S, cross.T).T
    state = state + K @ surprise
    state[2] = warp2pi(state[2])
    return state, covariance - K @ cross.T


def update(
    state: Array, covariance: Array, measurements: Array, measurement_covariance: Array, k: int
) -> tuple[Array, Array]:
    return update_landmarks(state, covariance, range(k), measurements, measurement_covariance)


def add_landmark(
    state: Array, covariance: Array, measurement: Array, measurement_covariance: Array
) -> tuple[Array, Array]:
    position, by_pose, by_measurement = place(state[:3], measurement)
    cross = covariance[:, :3] @ by_pose.T
    own = by_pose @ cross[:3] + by_measurement @ measurement_covariance @ by_measurement.T
    return np.append(state, position), np.block([[covariance, cross], [cross.T, own]])


def evaluate_landmarks(estimates: Array, covariances: Array, truth: Array) -> tuple[Array, Array]:
    errors = np.asarray(estimates) - truth
    squared = [e @ np.linalg.solve(P, e) for e, P in zip(errors, covariances, strict=True)]
    return np.hypot(*errors.T), np.sqrt(squared)
