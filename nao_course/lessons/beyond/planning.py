"""Drives that choose their next move: by what tells most, by a plan, or at random."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_course.exercises import register
from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.beyond.particles import Belief, NamedEkf
from nao_course.lessons.beyond.worlds import AHEAD, LANDMARKS, ODOMETRY, drive, noise_of, room_ahead
from nao_course.slam import Motion, range_and_bearing

Function = Callable[..., Any]
MOVES, STEP = 20, 0.3  # m
TURNS = np.radians((-90, -60, -40, -20, 0, 20, 40, 60, 90))
GOAL_LINE = 3.0  # m, of the half field of 2012
ROOM = 0.15  # m: a turn is offered if so much room is ahead after it


@register
@dataclass(frozen=True, eq=False)
class Option:
    """A move that is offered, with what the map says it will show.

    Parameters
    ----------
    control : ndarray, shape (2,)
        (distance, turn), m and rad.
    control_covariance : ndarray, shape (3, 3)
        Of the errors along, across and of the turn.
    indices : list of int
        Which landmarks of the map should be seen after it.
    measurements : ndarray, shape (2 n,)
        What is expected to be measured of them: bearing and range of each in turn.
    measurement_covariance : ndarray, shape (n, 2, 2)
        R of each.

    Raises
    ------
    ValueError
        If one of them has another shape.
    """

    control: FloatArray
    control_covariance: FloatArray
    indices: list[int]
    measurements: FloatArray
    measurement_covariance: FloatArray

    def __post_init__(self) -> None:
        """Refuse what no filter could take in."""
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
    """All moves that leave room ahead, from a believed state (3 + 2k,); where none does, a half turn."""
    distance = room_ahead(state[:3], STEP)
    there = (Pose.from_array(state[:3]) @ Pose(distance, 0.0, 0.0)).as_array()
    free = [turn for turn in TURNS.tolist() if room_ahead(there + (0.0, 0.0, turn), STEP) >= ROOM]
    return [_option(there, distance, turn, state[3:].reshape(-1, 2)) for turn in free or [np.pi]]


def _option(there: FloatArray, distance: float, turn: float, landmarks: FloatArray) -> Option:
    """A move to a pose (3,) and a turn there, and what of the map (k, 2) will be seen then."""
    after = there + (0.0, 0.0, turn)
    indices = np.flatnonzero(AHEAD.sees(after, landmarks)) if len(landmarks) else np.zeros(0, dtype=int)
    expected = range_and_bearing(after, landmarks[indices])
    noises = np.array([noise_of(each) for each in expected]).reshape(-1, 2, 2)
    noise = ODOMETRY.covariance(Motion(distance, turn))
    return Option(np.array([distance, turn]), noise, indices.tolist(), expected.ravel(), noises)


@dataclass(frozen=True, eq=False)
class Journey:
    """A drive whose moves were chosen on the way.

    Parameters
    ----------
    truth, believed : ndarray, shape (S, 3)
        Poses, field frame.
    covariances : ndarray, shape (S, 3, 3)
        Of the believed poses, m^2 and rad^2.
    state, covariance : ndarray
        What is believed at the end.
    known : tuple of int
        Which landmarks are on the map, in its order.
    """

    truth: FloatArray
    believed: FloatArray
    covariances: FloatArray
    state: FloatArray
    covariance: FloatArray
    known: tuple[int, ...]

    @property
    def doubts(self) -> FloatArray:
        """Root of the sum of the position's two variances after each step, (S,), m."""
        return np.sqrt(self.covariances[:, 0, 0] + self.covariances[:, 1, 1])

    @property
    def off(self) -> float:
        """Error of the last position, m."""
        return float(np.hypot(*(self.truth[-1] - self.believed[-1])[:2]))

    @property
    def map_error(self) -> float:
        """Median distance of the map's landmarks from the true ones, m."""
        return float(
            np.median(np.linalg.norm(self.state[3:].reshape(-1, 2) - LANDMARKS[list(self.known)], axis=1))
        )


Choose = Callable[[FloatArray, FloatArray, Sequence[Option]], int]


def journey(
    choose: Choose, ekf: Sequence[Function], seed: int, moves: int = MOVES, *, back: bool = False
) -> Journey:
    """Drive over the half field, each time by the move that is chosen.

    Parameters
    ----------
    choose : callable
        ``choose(state, covariance, options) -> int``, which of the options.
    ekf : sequence of callable
        The student's predict, update_landmarks and add_landmark, of lesson 07.
    seed : int
        Of the start and all errors.
    moves : int
        How many.
    back : bool
        Whether it begins with its back to the goal; nothing is in sight then.

    Raises
    ------
    ValueError
        If what is chosen is none of the options.
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
            raise ValueError(
                f"choose 0 to {len(offered) - 1}, one of the moves that are offered, not {number!r}"
            )
        option = offered[int(number)]
        slam.move(option.control, option.control_covariance)
        return Motion(*option.control.tolist())

    truth, believed = list[FloatArray](), list[Belief]()
    for step in drive(start, command, moves, rng, AHEAD):
        slam.observe(step.numbers.tolist(), step.measurements)
        truth.append(step.pose)
        believed.append(slam.belief())
    return Journey(
        np.array(truth),
        np.array([each.pose for each in believed]),
        np.array([each.covariance for each in believed]),
        slam.state,
        slam.covariance,
        tuple(slam.known),
    )


# --- ways to choose that know nothing ---


def at_random(seed: int) -> Choose:
    """Any of the moves, each as likely as the next."""
    rng = np.random.default_rng([seed, 125])
    return lambda state, covariance, offered: int(rng.integers(len(offered)))


def in_a_circle(state: FloatArray, covariance: FloatArray, offered: Sequence[Option]) -> int:
    """A fixed plan: 20 degrees to the left each time, or what is nearest to it."""
    return int(np.argmin([abs(option.control[1] - TURNS[5]) for option in offered]))


def straight_on(state: FloatArray, covariance: FloatArray, offered: Sequence[Option]) -> int:
    """A fixed plan: straight on, and at the edge as little of a turn as leads away from it."""
    return int(np.argmin([abs(option.control[1]) for option in offered]))
