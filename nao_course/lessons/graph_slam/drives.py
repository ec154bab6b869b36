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
REACH = 1.7  # m, up to which the robot measures a landmark
MOTION_SIGMA = 0.15  # m, of each axis of a step
MEASUREMENT_SIGMA = 0.03  # m, of each axis of an offset


@dataclass(frozen=True, eq=False)
class Constraint:
    """A constraint on one variable, or on the difference of two variables, in both axes.

    Parameters
    ----------
    kind : "start", "motion" or "measurement"
        A start gives the position of its variable `first`; `second` is the same number.
    first, second : int
        Numbers of variables: all poses, and after them all landmarks.
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
class LinearDrive:
    """A drive: the true path and landmarks, and all constraints.

    Parameters
    ----------
    path : ndarray, shape (P, 2)
        True positions of the robot, m.
    landmarks : ndarray, shape (L, 2)
        True positions of the landmarks, m: variables P to P + L - 1.
    constraints : tuple of Constraint
        In the order in which they arrived.
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
        """Number of variables."""
        return len(self.path) + len(self.landmarks)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the variables: x0, x1, ... and L0, L1, ..."""
        poses = (f"x{number}" for number in range(len(self.path)))
        return (*poses, *(f"L{number}" for number in range(len(self.landmarks))))

    def say(self, constraint: Constraint) -> str:
        """Say a constraint in words and numbers."""
        dx, dy = constraint.value
        first, second = self.names[constraint.first], self.names[constraint.second]
        words = f"{first} is at" if constraint.kind == "start" else f"{second} - {first} ="
        return f"{constraint.kind}: {words} ({dx:z.2f}, {dy:z.2f}) m"


def odometry(constraints: Sequence[Constraint]) -> FloatArray:
    """Return the positions, (M, 2) in metres, that follow from the start and the motions alone."""
    steps = [each.value for each in constraints if each.kind != "measurement"]
    return np.cumsum(steps, axis=0) if steps else np.zeros((0, 2))


def field_drive(seed: int = 1, noise: float = 1.0, turn: float = 0.0) -> LinearDrive:
    """Drive two rounds over half a field: ahead, back and sideways.

    Parameters
    ----------
    seed : int
        Seed of the errors.
    noise : float
        Factor of the errors; 0 gives exact constraints. The variances stay the same.
    turn : float
        Angle by which the robot turns during the whole drive, rad. It measures in its own frame, which by default
        stays parallel to the field.

    Returns
    -------
    LinearDrive
        The landmarks are the corners and goal posts of the half field.
    """
    landmarks = Field(2012, half=True).detectable_positions
    return drive_along(STOPS, landmarks, np.random.default_rng(seed), noise, turn)


def drive_along(
    path: FloatArray,
    landmarks: FloatArray,
    rng: np.random.Generator,
    noise: float = 1.0,
    turn: float = 0.0,
    reach: float = REACH,
) -> LinearDrive:
    """Drive along a path (P, 2), and measure at each stop the landmarks (L, 2) within `reach` metres."""
    frames = [rotation_2d(-turn * step / max(len(path) - 1, 1)) for step in range(len(path))]
    made = [Constraint("start", 0, 0, path[0].copy(), 1.0)]
    for step, at in enumerate(path):
        if step:
            moved = frames[step - 1] @ (at - path[step - 1]) + noise * MOTION_SIGMA * rng.standard_normal(2)
            made.append(Constraint("motion", step - 1, step, moved, MOTION_SIGMA**2))
        for number in np.flatnonzero(np.hypot(*(landmarks - at).T) <= reach):
            seen = frames[step] @ (landmarks[number] - at)
            seen = seen + noise * MEASUREMENT_SIGMA * rng.standard_normal(2)
            made.append(Constraint("measurement", step, len(path) + int(number), seen, MEASUREMENT_SIGMA**2))
    return LinearDrive(path, landmarks, tuple(made))


def odometry_first(drive: LinearDrive) -> tuple[Constraint, ...]:
    """Sort the constraints: the start, all motions, the first measurement of each landmark, then all others."""
    seen: set[int] = set()
    ranks = []
    for each in drive.constraints:
        is_again = each.kind == "measurement" and each.second in seen
        ranks.append(3 if is_again else ("start", "motion", "measurement").index(each.kind))
        seen.add(each.second)
    order = np.argsort(ranks, kind="stable")
    return tuple(drive.constraints[number] for number in order)


def corridor(poses: int, rng: np.random.Generator, width: float = 1.5, reach: float = 2.0) -> LinearDrive:
    """Walk straight on, 0.5 m a step, with a landmark every metre and a half on each side."""
    path = np.column_stack([0.5 * np.arange(poses), np.zeros(poses)])
    along = np.arange(0.0, 0.5 * poses, 1.5)
    landmarks = np.vstack([np.column_stack([along, np.full(len(along), side)]) for side in (-width, width)])
    return drive_along(path, landmarks, rng, reach=reach)
