"""The map that the student's solver makes of a laser scanner's log, which is not part of the course."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nao_course._internal.counts import say_count
from nao_course.datasets import read_carmen_log, read_mcap_log
from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.pose_graphs.figures import GaussNewton, same_limits
from nao_course.lessons.pose_graphs.scans import Scan, graph_of_scans, scan_of, used_scans
from nao_course.plotting import Drawing, course_style
from nao_course.plotting.legends import legend_below, source_key
from nao_course.plotting.style import GREY, style_of

WHERE = "ipb.uni-bonn.de/datasets"


@course_style()
def draw_scans(path: Path | str, gauss_newton: GaussNewton) -> Drawing:
    """Draw the scans of a log, by odometry and by a graph that the student's function solves.

    Parameters
    ----------
    path : path
        Path of the log: of ROS 2 if it ends in .mcap, otherwise in CARMEN's format.
    gauss_newton : callable
        Exercise 9.6.

    Returns
    -------
    Drawing
        Two maps of the same scans.

    Raises
    ------
    FileNotFoundError
        If there is no such file. The message says where to get one.
    ValueError
        If the file is malformed, or if the robot does not move.
    """
    if not Path(path).is_file():
        raise FileNotFoundError(
            f"There is no file {path} here. The course does not contain this log: download one in CARMEN's format "
            f"from {WHERE}, unpack it beside this notebook, and write its name into the cell."
        )
    log = (read_mcap_log if Path(path).suffix == ".mcap" else read_carmen_log)(path)
    graph, odometry, states = graph_of_scans(log, gauss_newton)
    chi2 = float(gauss_newton(graph, states.copy(), 0)[1][-1])
    scans = [scan_of(log, number) for number in used_scans(log)]
    count = len(graph.edges) - graph.poses + 1
    quotient = chi2 / max(graph.degrees_of_freedom, 1)
    said = f"{say_count(count, 'closure')}, χ² per degree of freedom {quotient:.2g}"
    figure = Figure(figsize=(12.0, 6.0))
    axes = figure.subplots(1, 2)
    for ax, source, found, title in zip(
        axes, ("odometry", "graph"), (odometry, states), ("odometry", f"graph: {said}"), strict=True
    ):
        _plot_scans(scans, found.reshape(-1, 3), ax, source)
        ax.set_title(title)
    same_limits(axes)
    legend_below(figure, [source_key("odometry"), source_key("graph", "poses by the graph")])
    moved = np.hypot(*(states - odometry).reshape(-1, 3)[:, :2].T).max()
    return Drawing(
        figure,
        f"Two maps of {len(scans)} laser scans, by odometry and by the graph: {said}. The graph moves poses by up to "
        f"{moved:.1f} m.",
    )


def _plot_scans(scans: list[Scan], poses: FloatArray, ax: Axes, source: str) -> None:
    points = np.concatenate(
        [Pose(*pose).to_parent(scan.points) for scan, pose in zip(scans, poses, strict=True)]
    )
    ax.plot(*points.T, ",", color=GREY, alpha=0.5, zorder=1)
    ax.plot(*poses[:, :2].T, "-", color=style_of(source).colour, lw=0.8)
    ax.set(xlabel="x (m)", ylabel="y (m)")
    ax.set_aspect("equal", adjustable="box")
    ax.autoscale_view()
