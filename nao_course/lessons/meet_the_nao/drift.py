"""Odometry drift in lesson 00: measurements with many robots, and figures of paths and of drift over distance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from nao_course._internal.counts import say_count
from nao_course.geometry import FloatArray
from nao_course.plotting.drawing import Drawing, say_place
from nao_course.plotting.ellipses import ellipse_outlines, filled_outlines
from nao_course.plotting.legends import legend_below, source_key
from nao_course.plotting.maps import metric_axes
from nao_course.plotting.paths import PathLike, as_path, plot_path
from nao_course.plotting.style import STYLES, YELLOW, course_style
from nao_course.sim import OdometryNoise, repeat_drive
from nao_course.slam import Motion

if TYPE_CHECKING:
    from matplotlib.artist import Artist

_LINE_STYLES = (("#6f4aa0", "v"), ("#1f7a6b", "X"))  # colour and marker, different from all sources of poses
_ROBOTS = 2000  # enough for a median that is the same to a few per cent at every seed


def measure_drift(commands: Sequence[Motion], seed: int, noise: OdometryNoise | None = None) -> FloatArray:
    """Measure the distances between robots and the poses that their commands lead to.

    Parameters
    ----------
    commands : sequence of Motion
        M commands, the same for all robots.
    seed : int
        Seed of the robots' errors.
    noise : OdometryNoise, optional
        Standard deviations of the errors; the default is `OdometryNoise()`.

    Returns
    -------
    ndarray, shape (2000, M + 1)
        Distances in metres, for each robot at the start and after each command.
    """
    paths = repeat_drive(list(commands), _ROBOTS, np.random.default_rng(seed), noise)
    meant = commanded(commands)
    return np.asarray(np.hypot(*(paths - meant)[..., :2].transpose(2, 0, 1)), dtype=float)


def commanded(commands: Sequence[Motion]) -> FloatArray:
    """Return the poses that commands lead to without errors, at the start and after each, shape (M + 1, 3)."""
    return repeat_drive(list(commands), 1, np.random.default_rng(0), OdometryNoise(0, 0, 0, 0))[0]


@course_style()
def draw_growth(drives: Mapping[str, Sequence[Motion]], seed: int, title: str | None = None) -> Drawing:
    """Draw how drift grows with the distance, for one or two drives.

    Parameters
    ----------
    drives : mapping of str to sequence of Motion
        Commands of one or two drives, by the names in the legend.
    seed : int
        Seed of the robots' errors, the same for all drives.
    title : str, optional
        Title of the figure.

    Returns
    -------
    Drawing
        For each drive the median of 2000 robots, and a band with 90 % of them.
    """
    words = [f"{title or 'Drift over the distance'}."]
    figure = Figure(figsize=(7.2, 4.2))
    ax = figure.add_subplot()
    for (name, commands), (colour, marker) in zip(drives.items(), _LINE_STYLES, strict=False):
        way = np.concatenate([[0.0], np.cumsum([abs(each.distance) for each in commands])])
        median, most = np.quantile(measure_drift(commands, seed), [0.5, 0.9], axis=0)
        ax.plot(way, median, color=colour, marker=marker, lw=2, ms=5, label=name)
        ax.fill_between(way, 0, most, color=colour, alpha=0.13, lw=0)
        words.append(
            f"{name}: median {median[-1]:.2f} m after {way[-1]:.0f} m, 90 % of the robots below {most[-1]:.2f} m."
        )
    ax.set(xlabel="commanded distance (m)", ylabel="drift (m)", xlim=0, ylim=0)
    ax.grid(color="#e3e5e8")
    ax.legend(title="median, and band with 90 % of the robots", loc="upper left")
    ax.set_title(title or "")
    return Drawing(figure, " ".join(words))


@course_style()
def draw_drift(
    paths: npt.ArrayLike, *, commanded: PathLike | None = None, title: str | None = None
) -> Drawing:
    """Draw the paths of robots that got the same commands.

    Parameters
    ----------
    paths : array_like, shape (N, M + 1, 3)
        Poses of each robot, as returned by `nao_course.sim.repeat_drive`.
    commanded : Pose, sequence of Pose, or array_like of shape (M + 1, 2) or (M + 1, 3), optional
        Poses that the commands lead to without errors, from the same origin. This is each robot's odometry.
    title : str, optional
        Title of the figure.

    Returns
    -------
    Drawing
        The figure; its text gives the standard deviations of the last positions.

    Raises
    ------
    ValueError
        If `paths` has another shape.
    """
    array = np.asarray(paths, dtype=float)
    if array.ndim != 3 or array.shape[2] != 3 or not array.shape[0] or not array.shape[1]:
        raise ValueError(
            f"paths must have shape (robots, steps + 1, 3), with at least one robot; got {array.shape}"
        )
    robots, ends = len(array), array[:, -1, :2]
    planned = None if commanded is None else as_path(commanded, "commanded")
    truth = STYLES["truth"]
    keys: list[Artist] = [
        Line2D([], [], color=truth.colour, lw=0.9, marker="o", ms=5, label="true paths, ends")
    ]
    figure = Figure(figsize=(6.0, 6.4))
    ax = figure.add_subplot()
    metric_axes(ax, array[:, :, :2].reshape(-1, 2), margin=0.4)
    ax.grid(color="#e3e5e8")
    for path in array:
        ax.plot(*path[:, :2].T, color=truth.colour, lw=0.9, alpha=0.4, zorder=4)
    ax.plot(*ends.T, truth.marker, color=truth.colour, ms=5, mec="white", mew=0.7, zorder=5)
    if robots >= 3:
        outline = ellipse_outlines(ends.mean(axis=0), np.cov(ends.T)[None])
        ax.add_collection(filled_outlines(outline, truth.colour))
        keys.append(Patch(facecolor="#d4d4d4", edgecolor=truth.colour, label="95 % of the ends"))
    if planned is not None and len(planned):
        plot_path(planned, ax, "odometry")
        keys.append(source_key("odometry", "odometry of each robot"))
    ax.plot(0.0, 0.0, "*", color=YELLOW, mec="black", ms=13, zorder=7)
    keys.append(Line2D([], [], color=YELLOW, marker="*", mec="black", ms=12, ls="", label="start"))
    legend_below(figure, keys, columns=2)
    ax.set_title(title or "")
    words = _say_ends(ends, title or "Drift", array.shape[1] - 1)
    if planned is not None and len(planned):
        words += f" The odometry of each robot ends at {say_place(planned[-1])}."
    return Drawing(figure, words)


def _say_ends(ends: FloatArray, title: str, commands: int) -> str:
    """Describe the mean and the standard deviations of the robots' last positions in words."""
    robots = len(ends)
    spread = ends.std(axis=0, ddof=1) if robots > 1 else np.zeros(2)
    return (
        f"{title}: {say_count(robots, 'robot')}, the same {say_count(commands, 'command')} each. "
        f"They end around ({ends[:, 0].mean():.2f}, {ends[:, 1].mean():.2f}) m, with standard deviations "
        f"{spread[0]:.2f} m in x and {spread[1]:.2f} m in y."
    )
