"""Drives on a field with known landmarks, and the trace of a filter that follows one."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, Pose, pose_errors, wrap_angle
from nao_course.metrics import squared_distances
from nao_course.sim import Field, OdometryNoise, SensorNoise, repeat_drive
from nao_course.sim.drives import Drive, FieldOfView, Step, measure_in_view
from nao_course.slam import Motion, range_and_bearing

FIELD = Field(2012)
LANDMARKS, KINDS = FIELD.detectable_positions, FIELD.detectable_kinds  # (10, 2), m, field frame

START = Pose(1.4, -0.8, 0.0)  # in the field frame
LAP = (Motion(0.2, 0.25),) * 30  # 6 m on a circle of 0.8 m: a lap and a bit
START_COVARIANCE = np.diag([0.1**2, 0.1**2, np.radians(5) ** 2])  # m^2, rad^2
REACH = 2.5  # m, our choice: beyond some 2 m a range from one picture is poor (lesson 04)
VIEW = FieldOfView(float(np.radians(60)), REACH)  # two pictures side by side, 61 degrees wide each
_STEP = 1e-6  # of central differences, m and rad
_SHIFTS = _STEP * np.vstack([np.eye(3), -np.eye(3)])


@dataclass(frozen=True, eq=False)
class LandmarkMeasurement:
    """Hold the measured (bearing, range), rad and m, of a landmark at a known position (2,) in m, field frame.

    The covariance (2, 2) of its noise is in rad^2 and m^2.
    """

    position: FloatArray
    measurement: FloatArray
    covariance: FloatArray


def measurements_of(step: Step, landmarks: FloatArray = LANDMARKS) -> list[LandmarkMeasurement]:
    """Return the measurements of a step of a drive, one by one."""
    rows = zip(landmarks[step.numbers], step.measurements, step.covariances, strict=True)
    return [LandmarkMeasurement(*row) for row in rows]


def measure_landmark(
    pose: Pose, landmark: int, noise: SensorNoise, rng: np.random.Generator
) -> LandmarkMeasurement:
    """Measure one landmark of `LANDMARKS` from a true pose, with noise."""
    exact = range_and_bearing(pose.as_array(), LANDMARKS[landmark])
    measured = noise.disturbed(exact, rng.standard_normal(2))
    return LandmarkMeasurement(LANDMARKS[landmark], measured, noise.covariances(measured[None])[0])


def make_drive(
    rng: np.random.Generator,
    commands: Sequence[Motion] = LAP,
    odometry: OdometryNoise | None = None,
    sensor: SensorNoise | None = None,
    start: Pose = START,
) -> Drive:
    """Drive over the half field and measure every landmark in view after each command.

    The default commands are a lap and a bit. With zeros as noise the drive is exact; nothing is measured at the start,
    and the frame is the field's.
    """
    odometry, sensor = odometry or OdometryNoise(), sensor or SensorNoise()
    local = repeat_drive(list(commands), 1, rng, odometry)[0]
    truth = np.column_stack([start.to_parent(local[:, :2]), wrap_angle(local[:, 2] + start.theta)])
    steps = [Step.at_start(truth[0])]
    for pose, motion in zip(truth[1:], commands, strict=True):
        numbers, seen = measure_in_view(pose, LANDMARKS, sensor, VIEW, rng)
        steps.append(Step(pose, motion, odometry.covariance(motion), numbers, seen, sensor.covariances(seen)))
    return Drive(LANDMARKS, tuple(steps))


@dataclass(frozen=True, eq=False)
class Trace:
    """Record what a filter estimated along a drive.

    Poses are (M + 1, 3) with covariances (M + 1, 3, 3). Each of K innovations (K, 2), measured minus expected before
    the update in rad and m, has its S (K, 2, 2) and the number of the command after which it was measured.
    """

    truth: FloatArray
    poses: FloatArray
    covariances: FloatArray
    innovations: FloatArray
    innovation_covariances: FloatArray
    steps: npt.NDArray[np.int_]

    @property
    def errors(self) -> FloatArray:
        """Return estimated minus true poses, (M + 1, 3), with wrapped headings."""
        return pose_errors(self.poses, self.truth)

    @property
    def nees(self) -> FloatArray:
        """Return the normalised estimation error squared of each pose, (M + 1,)."""
        return squared_distances(self.errors, self.covariances)

    @property
    def nis(self) -> FloatArray:
        """Return the normalised innovation squared of each measurement, (K,)."""
        return squared_distances(self.innovations, self.innovation_covariances)


def follow(
    drive: Drive,
    localize: Callable[..., Any],
    predict_pose: Callable[..., Any],
    predict_covariance: Callable[..., Any],
    covariance: npt.ArrayLike = START_COVARIANCE,
    error: npt.ArrayLike = (0.0, 0.0, 0.0),
) -> Trace:
    """Run a filter along a drive.

    The estimate starts with this covariance (3, 3) and error (3,), estimated minus true pose. Innovations and S are
    computed here, from the filter's estimate before each update.
    """
    pose, cov = drive.poses[0] + np.asarray(error, dtype=float), np.array(covariance, dtype=float)
    poses, covariances = [pose], [cov]
    innovations, innovation_covariances, steps = list[FloatArray](), list[FloatArray](), list[int]()
    for number, step in enumerate(drive.steps[1:], start=1):
        given = step.control, step.control_covariance
        pose, cov = predicted(predict_pose, predict_covariance, pose, cov, *given)
        for seen in measurements_of(step, drive.landmarks):
            difference, S = expected_innovation(pose, cov, seen)
            innovations.append(difference)
            innovation_covariances.append(S)
            steps.append(number)
            pose, cov = updated(localize, pose, cov, seen)
        poses.append(pose)
        covariances.append(cov)
    return Trace(
        drive.poses,
        np.array(poses),
        np.array(covariances),
        np.array(innovations).reshape(-1, 2),
        np.array(innovation_covariances).reshape(-1, 2, 2),
        np.array(steps, dtype=int),
    )


def predicted(
    predict_pose: Callable[..., Any],
    predict_covariance: Callable[..., Any],
    pose: FloatArray,
    covariance: FloatArray,
    control: FloatArray,
    noise: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return pose (3,) and covariance (3, 3) after a command, computed by a student's functions."""
    predicted_covariance = checked(
        predict_covariance(covariance, pose, control, noise), (3, 3), "predict_covariance"
    )
    moved = checked(predict_pose(pose, control), (3,), "predict_pose")
    moved[2] = wrap_angle(moved[2])
    return moved, predicted_covariance


