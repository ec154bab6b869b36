"""What a gate does to a drive: which associations are right and which are not, and the map that grows from them."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from nao_course.geometry import FloatArray
from nao_course.lessons.slam_on_the_field.associating import BAD, GOOD, Associate, Outcome, follow
from nao_course.lessons.slam_on_the_field.worlds import FIELD, LANDMARKS, DrawnDrive, drawn_drive
from nao_course.plotting import (
    STYLES,
    Drawing,
    Table,
    course_style,
    plot_estimate,
    plot_field,
    plot_path,
    table,
)
from nao_course.plotting.legends import legend_below, source_key

DRIVES, MOVES = 6, 15
GATES = (1.0, 3.0, 10.0)
TIGHTEST, WIDEST = GATES[0], GATES[-1]
NEAREST, JOINTLY = "nearest neighbour", "joint compatibility"
JOINT_GATE = 3.0
SHOWN = 1  # the drive that is drawn
RECORDED = Path(__file__).with_suffix(".json")
# What becomes of a measurement; "again": its landmark is on the map, and it is put there a second time.
FATES = {"right": GOOD, "wrong": BAD, "again": "#e08a00", "left out": "#b8b8b8"}
SAID = {"again": "a second time on the map"}


@dataclass(frozen=True, eq=False)
class Watched:
    """What a filter made of a drive, and what became of each measurement.

    Parameters
    ----------
    outcome : Outcome
        At the drive's end.
    fates : mapping of str to int
        How many measurements were each of `FATES`.
    """

    outcome: Outcome
    fates: Mapping[str, int]


def watch(
    slam_class: Callable[..., Any], drive: DrawnDrive, gate: float, match: Associate | None = None
) -> Watched:
    """Run a student's class over a drive, and look at its `indices` after each picture.

    A landmark on the map is the one whose measurement put it there.
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


def with_gates(
    slam_class: Callable[..., Any], associate_jointly: Associate | None = None
) -> Mapping[str, list[Watched]]:
    """What each gate makes of the lesson's drives, by its name; kept, for several cells show it."""
    kinds: dict[str, tuple[float, Associate | None]] = {f"gate {gate:g}": (gate, None) for gate in GATES}
    if associate_jointly is not None:
        kinds[f"{JOINTLY}, gate {JOINT_GATE:g}"] = (JOINT_GATE, associate_jointly)
    return {name: _watched(slam_class, gate, match) for name, (gate, match) in kinds.items()}


@lru_cache(maxsize=16)  # of both filters, and of both as they were before a cell was run again
def _watched(slam_class: Callable[..., Any], gate: float, match: Associate | None) -> list[Watched]:
    return [watch(slam_class, drive, gate, match) for drive in _drives()]


@cache
def _drives() -> tuple[DrawnDrive, ...]:
    return tuple(drawn_drive(seed, MOVES) for seed in range(DRIVES))


def lost_landmarks(slam_class: Callable[..., Any]) -> float:
    """How many landmarks the map has with the tightest gate, on average."""
    found = with_gates(slam_class)[f"gate {TIGHTEST:g}"]
    return round(float(np.mean([len(each.outcome.estimate.kinds) for each in found])), 1)


def wrong_share(slam_class: Callable[..., Any]) -> float:
    """How many of all measurements are taken for a wrong landmark with the widest gate, in percent."""
    return round(100 * shares_of(with_gates(slam_class)[f"gate {WIDEST:g}"])["wrong"], 1)


def shares_of(drives: Sequence[Watched]) -> dict[str, float]:
    """Which part of all measurements of some drives met each fate."""
    counts = {fate: sum(each.fates[fate] for each in drives) for fate in FATES}
    return {fate: count / sum(counts.values()) for fate, count in counts.items()}


def gate_table(slam_class: Callable[..., Any], associate_jointly: Associate) -> Table:
    """Say what each gate makes of the lesson's drives."""
    rows = []
    for name, drives in with_gates(slam_class, associate_jointly).items():
        off = np.array([each.outcome.off for each in drives])
        rows.append(
            [
                name,
                *(f"{100 * share:.1f}" for share in shares_of(drives).values()),
                f"{np.mean([len(each.outcome.estimate.kinds) for each in drives]):.1f}",
                f"{100 * np.median(off):.0f}",
                f"{100 * off.max():.0f}",
                f"{np.median([each.outcome.nees for each in drives]):.1f}",
            ]
        )
    columns = [
        "association",
        *(f"{fate} (%)" for fate in FATES),
        f"landmarks of {len(LANDMARKS)}",
        "median error (cm)",
        "worst (cm)",
        "median NEES (3)",
    ]
    return table(columns, rows)


def draw_gates(slam_class: Callable[..., Any], associate_jointly: Associate, shown: int = SHOWN) -> Drawing:
    """Draw the same drive with each gate: the true path, the estimated one, and the map at its end."""
    outcomes = {
        name: found[shown].outcome for name, found in with_gates(slam_class, associate_jointly).items()
    }
    with course_style():
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
    """What the reference's filter made of thirty drives, by way and gate; see `draw_associations`."""
    rows: list[dict[str, Any]] = json.loads(RECORDED.read_text(encoding="utf-8"))
    return rows


def draw_associations() -> Drawing:
    """Draw what became of the measurements of thirty drives by both ways with each gate, and how the drives ended."""
    rows, said = sorted(recorded(), key=lambda row: float(row["gate"])), []
    heights = [-n - 0.5 * (n // 2) for n in range(len(rows))]  # both ways of a gate stand together
    with course_style():
        figure = Figure(figsize=(10.4, 3.9))
        bars, ends = figure.subplots(1, 2, sharey=True, width_ratios=(3, 2))
        for y, row in zip(heights, rows, strict=True):
            _draw_shares(bars, y, row["shares"])
            _draw_ends(ends, y, 100 * np.array(row["off"]))
            shares = ", ".join(f"{100 * share:.1f} % {fate}" for fate, share in row["shares"].items())
            median = 100 * np.median(row["off"])
            said.append(f"Gate {row['gate']:g}, {row['way']}: {shares}; median {median:.1f} cm")
        bars.set_yticks(heights, labels=[f"gate {row['gate']:g}, {row['way']}" for row in rows])
        bars.set(xlim=(0, 100), xlabel="of all measurements (%)", ylim=(heights[-1] - 0.5, 0.7))
        ends.set(xscale="log", xlabel="final position off (cm)")
        ends.xaxis.set_major_formatter("{x:g}")
        keys = [Patch(color=colour, label=SAID.get(fate, fate)) for fate, colour in FATES.items()]
        legend_below(figure, keys)
    return Drawing(figure, f"{len(rows[0]['off'])} drives by gate and association. {'. '.join(said)}.")


def _draw_ends(ax: Axes, y: float, off: FloatArray) -> None:
    """A dot for each drive, and their median (cm)."""
    middle = float(np.median(off))
    ax.plot(off, np.full(len(off), y), "o", ms=4, mec="none", color=STYLES["ekf"].colour, alpha=0.45)
    ax.plot([middle], [y], "|", ms=18, mew=2.5, color=STYLES["truth"].colour)
    ax.annotate(f"{middle:.2g} cm", (middle, y), (0, 9), textcoords="offset points", ha="center", fontsize=9)


def _draw_shares(ax: Axes, y: float, shares: Mapping[str, float]) -> None:
    """One bar of all fates; a part that has room says how large it is."""
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
