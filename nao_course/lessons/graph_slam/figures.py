"""Figures of lesson 08: the matrix that fills in, the valley of the squared error, and what a weight does."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.geometry import FloatArray
from nao_course.lessons.graph_slam.drives import (
    Constraint,
    LinearDrive,
    field_drive,
    odometry,
    odometry_first,
)
from nao_course.lessons.graph_slam.matrices import plot_matrix, sign_keys
from nao_course.lessons.graph_slam.systems import Builders, Function, map_error, solve_axes, variables_in
from nao_course.plotting import STYLES, Drawing, course_style, plot_field, plot_path
from nao_course.plotting.legends import legend_below, source_key
from nao_course.plotting.style import FOUND, GREY, style_of
from nao_course.sim import Field

_FIELD = Field(2012, half=True)


# --- the matrix and the map ---


@course_style()
def draw_snapshots(
    add_initial_position: Function,
    add_relative_motion: Function,
    add_relative_measurement: Function,
    solve: Function,
) -> Drawing:
    """Draw how the matrix fills in and the map snaps into place, by the student's functions.

    Returns
    -------
    Drawing
        Four moments of a drive: the matrix above, the map below.
    """
    drive = field_drive()
    builders = Builders(add_initial_position, add_relative_motion, add_relative_measurement)
    constraints = odometry_first(drive)
    moments = _moments(constraints)
    words = []
    figure = Figure(figsize=(12.0, 6.9))
    above, below = figure.subplots(2, len(moments), height_ratios=(1.0, 1.25))
    for top, bottom, (title, count) in zip(above, below, moments.items(), strict=True):
        used = constraints[:count]
        positions, omega = solve_axes(used, drive.size, builders, solve)
        plot_matrix(omega, top, len(drive.path))
        top.set_title(title, fontsize=11)
        plot_graph_map(drive, used, positions, bottom)
        said = f"{count} constraints, {say_error(map_error(drive, positions))}"
        bottom.set_title(said.replace("map off", "off"), fontsize=10)
        words.append(f"{title}: {said}")
    for ax in below[1:]:
        ax.set(ylabel="", yticklabels=[])
    legend_below(figure, [*sign_keys(), *map_keys()], columns=8)
    return Drawing(figure, f"The matrix Omega and the map at four moments of a drive. {'; '.join(words)}.")


def _moments(constraints: Sequence[Constraint]) -> dict[str, int]:
    """Return the titles of the snapshots and the numbers of constraints."""
    motions = sum(each.kind != "measurement" for each in constraints)
    tree = len(variables_in(constraints))  # the start, and one constraint for every other variable
    return {
        "motions only": motions,
        "each landmark once": tree,
        "ten more measurements": tree + 10,
        "all constraints": len(constraints),
    }


def say_error(error: float) -> str:
    """Say how far a map is off; NaN where it has no landmark."""
    return "no landmark" if np.isnan(error) else f"map off by {100 * error:.0f} cm"


def map_keys(by: str = "by the graph") -> list[Line2D]:
    """Return the legend keys of a map with graph, odometry and truth; `by` says where its estimate comes from."""
    truth, graph = STYLES["truth"], STYLES["graph"]
    return [
        Line2D([], [], color=truth.colour, lw=0.9, alpha=0.6, label="true path"),
        source_key("odometry"),
        source_key("graph", f"path {by}"),
        Line2D([], [], marker="P", color=graph.colour, ls="", ms=8, mec="white", label=f"landmark {by}"),
        Line2D([], [], marker="o", mfc="none", mec=truth.colour, ls="", ms=9, label="true landmark"),
    ]


def plot_graph_map(drive: LinearDrive, used: Sequence[Constraint], positions: FloatArray, ax: Axes) -> None:
    """Draw odometry and estimated positions, (N, 2), by some constraints of a drive, over the truth."""
    _plot_truth(drive, ax)
    _plot_graph(drive, used, positions, ax)


def _plot_truth(drive: LinearDrive, ax: Axes) -> None:
    truth = STYLES["truth"]
    plot_field(_FIELD, ax)
    ax.plot(*drive.landmarks.T, "o", mfc="none", mec=truth.colour, ms=9, zorder=5)
    ax.plot(*drive.path.T, color=truth.colour, lw=0.9, alpha=0.6, zorder=3)


def _plot_graph(drive: LinearDrive, used: Sequence[Constraint], positions: FloatArray, ax: Axes) -> None:
    graph = STYLES["graph"]
    poses, marks = positions[: len(drive.path)], positions[len(drive.path) :]
    measured = [(each.first, each.second) for each in used if each.kind == "measurement"]
    rays = np.full((len(measured), 3, 2), np.nan)  # pose, landmark, gap
    rays[:, :2] = positions[np.array(measured, dtype=int).reshape(-1, 2)]
    ax.plot(*rays.reshape(-1, 2).T, color=graph.colour, lw=0.6, alpha=0.5, zorder=3)
    plot_path(odometry(used), ax, "odometry", robot=False)
    plot_path(poses[np.isfinite(poses).all(axis=1)], ax, "graph", robot=False)
    ax.plot(*marks.T, "P", color=graph.colour, ms=8, mec="white", zorder=6)


class GraphMap:
    """The same map for a graph that grows; everything that never changes is drawn once, to save time."""

    @course_style()
    def __init__(self, drive: LinearDrive) -> None:
        """Draw the field, the truth and the legend."""
        self._drive = drive
        figure = Figure(figsize=(4.6, 4.9), dpi=110)
        canvas: Any = FigureCanvasAgg  # matplotlib gives its methods no types
        self._canvas = canvas(figure)
        self._ax = figure.add_subplot()
        _plot_truth(drive, self._ax)
        legend_below(figure, map_keys(), columns=2)
        self._canvas.draw()
        figure.set_layout_engine("none")
        self._ax.set_autoscale_on(False)
        self._still = self._canvas.copy_from_bbox(figure.bbox)
        self._lines = len(self._ax.lines)
        self.size = self._still_size()

    def _still_size(self) -> tuple[int, int]:
        """Return the width and the height of the picture in pixels."""
        height, width = np.shape(self._canvas.buffer_rgba())[:2]
        return int(width), int(height)

    def pixels(self, positions: FloatArray) -> FloatArray:
        """Return the pixels (u, v) of some positions (N, 2) in metres, (N, 2)."""
        across, up = self._ax.transData.transform(positions).T
        return np.column_stack([across, self.size[1] - up])

    @course_style()
    def draw(
        self, used: Sequence[Constraint], positions: FloatArray, chosen: Constraint | None = None
    ) -> npt.NDArray[np.uint8]:
        """Return the map of some constraints, with variables at `positions`, (N, 2), as an RGB picture.

        The constraint `chosen` is highlighted.
        """
        self._canvas.restore_region(self._still)
        _plot_graph(self._drive, used, positions, self._ax)
        if chosen:
            self._ax.plot(
                *positions[[chosen.first, chosen.second]].T, "o-", color=FOUND, ms=4, lw=2.5, zorder=7
            )
        moving = list(self._ax.lines)[self._lines :]
        for line in sorted(moving, key=lambda each: each.zorder):
            self._ax.draw_artist(line)
            line.remove()
        return np.array(self._canvas.buffer_rgba())[:, :, :3]


# --- the valley ---


@course_style()
def draw_valley(omega: npt.ArrayLike, xi: npt.ArrayLike, names: Sequence[str] = ("x1", "L")) -> Drawing:
    """Draw the sum of squares of a system of three variables over the second and the third, the first being 0.

    Parameters
    ----------
    omega : array_like, shape (3, 3)
        Information matrix.
    xi : array_like, shape (3,)
        Its right-hand side.
    names : (str, str)
        Of the second and third variable.

    Returns
    -------
    Drawing
        Contours, and for each of both rows of ``omega x = xi`` the line on which it holds.
    """
    matrix, right = np.asarray(omega, dtype=float)[1:, 1:], np.asarray(xi, dtype=float)[1:]
    best = np.linalg.lstsq(matrix, right, rcond=None)[0]
    across, along = (np.linspace(middle - 1.2, middle + 1.2, 241) for middle in best)
    grid = np.stack(np.meshgrid(across, along), axis=-1)
    away = grid - best
    cost = np.einsum("...i,ij,...j->...", away, matrix, away)
    figure = Figure(figsize=(6.8, 5.2))
    ax = figure.add_subplot()
    levels = np.linspace(0, 3, 13)
    greys = [str(0.98 - 0.03 * number) for number in range(len(levels))]
    ax.contourf(across, along, cost, levels=levels, colors=greys, extend="max")
    styles = (("odometry", 0), ("ekf", 1))
    for source, row in styles:
        rest = right[row] - grid @ matrix[row]
        ax.contour(across, along, rest, levels=[0], colors=[style_of(source).colour], linewidths=2)
    ax.plot(*best, "D", color=STYLES["graph"].colour, ms=10, mec="white", zorder=6)
    ax.set(xlabel=f"{names[0]} (steps)", ylabel=f"{names[1]} (steps)", aspect="equal")
    ax.grid(color="#e3e5e8")
    keys = [
        Line2D(
            [],
            [],
            color=style_of(source).colour,
            lw=2,
            label=f"row of {names[row]}: the derivative with respect to {names[row]} is 0",
        )
        for source, row in styles
    ]
    keys.append(
        Line2D([], [], color=STYLES["graph"].colour, marker="D", ls="", ms=9, label="both: the lowest point")
    )
    legend_below(figure, keys, columns=2)
    return Drawing(
        figure,
        f"The sum of squares over {names[0]} and {names[1]}. On one line the row of {names[0]} holds, on the other "
        f"the row of {names[1]}; they cross at the lowest point, ({best[0]:.2f}, {best[1]:.2f}) steps.",
    )


# --- weights ---


@course_style()
def draw_weights(answer: Callable[[float], Any], formula: Callable[[FloatArray], FloatArray]) -> Drawing:
    """Draw how a solution moves between the values of odometry and of the landmark.

    Parameters
    ----------
    answer : callable
        ``answer(epsilon_motion)`` returns x1 in steps, by the student's functions.
    formula : callable
        The formula for the same value, for an array.

    Returns
    -------
    Drawing
        A curve over the motion's variance.
    """
    epsilons = np.logspace(-2, 2, 81)
    tried = np.logspace(-2, 2, 13)
    found = np.array([float(answer(each)) for each in tried])
    figure = Figure(figsize=(7.6, 4.2))
    ax = figure.add_subplot()
    ax.axhline(5, color=STYLES["odometry"].colour, ls="--", lw=1.6, label="odometry alone: 5")
    ax.axhline(6, color=STYLES["truth"].colour, ls=":", lw=1.8, label="landmark alone: 6")
    ax.plot(epsilons, formula(epsilons), color=STYLES["ekf"].colour, lw=2, label="equation 8.4")
    style = STYLES["graph"]
    ax.plot(tried, found, style.marker, color=style.colour, ms=7, mec="white", label="your graph")
    ax.axvline(1, color=GREY, lw=0.8)
    ax.set(xscale="log", ylim=(4.9, 6.1), ylabel="pose x1 (steps)")
    ax.set_xlabel(r"$\varepsilon$ of the motion (steps$^2$); each measurement has 1")
    ax.legend(loc="center right")
    ax.grid(color="#e3e5e8")
    at = float(np.interp(0.0, np.log10(tried), found))
    return Drawing(
        figure,
        f"The pose between odometry's 5 and the landmark's 6 steps. With equal variances it is {at:.2f}; with a "
        f"motion's variance of 0.01 it is {found[0]:.2f}, of 100 {found[-1]:.2f}.",
    )
