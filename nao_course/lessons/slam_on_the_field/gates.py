"""The effect of a gate on a drive: how many associations are right or wrong, and the map that grows from them."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from nao_course.geometry import FloatArray
from nao_course.lessons.slam_on_the_field.associating import (
    BAD,
    GOOD,
    Associate,
    Outcome,
    follow,
    plot_median,
)
from nao_course.lessons.slam_on_the_field.worlds import FIELD, LANDMARKS, DrawnDrive, drawn_drive
from nao_course.plotting import STYLES, Drawing, course_style, plot_estimate, plot_field, plot_path
from nao_course.plotting.legends import legend_below, source_key

MOVES = 15
GATES = (1.0, 3.0, 10.0)
NEAREST, JOINTLY = "nearest neighbour", "joint compatibility"
JOINT_GATE = 3.0
SHOWN = 1  # seed of the drive that is drawn
RECORDED = Path(__file__).with_suffix(".json")
# What happens to a measurement; "again": its landmark is on the map already, and it is put there a second time.
FATES = {"right": GOOD, "wrong": BAD, "again": "#e08a00", "left out": "#b8b8b8"}
SAID = {
    "right": "correct association",
    "wrong": "incorrect association",
    "again": "duplicate landmark",
    "left out": "rejected",
}


@dataclass(frozen=True, eq=False)
class Watched:
    """The result of a filter on a drive, and the number of measurements with each of `FATES`."""

    outcome: Outcome
    fates: Mapping[str, int]


def watch(
    slam_class: Callable[..., Any], drive: DrawnDrive, gate: float, match: Associate | None = None
) -> Watched:
    """Run a student's class over a drive and count what happens to each measurement, from its `indices`.

    A landmark on the map counts as the true landmark whose measurement put it there.
    """
    fates: Counter[str] = Counter()
    named: list[int] = []  # of each landmark on the map, which of the field's it is
    origins = iter(drive.origins)

    class Counted(slam_class):  # type: ignore[misc, valid-type]
        def observe(self, measurements: Any) -> None:
            super().observe(measurements)
            for index, origin in zip(self.indices, next(origins), strict=True):
                if index < 0:
                    fates["left out"] += 1
                elif index < len(named):
                    fates["right" if named[index] == origin else "wrong"] += 1
                else:
                    fates["again" if origin in named else "right"] += 1
                    named.append(origin)

    return Watched(follow(Counted, drive, gate, match), fates)


def recorded_landmarks(gate: float) -> float:
    """Return the mean number of landmarks on the map after the recorded drives with nearest neighbour."""
    return round(float(np.mean(_row(gate)["landmarks"])), 1)


def recorded_wrong(gate: float) -> float:
    """Return the percentage of measurements that the recorded drives match wrong with nearest neighbour."""
    return round(100 * float(_row(gate)["shares"]["wrong"]), 1)


def _row(gate: float) -> dict[str, Any]:
    """Return what was recorded of nearest neighbour with a gate."""
    return next(row for row in recorded() if row["way"] == NEAREST and row["gate"] == gate)


def shares_of(drives: Sequence[Watched]) -> dict[str, float]:
    """Return the fraction of all measurements of some drives that met each fate."""
    counts = {fate: sum(each.fates[fate] for each in drives) for fate in FATES}
    return {fate: count / sum(counts.values()) for fate, count in counts.items()}


@course_style()
def draw_gates(slam_class: Callable[..., Any], associate_jointly: Associate, seed: int = SHOWN) -> Drawing:
    """Draw the same drive with each gate: the true path, the estimated one, and the map at its end."""
    drive = drawn_drive(seed, MOVES)
    outcomes = {f"gate {gate:g}": follow(slam_class, drive, gate) for gate in GATES}
    outcomes[f"{JOINTLY}, gate {JOINT_GATE:g}"] = follow(slam_class, drive, JOINT_GATE, associate_jointly)
    figure = Figure(figsize=(10.4, 4.4))
    for number, (name, each) in enumerate(outcomes.items(), start=1):
        ax = figure.add_subplot(1, len(outcomes), number)
        plot_field(FIELD, ax)
        plot_path(each.path[:, :2], ax, "ekf", robot=False)
        plot_path(each.drive.poses, ax)
        plot_estimate(each.estimate, ax)
        ax.set_title(
            f"{name}\n{len(each.estimate.kinds)} landmarks, off {100 * each.off:.0f} cm", fontsize=10
        )
        x0, y0, x1, y1 = FIELD.carpet
        ax.set(xlim=(x0, x1), ylim=(y0, y1))
        if number > 1:
            ax.set_ylabel("")
    legend_below(figure, [source_key("truth", "true path"), source_key("ekf", "estimate, 95 %")])
    said = "; ".join(
        f"{name}: {len(each.estimate.kinds)} landmarks, position off by {100 * each.off:.0f} cm, NEES {each.nees:.1f}"
        for name, each in outcomes.items()
    )
    return Drawing(figure, f"One drive over the half field, which has {len(LANDMARKS)} landmarks. {said}.")


# --- thirty drives, recorded by `python -m benchmarks association` ---


def recorded() -> list[dict[str, Any]]:
    """Return the reference filter's results on thirty drives, by association and gate; see `draw_associations`."""
    rows: list[dict[str, Any]] = json.loads(RECORDED.read_text(encoding="utf-8"))
    return rows


