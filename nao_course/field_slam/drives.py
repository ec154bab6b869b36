"""Simulated drives over a field: a driver who knows the true pose steers, and the robot takes pictures."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from nao_course.codec import register
from nao_course.geometry import FloatArray, Pose, rotation_2d
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

MOVES = 60  # of a drive
STEP, SHARPEST = 0.25, float(np.radians(50))  # m and rad: longest step and sharpest turn of a move
YAWS = (0.8, 0.0, -0.8)  # rad: three pictures of 61 degrees each, which overlap a little
# The head is raised, because the bottom camera itself looks down by 39.7 degrees.
HEAD_PITCH = float(np.radians(-31.0))
# Standard deviations of the body tilt, as measured on real pictures (docs/real_data.md).
TILT = TorsoTilt(float(np.radians(1.3)), float(np.radians(0.8)))
FROM_LINES = 0.25  # m: least distance of the robot from the field's outer lines
NEAREST_GOAL, SMALLEST_TURN = 1.2, float(np.radians(30))  # m and rad: a new goal is at least this far away
SMALLEST_FIELD = (2.0, 2.0)  # m, along x and y: on a smaller one, there is not always a goal as far away
LEAST_SIGMA = 0.001  # m: also a robot that only turns moves a little
CARRIED = 1.5  # m: a robot that is carried away is put down at least this far away
PLACES = 64  # number of random poses of which the first that is far enough away is used

Area = tuple[tuple[float, float], tuple[float, float]]


def inside(field: Field) -> Area:
    """Return the lower left and the upper right corner of the area of a field where the robot drives, m.

    Raise a ValueError if the field is too small for a drive.
    """
    (x0, x1), (y0, y1) = field.x_range, field.y_range
    if x1 - x0 < SMALLEST_FIELD[0] or y1 - y0 < SMALLEST_FIELD[1]:
        raise ValueError(
            f"a drive needs a field of at least {SMALLEST_FIELD[0]:g} x {SMALLEST_FIELD[1]:g} m between its lines, "
            f"got {x1 - x0:g} x {y1 - y0:g} m"
        )
    return (x0 + FROM_LINES, y0 + FROM_LINES), (x1 - FROM_LINES, y1 - FROM_LINES)


INSIDE = inside(Field(2012))


@register
@dataclass(frozen=True)
class OdometryNoisePerMove(OdometryNoise):
    """Odometry noise with a standard deviation in proportion to each move.

    The variances of `OdometryNoise` grow in proportion to the distance. Here, the standard deviations do: 10 % of the
    distance along, 5 % across, and 1 degree plus 10 % of the turn.

    Parameters
    ----------
    along, across : float
        Standard deviations along and across the motion, m per m.
    turn : float
        Constant part of the standard deviation of the turn, rad.
    turn_per_turn : float
        Part of the standard deviation of the turn that grows with the turn, rad per rad.
    factor : float
        Factor for all standard deviations.
    """

    along: float = 0.10
    across: float = 0.05
    turn: float = float(np.radians(1.0))
    turn_per_turn: float = 0.10
    factor: float = 1.0

    def covariance(self, motion: Motion) -> FloatArray:
        """Return the covariance (3, 3) of the errors along, across and in turn, robot frame, m^2 and rad^2."""
        distance = abs(motion.distance)
        turn = self.turn + self.turn_per_turn * abs(motion.turn)
        sigmas = np.array([self.along * distance + LEAST_SIGMA, self.across * distance + LEAST_SIGMA, turn])
        return np.diag((self.factor * sigmas) ** 2)


@dataclass(frozen=True, eq=False)
class Shot:
    """A picture of a drive, with the ground truth.

    The motion was commanded before the picture, and is None if the robot only turned its head. The picture has the
    assumed view; the pose, in the field frame, and the view in `truth` are the true ones. Before the picture, the robot
    may have been `carried` away.
    """

    motion: Motion | None
    picture: Picture
    pose: Pose
    truth: PictureTruth
    carried: bool = False


def start_of(seed: int, field: Field | None = None) -> Pose:
    """Return the first pose of a drive in the field frame: near the halfway line, facing the centre of a goal line."""
    field = field or Field(2012)
    goal_line, aside = field.x_range[1], field.dimensions.width / 4
    x, y, turn = np.random.default_rng([seed, 11]).uniform((0.3, -aside, -0.3), (0.7, aside, 0.3))
    return Pose(float(x), float(y), float(np.arctan2(-y, goal_line - x) + turn))


def drive_over_field(
    seed: int,
    *,
    factor: float = 1.0,
    moves: int = MOVES,
    yaws: Sequence[float] = YAWS,
    reality: Reality | None = None,
    field: Field | None = None,
    carried: int | None = None,
) -> Iterator[Shot]:
    """Drive over a field and yield the pictures of each stop, which are rendered one at a time.

    There is a picture for each yaw angle (rad) of the head at each of the (moves + 1) stops. The same seed gives the
    same drive; `factor` scales the standard deviations of `OdometryNoisePerMove`. By default, the field is half a field
    by the rules of 2012, and `reality` is the preset `lab` in a room that depends on the seed. Before stop number
    `carried`, counted from 0, the robot is put down elsewhere, and the motion to this stop is zero.
    """
    field = field or Field(2012)
    nao = SimulatedNao(
        field,
        start_of(seed, field),
        np.random.default_rng([seed, 12]),
        odometry_noise=OdometryNoisePerMove(factor=factor),
        tilt=TILT,
        reality=reality or Reality.lab(seed),
    )
    world, driver = Truth(nao), Driver(np.random.default_rng([seed, 13]), inside(field))
    for stop in range(moves + 1):
        motion, away = None, stop == carried
        if away:
            motion = Motion()
            world.place(_elsewhere(world.pose, inside(field), np.random.default_rng([seed, 14])))
        elif stop:
            motion = driver.next(world.pose)
            nao.move(motion)
        for yaw in yaws:
            nao.look(yaw, HEAD_PITCH)
            picture = nao.take_picture()
            assert world.picture is not None
            yield Shot(motion, picture, world.pose, world.picture, away)
            motion, away = None, False


def _elsewhere(pose: Pose, area: Area, rng: np.random.Generator) -> Pose:
    """Return a random pose in an area, at least CARRIED away from another pose if the area is large enough."""
    poses = rng.uniform((*area[0], -np.pi), (*area[1], np.pi), (PLACES, 3))
    distance = np.hypot(*(poses[:, :2] - (pose.x, pose.y)).T)
    return Pose.from_array(poses[np.minimum(distance, CARRIED).argmax()])


class Driver:
    """A driver who knows the true pose of the robot and steers it from goal to goal inside the field.

    The area is its lower left and its upper right corner, m.
    """

    def __init__(self, rng: np.random.Generator, area: Area = INSIDE) -> None:
        """Start without a goal."""
        self._rng, self._area = rng, area
        self._goal: FloatArray | None = None

    def next(self, pose: Pose) -> Motion:
        """Return the next motion: a step ahead that stays inside the field, then a turn towards the goal."""
        step = room_ahead(pose.as_array(), STEP, self._area)
        there = pose @ Pose(step, 0.0, 0.0)
        if self._goal is None or np.hypot(*there.to_local(self._goal)[0]) < STEP:
            self._goal = self._new_goal(there)
        ahead, left = there.to_local(self._goal)[0]
        return Motion(step, float(np.clip(np.arctan2(left, ahead), -SHARPEST, SHARPEST)))

    def _new_goal(self, pose: Pose) -> FloatArray:
        """Return a random goal that is neither too near nor straight ahead."""
        while True:
            goal = self._rng.uniform(*self._area)
            ahead, left = pose.to_local(goal)[0]
            if np.hypot(ahead, left) >= NEAREST_GOAL and abs(np.arctan2(left, ahead)) > SMALLEST_TURN:
                return goal


def room_ahead(pose: FloatArray, step: float, area: Area = INSIDE) -> float:
    """Return how far the robot can walk ahead from a pose (3,) without leaving an area, m; at most one step."""
    position, heading = pose[:2], rotation_2d(float(pose[2]))[:, 0]
    to_edge = np.where(heading > 0, area[1] - position, area[0] - position)
    # The robot never reaches an edge that is parallel to its heading.
    room = np.divide(to_edge, heading, out=np.full(2, np.inf), where=heading != 0)
    return float(np.clip(room.min(), 0.0, step))
