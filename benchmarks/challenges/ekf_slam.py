"""Entries of lesson 07's challenge: odometry, the homework's start, the reference, and a smoother of all of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.linalg import block_diag

from benchmarks import solution
from nao_course.challenges.beliefs import odometry_belief
from nao_course.geometry import Pose, wrap_angle
from nao_course.slam import Motion

Array = npt.NDArray[Any]
Belief = tuple[Array, Array]

ITERATIONS = 15
START_DOUBT = 1e-9  # m, rad: the first pose is the origin


def _expected(pose: Array, landmark: Array) -> Array:
    dx, dy = landmark - pose[:2]
    return np.array([np.arctan2(dy, dx) - pose[2], np.hypot(dx, dy)])


def _look_slopes(pose: Array, landmark: Array) -> tuple[Array, Array]:
    dx, dy = landmark - pose[:2]
    r = np.hypot(dx, dy)
    by_landmark = np.array([[-dy / r**2, dx / r**2], [dx / r, dy / r]])
    return np.column_stack([-by_landmark, [-1.0, 0.0]]), by_landmark


def odometry(log: list[Any]) -> Belief:
    """Ignore all measurements."""
    motions = [Motion(*control) for control, *_ in log]
    return odometry_belief(Pose(), motions, [Q for _, Q, *_ in log])


def _followed(log: list[Any], joined: bool = True) -> tuple[Array, Array, list[int], list[Array]]:
    """Run the lesson's EKF; a new landmark is correlated with the state, or added without it as in the homework."""
    own, state, P, known, poses = solution("07"), np.zeros(3), np.zeros((3, 3)), list[int](), list[Array]()
    for control, Q, numbers, measurements, R in log:
        state, P = own["predict"](state, P, control, Q, len(known))
        pairs = measurements.reshape(-1, 2)
        again = [j for j, number in enumerate(numbers) if number in known]
        if again:
            indices = [known.index(numbers[j]) for j in again]
            state, P = own["update_landmarks"](state, P, indices, pairs[again].reshape(-1), R)
        for number, measured in zip(numbers, pairs, strict=True):
            if number not in known:
                known.append(number)
                known_before = P
                state, P = own["add_landmark"](state, P, measured, R)
                if not joined:
                    bearing = state[2] + measured[0]
                    c, s, r = np.cos(bearing), np.sin(bearing), measured[1]
                    slopes = np.array([[-r * s, c], [r * c, s]])
                    P = block_diag(known_before, slopes @ R @ slopes.T)
        poses.append(state[:3])
    return state, P, known, poses


def _filter(joined: bool) -> Callable[[list[Any]], Belief]:
    def entry(log: list[Any]) -> Belief:
        state, P, *_ = _followed(log, joined)
        pose = state[:3].copy()
        pose[2] = wrap_angle(pose[2])
        return pose, P[:3, :3]

    return entry


def better(log: list[Any]) -> Belief:
    """Estimate all poses and landmarks at once by repeated linearisation, and return the last pose."""
    state, _, names, followed = _followed(log)
    poses, landmarks, known = (
        np.array(followed),
        state[3:].reshape(-1, 2),
        {n: k for k, n in enumerate(names)},
    )
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
