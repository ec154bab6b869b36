"""Results of the benchmarks ``beyond_...`` of lesson 12, over many drives, rooms and measurements."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.legends import legend_below

FOLDER = Path(__file__).parent
CAMERAS, EXPLORING, PARTICLES, MOVES = (
    FOLDER / f"{name}.json" for name in ("two_cameras", "exploring", "particles", "planning")
)
AFTER = (30, 60, 150)  # moves of a drive with particles
MOST_NEES = 1000.0  # upper limit in a figure
_GRID = "#e3e5e8"
_NEUTRAL = "#6b7280"  # fixed plans
# Blue is the student's function, orange a random choice.
_STRATEGIES = {
    "nearest frontier": (STYLES["ekf"].colour, "-", "o"),
    "at random": (STYLES["odometry"].colour, "--", "s"),
    "lanes": (_NEUTRAL, ":", "v"),
}
_LABELS = {"at random": "random places"}
_MOVES = {
    "smallest variance": (STYLES["ekf"].colour, "-", "o"),
    "in a circle": (_NEUTRAL, ":", "v"),
    "along the edge": (_NEUTRAL, "-.", "D"),
    "at random": (STYLES["odometry"].colour, "--", "s"),
}
_FAST_SLAM = STYLES["graph"].colour  # the figure contains no graph
_SHADES = {320: (0.4, "v"), 640: (0.7, "^"), 1280: (1.0, "D")}


def read(path: Path) -> Any:
    """Read the results of a benchmark."""
    return json.loads(path.read_text(encoding="utf-8"))


# --- particles ---


@course_style()
def draw_fast_slam() -> Drawing:
    """Draw error, NEES and initial particles with descendants over the moves, for lesson 07's filter and FastSLAM."""
    recorded = read(PARTICLES)
    rows, (low, high) = recorded["rows"], recorded["band"]
    figure = Figure(figsize=(9.9, 4.2))
    error, nees, ancestors = figure.subplots(1, 3)
    for row in rows:
        line = _row_line(row, [each["particles"] for each in rows if each["particles"]])
        error.plot(100 * np.array(row["error"]), **line)
        nees.plot(np.minimum(row["nees"], 2 * MOST_NEES), **line)
        if row["ancestors"] is not None:
            ancestors.plot(row["ancestors"], **line)
    nees.axhspan(low, high, color=STYLES["truth"].colour, alpha=0.12, lw=0)
    nees.annotate("consistent", (150, low), (0, -11), textcoords="offset points", ha="right", fontsize=9)
    error.set(ylabel="position error, median (cm)", ylim=(0, None))
    nees.set(ylabel="NEES, median", yscale="log", ylim=(1, 100))
    ancestors.set(ylabel="initial particles with descendants, median", yscale="log", ylim=(0.8, 1200))
    for ax in (error, nees, ancestors):
        ax.set(xlabel="move", xlim=(0, 150))
        ax.grid(color=_GRID)
    legend_below(figure, error.get_legend_handles_labels()[0], columns=5)
    said = "; ".join(
        f"{row['name']} has an error of {100 * row['error'][-1]:.0f} cm and a NEES of {_short(row['nees'][-1])}"
        for row in rows
    )
    return Drawing(
        figure,
        f"Error, NEES and initial particles with descendants over {len(rows[0]['error']) - 1} moves "
        f"of {recorded['drives']} drives. "
        f"At the end {said}. The median NEES of a consistent filter lies between {low:.1f} and {high:.1f}.",
    )


def _row_line(row: dict[str, Any], counts: Sequence[int]) -> dict[str, Any]:
    """Return the line style of an algorithm."""
    if row["particles"] is None:
        return {"color": STYLES["ekf"].colour, "lw": 2.2, "label": row["name"]}
    place = counts.index(row["particles"]) / max(len(counts) - 1, 1)
    return {
        "color": _FAST_SLAM,
        "alpha": 0.35 + 0.65 * place,
        "lw": 1.0 + 1.2 * place,
        "ls": ("--", "-.", (0, (8, 1.5)), "-")[counts.index(row["particles"]) % 4],
        "label": f"{row['particles']} particles",
    }


def _short(nees: float) -> str:
    return f"{nees:.1f}" if nees < MOST_NEES else f"more than {MOST_NEES:.0f}"


# --- two cameras ---


