"""The compressed filter, which updates only a small part of a large map while the robot stays in it.

The effect of such a part of the drive on the far landmarks B is linear in its effect on the near part A (the pose and
the near landmarks): P_AB becomes phi P_AB, P_BB becomes P_BB - P_BA psi P_AB, and x_B becomes x_B + P_BA t
(Guivant and Nebot 2001, "Optimization of the simultaneous localization and map-building algorithm for real-time
implementation"). The three small quantities are accumulated step by step, and applied once, when the robot leaves A.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray
from nao_course.sim.drives import Belief, Function, as_belief


class CompressedFilter:
    """Run a student's filter on a large map at the cost of a small one.

    The student's functions accumulate phi, psi and t themselves: they run on A and on an equal number of auxiliary
    variables, whose covariance with A is the identity at first and whose own covariance is zero. The filter turns
    them into phi, -psi and t.

    Parameters
    ----------
    predict, update_landmarks, add_landmark : callable
        The student's functions.
    state, covariance : ndarray, shapes (3 + 2k,) and (3 + 2k, 3 + 2k)
        Of pose and all landmarks; by default the certain pose (0, 0, 0) and no landmark.
    near : sequence of int
        Landmarks that will be measured next.
    """

    def __init__(
        self,
        predict: Function,
        update_landmarks: Function,
        add_landmark: Function,
        state: npt.ArrayLike = (0.0, 0.0, 0.0),
        covariance: npt.ArrayLike | None = None,
        near: Sequence[int] = (),
    ) -> None:
        """Start near some landmarks."""
        self._predict, self._update, self._add = predict, update_landmarks, add_landmark
        whole = np.array(state, dtype=float)
        whole_covariance = (
            np.zeros((len(whole),) * 2) if covariance is None else np.array(covariance, dtype=float)
        )
        self._whole = whole, whole_covariance
        self._near, self._local = list(near), self._cut_out(near)

    @property
    def near(self) -> list[int]:
        """Return the landmarks that can be measured now, including the landmarks that were added since."""
        return list(self._near)

    @property
    def local(self) -> Belief:
        """Return the current pose and near landmarks, (a,) and (a, a), in the order of `near`."""
        state, covariance = self._local
        a = 3 + 2 * len(self._near)
        return state[:a].copy(), covariance[:a, :a].copy()

    # --- steps, whose cost does not depend on the size of the map ---

    def predict(self, control: FloatArray, control_covariance: FloatArray) -> None:
        """Predict the state after a control."""
        size = len(self._local[0])
        answer = self._predict(*self._local, control, control_covariance, (size - 3) // 2)
        self._local = as_belief(answer, size, "predict")

    def update_landmarks(
        self, indices: Sequence[int], measurements: FloatArray, measurement_covariance: FloatArray
    ) -> None:
        """Update with measurements of near landmarks.

        Raises
        ------
        ValueError
            If a landmark is not near.
        """
        slots = {landmark: slot for slot, landmark in enumerate(self._near)}
        if far := [index for index in indices if index not in slots]:
            raise ValueError(f"landmarks {far} are not near; call move_to() first")
        numbers = [slots[index] for index in indices]
        answer = self._update(*self._local, numbers, measurements, measurement_covariance)
        self._local = as_belief(answer, len(self._local[0]), "update_landmarks")

    def add_landmark(self, measurement: FloatArray, measurement_covariance: FloatArray) -> int:
        """Add a landmark to the map, and return its number."""
        size, a = len(self._local[0]), 3 + 2 * len(self._near)
        answer = self._add(*self._local, measurement, measurement_covariance)
        state, covariance = as_belief(answer, size + 2, "add_landmark")
        order = np.r_[:a, size : size + 2, a:size]  # after the near landmarks, before the auxiliary variables
        self._local = state[order], covariance[np.ix_(order, order)]
        number = max([self._k - 1, *self._near]) + 1
        self._near.append(number)
        return number

    # --- the whole map ---

    def move_to(self, near: Sequence[int]) -> None:
        """Update the whole map, which costs as much as one full update, and continue near other landmarks."""
        self._settle()
        self._near, self._local = list(near), self._cut_out(near)

    def whole(self) -> Belief:
        """Return the current state (3 + 2k,) and covariance (3 + 2k, 3 + 2k) of pose and all landmarks."""
        self.move_to(self._near)
        state, covariance = self._whole
        return state.copy(), covariance.copy()

    @property
    def _k(self) -> int:
        """Return how many landmarks the whole map had when the robot came here."""
        return (len(self._whole[0]) - 3) // 2

    def _settle(self) -> None:
        """Apply the accumulated quantities to the whole map, and append new landmarks."""
        (state, covariance), (local, local_covariance) = self._whole, self._local
        a = 3 + 2 * len(self._near)
        auxiliary = slice(a, len(local) - 1)
        entered = _columns(self._near)[: len(local) - 1 - a]
        across = covariance[entered]  # P_AA and P_AB; the result for A itself is overwritten below
        state += local[auxiliary] @ across
        covariance += across.T @ (local_covariance[auxiliary, auxiliary] @ across)
        if added := a - len(entered):
            state, across = np.pad(state, (0, added)), np.pad(across, ((0, 0), (0, added)))
            covariance = np.pad(covariance, (0, added))
        now = _columns(self._near)
        covariance[now] = local_covariance[:a, auxiliary] @ across
        covariance[:, now] = covariance[now].T
        state[now], covariance[np.ix_(now, now)] = local[:a], local_covariance[:a, :a]
        self._whole = state, covariance

    def _cut_out(self, landmarks: Sequence[int]) -> Belief:
        """Return the near part of the whole state with initial auxiliary variables."""
        state, covariance = self._whole
        near = _columns(landmarks)
        a = len(near)
        # a is odd, and the length of a state must be odd, too
        local, local_covariance = (np.zeros(2 * a + 1), np.zeros((2 * a + 1, 2 * a + 1)))
        local[:a], local_covariance[:a, :a] = state[near], covariance[np.ix_(near, near)]
        local_covariance[:a, a : 2 * a] = local_covariance[a : 2 * a, :a] = np.eye(a)
        return local, local_covariance


def _columns(landmarks: Sequence[int]) -> npt.NDArray[np.intp]:
    """Return the indices of the pose and of some landmarks in a state."""
    return np.array([0, 1, 2, *(3 + 2 * i + axis for i in landmarks for axis in (0, 1))], dtype=np.intp)
