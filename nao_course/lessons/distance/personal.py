"""Three landmarks of a student's personal world in one picture, which share its tilt."""

from __future__ import annotations

import numpy as np

from nao_course._internal.personal_world import PersonalWorld
from nao_course.geometry import FloatArray
from nao_course.lessons.distance.looks import PIXEL_SIGMA, Function, usual_view

RANGES = (1.5, 3.0)  # m
BEARING = float(np.radians(25.0))  # to the left or to the right at most, rad
TILT_SIGMAS = tuple(np.radians((0.7, 1.5)).tolist())  # rad


def personal_landmarks(world: PersonalWorld) -> tuple[FloatArray, float]:
    """Return three points (3, 2) on the ground in the robot frame, m, and the standard deviation of the tilt, rad."""
    rng = world.rng("04: landmarks")
    ranges, bearings = rng.uniform(*RANGES, 3), rng.uniform(-BEARING, BEARING, 3)
    points = ranges[:, None] * np.column_stack([np.cos(bearings), np.sin(bearings)])
    return points, float(rng.uniform(*TILT_SIGMAS))


def personal_numbers(world: PersonalWorld, measurement_covariance: Function) -> dict[str, float]:
    """Return the standard deviation of the mean of three ranges, with the whole covariance and with its blocks only."""
    points, tilt_sigma = personal_landmarks(world)
    view = usual_view()
    R = np.asarray(measurement_covariance(view.project(points), view, PIXEL_SIGMA, tilt_sigma), dtype=float)
    ranges = R[1::2, 1::2]
    return {
        f"standard deviation of the mean of the three ranges, {name} (cm)": 100 * float(np.sqrt(variance)) / 3
        for name, variance in (("with all of R", ranges.sum()), ("with zeros", np.trace(ranges)))
    }
