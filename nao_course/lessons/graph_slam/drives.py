"""Drives whose constraints are linear: a robot that sidesteps over half a field, and what it measures on the way."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from nao_course.geometry import FloatArray, rotation_2d
from nao_course.sim import Field

Kind = Literal["start", "motion", "measurement"]

# Where the robot stops on its way over the half field, m: two rounds, so that it meets its first landmarks again.
STOPS = np.array(
    [
        *(
            (0.3, -1.3),
            (0.9, -1.5),
            (1.5, -1.5),
            (2.1, -1.4),
            (2.2, -0.8),
            (2.1, -0.2),
            (2.2, 0.5),
            (2.1, 1.2),
        ),
        *((1.5, 1.5), (0.9, 1.5), (0.3, 1.2), (0.3, 0.5), (0.4, -0.1), (0.4, -0.8), (1.0, -1.2)),
    ]
)
SIGHT = 1.7  # m, how far the robot sees a landmark
MOTION_SIGMA = 0.15  # m, of each axis of a step
MEASUREMENT_SIGMA = 0.03  # m, of each axis of an offset


@dataclass(frozen=True, eq=False)
class Constraint:
    """What is known of one variable, or of the difference of two, in both axes.

    Parameters
    ----------
    kind : "start", "motion" or "measurement"
        A start holds its variable `first`; `second` is the same one.
    first, second : int
        Variables: poses come first, landmarks behind them.
    value : ndarray, shape (2,)
        The position, or the difference `second` minus `first`, in metres.
    epsilon : float
        Its variance in each axis, m^2.
    """

    kind: Kind
    first: int
    second: int
    value: FloatArray
    epsilon: float


@dataclass(frozen=True, eq=False)
class Drive:
    """Where a robot was, what is there, and all that it measured.

    Parameters
    ----------
    path : ndarray, shape (P, 2)
        True positions of the robot, m.
    landmarks : ndarray, shape (L, 2)
        True positions of the landmarks, m: variables P to P + L - 1.
    constraints : tuple of Constraint
        In the order in which they came.
    """

    path: FloatArray
    landmarks: FloatArray
    constraints: tuple[Constraint, ...]

    @property
    def truth(self) -> FloatArray:
        """True values of all variables, (P + L, 2) in metres."""
        return np.vstack([self.path, self.landmarks])

    @property
    def size(self) -> int:
        """How many variables there are."""
        return len(self.path) + len(self.landmarks)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the variables: x0, x1, ... and L0, L1, ..."""
        poses = (f"x{number}" for number in range(len(self.path)))
        return (*poses, *(f"L{number}" for number in range(len(self.landmarks))))

    def say(self, constraint: Constraint) -> str:
        """Say what a constraint tells."""
        dx, dy = constraint.value
        first, second = self.names[constraint.first], self.names[constraint.second]
        told = f"{first} is at" if constraint.kind == "start" else f"{second} - {first} ="
        return f"{constraint.kind}: {told} ({dx:z.2f}, {dy:z.2f}) m"


def odometry(constraints: Sequence[Constraint]) -> FloatArray:
    """Add up the start and the motions among some constraints: positions (M, 2) in metres."""
    steps = [each.value for each in constraints if each.kind != "measurement"]
    return np.cumsum(steps, axis=0) if steps else np.zeros((0, 2))


def field_drive(seed: int = 1, noise: float = 1.0, turn: float = 0.0) -> Drive:
    """Drive two rounds over half a field: ahead, back and sideways.

    Parameters
    ----------
    seed : int
        Of the errors.
    noise : float
        Their size; 0 for none, where the variances stay as they are.
    turn : float
        By how much the robot turns on the whole way, rad. What it measures is in its own frame, and by
        default that keeps the field's directions.

    Returns
    -------
    Drive
        With the corners and goal posts of the half field.
    """
    marks = Field(2012, half=True).landmarks
    landmarks = np.array([(each.x, each.y) for each in marks if each.kind != "cross"])
    return drive_along(STOPS, landmarks, np.random.default_rng(seed), noise, turn)


def drive_along(
    path: FloatArray,
    landmarks: FloatArray,
    rng: np.random.Generator,
    noise: float = 1.0,
    turn: float = 0.0,
    sight: float = SIGHT,
) -> Drive:
    """Drive along a path (P, 2), and measure at each stop the landmarks (L, 2) within `sight` metres."""
    frames = [rotation_2d(-turn * step / max(len(path) - 1, 1)) for step in range(len(path))]
    made = [Constraint("start", 0, 0, path[0].copy(), 1.0)]
    for step, at in enumerate(path):
        if step:
            moved = frames[step - 1] @ (at - path[step - 1]) + noise * MOTION_SIGMA * rng.standard_normal(2)
            made.append(Constraint("motion", step - 1, step, moved, MOTION_SIGMA**2))
        for number in np.flatnonzero(np.hypot(*(landmarks - at).T) <= sight):
            seen = frames[step] @ (landmarks[number] - at)
            seen = seen + noise * MEASUREMENT_SIGMA * rng.standard_normal(2)
            made.append(Constraint("measurement", step, len(path) + int(number), seen, MEASUREMENT_SIGMA**2))
    return Drive(path, landmarks, tuple(made))


def odometry_first(drive: Drive) -> tuple[Constraint, ...]:
    """Order a drive's constraints anew: the start, all motions, the first sight of each landmark, then all others."""
    seen: set[int] = set()
    ranks = []
    for each in drive.constraints:
        is_again = each.kind == "measurement" and each.second in seen
        ranks.append(3 if is_again else ("start", "motion", "measurement").index(each.kind))
        seen.add(each.second)
    order = np.argsort(ranks, kind="stable")
    return tuple(drive.constraints[number] for number in order)


def corridor(poses: int, rng: np.random.Generator, width: float = 1.5, sight: float = 2.0) -> Drive:
    """Walk straight on, 0.5 m a step, with a landmark every metre and a half on each side."""
    path = np.column_stack([0.5 * np.arange(poses), np.zeros(poses)])
    along = np.arange(0.0, 0.5 * poses, 1.5)
    landmarks = np.vstack([np.column_stack([along, np.full(len(along), side)]) for side in (-width, width)])
    return drive_along(path, landmarks, rng, sight=sight)
