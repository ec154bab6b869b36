"""Maps of pose graphs, and figures of how they relax and how a false closure bends them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course._internal.counts import say_count
from nao_course.datasets.intel import FILE, intel_graph
from nao_course.geometry import FloatArray
from nao_course.graphs import Graph
from nao_course.lessons.pose_graphs.robust import CLOSURE
from nao_course.lessons.pose_graphs.worlds import (
    World,
    building,
    chained,
    drifting_loop,
    position_error,
    with_false_closures,
)
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.legends import legend_below, source_key
from nao_course.plotting.style import FOUND, GREY, style_of

Function = Callable[..., Any]
GaussNewton = Callable[[Graph, FloatArray, int], tuple[FloatArray, FloatArray]]

SEED = 5  # of the building
_TRUTH = Line2D([], [], color=STYLES["truth"].colour, lw=1.2, alpha=0.45, label="true path")
_CLOSURES = Line2D([], [], color=CLOSURE, lw=1.4, label="closure")
_LANDMARKS = [
    Line2D([], [], marker="P", color=STYLES["graph"].colour, ls="", ms=8, mec="white", label="landmark"),
    Line2D([], [], marker="o", mfc="none", mec=STYLES["truth"].colour, ls="", ms=9, label="true landmark"),
]


def plot_graph(
    world: World,
    states: npt.ArrayLike,
    ax: Axes,
    *,
    source: str = "graph",
    false: int = 0,
    truth: bool = True,
) -> None:
    """Draw poses, closures, landmarks and the true path; the last `false` edges are false and stand out."""
    graph, style = world.graph, style_of(source)
    poses, marks = graph.split(states)
    if truth:
        true, true_marks = graph.split(world.truth)
        ax.plot(*true[:, :2].T, color=STYLES["truth"].colour, lw=1.2, alpha=0.45, zorder=1)
        ax.plot(*true_marks.T, "o", mfc="none", mec=STYLES["truth"].colour, ms=9, zorder=2)
    closing = world.closures()
    wrong = np.arange(len(closing)) >= len(closing) - false
    for chosen, colour, width in ((closing & ~wrong, CLOSURE, 1.4), (wrong, FOUND, 2.2)):
        ends = poses[graph.edges[chosen]][:, :, :2]
        ax.add_collection(LineCollection(list(ends), colors=colour, linewidths=width, zorder=4.5))
    ax.plot(*poses[:, :2].T, "-", color=style.colour, lw=1.5, marker=".", ms=3, zorder=4)
    to_mark = graph.landmark_edges
    rays = np.stack([poses[to_mark.first, :2], marks[to_mark.second]], axis=1)
    ax.add_collection(LineCollection(list(rays), colors=style.colour, linewidths=0.4, alpha=0.5, zorder=3))
    ax.plot(*marks.T, "P", color=style.colour, ms=8, mec="white", zorder=5)
    ax.plot(*poses[0, :2], "o", color=STYLES["truth"].colour, ms=6, zorder=6)
    ax.set(xlabel="x (m)", ylabel="y (m)")
    ax.set_aspect("equal", adjustable="box")
    ax.autoscale_view()


def map_keys(
    world: World, *, false: bool = False, sources: Sequence[str] = ("odometry", "graph"), truth: bool = True
) -> list[Any]:
    """Return the legend keys of a map."""
    names = {"odometry": "odometry", "graph": "poses by the graph"}
    keys: list[Any] = [source_key(each, names[each]) for each in sources]
    keys += [_TRUTH] if truth else []
    keys += [_CLOSURES] if world.closures().any() else []
    keys += [Line2D([], [], color=FOUND, lw=2.2, label="false closure")] if false else []
    return keys + (_LANDMARKS if world.graph.landmarks else [])


def say_chi2(value: float) -> str:
    """Format chi2 with few digits: "129,796" or "407.1"."""
    return f"{value:,.0f}" if value >= 1000 else f"{value:.1f}" if value >= 10 else f"{value:.2g}"


def relaxed(world: World, gauss_newton: GaussNewton, iterations: int) -> list[FloatArray]:
    """Return the states before the first step and after each step, starting from odometry."""
    every = [world.odometry]
    for _ in range(iterations):
        found, _ = gauss_newton(world.graph, every[-1].copy(), 1)
        every.append(np.asarray(found, dtype=float))
    return every


@course_style()
def draw_relaxing(gauss_newton: GaussNewton) -> Drawing:
    """Draw how a drive through a building relaxes, step by step, with the student's function of exercise 9.6."""
    world, iterations = building(SEED), (0, 1, 2, 4)
    every = relaxed(world, gauss_newton, max(iterations))
    chi2 = gauss_newton(world.graph, world.odometry.copy(), max(iterations))[1]
    said = []
    figure = Figure(figsize=(13.0, 4.45))
    axes = figure.subplots(1, len(iterations))
    for ax, step in zip(axes, iterations, strict=True):
        source = "graph" if step else "odometry"
        plot_graph(world, every[step], ax, source=source)
        title = "odometry" if step == 0 else f"after {say_count(step, 'step')}"
        off = position_error(world, every[step])
        ax.set_title(f"{title}\nχ² = {say_chi2(chi2[step])}, off by {off:.2f} m", fontsize=11)
        said.append(f"{title}, chi2 {say_chi2(chi2[step])} and off by {off:.2f} m")
    same_limits(axes)
    legend_below(figure, map_keys(world), columns=5)
    return Drawing(
        figure,
        f"A drive through a building's corridors, {world.graph.poses} poses, at {len(iterations)} moments: "
        f"{'; '.join(said)}.",
    )


