"""The compressed filter: while a robot stays among a few landmarks, the rest of a large map need not be touched.

All that such a stretch of the drive will do to the far landmarks B is linear in what it does to the near part A (the
pose and the near landmarks): P_AB becomes phi P_AB, P_BB becomes P_BB - P_BA psi P_AB, and x_B becomes x_B + P_BA t
(Guivant and Nebot 2001, "Optimization of the simultaneous localization and map-building algorithm for real-time
implementation"). The three small quantities are gathered step by step, and used once, on leaving.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray
from nao_course.lessons.ekf_slam.homework_log import Belief, Function, as_belief


class CompressedFilter:
    """A student's filter on a large map, at the cost of a small one.

    The student's functions gather phi, psi and t themselves: they run on A and on as many made-up variables, whose
    covariance with A is the identity at first, and their own zero. What a filter does to these is phi, -psi and t.

    Parameters
    ----------
    predict, update_landmarks : callable
        The student's.
    state, covariance : ndarray, shapes (3 + 2k,) and (3 + 2k, 3 + 2k)
        Of pose and all landmarks.
    near : sequence of int
        Which landmarks will be measured next.
    """

    def __init__(
        self,
        predict: Function,
        update_landmarks: Function,
        state: FloatArray,
        covariance: FloatArray,
        near: Sequence[int],
    ) -> None:
        """Begin among some landmarks."""
        self._predict, self._update = predict, update_landmarks
        self._whole = np.array(state, dtype=float), np.array(covariance, dtype=float)
        self._near, self._local = list(near), self._cut_out(near)

    @property
    def near(self) -> list[int]:
        """The landmarks that can be measured now."""
        return list(self._near)

    @property
    def pose(self) -> Belief:
        """Pose (3,) and its covariance (3, 3) as they are now."""
        state, covariance = self._local
        return state[:3].copy(), covariance[:3, :3].copy()

    def predict(self, control: FloatArray, control_covariance: FloatArray) -> None:
        """Move: the cost does not depend on how large the map is."""
        answer = self._predict(*self._local, control, control_covariance, (len(self._local[0]) - 3) // 2)
        self._local = as_belief(answer, len(self._local[0]), "predict")

    def update_landmarks(
        self, indices: Sequence[int], measurements: FloatArray, measurement_covariance: FloatArray
    ) -> None:
        """Take a look at near landmarks in: the cost does not depend on how large the map is.

        Raises
        ------
        ValueError
            If a landmark is not near.
        """
        slots = {landmark: slot for slot, landmark in enumerate(self._near)}
        if far := [index for index in indices if index not in slots]:
            raise ValueError(f"landmarks {far} are not near; call move_to() first")
        answer = self._update(
            *self._local, [slots[index] for index in indices], measurements, measurement_covariance
        )
        self._local = as_belief(answer, len(self._local[0]), "update_landmarks")

    def move_to(self, near: Sequence[int]) -> None:
        """Bring the whole map up to date, which costs as much as an update of it, and go on among others."""
        self._settle()
        self._near, self._local = list(near), self._cut_out(near)

    def whole(self) -> Belief:
        """State (3 + 2k,) and covariance (3 + 2k, 3 + 2k) of pose and all landmarks, up to date."""
        self._settle()
        self._local = self._cut_out(self._near)
        state, covariance = self._whole
        return state.copy(), covariance.copy()

    def _settle(self) -> None:
        """Do to the whole map what has been gathered."""
        (state, covariance), (local, spread) = self._whole, self._local
        near = _columns(self._near)
        a = len(near)
        phi, minus_psi, t = spread[:a, a : 2 * a], spread[a : 2 * a, a : 2 * a], local[a : 2 * a]
        across = covariance[near]  # P_AA and P_AB; what this does to A itself is written over
        state += t @ across
        covariance += across.T @ (minus_psi @ across)
        covariance[near] = phi @ across
        covariance[:, near] = covariance[near].T
        state[near], covariance[np.ix_(near, near)] = local[:a], spread[:a, :a]

    def _cut_out(self, landmarks: Sequence[int]) -> Belief:
        """The near part of the whole, and the made-up variables as they are at first."""
        state, covariance = self._whole
        near = _columns(landmarks)
        a = len(near)
        local, spread = (
            np.zeros(2 * a + 1),
            np.zeros((2 * a + 1, 2 * a + 1)),
        )  # a is odd, a state's length, too
        local[:a], spread[:a, :a] = state[near], covariance[np.ix_(near, near)]
        spread[:a, a : 2 * a] = spread[a : 2 * a, :a] = np.eye(a)
        return local, spread


def _columns(landmarks: Sequence[int]) -> npt.NDArray[np.intp]:
    """Where the pose and some landmarks stand in a state."""
    return np.array([0, 1, 2, *(3 + 2 * i + axis for i in landmarks for axis in (0, 1))], dtype=np.intp)
