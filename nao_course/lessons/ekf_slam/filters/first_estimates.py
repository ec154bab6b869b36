"""First-estimates Jacobians: a filter that does not learn what nobody has measured.

An EKF linearises each landmark anew wherever it believes it to be. Slopes at different places contradict each other,
and from the contradiction the filter seems to learn the heading of the whole map, which no measurement of a landmark
whose place is unknown can tell. The cure: take all slopes where each quantity was first estimated (Huang, Mourikis and
Roumeliotis 2008, "Analysis and improvement of the consistency of extended Kalman filter based SLAM").
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nao_course.geometry import FloatArray, rotation_2d, wrap_angle
from nao_course.lessons.ekf_slam.homework_log import Belief, Function, as_belief
from nao_course.slam import range_and_bearing


class FirstEstimates:
    """Three functions of a student's filter, called at first estimates; nothing else changes.

    `predict`, `update_landmarks` and `add_landmark` are called as the student's own are.

    Parameters
    ----------
    predict, update_landmarks, add_landmark : callable
        The student's.
    """

    def __init__(self, predict: Function, update_landmarks: Function, add_landmark: Function) -> None:
        """Begin without landmarks, at (0, 0, 0)."""
        self._predict, self._update, self._add = predict, update_landmarks, add_landmark
        self._first = np.zeros(3)  # the pose as it was predicted, and each landmark as it was added

    def predict(
        self, state: FloatArray, covariance: FloatArray, control: FloatArray, noise: FloatArray, k: int
    ) -> Belief:
        """Move the pose as ever; the covariance by the way from the last *predicted* position to the new one."""
        moved, _ = as_belief(self._predict(state, covariance, control, noise, k), len(state), "predict")
        way = moved[:2] - self._first[:2]
        # The same function answers, when it is told of a drive of just this way. Its errors stay those of the robot.
        elsewhere = state.copy()
        elsewhere[2] = np.arctan2(way[1], way[0])
        turned = np.eye(3)
        turned[:2, :2] = rotation_2d(state[2] - elsewhere[2])
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
        """Correct the state by what is new, with slopes at first estimates."""
        first, numbers = self._first, list(indices)

        def seen_from(where: FloatArray) -> FloatArray:
            return range_and_bearing(where[:3], where[3:].reshape(-1, 2)[numbers]).reshape(-1)

        # Asked at the first estimates, the function must find the innovation that the state as it is now would give.
        shifted = measurements - seen_from(state) + seen_from(first)
        answer = self._update(first.copy(), covariance, numbers, shifted, noise)
        corrected, covariance = as_belief(answer, len(state), "update_landmarks")
        state = state + corrected - first
        state[2] = wrap_angle(state[2])
        return state, covariance

    def add_landmark(
        self, state: FloatArray, covariance: FloatArray, measurement: FloatArray, noise: FloatArray
    ) -> Belief:
        """Put a landmark on the map, where it is seen from the pose as it is now; that is its first estimate."""
        size = len(state) + 2
        grown, _ = as_belief(self._add(state, covariance, measurement, noise), size, "add_landmark")
        as_seen = range_and_bearing(self._first[:3], grown[-2:])
        answer = self._add(np.append(self._first[:3], state[3:]), covariance, as_seen, noise)
        self._first = np.append(self._first, grown[-2:])
        return grown, as_belief(answer, size, "add_landmark")[1]
