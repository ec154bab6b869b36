"""Figure of an entry's worst cases side by side, drawn by the challenge's own function."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nao_course.challenges.declaration import Column, Run
from nao_course.plotting import Drawing, course_style
from nao_course.plotting.legends import legend_below

SHOWN = 3


@course_style()
def draw_worst(
    run: Run,
    plot: Callable[[Axes, Any], None],
    keys: Sequence[Artist],
    *,
    height: float = 4.7,
    digits: int | None = None,
    photo: bool = False,
) -> Drawing:
    """Draw the cases with the worst scores: ``plot(ax, kept)`` draws a case from `CaseScore.kept`.

    The figure is `height` inches high. By default, a score has as many digits as on the board; `photo` says whether the
    figure contains camera pictures.
    """
    challenge = run.challenge
    case = Column("", challenge.unit, challenge.digits if digits is None else digits)
    judged = (each for each in run.results if each.kept)
    worst = sorted(judged, key=lambda each: each.score, reverse=not challenge.higher_is_better)[:SHOWN]
    figure = Figure(figsize=(9.9, height))
    for number, each in enumerate(worst, start=1):
        ax = figure.add_subplot(1, SHOWN, number)
        plot(ax, each.kept)
        ax.set_title(f"{each.name}: {case.say(each.score)}", fontsize=11)
    legend_below(figure, keys)
    said = ", ".join(f"{each.name} with {case.say(each.score)}" for each in worst)
    return Drawing(
        figure,
        f"Score of {len(run.results)} {challenge.case}s: {challenge.say(run.score)}. The worst are {said}.",
        photo=photo,
    )