def draw_false_closure(gauss_newton: GaussNewton) -> Drawing:
    """Draw the building without a false closure and with one."""
    clean, world = (with_false_closures(building(SEED), count, seed=2) for count in (0, 1))
    panels = [
        ("all closures true", clean, relaxed(clean, gauss_newton, 8)[-1], 0),
        ("one false closure added", world, relaxed(world, gauss_newton, 8)[-1], 1),
    ]
    return _side_by_side(panels, "A drive through a building")


@course_style()
def _side_by_side(panels: Sequence[tuple[str, World, FloatArray, int]], what: str) -> Drawing:
    said = []
    figure = Figure(figsize=(4.6 * len(panels), 4.5))
    axes = figure.subplots(1, len(panels), squeeze=False)[0]
    for ax, (title, world, states, false) in zip(axes, panels, strict=True):
        plot_graph(world, states, ax, false=false)
        off = position_error(world, states)
        ax.set_title(f"{title}: off by {off:.2f} m", fontsize=11)
        said.append(f"{title}, off by {off:.2f} m")
    same_limits(axes)
    legend_below(figure, map_keys(panels[0][1], false=True, sources=("graph",)), columns=5)
    return Drawing(figure, f"{what}, {len(panels)} times: {'; '.join(said)}.")


def same_scale(axes: Sequence[Axes]) -> None:
    """Give maps side by side the same scale, each around its own centre."""
    half = [max(np.ptp(limits(ax)) for ax in axes) / 2 for limits in (Axes.get_xlim, Axes.get_ylim)]
    for ax in axes:
        x, y = (float(np.mean(each)) for each in (ax.get_xlim(), ax.get_ylim()))
        ax.set(xlim=(x - half[0], x + half[0]), ylim=(y - half[1], y + half[1]))


def same_limits(axes: Sequence[Axes]) -> None:
    """Give maps side by side the same limits, and only the left one a label along y."""
    xs, ys = (np.array([limits(ax) for ax in axes]) for limits in (Axes.get_xlim, Axes.get_ylim))
    for number, ax in enumerate(axes):
        ax.set(xlim=(xs[:, 0].min(), xs[:, 1].max()), ylim=(ys[:, 0].min(), ys[:, 1].max()))
        if number:
            ax.set_ylabel("")


# --- a step that is too long ---


def chi2_along(
    world: World, step: FloatArray, residuals: tuple[Function, Function], parts: FloatArray
) -> FloatArray:
    """Return chi2 at some parts of a step from the odometry."""
    return np.array(
        [world.graph.squared_errors(world.odometry + part * step, *residuals).sum() for part in parts]
    )


@course_style()
def draw_step(
    linearize: Function, gauss_newton: GaussNewton, pose_residual: Function, landmark_residual: Function
) -> Drawing:
    """Draw chi2 along the first step around a loop: predicted by the linear system, and true."""
    drifts = (30.0, 90.0)  # of the odometry's heading on the whole loop, degrees
    parts, said = np.linspace(0.0, 1.25, 51), []
    figure = Figure(figsize=(12.0, 4.4))
    *curves, map_ax = figure.subplots(1, len(drifts) + 1, width_ratios=(*(1.0 for _ in drifts), 1.25))
    for ax, drift in zip(curves, drifts, strict=True):
        world = drifting_loop(np.radians(drift))
        step = np.asarray(gauss_newton(world.graph, world.odometry.copy(), 1)[0]) - world.odometry
        H, b = linearize(world.graph, world.odometry)
        true = chi2_along(world, step, (pose_residual, landmark_residual), parts)
        promised = true[0] + 2 * parts * (b @ step) + parts**2 * (step @ (H @ step))
        ax.plot(parts, promised / true[0], "--", color=GREY, lw=1.8, label="predicted by H and b")
        ax.plot(parts, true / true[0], color=STYLES["graph"].colour, lw=2.2, label="true")
        ax.axvline(1.0, color=GREY, lw=0.8)
        best = int(np.argmin(true))
        ax.plot(parts[best], true[best] / true[0], "o", color=STYLES["graph"].colour, mec="white", ms=9)
        ax.annotate(
            f"lowest at {parts[best]:.2f}",
            (parts[best], true[best] / true[0]),
            xytext=(0, 44),
            textcoords="offset points",
            ha="center",
        )
        ax.set(xlabel="part of the step", ylim=(0, 2.9), xlim=(0, 1.25))
        ax.set_title(f"heading drifted by {drift:.0f}°", fontsize=11)
        ends = true[40] / true[0], promised[40] / true[0]
        said.append(
            f"with a drift of {drift:.0f} degrees the full step leaves {ends[0]:.2f} of chi2 where "
            f"{ends[1]:.3f} was predicted, and the lowest point is at {parts[np.argmin(true)]:.2f} of it"
        )
    curves[0].set_ylabel("χ² / χ² at the start")
    curves[0].legend(loc="upper left", bbox_to_anchor=(0, -0.2))
    world = drifting_loop(np.radians(drifts[-1]))
    every = relaxed(world, gauss_newton, 3)
    _plot_steps(world, every, map_ax)
    map_ax.set_title(f"the loop that drifted by {drifts[-1]:.0f}°", fontsize=11)
    return Drawing(
        figure, f"Chi2 along the first Gauss-Newton step round a closed square: {'; '.join(said)}."
    )


