"""Figure and table of the recorded errors and NEES of every variant of SLAM on the same rendered drives."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from nao_course.lessons.slam_on_the_field.associating import plot_median
from nao_course.plotting import STYLES, Drawing, Table, course_style, table
from nao_course.plotting.style import GREY, Source

RECORDED = Path(__file__).with_suffix(".json")  # written by the benchmark field_slam
EXPECTED = 2.37  # median NEES of a consistent pose: chi-square with 3 degrees of freedom
ON_THE_WAY = 10  # rows from odometry to the complete system; each of the others changes one thing in it
# Sources of the first and the last of these rows by variant; the rows between them are variants of the EKF.
ENDS: dict[str, Source] = {"odometry": "odometry", "graph": "graph"}
COMPLETE = 8  # row of the complete EKF
LOST = 15.0  # cm: a drive with a larger final error is lost
LEAST = 1e-2  # a smaller NEES is drawn here


def recorded_variants() -> list[dict[str, Any]]:
    """Return each variant with its name, and errors (m, degrees) and NEES of all its drives."""
    rows: list[dict[str, Any]] = json.loads(RECORDED.read_text(encoding="utf-8"))
    return rows


@course_style()
def draw_variants() -> Drawing:
    """Draw each drive's final error and NEES, with the median, from odometry to the complete system."""
    rows = recorded_variants()[:ON_THE_WAY]
    drives = len(rows[0]["position"])
    rng, said = np.random.default_rng(0), []
    figure = Figure(figsize=(9.6, 5.2))
    axes = figure.subplots(1, 2, sharey=True)
    for n, row in enumerate(rows):
        off, nees = 100 * np.array(row["position"]), np.maximum(row["nees"], LEAST)
        beside = -n - rng.uniform(0.05, 0.3, drives)
        source = STYLES[ENDS[row["variant"]] if n in (0, len(rows) - 1) else "ekf"]
        for ax, values, unit in zip(axes, (off, nees), (" cm", ""), strict=True):
            ax.plot(values, beside, "o", ms=2.5, mec="none", color=source.colour, alpha=0.45)
            middle = float(np.median(values))
            plot_median(ax, middle, -n, f"{_readable(middle)}{unit}", 2, below=0.17, ticks=15, size=8.5)
        said.append(f"{row['variant']}: {np.median(off):.1f} cm, NEES {np.median(nees):.1f}")
    axes[1].axvline(EXPECTED, color=GREY, lw=1, ls=":")
    for ax, label in zip(
        axes, ("final position error (cm)", "final pose NEES (consistent median: 2.4)"), strict=True
    ):
        ax.set(xscale="log", xlabel=label, ylim=(0.5 - len(rows), 0.6))
    axes[0].xaxis.set_major_formatter("{x:g}")
    axes[0].set_yticks([-n - 0.1 for n in range(len(rows))], labels=[row["variant"] for row in rows])
    return Drawing(
        figure, f"Error and NEES at the end of {drives} drives by variant, medians: {'; '.join(said)}."
    )


def variants_table() -> Table:
    """Make a table of the final errors and NEES of the complete EKF and of the variants that change one thing in it."""
    rows = []
    for each in recorded_variants()[COMPLETE:]:
        off = 100 * np.array(each["position"])
        landmarks = 100 * np.median(each["landmarks"])
        values = (np.median(off), np.quantile(off, 0.95), off.max())
        lost = str(int(np.count_nonzero(off > LOST)))
        nees = np.median(each["nees"]), np.mean(each["nees"])
        heading = f"{np.median(each['heading']):.2f}"
        rows.append(
            [
                each["variant"],
                *map(_readable, values),
                lost,
                _readable(landmarks),
                heading,
                *map(_readable, nees),
            ]
        )
    columns = [
        "variant",
        "error (cm, median)",
        "95 %",
        "worst",
        f"lost (> {LOST:g} cm)",
        "landmarks (cm)",
        "heading (°)",
        "NEES (median)",
        "NEES (mean)",
    ]
    return table(columns, rows)


def _readable(value: float) -> str:
    """Return a number with one decimal below 10, and without decimals above."""
    return f"{value:.1f}" if value < 10 else f"{value:,.0f}"
