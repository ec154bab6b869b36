"""Figure of the recorded errors, NEES and wrong associations of each idea, all on the same drives."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from nao_course.lessons.slam_on_the_field.associating import BAD, plot_median
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.style import GREY

RECORDED = Path(__file__).with_suffix(".json")
EXPECTED = 2.37  # median NEES of a consistent pose: chi-square with 3 degrees of freedom


@course_style()
def draw_ideas() -> Drawing:
    """Draw each drive's final error and NEES for each idea, with the median, and how many associations are wrong."""
    rows = json.loads(RECORDED.read_text(encoding="utf-8"))
    said = []
    figure = Figure(figsize=(10.2, 4.3))
    axes = figure.subplots(1, 3, sharey=True, width_ratios=(4, 4, 2))
    for n, row in enumerate(rows):
        off, nees = 100 * np.array(row["off"]), np.array(row["nees"])
        source = STYLES["graph" if "graph" in row["idea"] else "ekf"]
        for ax, values, unit in zip(axes[:2], (off, nees), (" cm", ""), strict=True):
            ax.plot(values, np.full(len(values), -n), "o", ms=4, mec="none", color=source.colour, alpha=0.5)
            middle = float(np.median(values))
            plot_median(ax, middle, -n, f"{middle:.1f}{unit}", 10)
        wrong = 100 * row["wrong"]
        axes[2].barh(-n, wrong, 0.5, color=BAD)
        axes[2].annotate(
            f"{wrong:.1f}", (wrong, -n), (3, 0), textcoords="offset points", va="center", fontsize=9
        )
        said.append(
            f"{row['idea']}: {np.median(off):.1f} cm, NEES {np.median(nees):.1f}, {wrong:.1f} % wrong"
        )
    axes[1].axvline(EXPECTED, color=GREY, lw=1, ls=":")
    axes[2].set(xlabel="matched with a\nwrong landmark (%)", xlim=(0, 8))
    for ax, label in zip(
        axes[:2], ("final position error (cm)", "final pose NEES (consistent median: 2.4)"), strict=True
    ):
        ax.set(xscale="log", xlabel=label, ylim=(0.6 - len(rows), 0.7))
    axes[0].xaxis.set_major_formatter("{x:g}")
    axes[0].set_yticks([-n for n in range(len(rows))], labels=[row["idea"] for row in rows])
    return Drawing(
        figure,
        f"Error and NEES at the end of {len(rows[0]['off'])} drives by idea, medians, and which share of all "
        f"measurements is matched with a wrong landmark: {'; '.join(said)}.",
    )
