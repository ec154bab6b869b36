"""The settings panel: the cost of any setting with its interval, and the pictures that cost most."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray
from nao_course.lessons.experiments.landscape import NOTHING, OURS, interval_of
from nao_course.lessons.experiments.resampling import as_table
from nao_course.lessons.experiments.scenes import CornerScene, nothing_costs, simulated_scenes
from nao_course.plotting import Drawing, course_style
from nao_course.plotting.marks import TRUE, at_scale, enlarged, with_crosses, with_rings
from nao_course.plotting.style import FOUND
from nao_course.widgets import Action, FunctionPanel, Legend, Slider

SIZE = 2  # times: how much larger than the camera's the shown pictures are
WORST = 2  # pictures that are shown
COSTS = "Cost of each picture"


class SettingPanel(FunctionPanel):
    """Show the cost of a setting with an interval, the cost of each picture, and the worst pictures.

    Parameters
    ----------
    scenes : sequence of CornerScene
        To try settings on.
    grid_search : callable
        ``grid_search(scenes, betas, gaps, lengths)`` returns costs (S,) by setting.
    bootstrap_interval : callable
        ``bootstrap_interval(values, probability, rng)`` returns (low, high).
    find : callable
        ``find(picture, beta, gap, length)`` returns corners (K, 2).

    Raises
    ------
    ValueError
        If there are fewer scenes than are shown.
    """

    css = ".nao-laid-out.nao-settings .nao-body { --nao-most: 360px; }"

    def __init__(
        self,
        scenes: Sequence[CornerScene],
        grid_search: Callable[..., Any],
        bootstrap_interval: Callable[..., Any],
        find: Callable[..., Any],
    ) -> None:
        """Try the paper's setting and build the widgets."""
        if len(scenes) < WORST:
            raise ValueError(f"scenes must be at least {WORST}, got {len(scenes)}")
        self._scenes = list(scenes)
        super().__init__(
            "Settings panel",
            self._try,
            [
                Slider(
                    "beta", "Beta", 80, 180, 5, 120, tooltip="Parameter of the white threshold, a lightness"
                ),
                Slider(
                    "gap",
                    "Largest gap",
                    1,
                    15,
                    1,
                    5,
                    unit="px",
                    tooltip="Largest number of missing pixels within a segment",
                ),
                Slider(
                    "length", "Least length", 15, 80, 5, 40, unit="px", tooltip="Shortest length of a segment"
                ),
                Action("paper", "The paper's best", sets={"beta": 120, "gap": 5, "length": 40}),
                Action("fresh", "Thirty new pictures", tooltip="Other rooms; Reset brings yours back"),
            ],
            student={"grid_search": grid_search, "bootstrap_interval": bootstrap_interval, "find": find},
            small=(COSTS,),
            time_limit=60.0,
            unfinished={
                "grid_search": "Finish exercise 10.3 to see what a setting costs.",
                "bootstrap_interval": "Finish exercise 10.4 to see the interval.",
                "find": "Finish lessons 01 and 03 to see the corners.",
            },
        )
        self.widget.add_class("nao-settings")

    def _try(self, values: Any, student: Any) -> Iterator[Any]:
        """Show the costs of all pictures, then the interval, then the pictures that cost most."""
        setting = (values.beta, values.gap, values.length)
        scenes = list(simulated_scenes(seed=values.fresh)) if values.fresh else self._scenes
        nothing = nothing_costs(scenes)
        table = as_table(student.grid_search(scenes, *([each] for each in setting)))
        costs = next(iter(table.values()))
        yield {COSTS: _draw_costs(costs, nothing)}
        yield Legend({"true corner (cross)": TRUE, "corner found (ring)": FOUND})
        low, high = interval_of(student.bootstrap_interval, costs)
        better, worse = interval_of(student.bootstrap_interval, costs - nothing)
        for i in np.argsort(-costs, kind="stable")[:WORST]:
            pixels, corners = scenes[i]
            found = student.find(pixels, *setting)
            rings = with_rings(enlarged(pixels, SIZE), at_scale(found, SIZE, "corners (u, v)"), scale=SIZE)
            marked = with_crosses(rings, at_scale(corners, SIZE), SIZE)
            yield {f"Picture {i + 1} costs {costs[i]:.2f}": marked}
        yield (
            f"Mean cost {costs.mean():.2f}, 95 % from {low:.2f} to {high:.2f}. Reporting nothing costs "
            f"{nothing.mean():.2f}; the difference is {np.mean(costs - nothing):.2f}, 95 % from {better:.2f} to "
            f"{worse:.2f}."
        )


@course_style()
def _draw_costs(costs: FloatArray, nothing: FloatArray) -> Drawing:
    """Draw the sorted costs of all pictures beside the cost of reporting nothing."""
    order = np.argsort(costs, kind="stable")
    figure = Figure(figsize=(3.8, 2.8))
    ax = figure.add_subplot()
    ax.bar(range(len(costs)), costs[order], color=OURS, width=0.8, label="this setting")
    ax.plot(range(len(costs)), nothing[order], "_", color=NOTHING, ms=8, mew=2, label="nothing")
    ax.axhline(0, color="black", lw=0.8)
    ax.set(xlabel="pictures, by their cost", ylabel="cost", xticks=[])
    ax.legend(loc="upper left")
    return Drawing(
        figure,
        f"Cost of {len(costs)} pictures from {costs.min():.2f} to {costs.max():.2f}, mean {costs.mean():.2f}.",
    )
