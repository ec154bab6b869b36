"""Odometry noise whose scale is estimated while the robot drives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from nao_course.field_slam.compass import reading_density
from nao_course.geometry import FloatArray
from nao_course.slam import Motion

# Candidates for the ratio of true to stated standard deviation of the odometry.
FACTORS = (1.0, 1.5, 2.0, 3.0)


class OdometryModel(Protocol):
    """Noise model of the odometry."""

    def covariance(self, motion: Motion) -> FloatArray:
        """Return the covariance (3, 3) of the errors along, across and in turn, m^2 and rad^2."""
        ...


class AdaptiveOdometryNoise:
    """Odometry noise with a scale factor that is estimated from the compass readings after each turn.

    `stated` is the model whose standard deviations are scaled; its candidate factors are equally likely at first.
    """

    def __init__(self, stated: OdometryModel, factors: Sequence[float] = FACTORS) -> None:
        """Give all factors the same probability."""
        self.stated, self._factors = stated, np.array(factors, dtype=float)
        self._log_weights = np.zeros(len(self._factors))

    @property
    def factor(self) -> float:
        """Root of the mean squared factor, weighted by the factors' probabilities."""
        weights = np.exp(self._log_weights - self._log_weights.max())
        return float(np.sqrt(weights @ self._factors**2 / weights.sum()))

    def covariance(self, motion: Motion) -> FloatArray:
        """Return the scaled covariance (3, 3) of the errors along, across and in turn; robot frame, m^2 and rad^2."""
        return np.asarray(self.factor**2 * self.stated.covariance(motion))

    def learn(self, innovation: float, known_variance: float, motion: Motion) -> None:
        """Update the probabilities of the factors with one compass reading after a motion.

        The innovation is measured minus predicted heading, rad; `known_variance` is its variance without the part that
        the motion causes, rad^2.
        """
        variances = known_variance + self._factors**2 * self.stated.covariance(motion)[2, 2]
        self._log_weights = self._log_weights + np.log(reading_density(innovation, variances))
