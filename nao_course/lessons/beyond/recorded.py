"""What lesson 12 measured over many drives, rooms and looks, as the benchmarks ``beyond_...`` recorded it."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nao_course.plotting import STYLES, Drawing, Table, course_style, table
from nao_course.plotting.legends import legend_below

FOLDER = Path(__file__).parent
CAMERAS, EXPLORING, PARTICLES, MOVES = (
    FOLDER / f"{name}.json" for name in ("two_cameras", "exploring", "particles", "planning")
)
AFTER = (30, 60, 150)  # moves of a drive with particles
ROOMS_AFTER = (10, 30, 60)  # moves in a room
MOST_NEES = 1000.0  # that a figure shows
_GRID = "#e3e5e8"
_NEUTRAL = "#6b7280"  # plans that are nobody's estimate
# What is compared: the course's blue is what the student wrote, orange what goes without it.
_WAYS = {
    "nearest frontier": (STYLES["ekf"].colour, "-", "o"),
    "at random": (STYLES["odometry"].colour, "--", "s"),
    "lawn-mower": (_NEUTRAL, ":", "v"),
}
_MOVES = {
    "what tells most": (STYLES["ekf"].colour, "-", "o"),
    "in a circle": (_NEUTRAL, ":", "v"),
    "along the edge": (_NEUTRAL, "-.", "D"),
    "at random": (STYLES["odometry"].colour, "--", "s"),
}
_FAST_SLAM = STYLES["graph"].colour  # here no graph is near
_SHADES = {320: (0.4, "v"), 640: (0.7, "^"), 1280: (1.0, "D")}


def read(path: Path) -> Any:
    """What a benchmark wrote."""
    return json.loads(path.read_text(encoding="utf-8"))


# --- particles ---


def draw_fast_slam() -> Drawing:
    """Draw error, honesty and ancestors over the moves: lesson 07's filter, and FastSLAM by its number of particles."""
    recorded = read(PARTICLES)
    rows, (low, high) = recorded["rows"], recorded["band"]
    with course_style():
        figure = Figure(figsize=(9.9, 4.2))
        error, nees, ancestors = figure.subplots(1, 3)
        for row in rows:
            line = _row_line(row, [each["particles"] for each in rows if each["particles"]])
            error.plot(100 * np.array(row["error"]), **line)
            nees.plot(np.minimum(row["nees"], 2 * MOST_NEES), **line)
            if row["ancestors"] is not None:
                ancestors.plot(row["ancestors"], **line)
        nees.axhspan(low, high, color=STYLES["truth"].colour, alpha=0.12, lw=0)
        nees.annotate("honest", (150, low), (0, -11), textcoords="offset points", ha="right", fontsize=9)
        error.set(ylabel="position error, median (cm)", ylim=(0, None))
        nees.set(ylabel="NEES, median", yscale="log", ylim=(1, 100))
        ancestors.set(ylabel="ancestors left, median", yscale="log", ylim=(0.8, 1200))
        for ax in (error, nees, ancestors):
            ax.set(xlabel="move", xlim=(0, 150))
            ax.grid(color=_GRID)
        legend_below(figure, error.get_legend_handles_labels()[0], columns=5)
    said = "; ".join(
        f"{row['name']} is {100 * row['error'][-1]:.0f} cm off with a NEES of {_short(row['nees'][-1])}"
        for row in rows
    )
    return Drawing(
        figure,
        f"Error, NEES and ancestors left over {len(rows[0]['error']) - 1} moves of {recorded['drives']} drives. "
        f"At the end {said}. The median of an honest NEES lies between {low:.1f} and {high:.1f}.",
    )


def _row_line(row: dict[str, Any], counts: Sequence[int]) -> dict[str, Any]:
    """How the line of a way to estimate looks."""
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


def fast_slam_table() -> Table:
    """Errors and honesty of FastSLAM by its number of particles, beside lesson 07's filter, over the same drives."""
    recorded = read(PARTICLES)
    rows = [
        (
            row["name"],
            *(f"{100 * row['error'][move]:.1f}" for move in AFTER),
            *(_short(row["nees"][move]) for move in AFTER),
            "" if row["ancestors"] is None else f"{row['ancestors'][AFTER[0]]:.0f}",
            f"{row['ms']:.1f}",
        )
        for row in recorded["rows"]
    ]
    low, high = recorded["band"]
    moves = [str(move) for move in AFTER]
    return table(
        (
            f"{recorded['drives']} drives",
            *(f"off, {move} moves (cm)" for move in moves),
            *(f"NEES, {move} moves" for move in moves),
            f"ancestors, {moves[0]} moves",
            "ms a move",
        ),
        [*rows, (f"honest: {low:.1f} to {high:.1f}", "", "", "", "", "", "", "", "")],
    )


