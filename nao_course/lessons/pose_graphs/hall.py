"""A hall that grows with the drive through it: lanes up and down, landmarks everywhere, and what is measured."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from nao_course.geometry import FloatArray, wrap_angle

# The hall: lanes of ten metres, three metres apart, a stop a metre; every landmark within four metres is measured.
LANE, BETWEEN_LANES, SIGHT = 10, 3, 4.0
LANDMARKS_PER_M2 = 0.1


class Noise(NamedTuple):
    """Standard deviations of one step of a metre, along and across (m) and of the turn (rad), and of one look."""

    along: float
    across: float
    turn: float
    bearing: float
    range: float

    @property
    def control_covariance(self) -> FloatArray:
        """Of (along, across, turn), (3, 3)."""
        return np.diag([self.along, self.across, self.turn]) ** 2

    @property
    def measurement_covariance(self) -> FloatArray:
        """Of (bearing, range), (2, 2)."""
        return np.diag([self.bearing, self.range]) ** 2


NOISES = {
    "a careful NAO": Noise(0.03, 0.02, np.radians(1.0), np.radians(1.5), 0.05),
    "3° a step, 5° bearing": Noise(0.05, 0.05, np.radians(3.0), np.radians(5.0), 0.10),
}


@dataclass(frozen=True, eq=False)
class Drive:
    """Controls and looks along the lanes of a hall, and what is true.

    Parameters
    ----------
    poses : ndarray, shape (M + 1, 3)
        Where the robot truly is, m and rad; it begins at 0.
    landmarks : ndarray, shape (k, 2)
        Where those that are seen truly are, in the order in which they are seen first.
    controls : ndarray, shape (M, 2)
        (distance, turn) as commanded, m and rad.
    looks : list of (ndarray, shape (m,), ndarray, shape (m, 2))
        For each pose the landmarks' numbers, and their (bearing, range) as measured.
    noise : Noise
        What the errors were drawn from, and what both methods are told.
    """

    poses: FloatArray
    landmarks: FloatArray
    controls: FloatArray
    looks: list[tuple[Any, FloatArray]]
    noise: Noise


def hall_drive(seed: int, steps: int, noise: Noise) -> Drive:
    """Drive up and down the lanes of a hall with landmarks, the longer the drive, the larger the hall.

    Parameters
    ----------
    seed : int
        Of the hall, and of all errors.
    steps : int
        M, a metre each.
    noise : Noise
        Of steps and looks.

    Returns
    -------
    Drive
    """
    rng = np.random.default_rng([seed, steps])
    controls = _lanes(steps)
    poses = np.zeros((steps + 1, 3))
    for step, (distance, turn) in enumerate(controls):
        along, across, turned = rng.normal(0.0, noise[:3])
        x, y, theta = poses[step]
        c, s = np.cos(theta), np.sin(theta)
        along += distance
        poses[step + 1] = (
            x + c * along - s * across,
            y + s * along + c * across,
            wrap_angle(theta + turn + turned),
        )
    low, high = poses[:, :2].min(axis=0) - 2.0, poses[:, :2].max(axis=0) + 2.0
    marks = rng.uniform(low, high, (int(LANDMARKS_PER_M2 * np.prod(high - low)), 2))
    marks, looks = _look_around(poses, marks, noise, rng)
    return Drive(poses, marks, controls, looks, noise)


def _lanes(steps: int) -> FloatArray:
    """(distance, turn) of each step: ten metres, a quarter turn, three metres, a quarter turn, and back."""
    controls = np.zeros((steps, 2))
    controls[:, 0] = 1.0
    round_trip = 2 * (LANE + BETWEEN_LANES)
    for step in range(steps):
        at = (step + 1) % round_trip
        if at in (LANE, LANE + BETWEEN_LANES):
            controls[step, 1] = np.pi / 2
        elif at in (2 * LANE + BETWEEN_LANES, 0):
            controls[step, 1] = -np.pi / 2
    return controls


def _look_around(
    poses: FloatArray, marks: FloatArray, noise: Noise, rng: np.random.Generator
) -> tuple[FloatArray, list[tuple[Any, FloatArray]]]:
    """Measure what is near each pose; landmarks are numbered as they are seen first, and the others are left out."""
    number_of: dict[int, int] = {}
    looks = []
    for x, y, theta in poses:
        away = marks - (x, y)
        ranges = np.hypot(*away.T)
        near = np.flatnonzero((ranges < SIGHT) & (ranges > 0.3))
        bearings = np.arctan2(away[near, 1], away[near, 0]) - theta
        measured = np.column_stack([bearings, ranges[near]])
        measured += rng.normal(0.0, (noise.bearing, noise.range), measured.shape)
        measured[:, 0] = wrap_angle(measured[:, 0])
        looks.append(
            (
                np.array([number_of.setdefault(int(each), len(number_of)) for each in near], dtype=int),
                measured,
            )
        )
    return marks[list(number_of)], looks