def _plot_steps(world: World, every: Sequence[FloatArray], ax: Axes) -> None:
    colours = [
        ("odometry", STYLES["odometry"].colour),
        ("after 1 step", "#e0b0be"),
        ("after 2", "#c8718b"),
        ("after 3", STYLES["graph"].colour),
    ]
    for (label, colour), states in zip(colours, every, strict=True):
        ax.plot(*world.graph.split(states)[0][:, :2].T, color=colour, lw=1.8, label=label)
    ax.plot(
        *world.graph.split(world.truth)[0][:, :2].T,
        color=STYLES["truth"].colour,
        lw=1.2,
        alpha=0.45,
        label="truth",
    )
    ax.set(xlabel="x (m)", ylabel="y (m)")
    ax.set_aspect("equal", adjustable="datalim")
    # Below the axes, because the legend's lines would look like paths inside.
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=2, fontsize=9)


def first_step_ratio(gauss_newton: GaussNewton, drift: float) -> float:
    """Return the factor by which the first step changes chi2 for a drift of the heading around a loop (degrees)."""
    world = drifting_loop(np.radians(drift))
    chi2 = gauss_newton(world.graph, world.odometry.copy(), 1)[1]
    return float(chi2[1] / chi2[0])


def drift_that_climbs(gauss_newton: GaussNewton) -> float:
    """Return the drift (degrees) from which on the first step increases chi2, by bisection."""
    low, high = 10.0, 120.0
    for _ in range(9):
        middle = (low + high) / 2
        low, high = (low, middle) if first_step_ratio(gauss_newton, middle) > 1 else (middle, high)
    return (low + high) / 2


# --- a real building: the Intel Research Lab in Seattle ---


def real_building(file: Path | str = FILE) -> tuple[Graph, FloatArray]:
    """Return the graph of the Intel Research Lab, and its states (2829,) by odometry alone."""
    graph, stored, steps = intel_graph(file)
    return graph, chained(stored[:3], steps).ravel()


@course_style()
def draw_real_building(
    gauss_newton: GaussNewton, file: Path | str = FILE, steps: tuple[int, ...] = (0, 1, 3)
) -> Drawing:
    """Draw how the graph of a real building relaxes from its odometry."""
    graph, states = real_building(file)
    said = []
    figure = Figure(figsize=(12.0, 4.3))
    axes = figure.subplots(1, len(steps))
    for ax, step in zip(axes, steps, strict=True):
        found, chi2 = gauss_newton(graph, states.copy(), step)
        title = "odometry" if step == 0 else f"after {say_count(step, 'step')}"
        _plot_poses(graph, np.asarray(found), ax, "graph" if step else "odometry")
        ax.set_title(f"{title}\nχ² = {say_chi2(float(chi2[-1]))}", fontsize=11)
        said.append(f"{title} {say_chi2(float(chi2[-1]))}")
    same_limits(axes)
    legend_below(figure, [source_key("odometry"), source_key("graph", "poses by the graph"), _CLOSURES])
    return Drawing(
        figure,
        f"The graph of the Intel Research Lab, {graph.poses} poses, on its way from odometry; chi2: {', '.join(said)}.",
    )


def _plot_poses(graph: Graph, states: FloatArray, ax: Axes, source: str) -> None:
    poses = graph.split(states)[0]
    closing = graph.edges[:, 1] != graph.edges[:, 0] + 1
    ends = poses[graph.edges[closing]][:, :, :2]
    ax.add_collection(LineCollection(list(ends), colors=CLOSURE, linewidths=0.9, alpha=0.8))
    ax.plot(*poses[:, :2].T, "-", color=style_of(source).colour, lw=0.8, marker=".", ms=1.8)
    ax.set(xlabel="x (m)", ylabel="y (m)")
    ax.set_aspect("equal", adjustable="box")
    ax.autoscale_view()
