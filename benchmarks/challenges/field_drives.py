"""Entries of lesson 11's challenge: odometry, the lesson's filter by nearest neighbour and jointly, one smoother."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares

from benchmarks import solution
from nao_course.challenges.beliefs import odometry_belief
from nao_course.field_slam.association import associate_jointly
from nao_course.field_slam.drives import OdometryNoisePerMove
from nao_course.field_slam.observation import CAMERA_HEIGHT, TILT_SIGMAS, picture_covariance
from nao_course.geometry import wrap_angle

Array = npt.NDArray[Any]
Belief = tuple[Array, Array]


def odometry(start: Any, log: list[Any]) -> Belief:
    """Ignore all measurements."""
    motions = [motion for motion, _ in log if motion is not None]
    return odometry_belief(start, motions, [OdometryNoisePerMove().covariance(motion) for motion in motions])


def _entry(name: str, **chosen: Any) -> Callable[..., Belief]:
    def entry(start: Any, log: list[Any]) -> Belief:
        slam = solution("11")[name](start, **chosen)
        for motion, seen in log:
            if motion is not None:
                slam.move(motion)
            slam.observe(seen)
        believed = slam.estimate()
        return believed.pose.as_array(), believed.covariance

    return entry


@dataclass(frozen=True, eq=False)
class _Whole:
    """A drive as one system of equations; its unknowns are all poses, all landmarks, and each picture's lean."""

    start: Array  # (3,): the first pose, which is known
    moves: Array  # (M, 3): what odometry says of each move, and how surely
    sigmas: Array
    pose: Array  # (N,): of which each measurement is
    picture: Array
    landmark: Array
    values: Array  # (N, 2): bearing and 1 / range, and their standard deviations without a lean
    errors: Array

    def split(self, x: Array) -> tuple[Array, Array, Array]:
        """Split the unknowns into poses (M + 1, 3), tilts (P, 2) and landmarks (K, 2)."""
        m, n = 3 * len(self.moves), 2 * (self.picture.max(initial=-1) + 1)
        poses = np.vstack([self.start, x[:m].reshape(-1, 3)])
        return poses, x[m : m + n].reshape(-1, 2), x[m + n :].reshape(-1, 2)

    def __call__(self, x: Array) -> Array:
        """Return all residuals, in standard deviations."""
        poses, leans, landmarks = self.split(x)
        step = np.diff(poses, axis=0)
        c, s = np.cos(poses[:-1, 2]), np.sin(poses[:-1, 2])
        step[:, :2] = np.column_stack([c * step[:, 0] + s * step[:, 1], c * step[:, 1] - s * step[:, 0]])
        step -= self.moves
        step[:, 2] = wrap_angle(step[:, 2])
        away = landmarks[self.landmark] - poses[self.pose, :2]
        bearing = wrap_angle(np.arctan2(away[:, 1], away[:, 0]) - poses[self.pose, 2])
        pitch, roll = leans[self.picture].T
        inverse = 1 / np.maximum(np.hypot(*away.T), 0.05)
        inverse -= (pitch * np.cos(bearing) - roll * np.sin(bearing)) / CAMERA_HEIGHT
        seen = np.column_stack([wrap_angle(self.values[:, 0] - bearing), self.values[:, 1] - inverse])
        return np.concatenate(
            [(step / self.sigmas).ravel(), (seen / self.errors).ravel(), (leans / TILT_SIGMAS).ravel()]
        )


def better(start: Any, log: list[Any]) -> Belief:
    """Take the associations of the reference, and solve for all poses, landmarks and tilts at once."""
    slam = solution("11")["EkfSlam"](start, association=associate_jointly)
    poses, moves, sigmas, rows = [start.as_array()], [], [], []
    for number, (motion, seen) in enumerate(log):
        if motion is not None:
            slam.move(motion)
            moves.append(motion.as_pose().as_array())
            sigmas.append(np.sqrt(np.diag(OdometryNoisePerMove().covariance(motion))))
            poses.append(slam.state[:3])
        slam.observe(seen)
        poses[-1] = slam.state[:3]
        sure = np.sqrt(np.diag(picture_covariance(seen, (0.0, 0.0)))).reshape(-1, 2)
        for i in np.flatnonzero(slam.indices >= 0):
            b, r = seen.values[i]
            rows.append((len(poses) - 1, number, slam.indices[i], b, 1 / r, sure[i, 0], sure[i, 1] / r**2))
    table = np.array(rows)
    whole = _Whole(
        start.as_array(),
        np.array(moves),
        np.array(sigmas),
        *table[:, :3].T.astype(int),
        table[:, 3:5],
        table[:, 5:],
    )
    leans = np.zeros(2 * (whole.picture.max() + 1))
    x = np.concatenate([np.ravel(poses[1:]), leans, slam.state[3:]])
    found = least_squares(whole, x)
    m = 3 * len(moves)
    covariance = np.linalg.inv(found.jac.T @ found.jac)
    return found.x[m - 3 : m], covariance[m - 3 : m, m - 3 : m]


FIELD_ENTRIES = {
    "odometry": odometry,
    "nearest neighbour": _entry("EkfSlam"),
    "the reference": _entry("EkfSlam", association=associate_jointly),
    "a better one": better,
}
