"""From a drive's constraints to a system of equations for each axis, by the student's functions, and to a map."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_course.geometry import FloatArray
from nao_course.lessons.graph_slam.drives import Constraint, LinearDrive

Function = Callable[..., Any]


@dataclass(frozen=True)
class Builders:
    """The student's functions that fill a system: each returns a new ``(omega, xi)``.

    Parameters
    ----------
    add_initial_position, add_relative_motion, add_relative_measurement : callable
        As in exercises 8.1 to 8.3.
    """

    add_initial_position: Function
    add_relative_motion: Function
    add_relative_measurement: Function

    def add(self, omega: FloatArray, xi: FloatArray, constraint: Constraint, axis: int) -> Any:
        """Add one axis of a constraint."""
        value = float(constraint.value[axis])
        if constraint.kind == "start":
            return self.add_initial_position(omega, xi, constraint.first, value)
        add = self.add_relative_motion if constraint.kind == "motion" else self.add_relative_measurement
        return add(omega, xi, constraint.first, constraint.second, value, constraint.epsilon)


def assemble(
    constraints: Sequence[Constraint], size: int, builders: Builders, axis: int
) -> tuple[FloatArray, FloatArray]:
    """Fill the system of one axis.

    Parameters
    ----------
    constraints : sequence of Constraint
        Constraints to use.
    size : int
        How many variables there are.
    builders : Builders
        The student's functions.
    axis : int
        0 for x, 1 for y.

    Returns
    -------
    omega : ndarray, shape (size, size)
        In 1/m^2.
    xi : ndarray, shape (size,)
        In 1/m.

    Raises
    ------
    ValueError
        If a function returns something else.
    """
    omega, xi = np.zeros((size, size)), np.zeros(size)
    for each in constraints:
        added = builders.add(omega, xi, each, axis)
        if not isinstance(added, tuple | list) or len(added) != 2:
            raise ValueError(
                f"a function for a {each.kind} must return (omega, xi), got {type(added).__name__}"
            )
        omega, xi = (np.asarray(part, dtype=float) for part in added)
        if omega.shape != (size, size) or xi.shape != (size,):
            raise ValueError(f"omega and xi must keep their shapes, got {omega.shape} and {xi.shape}")
    return omega, xi


def variables_in(constraints: Sequence[Constraint]) -> list[int]:
    """Return the variables of which something is known, in their order."""
    return sorted({variable for each in constraints for variable in (each.first, each.second)})


def not_a_solution(answer: Any, size: int) -> str:
    """Say what is wrong with a solver's answer that should be `size` finite numbers; "" where nothing is."""
    try:
        values = np.asarray(answer, dtype=float)
    except (TypeError, ValueError):
        values = np.zeros(())
    if values.shape != (size,):
        came = f"shape {values.shape}" if values.shape else type(answer).__name__
    elif not np.isfinite(values).all():
        came = "NaN or infinity among them"
    else:
        return ""
    return f"solve must return {size} numbers, and returned {came}: check exercise 8.4"


def solved(solve: Function, omega: FloatArray, xi: FloatArray) -> FloatArray:
    """Call the student's solver, and raise ValueError if it does not return a solution."""
    answer = solve(omega, xi)
    if wrong := not_a_solution(answer, len(xi)):
        raise ValueError(wrong)
    return np.asarray(answer, dtype=float)


def inverse_of(omega: FloatArray) -> FloatArray:
    """Return the inverse of the student's Omega, and raise ValueError if it has none."""
    try:
        return np.asarray(np.linalg.inv(omega))
    except np.linalg.LinAlgError as error:
        raise ValueError("your Omega has no inverse here: check exercises 8.1 to 8.3") from error


def solve_axes(
    constraints: Sequence[Constraint], size: int, builders: Builders, solve: Function
) -> tuple[FloatArray, FloatArray]:
    """Solve both axes for all variables that appear in a constraint.

    Parameters
    ----------
    constraints : sequence of Constraint
        Constraints to use.
    size : int
        How many variables there are.
    builders : Builders
        The student's functions.
    solve : callable
        ``solve(omega, xi)`` returns x, the student's.

    Returns
    -------
    positions : ndarray, shape (size, 2)
        In metres; NaN for variables without a constraint.
    omega : ndarray, shape (size, size)
        The matrix of the x axis; the y axis has the same.
    """
    known = variables_in(constraints)
    positions = np.full((size, 2), np.nan)
    omega = np.zeros((size, size))
    for axis in (1, 0):
        omega, xi = assemble(constraints, size, builders, axis)
        if known:
            positions[known, axis] = solved(solve, omega[np.ix_(known, known)], xi[known])
    return positions, omega


def map_error(drive: LinearDrive, positions: FloatArray) -> float:
    """Return the root mean square distance of the landmarks from the true ones, in m, without missing landmarks."""
    away = positions[len(drive.path) :] - drive.landmarks
    return float(np.sqrt(np.nanmean((away**2).sum(axis=1)))) if np.isfinite(away).any() else float("nan")
