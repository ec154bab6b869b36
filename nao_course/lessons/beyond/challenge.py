"""The challenge of lesson 12: in twenty moves, the most certain map of ten unknown landmarks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from nao_course.challenges import CaseScore, Challenge, Column, Run, recorded_rows
from nao_course.challenges.beliefs import DEEPEST, MOST_NEES
from nao_course.challenges.worst_cases import draw_worst
from nao_course.exercises import register
from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.beyond.planning import MOVES, STEP, Option, options
from nao_course.lessons.beyond.worlds import AHEAD, FIELD, ODOMETRY, SENSOR, moved
from nao_course.metrics import band
from nao_course.plotting import Drawing, plot_ellipse, plot_field, plot_landmarks, plot_path, style_of
from nao_course.plotting.legends import source_key
from nao_course.plotting.style import GREY
from nao_course.slam import Motion, range_and_bearing

ROBOTS = 20
LANDMARKS = 10
X0, Y0, X1, Y1 = FIELD.carpet  # m
MARGIN, APART = 0.3, 0.5  # m: from a landmark to the edge of the carpet, and to the next landmark
AREA = (X1 - X0) * (Y1 - Y0)  # m^2: where an unseen landmark may be
LEAST = 1e-6  # m^2: no landmark has a standard deviation below 1 mm
FIRST_SEED = 12_000
_MOVE, _MEASURE = 0, 1  # random streams: the errors of moves and of measurements are independent


@register
@dataclass(frozen=True, eq=False)
class Robot:
    """A robot that an entry drives: ``robot.look()``, and twenty times ``robot.move(option)``.

    Its start is known, in the field frame; `_landmarks` (10, 2) are true positions in m, and `_seed` draws all errors.
    """

    start: Pose
    _landmarks: FloatArray
    _seed: int

    def __post_init__(self) -> None:
        """Start the path; it is not a field, because the arguments of an entry must not change."""
        object.__setattr__(self, "_path", [self.start.as_array()])

    @property
    def moves_left(self) -> int:
        """Number of moves that remain."""
        return MOVES + 1 - len(self._true_path)

    @property
    def _true_path(self) -> list[FloatArray]:
        path: list[FloatArray] = self.__dict__["_path"]
        return path

    def options(self, state: FloatArray) -> list[Option]:
        """Return moves as in exercise 12.7 from an estimated state (3 + 2k,), pose first; others are legal, too."""
        return options(np.array(state, dtype=float))

    def move(self, option: Any) -> FloatArray:
        """Move by an option, or by (distance, turn), at most 0.3 m; returns the errors' covariance (3, 3).

        Raise a ValueError for an invalid move, after the twentieth move, and for a move that leaves the carpet.
        """
        if not self.moves_left:
            raise ValueError(f"all {MOVES} moves are made")
        distance, turn = _as_control(option)
        motion, path = Motion(distance, turn), self._true_path
        draws = self._draws(_MOVE, len(path), 3)
        pose = moved(path[-1], motion, draws)
        if not (X0 <= pose[0] <= X1 and Y0 <= pose[1] <= Y1):
            raise ValueError(f"the robot left the carpet with move {len(path)}")
        path.append(pose)
        return ODOMETRY.covariance(motion)

    def look(self) -> tuple[list[int], FloatArray, FloatArray]:
        """Measure the landmarks ahead: n numbers, bearings and ranges (n, 2), and their R (n, 2, 2); rad and m.

        A second call without a move between returns the same measurements.
        """
        pose, number = self._true_path[-1], len(self._true_path)
        seen = range_and_bearing(pose, self._landmarks)
        numbers = np.flatnonzero(AHEAD.contains(seen))
        measured = SENSOR.disturbed(seen, self._draws(_MEASURE, number, seen.shape))[numbers]
        return numbers.tolist(), measured, SENSOR.covariances(measured)

    def _draws(self, stream: int, step: int, shape: Any) -> FloatArray:
        """Return a stream's standard normal draws for a step, which do not depend on earlier calls of `look`."""
        return np.random.default_rng([self._seed, step, stream]).standard_normal(shape)


def _as_control(option: Any) -> tuple[float, float]:
    """Return distance (m) and turn (rad) of a requested move."""
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
    """A robot among landmarks: its start in the field frame, and the true positions (10, 2) in m."""

    start: Pose
    landmarks: FloatArray
    seed: int

    @property
    def robot(self) -> Robot:
        """A new robot that has not moved."""
        return Robot(self.start, self.landmarks.copy(), self.seed)


