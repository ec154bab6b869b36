"""Where an entry to lesson 02's challenge loses points: the three worst scenes, with what was found and what is so."""

from __future__ import annotations

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.challenges import Run
from nao_course.lessons.goalposts.figures import FOOT, plot_feet
from nao_course.plotting import Drawing, course_style, plot_picture
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import HALO

SHOWN = 3


def draw_worst_scenes(run: Run) -> Drawing:
    """Draw the scenes with the lowest scores.

    Parameters
    ----------
    run : Run
        All scenes of the challenge.

    Returns
    -------
    Drawing
        The figure; its text names them.
    """
    worst = sorted((each for each in run.results if each.kept), key=lambda each: each.score)[:SHOWN]
    with course_style():
        figure = Figure(figsize=(9.9, 3.2))
        for number, each in enumerate(worst, start=1):
            pixels, points, feet = each.kept
            ax = figure.add_subplot(1, SHOWN, number)
            plot_picture(pixels, ax, ticks=False)
            ax.plot(*feet.T, "x", color="black", ms=8, mew=2.2, path_effects=HALO)
            plot_feet(points, ax, size=11)
            ax.set_title(f"{each.name}: {each.score:.2f}", fontsize=11)
        keys = [
            Line2D([], [], color=FOOT, marker="o", mfc="none", ls="", ms=9, mew=2.2, label="found"),
            Line2D([], [], color="black", marker="x", ls="", ms=8, mew=2.2, label="true foot"),
        ]
        legend_below(figure, keys)
    said = ", ".join(f"{each.name} with {each.score:.2f}" for each in worst)
    return Drawing(
        figure, f"Score of {len(run.results)} scenes: {run.score:.2f}. The worst are {said}.", photo=True
    )
