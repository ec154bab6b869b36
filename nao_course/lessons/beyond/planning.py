"""Drives that choose their next move: by the predicted uncertainty, by a plan, or at random."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_course.exercises import register
from nao_course.field_slam.drives import room_ahead
from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.beyond.worlds import AHEAD, KINDS, LANDMARKS, ODOMETRY, SENSOR, drive
from nao_course.sim.drives import NamedEkf
from nao_course.slam import Estimate, Motion, range_and_bearing

Function = Callable[..., Any]
MOVES, STEP = 20, 0.3  # m
TURNS = np.radians((-90, -60, -40, -20, 0, 20, 40, 60, 90))
GOAL_LINE = 3.0  # m, of the half field of 2012
ROOM = 0.15  # m: a turn is offered if so much room is ahead after it


@register
@dataclass(frozen=True, eq=False)
class Option:
    """A possible move, with the landmarks of the map that should be in view after it.

    The control (2,) is (distance, turn), m and rad, with the covariance (3, 3) of the errors along and across the robot
    and of the turn. The n landmarks in view have expected measurements (2 n,), bearing and range, and covariances R
    (n, 2, 2).
    """

    control: FloatArray
    control_covariance: FloatArray
    indices: list[int]
    measurements: FloatArray
    measurement_covariance: FloatArray

    def __post_init__(self) -> None:
        """Refuse values of the wrong shape."""
        n = len(self.indices)
        wanted = {
            "control": (2,),
            "control_covariance": (3, 3),
            "measurements": (2 * n,),
            "measurement_covariance": (n, 2, 2),
        }
        for name, shape in wanted.items():
            if np.shape(getattr(self, name)) != shape:
                raise ValueError(
                    f"{name} of an option that shows {n} landmarks must have shape {shape}, "
                    f"got {np.shape(getattr(self, name))}"
                )


def options(state: FloatArray) -> list[Option]:
    """Return all moves from an estimated state (3 + 2k,) that leave room ahead, or a half turn if there are none."""
    distance = room_ahead(state[:3], STEP)
    there = (Pose.from_array(state[:3]) @ Pose(distance, 0.0, 0.0)).as_array()
    free = [turn for turn in TURNS.tolist() if room_ahead(there + (0.0, 0.0, turn), STEP) >= ROOM]
    return [_option(there, distance, turn, state[3:].reshape(-1, 2)) for turn in free or [np.pi]]


def _option(there: FloatArray, distance: float, turn: float, landmarks: FloatArray) -> Option:
    """Return the move to a pose (3,) with a turn there, and the landmarks of the map (k, 2) that are then in view."""
    after = there + (0.0, 0.0, turn)
    indices = np.flatnonzero(AHEAD.sees(after, landmarks)) if len(landmarks) else np.zeros(0, dtype=int)
    expected = range_and_bearing(after, landmarks[indices])
    noise = ODOMETRY.covariance(Motion(distance, turn))
    return Option(
        np.array([distance, turn]), noise, indices.tolist(), expected.ravel(), SENSOR.covariances(expected)
    )


@dataclass(frozen=True, eq=False)
class Journey:
    """A drive with moves that were chosen on the way.

    `truth` (S, 3) has the true poses in the field frame, `estimates` and `seen` an entry for each step, and `known` the
    landmarks on the map at the end, in its order.
    """

    truth: FloatArray
    estimates: tuple[Estimate, ...]
    seen: tuple[tuple[int, ...], ...]
    known: tuple[int, ...]

    @property
    def sigmas(self) -> FloatArray:
        """Standard deviation of the position after each step (S,), m: the root of the sum of both variances."""
        return np.array([np.sqrt(np.trace(each.covariance[:2, :2])) for each in self.estimates])

    @property
    def errors(self) -> FloatArray:
        """Error of the position after each step (S,), m."""
        estimated = np.array([each.pose.as_array() for each in self.estimates])
        return np.hypot(*(self.truth - estimated)[:, :2].T)

    @property
    def map_error(self) -> float:
        """Median distance of the map's landmarks from the true ones, m."""
        off = self.estimates[-1].landmarks - LANDMARKS[list(self.known)]
        return float(np.median(np.linalg.norm(off, axis=1)))


Choose = Callable[[FloatArray, FloatArray, Sequence[Option]], int]


def journey(
    choose: Choose, ekf: Sequence[Function], seed: int, moves: int = MOVES, *, back: bool = False
) -> Journey:
    """Drive over the half field, with a chosen move in each step.

    ``choose(state, covariance, options)`` returns the index of an option, and `ekf` is a student's predict,
    update_landmarks and add_landmark of lesson 07. With `back`, the robot starts with its back to the goal, without
    landmarks in view.
    """
    rng = np.random.default_rng([seed, 124])
    x, y, turn = rng.uniform((0.3, -1.0, -0.3), (0.7, 1.0, 0.3)).tolist()
    goal = float(np.arctan2(-y, GOAL_LINE - x))
    start = Pose(x, y, goal + turn + (np.pi if back else 0.0))  # near the halfway line, looking at the goal
    slam = NamedEkf(start, *ekf)

    def command() -> Motion:
        offered = options(slam.state)
        number: Any = choose(slam.state.copy(), slam.covariance.copy(), offered)
        if (
            isinstance(number, bool)
            or not isinstance(number, int | np.integer)
            or not 0 <= number < len(offered)
        ):
            raise ValueError(f"choose_move must return an index from 0 to {len(offered) - 1}, got {number!r}")
        option = offered[int(number)]
        slam.move(option.control, option.control_covariance)
        return Motion(*option.control.tolist())

    rows = list[tuple[FloatArray, Estimate, tuple[int, ...]]]()
    for step in drive(start, command, moves, rng, AHEAD):
        slam.observe(step.numbers, step.measurements, step.covariances)
        rows.append((step.pose, slam.estimate(KINDS), tuple(int(number) for number in step.numbers)))
    truth, estimates, seen = zip(*rows, strict=True)
    return Journey(np.array(truth), estimates, seen, tuple(slam.known))


# --- baselines ---


def at_random(seed: int) -> Choose:
    """Return a function that chooses any of the moves with equal probability."""
    rng = np.random.default_rng([seed, 125])
    return lambda state, covariance, offered: int(rng.integers(len(offered)))


def in_a_circle(state: FloatArray, covariance: FloatArray, offered: Sequence[Option]) -> int:
    """Choose the turn that is closest to 20 degrees to the left."""
    return int(np.argmin([abs(option.control[1] - TURNS[5]) for option in offered]))


def straight_on(state: FloatArray, covariance: FloatArray, offered: Sequence[Option]) -> int:
    """Choose the smallest turn: straight on, and at the edge just enough to stay inside."""
    return int(np.argmin([abs(option.control[1]) for option in offered]))
