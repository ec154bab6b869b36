"""Wrappers that make a SLAM algorithm more cautious.

`SurestFirst` changes the order of a stop's pictures. `PruningSlam` estimates the noise of the odometry while it drives,
and it removes landmarks that are not seen again.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
import numpy.typing as npt

from nao_course.field_slam.compass import QUARTER, wrap_quarter
from nao_course.field_slam.observation import Observation, as_observation
from nao_course.geometry import FloatArray
from nao_course.slam import Estimate, LandmarkKind, Measurement, Motion, SlamAlgorithm

SIGHTINGS = 3  # how often a landmark must be observed before it stays on the map for good
PATIENCE = 15  # pictures after its last observation in which a new landmark is kept
# Candidates for the ratio of true to stated standard deviation of the odometry.
FACTORS = (1.0, 1.5, 2.0, 3.0)
OUTLIERS = 0.01  # share of compass readings that have nothing to do with the heading


class SurestFirst(SlamAlgorithm):
    """Update with the pictures of a stop in order of their compass: the smallest standard deviation first.

    After a sharp turn the heading is uncertain by several degrees, and a picture with a single landmark may associate
    it with the wrong one. While the robot stands still, the pictures that measure the heading can come first.

    Parameters
    ----------
    inner : SlamAlgorithm
        Algorithm that is updated with the pictures of a stop when the next motion is commanded. An estimate before
        that is computed by a copy, so the order of the updates does not depend on when estimates are requested.
    """

    def __init__(self, inner: SlamAlgorithm) -> None:
        """Start with an empty list of pictures."""
        self.inner = inner
        self._pictures: list[Observation] = []
        self._updated: SlamAlgorithm | None = None

    def move(self, motion: Motion) -> None:
        """Update with the stop's pictures, then predict."""
        self.inner = self._after_pictures()
        self._pictures, self._updated = [], None
        self.inner.move(motion)

    def observe(self, measurements: Sequence[Measurement]) -> None:
        """Keep a picture until the stop is over."""
        self._pictures.append(as_observation(measurements))
        self._updated = None

    def estimate(self) -> Estimate:
        """Return the estimate after all pictures so far."""
        return self._after_pictures().estimate()

    def _after_pictures(self) -> SlamAlgorithm:
        """Return a copy of the algorithm that is updated with the stop's pictures."""
        if self._updated is None:
            self._updated = deepcopy(self.inner)
            for each in sorted(self._pictures, key=lambda one: one.direction_sigma):
                self._updated.observe(each)
        return self._updated


class Odometry(Protocol):
    """Noise model of the odometry."""

    def covariance(self, motion: Motion) -> FloatArray:
        """Return the covariance (3, 3) of the errors along, across and in turn, m^2 and rad^2."""
        ...


class FieldFilter(Protocol):
    """The interface of a filter that `PruningSlam` wraps; lesson 11's EkfSlam has it."""

    state: FloatArray
    covariance: FloatArray
    kinds: list[LandmarkKind]
    indices: npt.NDArray[np.int64]
    odometry: Odometry

    def move(self, motion: Motion) -> None:
        """Predict the state after a motion."""
        ...

    def observe(self, measurements: Sequence[Measurement]) -> None:
        """Update with a picture."""
        ...

    def estimate(self) -> Estimate:
        """Return the current estimate."""
        ...


class LearntOdometry:
    """Odometry noise with a scale factor that is estimated from the compass readings after each turn.

    Parameters
    ----------
    stated : Odometry
        Noise model whose standard deviations are scaled.
    factors : sequence of float
        Candidates for the scale factor. At first they are equally likely.
    """

    def __init__(self, stated: Odometry, factors: Sequence[float] = FACTORS) -> None:
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
        """Update the probabilities of the factors with one compass reading.

        Parameters
        ----------
        innovation : float
            Measured minus predicted heading after the motion, rad.
        known_variance : float
            Variance of the innovation without the part that the motion causes, rad^2.
        motion : Motion
            Motion before the reading.
        """
        variances = known_variance + self._factors**2 * self.stated.covariance(motion)[2, 2]
        density = np.exp(-0.5 * innovation**2 / variances) / np.sqrt(2 * np.pi * variances)
        self._log_weights = self._log_weights + np.log((1 - OUTLIERS) * density + OUTLIERS / QUARTER)


