"""The errors in the homework report, each measured with the student's functions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.lessons.ekf_derivations.figures import draw_correlation
from nao_course.lessons.ekf_derivations.samples import SAMPLES, draw, propagated
from nao_course.plotting import Drawing, Table, table

Function = Callable[..., Any]

NUMBER = 2000  # random positions
MEASUREMENT_SIGMA = np.array([np.radians(2.0), 0.05])  # of bearing (rad) and range (m)
POSE_SIGMA = np.array([0.1, 0.1, np.radians(5.0)])  # m, m, rad
BOTH = np.array([[2.0, 0.6], [2.6, -0.4]])  # m, the two landmarks in front of the robot


def derivative_at_one(motion_jacobians: Function) -> tuple[float, float]:
    """Return σ of y (m) for a heading known to 5 degrees: with F at e_y = 0, and at the report's e_y = 1.

    The robot drives 0.5 m along y, so an error of its heading changes x but not y.
    """
    by_pose, by_noise = (
        np.asarray(each) for each in motion_jacobians(np.array([0, 0, np.pi / 2]), np.array([0.5, 0]))
    )
    at_one = by_pose[1, 2] + by_noise[0, 1]  # e_y adds -e_y sin(theta) to this derivative
    return float(abs(by_pose[1, 2]) * POSE_SIGMA[2]), float(abs(at_one) * POSE_SIGMA[2])


def swapped_coordinates(landmark_position: Function, rng: np.random.Generator) -> FloatArray:
    """Return the errors (m) of landmarks whose y is computed with l_x and l_y swapped, as in the report."""
    away = []
    for _ in range(NUMBER):
        heading, bearing, distance = rng.uniform(-np.pi, np.pi), rng.uniform(-0.6, 0.6), rng.uniform(0.5, 4.0)
        right = np.asarray(landmark_position(np.array([0, 0, heading]), np.array([bearing, distance])))
        ahead, left = Pose(0, 0, heading).to_local(right)[0]
        page = np.sin(heading) * left + np.cos(heading) * ahead
        away.append(abs(float(right[1]) - page))
    return np.array(away)


def share_outside(expected_measurement: Function, rng: np.random.Generator) -> float:
    """Return the share of bearings outside (-pi, pi], for a landmark behind the robot and noise after the wrap."""
    directions = draw([np.pi], [[np.radians(5.0) ** 2]], NUMBER, rng)[:, 0]
    behind = 2.0 * np.column_stack([np.cos(directions), np.sin(directions)])
    wrapped = np.array([expected_measurement(np.zeros(3), each)[0] for each in behind], dtype=float)
    noisy = wrapped + rng.normal(0, MEASUREMENT_SIGMA[0], NUMBER)
    return float(np.mean(np.abs(noisy) > np.pi))


def half_turns(expected_measurement: Function, rng: np.random.Generator) -> float:
    """Return the share of landmarks that the report's arctan puts on the opposite side of the robot."""
    pose = np.array([0.0, 0.0, 0.7])
    places = rng.uniform(-3, 3, (NUMBER, 2))
    right = np.array([expected_measurement(pose, each)[0] for each in places], dtype=float)
    page = np.arctan(places[:, 1] / places[:, 0]) - pose[2]
    return float(np.mean(np.abs(wrap_angle(page - right)) > 3))


def report_costs(
    expected_measurement: Function, landmark_position: Function, motion_jacobians: Function
) -> Table:
    """Measure the cost of each error in the report, if it were programmed.

    Parameters
    ----------
    expected_measurement, landmark_position, motion_jacobians : callable
        The student's functions.

    Returns
    -------
    Table
        A row for each error.
    """
    rng = np.random.default_rng(8)
    right, page = derivative_at_one(motion_jacobians)
    swapped = swapped_coordinates(landmark_position, rng)
    outside, opposite = share_outside(expected_measurement, rng), half_turns(expected_measurement, rng)
    middle, tenth = np.median(swapped), np.quantile(swapped, 0.9)
    rows = [
        (
            "1.2, e_y = 1",
            f"σ of y after 0.5 m along y, heading known to 5°: {100 * page:.0f} cm, not {100 * right:.0f}",
        ),
        ("1.3, swapped", f"landmarks off by {middle:.1f} m (median), one in ten by {tenth:.1f} m and more"),
        ("1.4, noise after the wrap", f"behind the robot, {outside:.0%} of the bearings are outside (-π, π]"),
        ("1.5, arctan", f"{opposite:.0%} of the landmarks on the opposite side"),
    ]
    return table(("error", "cost"), rows)


def two_landmarks(
    landmark_position: Function, expected_measurement: Function, landmark_jacobians: Function
) -> tuple[FloatArray, float]:
    """Measure two landmarks from one uncertain pose: their errors along y (N, 2) and the predicted correlation.

    The Jacobians predict the correlation: both landmarks share the pose's error, and each has noise of its own.
    """
    rng = np.random.default_rng(9)
    measurements = np.array([expected_measurement(np.zeros(3), each) for each in BOTH], dtype=float)
    poses = draw(np.zeros(3), np.diag(POSE_SIGMA) ** 2, SAMPLES, rng)
    placed = np.array(
        [
            [landmark_position(pose, each + rng.normal(0, MEASUREMENT_SIGMA)) for each in measurements]
            for pose in poses
        ],
        dtype=float,
    )
    jacobians = [
        [np.asarray(part) for part in landmark_jacobians(np.zeros(3), each)] for each in measurements
    ]
    shared = propagated(np.vstack([each[0] for each in jacobians]), np.diag(POSE_SIGMA) ** 2)
    for number, (_, by_measurement) in enumerate(jacobians):
        block = slice(2 * number, 2 * number + 2)
        shared[block, block] += propagated(by_measurement, np.diag(MEASUREMENT_SIGMA) ** 2)
    correlation = shared[1, 3] / np.sqrt(shared[1, 1] * shared[3, 3])
    return placed[:, :, 1] - BOTH[:, 1], float(correlation)


def draw_two_landmarks(
    landmark_position: Function, expected_measurement: Function, landmark_jacobians: Function
) -> Drawing:
    """Draw the errors of two landmarks that were measured from the same uncertain pose."""
    return draw_correlation(*two_landmarks(landmark_position, expected_measurement, landmark_jacobians))
