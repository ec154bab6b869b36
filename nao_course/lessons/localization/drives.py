"""Drives on a field whose landmarks are known: commands, sights and the truth, and a filter's way along one."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.metrics import squared_distances
from nao_course.sim import Field, OdometryNoise, SensorNoise, repeat_drive
from nao_course.slam import LandmarkKind, Measurement, Motion, range_and_bearing

FIELD = Field(2012)
_MARKS = [mark for mark in FIELD.landmarks if mark.kind != "cross"]
LANDMARKS: FloatArray = np.array([(mark.x, mark.y) for mark in _MARKS])  # (10, 2), m, field frame
KINDS: tuple[LandmarkKind, ...] = tuple("post" if mark.kind == "post" else "corner" for mark in _MARKS)

START = Pose(1.4, -0.8, 0.0)  # in the field frame
LAP = (Motion(0.2, 0.25),) * 30  # 6 m on a circle of 0.8 m: a lap and a bit
START_COVARIANCE = np.diag([0.1**2, 0.1**2, np.radians(5) ** 2])  # m^2, rad^2
REACH = 2.5  # m, our choice: beyond some 2 m a range from one picture is poor (lesson 04)
SIDEWAYS = float(np.radians(60))  # two pictures side by side, 61 degrees wide each
_STEP = 1e-6  # of central differences, m and rad
_SHIFTS = _STEP * np.vstack([np.eye(3), -np.eye(3)])


@dataclass(frozen=True, eq=False)
class Sight:
    """One known landmark, as it is measured.

    Parameters
    ----------
    landmark : int
        Which: a row of `LANDMARKS`. Nobody has to guess it in this lesson.
    measurement : ndarray, shape (2,)
        (bearing, range) in rad and m.
    covariance : ndarray, shape (2, 2)
        Of its noise, in rad^2 and m^2.
    """

    landmark: int
    measurement: FloatArray
    covariance: FloatArray

    @property
    def position(self) -> FloatArray:
        """Where the landmark is, (2,), m in the field frame."""
        return LANDMARKS[self.landmark].copy()


@dataclass(frozen=True, eq=False)
class Drive:
    """A drive as the simulator knows it.

    Parameters
    ----------
    truth : ndarray, shape (M + 1, 3)
        Poses at the start and after each command, field frame.
    controls : ndarray, shape (M, 2)
        (distance, turn) as commanded, m and rad.
    control_covariances : ndarray, shape (M, 3, 3)
        Of (along, across, turn) in the robot frame, m^2 and rad^2.
    sights : tuple of tuple of Sight
        What is seen after each command.
    """

    truth: FloatArray
    controls: FloatArray
    control_covariances: FloatArray
    sights: tuple[tuple[Sight, ...], ...]


def look_at(pose: npt.ArrayLike, landmark: int, noise: SensorNoise, rng: np.random.Generator) -> Sight:
    """Measure one landmark from a true pose (3,), with noise; its covariance is that at the measured range."""
    bearing, distance = range_and_bearing(pose, LANDMARKS[landmark])
    e_bearing, e_range = rng.standard_normal(2)
    bearing = float(wrap_angle(bearing + noise.bearing * e_bearing))
    distance = float(distance * (1 + noise.range_fraction * e_range))
    covariance = noise.covariance(Measurement(bearing, max(distance, 0.05)))
    return Sight(landmark, np.array([bearing, distance]), covariance)


def make_drive(
    rng: np.random.Generator,
    commands: Sequence[Motion] = LAP,
    odometry: OdometryNoise | None = None,
    sensor: SensorNoise | None = None,
    start: Pose = START,
) -> Drive:
    """Drive over the half field and look at every landmark within reach after each command.

    Parameters
    ----------
    rng : numpy.random.Generator
        Of all errors.
    commands : sequence of Motion
        By default a lap and a bit.
    odometry, sensor : OdometryNoise, SensorNoise
        By default the robot's own; with zeros the drive is exact.
    start : Pose
        Where the robot truly starts.

    Returns
    -------
    Drive
        With M sets of sights.
    """
    odometry, sensor = odometry or OdometryNoise(), sensor or SensorNoise()
    local = repeat_drive(list(commands), 1, rng, odometry)[0]
    xy = start.to_parent(local[:, :2])
    truth = np.column_stack([xy, wrap_angle(local[:, 2] + start.theta)])
    sights = tuple(
        tuple(look_at(pose, number, sensor, rng) for number in within_reach(pose)) for pose in truth[1:]
    )
    controls = np.array([(motion.distance, motion.turn) for motion in commands])
    return Drive(truth, controls, np.array([odometry.covariance(motion) for motion in commands]), sights)


def within_reach(pose: npt.ArrayLike, reach: float = REACH, sideways: float = SIDEWAYS) -> list[int]:
    """Numbers of the landmarks that the head can see from a pose (3,) without the body's turning."""
    seen = range_and_bearing(np.asarray(pose, dtype=float), LANDMARKS)
    return [
        int(number) for number in np.flatnonzero((np.abs(seen[:, 0]) <= sideways) & (seen[:, 1] <= reach))
    ]


