"""The graph panel: constraints arrive one by one, the matrix fills in, and the map follows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.colors import to_rgb

from nao_course.geometry import FloatArray
from nao_course.lessons.graph_slam.drives import Constraint, field_drive, odometry_first
from nao_course.lessons.graph_slam.figures import GraphMap, say_error
from nao_course.lessons.graph_slam.matrices import NEGATIVE, POSITIVE
from nao_course.lessons.graph_slam.systems import (
    Builders,
    Function,
    assemble,
    map_error,
    not_a_solution,
    variables_in,
)
from nao_course.plotting.drawing import say_count
from nao_course.plotting.style import FOUND
from nao_course.widgets import Choice, FunctionPanel, Legend, Slider, Toggle

CELL = 14  # px
ORDERS = ("as they came", "odometry first")
Pixels = npt.NDArray[np.uint8]


def paint_matrix(omega: FloatArray, poses: int, newest: tuple[int, ...] = ()) -> Pixels:
    """Paint which entries of a matrix are positive, negative and zero, one cell each.

    Parameters
    ----------
    omega : ndarray, shape (N, N)
        Information matrix.
    poses : int
        Its first rows are those of poses: a line parts them from the landmarks.
    newest : tuple of int
        Variables of the newest constraint, whose cells are framed.

    Returns
    -------
    ndarray of uint8, shape (14 N, 14 N, 3)
        RGB.
    """
    colours = np.array([_rgb(NEGATIVE), (255, 255, 255), _rgb(POSITIVE)], dtype=np.uint8)
    painted = colours[np.nan_to_num(np.sign(omega)).astype(int) + 1].repeat(CELL, axis=0).repeat(CELL, axis=1)
    painted[::CELL], painted[:, ::CELL] = 225, 225
    painted[poses * CELL], painted[:, poses * CELL] = 110, 110
    for row in newest:
        for column in newest:
            cell = painted[row * CELL : (row + 1) * CELL, column * CELL : (column + 1) * CELL]
            inside = cell[3:-2, 3:-2].copy()
            cell[1:, 1:] = _rgb(FOUND)
            cell[3:-2, 3:-2] = inside
    return painted


class GraphPanel(FunctionPanel):
    """A drive's constraints, your matrix and your map, step by step.

    Parameters
    ----------
    add_initial_position, add_relative_motion, add_relative_measurement, solve : callable
        Your functions, as in exercises 8.1 to 8.4.
    """

    def __init__(
        self,
        add_initial_position: Function,
        add_relative_motion: Function,
        add_relative_measurement: Function,
        solve: Function,
    ) -> None:
        """Add the first constraint and build the widgets."""
        self._drive = field_drive()
        self._map = GraphMap(self._drive)
        every = len(self._drive.constraints)
        super().__init__(
            "Graph panel",
            self._grow,
            [
                Slider(
                    "count",
                    "Constraints",
                    1,
                    every,
                    1,
                    22,
                    tooltip="How many have arrived: the arrow keys add one",
                ),
                Choice("order", "Order", ORDERS, tooltip="In which order they arrive"),
                Choice("variance", "Variance of sights", ("x 1/100", "x 1", "x 100", "x 10000"), start="x 1"),
                Toggle("held", "Start held", True, tooltip="Whether the constraint of the start is used"),
            ],
            student={
                "add_initial_position": add_initial_position,
                "add_relative_motion": add_relative_motion,
                "add_relative_measurement": add_relative_measurement,
                "solve": solve,
            },
            unfinished={
                "add_initial_position": "Finish exercise 8.1 to see your matrix.",
                "add_relative_motion": "Finish exercise 8.2 to see your matrix.",
                "add_relative_measurement": "Finish exercise 8.3 to see your matrix.",
                "solve": "Finish exercise 8.4 to see your map.",
            },
        )

    def _arrived(self, values: Any) -> list[Constraint]:
        """The constraints so far, with the variance that is set."""
        drive = self._drive
        every = drive.constraints if values.order == ORDERS[0] else odometry_first(drive)
        factor = {"x 1/100": 0.01, "x 1": 1.0, "x 100": 1e2, "x 10000": 1e4}[values.variance]
        return [
            replace(each, epsilon=each.epsilon * (factor if each.kind == "measurement" else 1.0))
            for each in every[: values.count]
            if values.held or each.kind != "start"
        ]

    def _grow(self, values: Any, student: Any) -> Iterator[Any]:
        """Show the matrix, and then the map that it gives."""
        drive, used = self._drive, self._arrived(values)
        if not used:
            yield "No constraint has arrived."
            return
        yield Legend({"positive": POSITIVE, "negative": NEGATIVE, "newest constraint": FOUND})
        builders = Builders(
            student.add_initial_position, student.add_relative_motion, student.add_relative_measurement
        )
        systems = [assemble(used, drive.size, builders, axis) for axis in (0, 1)]
        omega, newest = systems[0][0], used[-1]
        yield {"Your Omega": paint_matrix(omega, len(drive.path), (newest.first, newest.second))}
        yield f"{say_count(len(used), 'constraint')}; the newest is a {drive.say(newest)}."
        if not all(np.isfinite(part).all() for system in systems for part in system):
            yield "Your Omega or xi has entries that are no numbers: check exercises 8.1 to 8.3."
            return
        yield f"{np.count_nonzero(omega)} of {omega.size} entries of Omega are not zero."
        known = variables_in(used)
        answers = []
        try:
            for matrix, right in systems:
                answers.append(student.solve(matrix[np.ix_(known, known)], right[known]))
        except ValueError as error:
            yield f"There is no map. Your solve says: {error}"
            return
        if wrong := next(filter(None, (not_a_solution(each, len(known)) for each in answers)), ""):
            yield f"There is no map. Your {wrong}."
            return
        positions = np.full((drive.size, 2), np.nan)
        positions[known] = np.column_stack(answers)
        yield {"Your map": self._map.draw(used, positions)}
        yield f"{say_error(map_error(drive, positions)).capitalize()}."


def _rgb(colour: str) -> tuple[int, int, int]:
    red, green, blue = (round(255 * part) for part in to_rgb(colour))
    return red, green, blue
