"""The relaxing panel: a graph, step by step, and the blocks of its matrix."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from typing import Any

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
from nao_course.widgets import Choice, Legend, PlayerPanel, Slider

STEPS = 10
PACE = 1.4  # steps in a second, while it plays
ROOM = 0.2  # of a map's size, around it
LOOP, ROOM_OF_LOOP = "a loop that drifted by 90°", 1.3  # its first step throws it far out
_WORLDS = {
    "a building": lambda: building(5, 240),
    "a building, one false closure": lambda: with_false_closures(building(5, 240), 1, 2),
    LOOP: lambda: drifting_loop(np.pi / 2),
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


class RelaxPanel(PlayerPanel):
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
            Slider("step", "Step", 0, STEPS, 1, 0, tooltip="Gauss-Newton steps: arrow keys go on and back"),
            [
                Choice("world", "Graph", tuple(_WORLDS), tooltip="Which drive", stays=True),
                Choice("guess", "First guess", tuple(_GUESSES), tooltip="Where the first step begins"),
            ],
            speeds={"one after the other": PACE},
            backwards=False,
            student={"linearize": linearize, "gauss_newton": gauss_newton},
            unfinished={
                "linearize": "Finish exercise 9.5 to see the blocks of H.",
                "gauss_newton": "Finish exercise 9.6 to see the graph relax.",
            },
        )

    def _relax(self, values: Any, student: Any) -> Iterator[Any]:
        """Show the states after so many steps, and H there."""
        world = world_named(values.world)
        states = first_guess(world, values.guess)
        yield Legend(_block_colours(world))
        if values.step == 0:
            yield {"Graph": draw_map(world, states, values)}
            yield f"First guess: {values.guess}. Off by {_say_error(world, states)}."
        else:
            states, chi2 = student.gauss_newton(world.graph, states, values.step)
            states, chi2 = np.asarray(states, dtype=float), np.asarray(chi2, dtype=float)
            yield {"Graph": draw_map(world, states, values)}
            before, after = (say_chi2(float(each)) for each in chi2[-2:])
            yield f"Step {values.step}: chi2 {before} -> {after}. Off by {_say_error(world, states)}."
        H = student.linearize(world.graph, states)[0]
        yield {"Blocks of H": block_picture(H, world.graph.poses)}
        part = 100 * H.nnz / np.prod(H.shape)
        yield f"H has {H.shape[0]} rows; {part:.1f} % of it is stored."


def _block_colours(world: World) -> dict[str, str]:
    """What the colours of H's blocks mean, of those that there are."""
    colours = {"own block, next pose": "#3c3c42"}
    colours |= {"closure": "#2a8a82"} if world.closures().any() else {}
    return colours | ({"sight of a landmark": "#a14566"} if world.graph.landmarks else {})


def _limits(world: World, name: str) -> tuple[FloatArray, FloatArray]:
    """The part of the plane that all steps are shown in, (2,) along x and y: truth and odometry, and room around."""
    poses, marks = world.graph.split(world.truth)
    driven = world.graph.split(world.odometry)[0]
    places = np.concatenate([poses[:, :2], driven[:, :2], marks])
    low, high = places.min(axis=0), places.max(axis=0)
    room = (ROOM_OF_LOOP if name == LOOP else ROOM) * (high - low).max()
    return np.array([low[0] - room, high[0] + room]), np.array([low[1] - room, high[1] + room])


def draw_map(world: World, states: FloatArray, values: Any) -> Drawing:
    """Draw a graph at some states, always in the same part of the plane."""
    false = int("false" in values.world)
    with course_style():
        figure = Figure(figsize=(6.2, 5.2))
        ax = figure.add_subplot()
        source = "graph" if values.step else "odometry"
        plot_graph(world, states, ax, source=source, false=false)
        x, y = _limits(world, values.world)
        ax.set(xlim=x, ylim=y)
        legend_below(figure, map_keys(world, false=bool(false), sources=(source,)), columns=3)
    return Drawing(figure, f"The graph after {values.step} steps, off by {_say_error(world, states)}.")


def _say_error(world: World, states: FloatArray) -> str:
    return f"{position_error(world, states):.2f} m"
