"""Wariness: the surest picture first, odometry's noise learnt, landmarks that lapse."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray
from nao_course.lessons.slam_on_the_field.system.compass import QUARTER, wrap_quarter
from nao_course.lessons.slam_on_the_field.system.observation import Observation, as_observation
from nao_course.slam import Estimate, LandmarkKind, Measurement, Motion, SlamAlgorithm

SIGHTINGS, PATIENCE = (
    3,
    15,
)  # a landmark stays that is seen so often; so many pictures may pass before the next time
FACTORS = (1.0, 1.5, 2.0, 3.0)  # how much worse than told odometry may be
OUTLIERS = 0.01  # share of compass readings that have nothing to do with the heading


class SurestFirst(SlamAlgorithm):
    """Takes in a stop's pictures in another order: the surest compass first, those without one last.

    After a sharp turn the heading is in doubt by several degrees, and a picture with a single landmark may take it for
    another. A robot that stands still may read first what tells its heading.

    Parameters
    ----------
    inner : SlamAlgorithm
        Gets the pictures of a stop when the next command comes, or an estimate is asked for.
    """

    def __init__(self, inner: SlamAlgorithm) -> None:
        """Begin with nothing seen."""
        self.inner = inner
        self._seen: list[Observation] = []

    def move(self, motion: Motion) -> None:
        """Take in the stop that is left, and the command."""
        self._take_in()
        self.inner.move(motion)

    def observe(self, measurements: Sequence[Measurement]) -> None:
        """Keep a picture until the stop is over."""
        self._seen.append(as_observation(measurements))

    def estimate(self) -> Estimate:
        """Return what is believed after all that was seen."""
        self._take_in()
        return self.inner.estimate()

    def _take_in(self) -> None:
        seen, self._seen = self._seen, []
        for each in sorted(seen, key=lambda one: one.direction_sigma):
            self.inner.observe(each)


class Odometry(Protocol):
    """How surely a motion is known."""

    def covariance(self, motion: Motion) -> FloatArray:
        """Covariance (3, 3) of (along, across, turn)."""
        ...


class FieldFilter(Protocol):
    """What `CarefulSlam` needs to know of a filter; lesson 11's EkfSlam is one."""

    state: FloatArray
    covariance: FloatArray
    kinds: list[LandmarkKind]
    indices: npt.NDArray[np.int64]
    odometry: Odometry

    def move(self, motion: Motion) -> None:
        """Take in a command."""
        ...

    def observe(self, measurements: Sequence[Measurement]) -> None:
        """Take in a picture."""
        ...

    def estimate(self) -> Estimate:
        """Return what is believed now."""
        ...


class LearntOdometry:
    """Odometry that is worse than told by a factor, which the compass shows from move to move.

    Parameters
    ----------
    told : Odometry
        As it is said to be.
    factors : sequence of float
        How much worse it may be.
    """

    def __init__(self, told: Odometry, factors: Sequence[float] = FACTORS) -> None:
        """Hold all factors for equally likely."""
        self.told, self._factors = told, np.array(factors, dtype=float)
        self._logs = np.zeros(len(self._factors))

    @property
    def factor(self) -> float:
        """The factor to reckon with: the root of its square's mean."""
        weights = np.exp(self._logs - self._logs.max())
        return float(np.sqrt(weights @ self._factors**2 / weights.sum()))

    def covariance(self, motion: Motion) -> FloatArray:
        """Covariance (3, 3) of (along, across, turn) for a motion, in the robot frame; m^2 and rad^2."""
        return np.asarray(self.factor**2 * self.told.covariance(motion))

    def learn(self, innovation: float, known: float, motion: Motion) -> None:
        """Weigh the factors by a turn: its error as the compass shows it (rad), what else errs there (rad^2)."""
        variances = known + self._factors**2 * self.told.covariance(motion)[2, 2]
        density = np.exp(-0.5 * innovation**2 / variances) / np.sqrt(2 * np.pi * variances)
        self._logs = self._logs + np.log((1 - OUTLIERS) * density + OUTLIERS / QUARTER)


