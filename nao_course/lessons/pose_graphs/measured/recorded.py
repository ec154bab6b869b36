"""The figure of a recorded benchmark for lesson 09: EKF and graph."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator

from nao_course.metrics import band
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.legends import legend_below, source_key

EKF_AND_GRAPH = Path(__file__).with_name("ekf_and_graph.json")


@course_style()
def draw_ekf_and_graph(recorded: Mapping[str, Any] | None = None) -> Drawing:
    """Draw error, NEES and time of both methods by the length of the drive.

    Parameters
    ----------
    recorded : mapping, optional
        Result of ``python -m benchmarks ekf_and_graph``; by default the course's own record.

    Returns
    -------
    Drawing
        Three plots.
    """
    recorded = recorded or json.loads(EKF_AND_GRAPH.read_text(encoding="utf-8"))
    steps, runs = recorded["steps"], recorded["runs"]
    words = []
    figure = Figure(figsize=(12.0, 4.2))
    error, nees, seconds = figure.subplots(1, 3)
    for name, rows in recorded["methods"].items():
        style = STYLES[name]
        options: dict[str, Any] = {"color": style.colour, "marker": style.marker, "lw": 2, "ms": 6}
        error.plot(steps, rows["path"], **options)
        nees.plot(steps, rows["nees"], **options)
        taken = np.add(rows["seconds"], recorded["methods"]["ekf"]["seconds"] if name == "graph" else 0.0)
        seconds.plot(steps, taken, **options)
        words.append(
            f"{style.label} after {steps[-1]} steps: {rows['path'][-1]:.1f} m, NEES {rows['nees'][-1]:.1f}, "
            f"{taken[-1]:.2g} s{', the EKF that it begins with included' if name == 'graph' else ''}"
        )
    _plot_band(nees, runs)
    every = recorded["graph_at_every_stop"]
    seconds.plot(
        steps, every, color=STYLES["graph"].colour, lw=1.3, ls=":", marker=STYLES["graph"].marker, mfc="white"
    )
    beside: dict[str, Any] = {"ha": "right", "textcoords": "offset points", "fontsize": 9}
    once = seconds.lines[1].get_ydata()[-1]
    seconds.annotate("once, after\nthe EKF", (steps[-1], once), xytext=(-4, 10), **beside)
    seconds.annotate("anew at\nevery stop", (steps[2], every[2]), xytext=(0, 8), **beside)
    error.set(ylabel="error of the whole path (m)")
    nees.set(ylabel="NEES of the last pose, mean")
    seconds.set(ylabel="seconds for the drive")
    for ax in (error, nees, seconds):
        _scale_by_steps(ax, steps, (1.0, 2.0, 5.0) if ax is not seconds else (1.0,))
    legend_below(figure, [source_key(name) for name in recorded["methods"]])
    return Drawing(figure, f"EKF and graph on the same {runs} drives of each length. {'; '.join(words)}.")


def _scale_by_steps(ax: Axes, steps: Sequence[int], ticks: tuple[float, ...]) -> None:
    """Scale both axes logarithmically, with a tick for each length of the drive."""
    ax.set(xscale="log", yscale="log", xlabel="steps of a metre")
    ax.set_xticks(steps, [str(count) for count in steps], minor=False)
    ax.minorticks_off()
    ax.yaxis.set_major_locator(LogLocator(subs=ticks))
    ax.yaxis.set_major_formatter("{x:g}")
    ax.grid(color="#e3e5e8")


def _plot_band(ax: Axes, runs: int) -> None:
    """Draw the 95 % band of the mean NEES of a consistent estimate."""
    low, high = band(3, runs)
    ax.axhspan(low, high, color="#e3e5e8", lw=0)
    ax.annotate(
        "consistent: 95 %", (1, low), xycoords=("axes fraction", "data"), ha="right", va="bottom", fontsize=9
    )