@course_style()
def draw_associations() -> Drawing:
    """Draw what happened to the measurements of thirty drives with each gate and association, and the final errors."""
    rows, said = sorted(recorded(), key=lambda row: float(row["gate"])), []
    heights = [-n - 0.5 * (n // 2) for n in range(len(rows))]  # both associations of a gate are neighbours
    figure = Figure(figsize=(10.4, 3.9))
    bars, ends = figure.subplots(1, 2, sharey=True, width_ratios=(3, 2))
    for y, row in zip(heights, rows, strict=True):
        _draw_shares(bars, y, row["shares"])
        _draw_ends(ends, y, 100 * np.array(row["off"]))
        shares = ", ".join(f"{100 * share:.1f} % {SAID[fate]}" for fate, share in row["shares"].items())
        median = 100 * np.median(row["off"])
        said.append(f"Gate {row['gate']:g}, {row['way']}: {shares}; median {median:.1f} cm")
    bars.set_yticks(heights, labels=[f"gate {row['gate']:g}, {row['way']}" for row in rows])
    bars.set(xlim=(0, 100), xlabel="of all measurements (%)", ylim=(heights[-1] - 0.5, 0.7))
    ends.set(xscale="log", xlabel="final position error (cm)")
    ends.xaxis.set_major_formatter("{x:g}")
    keys = [Patch(color=colour, label=SAID[fate]) for fate, colour in FATES.items()]
    legend_below(figure, keys)
    return Drawing(figure, f"{len(rows[0]['off'])} drives by gate and association. {'. '.join(said)}.")


def _draw_ends(ax: Axes, y: float, off: FloatArray) -> None:
    """Plot a dot for each drive, and mark their median (cm)."""
    middle = float(np.median(off))
    ax.plot(off, np.full(len(off), y), "o", ms=4, mec="none", color=STYLES["ekf"].colour, alpha=0.45)
    plot_median(ax, middle, y, f"{middle:.2g} cm", 9)


def _draw_shares(ax: Axes, y: float, shares: Mapping[str, float]) -> None:
    """Plot one bar of all fates, with its percentage in each part that is wide enough."""
    left = 0.0
    for fate, colour in FATES.items():
        width = 100 * shares[fate]
        ax.barh(y, width, 0.62, left=left, color=colour)
        if width >= 5:
            ax.text(
                left + width / 2,
                y,
                f"{width:.0f}",
                ha="center",
                va="center",
                fontsize=9,
                color="black" if fate in ("left out", "again") else "white",
            )
        left += width
