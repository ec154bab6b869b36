"""Every way of SLAM on the same rendered drives: recorded errors and NEES, as a figure and as a table."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from nao_course.plotting import STYLES, Drawing, Table, course_style, table
from nao_course.plotting.style import GREY

RECORDED = Path(__file__).with_suffix(".json")  # written by the benchmark field_slam
HONEST = 3.0  # an honest pose's NEES, on average
ON_THE_WAY = 10  # rows from odometry to the whole system; the others change one thing of it
LEAST = 1e-2  # a NEES below that is drawn there


def recorded_ways() -> list[dict[str, Any]]:
    """Each way with its name, and errors and NEES of all its drives: m, degrees."""
    rows: list[dict[str, Any]] = json.loads(RECORDED.read_text(encoding="utf-8"))
    return rows


def draw_ways() -> Drawing:
    """Draw each drive's final error and NEES, with the median, from odometry to the whole system."""
    rows = recorded_ways()[:ON_THE_WAY]
    drives = len(rows[0]["position"])
    rng, said = np.random.default_rng(0), []
    with course_style():
        figure = Figure(figsize=(9.6, 5.2))
        axes = figure.subplots(1, 2, sharey=True)
        for n, row in enumerate(rows):
            off, nees = 100 * np.array(row["position"]), np.maximum(row["nees"], LEAST)
            beside = -n - rng.uniform(0.05, 0.3, drives)
            source = STYLES["graph" if row["way"] == "graph" else "ekf" if n else "odometry"]
            for ax, values, unit in zip(axes, (off, nees), (" cm", ""), strict=True):
                ax.plot(values, beside, "o", ms=2.5, mec="none", color=source.colour, alpha=0.45)
                middle = float(np.median(values))
                ax.plot([middle], [-n - 0.17], "|", ms=15, mew=2.5, color=STYLES["truth"].colour)
                ax.annotate(
                    f"{middle:{'.2g' if middle < 100 else ',.0f'}}{unit}",
                    (middle, -n),
                    (0, 2),
                    textcoords="offset points",
                    ha="center",
                    fontsize=8.5,
                )
            said.append(f"{row['way']}: {np.median(off):.1f} cm, NEES {np.median(nees):.1f}")
        axes[1].axvline(HONEST, color=GREY, lw=1, ls=":")
        for ax, label in zip(axes, ("final position off (cm)", "final pose NEES (honest: 3)"), strict=True):
            ax.set(xscale="log", xlabel=label, ylim=(0.5 - len(rows), 0.6))
        axes[0].set_yticks([-n - 0.1 for n in range(len(rows))], labels=[row["way"] for row in rows])
    return Drawing(
        figure,
        f"Error and NEES at the end of {drives} drives by way, medians: {'; '.join(said)}.",
    )


def ways_table() -> Table:
    """Say of each way what the ends of its drives are like."""
    rows = []
    for each in recorded_ways():
        off = 100 * np.array(each["position"])
        landmarks = 100 * np.median(each["landmarks"]) if each["landmarks"] else np.nan
        rows.append(
            [
                each["way"],
                f"{np.median(off):.1f}",
                f"{np.quantile(off, 0.95):.1f}",
                f"{off.max():.0f}" if off.max() > 10 else f"{off.max():.1f}",
                f"{np.median(each['heading']):.2f}",
                f"{landmarks:.1f}" if np.isfinite(landmarks) else "",
                f"{np.mean(each['nees']):.2g}" if np.mean(each["nees"]) < 100 else "more than 100",
                f"{np.median(each['nees']):.2g}",
            ]
        )
    columns = ["way", "off (cm)", "95 %", "worst", "heading (°)", "landmarks (cm)", "NEES", "median"]
    return table(columns, rows)
