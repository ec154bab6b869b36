"""Observations: drawn at random for drives that are not rendered, or made from a picture by a student's function."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.field_slam.compass import estimate_body_tilt, wrap_quarter
from nao_course.field_slam.drives import YAWS, Driver, OdometryNoisePerMove, start_of
from nao_course.field_slam.lines import read_lines
from nao_course.field_slam.observation import (
    CAMERA_HEIGHT,
    FOCAL,
    PIXEL_SIGMA,
    POST_SIGMA,
    TILT_SIGMAS,
    Observation,
    observation,
    tilted,
)
from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.sim import CameraView, Field
from nao_course.slam import LandmarkKind, Measurement, Motion, range_and_bearing

FIELD = Field(2012)
LANDMARKS, KINDS = FIELD.detectable_positions, FIELD.detectable_kinds
NEAREST, REACH = 0.5, 4.0  # m
HALF_VIEW = float(np.radians(30.0))  # of the camera, to either side

Log = list[tuple[Motion | None, Observation]]


@dataclass(frozen=True, eq=False)
class DrawnDrive:
    """A drive over the half field with randomly drawn measurements, in the field's frame.

    The start is known; `log` has the motion and observation of each step, `poses` (S, 3) the true poses, and `origins`
    the number in `LANDMARKS` of each measurement's landmark, -1 for a false corner.
    """

    start: Pose
    log: Log
    poses: FloatArray
    origins: tuple[tuple[int, ...], ...]


def drawn_drive(
    seed: int,
    moves: int = 20,
    yaws: Sequence[float] = YAWS,
    false_rate: float = 0.0,
    compass_sigma: float = np.inf,
    tilt: tuple[float, float] = TILT_SIGMAS,
    circle_rate: float = 0.0,
) -> DrawnDrive:
    """Draw a drive over the half field; the same seed gives the same drive.

    There is one more stop than moves. `yaws` (rad) are of the head, one picture each; `false_rate` is the mean number
    of false corners in a picture; every second picture measures the heading with `compass_sigma` (rad, infinite for
    none); `tilt` has the standard deviations (rad) of a picture's unknown pitch and roll; `circle_rate` is the fraction
    of the compass's directions that are wrong by 15 to 40 degrees.
    """
    rng, driver = np.random.default_rng([seed, 111]), Driver(np.random.default_rng([seed, 112]))
    odometry, pose = OdometryNoisePerMove(), start_of(seed)
    log: Log = []
    poses, origins = [], []
    for stop in range(moves + 1):
        motion = driver.next(pose) if stop else None
        if motion is not None:
            off = rng.standard_normal(3) * np.sqrt(np.diag(odometry.covariance(motion)))
            pose = pose @ Pose(motion.distance + off[0], off[1], motion.turn + off[2])
        for yaw in yaws:
            observation, of = draw_observation(pose, yaw, rng, false_rate, tilt=tilt)
            if np.isfinite(compass_sigma) and len(log) % 2:
                wrong = compass_sigma * rng.standard_normal()
                if circle_rate and rng.random() < circle_rate:
                    wrong = float(rng.choice((-1, 1)) * np.radians(rng.uniform(15, 40)))
                direction = float(wrap_quarter(wrong - pose.theta))
                observation = replace(observation, direction=direction, direction_sigma=compass_sigma)
            log.append((motion, observation))
            poses.append(pose.as_array())
            origins.append(of)
            motion = None
    return DrawnDrive(start_of(seed), log, np.array(poses), tuple(origins))


def draw_observation(
    pose: Pose,
    yaw: float,
    rng: np.random.Generator,
    false_rate: float = 0.0,
    half_view: float = HALF_VIEW,
    tilt: tuple[float, float] = TILT_SIGMAS,
) -> tuple[Observation, tuple[int, ...]]:
    """Draw the measurements of one picture with a random body tilt and one pixel of error for each landmark.

    The pose is in the field's frame; yaw and `half_view`, half of the camera's horizontal field of view, are in rad.
    Measurements are in a random order, and `origins` is as in `DrawnDrive`.
    """
    exact = range_and_bearing(pose.as_array(), LANDMARKS)
    seen = (
        (np.abs(wrap_angle(exact[:, 0] - yaw)) < half_view) & (exact[:, 1] > NEAREST) & (exact[:, 1] < REACH)
    )
    numbers = rng.permutation(np.flatnonzero(seen))
    extra = int(rng.poisson(false_rate)) if false_rate else 0
    values = np.vstack(
        [exact[numbers], rng.uniform((yaw - half_view, 1.0), (yaw + half_view, 3.0), (extra, 2))]
    )
    pitch, roll = rng.normal(0.0, tilt)
    tilted = (pitch * np.cos(values[:, 0]) - roll * np.sin(values[:, 0])) / CAMERA_HEIGHT
    values[:, 1] = 1 / np.maximum(1 / values[:, 1] - tilted, 0.1)
    steep = (CAMERA_HEIGHT**2 + values[:, 1] ** 2) / CAMERA_HEIGHT
    values += (
        PIXEL_SIGMA
        / FOCAL
        * np.column_stack([np.ones(len(values)), steep])
        * rng.standard_normal(values.shape)
    )
    kinds: list[LandmarkKind] = [KINDS[i] for i in numbers]
    kinds += ["corner"] * extra
    measurements = [
        Measurement(float(b), float(max(r, 0.1)), kind) for (b, r), kind in zip(values, kinds, strict=True)
    ]
    origins = (*(int(i) for i in numbers), *[-1] * extra)
    return observation(measurements, tilt), origins


@dataclass(frozen=True, eq=False)
class AssociationProblem:
    """An estimate and one picture's measurements, whose landmarks have to be chosen.

    State (3 + 2k,) and covariance (3 + 2k, 3 + 2k) have the pose, then all landmarks of the half field; `origins` are
    the true landmarks of the measurements.
    """

    state: FloatArray
    covariance: FloatArray
    observation: Observation
    origins: tuple[int, ...]
    pose: Pose

    def right(self, indices: npt.ArrayLike) -> int:
        """Return how many of some answers are right."""
        return int(np.count_nonzero(np.asarray(indices) == np.array(self.origins)))


def association_problem(
    seed: int, position_sigma: float, heading_sigma: float, landmark_sigma: float = 0.04
) -> AssociationProblem:
    """Draw a true pose, an uncertain estimate of it, and the measurements of one picture.

    The standard deviations are `position_sigma` along each axis (m), `heading_sigma` (rad), and `landmark_sigma` of
    each landmark on the map (m).
    """
    rng = np.random.default_rng([seed, 113])
    while True:
        x, y = rng.uniform((0.2, -1.6), (2.4, 1.6))
        pose = Pose(x, y, rng.uniform(-np.pi, np.pi))
        observation, origins = draw_observation(pose, 0.0, rng, half_view=2 * HALF_VIEW)
        if len(origins) >= 3:
            break
    sigmas = np.r_[position_sigma, position_sigma, heading_sigma, np.full(2 * len(LANDMARKS), landmark_sigma)]
    state = np.concatenate([pose.as_array(), LANDMARKS.ravel()]) + sigmas * rng.standard_normal(len(sigmas))
    state[2] = wrap_angle(state[2])
    return AssociationProblem(state, np.diag(sigmas**2), observation, origins, pose)


def observe(measure: Callable[..., Any], pixels: npt.NDArray[np.uint8], view: CameraView) -> Observation:
    """Return the observation of a picture (H, W, 3) by a student's ``measure(pixels, view)``.

    The function gets a copy of the picture, and the view with the body tilt that the library finds from the field
    lines, as in the demo. One picture follows the other so closely that errors of the assumed view would add up.
    """
    tilt = estimate_body_tilt(read_lines(pixels, view), view)
    return observation(
        checked_measurements(measure(pixels.copy(), tilted(view, tilt.pitch, tilt.roll))),
        tilt.covariance[:2, :2],
        direction=tilt.direction,
        direction_sigma=tilt.direction_sigma,
        post_sigma=POST_SIGMA,
    )


def checked_measurements(found: object) -> list[Measurement]:
    """Return a student's measurements, or raise TypeError if they are something else."""
    if not isinstance(found, Iterable) or isinstance(found, Measurement):
        raise TypeError(f"measure must return a list of Measurement, got {type(found).__name__}")
    seen = list(found)
    if any(not isinstance(each, Measurement) for each in seen):
        raise TypeError("measure must return a list of Measurement")
    return seen
