"""First-estimates Jacobians, which keep the filter from gaining information that no measurement contains.

An EKF linearises each measurement at the current estimates. Jacobians at different estimates contradict each other,
and the filter treats the contradiction as information about the heading of the whole map, although measurements of
unknown landmarks contain none. The remedy is to evaluate all Jacobians at the first estimates (Huang, Mourikis and
Roumeliotis 2008, "Analysis and improvement of the consistency of extended Kalman filter based SLAM").
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nao_course.geometry import FloatArray, rotation_2d, wrap_angle
from nao_course.sim.drives import Belief, Function, as_belief
from nao_course.slam import range_and_bearing


class FirstEstimates:
    """Call the three functions of a student's filter at first estimates; nothing else changes.

    `predict`, `update_landmarks` and `add_landmark` have the arguments of the student's functions.

    Parameters
    ----------
    predict, update_landmarks, add_landmark : callable
        The student's functions.
    """

    def __init__(self, predict: Function, update_landmarks: Function, add_landmark: Function) -> None:
        """Start at (0, 0, 0) with an empty map."""
        self._predict, self._update, self._add = predict, update_landmarks, add_landmark
        self._first = np.zeros(3)  # the predicted pose, and each landmark's first estimate

    def predict(
        self, state: FloatArray, covariance: FloatArray, control: FloatArray, noise: FloatArray, k: int
    ) -> Belief:
        """Predict the pose as usual, and the covariance by the path from the last *predicted* position."""
        moved, _ = as_belief(self._predict(state, covariance, control, noise, k), len(state), "predict")
        way = moved[:2] - self._first[:2]
        # The same function is called with a drive along this path; the noise stays the robot's own.
        elsewhere = state.copy()
        elsewhere[2] = ahead = np.arctan2(way[1], way[0])
        turned = np.eye(3)
        turned[:2, :2] = rotation_2d(state[2] - ahead)
        drive = np.array([np.hypot(*way), control[1]])
        answer = self._predict(elsewhere, covariance, drive, turned @ noise @ turned.T, k)
        self._first[:3] = moved[:3]
        return moved, as_belief(answer, len(state), "predict")[1]

    def update_landmarks(
        self,
        state: FloatArray,
        covariance: FloatArray,
        indices: Sequence[int],
        measurements: FloatArray,
        noise: FloatArray,
    ) -> Belief:
        """Correct the state by its innovation, with Jacobians at first estimates."""
        first, numbers = self._first, list(indices)

        def expected_at(where: FloatArray) -> FloatArray:
            return range_and_bearing(where[:3], where[3:].reshape(-1, 2)[numbers]).reshape(-1)

        # At the first estimates the function must compute the innovation of the current state.
        shifted = measurements - expected_at(state) + expected_at(first)
        answer = self._update(first.copy(), covariance, numbers, shifted, noise)
        corrected, covariance = as_belief(answer, len(state), "update_landmarks")
        state = state + corrected - first
        state[2] = wrap_angle(state[2])
        return state, covariance

    def add_landmark(
        self, state: FloatArray, covariance: FloatArray, measurement: FloatArray, noise: FloatArray
    ) -> Belief:
        """Add a landmark as measured from the current pose, which gives its first estimate."""
        size = len(state) + 2
        grown, _ = as_belief(self._add(state, covariance, measurement, noise), size, "add_landmark")
        from_first = range_and_bearing(self._first[:3], grown[-2:])
        answer = self._add(np.append(self._first[:3], state[3:]), covariance, from_first, noise)
        self._first = np.append(self._first, grown[-2:])
        return grown, as_belief(answer, size, "add_landmark")[1]
