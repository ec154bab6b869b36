"""How false loop closures bend a map, and how a kernel that reduces the weight of bad edges helps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator

from nao_course.geometry import FloatArray
from nao_course.graphs import Graph
from nao_course.lessons.pose_graphs.worlds import World, building, position_error, with_false_closures
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import FOUND

GaussNewton = Callable[[Graph, FloatArray, int], tuple[FloatArray, FloatArray]]
Reweight = Callable[[Graph, FloatArray, float], Graph]

COUNTS = (0, 1, 2, 5, 10, 20)
SEEDS = (1, 2, 3, 4, 5)
SHOWN = 2  # building with the median error with the kernel and twenty false closures
WIDTH = 3.0  # standard deviations: a larger error counts less and less
PLAIN_ITERATIONS, ROBUST_ITERATIONS = 8, 15
CLOSURE = "#2a8a82"  # edges to recognised poses
FAR = 3.0  # m between two poses that no true closure connects
TRUE_COLOUR, FALSE_COLOUR = CLOSURE, FOUND


def robust_gauss_newton(
    gauss_newton: GaussNewton, reweight: Reweight, graph: Graph, states: FloatArray
) -> FloatArray:
    """Compute a weight for each edge from its error and take one step of Gauss-Newton, again and again.

    Parameters
    ----------
    gauss_newton, reweight : callable
        The student's.
    graph : Graph
        Some of its edges may be false.
    states : ndarray, shape (graph.size,)
        Initial estimate. A kernel finds a map near it, so odometry is better than a bent map.

    Returns
    -------
    ndarray, shape (graph.size,)
    """
    for _ in range(ROBUST_ITERATIONS):
        states, _ = gauss_newton(reweight(graph, states, WIDTH), states, 1)
    return states


def edge_weights(reweight: Reweight, graph: Graph, states: FloatArray) -> FloatArray:
    """Return the weight of each edge at these states: (E,), from 0 to 1."""
    left: FloatArray = reweight(graph, states, WIDTH).information[:, 0, 0] / graph.information[:, 0, 0]
    return left


@dataclass(frozen=True, eq=False)
class FalseClosures:
    """Root mean square errors (C, S) in m of the poses in S buildings, for C numbers of false loop closures.

    They are by odometry, with equal weights, with the kernel, and with the kernel started late, on the map with equal
    weights.
    """

    counts: tuple[int, ...]
    odometry: FloatArray
    plain: FloatArray
    robust: FloatArray
    late: FloatArray


def errors_by_false_closures(
    gauss_newton: GaussNewton,
    reweight: Reweight,
    counts: Sequence[int] = COUNTS,
    seeds: Sequence[int] = SEEDS,
    poses: int = 300,
) -> FalseClosures:
    """Map buildings with more and more false closures, with and without the kernel. A drive has a pose every metre."""
    errors = np.array(
        [[_errors(gauss_newton, reweight, _world(seed, count, poses)) for seed in seeds] for count in counts]
    )
    return FalseClosures(tuple(counts), *np.moveaxis(errors, 2, 0))


@course_style()
def draw_false_closures(
    gauss_newton: GaussNewton, reweight: Reweight, found: FalseClosures | None = None
) -> Drawing:
    """Draw a map with twenty false closures, without and with the kernel, and the error by their number.

    Parameters
    ----------
    gauss_newton, reweight : callable
        The student's.
    found : FalseClosures, optional
        Result of `errors_by_false_closures`, which is called by default.

    Returns
    -------
    Drawing
        Two maps and a plot.
    """
    found = found or errors_by_false_closures(gauss_newton, reweight)
    world = _world(SHOWN, COUNTS[-1], 300)
    plain, _ = gauss_newton(world.graph, world.odometry, PLAIN_ITERATIONS)
    robust = robust_gauss_newton(gauss_newton, reweight, world.graph, world.odometry)
    figure = Figure(figsize=(12.0, 4.3))
    first, second, third = figure.subplots(1, 3, width_ratios=(1.0, 1.0, 1.25))
    _plot_map(world, plain, np.ones(len(world.graph.edges)), first)
    first.set_title(
        f"{COUNTS[-1]} false closures, equal weights:\n{position_error(world, plain):.1f} m off", fontsize=11
    )
    _plot_map(world, robust, edge_weights(reweight, world.graph, robust), second)
    second.set_title(
        f"{COUNTS[-1]} false closures, with the kernel:\n{position_error(world, robust):.1f} m off",
        fontsize=11,
    )
    _plot_errors(found, third)
    legend_below(figure, [*third.get_legend_handles_labels()[0], *_map_keys()])
    return Drawing(
        figure,
        f"A building with {COUNTS[-1]} false loop closures: {position_error(world, plain):.1f} m off with equal "
        f"weights, {position_error(world, robust):.1f} m with the kernel. {_say(found)}",
    )


def _world(seed: int, count: int, poses: int) -> World:
    return with_false_closures(building(seed, poses), count, seed)


def _errors(gauss_newton: GaussNewton, reweight: Reweight, world: World) -> list[float]:
    """Return the errors (m) of odometry, of plain Gauss-Newton, with the kernel, and with the kernel started late."""
    plain, _ = gauss_newton(world.graph, world.odometry, PLAIN_ITERATIONS)
    robust, late = (
        robust_gauss_newton(gauss_newton, reweight, world.graph, begin) for begin in (world.odometry, plain)
    )
    return [position_error(world, states) for states in (world.odometry, plain, robust, late)]


def _plot_map(world: World, states: FloatArray, weights: FloatArray, ax: Axes) -> None:
    """Plot the poses, the true path below them, and the closures that have some weight."""
    graph = world.graph
    truth, poses = (graph.split(each)[0] for each in (world.truth, states))
    ax.plot(*truth[:, :2].T, color=STYLES["truth"].colour, lw=1.2, alpha=0.45)
    ax.plot(*poses[:, :2].T, color=STYLES["graph"].colour, lw=1.6)
    chosen = world.closures() & (weights > 0.05)
    lines = poses[graph.edges[chosen]][:, :, :2]
    false = np.hypot(*np.diff(truth[graph.edges[chosen]][:, :, :2], axis=1)[:, 0].T) > FAR
    for which, colour in ((~false, TRUE_COLOUR), (false, FALSE_COLOUR)):
        ax.add_collection(LineCollection(lines[which], colors=colour, lw=1.3, zorder=3))
    low, high = truth[:, :2].min(axis=0) - FAR, truth[:, :2].max(axis=0) + FAR
    ax.set(aspect="equal", xlabel="x (m)", ylabel="y (m)", xlim=(low[0], high[0]), ylim=(low[1], high[1]))


def _map_keys() -> list[Line2D]:
    styles = {"true path": (STYLES["truth"].colour, 1.2, 0.45), "true closure": (TRUE_COLOUR, 1.3, 1.0)}
    styles["false closure with weight"] = (FALSE_COLOUR, 1.3, 1.0)
    return [
        Line2D([], [], color=colour, lw=width, alpha=alpha, label=name)
        for name, (colour, width, alpha) in styles.items()
    ]


def _plot_errors(found: FalseClosures, ax: Axes) -> None:
    """Plot medians, and bands from the best building to the worst."""
    at = np.arange(len(found.counts))
    odometry, graph = STYLES["odometry"], STYLES["graph"]
    rows = {
        "odometry alone": (odometry.colour, odometry.marker, "-", found.odometry),
        "equal weights": ("#7d8b1e", "v", "-", found.plain),
        "with the kernel": (graph.colour, graph.marker, "-", found.robust),
        "kernel, started on the bent map": ("#5b4a9c", "s", "--", found.late),
    }
    for name, (colour, marker, line, errors) in rows.items():
        ax.fill_between(at, errors.min(axis=1), errors.max(axis=1), color=colour, alpha=0.13, lw=0)
        ax.plot(at, np.median(errors, axis=1), color=colour, marker=marker, ls=line, lw=2, label=name)
    ax.set_title(f"medians; bands: all {found.plain.shape[1]} buildings", fontsize=11)
    ax.set(yscale="log", xlabel="false loop closures", ylabel="error of the poses (m)")
    ax.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    ax.yaxis.set_major_formatter("{x:g}")
    ax.minorticks_off()
    ax.set_xticks(at, [str(count) for count in found.counts])
    ax.grid(axis="y", color="#e3e5e8")


def _say(found: FalseClosures) -> str:
    """Return the medians of the figure in words."""
    rows = zip(found.counts, np.median(found.plain, axis=1), np.median(found.robust, axis=1), strict=True)
    said = "; ".join(f"{count}: {plain:.1f} and {robust:.1f} m" for count, plain, robust in rows)
    return f"Median error by the number of false closures, without and with the kernel: {said}."
