"""EKF SLAM with known data association, computed by a student's functions of lesson 07."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, Pose
from nao_course.slam import Estimate, LandmarkKind

Function = Callable[..., Any]
Functions = tuple[Function, Function, Function]  # predict, update_landmarks, add_landmark
Belief = tuple[FloatArray, FloatArray]
Numbers = Sequence[int] | npt.NDArray[np.intp]


def as_belief(answer: Any, size: int, name: str) -> Belief:
    """Return the state (size,) and the covariance (size, size) that a student's function has returned.

    Raises
    ------
    ValueError
        If the function has returned something else. The message contains its name.
    """
    if not isinstance(answer, tuple | list) or len(answer) != 2:
        raise ValueError(f"{name} must return (state, covariance), got {type(answer).__name__}")
    state, covariance = (np.array(each, dtype=float) for each in answer)
    if state.shape != (size,) or covariance.shape != (size, size):
        raise ValueError(
            f"{name} must return shapes ({size},) and ({size}, {size}), got {state.shape} and {covariance.shape}"
        )
    return state, covariance


def checked_functions(functions: Functions) -> Functions:
    """Wrap three functions so that they get copies of their arguments and the shapes of their results are checked."""

    def check(function: Function, name: str, new: int) -> Function:
        def call(state: FloatArray, covariance: FloatArray, *given: Any) -> Belief:
            copies = (each.copy() if isinstance(each, np.ndarray) else each for each in given)
            return as_belief(function(state.copy(), covariance.copy(), *copies), len(state) + new, name)

        return call

    predict, update_landmarks, add_landmark = functions
    return (
        check(predict, "predict", 0),
        check(update_landmarks, "update_landmarks", 0),
        check(add_landmark, "add_landmark", 2),
    )


def landmark_blocks(covariance: FloatArray) -> FloatArray:
    """Return the covariances (k, 2, 2) of the landmarks from the covariance (3 + 2k, 3 + 2k) of a state."""
    k = (len(covariance) - 3) // 2
    each = np.arange(k)
    return covariance[3:, 3:].reshape(k, 2, k, 2)[each, :, each]


class NamedEkf:
    """The filter of lesson 07 with known data association.

    Parameters
    ----------
    start : Pose
        First pose, which is known exactly.
    predict, update_landmarks, add_landmark : callable
        Student's functions of lesson 07.
    """

    def __init__(
        self, start: Pose, predict: Function, update_landmarks: Function, add_landmark: Function
    ) -> None:
        """Start with an empty map."""
        self._predict, self._update, self._add = predict, update_landmarks, add_landmark
        self.state, self.covariance = start.as_array(), np.zeros((3, 3))
        self.known: list[int] = []  # numbers of the landmarks on the map, in the order of the state

    def copy(self) -> Self:
        """Return an independent filter with the same state."""
        other = copy(self)
        other.known = list(self.known)
        return other

    def move(self, control: FloatArray, covariance: FloatArray) -> None:
        """Predict the state after a control (2,) with its covariance (3, 3)."""
        self.state, self.covariance = self._predict(
            self.state, self.covariance, control, covariance, len(self.known)
        )

    def observe(self, numbers: Numbers, measurements: FloatArray, covariances: FloatArray) -> None:
        """Update with the measurements (n, 2) of landmarks on the map, then add the other landmarks.

        Parameters
        ----------
        numbers : sequence of int
            Number of the landmark of each measurement.
        measurements : ndarray, shape (n, 2)
            Bearing and range of each landmark, rad and m.
        covariances : ndarray, shape (n, 2, 2)
            Covariance of each measurement, rad^2 and m^2.
        """
        again, slots = self.on_map(numbers)
        if again:
            self.state, self.covariance = self._update(
                self.state, self.covariance, slots, measurements[again].ravel(), covariances[again]
            )
        for i in sorted(set(range(len(numbers))) - set(again)):
            self.state, self.covariance = self._add(
                self.state, self.covariance, measurements[i], covariances[i]
            )
            self.known.append(int(numbers[i]))

    def on_map(self, numbers: Numbers) -> tuple[list[int], list[int]]:
        """Return the positions in `numbers` of the landmarks that are on the map, and their positions on the map."""
        again = [i for i, number in enumerate(numbers) if number in self.known]
        return again, [self.known.index(numbers[i]) for i in again]

    def estimate(self, kinds: Sequence[LandmarkKind]) -> Estimate:
        """Return the current estimate; `kinds` contains the kinds of all landmarks by their numbers."""
        return Estimate(
            Pose.from_array(self.state[:3]),
            self.covariance[:3, :3],
            self.state[3:].reshape(-1, 2),
            landmark_blocks(self.covariance),
            tuple(kinds[number] for number in self.known),
        )
