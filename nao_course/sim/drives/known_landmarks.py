"""Simulated drives in which the landmark of each measurement is known."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.sim.nao import OdometryNoise
from nao_course.slam import Motion, range_and_bearing


class Sensor(Protocol):
    """Noise model of measurements (bearing, range), such as `Sigmas` or `SensorNoise`."""

    def disturbed(self, exact: FloatArray, draws: FloatArray) -> FloatArray:
        """Add errors to exact measurements (..., 2), computed from standard normal samples (..., 2)."""
        ...

    def covariances(self, measurements: FloatArray) -> FloatArray:
        """Return the covariances (n, 2, 2) of measurements (n, 2), rad^2 and m^2."""
        ...


@dataclass(frozen=True)
class Sigmas:
    """Standard deviations that a filter assumes or a simulator uses; by default the homework's values.

    Parameters
    ----------
    along, across : float
        Standard deviations of a step, ahead and to the left of the robot, m (sigma_x and sigma_y).
    turn : float
        Standard deviation of a turn, rad (sigma_alpha).
    bearing : float
        Standard deviation of a measured bearing, rad (sigma_beta).
    range : float
        Standard deviation of a measured range, m (sigma_r).
    """

    along: float = 0.25
    across: float = 0.1
    turn: float = 0.1
    bearing: float = 0.01
    range: float = 0.08

    @property
    def control_covariance(self) -> FloatArray:
        """Covariance (3, 3) of the errors along, across and in turn, robot frame, m^2 and rad^2."""
        return np.diag([self.along, self.across, self.turn]) ** 2

    @property
    def measurement_covariance(self) -> FloatArray:
        """Covariance (2, 2) of bearing and range, rad^2 and m^2."""
        return np.diag([self.bearing, self.range]) ** 2

    def scaled(self, name: str, factor: float) -> Sigmas:
        """Return a copy with one standard deviation multiplied by a factor."""
        return replace(self, **{name: factor * getattr(self, name)})

    def times(self, factor: float) -> Sigmas:
        """Return a copy with all standard deviations multiplied by a factor."""
        return Sigmas(*(factor * each for each in vars(self).values()))

    def disturbed(self, exact: FloatArray, draws: FloatArray) -> FloatArray:
        """Add errors to exact measurements (..., 2), computed from standard normal samples (..., 2)."""
        return _wrapped(exact + draws * (self.bearing, self.range))

    def covariances(self, measurements: FloatArray) -> FloatArray:
        """Return the covariances (n, 2, 2) of measurements (n, 2), which are all the same, rad^2 and m^2."""
        return np.tile(self.measurement_covariance, (len(measurements), 1, 1))


def _wrapped(measurements: FloatArray) -> FloatArray:
    measurements[..., 0] = wrap_angle(measurements[..., 0])
    return measurements


@dataclass(frozen=True)
class FieldOfView:
    """The region, relative to the robot, in which it can measure landmarks.

    Parameters
    ----------
    sideways : float
        Largest absolute bearing, rad.
    reach : float
        Largest range, m.
    nearest : float
        Smallest range, m.
    """

    sideways: float
    reach: float
    nearest: float = 0.0

    def sees(self, poses: npt.ArrayLike, landmarks: npt.ArrayLike) -> npt.NDArray[np.bool_]:
        """Return whether landmarks (k, 2) are in view from poses (..., 1, 3) or (3,), as booleans (..., k)."""
        return self.contains(range_and_bearing(poses, landmarks))

    def contains(self, measurements: FloatArray) -> npt.NDArray[np.bool_]:
        """Return whether measurements (..., 2) are inside the field of view, as booleans (...)."""
        bearings, ranges = np.abs(measurements[..., 0]), measurements[..., 1]
        return np.asarray((bearings <= self.sideways) & (ranges >= self.nearest) & (ranges <= self.reach))


@dataclass(frozen=True, eq=False)
class Step:
    """A step of a drive: a motion, and the measurements after it.

    Parameters
    ----------
    pose : ndarray, shape (3,)
        True pose after the motion, m and rad.
    motion : Motion or None
        Commanded motion; None at the start.
    control_covariance : ndarray, shape (3, 3)
        Covariance of the motion's errors along, across and in turn, m^2 and rad^2; zeros at the start.
    numbers : ndarray of int, shape (n,)
        Indices of the measured landmarks.
    measurements : ndarray, shape (n, 2)
        Bearing and range of each, rad and m.
    covariances : ndarray, shape (n, 2, 2)
        Covariance of each measurement, rad^2 and m^2.
    """

    pose: FloatArray
    motion: Motion | None
    control_covariance: FloatArray
    numbers: npt.NDArray[np.intp]
    measurements: FloatArray
    covariances: FloatArray

    @classmethod
    def at_start(cls, pose: FloatArray) -> Step:
        """Return the first step of a drive, without a motion and without measurements."""
        nothing = np.zeros((0, 2))
        return cls(
            pose, None, np.zeros((3, 3)), np.zeros(0, dtype=np.intp), nothing, nothing.reshape(0, 2, 2)
        )

    @property
    def control(self) -> FloatArray:
        """Commanded (distance, turn), m and rad; zeros at the start."""
        return np.array([self.motion.distance, self.motion.turn] if self.motion else [0.0, 0.0])


@dataclass(frozen=True, eq=False)
class Drive:
    """A simulated drive with its ground truth.

    Parameters
    ----------
    landmarks : ndarray, shape (k, 2)
        True positions of the landmarks, m.
    steps : tuple of Step
        First step without a motion, then a step for each of M motions.
    """

    landmarks: FloatArray
    steps: tuple[Step, ...]

    @property
    def poses(self) -> FloatArray:
        """True poses at the start and after each motion, (M + 1, 3), m and rad."""
        return np.array([step.pose for step in self.steps])

    @property
    def controls(self) -> FloatArray:
        """Commanded (distance, turn) of each motion, (M, 2), m and rad."""
        return np.array([step.control for step in self.steps[1:]]).reshape(-1, 2)


def repeat_drive(
    commands: list[Motion], robots: int, rng: np.random.Generator, noise: OdometryNoise | None = None
) -> FloatArray:
    """Simulate many robots that get the same commands, without pictures.

    Parameters
    ----------
    commands : list of Motion
        The M commanded motions.
    robots : int
        Number N of robots.
    rng : numpy.random.Generator
        Source of their errors.
    noise : OdometryNoise, optional
        Noise of the odometry.

    Returns
    -------
    ndarray, shape (N, M + 1, 3)
        True poses of each robot at the start, which is (0, 0, 0), and after each motion, m and rad.
    """
    noise = noise or OdometryNoise()
    paths = np.zeros((robots, len(commands) + 1, 3))
    for step, motion in enumerate(commands):
        errors = rng.standard_normal((robots, 3)) * np.sqrt(np.diag(noise.covariance(motion)))
        old = paths[:, step]
        along, across = motion.distance + errors[:, 0], errors[:, 1]
        c, s = np.cos(old[:, 2]), np.sin(old[:, 2])
        turned = old[:, 2] + motion.turn + errors[:, 2]
        paths[:, step + 1] = np.column_stack(
            [old[:, 0] + c * along - s * across, old[:, 1] + s * along + c * across, turned]
        )
    return paths


def true_path(
    motions: Iterable[Motion], sigmas: Sigmas, rng: np.random.Generator, start: Pose | None = None
) -> list[Pose]:
    """Simulate the M + 1 true poses of a robot that gets M commands, by default from (0, 0, 0)."""
    path, deviations = [start or Pose()], np.sqrt(np.diag(sigmas.control_covariance))
    for motion in motions:
        along, across, turned = rng.standard_normal(3) * deviations
        path.append(path[-1] @ Pose(motion.distance + along, across, motion.turn + turned))
    return path


def measure_in_view(
    pose: npt.ArrayLike,
    landmarks: FloatArray,
    sensor: Sensor,
    view: FieldOfView,
    rng: np.random.Generator,
    draw_unseen: bool = False,
) -> tuple[npt.NDArray[np.intp], FloatArray]:
    """Measure the landmarks that are in view.

    Parameters
    ----------
    pose : array_like, shape (3,)
        True pose of the robot, m and rad.
    landmarks : ndarray, shape (k, 2)
        True positions of the landmarks, m.
    sensor : Sensor
        Noise of the measurements.
    view : FieldOfView
        Region in which landmarks are measured.
    rng : numpy.random.Generator
        Source of the errors.
    draw_unseen : bool
        Whether random numbers are also drawn for landmarks out of view.

    Returns
    -------
    numbers : ndarray of int, shape (n,)
        Indices of the landmarks in view.
    measurements : ndarray, shape (n, 2)
        Bearing and range of each, rad and m.
    """
    exact = range_and_bearing(pose, landmarks)
    numbers = np.flatnonzero(view.contains(exact))
    draws = (
        rng.standard_normal(exact.shape)[numbers] if draw_unseen else rng.standard_normal((len(numbers), 2))
    )
    return numbers, sensor.disturbed(exact[numbers], draws)