@dataclass(frozen=True, eq=False)
class Trace:
    """What a filter believed along a drive.

    Parameters
    ----------
    truth, poses : ndarray, shape (M + 1, 3)
        Where the robot was and where it is believed to be.
    covariances : ndarray, shape (M + 1, 3, 3)
        Of the believed pose.
    innovations : ndarray, shape (K, 2)
        Measured less expected before each update: rad, m.
    spreads : ndarray, shape (K, 2, 2)
        The covariance that each should have, S.
    steps : ndarray of int, shape (K,)
        After which command.
    """

    truth: FloatArray
    poses: FloatArray
    covariances: FloatArray
    innovations: FloatArray
    spreads: FloatArray
    steps: npt.NDArray[np.int_]

    @property
    def errors(self) -> FloatArray:
        """Believed less true pose, (M + 1, 3), the heading wrapped."""
        off = self.poses - self.truth
        return np.column_stack([off[:, :2], wrap_angle(off[:, 2])])

    @property
    def nees(self) -> FloatArray:
        """Normalised estimation error squared of each pose, (M + 1,)."""
        return squared_distances(self.errors, self.covariances)

    @property
    def nis(self) -> FloatArray:
        """Normalised innovation squared of each measurement, (K,)."""
        return squared_distances(self.innovations, self.spreads)


def follow(
    drive: Drive,
    localize: Callable[..., Any],
    predict_pose: Callable[..., Any],
    predict_covariance: Callable[..., Any],
    covariance: npt.ArrayLike = START_COVARIANCE,
    error: npt.ArrayLike = (0.0, 0.0, 0.0),
) -> Trace:
    """Run a student's filter along a drive.

    Parameters
    ----------
    drive : Drive
        What the robot is told, and sees.
    localize, predict_pose, predict_covariance : callable
        The student's.
    covariance : array_like, shape (3, 3)
        Of the belief at the start.
    error : array_like, shape (3,)
        How far the belief is off at the start: believed less true pose.

    Returns
    -------
    Trace
        Innovations and their covariances are computed here, from what the filter believes before each update.
    """
    pose, spread = drive.truth[0] + np.asarray(error, dtype=float), np.array(covariance, dtype=float)
    poses, covariances = [pose], [spread]
    innovations, spreads, steps = list[FloatArray](), list[FloatArray](), list[int]()
    given = zip(drive.controls, drive.control_covariances, drive.sights, strict=True)
    for step, (control, noise, sights) in enumerate(given, start=1):
        spread = checked(predict_covariance(spread, pose, control, noise), (3, 3), "predict_covariance")
        pose = checked(predict_pose(pose, control), (3,), "predict_pose")
        pose[2] = wrap_angle(pose[2])
        for sight in sights:
            surprise, expected_spread = judged(pose, spread, sight)
            innovations.append(surprise)
            spreads.append(expected_spread)
            steps.append(step)
            pose, spread = updated(localize, pose, spread, sight)
        poses.append(pose)
        covariances.append(spread)
    return Trace(
        drive.truth,
        np.array(poses),
        np.array(covariances),
        np.array(innovations).reshape(-1, 2),
        np.array(spreads).reshape(-1, 2, 2),
        np.array(steps, dtype=int),
    )


def updated(
    localize: Callable[..., Any], pose: FloatArray, covariance: FloatArray, sight: Sight
) -> tuple[FloatArray, FloatArray]:
    """Give one sight to a student's `localize`, and take pose (3,) and covariance (3, 3) from it."""
    answer = localize(
        pose.copy(), covariance.copy(), sight.measurement.copy(), sight.position, sight.covariance.copy()
    )
    if not isinstance(answer, tuple | list) or len(answer) != 2:
        raise ValueError(f"localize must return (pose, covariance), got {type(answer).__name__}")
    return checked(answer[0], (3,), "localize: pose"), checked(answer[1], (3, 3), "localize: covariance")


def checked(value: Any, shape: tuple[int, ...], name: str) -> FloatArray:
    """Return an array of this shape; another one is a ValueError that names whose it is."""
    array = np.array(value, dtype=float)
    if array.shape != shape:
        raise ValueError(f"{name} must have shape {shape}, got {array.shape}")
    return array


def judged(pose: FloatArray, covariance: FloatArray, sight: Sight) -> tuple[FloatArray, FloatArray]:
    """The innovation (2,) of a sight, and the covariance (2, 2) it should have by what is believed."""
    x, y, theta = pose.tolist()
    away = complex(*sight.position) - complex(x, y)
    near = away - _SHIFTS @ (1.0, 1j, 0.0)  # from poses a little beside
    bearings = np.angle(near * away.conjugate()) - _SHIFTS[:, 2]
    changes = np.stack([bearings, np.abs(near)], axis=1)
    slopes = (changes[:3] - changes[3:]) / (2 * _STEP)
    bearing = wrap_angle(sight.measurement[0] - (np.angle(away) - theta))
    return np.array(
        [bearing, sight.measurement[1] - abs(away)]
    ), slopes.T @ covariance @ slopes + sight.covariance


def follow_many(
    seeds: Iterable[int],
    localize: Callable[..., Any],
    predict_pose: Callable[..., Any],
    predict_covariance: Callable[..., Any],
) -> list[Trace]:
    """Run a student's filter along many drives, each begun with a wrong belief that its covariance is honest about.

    Parameters
    ----------
    seeds : iterable of int
        One for each drive.
    localize, predict_pose, predict_covariance : callable
        The student's.

    Returns
    -------
    list of Trace
        One for each seed.
    """
    laps = map(lap, seeds)
    return [follow(drive, localize, predict_pose, predict_covariance, error=error) for drive, error in laps]


@cache
def lap(seed: int) -> tuple[Drive, FloatArray]:
    """One of the lesson's drives, and by how much the belief is off at its start; the same at each call."""
    rng = np.random.default_rng([6, seed])
    drive = make_drive(rng)
    return drive, rng.standard_normal(3) * np.sqrt(np.diag(START_COVARIANCE))
