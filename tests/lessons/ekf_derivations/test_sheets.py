"""Lesson 05's sheets have the solution's Jacobians, and its checks name likely slips."""

import re

import numpy as np
import pytest
import sympy
import sympy as sp

from nao_course.exercises.checking import grade_public, read_public
from nao_course.geometry import wrap_angle
from nao_course.instructor.authoring import lesson_text
from nao_course.lessons.ekf_derivations.sheets import motion_sheet, position_sheet
from nao_course.lessons.ekf_slam import group_sheet
from nao_course.lessons.pose_graphs import landmark_sheet
from tests.lessons.every import solved
from tests.lessons.test_one_course import names_given

MOTION = [
    ["1", "0", "-d*sin(theta)", "cos(theta)", "-sin(theta)", "0"],
    ["0", "1", "d*cos(theta)", "sin(theta)", "cos(theta)", "0"],
    ["0", "0", "1", "0", "0", "1"],
]
POSITION = [
    ["1", "0", "-r*sin(theta+beta)", "-r*sin(theta+beta)", "cos(theta+beta)"],
    ["0", "1", "r*cos(theta+beta)", "r*cos(theta+beta)", "sin(theta+beta)"],
]


def values(table, at):
    return np.array([[float(sympy.sympify(entry, at)) for entry in row] for row in table])


def test_the_entries_are_the_solutions_jacobians(solution):
    at = {"theta": 2.5, "d": 1.2, "beta": 0.6, "r": 3.0}
    F, G = solution["motion_jacobians"]((0, 0, 2.5), (1.2, 0.3))
    assert np.allclose(values(MOTION, at), np.hstack([F, G]))
    by_pose, by_measurement = solution["landmark_jacobians"]((0, 0, 2.5), (0.6, 3.0))
    at["beta"] = sympy.Float(0.6)  # SymPy has a function of this name
    assert np.allclose(values(POSITION, at), np.hstack([by_pose, by_measurement]))


@pytest.mark.parametrize(
    ("row", "entry", "said"),
    [
        (0, "-(d+e_x)*sin(theta)-e_y*cos(theta)", "new x by theta: e_x is 0"),
        (1, "-d*cos(theta)", "new y by theta"),
    ],
)
def test_right_entries_are_right_and_an_error_that_is_zero_and_a_wrong_sign_are_said(row, entry, said):
    assert "All" in repr(motion_sheet().write(MOTION)) and "All" in repr(position_sheet().write(POSITION))
    entries = [list(row) for row in MOTION]
    entries[row][2] = entry
    shown = repr(motion_sheet().write(entries))
    assert said in shown and "no symbol" not in shown


@pytest.mark.parametrize("sheet", [motion_sheet, position_sheet, landmark_sheet, group_sheet])
def test_each_symbol_of_each_sheet_is_shown_as_itself(sheet):
    one = sheet()
    names = [*one.symbols, *one._zero]
    differences = {"dx": r"$\Delta x$", "dy": r"$\Delta y$"} if {"dx", "dy"} <= {*names} else {}
    shown = {name: f"${sympy.latex(sympy.Symbol(name))}$" for name in names} | differences
    assert {name: one.formula(name) for name in names} == shown


def test_no_cell_that_the_grader_skips_defines_a_name_that_an_exercise_could_use():
    """With a global symbol x a function could pass its check and fail with a NameError when it is graded."""
    names = set()
    for _, cell in lesson_text.code_cells(solved("05_ekf_derivations")):
        if lesson_text.role(cell) in ("display", "example", "payoff"):
            names |= names_given(lesson_text.python(cell))
    figures = {"lap_guess", "break_guess", "limits_with_guess"}
    assert names == {*figures, "paper_minus_sympy", "ground_jacobian", "name_mistake"}
    assert not [name for name in names if re.fullmatch(r"[a-z]|theta|alpha|beta|[dl]_?[xy]", name)]


EXERCISES = {each.name: each for each in read_public("05_ekf_derivations").exercises}


def test_arguments_that_are_not_unpacked_and_a_bearing_that_is_wrapped_only_once_are_named():
    report = repr(grade_public(EXERCISES["motion_jacobians"], lambda pose, control: (np.cos(theta), control)))  # noqa: F821
    assert "x, y, theta = pose" in report

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
