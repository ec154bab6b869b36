"""The uncertainty of a map: ellipses along a drive without and with its closures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import scipy.sparse
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray
from nao_course.graphs import Graph
from nao_course.lessons.pose_graphs.figures import GaussNewton, same_limits
from nao_course.lessons.pose_graphs.worlds import World, building
from nao_course.plotting import STYLES, Drawing, course_style, ellipse_outlines
from nao_course.plotting.ellipses import filled_outlines
from nao_course.plotting.legends import legend_below, source_key
from nao_course.plotting.style import style_of

Function = Callable[..., Any]


def without_closures(graph: Graph) -> Graph:
    """Return the graph with its odometry edges only."""
    follows = graph.edges[:, 1] == graph.edges[:, 0] + 1
    return replace(
        graph,
        edges=graph.edges[follows],
        measurements=graph.measurements[follows],
        information=graph.information[follows],
    )


def blocks_at(
    graph: Graph, states: FloatArray, numbers: Any, linearize: Function, marginal_covariances: Function
) -> list[FloatArray]:
    """Return the covariances (3, 3) of some poses with numbers from 1, with the first pose held."""
    H, _ = linearize(graph, states)
    rows = [3 * (int(number) - 1) + np.arange(3) for number in numbers]
    return [np.asarray(each) for each in marginal_covariances(scipy.sparse.csc_array(H)[3:, 3:], rows)]


@course_style()
def draw_uncertainty(
    linearize: Function, gauss_newton: GaussNewton, marginal_covariances: Function
) -> Drawing:
    """Draw ellipses of 95 % along a drive through a building, by its odometry and with its closures."""
    world = building(5)
    numbers = np.arange(17, world.graph.poses, 17)
    alone = without_closures(world.graph)
    solved = gauss_newton(world.graph, world.odometry.copy(), 6)[0]
    said = []
    figure = Figure(figsize=(11.0, 4.9))
    axes = figure.subplots(1, 2)
    for ax, (title, graph, states, source) in zip(
        axes,
        (
            ("odometry alone", alone, world.odometry, "odometry"),
            ("with closures", world.graph, solved, "graph"),
        ),
        strict=True,
    ):
        blocks = blocks_at(graph, states, numbers, linearize, marginal_covariances)
        _plot_ellipses(world, states, numbers, blocks, source, ax)
        sigma = [float(np.sqrt(np.linalg.eigvalsh(each[:2, :2])[-1])) for each in blocks]
        ax.set_title(f"{title}: largest σ {min(sigma):.2f} to {max(sigma):.2f} m", fontsize=11)
        said.append(
            f"{title}, the standard deviation along the longest axis is {min(sigma):.2f} to {max(sigma):.2f} m"
        )
    same_limits(axes)
    keys = [
        source_key("odometry"),
        source_key("graph", "poses by the graph"),
        source_key("truth", "true position"),
    ]
    legend_below(figure, keys, columns=3)
    return Drawing(figure, f"Ellipses of 95 % along a drive through a building: {'; '.join(said)}.")


def _plot_ellipses(
    world: World, states: FloatArray, numbers: Any, blocks: list[FloatArray], source: str, ax: Axes
) -> None:
    poses, truth = (world.graph.split(each)[0] for each in (states, world.truth))
    style = style_of(source)
    ax.plot(*poses[:, :2].T, color=style.colour, ls=style.line, lw=1.1, zorder=3)
    outlines = ellipse_outlines(poses[numbers, :2], np.array(blocks)[:, :2, :2])
    ax.add_collection(filled_outlines(outlines, style.colour))
    errors = np.stack([poses[numbers, :2], truth[numbers, :2]], axis=1)
    ax.add_collection(LineCollection(list(errors), colors=STYLES["truth"].colour, linewidths=0.7, zorder=4))
    ax.plot(*truth[numbers, :2].T, "o", color=STYLES["truth"].colour, ms=3.5, zorder=5)
    ax.set(xlabel="x (m)", ylabel="y (m)")
    ax.set_aspect("equal")
    ax.autoscale_view()
