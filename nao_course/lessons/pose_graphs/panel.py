"""The relaxing panel: a graph, step by step, and the blocks of its matrix."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

import ipywidgets
import numpy as np
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray
from nao_course.lessons.pose_graphs.figures import Function, GaussNewton, map_keys, plot_graph, say_chi2
from nao_course.lessons.pose_graphs.matrices import block_picture
from nao_course.lessons.pose_graphs.worlds import (
    World,
    building,
    disturbed,
    drifting_loop,
    field_drive,
    position_error,
    with_false_closures,
)
from nao_course.plotting import Drawing, course_style
from nao_course.plotting.legends import legend_below
from nao_course.widgets import Choice, FunctionPanel, Legend, Slider

STEPS = 10
PACE = 700  # ms a step, while it plays
_WORLDS = {
    "a building": lambda: building(5, 240),
    "a building, one false closure": lambda: with_false_closures(building(5, 240), 1, 2),
    "a loop that drifted by 90°": lambda: drifting_loop(np.pi / 2),
    "the half field": lambda: field_drive(1),
}
_GUESSES = {
    "odometry": (0.0, 0.0),
    "positions off by 100 m": (100.0, 0.0),
    "headings off by 20°": (0.0, 20.0),
    "headings off by 60°": (0.0, 60.0),
}


@cache
def world_named(name: str) -> World:
    """One of the panel's worlds, made once."""
    return _WORLDS[name]()


def first_guess(world: World, name: str) -> FloatArray:
    """States to begin with: the odometry's, or the truth disturbed."""
    position, heading = _GUESSES[name]
    if name == "odometry":
        return world.odometry.copy()
    return disturbed(world, position, np.radians(heading), np.random.default_rng(0))


class RelaxPanel(FunctionPanel):
    """A graph that relaxes under your functions, step by step, and the blocks of H.

    Parameters
    ----------
    linearize, gauss_newton : callable
        Your functions, as in exercises 9.5 and 9.6.
    """

    def __init__(self, linearize: Function, gauss_newton: GaussNewton) -> None:
        """Show the first guess and build the widgets."""
        super().__init__(
            "Relaxing panel",
            self._relax,
            [
                Slider(
                    "step", "Step", 0, STEPS, 1, 0, tooltip="Gauss-Newton steps: arrow keys go on and back"
                ),
                Choice("world", "Graph", tuple(_WORLDS), tooltip="Which drive"),
                Choice("guess", "First guess", tuple(_GUESSES), tooltip="Where the first step begins"),
            ],
            student={"linearize": linearize, "gauss_newton": gauss_newton},
            unfinished={
                "linearize": "Finish exercise 9.5 to see the blocks of H.",
                "gauss_newton": "Finish exercise 9.6 to see the graph relax.",
            },
        )
        self._add_player()

    def _add_player(self) -> None:
        """A player beside the slider, linked to it in the browser."""
        player = ipywidgets.Play(min=0, max=STEPS, step=1, interval=PACE, show_repeat=False)
        player.description = player.tooltip = "Play the steps"
        ipywidgets.jslink((player, "value"), (self._widgets["step"], "value"))
        row = self.widget.children[2]
        row.children = (player, *row.children)
        self.player = player

    def _relax(self, values: Any, student: Any) -> Iterator[Any]:
        """Show the states after so many steps, and H there."""
        world = world_named(values.world)
        states = first_guess(world, values.guess)
        yield Legend({"neighbours": "#3c3c42", "closure": "#2a8a82", "sight of a landmark": "#a14566"})
        if values.step == 0:
            yield {"Graph": _map(world, states, values)}
            yield f"First guess: {values.guess}. Off by {_say_error(world, states)}."
        else:
            states, chi2 = student.gauss_newton(world.graph, states, values.step)
            states, chi2 = np.asarray(states, dtype=float), np.asarray(chi2, dtype=float)
            yield {"Graph": _map(world, states, values)}
            before, after = (say_chi2(float(each)) for each in chi2[-2:])
            yield f"Step {values.step}: chi2 {before} -> {after}. Off by {_say_error(world, states)}."
        H = student.linearize(world.graph, states)[0]
        yield {"Blocks of H": block_picture(H, world.graph.poses)}
        part = 100 * H.nnz / np.prod(H.shape)
        yield f"H has {H.shape[0]} rows; {part:.1f} % of it is stored."


def _map(world: World, states: FloatArray, values: Any) -> Drawing:
    false = int("false" in values.world)
    with course_style():
        figure = Figure(figsize=(6.2, 5.2))
        ax = figure.add_subplot()
        plot_graph(world, states, ax, source="graph" if values.step else "odometry", false=false)
        legend_below(figure, map_keys(world, false=bool(false)), columns=3)
    return Drawing(figure, f"The graph after {values.step} steps, off by {_say_error(world, states)}.")


def _say_error(world: World, states: FloatArray) -> str:
    return f"{position_error(world, states):.2f} m"
