"""Which landmark each measurement of a picture shows, judged together: joint compatibility, by branch and bound.

References
----------
J. Neira, J. D. Tardos, *Data association in stochastic mapping using the joint compatibility test*, IEEE Transactions
on Robotics and Automation 17, 2001.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache

import numpy as np
import numpy.typing as npt
from scipy.special import chdtrc, chdtri

from nao_course.exercises.codec import register
from nao_course.geometry import FloatArray, wrap_angle
from nao_course.slam import LandmarkKind, Measurement

NEW = -1
MOST_TRIED = 2000  # hypotheses of a picture: enough for any that a camera of 61 degrees can see
IntArray = npt.NDArray[np.int64]


@register
def associate_jointly(
    state: FloatArray,
    covariance: FloatArray,
    kinds: Sequence[LandmarkKind],
    measurements: Sequence[Measurement],
    measurement_covariance: FloatArray,
    gate: float,
) -> IntArray:
    """Find the largest set of pairs of measurements and landmarks that fit together, of those the nearest.

    Parameters
    ----------
    state : ndarray, shape (3 + 2n,)
        Pose and landmarks, m and rad.
    covariance : ndarray, shape (3 + 2n, 3 + 2n)
        Of it.
    kinds : sequence of str
        Of the n landmarks.
    measurements : sequence of Measurement
        k of one picture.
    measurement_covariance : ndarray, shape (2k, 2k)
        Of bearing and range of each in turn; what moves all of them together is in it.
    gate : float
        Standard deviations: a pair's largest Mahalanobis distance; that of m pairs together is as unlikely.

    Returns
    -------
    ndarray of int, shape (k,)
        A landmark's number for each measurement, or -1: new.
    """
    pairs = _Pairs.of(state, covariance, kinds, measurements, measurement_covariance)
    search = _Search(pairs, gate)
    search.extend(0, (), 0.0)
    indices = np.full(len(measurements), NEW)
    for pair in search.best:
        indices[pairs.measurement[pair]] = pairs.landmark[pair]
    return indices


@cache
def joint_gate(gate: float, pairs: int) -> float:
    """Square of the distance that is as unlikely for some pairs together as `gate` is for one."""
    return float(chdtri(2 * pairs, chdtrc(2, gate**2)))


@dataclass(frozen=True, eq=False)
class _Pairs:
    """All pairs (P,) of a measurement and a landmark of its kind.

    Parameters
    ----------
    measurement, landmark : ndarray of int, shape (P,)
        Their numbers.
    innovation : ndarray, shape (2P,)
        Bearing and range of each pair, rad and m.
    S : ndarray, shape (2P, 2P)
        Covariance of all innovations.
    """

    measurement: IntArray
    landmark: IntArray
    innovation: FloatArray
    S: FloatArray

    @classmethod
    def of(
        cls,
        state: FloatArray,
        covariance: FloatArray,
        kinds: Sequence[LandmarkKind],
        measurements: Sequence[Measurement],
        R: FloatArray,
    ) -> _Pairs:
        """Compare every measurement with every landmark of its kind."""
        same = [
            (i, j) for i, seen in enumerate(measurements) for j, kind in enumerate(kinds) if kind == seen.kind
        ]
        i, j = np.array(same, dtype=int).reshape(-1, 2).T
        away = state[3:].reshape(-1, 2)[j] - state[:2]
        distance = np.maximum(np.hypot(*away.T), 1e-6)
        values = np.array([(each.bearing, each.range) for each in measurements]).reshape(-1, 2)[i]
        bearing = wrap_angle(values[:, 0] - np.arctan2(away[:, 1], away[:, 0]) + state[2])
        H = landmark_slopes(away, distance, j, len(state))
        rows = (2 * i[:, None] + (0, 1)).ravel()
        S = np.linalg.multi_dot([H, covariance, H.T]) + R[rows][:, rows]
        return cls(i, j, np.column_stack([bearing, values[:, 1] - distance]).ravel(), S)

    def distance(self, chosen: Sequence[int]) -> float:
        """Squared Mahalanobis distance of some pairs together."""
        rows = (2 * np.array(chosen)[:, None] + (0, 1)).ravel()
        away = self.innovation[rows]
        return float(away @ np.linalg.solve(self.S[np.ix_(rows, rows)], away))


def landmark_slopes(away: FloatArray, distance: FloatArray, landmark: IntArray, size: int) -> FloatArray:
    """Slopes (2P, size) of bearing and range by the state, for landmarks `away` (P, 2) from the robot."""
    H = np.zeros((len(away), 2, size))
    across = np.column_stack([-away[:, 1], away[:, 0]]) / (distance**2)[:, None]
    along = away / distance[:, None]
    H[:, 0, :2], H[:, 1, :2], H[:, 0, 2] = -across, -along, -1.0
    pairs = np.arange(len(away))
    for axis in (0, 1):
        H[pairs, 0, 3 + 2 * landmark + axis] = across[:, axis]
        H[pairs, 1, 3 + 2 * landmark + axis] = along[:, axis]
    return H.reshape(-1, size)


@dataclass
class _Search:
    """Goes through hypotheses, measurement by measurement, and keeps the best."""

    pairs: _Pairs
    gate: float
    best: tuple[int, ...] = ()
    best_distance: float = float("inf")
    tried: int = 0
    options: list[list[int]] = field(default_factory=list)

    def __post_init__(self) -> None:
        """List for each measurement the pairs that fit by themselves, the nearest first."""
        alone = np.array([self.pairs.distance([p]) for p in range(len(self.pairs.landmark))])
        for i in sorted(set(self.pairs.measurement.tolist())):
            mine = [
                p for p in np.flatnonzero(self.pairs.measurement == i).tolist() if alone[p] <= self.gate**2
            ]
            self.options.append(sorted(mine, key=alone.__getitem__))
        self.options = sorted(filter(None, self.options), key=lambda mine: alone[mine[0]])

    def extend(self, depth: int, chosen: tuple[int, ...], distance: float) -> None:
        """Try every landmark for the next measurement, and none; leave where no better one can follow."""
        if (len(chosen), -distance) > (len(self.best), -self.best_distance):
            self.best, self.best_distance = chosen, distance
        left = len(self.options) - depth
        if not left or self.tried >= MOST_TRIED or len(chosen) + left < len(self.best):
            return
        for pair in self.options[depth]:
            if self.pairs.landmark[pair] in self.pairs.landmark[list(chosen)]:
                continue
            self.tried += 1
            together = self.pairs.distance([*chosen, pair])
            if together <= joint_gate(self.gate, len(chosen) + 1):
                self.extend(depth + 1, (*chosen, pair), together)
        self.extend(depth + 1, chosen, distance)