@dataclass(frozen=True)
class _Move:
    """A motion, with the state and the covariance before it."""

    motion: Motion
    state: FloatArray
    covariance: FloatArray


class PruningSlam(SlamAlgorithm):
    """A filter that estimates the odometry's noise and removes landmarks that are not seen often enough.

    Parameters
    ----------
    inner : FieldFilter
        Filter that is wrapped, such as lesson 11's EkfSlam. Nobody else may use it, because its map shrinks.
    sightings : int
        Number of observations after which a landmark stays for good. With 1, every landmark stays.
    factors : sequence of float
        Candidates for the scale factor of the odometry's standard deviations. With (1.0,), the stated noise is used.
    """

    def __init__(
        self, inner: FieldFilter, sightings: int = SIGHTINGS, factors: Sequence[float] = FACTORS
    ) -> None:
        """Replace the filter's odometry noise by a noise that is estimated during the drive."""
        self.inner, self.odometry = inner, LearntOdometry(inner.odometry, factors)
        inner.odometry = self.odometry
        self._sightings = sightings
        self._last: _Move | None = None
        self._picture = 0
        self._count = np.zeros(0, dtype=int)  # observations of each landmark
        self._last_seen = np.zeros(0, dtype=int)  # number of the picture that showed each landmark last

    def move(self, motion: Motion) -> None:
        """Predict the state after a motion."""
        self._last = _Move(motion, self.inner.state.copy(), self.inner.covariance.copy())
        self.inner.move(motion)

    def observe(self, measurements: Sequence[Measurement]) -> None:
        """Update with a picture, then remove the landmarks that have not been seen again."""
        seen = as_observation(measurements)
        self._learn_odometry(seen)
        self.inner.observe(seen)
        self._count_observations()
        self._remove_landmarks()

    def estimate(self) -> Estimate:
        """Return the current estimate without landmarks that have not been seen often enough."""
        found, kept = self.inner.estimate(), self._count >= self._sightings
        return replace(
            found,
            landmarks=np.asarray(found.landmarks).reshape(-1, 2)[kept],
            landmark_covariances=np.asarray(found.landmark_covariances).reshape(-1, 2, 2)[kept],
            kinds=tuple(kind for kind, keep in zip(found.kinds, kept, strict=True) if keep),
        )

    def _learn_odometry(self, seen: Observation) -> None:
        """Update the odometry noise with the first compass reading after a motion, and repeat the prediction."""
        last, self._last = self._last, None
        if last is None or not np.isfinite(seen.direction_sigma):
            return
        innovation = float(wrap_quarter(-seen.direction - self.inner.state[2]))
        self.odometry.learn(innovation, last.covariance[2, 2] + seen.direction_sigma**2, last.motion)
        self.inner.state, self.inner.covariance = last.state, last.covariance
        self.inner.move(last.motion)

    def _count_observations(self) -> None:
        """Count the picture's observations of each landmark."""
        self._picture += 1
        new = len(self.inner.kinds) - len(self._count)
        self._count, self._last_seen = np.pad(self._count, (0, new)), np.pad(self._last_seen, (0, new))
        shown = np.asarray(self.inner.indices, dtype=int)
        shown = shown[shown >= 0]
        self._count[shown] += 1
        self._last_seen[shown] = self._picture

    def _remove_landmarks(self) -> None:
        """Remove the landmarks that were seen too seldom, and not recently, from state, covariance and indices."""
        kept = (self._count >= self._sightings) | (self._picture - self._last_seen <= PATIENCE)
        if kept.all():
            return
        rows = np.concatenate([np.ones(3, dtype=bool), np.repeat(kept, 2)])
        self.inner.state, self.inner.covariance = self.inner.state[rows], self.inner.covariance[rows][:, rows]
        self.inner.kinds = [kind for kind, keep in zip(self.inner.kinds, kept, strict=True) if keep]
        new_index = np.where(kept, np.cumsum(kept) - 1, -1)
        indices = np.asarray(self.inner.indices, dtype=int)
        self.inner.indices = np.where(indices >= 0, new_index[indices], -1)
        self._count, self._last_seen = self._count[kept], self._last_seen[kept]
