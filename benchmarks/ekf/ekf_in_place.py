"""An EKF for SLAM that changes its covariance where it lies: the fastest of lesson 07's, and not the clearest."""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg.blas import dsyrk

from nao_course.geometry import FloatArray, wrap_angle


class InPlaceFilter:
    """Pose and known landmarks; only the covariance's lower triangle is kept, column by column.

    An update takes W W' off the covariance, with W = P H' inv(L)' and L L' = S: BLAS does that in one pass over half of
    the numbers, without a new array. It begins with a state (3 + 2k,) and a covariance (3 + 2k, 3 + 2k).
    """

    def __init__(self, state: FloatArray, covariance: FloatArray) -> None:
        self.state = np.array(state, dtype=float)
        self._lower = np.array(covariance, dtype=float, order="F")

    @property
    def covariance(self) -> FloatArray:
        """Both triangles, a new array."""
        lower = np.tril(self._lower)
        return lower + np.tril(lower, -1).T

    def predict(self, control: FloatArray, control_covariance: FloatArray) -> None:
        """Move: three columns change."""
        x, y, theta = self.state[:3].tolist()
        distance, turn = control
        c, s = math.cos(theta), math.sin(theta)
        F = np.array([[1.0, 0.0, -distance * s], [0.0, 1.0, distance * c], [0.0, 0.0, 1.0]])
        G = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        self.state[:3] = x + distance * c, y + distance * s, wrap_angle(theta + turn)
        lower, pose = self._lower, self._columns([0, 1, 2])[:3]
        lower[3:, :3] = lower[3:, :3] @ F.T
        lower[:3, :3] = F @ pose @ F.T + G @ control_covariance @ G.T

    def update_landmark(
        self, index: int, measurement: FloatArray, measurement_covariance: FloatArray
    ) -> None:
        """Take one (bearing, range) in: one pass over the lower triangle."""
        at = 3 + 2 * index
        x, y, theta, lx, ly = self.state[[0, 1, 2, at, at + 1]].tolist()
        dx, dy = lx - x, ly - y
        r = math.hypot(dx, dy)
        u, v = dx / r, dy / r
        H = np.array([[v / r, -u / r, -1.0, -v / r, u / r], [-u, -v, 0.0, u, v]])
        surprise = np.array([wrap_angle(measurement[0] - math.atan2(dy, dx) + theta), measurement[1] - r])
        columns = [0, 1, 2, at, at + 1]
        shared = self._columns(columns) @ H.T
        root = np.linalg.inv(np.linalg.cholesky(H @ shared[columns] + measurement_covariance))
        W = shared @ root.T
        self.state += W @ (root @ surprise)
        self.state[2] = wrap_angle(self.state[2])
        self._lower = dsyrk(-1.0, W, beta=1.0, c=self._lower, overwrite_c=1, lower=1)

    def _columns(self, numbers: list[int]) -> FloatArray:
        """Return columns of the whole covariance, (n, len(numbers))."""
        found = np.empty((len(self.state), len(numbers)))
        for to, column in enumerate(numbers):
            found[:column, to] = self._lower[column, :column]
            found[column:, to] = self._lower[column:, column]
        return found
