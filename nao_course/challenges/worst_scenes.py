"""Figure of the three worst scenes of an entry that finds points in pictures, with found and true points."""

from __future__ import annotations

from functools import partial
from typing import Any

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from nao_course.challenges.declaration import Run
from nao_course.challenges.worst_cases import draw_worst
from nao_course.plotting import Drawing, plot_found, plot_picture
from nao_course.plotting.halo import HALO
from nao_course.plotting.style import FOUND


def draw_worst_scenes(run: Run, what: str) -> Drawing:
    """Draw the scenes with the worst scores; each has `kept` (pixels, found points, true points), px."""
    keys = [
        Line2D([], [], color=FOUND, marker="o", mfc="none", ls="", ms=9, mew=2.2, label="found"),
        Line2D([], [], color="black", marker="x", ls="", ms=8, mew=2.2, label=f"true {what}"),
    ]
    return draw_worst(run, _plot_scene, keys, height=3.2, photo=True)


def _plot_scene(ax: Axes, kept: Any) -> None:
    """Draw a picture with found and true points."""
    pixels, points, truth = kept
    plot_picture(pixels, ax, ticks=False)
    ax.plot(*truth.T, "x", color="black", ms=8, mew=2.2, path_effects=HALO)
    plot_found(points, ax, size=11)


def worst_scenes_of(what: str) -> partial[Drawing]:
    """Return `draw_worst_scenes` for a `Challenge`'s figure; `what` is the noun for a point, such as "foot"."""
    return partial(draw_worst_scenes, what=what)
