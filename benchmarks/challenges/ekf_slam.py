"""Entries of lesson 07's challenge: odometry, the homework's start, the reference, and a smoother of all of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.geometry import wrap_angle

Array = npt.NDArray[Any]
Belief = tuple[Array, Array]

ITERATIONS = 15
START_DOUBT = 1e-9  # m, rad: the first pose is the origin


def _moved(pose: Array, control: Array) -> Array:
    return pose + (control[0] * np.cos(pose[2]), control[0] * np.sin(pose[2]), control[1])


def _motion_slopes(pose: Array, control: Array) -> tuple[Array, Array]:
    c, s = np.cos(pose[2]), np.sin(pose[2])
    F, G = np.eye(3), np.eye(3)
    F[:2, 2] = -control[0] * s, control[0] * c
    G[:2, :2] = [[c, -s], [s, c]]
    return F, G


def _expected(pose: Array, landmark: Array) -> Array:
    dx, dy = landmark - pose[:2]
    return np.array([np.arctan2(dy, dx) - pose[2], np.hypot(dx, dy)])


def _look_slopes(pose: Array, landmark: Array) -> tuple[Array, Array]:
    dx, dy = landmark - pose[:2]
    r = np.hypot(dx, dy)
    by_landmark = np.array([[-dy / r**2, dx / r**2], [dx / r, dy / r]])
    return np.column_stack([-by_landmark, [-1.0, 0.0]]), by_landmark


def _placed(pose: Array, measured: Array) -> tuple[Array, Array, Array]:
    c, s = np.cos(pose[2] + measured[0]), np.sin(pose[2] + measured[0])
    r = measured[1]
    return (
        pose[:2] + r * np.array([c, s]),
        np.array([[1.0, 0.0, -r * s], [0.0, 1.0, r * c]]),
        np.array([[-r * s, c], [r * c, s]]),
    )


def odometry(log: list[Any]) -> Belief:
    """Ignore all measurements."""
    pose, covariance = np.zeros(3), np.zeros((3, 3))
    for control, Q, *_ in log:
        F, G = _motion_slopes(pose, control)
        pose, covariance = _moved(pose, control), F @ covariance @ F.T + G @ Q @ G.T
    pose[2] = wrap_angle(pose[2])
    return pose, covariance


def _predicted(state: Array, P: Array, control: Array, Q: Array) -> Belief:
    F, G = _motion_slopes(state[:3], control)
    state, P = state.copy(), P.copy()
    state[:3] = _moved(state[:3], control)
    P[:3, :3] = F @ P[:3, :3] @ F.T + G @ Q @ G.T
    P[3:, :3] = P[3:, :3] @ F.T
    P[:3, 3:] = P[3:, :3].T
    return state, P


def _updated(state: Array, P: Array, indices: list[int], z: Array, R: Array) -> Belief:
    H, surprise = np.zeros((2 * len(indices), len(state))), np.zeros(2 * len(indices))
    for j, i in enumerate(indices):
        rows, columns = slice(2 * j, 2 * j + 2), slice(3 + 2 * i, 5 + 2 * i)
        H[rows, :3], H[rows, columns] = _look_slopes(state[:3], state[columns])
        surprise[rows] = z[rows] - _expected(state[:3], state[columns])
    surprise[::2] = wrap_angle(surprise[::2])
    shared = P @ H.T
    gain = np.linalg.solve(H @ shared + np.kron(np.eye(len(indices)), R), shared.T).T
    P = P - gain @ shared.T
    return state + gain @ surprise, (P + P.T) / 2


def _filter(joined: bool) -> Callable[[list[Any]], Belief]:
    """Run an EKF; a new landmark is correlated with the state, or added without correlations as in the homework."""

    def entry(log: list[Any]) -> Belief:
        state, P, known = np.zeros(3), np.zeros((3, 3)), list[int]()
        for control, Q, numbers, measurements, R in log:
            state, P = _predicted(state, P, control, Q)
            pairs = measurements.reshape(-1, 2)
            again = [j for j, number in enumerate(numbers) if number in known]
            if again:
                indices = [known.index(numbers[j]) for j in again]
                state, P = _updated(state, P, indices, pairs[again].reshape(-1), R)
            for number, measured in zip(numbers, pairs, strict=True):
                if number not in known:
                    known.append(number)
                    place, by_pose, by_measurement = _placed(state[:3], measured)
                    noise = by_measurement @ R @ by_measurement.T
                    cross = P[:, :3] @ by_pose.T * joined
                    own = noise + joined * by_pose @ P[:3, :3] @ by_pose.T
                    state, P = np.append(state, place), np.block([[P, cross], [cross.T, own]])
        state[2] = wrap_angle(state[2])
        return state[:3], P[:3, :3]

    return entry


def better(log: list[Any]) -> Belief:
    """Estimate all poses and landmarks at once by repeated linearisation, and return the last pose."""
    poses, landmarks, known = _first_guess(log)
    for _ in range(ITERATIONS):
        H, b = _normal_equations(log, poses, landmarks, known)
        shift = np.linalg.solve(H, b)
        poses = poses + shift[: poses.size].reshape(-1, 3)
        landmarks = landmarks + shift[poses.size :].reshape(-1, 2)
        if np.abs(shift).max() < 1e-8:
            break
    H, _ = _normal_equations(log, poses, landmarks, known)
    last = slice(poses.size - 3, poses.size)
    columns = np.zeros((len(H), 3))
    columns[last] = np.eye(3)
    covariance = np.linalg.solve(H, columns)[last]
    pose = poses[-1].copy()
    pose[2] = wrap_angle(pose[2])
    return pose, (covariance + covariance.T) / 2


def _first_guess(log: list[Any]) -> tuple[Array, Array, dict[int, int]]:
    """Return the poses and landmarks that an EKF estimates during the drive."""
    state, P, known, poses = np.zeros(3), np.zeros((3, 3)), dict[int, int](), list[Array]()
    for control, Q, numbers, measurements, R in log:
        state, P = _predicted(state, P, control, Q)
        pairs = measurements.reshape(-1, 2)
        again = [j for j, number in enumerate(numbers) if number in known]
        if again:
            state, P = _updated(state, P, [known[numbers[j]] for j in again], pairs[again].reshape(-1), R)
        for number, measured in zip(numbers, pairs, strict=True):
            if number not in known:
                known[number] = len(known)
                place, by_pose, by_measurement = _placed(state[:3], measured)
                cross = P[:, :3] @ by_pose.T
                own = by_measurement @ R @ by_measurement.T + by_pose @ P[:3, :3] @ by_pose.T
                state, P = np.append(state, place), np.block([[P, cross], [cross.T, own]])
        poses.append(state[:3])
    return np.array(poses), state[3:].reshape(-1, 2), known


def _normal_equations(
    log: list[Any], poses: Array, landmarks: Array, known: dict[int, int]
) -> tuple[Array, Array]:
    size = poses.size + landmarks.size
    H, b = np.zeros((size, size)), np.zeros(size)

    def add(columns: Array, slopes: Array, residual: Array, weight: Array) -> None:
        H[np.ix_(columns, columns)] += slopes.T @ weight @ slopes
        b[columns] += slopes.T @ weight @ residual

    first = np.arange(3)
    add(first, np.eye(3), -poses[0], np.eye(3) / START_DOUBT**2)
    for n, (control, Q, numbers, measurements, R) in enumerate(log):
        here = np.arange(3 * n, 3 * n + 3)
        if n:
            before = poses[n - 1]
            c, s = np.cos(before[2]), np.sin(before[2])
            turn = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
            off = poses[n] - before
            off[2] = wrap_angle(off[2] - control[1])
            residual = turn @ off - (control[0], 0.0, 0.0)
            by_before = -turn.copy()
            by_before[:2, 2] = np.array([[-s, c], [-c, -s]]) @ off[:2]
            slopes = np.column_stack([by_before, turn])
            add(np.append(here - 3, here), -slopes, residual, np.linalg.inv(Q))
        weight = np.linalg.inv(R)
        for number, measured in zip(numbers, measurements.reshape(-1, 2), strict=True):
            i = known[number]
            residual = measured - _expected(poses[n], landmarks[i])
            residual[0] = wrap_angle(residual[0])
            there = poses.size + 2 * i + np.arange(2)
            add(
                np.append(here, there),
                np.column_stack(_look_slopes(poses[n], landmarks[i])),
                residual,
                weight,
            )
    return H, b


EKF_ENTRIES = {
    "odometry": odometry,
    "the homework's start": _filter(joined=False),
    "the reference": _filter(joined=True),
    "a better one": better,
}
