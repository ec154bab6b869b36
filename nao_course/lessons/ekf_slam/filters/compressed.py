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
    predict, update_landmarks, add_landmark : callable
        The student's.
    state, covariance : ndarray, shapes (3 + 2k,) and (3 + 2k, 3 + 2k)
        Of pose and all landmarks; by default the pose (0, 0, 0), known, and no landmark.
    near : sequence of int
        Which landmarks will be measured next.
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
        """Begin among some landmarks."""
        self._predict, self._update, self._add = predict, update_landmarks, add_landmark
        believed = np.array(state, dtype=float)
        spread = np.zeros((len(believed),) * 2) if covariance is None else np.array(covariance, dtype=float)
        self._whole = believed, spread
        self._near, self._local = list(near), self._cut_out(near)

    @property
    def near(self) -> list[int]:
        """The landmarks that can be measured now: those that were named, and those added since."""
        return list(self._near)

    @property
    def local(self) -> Belief:
        """Pose and near landmarks as they are now: (a,) and (a, a), in the order of `near`."""
        state, covariance = self._local
        a = 3 + 2 * len(self._near)
        return state[:a].copy(), covariance[:a, :a].copy()

    # --- steps, whose cost does not depend on how large the map is ---

    def predict(self, control: FloatArray, control_covariance: FloatArray) -> None:
        """Move."""
        size = len(self._local[0])
        answer = self._predict(*self._local, control, control_covariance, (size - 3) // 2)
        self._local = as_belief(answer, size, "predict")

    def update_landmarks(
        self, indices: Sequence[int], measurements: FloatArray, measurement_covariance: FloatArray
    ) -> None:
        """Take a look at near landmarks in.

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
        """Put a landmark on the map, and return its number."""
        size, a = len(self._local[0]), 3 + 2 * len(self._near)
        answer = self._add(*self._local, measurement, measurement_covariance)
        state, covariance = as_belief(answer, size + 2, "add_landmark")
        order = np.r_[:a, size : size + 2, a:size]  # behind the near ones, before the made-up variables
        self._local = state[order], covariance[np.ix_(order, order)]
        number = max([self._k - 1, *self._near]) + 1
        self._near.append(number)
        return number

    # --- the whole map ---

    def move_to(self, near: Sequence[int]) -> None:
        """Bring the whole map up to date, which costs as much as an update of it, and go on among others."""
        self._settle()
        self._near, self._local = list(near), self._cut_out(near)

    def whole(self) -> Belief:
        """State (3 + 2k,) and covariance (3 + 2k, 3 + 2k) of pose and all landmarks, up to date."""
        self.move_to(self._near)
        state, covariance = self._whole
        return state.copy(), covariance.copy()

    @property
    def _k(self) -> int:
        """How many landmarks the whole map had when the robot came here."""
        return (len(self._whole[0]) - 3) // 2

    def _settle(self) -> None:
        """Do to the whole map what has been gathered, and append what is new."""
        (state, covariance), (local, spread) = self._whole, self._local
        a = 3 + 2 * len(self._near)
        made_up = slice(a, len(local) - 1)
        entered = _columns(self._near)[: len(local) - 1 - a]
        across = covariance[entered]  # P_AA and P_AB; what this does to A itself is written over
        state += local[made_up] @ across
        covariance += across.T @ (spread[made_up, made_up] @ across)
        if added := a - len(entered):
            state, across = np.pad(state, (0, added)), np.pad(across, ((0, 0), (0, added)))
            covariance = np.pad(covariance, (0, added))
        now = _columns(self._near)
        covariance[now] = spread[:a, made_up] @ across
        covariance[:, now] = covariance[now].T
        state[now], covariance[np.ix_(now, now)] = local[:a], spread[:a, :a]
        self._whole = state, covariance

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
