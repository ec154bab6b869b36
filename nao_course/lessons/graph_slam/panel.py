"""The graph panel: constraints arrive one by one, the matrix fills in, and the map follows."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from nao_course._internal.counts import say_count
from nao_course.geometry import FloatArray
from nao_course.lessons.graph_slam.drives import Constraint, field_drive, odometry_first
from nao_course.lessons.graph_slam.figures import GraphMap, say_error
from nao_course.lessons.graph_slam.systems import (
    Builders,
    Function,
    assemble,
    map_error,
    not_a_solution,
    variables_in,
)
from nao_course.plotting.drawing import table
from nao_course.plotting.matrix_signs import NEGATIVE, POSITIVE, paint_matrix
from nao_course.plotting.style import FOUND
from nao_course.widgets import Choice, Legend, Pixel, PlayerPanel, Slider, Toggle

ORDERS = ("as measured", "odometry first")
NEAR = 16.0  # px: an edge that is farther from the click is not selected


def clicked(ends: FloatArray, at: tuple[int, int]) -> int | None:
    """Return the number of the edge nearest to a pixel, or None if all are farther than `NEAR`.

    The ends (E, 2, 2) of the edges are pixels (u, v).
    """
    along = ends[:, 1] - ends[:, 0]
    from_end = np.asarray(at) - ends[:, 0]
    part = (from_end * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-9)
    away = np.linalg.norm(from_end - np.clip(part, 0.0, 1.0)[:, None] * along, axis=1)
    return int(np.argmin(away)) if len(away) and away.min() <= NEAR else None


class GraphPanel(PlayerPanel):
    """A drive's constraints, your matrix and your map, step by step.

    Parameters
    ----------
    add_initial_position, add_relative_motion, add_relative_measurement, solve : callable
        Your functions, as in exercises 8.1 to 8.4.
    """

    wide_controls = True

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
        # What is shown until there are results, so that no control changes its place
        size = self._drive.size
        self._nothing = {
            "Your Omega": paint_matrix(np.zeros((size, size)), len(self._drive.path)),
            "Your map": self._map.draw((), np.full((size, 2), np.nan)),
        }
        every = len(self._drive.constraints)
        super().__init__(
            "Graph panel",
            self._grow,
            Slider(
                "count",
                "Constraints",
                1,
                every,
                1,
                22,
                tooltip="How many constraints are in the matrix; the arrow keys add one",
            ),
            [
                Choice("order", "Order", ORDERS, tooltip="The order in which they are added"),
                Choice(
                    "variance",
                    "Variance of measurements",
                    ("x 1/100", "x 1", "x 100", "x 10000"),
                    start="x 1",
                ),
                Toggle("held", "Use the start", True, tooltip="Whether the constraint of the start is used"),
                Pixel(
                    "edge",
                    "Edge",
                    self._map.size,
                    (0, 0),
                    picture="Your map",
                    marks_start=False,
                    tooltip="Click an edge of the map to see what it adds; beside the map: the newest constraint",
                ),
            ],
            speeds={"5 a second": 5.0},
            drawn=("Your Omega", "Your map"),
            backwards=False,
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
        """Return the constraints so far, with the chosen variance."""
        drive = self._drive
        every = drive.constraints if values.order == ORDERS[0] else odometry_first(drive)
        factor = {"x 1/100": 0.01, "x 1": 1.0, "x 100": 1e2, "x 10000": 1e4}[values.variance]
        return [
            replace(each, epsilon=each.epsilon * (factor if each.kind == "measurement" else 1.0))
            for each in every[: values.count]
            if values.held or each.kind != "start"
        ]

    def _grow(self, values: Any, student: Any) -> Iterator[Any]:
        """Show the matrix, and then the map."""
        drive, used = self._drive, self._arrived(values)
        yield self._nothing
        if not used:
            yield "No constraint has arrived."
            return
        yield Legend({"positive": POSITIVE, "negative": NEGATIVE, "newest or selected constraint": FOUND})
        builders = Builders(
            student.add_initial_position, student.add_relative_motion, student.add_relative_measurement
        )
        systems = [assemble(used, drive.size, builders, axis) for axis in (0, 1)]
        omega, newest = systems[0][0], used[-1]
        yield self._framed(omega, newest)
        yield f"{say_count(len(used), 'constraint')}; the newest is a {drive.say(newest)}."
        if not all(np.isfinite(part).all() for system in systems for part in system):
            yield "Your Omega or xi contains NaN or infinity: check exercises 8.1 to 8.3."
            return
        yield f"{np.count_nonzero(omega)} of {omega.size} entries of Omega are not zero."
        yield self._added(newest, builders)
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
        ends = np.array([positions[[each.first, each.second]] for each in used])
        pixels = self._map.pixels(ends.reshape(-1, 2)).reshape(-1, 2, 2)
        selected = clicked(pixels, values.edge)
        if selected is not None:
            yield self._framed(omega, used[selected])
            yield self._added(used[selected], builders)
            yield f"You selected a {drive.say(used[selected])}."
        yield {"Your map": self._map.draw(used, positions, None if selected is None else used[selected])}
        yield f"{say_error(map_error(drive, positions)).capitalize()}."

    def _framed(self, omega: FloatArray, constraint: Constraint) -> dict[str, Any]:
        """Return the picture of the matrix with the entries framed that a constraint changes."""
        ends = constraint.first, constraint.second
        return {"Your Omega": paint_matrix(omega, len(self._drive.path), ends)}

    def _added(self, constraint: Constraint, builders: Builders) -> dict[str, Any]:
        """Return a table of what the student's functions add for a constraint in x."""
        omega, xi = assemble([constraint], self._drive.size, builders, 0)
        ends = sorted({constraint.first, constraint.second})
        names = [self._drive.names[end] for end in ends]
        rows = [
            [name, *(f"{value:z.1f}" for value in (*omega[end, ends], xi[end]))]
            for name, end in zip(names, ends, strict=True)
        ]
        return {"It adds to Ω and ξ (x axis, 1/m² and 1/m)": table(["row", *names, "ξ"], rows)}
