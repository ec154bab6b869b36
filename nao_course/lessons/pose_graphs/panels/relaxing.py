"""The relaxing panel: a graph, step by step, solved by given parts and by the student's, and the blocks of H."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray
from nao_course.lessons.pose_graphs.figures import Function, map_keys, plot_graph, real_building, say_chi2
from nao_course.lessons.pose_graphs.matrices import block_picture
from nao_course.lessons.pose_graphs.panels.given import given_gauss_newton
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
REAL = "a real building, recorded"
LOOP, ROOM_OF_LOOP = "a loop that drifted by 90°", 1.3  # its first step throws it far out
_GUESSES = {
    "odometry": (0.0, 0.0),
    "each position off at random, σ 100 m": (100.0, 0.0),
    "each heading off at random, σ 20°": (0.0, 20.0),
    "each heading off at random, σ 60°": (0.0, 60.0),
}


_PARTS = ("landmark_residual", "landmark_residual_jacobians", "pose_residual", "pose_residual_jacobians")
_FUNCTIONS = (*_PARTS, "linearize", "gauss_newton")


def _recorded() -> World:
    """Return the graph of the Intel Research Lab, with the map of smallest chi2 in place of the unknown truth."""
    graph, odometry = real_building()
    return World(graph, given_gauss_newton(graph, odometry, 4)[0], odometry)


_WORLDS = {
    "a building": lambda: building(5, 240),
    "a building, one false closure": lambda: with_false_closures(building(5, 240), 1, 2),
    LOOP: lambda: drifting_loop(np.pi / 2),
    "the half field": lambda: field_drive(1),
    REAL: _recorded,
}


@cache
def world_named(name: str) -> World:
    """Return one of the panel's worlds, which is made only once."""
    return _WORLDS[name]()


def initial_estimate(world: World, name: str) -> FloatArray:
    """Return the states before the first step: from odometry, or the truth with noise."""
    position, heading = _GUESSES[name]
    if name == "odometry":
        return world.odometry.copy()
    return disturbed(world, position, np.radians(heading), np.random.default_rng(0))


class RelaxPanel(PlayerPanel):
    """A graph that relaxes step by step. Your functions replace the parts of the given solver.

    Parameters
    ----------
    world : str
        The graph at first.
    **functions : callable
        Your functions of exercises 9.1 to 9.6, by their names. The given solver computes what is missing or not
        finished. With `linearize` the panel also shows the blocks of your H.
    """

    def __init__(self, world: str = "a building", **functions: Function) -> None:
        """Show the initial estimate and build the widgets."""
        if unknown := functions.keys() - set(_FUNCTIONS):
            raise TypeError(
                f"RelaxPanel has no part {', '.join(sorted(unknown))}; it has {', '.join(_FUNCTIONS)}"
            )
        super().__init__(
            "Relaxing panel",
            self._relax,
            Slider(
                "step", "Step", 0, STEPS, 1, 0, tooltip="Gauss-Newton steps; the arrow keys go on and back"
            ),
            [
                Choice("world", "Graph", tuple(_WORLDS), world, tooltip="Which drive", stays=True),
                Choice(
                    "guess", "Initial estimate", tuple(_GUESSES), tooltip="The states before the first step"
                ),
            ],
            speeds={"one after the other": PACE},
            backwards=False,
            student=functions,
            drawn=("Blocks of H",),
        )

    def _relax(self, values: Any, student: Mapping[str, Function]) -> Iterator[Any]:
        """Show the states after some steps, and H at these states."""
        world = world_named(values.world)
        start = initial_estimate(world, values.guess)
        states, chi2, own = _solved(world, start, values.step, student)
        yield {"Graph": draw_map(world, states, values)}
        error = _say_error(world, states)
        error += " from the map with the smallest chi2" if values.world == REAL else ""
        if values.step == 0:
            yield f"Before the first step: {values.guess}, chi2 {say_chi2(float(chi2[0]))}, off by {error}."
        else:
            before, after = (say_chi2(float(each)) for each in chi2[-2:])
            yield f"Step {values.step}: chi2 {before} -> {after}, off by {error}."
        rest = "It calls your other functions." if "gauss_newton" in own else "The rest is given."
        yield f"Your code: {', '.join(own)}. {rest}" if own else "The given solver."
        if "linearize" in student:
            try:
                H = student["linearize"](world.graph, states)[0]
            except NotImplementedError:
                yield "Finish exercise 9.5 to see the blocks of H."
                return
            yield Legend(_block_colours(world))
            yield {"Blocks of H": block_picture(H, world.graph.poses)}
            part = 100 * H.nnz / np.prod(H.shape)
            yield f"H has {H.shape[0]} rows; {part:.1f} % of it is stored."


def _solved(
    world: World, start: FloatArray, steps: int, student: Mapping[str, Function]
) -> tuple[FloatArray, FloatArray, list[str]]:
    """Return the states after some steps, the history of chi2, and which functions of the student's were used."""
    graph = world.graph
    if "gauss_newton" in student:
        try:
            states, chi2 = student["gauss_newton"](graph, start, steps)
            return np.asarray(states, dtype=float), np.asarray(chi2, dtype=float), ["gauss_newton"]
        except NotImplementedError:
            pass
    poses, landmarks = graph.split(start)
    parts = {}
    for name in student.keys() & set(_PARTS):
        edges, ends = (
            (graph.pose_edges, poses) if name.startswith("pose") else (graph.landmark_edges, landmarks)
        )
        try:
            student[name](poses[edges.first], ends[edges.second], edges.z)
        except NotImplementedError:
            continue
        if len(edges.z):
            parts[name] = student[name]
    return *given_gauss_newton(graph, start, steps, **parts), sorted(parts)


def _block_colours(world: World) -> dict[str, str]:
    """Return the meanings of the colours that occur in H."""
    colours = {"own block, next pose": "#3c3c42"}
    colours |= {"closure": "#2a8a82"} if world.closures().any() else {}
    return colours | ({"measurement of a landmark": "#a14566"} if world.graph.landmarks else {})


def _limits(world: World, name: str) -> tuple[FloatArray, FloatArray]:
    """Return the limits along x and y, (2,) each, in which all steps are shown."""
    poses, marks = world.graph.split(world.truth)
    driven = world.graph.split(world.odometry)[0]
    places = np.concatenate([poses[:, :2], driven[:, :2], marks])
    low, high = places.min(axis=0), places.max(axis=0)
    room = (ROOM_OF_LOOP if name == LOOP else ROOM) * (high - low).max()
    return np.array([low[0] - room, high[0] + room]), np.array([low[1] - room, high[1] + room])


@course_style()
def draw_map(world: World, states: FloatArray, values: Any) -> Drawing:
    """Draw a graph at some states, with the same limits for every step."""
    false = int("false" in values.world)
    figure = Figure(figsize=(5.9, 4.95))
    ax = figure.add_subplot()
    source = "graph" if values.step else "odometry"
    real = values.world == REAL
    plot_graph(world, states, ax, source=source, false=false, truth=not real)
    x, y = _limits(world, values.world)
    ax.set(xlim=x, ylim=y)
    legend_below(figure, map_keys(world, false=bool(false), sources=(source,), truth=not real), columns=3)
    return Drawing(figure, f"The graph after {values.step} steps, off by {_say_error(world, states)}.")


def _say_error(world: World, states: FloatArray) -> str:
    return f"{position_error(world, states):.2f} m"
