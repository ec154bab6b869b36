"""Entries of lesson 07's challenge: odometry, the homework's start, the reference, and a smoother of all of it."""

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.linalg import block_diag
from scipy.optimize import least_squares

from benchmarks import solution
from nao_course.challenges.beliefs import odometry_belief
from nao_course.geometry import Pose, wrap_angle
from nao_course.slam import Motion

Array = npt.NDArray[Any]
Belief = tuple[Array, Array]
STEP = 1e-6  # of the unknowns, for derivatives


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
    moves = np.array([control for control, *_ in log[1:]])
    to_sigmas = [np.linalg.inv(np.linalg.cholesky(Q)) for _, Q, *_ in log[1:]]
    pose = np.repeat(np.arange(len(log)), [len(numbers) for _, _, numbers, *_ in log])
    landmark = [names.index(number) for _, _, numbers, *_ in log for number in numbers]
    seen = np.concatenate([measurements.reshape(-1, 2) for *_, measurements, _ in log])
    roots = np.array([np.linalg.inv(np.linalg.cholesky(R)) for *_, R in log])[pose]

    def residuals(x: Array) -> Array:
        """Return all residuals (..., M) of unknowns (..., N), in standard deviations; the first pose is the origin."""
        poses = np.pad(x[..., : 3 * len(moves)], [*[(0, 0)] * (x.ndim - 1), (3, 0)]).reshape(
            *x.shape[:-1], -1, 3
        )
        landmarks = x[..., 3 * len(moves) :].reshape(*x.shape[:-1], -1, 2)
        dx, dy, turn = np.moveaxis(np.diff(poses, axis=-2), -1, 0)
        c, s = np.cos(poses[..., :-1, 2]), np.sin(poses[..., :-1, 2])
        along, across = c * dx + s * dy - moves[:, 0], c * dy - s * dx
        step = np.stack([along, across, wrap_angle(turn - moves[:, 1])], axis=-1)
        dx, dy = np.moveaxis(landmarks[..., landmark, :] - poses[..., pose, :2], -1, 0)
        bearing = wrap_angle(seen[:, 0] - np.arctan2(dy, dx) + poses[..., pose, 2])
        off = np.stack([bearing, seen[:, 1] - np.hypot(dx, dy)], axis=-1)
        weighted = np.einsum("nij,...nj->...ni", to_sigmas, step), np.einsum("nij,...nj->...ni", roots, off)
        return np.concatenate([each.reshape(*x.shape[:-1], -1) for each in weighted], axis=-1)

    def jacobian(x: Array) -> Array:
        return (residuals(x + STEP * np.eye(len(x))) - residuals(x)).T / STEP

    x = np.concatenate([np.ravel(followed[1:]), state[3:]])
    found = least_squares(residuals, x, jacobian, x_scale="jac")
    last = slice(3 * len(moves) - 3, 3 * len(moves))
    x, y, heading = found.x[last]
    return np.array([x, y, wrap_angle(heading)]), np.linalg.inv(found.jac.T @ found.jac)[last, last]


EKF_ENTRIES = {
    "odometry": odometry,
    "the homework's start": _filter(joined=False),
    "the reference": _filter(joined=True),
    "a better one": better,
}
