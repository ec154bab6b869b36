"""Lesson 05's checks name likely slips: two at once, an argument that is not unpacked, a difference quotient."""

import numpy as np
import pytest
import sympy as sp

from nao_course.exercises.checking import grade_public, read_public
from nao_course.geometry import wrap_angle

EXERCISES = {each.name: each for each in read_public("05_ekf_derivations").exercises}


def turns_first_and_swaps(pose, control):
    x, y, theta = pose
    d, alpha = control
    return x + d * np.sin(theta + alpha), y + d * np.cos(theta + alpha), theta + alpha


def adds_the_heading_and_does_not_wrap(pose, landmark):
    dx, dy = landmark - pose[:2]
    return np.arctan2(dy, dx) + pose[2], np.hypot(dx, dy)


def two_signs(pose, control):
    c, s, d = np.cos(pose[2]), np.sin(pose[2]), control[0]
    return np.array([[1, 0, d * s], [0, 1, d * c], [0, 0, 1]]), np.array([[c, s, 0], [s, c, 0], [0, 0, 1]])


def both_divisors(pose, landmark):
    dx, dy = landmark - pose[:2]
    q, r = dx**2 + dy**2, np.hypot(dx, dy)
    return np.array([[dy / r, -dx / r, -1], [-dx / q, -dy / q, 0]])


@pytest.mark.parametrize(
    ("name", "function", "said"),
    [
        (
            "predict_pose",
            turns_first_and_swaps,
            ["two errors", "drives first", "Cosine and sine are swapped"],
        ),
        (
            "expected_measurement",
            adds_the_heading_and_does_not_wrap,
            ["two errors", "wrap_angle", "You add the heading"],
        ),
        (
            "motion_jacobians",
            two_signs,
            ["two errors", *(f"{of} has the wrong sign" for of in ("F[0, 2]", "G[0, 1]"))],
        ),
        ("measurement_jacobian_pose", both_divisors, ["The two divisors are exchanged"]),
        ("motion_jacobians", lambda pose, control: (np.cos(theta), control), ["x, y, theta = pose"]),  # noqa: F821
    ],
)
def test_two_slips_at_once_and_arguments_that_are_not_unpacked_are_named(name, function, said):
    report = repr(grade_public(EXERCISES[name], function))
    assert all(each in report for each in said), report


def test_a_bearing_that_is_wrapped_only_once_is_wrong():
    def once(pose, landmark):
        dx, dy = landmark - pose[:2]
        angle = np.arctan2(dy, dx) - pose[2]
        angle += 2 * np.pi * (float(angle < -np.pi) - float(angle > np.pi))
        return angle, np.hypot(dx, dy)

    assert "at most once" in repr(grade_public(EXERCISES["expected_measurement"], once))
    right = lambda pose, landmark: (wrap_angle(once(pose, landmark)[0]), once(pose, landmark)[1])  # noqa: E731
    assert grade_public(EXERCISES["expected_measurement"], right)


@pytest.mark.parametrize("step", [1e-6, sp.Rational(1, 10**5)])
def test_a_difference_quotient_is_not_accepted_in_5_7(step):
    def derive():
        x, y, theta, l_x, l_y = sp.symbols("x y theta l_x l_y")
        model = sp.Matrix([sp.atan2(l_y - y, l_x - x) - theta, sp.sqrt((l_x - x) ** 2 + (l_y - y) ** 2)])
        columns = [(model.subs(v, v + step) - model.subs(v, v - step)) / (2 * step) for v in (x, y, theta)]
        return model, sp.Matrix.hstack(*columns)

    report = grade_public(EXERCISES["derive_measurement_jacobian"], derive)
    assert not report and "difference quotient" in repr(report)
