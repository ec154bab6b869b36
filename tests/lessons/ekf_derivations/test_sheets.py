"""The sheets: their entries are the solution's Jacobians, and no cell leaves a symbol behind in the notebook."""

import re

import numpy as np
import pytest
import sympy

from nao_course.instructor.authoring import lesson_text
from nao_course.lessons.ekf_derivations.sheets import motion_sheet, position_sheet
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


@pytest.mark.parametrize(("sheet", "entries"), [(motion_sheet, MOTION), (position_sheet, POSITION)])
def test_the_right_entries_are_right(sheet, entries):
    assert "All" in repr(sheet().write(entries))


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
        (
            0,
            "-(d+e_x)*sin(theta)-e_y*cos(theta)",
            "new x by theta: e_x is 0 where this Jacobian is evaluated",
        ),
        (1, "-d*cos(theta)", "new y by theta: its sign is wrong"),
    ],
)
def test_an_error_that_is_zero_and_a_wrong_sign_are_said_to_be_so(row, entry, said):
    entries = [list(row) for row in MOTION]
    entries[row][2] = entry
    shown = repr(motion_sheet().write(entries))
    assert said in shown and "no symbol" not in shown


def test_no_cell_that_the_grader_skips_defines_a_name_that_an_exercise_could_use():
    """With a global symbol x a function could pass its check and fail with a NameError when it is graded."""
    names = set()
    for _, cell in lesson_text.code_cells(solved("05_ekf_derivations")):
        if lesson_text.role(cell) in ("display", "example", "payoff"):
            names |= names_given(lesson_text.python(cell))
    assert names == {"lap_guess", "break_guess", "paper_minus_sympy", "ground_jacobian", "name_mistake"}
    assert not [name for name in names if re.fullmatch(r"[a-z]|theta|alpha|beta|[dl]_?[xy]", name)]