@course_style()
def draw_two_cameras() -> Drawing:
    """Draw the error of a distance against the distance, and the head pitches at which both cameras see the point."""
    recorded, said = read(CAMERAS), []
    rows = recorded["rows"]
    figure = Figure(figsize=(9.9, 4.6))
    ax, head = figure.subplots(1, 2, width_ratios=(1.35, 1))
    one = [row for row in rows if row["width"] == min(_SHADES)]
    orange = STYLES["odometry"].colour
    _measured_and_formula(ax, one, "one", {"color": orange, "marker": "s"}, "one camera, any resolution")
    for width, (shade, marker) in _SHADES.items():
        of = [row for row in rows if row["width"] == width]
        style = {"color": STYLES["ekf"].colour, "alpha": shade, "marker": marker}
        _measured_and_formula(ax, of, "both", style, f"both, {width} px across")
        at_two = next(row for row in of if row["distance"] == 2)
        said.append(f"{width} px across {at_two['one']:.2f} m by one and {at_two['both']:.2f} m by both")
    ax.plot([], [], color=STYLES["truth"].colour, lw=1.2, label="lines: the formulas")
    ax.set(xscale="log", yscale="log", xlabel="distance (m)", ylabel="standard deviation (m)")
    ax.set_yticks([0.01, 0.03, 0.1, 0.3, 1.0], ["0.01", "0.03", "0.1", "0.3", "1"])
    ax.set_xticks(one_to_five := [1, 2, 3, 4, 5], [str(each) for each in one_to_five])
    ax.minorticks_off()
    ax.grid(color=_GRID)
    for each, line in zip(recorded["heads"], ("-", "--", ":"), strict=True):
        head.plot(each["pitches"], 100 * np.array(each["seen"]), ls=line, color=STYLES["ekf"].colour, lw=2)
        middle = each["pitches"][len(each["pitches"]) // 2]
        head.annotate(f"{each['distance']:g} m", (middle, 103), ha="center", fontsize=9)
    head.set(xlabel="head pitch (°), positive looks down", ylabel="both cameras see it (%)", ylim=(0, 112))
    head.grid(color=_GRID)
    legend_below(figure, ax.get_legend_handles_labels()[0], columns=3)
    return Drawing(
        figure,
        f"Standard deviation of a measured distance, with a body tilt of {recorded['tilt']} degrees. "
        f"At 2 m, {'; '.join(said)}. Right: at each distance both cameras see the point only within about "
        "seven degrees of head pitch.",
    )


def _measured_and_formula(
    ax: Axes, rows: list[dict[str, float]], key: str, style: dict[str, Any], label: str
) -> None:
    """Plot markers for the measurements and a line for the formula."""
    distances = [row["distance"] for row in rows]
    ax.plot(
        distances,
        [row[key] for row in rows],
        ls="",
        ms=8,
        mec="white",
        label=label,
        zorder=3 + (key == "both"),
        **style,
    )
    line = {name: value for name, value in style.items() if name != "marker"}
    ax.plot(distances, [row[f"{key}_formula"] for row in rows], lw=1.2, **line)


# --- exploring ---


@course_style()
def draw_coverage() -> Drawing:
    """Draw the known part of a room after each move, for three strategies."""
    recorded, said = read(EXPLORING), []
    figure = Figure(figsize=(8.4, 4.4))
    ax = figure.add_subplot()
    for name, (colour, line, marker) in _STRATEGIES.items():
        low, middle, high = 100 * np.array(recorded["variants"][name]["quartiles"])
        ax.fill_between(range(len(middle)), low, high, color=colour, alpha=0.15, lw=0)
        label = _LABELS.get(name, name)
        ax.plot(
            middle, color=colour, ls=line, lw=2, marker=marker, markevery=10, ms=7, mec="white", label=label
        )
        said.append(f"{label} {middle[30]:.0f} % after 30 moves and {middle[60]:.0f} % after 60")
    ax.axhline(100 * recorded["enough"], color=STYLES["truth"].colour, lw=0.8, zorder=1)
    ax.set(
        xlabel="move", ylabel="known part of the visible area (%)", xlim=(0, len(middle) - 1), ylim=(30, 102)
    )
    ax.grid(color=_GRID)
    legend_below(figure, ax.get_legend_handles_labels()[0])
    return Drawing(
        figure, f"Known part of {recorded['rooms']} rooms, median and quartiles: {'; '.join(said)}."
    )


# --- moves ---


@course_style()
def draw_moves() -> Drawing:
    """Draw the standard deviation after each move and the errors at the end, for four ways to choose moves."""
    recorded, said = read(MOVES), []
    figure = Figure(figsize=(9.9, 4.4))
    ax, ends = figure.subplots(1, 2, width_ratios=(1.2, 1))
    for place, (name, (colour, line, marker)) in enumerate(_MOVES.items()):
        of = recorded["variants"][name]
        low, middle, high = 100 * np.array(of["sigmas"]).T
        ax.fill_between(range(len(middle)), low, high, color=colour, alpha=0.12, lw=0)
        ax.plot(
            middle, color=colour, ls=line, lw=2, marker=marker, markevery=4, ms=7, mec="white", label=name
        )
        error = 100 * np.sort(of["error"])
        across = (
            place + 0.25 * np.linspace(-1, 1, len(error))[np.argsort(np.arange(len(error)) * 7 % len(error))]
        )
        ends.plot(across, error, marker, color=colour, ms=5, alpha=0.55, mec="none")
        ends.hlines(np.median(error), place - 0.35, place + 0.35, color=STYLES["truth"].colour, lw=2.5)
        said.append(f"{name} {middle[-1]:.0f} cm stated and {np.median(error):.0f} cm true error")
    ax.set(xlabel="move", ylabel="standard deviation (cm)", ylim=(0, None), xlim=(0, len(middle) - 1))
    ax.set_xticks(range(0, len(middle), 5))
    ends.set(ylabel="true error after the last move (cm)", yscale="log")
    ends.set_yticks([1, 3, 10, 30, 100], ["1", "3", "10", "30", "100"])
    ends.set_xticks(range(len(_MOVES)), [name.replace(" ", "\n", 1) for name in _MOVES], fontsize=9.5)
    for each in (ax, ends):
        each.grid(color=_GRID, axis="y")
    legend_below(figure, ax.get_legend_handles_labels()[0])
    return Drawing(
        figure,
        f"{recorded['drives']} drives of {len(middle) - 1} moves. Medians at the end: {'; '.join(said)}. "
        "Left, median and quartiles over the moves; right, the errors at the end, with the median as a bar.",
    )
