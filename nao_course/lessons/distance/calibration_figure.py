"""The figure of the distances' errors after calibration: of simulated marks, and of a real robot's pictures."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.geometry import FloatArray
from nao_course.lessons.distance.calibration import EDGES, by_distance
from nao_course.plotting.drawing import Drawing
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import STYLES, course_style, style_of

COLOURS = {"the paper's formula": STYLES["odometry"].colour, "exact": STYLES["ekf"].colour}

# Real pictures, set by set: median and 90 % of the size of the distance's error (m) in each bin, after `estimate_pitch`
# on ten other pictures, by `python -m benchmarks distance`; a test holds both together.
REAL: dict[str, dict[str, tuple[tuple[float, float], ...]]] = {
    "real scenes": {
        "the paper's formula": ((0.048, 0.162), (0.145, 0.389), (0.300, 0.581), (0.427, 0.764)),
        "exact": ((0.037, 0.129), (0.108, 0.336), (0.260, 0.545), (0.165, 0.484)),
    },
    "real walk": {
        "the paper's formula": ((0.051, 0.124), (0.070, 0.113), (0.230, 0.337), (0.325, 0.592)),
        "exact": ((0.036, 0.097), (0.064, 0.165), (0.100, 0.255), (0.191, 0.432)),
    },
}


@course_style()
def draw_calibrated(simulated: Mapping[str, tuple[FloatArray, FloatArray]]) -> Drawing:
    """Draw the size of the distances' errors by distance: simulated pictures, and a real robot's.

    Parameters
    ----------
    simulated : mapping of str to (true, errors)
        From `range_errors`, by "the paper's formula" and "exact".

    Returns
    -------
    Drawing
        The figure; its text has all medians.
    """
    sets = {"simulated": {name: by_distance(*each) for name, each in simulated.items()}, **REAL}
    middles = [(low + high) / 2 for low, high in pairwise(EDGES)]
    said = []
    figure = Figure(figsize=(9.9, 3.8))
    for ax, (title, methods) in zip(
        figure.subplots(1, len(sets), sharey=True, squeeze=False)[0], sets.items(), strict=True
    ):
        for shift, (name, rows) in zip((-0.08, 0.08), methods.items(), strict=False):
            median, most = np.array(rows).T
            x, colour = np.array(middles) + shift, COLOURS[name]
            ax.vlines(x, median, most, color=colour, lw=2, alpha=0.6)
            ax.plot(x, median, STYLES["odometry" if shift < 0 else "ekf"].marker, color=colour, ms=8)
            said.append(f"{title}, {name}: {', '.join(f'{each:.2f}' for each in median)} m")
        ax.set(xlabel="true distance (m)", ylim=(0, 1.6), xticks=EDGES)
        ax.grid(color="#e3e5e8")
        ax.set_title(title, fontsize=11)
    figure.axes[0].set_ylabel("size of the distance's error (m)")
    keys = [
        Line2D(
            [],
            [],
            color=colour,
            marker=style_of(key).marker,
            lw=2,
            ms=8,
            label=f"{name}: median, and up to 90 %",
        )
        for key, (name, colour) in zip(("odometry", "ekf"), COLOURS.items(), strict=True)
    ]
    legend_below(figure, keys)
    return Drawing(figure, f"Median errors at 1-2, 2-3, 3-4 and 4-5 m. {'; '.join(said)}.")