def updated(
    localize: Callable[..., Any], pose: FloatArray, covariance: FloatArray, seen: LandmarkMeasurement
) -> tuple[FloatArray, FloatArray]:
    """Return pose (3,) and covariance (3, 3) after one measurement, computed by a student's `localize`."""
    given = seen.measurement, seen.position, seen.covariance
    answer = localize(pose.copy(), covariance.copy(), *(each.copy() for each in given))
    if not isinstance(answer, tuple | list) or len(answer) != 2:
        raise ValueError(f"localize must return (pose, covariance), got {type(answer).__name__}")
    return checked(answer[0], (3,), "localize: pose"), checked(answer[1], (3, 3), "localize: covariance")


def checked(value: Any, shape: tuple[int, ...], name: str) -> FloatArray:
    """Return `value` as an array; raise a ValueError that names it if the shape is another one."""
    array = np.array(value, dtype=float)
    if array.shape != shape:
        raise ValueError(f"{name} must have shape {shape}, got {array.shape}")
    return array


def linearised(pose: FloatArray, landmark: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the expected (bearing, range) of a landmark and its Jacobian (2, 3) by the pose, numerically.

    The bearing is the landmark's direction minus the heading; it is not wrapped.
    """
    x, y, theta = pose.tolist()
    away = complex(*landmark) - complex(x, y)
    near = away - _SHIFTS @ (1.0, 1j, 0.0)  # from poses that are shifted a little
    bearings = np.angle(near * away.conjugate()) - _SHIFTS[:, 2]
    changes = np.stack([bearings, np.abs(near)], axis=1)
    jacobian = (changes[:3] - changes[3:]).T / (2 * _STEP)
    return np.array([np.angle(away) - theta, abs(away)]), jacobian


def expected_innovation(
    pose: FloatArray, covariance: FloatArray, seen: LandmarkMeasurement
) -> tuple[FloatArray, FloatArray]:
    """Return the innovation (2,) of a measurement and its covariance S (2, 2), given the estimate before it."""
    expected, jacobian = linearised(pose, seen.position)
    difference = seen.measurement - expected
    difference[0] = wrap_angle(difference[0])
    return difference, seen.covariance + jacobian @ (covariance @ jacobian.T)


def follow_many(
    seeds: Iterable[int],
    localize: Callable[..., Any],
    predict_pose: Callable[..., Any],
    predict_covariance: Callable[..., Any],
) -> list[Trace]:
    """Run a student's filter along many drives; each starts with an error drawn from the start covariance.

    Parameters
    ----------
    seeds : iterable of int
        One for each drive.
    localize, predict_pose, predict_covariance : callable
        The student's functions.

    Returns
    -------
    list of Trace
        One for each seed.
    """
    laps = map(lap, seeds)
    return [follow(drive, localize, predict_pose, predict_covariance, error=error) for drive, error in laps]


@lru_cache(maxsize=200)
def lap(seed: int) -> tuple[Drive, FloatArray]:
    """Return one of the lesson's drives and the estimate's error at its start; the same at each call."""
    rng = np.random.default_rng([6, seed])
    drive = make_drive(rng)
    return drive, rng.standard_normal(3) * np.sqrt(np.diag(START_COVARIANCE))
