"""Entries of lesson 11's challenge: odometry, the lesson's filter by nearest neighbour and jointly, one smoother."""

from collections.abc import Callable
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


def better(start: Any, log: list[Any]) -> Belief:
    """Take the associations of the reference, and solve for all poses, landmarks and tilts at once."""
    slam = solution("11")["EkfSlam"](start, association=associate_jointly)
    followed, given, rows = [start.as_array()], [], []
    for number, (motion, seen) in enumerate(log):
        if motion is not None:
            slam.move(motion)
            sigmas = np.sqrt(np.diag(OdometryNoisePerMove().covariance(motion)))
            given.append((motion.as_pose().as_array(), sigmas))
            followed.append(slam.state[:3])
        slam.observe(seen)
        followed[-1] = slam.state[:3]
        sure = np.sqrt(np.diag(picture_covariance(seen, (0.0, 0.0)))).reshape(-1, 2)
        for i in np.flatnonzero(slam.indices >= 0):
            b, r = seen.values[i]
            rows.append((len(followed) - 1, number, slam.indices[i], b, 1 / r, sure[i, 0], sure[i, 1] / r**2))
    table, (moves, move_sigmas) = np.array(rows), np.moveaxis(given, 1, 0)
    pose, picture, landmark = table[:, :3].T.astype(int)
    m, n = 3 * len(moves), 2 * (picture.max() + 1)

    def residuals(x: Array) -> Array:
        """Return all residuals, in standard deviations; x has all poses after the first, tilts and landmarks."""
        poses = np.vstack([start.as_array(), x[:m].reshape(-1, 3)])
        tilts, landmarks = x[m : m + n].reshape(-1, 2), x[m + n :].reshape(-1, 2)
        step = np.diff(poses, axis=0)
        c, s = np.cos(poses[:-1, 2]), np.sin(poses[:-1, 2])
        step[:, :2] = np.column_stack([c * step[:, 0] + s * step[:, 1], c * step[:, 1] - s * step[:, 0]])
        step -= moves
        step[:, 2] = wrap_angle(step[:, 2])
        away = landmarks[landmark] - poses[pose, :2]
        bearing = wrap_angle(np.arctan2(away[:, 1], away[:, 0]) - poses[pose, 2])
        pitch, roll = tilts[picture].T
        inverse = 1 / np.maximum(np.hypot(*away.T), 0.05)
        inverse -= (pitch * np.cos(bearing) - roll * np.sin(bearing)) / CAMERA_HEIGHT
        seen = np.column_stack([wrap_angle(table[:, 3] - bearing), table[:, 4] - inverse])
        parts = step / move_sigmas, seen / table[:, 5:], tilts / TILT_SIGMAS
        return np.concatenate([part.ravel() for part in parts])

    found = least_squares(residuals, np.concatenate([np.ravel(followed[1:]), np.zeros(n), slam.state[3:]]))
    covariance = np.linalg.inv(found.jac.T @ found.jac)
    return found.x[m - 3 : m], covariance[m - 3 : m, m - 3 : m]


FIELD_ENTRIES = {
    "odometry": odometry,
    "nearest neighbour": _entry("EkfSlam"),
    "the reference": _entry("EkfSlam", association=associate_jointly),
    "a better one": better,
}
