"""A real building: the graph of the Intel Research Lab in Seattle, read where the recordings are."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from nao_course.datasets import data_folder, read_g2o
from nao_course.geometry import FloatArray
from nao_course.graphs import Graph
from nao_course.lessons.pose_graphs.figures import CLOSURE, GaussNewton, say_chi2
from nao_course.lessons.pose_graphs.worlds import chained
from nao_course.plotting import STYLES, Drawing, course_style

INTEL = "slam/g2o/openslam_intel.g2o"


def intel_graph() -> tuple[Graph, FloatArray]:
    """The graph of 943 poses in the Intel Research Lab, and the states that its odometry alone gives.

    Returns
    -------
    graph : Graph
    states : ndarray, shape (2829,)

    Raises
    ------
    FileNotFoundError
        If there are no recordings; the message says what to do.
    """
    graph, states = read_g2o(data_folder() / INTEL)
    follows = np.flatnonzero(graph.edges[:, 1] == graph.edges[:, 0] + 1)
    order = follows[np.argsort(graph.edges[follows, 0], kind="stable")]
    first = order[np.unique(graph.edges[order, 0], return_index=True)[1]]
    return graph, chained(states[:3], graph.measurements[first]).ravel()


def draw_real_building(gauss_newton: GaussNewton, steps: tuple[int, ...] = (0, 1, 3)) -> Drawing | str:
    """Draw how the graph of a real building relaxes from its odometry; where it is not there, say so."""
    try:
        graph, states = intel_graph()
    except FileNotFoundError as error:
        return f"The picture above was made by the solution. {error}"
    said = []
    with course_style():
        figure = Figure(figsize=(12.0, 4.3))
        for ax, step in zip(figure.subplots(1, len(steps)), steps, strict=True):
            found, chi2 = gauss_newton(graph, states.copy(), step)
            title = "odometry" if step == 0 else f"after {step} step{'s' if step > 1 else ''}"
            _plot_poses(graph, np.asarray(found), ax, "graph" if step else "odometry")
            ax.set_title(f"{title}\nχ² = {say_chi2(float(chi2[-1]))}", fontsize=11)
            said.append(f"{title} {say_chi2(float(chi2[-1]))}")
    return Drawing(
        figure,
        f"The graph of the Intel Research Lab, {graph.poses} poses, on its way from odometry; chi2: {', '.join(said)}.",
    )


def _plot_poses(graph: Graph, states: FloatArray, ax: Axes, source: str) -> None:
    poses = graph.split(states)[0]
    closing = graph.edges[:, 1] != graph.edges[:, 0] + 1
    ends = poses[graph.edges[closing]][:, :, :2]
    ax.add_collection(LineCollection(list(ends), colors=CLOSURE, linewidths=0.5, alpha=0.7))
    ax.plot(*poses[:, :2].T, "-", color=STYLES[source].colour, lw=0.8, marker=".", ms=1.8)
    ax.set(xlabel="x (m)", ylabel="y (m)")
    ax.set_aspect("equal", adjustable="datalim")