def make_case(seed: int) -> Case:
    """Draw ten landmarks on the carpet, and a robot near the halfway line that looks at the goal."""
    rng = np.random.default_rng([FIRST_SEED, seed])
    landmarks = list[FloatArray]()
    while len(landmarks) < LANDMARKS:
        place = rng.uniform((X0 + MARGIN, Y0 + MARGIN), (X1 - MARGIN, Y1 - MARGIN))
        if all(np.hypot(*(place - each)) >= APART for each in landmarks):
            landmarks.append(place)
    return Case(Pose(*rng.uniform((0.3, -0.5, -0.3), (0.7, 0.5, 0.3)).tolist()), np.array(landmarks), seed)


def judge(answer: Any, case: Case) -> CaseScore:
    """Score a map: the bits by which it is denser at the true landmarks than a uniform density over the carpet."""
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
    """Return the landmarks of an answer: their numbers, positions (k, 2) and covariance (2k, 2k).

    Raise a TypeError or ValueError with a message for the student if the answer is anything else.
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
            f"Your state has shape {state.shape} and your covariance {covariance.shape}. With {len(numbers)} numbers "
            f"they must have the shapes ({size},) and ({size}, {size}), with the pose first."
        )
    if len(set(numbers)) < len(numbers) or not set(numbers) <= set(range(LANDMARKS)):
        raise ValueError(f"Your numbers must be from 0 to {LANDMARKS - 1}, each once, got {numbers}.")
    places, blocks = state[3:].reshape(-1, 2), covariance[3:, 3:]
    if not (np.isfinite(places).all() and np.isfinite(blocks).all()):
        raise ValueError("Your map or its covariance contains NaN or infinite numbers.")
    if not np.allclose(blocks, blocks.T, rtol=1e-6, atol=1e-12):
        raise ValueError("Your map's covariance is not symmetric.")
    if len(numbers) and np.linalg.eigvalsh(blocks)[0] <= -LEAST / 2:
        raise ValueError("Your map's covariance has a negative eigenvalue.")
    return numbers, places, blocks


def draw_worst_maps(run: Run) -> Drawing:
    """Draw the maps with the fewest bits, with the true landmarks."""
    blue = style_of("ekf").colour
    keys = [
        source_key("truth", "start"),
        _disc_key(GREY, GREY, "true landmark"),
        _disc_key("white", GREY, "true landmark, not on your map"),
        _disc_key(blue, "white", "your landmark, 95 %, with a line to its true position"),
    ]
    return draw_worst(run, _plot_map, keys)


def _disc_key(face: str, edge: str, label: str) -> Line2D:
    """Return the legend key of a disc."""
    return Line2D([], [], ls="", marker="o", ms=7, mfc=face, mec=edge, mew=1.3, label=label)


def _plot_map(ax: Axes, kept: Any) -> None:
    """Plot the true landmarks, and a map: means, ellipses and a line from each mean to its true landmark."""
    case, numbers, places, covariance = kept
    plot_field(FIELD, ax)
    plot_landmarks(case.landmarks[numbers], ["post"] * len(numbers), ax, GREY, size=7)
    missing = np.delete(case.landmarks, numbers, axis=0)
    ax.plot(*missing.T, "o", mfc="white", mec=GREY, mew=1.3, ms=6, ls="", zorder=5)
    plot_path([case.start], ax)
    for n, (number, place) in enumerate(zip(numbers, places, strict=True)):
        plot_ellipse(place, covariance[2 * n : 2 * n + 2, 2 * n : 2 * n + 2], ax, "ekf")
        ax.plot(*np.array([place, case.landmarks[number]]).T, color=style_of("ekf").colour, lw=1.2, zorder=4)
    plot_landmarks(places, ["post"] * len(places), ax, size=6)


_LOW, _HIGH = (each / 2 / LANDMARKS for each in band(2 * LANDMARKS, ROBOTS))
CHALLENGE = Challenge(
    lesson="12_beyond",
    title="Challenge 12: the most certain map in twenty moves",
    task=f"{ROBOTS} robots stand among {LANDMARKS} landmarks that no map contains, and each has {MOVES} moves. Write a "
    "function of robot: robot.start is its pose, robot.look() returns numbers, measurements and their covariances, "
    "robot.options(state) returns the moves of exercise 12.7, and robot.move(option) makes a move. Return numbers, "
    "state and covariance: the numbers of your landmarks in the order of your map, and the map as in lesson 07.",
    scoring="bits: the logarithm to the base 2 of your map's probability density at the true landmarks, relative to a "
    "uniform density over the carpet, mean over all robots. A missing landmark adds nothing, and a landmark far "
    f"outside its ellipse costs points. A consistent map has a NEES per coordinate of {_LOW:.1f} to {_HIGH:.1f}.",
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
