"""Drives and single looks without pictures, to try association on: what is seen and how it errs is drawn at random."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.lessons.slam_on_the_field.system.compass import wrap_quarter
from nao_course.lessons.slam_on_the_field.system.drives import YAWS, Driver, FieldOdometry, start_of
from nao_course.lessons.slam_on_the_field.system.observation import (
    CAMERA_HEIGHT,
    FOCAL,
    PIXEL_SIGMA,
    TILT_SIGMAS,
    Observation,
    observation,
)
from nao_course.sim import Field
from nao_course.slam import LandmarkKind, Measurement, Motion, range_and_bearing

FIELD = Field(2012)
_MARKS = [mark for mark in FIELD.landmarks if mark.kind != "cross"]
LANDMARKS: FloatArray = np.array([(mark.x, mark.y) for mark in _MARKS])
KINDS: tuple[LandmarkKind, ...] = tuple("post" if mark.kind == "post" else "corner" for mark in _MARKS)
NEAREST, REACH = 0.5, 4.0  # m
HALF_VIEW = float(np.radians(30.0))  # of the camera, to either side

Log = list[tuple[Motion | None, Observation]]


@dataclass(frozen=True, eq=False)
class DrawnDrive:
    """A drive over the half field whose measurements are drawn, in the field's frame.

    Parameters
    ----------
    start : Pose
        Where it begins; the robot knows it.
    log : list of (Motion or None, Observation)
        What the robot knows of each step.
    poses : ndarray, shape (S, 3)
        True pose at each step.
    origins : tuple of tuple of int
        For each step, which landmark of `LANDMARKS` each measurement is of; -1 for one of nothing.
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
    """Drive over the half field; the same seed gives the same drive.

    Parameters
    ----------
    seed : int
        Of the way and all errors.
    moves : int
        How many; there is one more stop.
    yaws : sequence of float
        Where the head looks at each stop, rad.
    false_rate : float
        How many corners a picture shows, on average, that are none.
    compass_sigma : float
        How well the lines of each second picture tell the heading, rad; infinite: they do not.
    tilt : (float, float)
        How the body leans in a picture beyond what is known, standard deviations of pitch and roll, rad.
    circle_rate : float
        Which part of the compass's directions is none of the field's, but 15 to 40 degrees off.
    """
    rng, driver = np.random.default_rng([seed, 111]), Driver(np.random.default_rng([seed, 112]))
    odometry, pose = FieldOdometry(), start_of(seed)
    log: Log = []
    poses, origins = [], []
    for stop in range(moves + 1):
        motion = driver.next(pose) if stop else None
        if motion is not None:
            off = rng.standard_normal(3) * np.sqrt(np.diag(odometry.covariance(motion)))
            pose = pose @ Pose(motion.distance + off[0], off[1], motion.turn + off[2])
        for yaw in yaws:
            observation, of = draw_look(pose, yaw, rng, false_rate, tilt=tilt)
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


def draw_look(
    pose: Pose,
    yaw: float,
    rng: np.random.Generator,
    false_rate: float = 0.0,
    half_view: float = HALF_VIEW,
    tilt: tuple[float, float] = TILT_SIGMAS,
) -> tuple[Observation, tuple[int, ...]]:
    """Draw what is measured in one picture: the body leans, and each landmark is found to a pixel.

    Parameters
    ----------
    pose : Pose
        In the field's frame.
    yaw : float
        Of the head, rad.
    rng : numpy.random.Generator
        Of all errors.
    false_rate : float
        As in `drawn_drive`.
    half_view : float
        How far to either side the camera sees, rad.
    tilt : (float, float)
        As in `drawn_drive`.

    Returns
    -------
    observation : Observation
        In a random order.
    origins : tuple of int
        As in `DrawnDrive`.
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
    lean = (pitch * np.cos(values[:, 0]) - roll * np.sin(values[:, 0])) / CAMERA_HEIGHT
    values[:, 1] = 1 / np.maximum(1 / values[:, 1] - lean, 0.1)
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
class Riddle:
    """A belief and one look, of which nobody says which landmark is which.

    Parameters
    ----------
    state, covariance : ndarray, shapes (3 + 2k,) and (3 + 2k, 3 + 2k)
        Pose, then all landmarks of the half field.
    observation : Observation
        What is seen.
    origins : tuple of int
        The true answers.
    pose : Pose
        The true one.
    """

    state: FloatArray
    covariance: FloatArray
    observation: Observation
    origins: tuple[int, ...]
    pose: Pose

    def right(self, indices: npt.ArrayLike) -> int:
        """How many of some answers are right."""
        return int(np.count_nonzero(np.asarray(indices) == np.array(self.origins)))


def riddle(seed: int, position_sigma: float, heading_sigma: float, landmark_sigma: float = 0.04) -> Riddle:
    """Put the robot somewhere, let it believe to be somewhere else, and look to one side.

    Parameters
    ----------
    seed : int
        The same gives the same.
    position_sigma, heading_sigma : float
        Standard deviations of the belief, along each axis in m and in rad.
    landmark_sigma : float
        Of each landmark on its map, m.
    """
    rng = np.random.default_rng([seed, 113])
    while True:
        x, y = rng.uniform((0.2, -1.6), (2.4, 1.6))
        pose = Pose(x, y, rng.uniform(-np.pi, np.pi))
        observation, origins = draw_look(pose, 0.0, rng, half_view=2 * HALF_VIEW)
        if len(origins) >= 3:
            break
    sigmas = np.r_[position_sigma, position_sigma, heading_sigma, np.full(2 * len(LANDMARKS), landmark_sigma)]
    state = np.concatenate([pose.as_array(), LANDMARKS.ravel()]) + sigmas * rng.standard_normal(len(sigmas))
    state[2] = wrap_angle(state[2])
    return Riddle(state, np.diag(sigmas**2), observation, origins, pose)