@dataclass(frozen=True)
class _Move:
    """A motion, and what was believed before it."""

    motion: Motion
    state: FloatArray
    covariance: FloatArray


class CarefulSlam(SlamAlgorithm):
    """A filter with doubts: about odometry, and about landmarks until they were seen three times.

    Parameters
    ----------
    inner : FieldFilter
        Lesson 11's EkfSlam, or one like it. It is used from here alone: its map shrinks.
    sightings : int
        How often a landmark must be seen to stay; 1: each stays.
    factors : sequence of float
        How much worse than told odometry may be; (1.0,): it is as told.
    """

    def __init__(
        self, inner: FieldFilter, sightings: int = SIGHTINGS, factors: Sequence[float] = FACTORS
    ) -> None:
        """Begin where the filter is."""
        self.inner, self.odometry = inner, LearntOdometry(inner.odometry, factors)
        inner.odometry = self.odometry
        self._sightings = sightings
        self._last: _Move | None = None
        self._picture = 0
        self._seen = np.zeros(0, dtype=int)  # how often each landmark was
        self._when = np.zeros(0, dtype=int)  # the picture in which it was last

    def move(self, motion: Motion) -> None:
        """Take in a command."""
        self._last = _Move(motion, self.inner.state.copy(), self.inner.covariance.copy())
        self.inner.move(motion)

    def observe(self, measurements: Sequence[Measurement]) -> None:
        """Take in a picture."""
        seen = as_observation(measurements)
        self._doubt_odometry(seen)
        self.inner.observe(seen)
        self._count()
        self._forget()

    def estimate(self) -> Estimate:
        """Return what is believed now; landmarks that were not seen often enough are left out."""
        found, sure = self.inner.estimate(), self._seen >= self._sightings
        kinds = tuple(kind for kind, kept in zip(found.kinds, sure, strict=True) if kept)
        return replace(
            found,
            landmarks=np.asarray(found.landmarks).reshape(-1, 2)[sure],
            landmark_covariances=np.asarray(found.landmark_covariances).reshape(-1, 2, 2)[sure],
            kinds=kinds,
        )

    def _doubt_odometry(self, seen: Observation) -> None:
        """Let the first picture after a move tell how far off its turn was, and take the move in again."""
        last, self._last = self._last, None
        if last is None or not np.isfinite(seen.direction_sigma):
            return
        innovation = float(wrap_quarter(-seen.direction - self.inner.state[2]))
        self.odometry.learn(innovation, last.covariance[2, 2] + seen.direction_sigma**2, last.motion)
        self.inner.state, self.inner.covariance = last.state, last.covariance
        self.inner.move(last.motion)

    def _count(self) -> None:
        """Note which landmarks the picture shows."""
        self._picture += 1
        new = len(self.inner.kinds) - len(self._seen)
        self._seen, self._when = np.pad(self._seen, (0, new)), np.pad(self._when, (0, new))
        shown = np.asarray(self.inner.indices, dtype=int)
        shown = shown[shown >= 0]
        self._seen[shown] += 1
        self._when[shown] = self._picture

    def _forget(self) -> None:
        """Drop what was seen too seldom, and not of late."""
        gone = (self._seen < self._sightings) & (self._picture - self._when > PATIENCE)
        if not gone.any():
            return
        rows = np.concatenate([np.ones(3, dtype=bool), np.repeat(~gone, 2)])
        self.inner.state, self.inner.covariance = self.inner.state[rows], self.inner.covariance[rows][:, rows]
        self.inner.kinds = [kind for kind, lost in zip(self.inner.kinds, gone, strict=True) if not lost]
        number = np.where(gone, -1, np.cumsum(~gone) - 1)
        indices = np.asarray(self.inner.indices, dtype=int)
        self.inner.indices = np.where(indices >= 0, number[indices], -1)
        self._seen, self._when = self._seen[~gone], self._when[~gone]
