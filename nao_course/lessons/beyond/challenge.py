"""The challenge of lesson 12: in twenty moves, the most certain map of ten landmarks that nobody has seen before."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from nao_course.challenges import CaseScore, Challenge, Column, Run, recorded_rows
from nao_course.challenges.beliefs import DEEPEST, MOST_NEES
from nao_course.challenges.worst_cases import draw_worst
from nao_course.exercises import register
from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.lessons.beyond.planning import MOVES, STEP, Option, options
from nao_course.lessons.beyond.worlds import AHEAD, FIELD, ODOMETRY, SENSOR, moved, noise_of
from nao_course.metrics import band
from nao_course.plotting import Drawing, plot_ellipse, plot_field, plot_landmarks, plot_path
from nao_course.plotting.legends import source_key
from nao_course.plotting.style import GREY
from nao_course.slam import Motion, range_and_bearing

ROBOTS = 20
LANDMARKS = 10
X0, Y0, X1, Y1 = FIELD.carpet  # m
MARGIN, APART = 0.3, 0.5  # m: of a landmark from the carpet's rim, and from the next one
AREA = (X1 - X0) * (Y1 - Y0)  # m^2: where a landmark may be that nobody has seen
LEAST = 1e-6  # m^2: no belief is surer of a landmark than 1 mm
FIRST_SEED = 12_000


@register
@dataclass(frozen=True, eq=False)
class Robot:
    """A robot to be driven: ``robot.look()``, and twenty times ``robot.move(option)``.

    Parameters
    ----------
    start : Pose
        Where it begins, which it knows; field frame.
    _landmarks : ndarray, shape (10, 2)
        True places, m, field frame.
    _seed : int
        Of all errors.
    """

    start: Pose
    _landmarks: FloatArray
    _seed: int

    def __post_init__(self) -> None:
        """Begin at the start; that is no field, for what is given to an entry must stay as it was."""
        object.__setattr__(self, "_path", [self.start.as_array()])

    @property
    def moves_left(self) -> int:
        """How often it may be moved still."""
        return MOVES + 1 - len(self._true_path)

    @property
    def _true_path(self) -> list[FloatArray]:
        path: list[FloatArray] = self.__dict__["_path"]
        return path

    def options(self, state: FloatArray) -> list[Option]:
        """Moves as in exercise 12.7, from a believed state (3 + 2k,), pose first; any other move is allowed, too."""
        return options(np.array(state, dtype=float))

    def move(self, option: Any) -> FloatArray:
        """Move by an option, or by (distance, turn), at most 0.3 m; returns the errors' covariance (3, 3).

        Raises
        ------
        ValueError
            For another move, after the twentieth, and for one that leaves the carpet.
        """
        if not self.moves_left:
            raise ValueError(f"all {MOVES} moves are made")
        distance, turn = _as_control(option)
        motion, path = Motion(distance, turn), self._true_path
        draws = self._draws(len(path), 3)
        pose = moved(path[-1], motion, draws)
        if not (X0 <= pose[0] <= X1 and Y0 <= pose[1] <= Y1):
            raise ValueError(f"the robot left the carpet with move {len(path)}")
        path.append(pose)
        return ODOMETRY.covariance(motion)

    def look(self) -> tuple[list[int], FloatArray, FloatArray]:
        """See what lies ahead: n landmarks' numbers, bearings and ranges (n, 2), their R (n, 2, 2); rad and m.

        To look twice from the same place shows the same: what errs is the place's light, not the moment.
        """
        pose, number = self._true_path[-1], len(self._true_path)
        seen = range_and_bearing(pose, self._landmarks)
        draws = self._draws(number, seen.shape, "look")
        measured = np.column_stack(
            [
                wrap_angle(seen[:, 0] + SENSOR.bearing * draws[:, 0]),
                seen[:, 1] * np.maximum(1 + SENSOR.range_fraction * draws[:, 1], 0.1),
            ]
        )
        numbers = np.flatnonzero(AHEAD.sees(pose, self._landmarks))
        noises = np.array([noise_of(each) for each in measured[numbers]]).reshape(-1, 2, 2)
        return numbers.tolist(), measured[numbers], noises

    def _draws(self, step: int, shape: Any, what: str = "move") -> FloatArray:
        """Standard normal draws of a step: the same whatever was looked at before."""
        return np.random.default_rng([self._seed, step, len(what)]).standard_normal(shape)


def _as_control(option: Any) -> tuple[float, float]:
    """Distance (m) and turn (rad) of what an entry asks for."""
    control = np.array(getattr(option, "control", option), dtype=float)
    if control.shape != (2,) or not np.isfinite(control).all():
        raise ValueError(f"a move is one of robot.options(state), or (distance, turn); got {option!r}")
    distance, turn = control.tolist()
    if abs(distance) > STEP + 1e-9 or abs(turn) > np.pi + 1e-9:
        raise ValueError(
            f"a move is at most {STEP} m and a half turn, got {distance:.2f} m and {turn:.2f} rad"
        )
    return distance, turn


@dataclass(frozen=True, eq=False)
class Case:
    """A robot among landmarks.

    Parameters
    ----------
    start : Pose
        Field frame.
    landmarks : ndarray, shape (10, 2)
        True places, m.
    seed : int
        Of the errors.
    """

    start: Pose
    landmarks: FloatArray
    seed: int

    @property
    def robot(self) -> Robot:
        """A new one, that has not moved."""
        return Robot(self.start, self.landmarks.copy(), self.seed)


def make_case(seed: int) -> Case:
    """Put ten landmarks anywhere on the carpet, and a robot near the halfway line that looks at the goal."""
    rng = np.random.default_rng([FIRST_SEED, seed])
    landmarks = list[FloatArray]()
    while len(landmarks) < LANDMARKS:
        place = rng.uniform((X0 + MARGIN, Y0 + MARGIN), (X1 - MARGIN, Y1 - MARGIN))
        if all(np.hypot(*(place - each)) >= APART for each in landmarks):
            landmarks.append(place)
    return Case(Pose(*rng.uniform((0.3, -0.5, -0.3), (0.7, 0.5, 0.3)).tolist()), np.array(landmarks), seed)


def judge(answer: Any, case: Case) -> CaseScore:
    """Score a map by how many bits it is denser at the true landmarks than knowing only that they are on the carpet."""
    numbers, places, covariance = as_map(answer)
    off = (places - case.landmarks[numbers]).ravel()
    covariance = covariance + LEAST * np.eye(len(off))
    squares = float(off @ np.linalg.solve(covariance, off)) if len(off) else 0.0
    log_density = -0.5 * (squares + np.linalg.slogdet(2 * np.pi * covariance)[1])
    bits = (log_density + len(numbers) * np.log(AREA)) / np.log(2)
    stated = np.sqrt(np.diag(covariance).reshape(-1, 2).sum(axis=1))
    columns = {
        "found": float(len(numbers)),
        "off": 100 * float(np.median(np.hypot(*off.reshape(-1, 2).T))) if len(off) else 0.0,
        "stated": 100 * float(np.median(stated)) if len(off) else 0.0,
        "NEES a coordinate": min(squares / max(len(off), 1), MOST_NEES),
    }
    return CaseScore(max(float(bits), DEEPEST), columns, (case, numbers, places, covariance))


def as_map(answer: Any) -> tuple[list[int], FloatArray, FloatArray]:
    """Return an answer's landmarks: their numbers, places (k, 2) and covariance (2k, 2k).

    Raises
    ------
    TypeError, ValueError
        If it is something else; the message is for the student.
    """
    if answer is None:
        raise TypeError("Your entry returns None: does it end with return numbers, state, covariance?")
    try:
        numbers, state, covariance = answer
        numbers = [int(each) for each in numbers]
        state, covariance = (np.array(each, dtype=float, subok=False) for each in (state, covariance))
    except (TypeError, ValueError):
        raise TypeError("Your entry must return three things: numbers, state and covariance.") from None
    size = 3 + 2 * len(numbers)
    if state.shape != (size,) or covariance.shape != (size, size):
        raise ValueError(
            f"Your state has shape {state.shape} and your covariance {covariance.shape}; with {len(numbers)} numbers "
            f"({size},) and ({size}, {size}), the pose first, are wanted."
        )
    if len(set(numbers)) < len(numbers) or not set(numbers) <= set(range(LANDMARKS)):
        raise ValueError(f"Your numbers must be from 0 to {LANDMARKS - 1}, each once, got {numbers}.")
    places, spread = state[3:].reshape(-1, 2), covariance[3:, 3:]
    if not (np.isfinite(places).all() and np.isfinite(spread).all()):
        raise ValueError("Your map or its covariance has NaN or infinite numbers in it.")
    if not np.allclose(spread, spread.T, rtol=1e-6, atol=1e-12):
        raise ValueError("Your map's covariance is not symmetric.")
    if len(numbers) and np.linalg.eigvalsh(spread)[0] <= -LEAST / 2:
        raise ValueError("Your map's covariance has a negative eigenvalue.")
    return numbers, places, spread


def draw_worst_maps(run: Run) -> Drawing:
    """Draw the maps with the fewest bits, beside the true landmarks."""
    keys = [source_key("truth", "where it began"), source_key("ekf", "your map, 95 %")]
    return draw_worst(run, _plot_map, keys)


def _plot_map(ax: Axes, kept: Any) -> None:
    """True landmarks, and those of a map with their ellipses."""
    case, _, places, covariance = kept
    plot_field(FIELD, ax)
    plot_landmarks(case.landmarks, ["post"] * LANDMARKS, ax, GREY, size=7)
    plot_path([case.start], ax)
    for n, place in enumerate(places):
        plot_ellipse(place, covariance[2 * n : 2 * n + 2, 2 * n : 2 * n + 2], ax, "ekf")


_LOW, _HIGH = (each / 2 / LANDMARKS for each in band(2 * LANDMARKS, ROBOTS))
CHALLENGE = Challenge(
    lesson="12_beyond",
    title="Challenge 12: the most certain map in twenty moves",
    task=f"{ROBOTS} robots stand among {LANDMARKS} landmarks that no map shows, and each has {MOVES} moves. Write a "
    "function of robot: robot.start is its pose, robot.look() gives numbers, measurements and their covariances, "
    "robot.options(state) the moves of exercise 12.7, robot.move(option) makes one. It returns numbers, state and "
    "covariance: which landmarks your map has, in its order, and the map as lesson 07 has it, pose first.",
    scoring="bits: how much denser your map is at the true landmarks than the knowledge that each is somewhere on the "
    "carpet, as a logarithm to the base 2, the mean over all robots. A landmark that is not on it counts nothing; "
    f"one of which you are wrongly sure costs. Honest are {_LOW:.1f} to {_HIGH:.1f} NEES a coordinate.",
    seeds=range(ROBOTS),
    make=make_case,
    given=lambda case: (case.robot,),
    judge=judge,
    figure=draw_worst_maps,
    columns=(
        Column("found", "", 1),
        Column("off", " cm", 1),
        Column("stated", " cm", 1),
        Column("NEES a coordinate", "", 1),
    ),
    rows=recorded_rows(Path(__file__).with_suffix(".json")),
    nothing=DEEPEST,
    unit=" bits",
    case="robot",
    name_of=partial("robot {}".format),
)
