"""The edge panel: edges are added one by one, and each adds its blocks to H."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray
from nao_course.graphs import POSE, Graph
from nao_course.lessons.pose_graphs.worlds import World, small_world
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.matrix_signs import NEGATIVE, POSITIVE, paint_matrix
from nao_course.plotting.style import FOUND, GREY
from nao_course.widgets import Legend, PlayerPanel, Slider


@cache
def _world() -> World:
    return small_world()


def first_edges(graph: Graph, count: int) -> Graph:
    """Return a graph with its first `count` edges."""
    return replace(
        graph,
        edges=graph.edges[:count],
        measurements=graph.measurements[:count],
        information=graph.information[:count],
    )


def rows_of(graph: Graph, number: int) -> list[int]:
    """Return the rows of H that belong to the two ends of an edge."""
    rows: list[int] = []
    for end in graph.edges[number].tolist():
        width = 3 if graph.kinds[end] == POSE else 2
        begin = 3 * min(end, graph.poses) + 2 * max(end - graph.poses, 0)
        rows += range(begin, begin + width)
    return rows


class EdgePanel(PlayerPanel):
    """A small graph whose edges are added one by one, and the rows and columns of H that each edge changes.

    Parameters
    ----------
    linearize : callable, optional
        Your function of exercise 9.5. Without it, the panel only frames the entries that the newest edge changes.
    """

    def __init__(self, linearize: Any = None) -> None:
        """Add the first edges and build the widgets."""
        count = len(_world().graph.edges)
        super().__init__(
            "Edge panel",
            self._add,
            Slider(
                "count", "Edges", 1, count, 1, 9, tooltip="Number of edges so far; the arrow keys add one"
            ),
            speeds={"2 a second": 2.0},
            backwards=False,
            drawn=("H",),
            student={} if linearize is None else {"linearize": linearize},
        )

    def _add(self, values: Any, student: Mapping[str, Any]) -> Iterator[Any]:
        """Show the graph and the matrix with the edges so far."""
        world = _world()
        graph, newest = first_edges(world.graph, values.count), values.count - 1
        first, second = (_name(graph, end) for end in graph.edges[newest])
        rows = rows_of(graph, newest)
        H = np.zeros((graph.size, graph.size))
        for number in range(newest):
            H[np.ix_(rows_of(graph, number), rows_of(graph, number))] = 1.0
        colours = {"changed by an earlier edge": POSITIVE, "newest edge": FOUND}
        said = "The frames show which entries the newest edge changes."
        if "linearize" in student:
            try:
                H = student["linearize"](graph, world.odometry)[0].toarray()
                colours = {"positive": POSITIVE, "negative": NEGATIVE, "newest edge": FOUND}
                said = f"{np.count_nonzero(H)} of {H.size} entries of your H are not zero."
            except NotImplementedError:
                said += " Finish exercise 9.5 to see your H."
        yield Legend(colours)
        yield {"Graph": _draw(world, newest)}
        yield {"H": paint_matrix(H, 3 * graph.poses, rows)}
        yield f"Edge {values.count}: from {first} to {second}. It changes {len(rows)} rows and columns."
        yield said


def _name(graph: Graph, end: int) -> str:
    return f"pose {end}" if end < graph.poses else f"landmark {'AB'[end - graph.poses]}"


@course_style()
def _draw(world: World, newest: int) -> Drawing:
    """Draw the edges up to the newest one."""
    graph = world.graph
    poses, marks = graph.split(world.odometry)
    places: FloatArray = np.concatenate([poses[:, :2], marks])
    figure = Figure(figsize=(5.0, 4.6))
    ax = figure.add_subplot()
    for number, ends in enumerate(graph.edges[: newest + 1]):
        is_newest = number == newest
        ax.plot(*places[ends].T, color=FOUND if is_newest else GREY, lw=3.0 if is_newest else 1.5)
    style = STYLES["graph"]
    ax.plot(*poses[:, :2].T, "o", color=style.colour, ms=15, mec="white")
    ax.plot(*marks.T, "P", color=style.colour, ms=17, mec="white")
    for end, place in enumerate(poses[:, :2]):
        ax.annotate(str(end), place, ha="center", va="center", color="white", fontsize=9)
    for label, place in zip("AB", marks, strict=False):
        ax.annotate(label, place, (12, 0), textcoords="offset points", va="center", fontsize=11)
    ax.set(xlabel="x (m)", ylabel="y (m)")
    ax.set_aspect("equal")
    ax.margins(0.12)
    return Drawing(figure, f"A loop of {graph.poses} poses with two landmarks and {newest + 1} edges.")
