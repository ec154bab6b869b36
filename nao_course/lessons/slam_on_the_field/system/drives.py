"""Drives over the half field: somebody who sees the robot steers it, and it takes pictures at every stop."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from nao_course.exercises.codec import register
from nao_course.geometry import FloatArray, Pose
from nao_course.sim import (
    Field,
    OdometryNoise,
    Picture,
    PictureTruth,
    Reality,
    SimulatedNao,
    TorsoTilt,
    Truth,
)
from nao_course.slam import Motion

MOVES, STEP, SHARPEST = 60, 0.25, float(np.radians(50))  # of a drive; m and rad of a move
YAWS = (0.8, 0.0, -0.8)  # rad: three looks that overlap a little, 61 degrees wide each
HEAD_PITCH = float(np.radians(-31.0))  # up: the bottom camera's own pitch is 39.7 degrees
LEAN = TorsoTilt(
    float(np.radians(1.3)), float(np.radians(0.8))
)  # a picture; as of real ones (docs/real_data.md)
INSIDE = ((0.25, -1.75), (2.75, 1.75))  # m, where the robot is steered to
NEAREST_GOAL, SMALLEST_TURN = 1.2, float(np.radians(30))  # from one goal to the next
GOAL_LINE = 3.0  # m, of the half field of 2012
LEAST_SIGMA = 0.001  # m: a robot that only turns does not stay on the very spot


@register
@dataclass(frozen=True)
class FieldOdometry(OdometryNoise):
    """Odometry that errs by a tenth of each way: 10 % along, 5 % across, 10 % and 1 degree of turn.

    Other than `OdometryNoise`, whose variances grow with the way, these are standard deviations of a single move.

    Parameters
    ----------
    factor : float
        How much worse than that it is.
    """

    along: float = 0.10
    across: float = 0.05
    turn: float = float(np.radians(1.0))
    turn_per_turn: float = 0.10
    factor: float = 1.0

    def covariance(self, motion: Motion) -> FloatArray:
        """Covariance (3, 3) of (along, across, turn) for a motion, in the robot frame; m^2 and rad^2."""
        way = abs(motion.distance)
        turn = self.turn + self.turn_per_turn * abs(motion.turn)
        sigmas = np.array([self.along * way + LEAST_SIGMA, self.across * way + LEAST_SIGMA, turn])
        return np.diag((self.factor * sigmas) ** 2)


@dataclass(frozen=True, eq=False)
class Shot:
    """A picture of a drive, and what is true of it.

    Parameters
    ----------
    motion : Motion or None
        The command before it; None where the robot only turned its head.
    picture : Picture
        What it shows, and what the robot believes of its camera.
    pose : Pose
        Where the robot is, in the field's frame.
    truth : PictureTruth
        What the picture really shows.
    """

    motion: Motion | None
    picture: Picture
    pose: Pose
    truth: PictureTruth


def start_of(seed: int) -> Pose:
    """Where a drive begins, in the field's frame: near the halfway line, looking at the goal. The robot knows it."""
    x, y, turn = np.random.default_rng([seed, 11]).uniform((0.3, -1.0, -0.3), (0.7, 1.0, 0.3))
    return Pose(float(x), float(y), float(np.arctan2(-y, GOAL_LINE - x) + turn))


def drive_over_field(
    seed: int,
    *,
    factor: float = 1.0,
    moves: int = MOVES,
    yaws: Sequence[float] = YAWS,
    reality: Reality | None = None,
) -> Iterator[Shot]:
    """Drive over the half field and take pictures at each stop; rendered one by one, as they are asked for.

    Parameters
    ----------
    seed : int
        Of start, ways, odometry, lean and room: the same seed gives the same drive.
    factor : float
        How much worse the odometry is than `FieldOdometry`.
    moves : int
        How many moves.
    yaws : sequence of float
        Where the head turns at each stop, rad.
    reality : Reality, optional
        How real the pictures look; by default the preset `lab` in a room of the seed's.

    Yields
    ------
    Shot
        One for each picture: as many at each stop as there are yaws, (moves + 1) stops.
    """
    nao = SimulatedNao(
        Field(2012),
        start_of(seed),
        np.random.default_rng([seed, 12]),
        odometry_noise=FieldOdometry(factor=factor),
        tilt=LEAN,
        reality=reality or Reality.lab(seed),
    )
    world, driver = Truth(nao), Driver(np.random.default_rng([seed, 13]))
    for stop in range(moves + 1):
        motion = driver.next(world.pose) if stop else None
        if motion is not None:
            nao.move(motion)
        for yaw in yaws:
            nao.look(yaw, HEAD_PITCH)
            picture = nao.take_picture()
            assert world.picture is not None
            yield Shot(motion, picture, world.pose, world.picture)
            motion = None


class Driver:
    """Steers a robot from goal to goal inside the field; it sees where the robot is.

    Parameters
    ----------
    rng : numpy.random.Generator
        Of the goals.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        """Begin without a goal."""
        self._rng = rng
        self._goal: FloatArray | None = None

    def next(self, pose: Pose) -> Motion:
        """Return the next command: ahead as far as there is room, then turn towards the goal."""
        step = _room_ahead(pose)
        there = pose @ Pose(step, 0.0, 0.0)
        if self._goal is None or np.hypot(*there.to_local(self._goal)[0]) < STEP:
            self._goal = self._new_goal(there)
        ahead, left = there.to_local(self._goal)[0]
        return Motion(step, float(np.clip(np.arctan2(left, ahead), -SHARPEST, SHARPEST)))

    def _new_goal(self, pose: Pose) -> FloatArray:
        """A place that is not too near, and not straight ahead."""
        while True:
            goal = self._rng.uniform(*INSIDE)
            ahead, left = pose.to_local(goal)[0]
            if np.hypot(ahead, left) >= NEAREST_GOAL and abs(np.arctan2(left, ahead)) > SMALLEST_TURN:
                return goal


def _room_ahead(pose: Pose) -> float:
    """How far the robot may walk ahead, m: a step at most, and not out of the field."""
    low, high = np.array(INSIDE)
    here, way = np.array([pose.x, pose.y]), np.array([np.cos(pose.theta), np.sin(pose.theta)])
    with np.errstate(divide="ignore"):
        room = np.where(way > 0, high - here, low - here) / way
    return float(np.clip(room.min(), 0.0, STEP))
