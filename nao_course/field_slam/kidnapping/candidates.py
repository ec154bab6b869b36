"""Poses where a robot may be that was carried away, in closed form from a measurement and a landmark of its kind."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from nao_course.field_slam.compass import QUARTER, reading_density, wrap_quarter
from nao_course.field_slam.likelihood import KnownMap, PositionLikelihood
from nao_course.field_slam.line_observation import StopView
from nao_course.geometry import FloatArray, rotation_2d, wrap_angle
from nao_course.slam import Motion

SAME = 0.1  # m: nearer candidates with the same heading are one
MOST = 16  # candidates with each heading that all measurements correct, and candidates after a stop
AROUND = 4  # positions along each axis at which the likelihood of a stop without any match is averaged
COMPASS_OUTLIERS = 0.02  # probability that the compass is wrong

Area = tuple[tuple[float, float], tuple[float, float]]


@dataclass(frozen=True, eq=False)
class Candidates:
    """Gaussian hypotheses about the pose of a robot that may be anywhere in an area.

    The area is its lower left and its upper right corner, m, map frame. The candidates are at positions (n, 2), with
    covariances (n, 2, 2), and their headings are `quarters` (n,) turns of 90 degrees from `heading` (rad) on.
    `heading_sigma` (rad) holds if the quarter is known, and is infinite before the first compass. The first of the
    probabilities (1 + n,) is of all other poses in the area; their sum may be less than 1.
    """

    area: Area
    positions: FloatArray
    covariances: FloatArray
    quarters: npt.NDArray[np.int64]
    probabilities: FloatArray
    heading: float = 0.0
    heading_sigma: float = float("inf")

    @classmethod
    def none(cls, area: Area) -> Candidates:
        """Return no candidates."""
        return cls(area, np.zeros((0, 2)), np.zeros((0, 2, 2)), np.zeros(0, dtype=int), np.zeros(1))

    @property
    def total(self) -> float:
        """Sum of all probabilities."""
        return float(self.probabilities.sum())

    @property
    def poses(self) -> FloatArray:
        """Pose of each candidate, shape (n, 3), m and rad."""
        return np.column_stack([self.positions, self.heading + self.quarters * QUARTER])

    def moved(self, motion: Motion, noise: FloatArray) -> Candidates:
        """Return the candidates after a motion with a covariance (3, 3) along, across and in turn, m^2 and rad^2."""
        R = np.array([rotation_2d(theta) for theta in self.poses[:, 2]]).reshape(-1, 2, 2)
        own = noise[:2, :2] + np.diag([0.0, motion.distance**2 * min(self.heading_sigma, 1.0) ** 2])
        return replace(
            self,
            positions=self.positions + motion.distance * R[:, :, 0],
            covariances=self.covariances + R @ own @ R.mT,
            heading=self.heading + motion.turn,
            heading_sigma=float(np.hypot(self.heading_sigma, np.sqrt(noise[2, 2]))),
        )

    def aligned(self, stop: StopView) -> Candidates:
        """Return the candidates with the headings of a stop's compass, weighted by how well these agree with theirs."""
        difference = float(wrap_quarter(stop.heading - self.heading))
        factor = compass_likelihood(difference, self.heading_sigma**2 + stop.heading_sigma**2)
        probabilities = self.probabilities * np.append(1.0, np.full(len(self.positions), factor))
        heading = self.heading + difference
        return replace(self, probabilities=probabilities, heading=heading, heading_sigma=stop.heading_sigma)

    def updated(self, stop: StopView, known: KnownMap, added: float) -> tuple[Candidates, FloatArray]:
        """Return the candidates after a stop, and the log probabilities (1 + n,) of all, which do not add up to 1.

        The probability `added` belongs to no candidate before the stop. New candidates are where single measurements
        put the robot, corrected by all measurements. Each takes its share, by Laplace's approximation, of the first
        probability, which all poses in the area had together.
        """
        corners = np.array(self.area)
        around = np.stack(np.meshgrid(*np.linspace(corners[0], corners[1], AROUND).T), axis=-1).reshape(-1, 2)
        with np.errstate(divide="ignore"):
            prior = np.log(self.probabilities + np.eye(1, len(self.probabilities))[0] * added)
        uniform = prior[0] - np.log(4 * np.prod(corners[1] - corners[0]))
        parts, logs, nothing = [], [], []
        for quarter in range(4):
            likelihood = PositionLikelihood(stop, known, self.heading + quarter * QUARTER)
            nothing.append(likelihood.missed(around))
            old = self.quarters == quarter
            mean, information = self.positions[old], np.linalg.inv(self.covariances[old])
            at, Q, evidence = likelihood.fit(mean, mean, information)
            starts = likelihood.positions
            likely = np.argsort(-likelihood.log_likelihood(starts), kind="stable")[:MOST]
            new, new_Q, new_evidence = likelihood.fit(starts[likely])
            inside = ((new > corners[0]) & (new < corners[1])).all(axis=1)
            at, Q = np.vstack([at, new[inside]]), np.concatenate([Q, new_Q[inside]])
            each = np.append(prior[1:][old] + evidence, uniform + new_evidence[inside])
            chosen = _distinct(at, each)
            parts.append((at[chosen], np.linalg.inv(Q[chosen]), np.full(len(chosen), quarter)))
            logs.append(each[chosen])
        log, first = np.concatenate(logs), prior[0] + np.log(np.mean(np.exp(nothing)))
        best = np.argsort(-log, kind="stable")[:MOST]
        positions, covariances, quarters = (np.concatenate(part)[best] for part in zip(*parts, strict=True))
        found = replace(self, positions=positions, covariances=covariances, quarters=quarters)
        return found, np.append(first, log[best])

    def covariance(self, mean: FloatArray) -> FloatArray:
        """Return the mean square (3, 3) of the deviations of all candidates from a pose (3,), m^2 and rad^2."""
        deviation = self.poses - mean
        deviation[:, 2] = wrap_angle(deviation[:, 2])
        weights = self.probabilities[1:] / self.probabilities[1:].sum()
        found = (weights[:, None] * deviation).T @ deviation
        found[:2, :2] += np.tensordot(weights, self.covariances, 1)
        found[2, 2] += self.heading_sigma**2
        return np.asarray(found)


def _distinct(positions: FloatArray, logs: FloatArray) -> npt.NDArray[np.int64]:
    """Return the numbers of the most probable candidates of each place, the most probable first."""
    kept: list[int] = []
    for i in np.argsort(-logs, kind="stable").tolist():
        if (np.hypot(*(positions[kept] - positions[i]).T) > SAME).all():
            kept.append(i)
    return np.array(kept, dtype=int)


def compass_likelihood(innovation: float, variance: float) -> float:
    """Return the likelihood of a compass reading relative to a reading in any direction."""
    if not np.isfinite(variance):
        return 1.0
    return QUARTER * float(reading_density(innovation, variance, COMPASS_OUTLIERS))
