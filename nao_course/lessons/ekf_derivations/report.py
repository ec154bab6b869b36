"""What the homework report says where it slips, held against the student's functions: each difference is measured."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.lessons.ekf_derivations.figures import draw_correlation
from nao_course.lessons.ekf_derivations.samples import SAMPLES, carried, draw
from nao_course.plotting import Drawing, Table, table

Function = Callable[..., Any]

NUMBER = 2000  # places to measure at
LOOK_SIGMA = np.array([np.radians(2.0), 0.05])  # of bearing (rad) and range (m)
POSE_SIGMA = np.array([0.1, 0.1, np.radians(5.0)])  # m, m, rad
BOTH = np.array([[2.0, 0.6], [2.6, -0.4]])  # m, the two landmarks in front of the robot


def slope_at_one(motion_jacobians: Function) -> tuple[float, float]:
    """How far y is from where F puts it, m, for a heading off by 5 degrees: with e_y = 0, and with the page's e_y = 1.

    The robot drives 0.5 m along y. Its x changes with the heading and its y does not.
    """
    by_pose, by_noise = (
        np.asarray(each) for each in motion_jacobians(np.array([0, 0, np.pi / 2]), np.array([0.5, 0]))
    )
    at_one = by_pose[1, 2] + by_noise[0, 1]  # e_y adds -e_y sin(theta) to this slope
    return float(abs(by_pose[1, 2]) * POSE_SIGMA[2]), float(abs(at_one) * POSE_SIGMA[2])


def swapped_coordinates(landmark_position: Function, rng: np.random.Generator) -> FloatArray:
    """How far the page's landmarks are from the right ones, m: with l_x and l_y of the robot's frame swapped for y."""
    away = []
    for _ in range(NUMBER):
        heading, bearing, distance = rng.uniform(-np.pi, np.pi), rng.uniform(-0.6, 0.6), rng.uniform(0.5, 4.0)
        right = np.asarray(landmark_position(np.array([0, 0, heading]), np.array([bearing, distance])))
        ahead, left = Pose(0, 0, heading).to_local(right)[0]
        page = np.sin(heading) * left + np.cos(heading) * ahead
        away.append(abs(float(right[1]) - page))
    return np.array(away)


def left_of_the_range(expected_measurement: Function, rng: np.random.Generator) -> float:
    """Part of the measurements outside (-pi, pi], of a landmark right behind the robot, with noise after the wrap."""
    directions = draw([np.pi], [[np.radians(5.0) ** 2]], NUMBER, rng)[:, 0]
    behind = 2.0 * np.column_stack([np.cos(directions), np.sin(directions)])
    wrapped = np.array([expected_measurement(np.zeros(3), each)[0] for each in behind], dtype=float)
    noisy = wrapped + rng.normal(0, LOOK_SIGMA[0], NUMBER)
    return float(np.mean(np.abs(noisy) > np.pi))


def half_turns(expected_measurement: Function, rng: np.random.Generator) -> float:
    """Part of the landmarks all round that the page's arctan puts on the opposite side."""
    pose = np.array([0.0, 0.0, 0.7])
    places = rng.uniform(-3, 3, (NUMBER, 2))
    right = np.array([expected_measurement(pose, each)[0] for each in places], dtype=float)
    page = np.arctan(places[:, 1] / places[:, 0]) - pose[2]
    return float(np.mean(np.abs(wrap_angle(page - right)) > 3))


def report_costs(
    expected_measurement: Function, landmark_position: Function, motion_jacobians: Function
) -> Table:
    """Measure what each slip of the report would cost, if it were programmed.

    Parameters
    ----------
    expected_measurement, landmark_position, motion_jacobians : callable
        The student's.

    Returns
    -------
    Table
        A row for each slip.
    """
    rng = np.random.default_rng(8)
    right, page = slope_at_one(motion_jacobians)
    swapped = swapped_coordinates(landmark_position, rng)
    outside, opposite = left_of_the_range(expected_measurement, rng), half_turns(expected_measurement, rng)
    middle, tenth = np.median(swapped), np.quantile(swapped, 0.9)
    rows = [
        (
            "1.2, e_y = 1",
            f"σ of y after 0.5 m along y, heading ± 5°: {100 * page:.0f} cm, not {100 * right:.0f}",
        ),
        ("1.3, swapped", f"landmarks off by {middle:.1f} m (median), one in ten by {tenth:.1f} m and more"),
        ("1.4, noise after the wrap", f"right behind, {outside:.0%} of the bearings leave (-π, π]"),
        ("1.5, arctan", f"{opposite:.0%} of the landmarks on the opposite side"),
    ]
    return table(("slip", "what it would cost"), rows)


def two_landmarks(
    landmark_position: Function, expected_measurement: Function, landmark_jacobians: Function
) -> tuple[FloatArray, float]:
    """Place two landmarks by one look from a pose that is not sure: errors along y (N, 2), and their correlation.

    The correlation is the one that the Jacobians give: both landmarks share the pose's error, each has its own noise.
    """
    rng = np.random.default_rng(9)
    looks = np.array([expected_measurement(np.zeros(3), each) for each in BOTH], dtype=float)
    poses = draw(np.zeros(3), np.diag(POSE_SIGMA) ** 2, SAMPLES, rng)
    placed = np.array(
        [[landmark_position(pose, look + rng.normal(0, LOOK_SIGMA)) for look in looks] for pose in poses],
        dtype=float,
    )
    slopes = [[np.asarray(each) for each in landmark_jacobians(np.zeros(3), look)] for look in looks]
    shared = carried(np.vstack([each[0] for each in slopes]), np.diag(POSE_SIGMA) ** 2)
    for number, (_, by_measurement) in enumerate(slopes):
        block = slice(2 * number, 2 * number + 2)
        shared[block, block] += carried(by_measurement, np.diag(LOOK_SIGMA) ** 2)
    correlation = shared[1, 3] / np.sqrt(shared[1, 1] * shared[3, 3])
    return placed[:, :, 1] - BOTH[:, 1], float(correlation)


def draw_two_landmarks(
    landmark_position: Function, expected_measurement: Function, landmark_jacobians: Function
) -> Drawing:
    """Draw the errors of two landmarks that were placed by one look from an uncertain pose."""
    return draw_correlation(*two_landmarks(landmark_position, expected_measurement, landmark_jacobians))
