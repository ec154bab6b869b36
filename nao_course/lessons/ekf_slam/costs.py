"""Show the time of a step of EKF SLAM by the size of the map, as ``python -m benchmarks ekf_speed`` measured it."""

from __future__ import annotations

import json
from pathlib import Path

from matplotlib.figure import Figure

from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import GREY

RECORDED = Path(__file__).with_suffix(".json")
_STYLES = {
    "dense textbook": (STYLES["odometry"].colour, "s", "-"),
    "filterpy": (GREY, "v", "--"),
    "new arrays": (STYLES["ekf"].colour, "^", "-"),
    "in place": ("#56a0d3", "o", "-"),
    "compressed": ("#2e8540", "D", "-"),
    "compressed, moving on": ("#2e8540", "D", ":"),
}


@course_style()
def draw_costs() -> Drawing:
    """Draw the recorded time of a prediction and an update with one landmark by the number of landmarks."""
    recorded = json.loads(RECORDED.read_text(encoding="utf-8"))
    words = []
    figure = Figure(figsize=(8.4, 5.0))
    ax = figure.add_subplot()
    for name, (colour, marker, line) in _STYLES.items():
        if rows := recorded.get(name):
            landmarks, ms = [row["landmarks"] for row in rows], [row["ms"] for row in rows]
            ax.plot(landmarks, ms, color=colour, marker=marker, ls=line, ms=6, lw=2, label=name)
            words.append(f"{name}: {ms[-1]:.3g} ms for {landmarks[-1]}")
    ax.set(xscale="log", yscale="log", xlabel="landmarks", ylabel="ms for one step, one core")
    ax.set_xticks([10, 20, 50, 100, 200, 500, 1000], labels=["10", "20", "50", "100", "200", "500", "1000"])
    ax.minorticks_off()
    ax.grid(color="#e3e5e8")
    legend_below(figure, ax.get_legend_handles_labels()[0], columns=3)
    return Drawing(
        figure,
        f"Time of a prediction and an update with one landmark by the number of landmarks. {'; '.join(words)}.",
    )
