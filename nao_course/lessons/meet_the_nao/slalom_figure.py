"""Figure of the slalom in lesson 00: the paths of the robots, and how many robots passed each gate."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.challenges import EntryReport, Run
from nao_course.geometry import FloatArray
from nao_course.lessons.meet_the_nao.slalom import GATES
from nao_course.plotting.drawing import Drawing
from nao_course.plotting.halo import HALO
from nao_course.plotting.legends import legend_below, source_key
from nao_course.plotting.maps import plot_field
from nao_course.plotting.paths import plot_path
from nao_course.plotting.style import STYLES, YELLOW, course_style
from nao_course.sim import Field

POLE = "#b3261e"


@course_style()
def draw_slalom(run: Run) -> Drawing:
    """Draw the robots' true paths through the gates, and the number of robots that passed each gate."""
    kept = [each.kept for each in run.results if each.kept]
    through = np.array([each[2] for each in kept]).reshape(-1, len(GATES))
    figure = Figure(figsize=(9.2, 7.0))
    side: Axes
    ax, side = figure.subplots(1, 2, width_ratios=[3.2, 1.0])
    plot_field(Field(2012, half=True), ax)
    for path, _, _ in kept:
        ax.plot(*path[:, :2].T, color=STYLES["truth"].colour, lw=0.9, alpha=0.35, zorder=4)
        ax.plot(*path[-1, :2], "o", color=STYLES["truth"].colour, ms=4, mec="white", mew=0.5, zorder=5)
    if kept:
        plot_path(kept[0][1], ax, "odometry")
    _plot_gates(ax)
    ax.plot(0, 0, "*", color=YELLOW, mec="black", ms=13, zorder=7)
    ax.set_title(f"{run.score:.2f} of {len(GATES)} gates, mean of {len(run.results)} robots")
    _plot_counts(side, through, len(run.results))
    legend_below(figure, _keys(), columns=4)
    counts = ", ".join(f"gate {number}: {count}" for number, count in enumerate(through.sum(axis=0), start=1))
    robots = len(run.results)
    words = f"{robots} robots drive one plan and pass {run.score:.2f} of {len(GATES)} gates on average."
    return Drawing(figure, f"{words} Robots that passed: {counts}.")


def _plot_gates(ax: Axes) -> None:
    """Draw the poles of each gate and its number."""
    for number, gate in enumerate(GATES, start=1):
        poles: FloatArray = gate.poles
        ax.plot(*poles.T, color=POLE, lw=1.2, ls=":", zorder=5)
        ax.plot(*poles.T, "o", color=POLE, ms=7, mec="white", mew=1.0, zorder=6)
        beyond = poles[1] + 0.16 * (poles[1] - poles[0]) / np.linalg.norm(poles[1] - poles[0])
        x, y = beyond.tolist()
        ax.text(
            x,
            y,
            str(number),
            ha="center",
            va="center",
            weight="bold",
            color=POLE,
            zorder=7,
            path_effects=HALO,
        )


def _plot_counts(ax: Axes, through: FloatArray, robots: int) -> None:
    """Draw a bar for each gate: the number of robots that passed it."""
    numbers = np.arange(1, len(GATES) + 1)
    counts = through.sum(axis=0) if len(through) else np.zeros(len(GATES))
    ax.barh(numbers, counts, color=STYLES["truth"].colour, height=0.6)
    for number, count in enumerate(counts.tolist(), start=1):
        ax.text(count + 0.3, number, f"{count:.0f}", va="center", fontsize=9)
    ax.set(xlim=(0, robots * 1.15), ylim=(len(GATES) + 0.6, 0.4), yticks=numbers)
    ax.set(xlabel="robots that passed", ylabel="gate", xticks=[0, robots // 2, robots])


def _keys() -> list[Line2D]:
    truth = STYLES["truth"]
    return [
        Line2D([], [], color=truth.colour, lw=0.9, marker="o", ms=4, label="true paths, ends"),
        source_key("odometry", "the plan, without errors"),
        Line2D([], [], color=POLE, marker="o", ls=":", lw=1.2, label="gate"),
        Line2D([], [], color=YELLOW, marker="*", mec="black", ms=12, ls="", label="start"),
    ]


def robots_through(gate: int, report: EntryReport) -> int:
    """Count the robots that passed a gate.

    Parameters
    ----------
    gate : int
        Number of the gate, from 1.
    report : EntryReport
        Report of `challenge("00").enter(...)`. Robots without a usable plan passed no gate.

    Returns
    -------
    int
        Number of robots.
    """
    return sum(bool(each.kept[2][gate - 1]) for each in report.run.results if each.kept)
