"""Systems from the student's functions: what is not there stays open, and what is wrong is said."""

import numpy as np
import pytest

from nao_course.lessons.graph_slam import systems
from nao_course.lessons.graph_slam.drives import field_drive

DRIVE = field_drive()


def start(omega, xi, index, position):
    omega, xi = omega.copy(), xi.copy()
    omega[index, index] += 1
    xi[index] += position
    return omega, xi


def link(omega, xi, first, second, value, epsilon=1.0):
    row = np.eye(len(xi))[second] - np.eye(len(xi))[first]
    return omega + np.outer(row, row) / epsilon, xi + row * value / epsilon


BUILDERS = systems.Builders(start, link, link)


def test_only_known_variables_are_solved_for_and_the_error_of_a_map_is_that_of_its_landmarks():
    used = DRIVE.constraints[:6]
    positions, omega = systems.solve_axes(used, DRIVE.size, BUILDERS, np.linalg.solve)
    known = systems.variables_in(used)
    assert np.isfinite(positions[known]).all() and np.isnan(np.delete(positions, known, axis=0)).all()
    assert omega.shape == (DRIVE.size, DRIVE.size)
    assert np.isnan(systems.solve_axes((), DRIVE.size, BUILDERS, np.linalg.solve)[0]).all()
    moved = DRIVE.truth + (0.3, 0.4)
    assert systems.map_error(DRIVE, moved) == pytest.approx(0.5)
    moved[-1] = np.nan
    assert systems.map_error(DRIVE, moved) == pytest.approx(0.5)
    assert np.isnan(systems.map_error(DRIVE, np.full((DRIVE.size, 2), np.nan)))


def test_a_function_that_returns_something_else_gets_a_message():
    for wrong, said in (
        (lambda *given: None, "must return \\(omega, xi\\), got NoneType"),
        (lambda omega, xi, *given: (xi, omega), "must keep their shapes"),
    ):
        with pytest.raises(ValueError, match=said):
            systems.assemble(DRIVE.constraints, DRIVE.size, systems.Builders(wrong, link, link), 0)
    for wrong in (None, np.zeros(2), np.full(4, np.nan), "words"):
        with pytest.raises(ValueError, match=r"solve must return \d+ numbers, .*: check exercise 8.4"):
            systems.solve_axes(
                DRIVE.constraints[:6], DRIVE.size, BUILDERS, lambda omega, xi, wrong=wrong: wrong
            )
    with pytest.raises(ValueError, match="has no inverse here: check exercises 8.1 to 8.3"):
        systems.inverse_of(np.zeros((3, 3)))
