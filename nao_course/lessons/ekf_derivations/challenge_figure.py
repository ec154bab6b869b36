"""How an entry to lesson 05's challenge went: the calls it took for each Jacobian, and what it named."""

from __future__ import annotations

from matplotlib.figure import Figure
from matplotlib.patches import Patch

from nao_course.challenges import Run
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.drawing import say_count
from nao_course.plotting.legends import legend_below

_RIGHT, _WRONG = STYLES["ekf"].colour, STYLES["odometry"].colour


def draw_calls(run: Run) -> Drawing:
    """Draw the calls that each Jacobian took.

    Parameters
    ----------
    run : Run
        All Jacobians of the challenge.

    Returns
    -------
    Drawing
        A bar for each that was named; its text lists them.
    """
    named = [each for each in run.results if each.kept]
    said = []
    with course_style():
        figure = Figure(figsize=(9.6, 0.42 * max(len(named), 1) + 1.3))
        ax = figure.subplots()
        for place, each in enumerate(named):
            right, name, calls = each.kept
            ax.barh(place, calls, color=_RIGHT if right else _WRONG, hatch="" if right else "///", ec="white")
            text = name if right else f"{name}, which is wrong"
            ax.text(calls + 0.15, place, text, va="center", fontsize=9.5)
            said.append(f"{each.name}: {say_count(calls, 'call')}, {text}")
        ax.set(
            xlabel="calls",
            xlim=(0, 2.2 * max([each.kept[2] for each in named] + [5])),
            ylim=(len(named) - 0.4, -0.6),
        )
        ax.set_yticks(range(len(named)), [each.name for each in named])
        keys = [
            Patch(facecolor=_RIGHT, label="named right"),
            Patch(facecolor=_WRONG, hatch="///", ec="white", label="named wrong"),
        ]
        legend_below(figure, keys)
    return Drawing(figure, "Calls for each Jacobian, and what was named. " + "; ".join(said) + ".")
