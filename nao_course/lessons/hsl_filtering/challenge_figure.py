"""Figure of the challenge of lesson 01: lost points of each scene, and wrong pixels of the worst scene."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from nao_course.challenges import CaseResult, EntryReport, Run
from nao_course.lessons.hsl_filtering.scores import ERROR_COLOURS, error_classes
from nao_course.plotting.drawing import Drawing
from nao_course.plotting.legends import legend_below
from nao_course.plotting.pictures import painted, plot_picture
from nao_course.plotting.style import STYLES, YELLOW, course_style
from nao_course.sim import LABELS

SCORED, WHITE_LOST = STYLES["ekf"].colour, "#c9ced6"


@course_style()
def draw_lost_points(run: Run) -> Drawing:
    """Draw the score of each scene, the points lost to white and yellow, and the wrong pixels of the worst scene."""
    shown = min((each for each in run.results if each.kept), key=lambda each: each.score, default=None)
    figure = Figure(figsize=(9.9, 6.6 if shown else 3.6))
    grid = figure.add_gridspec(2 if shown else 1, 3, height_ratios=[1.0, 1.15] if shown else None)
    _plot_scenes(run, figure.add_subplot(grid[0, :]))
    if shown:
        _plot_worst(shown, [figure.add_subplot(grid[1, column]) for column in range(3)])
    legend_below(figure, _keys(run, with_pixels=shown is not None), columns=3)
    return Drawing(figure, _words(run), photo=True)


def harder_rooms(report: EntryReport) -> str:
    """Return the rooms in which an entry loses more, "dark" or "harsh".

    Parameters
    ----------
    report : EntryReport
        From ``challenge("01").enter(...)``.

    Raises
    ------
    NotImplementedError
        If the entry was not run on all scenes, for example because it calls a blank exercise.
    """
    if not report.run.complete:
        raise NotImplementedError("the entry has no score")
    return min(("dark", "harsh"), key=lambda room: _mean_score(report.run, room))


def _mean_score(run: Run, room: str) -> float:
    return float(np.mean([each.score for each in run.results if each.name.startswith(room)]))


def _plot_scenes(run: Run, ax: Axes) -> None:
    """Draw a bar for each scene with the score and the points lost, and the reference's score as a line."""
    x = np.arange(len(run.results))
    score = np.array([each.score for each in run.results])
    lost = {
        name: np.array([(1 - each.columns.get(name, 0.0)) / 2 for each in run.results])
        for name in ("white", "yellow")
    }
    ax.bar(x, score, color=SCORED, width=0.8)
    ax.bar(x, lost["white"], bottom=score, color=WHITE_LOST, width=0.8)
    ax.bar(x, lost["yellow"], bottom=score + lost["white"], color=YELLOW, width=0.8)
    for row in run.challenge.rows:
        if row.name == "the reference" and len(row.cases) == len(x):
            ax.hlines(row.cases, x - 0.4, x + 0.4, color="black", lw=2)
    ax.set(xlim=(-0.6, len(x) - 0.4), ylim=(0, 1), ylabel="score of the scene", xticks=x)
    ax.set_xticklabels([each.name.split()[-1] for each in run.results], fontsize=8)
    ax.set_title(f"Where points are lost: {run.score:.2f} of 1", pad=18)
    rooms = [each.name.split()[0] for each in run.results]
    for name in dict.fromkeys(rooms):
        places = [i for i, each in enumerate(rooms) if each == name]
        ax.text(float(np.mean(places)), 1.02, f"{name} rooms", ha="center", va="bottom", fontsize=10)
        if places[0]:
            ax.axvline(places[0] - 0.5, color="black", lw=1)


def _plot_worst(worst: CaseResult, axes: list[Axes]) -> None:
    """Draw the picture of the worst scene and its errors in white and in yellow."""
    pixels, labels, truth, field = worst.kept
    plot_picture(pixels, axes[0], ticks=False)
    axes[0].set_title(f"worst: {worst.name}, {worst.score:.2f}", fontsize=11)
    for ax, name in zip(axes[1:], ("white", "yellow"), strict=True):
        label = LABELS.index(name)
        called = (labels == label) & (field if name == "white" else True)
        errors = painted(error_classes(called, truth == label), ERROR_COLOURS)
        if name == "white":
            errors[~field] = 90  # not counted
        plot_picture(errors, ax, ticks=False)
        ax.set_title(f"{name}: F1 {worst.columns[name]:.2f}", fontsize=11)


def _keys(run: Run, with_pixels: bool) -> list[Patch | Line2D]:
    bars = ((SCORED, "scored"), (WHITE_LOST, "lost to white"), (YELLOW, "lost to yellow"))
    keys: list[Patch | Line2D] = [Patch(color=colour, label=text) for colour, text in bars]
    if any(row.name == "the reference" for row in run.challenge.rows):
        keys.append(Line2D([], [], color="black", lw=2, label="the reference's score"))
    if with_pixels:
        words = ("right", "wrongly labelled", "missed")
        keys += [
            Patch(facecolor=colour, edgecolor="black", lw=0.5, label=f"pixel: {text}")
            for colour, text in zip(ERROR_COLOURS, words, strict=False)
        ]
        keys.append(Patch(color="#5a5a5a", label="behind the field: white does not count"))
    return keys


def _words(run: Run) -> str:
    """Return the contents of the figure in words."""
    by_score = sorted(run.results, key=lambda each: each.score)
    lost = ", ".join(f"{each.name} with {each.score:.2f}" for each in by_score[:3])
    means = "; ".join(
        f"{room} rooms {_mean_score(run, room):.2f} on average"
        for room in dict.fromkeys(each.name.split()[0] for each in run.results)
    )
    return f"Score of each of {len(run.results)} scenes: {means}. The worst are {lost}."
