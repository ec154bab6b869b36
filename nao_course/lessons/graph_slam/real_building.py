"""A real building as a linear graph, with the headings of its odometry."""

from __future__ import annotations

import numpy as np
import scipy.sparse
from matplotlib.figure import Figure

from nao_course.datasets.intel import intel_graph
from nao_course.geometry import FloatArray, rotation_2d
from nao_course.graphs import Graph
from nao_course.lessons.graph_slam.systems import Function
from nao_course.plotting import Drawing, course_style
from nao_course.plotting.style import style_of

START = 1e6  # weight of the first position, 1/m^2


def positions_of(graph: Graph, headings: FloatArray, solve_sparse: Function) -> FloatArray:
    """Return the positions (n, 2) of a graph's poses, m, with given headings (n,), by the student's function."""
    i, j = graph.edges.T
    moves = np.einsum(
        "kab,kb->ka", np.array([rotation_2d(each) for each in headings[i]]), graph.measurements[:, :2]
    )
    weights = graph.information[:, 0, 0]
    rows = np.arange(len(i))
    A = scipy.sparse.csr_array(
        (np.repeat([-1.0, 1.0], len(i)), (np.tile(rows, 2), np.append(i, j))), shape=(len(i), len(headings))
    )
    weighted = A.T @ scipy.sparse.diags_array(weights)
    omega = (weighted @ A).tolil()
    omega[0, 0] += START
    return np.column_stack([solve_sparse(omega.tocsc(), weighted @ axis) for axis in moves.T])


@course_style()
def draw_real_building(solve_sparse: Function) -> Drawing:
    """Draw the Intel Research Lab by odometry, and by a linear graph with the headings of the odometry.

    Parameters
    ----------
    solve_sparse : callable
        The student's function of exercise 8.6.

    Returns
    -------
    Drawing
        Two maps of 943 poses.
    """
    graph, stored, steps = intel_graph()
    good = stored.reshape(-1, 3)
    headings = good[0, 2] + np.append(0.0, np.cumsum(steps[:, 2]))
    moves = np.einsum("kab,kb->ka", np.array([rotation_2d(each) for each in headings[:-1]]), steps[:, :2])
    maps = {
        "odometry": good[0, :2] + np.vstack([np.zeros(2), np.cumsum(moves, axis=0)]),
        "graph": positions_of(graph, headings, solve_sparse) + good[0, :2],
    }
    figure = Figure(figsize=(9.6, 4.6))
    said = []
    for ax, (source, found) in zip(figure.subplots(1, 2), maps.items(), strict=True):
        off = np.sqrt(np.mean(np.sum(np.square(found - good[:, :2]), axis=1)))
        style = style_of(source)
        ax.plot(*found.T, "-", color=style.colour, lw=0.8, marker=".", ms=1.8)
        ax.set(xlabel="x (m)", ylabel="y (m)", title=f"{style.label}: {off:.1f} m")
        ax.set_aspect("equal", adjustable="box")
        said.append(f"the {source} differs from it by {off:.1f} m")
    return Drawing(
        figure,
        f"Positions of {len(good)} poses in a real building. With the map of a nonlinear graph for comparison, "
        f"{' and '.join(said)}, root mean square.",
    )