# --- two cameras ---


def draw_two_cameras() -> Drawing:
    """Draw by how much a distance scatters over the distance, and where the head must look for both to see it."""
    recorded, said = read(CAMERAS), []
    rows = recorded["rows"]
    with course_style():
        figure = Figure(figsize=(9.9, 4.6))
        ax, head = figure.subplots(1, 2, width_ratios=(1.35, 1))
        one = [row for row in rows if row["width"] == min(_SHADES)]
        orange = STYLES["odometry"].colour
        _measured_and_formula(ax, one, "one", {"color": orange, "marker": "s"}, "one camera, any resolution")
        for width, (shade, marker) in _SHADES.items():
            of = [row for row in rows if row["width"] == width]
            look = {"color": STYLES["ekf"].colour, "alpha": shade, "marker": marker}
            _measured_and_formula(ax, of, "both", look, f"both, {width} px across")
            at_two = next(row for row in of if row["distance"] == 2)
            said.append(f"{width} px across {at_two['one']:.2f} m by one and {at_two['both']:.2f} m by both")
        ax.plot([], [], color=STYLES["truth"].colour, lw=1.2, label="lines: the formulas")
        ax.set(xscale="log", yscale="log", xlabel="distance (m)", ylabel="standard deviation (m)")
        ax.set_yticks([0.01, 0.03, 0.1, 0.3, 1.0], ["0.01", "0.03", "0.1", "0.3", "1"])
        ax.set_xticks(one_to_five := [1, 2, 3, 4, 5], [str(each) for each in one_to_five])
        ax.minorticks_off()
        ax.grid(color=_GRID)
        for each, line in zip(recorded["heads"], ("-", "--", ":"), strict=True):
            head.plot(
                each["pitches"], 100 * np.array(each["seen"]), ls=line, color=STYLES["ekf"].colour, lw=2
            )
            middle = each["pitches"][len(each["pitches"]) // 2]
            head.annotate(f"{each['distance']:g} m", (middle, 103), ha="center", fontsize=9)
        head.set(
            xlabel="head pitch (°), positive looks down",
            ylabel="both cameras see it (% of looks)",
            ylim=(0, 112),
        )
        head.grid(color=_GRID)
        legend_below(figure, ax.get_legend_handles_labels()[0], columns=3)
    return Drawing(
        figure,
        f"Scatter of a measured distance, the body leaning by {recorded['lean']} degrees. At 2 m, {'; '.join(said)}. "
        "Right: for each distance both cameras see the point within some seven degrees of the head's pitch only.",
    )


def _measured_and_formula(
    ax: Axes, rows: list[dict[str, float]], key: str, look: dict[str, Any], label: str
) -> None:
    """Markers where it was measured, a line by the formula."""
    distances = [row["distance"] for row in rows]
    ax.plot(distances, [row[key] for row in rows], ls="", ms=8, mec="white", label=label, zorder=3, **look)
    line = {name: value for name, value in look.items() if name != "marker"}
    ax.plot(distances, [row[f"{key}_formula"] for row in rows], lw=1.2, **line)


def cameras_table() -> Table:
    """Standard deviations of a distance by one camera and by both: measured, and by the formulas."""
    shown = [row for row in read(CAMERAS)["rows"] if row["distance"] in (1, 2, 5)]
    keys = ("one", "one_formula", "both", "both_formula")
    rows = [
        (f"{row['width']:g}", f"{row['distance']:g}", *(f"{row[key]:.3f}" for key in keys)) for row in shown
    ]
    columns = ("px across", "distance (m)", "one camera (m)", "formula (m)", "both (m)", "formula (m)")
    return table(columns, rows)


# --- exploring ---


def draw_coverage() -> Drawing:
    """Draw which part of a room is known after each move, for three ways to go on."""
    recorded, said = read(EXPLORING), []
    with course_style():
        figure = Figure(figsize=(8.4, 4.4))
        ax = figure.add_subplot()
        for name, (colour, line, marker) in _WAYS.items():
            low, middle, high = 100 * np.array(recorded["ways"][name]["quartiles"])
            ax.fill_between(range(len(middle)), low, high, color=colour, alpha=0.15, lw=0)
            ax.plot(
                middle,
                color=colour,
                ls=line,
                lw=2,
                marker=marker,
                markevery=10,
                ms=7,
                mec="white",
                label=name,
            )
            said.append(f"{name} {middle[30]:.0f} % after 30 moves and {middle[60]:.0f} % after 60")
        ax.axhline(100 * recorded["enough"], color=STYLES["truth"].colour, lw=0.8, zorder=1)
        ax.set(
            xlabel="move", ylabel="known of what can be seen (%)", xlim=(0, len(middle) - 1), ylim=(30, 102)
        )
        ax.grid(color=_GRID)
        legend_below(figure, ax.get_legend_handles_labels()[0])
    return Drawing(figure, f"Median and quartiles of {recorded['rooms']} rooms, known: {'; '.join(said)}.")


def coverage_table() -> Table:
    """Part of the rooms that is known after so many moves, and the moves until nine tenths are."""
    recorded = read(EXPLORING)
    rows = [
        (name, *(_percent(of["quartiles"], move) for move in ROOMS_AFTER), _moves(of, recorded["moves"]))
        for name, of in recorded["ways"].items()
    ]
    head = (f"{recorded['rooms']} rooms", *(f"known after {move} moves" for move in ROOMS_AFTER))
    return table((*head, f"moves to {recorded['enough']:.0%}"), rows)


def known_after(way: str, moves: int) -> float:
    """Percent of a room, median, known after so many moves by "nearest frontier", "at random" or "lawn-mower"."""
    return round(100 * float(read(EXPLORING)["ways"][way]["quartiles"][1][moves]), 1)


def _percent(quartiles: list[list[float]], move: int) -> str:
    low, middle, high = (100 * each[move] for each in quartiles)
    return f"{middle:.0f} % ({low:.0f} to {high:.0f})"


def _moves(of: dict[str, Any], most: int) -> str:
    """Median; a room that never was known well enough counts as the most."""
    median = np.median([most if each is None else each for each in of["enough"]])
    return f"{median:.0f}" if median < most else f"more than {most - 1}"


# --- moves ---


def draw_moves() -> Drawing:
    """Draw how surely a robot knows its place after each move, and how far it is off at the end, for four ways."""
    recorded, said = read(MOVES), []
    with course_style():
        figure = Figure(figsize=(9.9, 4.4))
        ax, ends = figure.subplots(1, 2, width_ratios=(1.2, 1))
        for place, (name, (colour, line, marker)) in enumerate(_MOVES.items()):
            of = recorded["ways"][name]
            low, middle, high = 100 * np.array(of["doubts"]).T
            ax.fill_between(range(len(middle)), low, high, color=colour, alpha=0.12, lw=0)
            ax.plot(
                middle, color=colour, ls=line, lw=2, marker=marker, markevery=4, ms=7, mec="white", label=name
            )
            off = 100 * np.sort(of["off"])
            across = (
                place + 0.25 * np.linspace(-1, 1, len(off))[np.argsort(np.arange(len(off)) * 7 % len(off))]
            )
            ends.plot(across, off, marker, color=colour, ms=5, alpha=0.55, mec="none")
            ends.hlines(np.median(off), place - 0.35, place + 0.35, color=STYLES["truth"].colour, lw=2.5)
            said.append(f"{name} {middle[-1]:.0f} cm stated and {np.median(off):.0f} cm off")
        ax.set(
            xlabel="move", ylabel="stated standard deviation (cm)", ylim=(0, None), xlim=(0, len(middle) - 1)
        )
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
        "Left, median and quartiles over the moves; right, each drive's end, with the median as a bar.",
    )


def moves_table() -> Table:
    """What is believed and true at the ends of the drives, by the way to choose the moves."""
    recorded = read(MOVES)
    low, high = recorded["band"]
    rows = [
        (
            name,
            *(f"{100 * np.median(of[key]):.1f}" for key in ("doubt", "off", "map")),
            f"{np.mean(of['nees']):.1f}",
        )
        for name, of in recorded["ways"].items()
    ]
    columns = ("stated (cm)", "off (cm)", "map off (cm)", f"NEES (honest: {low:.1f} to {high:.1f})")
    return table((f"{recorded['drives']} drives", *columns), rows)
