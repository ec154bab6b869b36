"""Where an entry that finds points in pictures loses: the three worst scenes, with what was found and what is so."""

from __future__ import annotations

from functools import partial

from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.challenges.declaration import Run
from nao_course.plotting import Drawing, course_style, plot_found, plot_picture
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import FOUND, HALO

SHOWN = 3


def draw_worst_scenes(run: Run, what: str) -> Drawing:
    """Draw the scenes with the worst scores.

    Parameters
    ----------
    run : Run
        All scenes of the challenge; what a judge kept of each is (pixels, found points, true points).
    what : str
        One of the points, such as "foot".

    Returns
    -------
    Drawing
        The figure; its text names them.
    """
    challenge = run.challenge
    judged = (each for each in run.results if each.kept)
    worst = sorted(judged, key=lambda each: each.score, reverse=not challenge.higher_is_better)[:SHOWN]
    with course_style():
        figure = Figure(figsize=(9.9, 3.2))
        for number, each in enumerate(worst, start=1):
            pixels, points, truth = each.kept
            ax = figure.add_subplot(1, SHOWN, number)
            plot_picture(pixels, ax, ticks=False)
            ax.plot(*truth.T, "x", color="black", ms=8, mew=2.2, path_effects=HALO)
            plot_found(points, ax, size=11)
            ax.set_title(f"{each.name}: {challenge.say(each.score)}", fontsize=11)
        keys = [
            Line2D([], [], color=FOUND, marker="o", mfc="none", ls="", ms=9, mew=2.2, label="found"),
            Line2D([], [], color="black", marker="x", ls="", ms=8, mew=2.2, label=f"true {what}"),
        ]
        legend_below(figure, keys)
    said = ", ".join(f"{each.name} with {challenge.say(each.score)}" for each in worst)
    return Drawing(
        figure,
        f"Score of {len(run.results)} scenes: {challenge.say(run.score)}. The worst are {said}.",
        photo=True,
    )


def worst_scenes_of(what: str) -> partial[Drawing]:
    """Return `draw_worst_scenes` for a `Challenge`'s figure; `what` is one of the points, such as "foot"."""
    return partial(draw_worst_scenes, what=what)
