"""What solving costs by size, as ``python -m benchmarks linear_graphs`` measured it."""

from __future__ import annotations

import json
from pathlib import Path

from matplotlib.figure import Figure

from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.legends import legend_below

RECORDED = Path(__file__).with_suffix(".json")
_LOOKS = {"dense": "odometry", "sparse, as numbered": "ekf", "sparse, a good order": "graph"}


def draw_costs() -> Drawing:
    """Draw the recorded seconds and megabytes by the number of variables, in three ways of solving."""
    recorded = json.loads(RECORDED.read_text(encoding="utf-8"))
    words = []
    with course_style():
        figure = Figure(figsize=(9.8, 4.1))
        times, sizes = figure.subplots(1, 2)
        for name, source in _LOOKS.items():
            rows = recorded[name]
            look = STYLES[source]
            options = {"color": look.colour, "marker": look.marker, "ms": 6, "lw": 2, "label": name}
            variables = [row["variables"] for row in rows]
            times.plot(variables, [row["seconds"] for row in rows], **options)
            sizes.plot(variables, [row["megabytes"] for row in rows], **options)
            last = rows[-1]
            words.append(
                f"{name}: {last['seconds']:.2g} s and {last['megabytes']:.2g} MB for {last['variables']} variables"
            )
        times.set(ylabel="seconds for one axis")
        sizes.set(ylabel="megabytes of the factor")
        for ax in (times, sizes):
            ax.set(xscale="log", yscale="log", xlabel="variables")
            ax.grid(color="#e3e5e8")
        legend_below(figure, times.get_legend_handles_labels()[0])
    return Drawing(figure, f"Cost of solving a corridor by its size, on one core. {'; '.join(words)}.")
