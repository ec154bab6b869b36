"""Two localizations on the known map, as robots on the field use them: baselines without SLAM.

References
----------
D. Fox, *Adapting the sample size in particle filters through KLD-sampling*, The International Journal of Robotics
Research 22, 2003.
J.-S. Gutmann, D. Fox, *An experimental comparison of localization methods continued*, IROS 2002: the factor FALLEN.
S. Thrun, W. Burgard, D. Fox, *Probabilistic Robotics*, MIT Press, 2005: section 8.3.7, augmented MCL.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.stats import chi2, norm

from benchmarks import solution
from benchmarks.field.detections import LANDMARKS
from nao_course.field_slam.adaptive_noise import OdometryModel
from nao_course.field_slam.compass import QUARTER, reading_density, wrap_quarter
from nao_course.field_slam.drives import OdometryNoisePerMove
from nao_course.field_slam.observation import Observation, as_observation
from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.sim import Field
from nao_course.slam import Estimate, Measurement, Motion, SlamAlgorithm, range_and_bearing

MEASURED = [mark for mark in LANDMARKS if mark.kind != "cross"]
PLACES, KINDS = np.array([(mark.x, mark.y) for mark in MEASURED]), np.array([mark.kind for mark in MEASURED])
GATE = float(np.sqrt(chi2.ppf(0.99, 2)))
LOW, HIGH = np.transpose([Field(2012).x_range, Field(2012).y_range])
# Of KLD sampling: m, m and rad of a bin, largest divergence, and the probability that it is not exceeded.
BIN, DIVERGENCE, CONFIDENCE = np.array([0.1, 0.1, np.radians(10)]), 0.05, 0.99
LEAST, MOST = 300, 5000  # particles
SLOW, FAST = 0.005, 0.1  # rates of the averages of the fit, per picture
FALLEN = 2.0  # random particles are added if the fast average is so many times smaller than the slow one
# m, m and rad: noise of drawn particles, against impoverishment
ROUGH = np.array([0.01, 0.01, np.radians(0.5)])
FALSE = 0.05  # least factor of a measurement, which may be of no landmark
NEAR = (0.5, 0.5)  # m and rad: the estimate is of the particles so near to the median
EKF: Any = solution("11")["EkfSlam"]


class GatedEkf(EKF):
    """An EKF on the known map: each measurement belongs to the nearest landmark inside a chi-square gate of 99 %."""

    def __init__(self, start: Pose) -> None:
        """Start with a certain pose and map."""
        super().__init__(start, gate=GATE)
        self.state = np.concatenate([self.state, PLACES.ravel()])
        self.covariance, self.kinds = np.zeros((len(self.state), len(self.state))), KINDS.tolist()

    def number(self, seen: Observation) -> None:
        """Associate the measurements, and add no landmark."""
        belief = self.state, self.covariance, tuple(self.kinds)
        self.indices = np.array(self.association(*belief, seen, seen.covariance, self.gate), dtype=int)


def kld_bound(bins: npt.ArrayLike) -> FloatArray:
    """Return how many particles keep the KL divergence below DIVERGENCE if they fill some bins (...); Fox, eq. 7."""
    k = np.maximum(np.asarray(bins, dtype=float) - 1, 1e-9)
    spread = 2 / (9 * k)
    cube = np.maximum(1 - spread + np.sqrt(spread) * norm.ppf(CONFIDENCE), 0) ** 3
    return np.where(k < 1, 1.0, k / (2 * DIVERGENCE) * cube)


class MonteCarlo(SlamAlgorithm):
    """Augmented Monte Carlo localization on the known map, with as many particles as KLD sampling asks for."""

    def __init__(self, start: Pose, odometry: OdometryModel | None = None, least: int = LEAST) -> None:
        """Start with all particles at a pose."""
        self.particles = np.tile(start.as_array(), (least, 1))
        self.odometry, self.least = odometry or OdometryNoisePerMove(), least
        self.rng = np.random.default_rng(0)
        self.slow = self.fast = 0.0

    def move(self, motion: Motion) -> None:
        """Move each particle with its own error."""
        errors = self.rng.standard_normal(self.particles.shape) * np.sqrt(
            np.diag(self.odometry.covariance(motion))
        )
        ahead, left, turn = (errors + [motion.distance, 0.0, motion.turn]).T
        x, y, theta = self.particles.T
        c, s = np.cos(theta), np.sin(theta)
        self.particles = np.column_stack(
            [x + c * ahead - s * left, y + s * ahead + c * left, wrap_angle(theta + turn)]
        )

    def observe(self, measurements: Sequence[Measurement]) -> None:
        """Weigh the particles, add random ones if they have come to fit worse, and draw anew by KLD sampling."""
        seen = as_observation(measurements)
        log_weights, fits = self._log_weights(seen)
        weights = np.exp(log_weights - log_weights.max())
        weights /= weights.sum()
        if len(seen):
            fit = float(weights @ fits)  # without the weights, random particles would call for more of them
            self.slow += (SLOW if self.slow else 1.0) * (fit - self.slow)
            self.fast += (FAST if self.fast else 1.0) * (fit - self.fast)
        drawn = self.particles[self.rng.choice(len(weights), MOST, p=weights)]
        drawn = drawn + ROUGH * self.rng.standard_normal(drawn.shape)
        lost = 1 - FALLEN * self.fast / self.slow if len(seen) and self.slow else 0.0
        anew = self.rng.random(MOST) < lost
        drawn[anew] = self._anywhere(int(anew.sum()), seen)
        _, first = np.unique(np.floor(drawn / BIN), axis=0, return_index=True)
        filled = np.cumsum(np.isin(np.arange(MOST), first))
        enough = np.arange(1, MOST + 1) >= np.maximum(kld_bound(filled), self.least)
        self.particles = drawn[: int(enough.argmax()) + 1 if enough.any() else MOST]

    def estimate(self) -> Estimate:
        """Return the mean and covariance of the particles near the median."""
        x, y, theta = self.particles.T
        mean = np.angle(np.exp(1j * theta).mean())
        around = np.column_stack([x, y, wrap_angle(theta - mean)])
        off = np.abs(around - np.median(around, axis=0))
        near = around[(np.hypot(off[:, 0], off[:, 1]) <= NEAR[0]) & (off[:, 2] <= NEAR[1])]
        near = near if len(near) > 1 else around
        pose = near.mean(axis=0) + [0.0, 0.0, mean]
        return Estimate(Pose.from_array(pose), np.cov(near.T), np.empty((0, 2)), np.empty((0, 2, 2)))

    def _log_weights(self, seen: Observation) -> tuple[FloatArray, FloatArray]:
        """Return a picture's log weight and its mean fit for each particle (N,).

        A measurement fits with exp(-d^2 / 2), where d is its Mahalanobis distance from the nearest landmark.
        """
        total, fits = np.zeros((2, len(self.particles)))
        if np.isfinite(seen.direction_sigma):
            off = wrap_quarter(-seen.direction - self.particles[:, 2])
            total += np.log(reading_density(off, seen.direction_sigma**2))
        if not len(seen):
            return total, fits
        expected = range_and_bearing(self.particles[:, None], PLACES)
        for one, value, R in zip(seen, *seen.decorrelated(seen.values[:, 1]), strict=True):
            nu = value - expected[:, one.kind == KINDS]
            nu[..., 0] = wrap_angle(nu[..., 0])
            square = np.einsum("nki,ij,nkj->nk", nu, np.linalg.inv(R), nu).min(axis=1)
            near = np.exp(-0.5 * square)
            total += np.log((1 - FALSE) * near + FALSE)
            fits += near / len(seen)
        return total, fits

    def _anywhere(self, count: int, seen: Observation) -> FloatArray:
        """Return random poses (count, 3) on the field, with one of the compass's four headings if there is one."""
        theta = self.rng.uniform(-np.pi, np.pi, count)
        if np.isfinite(seen.direction_sigma):
            theta = -seen.direction + QUARTER * self.rng.integers(4, size=count)
        return np.column_stack([self.rng.uniform(LOW, HIGH, (count, 2)), wrap_angle(theta)])
