"""The figure of lesson 09's challenge: the error of each drive, and the map of the worst."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator

from nao_course.challenges import Run
from nao_course.geometry import FloatArray
from nao_course.lessons.pose_graphs.figures import same_scale
from nao_course.lessons.pose_graphs.robust import CLOSURE
from nao_course.lessons.pose_graphs.worlds import World, position_error
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import FOUND

Flags = npt.NDArray[np.bool_]


@course_style()
def draw_entries(run: Run) -> Drawing:
    """Draw the error of each drive beside the error of its odometry, and the maps of the best and the worst drive."""
    kept = [(number, each.score, each.kept) for number, each in enumerate(run.results, start=1) if each.kept]
    graph, odometry = STYLES["graph"], STYLES["odometry"]
    figure = Figure(figsize=(12.0, 4.3))
    errors, best, worst = figure.subplots(1, 3, width_ratios=(1.3, 1.0, 1.0))
    numbers = [number for number, *_ in kept]
    drifted = [position_error(world, world.odometry) for _, _, (world, *_) in kept]
    errors.plot(numbers, drifted, odometry.marker, color=odometry.colour, mfc="none", label="odometry")
    errors.plot(numbers, [score for _, score, _ in kept], graph.marker, color=graph.colour, label="yours")
    errors.set(xlabel="drive", ylabel="error of the poses (m)", yscale="log")
    errors.set_xticks(range(2, len(run.results) + 1, 2))
    errors.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    errors.yaxis.set_major_formatter("{x:g}")
    errors.minorticks_off()
    errors.grid(axis="y", alpha=0.3)
    errors.legend()
    ranked = sorted(kept, key=lambda each: each[1])
    for ax, which in ((best, ranked[:1]), (worst, ranked[-1:])):
        for number, score, (world, states, false, accepted) in which:
            _plot_accepted(world, states, false, accepted, ax)
            ax.set_title(f"{'best' if ax is best else 'worst'}: drive {number}, {score:.2f} m", fontsize=11)
    same_scale((best, worst))
    legend_below(figure, _keys(), columns=4)
    median = float(np.median([score for _, score, _ in kept])) if kept else float("nan")
    return Drawing(
        figure,
        f"Errors of {len(kept)} drives, {median:.2f} m in the median, and maps of the best and of the worst.",
    )


def _plot_accepted(world: World, states: FloatArray, false: Flags, accepted: Flags, ax: Axes) -> None:
    graph = world.graph
    poses, truth = (graph.split(each)[0] for each in (states, world.truth))
    ax.plot(*truth[:, :2].T, color=STYLES["truth"].colour, lw=1.0, alpha=0.45)
    ax.plot(*poses[:, :2].T, color=STYLES["graph"].colour, lw=1.4)
    closing = world.closures()
    for chosen, colour in ((closing & ~false & accepted, CLOSURE), (closing & false & accepted, FOUND)):
        ends = poses[graph.edges[chosen]][:, :, :2]
        ax.add_collection(LineCollection(list(ends), colors=colour, linewidths=2.0, zorder=3))
        ax.plot(*ends.reshape(-1, 2).T, ".", color=colour, ms=6, zorder=4)
    ax.set(xlabel="x (m)", ylabel="y (m)")
    ax.set_aspect("equal")


def _keys() -> list[Line2D]:
    styles = {
        "true path": (STYLES["truth"].colour, 0.45),
        "yours": (STYLES["graph"].colour, 1.0),
        "true closure, accepted": (CLOSURE, 1.0),
        "false closure, accepted": (FOUND, 1.0),
    }
    return [
        Line2D([], [], color=colour, alpha=alpha, lw=2, label=name)
        for name, (colour, alpha) in styles.items()
    ]
