"""Data association by joint compatibility: assign all measurements of a picture to landmarks at once.

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

from nao_course.codec import register
from nao_course.geometry import FloatArray, wrap_angle
from nao_course.slam import LandmarkKind, Measurement

NEW = -1
MOST_TRIED = (
    2000  # hypotheses for one picture: more than a camera with a field of view of 61 degrees ever needs
)
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
    """Assign the measurements of one picture to landmarks by joint compatibility, with branch and bound.

    The result is the largest set of pairs that are jointly compatible. If several sets have the same size, it is the
    set with the smallest Mahalanobis distance.

    Parameters
    ----------
    state : ndarray, shape (3 + 2n,)
        Pose and the positions of n landmarks in the map frame, m and rad.
    covariance : ndarray, shape (3 + 2n, 3 + 2n)
        Covariance of the state.
    kinds : sequence of str
        Kind of each of the n landmarks.
    measurements : sequence of Measurement
        The k measurements of one picture.
    measurement_covariance : ndarray, shape (2k, 2k)
        Joint covariance of bearing and range of each measurement in turn, rad^2, rad m and m^2.
    gate : float
        Largest Mahalanobis distance of a single pair, in standard deviations. The gate of m pairs has the same
        probability; see `joint_gate`.

    Returns
    -------
    ndarray of int, shape (k,)
        Index of the landmark of each measurement, or `NEW` (-1) if no landmark fits.
    """
    pairs = _Pairs.of(state, covariance, kinds, measurements, measurement_covariance, gate)
    search = _Search(pairs, gate)
    search.extend(0, (), 0.0)
    indices = np.full(len(measurements), NEW)
    for pair in search.best:
        indices[pairs.measurement[pair]] = pairs.landmark[pair]
    return indices


@cache
def joint_gate(gate: float, pairs: int) -> float:
    """Return the squared distance that several pairs exceed as rarely as a single pair exceeds `gate`."""
    return float(chdtri(2 * pairs, chdtrc(2, gate**2)))


@dataclass(frozen=True, eq=False)
class _Pairs:
    """The P pairs of a measurement and a landmark of the same kind that are compatible on their own.

    `measurement` and `landmark` (P,) are indices, `alone` (P,) the squared Mahalanobis distances of single pairs; the
    innovation (2P,) has bearing and range of each pair in turn, rad and m, and S (2P, 2P) is their joint covariance.
    """

    measurement: IntArray
    landmark: IntArray
    alone: FloatArray
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
        gate: float,
    ) -> _Pairs:
        """Compute the innovations of all measurements with all landmarks of their kinds inside the gate."""
        n, k = len(kinds), len(measurements)
        offset = state[3:].reshape(-1, 2) - state[:2]
        distance = np.maximum(np.hypot(*offset.T), 1e-6)
        H = landmark_jacobian(offset, distance, np.arange(n), len(state)).reshape(n, 2, len(state))
        # Only the pose and the landmark itself have derivatives, so a single pair needs a covariance of 5 by 5.
        own = np.column_stack([np.tile((0, 1, 2), (n, 1)), 3 + 2 * np.arange(n), 4 + 2 * np.arange(n)])
        J = np.take_along_axis(H, own[:, None], axis=2)
        landmarks = J @ covariance[own[:, :, None], own[:, None]] @ J.mT
        noise = np.asarray(R).reshape(k, 2, k, 2)[np.arange(k), :, np.arange(k)]
        values = np.array([(each.bearing, each.range) for each in measurements]).reshape(-1, 1, 2)
        expected = np.column_stack([np.arctan2(offset[:, 1], offset[:, 0]) - state[2], distance])
        innovation = values - expected
        innovation[..., 0] = wrap_angle(innovation[..., 0])
        same = np.equal.outer(np.array([each.kind for each in measurements], str), np.array(kinds, str))
        i, j = np.nonzero(same)
        S = landmarks[j] + noise[i]
        alone = (innovation[i, j] * np.linalg.solve(S, innovation[i, j][..., None])[..., 0]).sum(axis=1)
        near = alone <= gate**2
        i, j = i[near], j[near]
        rows, H = (2 * i[:, None] + (0, 1)).ravel(), H[j].reshape(2 * len(j), len(state))
        joint = H @ covariance @ H.T + np.asarray(R)[rows][:, rows]
        return cls(i, j, alone[near], innovation[i, j].ravel(), joint)

    def distance(self, chosen: Sequence[int]) -> float:
        """Return the squared joint Mahalanobis distance of some pairs."""
        rows = (2 * np.array(chosen)[:, None] + (0, 1)).ravel()
        innovation = self.innovation[rows]
        return float(innovation @ np.linalg.solve(self.S[np.ix_(rows, rows)], innovation))


def landmark_jacobian(offset: FloatArray, distance: FloatArray, landmark: IntArray, size: int) -> FloatArray:
    """Return the Jacobian (2P, size) of the bearings and ranges of P landmarks, in turn, with respect to the state.

    Each offset (P, 2) is the landmark's position minus the robot's in the map frame, m, and `distance` (P,) its length,
    m, above 0; `landmark` (P,) is the index in the state.
    """
    H = np.zeros((len(offset), 2, size))
    across = np.column_stack([-offset[:, 1], offset[:, 0]]) / (distance**2)[:, None]
    along = offset / distance[:, None]
    H[:, 0, :2], H[:, 1, :2], H[:, 0, 2] = -across, -along, -1.0
    pairs = np.arange(len(offset))
    for axis in (0, 1):
        H[pairs, 0, 3 + 2 * landmark + axis] = across[:, axis]
        H[pairs, 1, 3 + 2 * landmark + axis] = along[:, axis]
    return H.reshape(-1, size)


@dataclass
class _Search:
    """Depth-first search over hypotheses, one measurement after the other, which keeps the best hypothesis."""

    pairs: _Pairs
    gate: float
    best: tuple[int, ...] = ()
    best_distance: float = float("inf")
    tried: int = 0
    options: list[list[int]] = field(default_factory=list)

    def __post_init__(self) -> None:
        """List the pairs of each measurement, the nearest pair first."""
        alone = self.pairs.alone
        for i in sorted(set(self.pairs.measurement.tolist())):
            of_measurement = np.flatnonzero(self.pairs.measurement == i).tolist()
            self.options.append(sorted(of_measurement, key=alone.__getitem__))
        self.options = sorted(self.options, key=lambda options: alone[options[0]])

    def extend(self, depth: int, chosen: tuple[int, ...], distance: float) -> None:
        """Try each landmark for the next measurement, and no landmark; stop where no better hypothesis can follow."""
        if (len(chosen), -distance) > (len(self.best), -self.best_distance):
            self.best, self.best_distance = chosen, distance
        remaining = len(self.options) - depth
        if not remaining or self.tried >= MOST_TRIED or len(chosen) + remaining < len(self.best):
            return
        for pair in self.options[depth]:
            if self.pairs.landmark[pair] in self.pairs.landmark[list(chosen)]:
                continue
            self.tried += 1
            joint_distance = self.pairs.distance([*chosen, pair])
            if joint_distance <= joint_gate(self.gate, len(chosen) + 1):
                self.extend(depth + 1, (*chosen, pair), joint_distance)
        self.extend(depth + 1, chosen, distance)
