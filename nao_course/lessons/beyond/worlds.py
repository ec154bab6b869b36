"""Drives over the half field on which somebody names the landmarks: what is commanded, what is seen, what is true."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from nao_course.geometry import FloatArray, Pose, rotation_2d, wrap_angle
from nao_course.sim import Field, OdometryNoise, SensorNoise
from nao_course.slam import LandmarkKind, Measurement, Motion, range_and_bearing

FIELD = Field(2012)
_MARKS = [mark for mark in FIELD.landmarks if mark.kind != "cross"]
LANDMARKS: FloatArray = np.array([(mark.x, mark.y) for mark in _MARKS])
KINDS: tuple[LandmarkKind, ...] = tuple("post" if mark.kind == "post" else "corner" for mark in _MARKS)
INSIDE = ((0.25, -1.75), (2.75, 1.75))  # m: lower and upper end of where the robot drives
NEAREST = 0.4  # m: nothing nearer is measured
SENSOR = SensorNoise()


@dataclass(frozen=True)
class DriveNoise(OdometryNoise):
    """Odometry that errs by 10 % along, 5 % across, and 10 % and 1 degree of turn: standard deviations of a move."""

    along: float = 0.10
    across: float = 0.05
    turn: float = float(np.radians(1.0))
    turn_per_turn: float = 0.10

    def covariance(self, motion: Motion) -> FloatArray:
        """Covariance (3, 3) of (along, across, turn) for a motion, in the robot frame; m^2 and rad^2."""
        way, least = abs(motion.distance), 0.001
        sigmas = (
            self.along * way + least,
            self.across * way + least,
            self.turn + self.turn_per_turn * abs(motion.turn),
        )
        return np.diag(np.square(sigmas))


ODOMETRY = DriveNoise()


@dataclass(frozen=True)
class Eye:
    """How far a robot sees without turning its body.

    Parameters
    ----------
    sideways : float
        To either side, rad.
    reach : float
        Farthest, m.
    """

    sideways: float
    reach: float

    def sees(self, poses: FloatArray, landmarks: FloatArray) -> np.ndarray:
        """Which landmarks (k, 2) are seen from poses (..., 1, 3) or (3,): booleans (..., k)."""
        seen = range_and_bearing(poses, landmarks)
        return (
            (np.abs(seen[..., 0]) <= self.sideways) & (seen[..., 1] >= NEAREST) & (seen[..., 1] <= self.reach)
        )


AHEAD = Eye(float(np.radians(30.0)), 3.0)  # one picture, 61 degrees wide
AROUND = Eye(float(np.radians(60.0)), 2.5)  # two pictures side by side


@dataclass(frozen=True, eq=False)
class Step:
    """One step of a drive.

    Parameters
    ----------
    motion : Motion or None
        The command; None at the start.
    numbers : ndarray of int, shape (n,)
        Which landmarks are seen afterwards.
    measurements : ndarray, shape (n, 2)
        Their (bearing, range), rad and m.
    pose : ndarray, shape (3,)
        The true one, field frame.
    """

    motion: Motion | None
    numbers: np.ndarray
    measurements: FloatArray
    pose: FloatArray


Chooser = Callable[[], Motion]


def drive(
    start: Pose, choose: Chooser, moves: int, rng: np.random.Generator, eye: Eye = AROUND
) -> Iterator[Step]:
    """Drive, and look after each move; the command is asked for when it is its turn.

    Parameters
    ----------
    start : Pose
        The true one, field frame.
    choose : callable
        ``choose() -> Motion``, the next command.
    moves : int
        How many; there is one more step, the start's.
    rng : numpy.random.Generator
        Of all errors.
    eye : Eye
        What is seen.

    Yields
    ------
    Step
        The start's first.
    """
    pose = start.as_array()
    for number in range(moves + 1):
        motion = choose() if number else None
        if motion is not None:
            pose = moved(pose, motion, rng.standard_normal(3))
        numbers = np.flatnonzero(eye.sees(pose, LANDMARKS))
        seen = range_and_bearing(pose, LANDMARKS[numbers])
        noise = rng.standard_normal(seen.shape)
        seen[:, 0] = wrap_angle(seen[:, 0] + SENSOR.bearing * noise[:, 0])
        seen[:, 1] *= np.maximum(1 + SENSOR.range_fraction * noise[:, 1], 0.1)
        yield Step(motion, numbers, seen, pose.copy())


def moved(poses: FloatArray, motion: Motion, draws: FloatArray) -> FloatArray:
    """Move poses (..., 3) by a command, with the errors that standard normal draws (..., 3) give them."""
    errors = draws * np.sqrt(np.diag(ODOMETRY.covariance(motion)))
    poses = np.array(poses, dtype=float)
    along, across = motion.distance + errors[..., 0], errors[..., 1]
    cos, sin = np.cos(poses[..., 2]), np.sin(poses[..., 2])
    poses[..., 0] += cos * along - sin * across
    poses[..., 1] += sin * along + cos * across
    poses[..., 2] = wrap_angle(poses[..., 2] + motion.turn + errors[..., 2])
    return poses


def noise_of(measurement: FloatArray) -> FloatArray:
    """Covariance R (2, 2) of one measurement (bearing, range), rad^2 and m^2."""
    return SENSOR.covariance(Measurement(float(measurement[0]), float(measurement[1])))


def room_ahead(pose: FloatArray, step: float) -> float:
    """How far a robot may walk ahead, m: a step, or as far as it stays inside."""
    here, way = pose[:2], rotation_2d(float(pose[2]))[:, 0]
    left = np.where(way > 0, INSIDE[1] - here, INSIDE[0] - here)
    room = np.divide(left, way, out=np.full(2, np.inf), where=way != 0)  # along an edge there is no end
    return float(np.clip(room.min(), 0.0, step))
