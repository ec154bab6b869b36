"""Samples sent through a student's function, and the Gaussian that the linearisation predicts for them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, wrap_angle

Function = Callable[..., Any]

SAMPLES = 500


@dataclass(frozen=True, eq=False)
class Cloud:
    """Samples after a function, and the Gaussian that a linearisation predicts for them.

    Each point (N, 2) is a position in metres, or bearing (rad) and range (m). `mean` (2,) is the function's value at
    the input's mean, and `covariance` (2, 2) is what the Jacobians predict.
    """

    points: FloatArray
    mean: FloatArray
    covariance: FloatArray

    @property
    def sampled_mean(self) -> FloatArray:
        """Mean of the samples, shape (2,)."""
        return np.asarray(self.points.mean(axis=0))

    @property
    def sampled_covariance(self) -> FloatArray:
        """Covariance of the samples, shape (2, 2)."""
        return np.cov(self.points.T)

    @property
    def shift(self) -> FloatArray:
        """The samples' mean minus the predicted mean, shape (2,)."""
        return self.sampled_mean - self.mean

    def inside(self, probability: float = 0.95) -> float:
        """Return the share of samples inside the ellipse that should hold the share `probability`."""
        away = self.points - self.mean
        squared = np.einsum("ni,ij,nj->n", away, np.linalg.pinv(self.covariance), away)
        return float(np.mean(squared <= -2 * np.log1p(-probability)))


def draw(mean: npt.ArrayLike, covariance: npt.ArrayLike, number: int, rng: np.random.Generator) -> FloatArray:
    """Draw samples (number, K) of a Gaussian with a mean (K,) and a covariance (K, K)."""
    values, axes = np.linalg.eigh(np.asarray(covariance, dtype=float))
    root = axes * np.sqrt(np.maximum(values, 0.0))
    return np.asarray(mean, dtype=float) + rng.standard_normal((number, len(values))) @ root.T


def each_moved(
    predict_pose: Function, poses: FloatArray, control: npt.ArrayLike, noise: FloatArray
) -> FloatArray:
    """Move poses (N, 3) by a control (2,), each with its own errors (N, 3): along, across (m) and turn (rad)."""
    distance, turn = np.asarray(control, dtype=float)
    controls = np.column_stack([distance + noise[:, 0], turn + noise[:, 2]])
    ends = np.array(
        [np.asarray(predict_pose(*pair), dtype=float) for pair in zip(poses, controls, strict=True)]
    )
    ends[:, :2] += noise[:, 1:2] * np.column_stack([-np.sin(poses[:, 2]), np.cos(poses[:, 2])])
    return ends


def motion_cloud(
    predict_pose: Function,
    predict_covariance: Function,
    pose: npt.ArrayLike,
    covariance: npt.ArrayLike,
    control: npt.ArrayLike,
    control_covariance: npt.ArrayLike,
    rng: np.random.Generator,
    number: int = SAMPLES,
) -> Cloud:
    """Return the positions (x, y), in metres, of robots that move from poses drawn from a Gaussian.

    Pose (3,) and control (2,) are in m and rad; the covariances (3, 3) are of the pose, and of the motion errors
    (along, across, turn) in the robot frame.
    """
    pose, control = np.array(pose, dtype=float), np.array(control, dtype=float)
    poses = draw(pose, covariance, number, rng)
    ends = each_moved(predict_pose, poses, control, draw(np.zeros(3), control_covariance, number, rng))
    mean = np.asarray(predict_pose(pose.copy(), control.copy()), dtype=float)
    predicted = predict_covariance(np.array(covariance), pose, control, np.array(control_covariance))
    return Cloud(ends[:, :2], mean[:2], np.asarray(predicted, dtype=float)[:2, :2])


def landmark_cloud(
    landmark_position: Function,
    landmark_jacobians: Function,
    covariance: npt.ArrayLike,
    measurement: npt.ArrayLike,
    measurement_covariance: npt.ArrayLike,
    rng: np.random.Generator,
    number: int = SAMPLES,
) -> Cloud:
    """Return a landmark's positions (x, y), in m, for uncertain poses at (0, 0, 0) and a noisy (bearing, range)."""
    pose, measurement = np.zeros(3), np.array(measurement, dtype=float)
    poses = draw(pose, covariance, number, rng)
    measured = draw(measurement, measurement_covariance, number, rng)
    points = np.array([landmark_position(*pair) for pair in zip(poses, measured, strict=True)], dtype=float)
    by_pose, by_measurement = (np.asarray(each) for each in landmark_jacobians(pose, measurement))
    predicted = propagated(by_pose, covariance) + propagated(by_measurement, measurement_covariance)
    return Cloud(points, np.asarray(landmark_position(pose, measurement), dtype=float), predicted)


def measurement_cloud(
    expected_measurement: Function,
    measurement_jacobian_pose: Function,
    covariance: npt.ArrayLike,
    landmark: npt.ArrayLike,
    rng: np.random.Generator,
    number: int = SAMPLES,
) -> Cloud:
    """Compute the expected measurement of a landmark (2,) from uncertain poses around (0, 0, 0).

    Bearings (rad) are within half a turn of the mean's; ranges are in m.
    """
    pose, landmark = np.zeros(3), np.array(landmark, dtype=float)
    mean = np.asarray(expected_measurement(pose, landmark), dtype=float)
    poses = draw(pose, covariance, number, rng)
    points = np.array([expected_measurement(each, landmark.copy()) for each in poses], dtype=float)
    points[:, 0] = mean[0] + wrap_angle(points[:, 0] - mean[0])
    return Cloud(points, mean, propagated(np.asarray(measurement_jacobian_pose(pose, landmark)), covariance))


def propagated(jacobian: FloatArray, covariance: npt.ArrayLike) -> FloatArray:
    """Return the covariance (R, R) of a covariance (C, C) after a linear map (R, C)."""
    root = np.linalg.cholesky(
        np.asarray(covariance, dtype=float) + 1e-18 * np.eye(len(np.asarray(covariance)))
    )
    half = jacobian @ root
    return np.asarray(half @ half.T)
