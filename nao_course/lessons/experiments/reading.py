"""Figures about the paper's table: which means are possible, and how other pictures and sizes rank the settings."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.geometry import FloatArray
from nao_course.lessons.experiments.landscape import NOTHING, OURS, THEIRS
from nao_course.lessons.experiments.paper_table import (
    BEST,
    PAPER_MEANS,
    PICTURES,
    SETTINGS,
    Setting,
    say_setting,
)
from nao_course.lessons.experiments.resampling import CostTable, as_table, rank_correlation
from nao_course.plotting import Drawing, course_style
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import GREY

MOST_HITS = 8 * PICTURES  # each picture shows all eight corners of the half field, and all are found
RECORDED = Path(__file__).with_name("recorded.json")


def impossible_means(possible_hits: Callable[..., Any], most_hits: int = MOST_HITS) -> list[Setting]:
    """Return the settings of Table A.1 whose printed mean thirty pictures cannot have."""
    return [
        key
        for key, mean in PAPER_MEANS.items()
        if not np.size(np.asarray(possible_hits(mean, PICTURES, most_hits)))
    ]


def ninetieths(pictures: int = PICTURES) -> list[Setting]:
    """Return the settings whose mean is possible for a number of pictures if a hit costs -4/3."""
    return [
        key
        for key, mean in PAPER_MEANS.items()
        if abs(mean - round(3 * pictures * mean) / (3 * pictures)) <= 0.0005 + 1e-9
    ]


@course_style()
def draw_possible(possible_hits: Callable[..., Any], most_hits: int = MOST_HITS) -> Drawing:
    """Draw which numbers of hits explain each mean of Table A.1, and which means are possible with -4/3 for a hit."""
    hits = {
        key: np.asarray(possible_hits(mean, PICTURES, most_hits), dtype=float).ravel()
        for key, mean in PAPER_MEANS.items()
    }
    cannot, thirds = [key for key, each in hits.items() if not len(each)], ninetieths()
    figure = Figure(figsize=(9.6, 6.6))
    ax, beside = figure.subplots(1, 2, sharey=True, width_ratios=(12, 1))
    for row, (key, each) in enumerate(hits.items()):
        for part in (ax, beside):
            part.axhline(row, color="#e3e5e8", lw=0.8, zorder=0)
        ax.plot(each, np.full(len(each), row), "o", color=OURS, ms=3.5)
        if not len(each):
            box = {"fc": "white", "ec": "none", "pad": 1}
            place = (most_hits / 2, row, "no number of hits")
            ax.text(*place, color=NOTHING, fontsize=10, va="center", ha="center", bbox=box)
        if key in thirds:
            beside.plot(0, row, "D", color=THEIRS, ms=5)
    names = [f"{say_setting(key)}:  {mean:.3f}" for key, mean in PAPER_MEANS.items()]
    ax.set_yticks(range(len(names)), names, fontsize=10)
    ax.set(xlabel="possible numbers of hits in thirty pictures", ylim=(len(names) - 0.4, -0.6))
    ax.set_xlim(-3, most_hits + 3)
    ax.set_xticks(range(0, most_hits + 1, 40))
    beside.set(xlim=(-1, 1), xlabel="possible\nwith 4/3?")
    beside.set_xticks([])
    for part in (ax, beside):
        part.tick_params(axis="y", length=0)
    marks = (("o", OURS, "possible with 1.333, as printed"), ("D", THEIRS, "mean possible with four thirds"))
    legend_below(figure, [Line2D([], [], ls="", marker=m, ms=5, color=c, label=name) for m, c, name in marks])
    best = hits[BEST]
    said = f"{len(best)} from {best.min():.0f} to {best.max():.0f}" if len(best) else "none"
    return Drawing(
        figure,
        f"Possible numbers of hits, up to {most_hits}, for each of the 27 means of Table A.1. For {len(cannot)} "
        f"there is none: {'; '.join(say_setting(key) for key in cannot)}. For the best setting there are {said}. With "
        f"four thirds for a hit {len(thirds)} means are possible: {'; '.join(say_setting(key) for key in thirds)}.",
    )


# --- what was recorded ---


@cache
def recorded() -> Mapping[str, Mapping[str, Any]]:
    """Read the means measured by ``python -m benchmarks experiments``, by set of pictures, in the order of SETTINGS."""
    found: dict[str, dict[str, Any]] = json.loads(RECORDED.read_text(encoding="utf-8"))
    return found


def recorded_means(name: str) -> dict[Setting, float]:
    """Return the 27 mean costs of a set of pictures, by setting."""
    return dict(zip(SETTINGS, recorded()[name]["means"], strict=True))


@course_style()
def draw_agreement(own: CostTable) -> Drawing:
    """Draw how similarly the student's table, the paper's and other pictures rank the 27 settings.

    Parameters
    ----------
    own : mapping
        The student's costs (S,) by setting.
    """
    others = {"the paper": dict(PAPER_MEANS)} | {name: recorded_means(name) for name in AGREEING}
    found = agreement(own, others)
    theirs = {name: rank_correlation(PAPER_MEANS, others[name]) for name in AGREEING}
    names = [HALVES, *sorted(others, key=lambda name: -found[name][0])]
    figure = Figure(figsize=(8.2, 3.2))
    ax = figure.add_subplot()
    ax.axvline(0, color=GREY, lw=1, zorder=0)
    for row, name in enumerate(names):
        middle, low, high = found[name]
        ax.plot([low, high], [row, row], color=OURS, lw=3, alpha=0.45, solid_capstyle="butt")
        ax.plot(middle, row, "o", color=OURS, ms=8, mec="white")
        if name in theirs:
            ax.plot(theirs[name], row, "D", color=THEIRS, ms=6, mec="white")
    ax.set_yticks(range(len(names)), names)
    ax.set(xlabel="rank correlation of the 27 mean costs", xlim=(-0.55, 1.02), ylim=(len(names) - 0.5, -0.5))
    ax.tick_params(axis="y", length=0)
    marks = (("o", OURS, "yours; bar: 95 % of the resamples of your pictures"), ("D", THEIRS, "the paper's"))
    legend_below(figure, [Line2D([], [], ls="", marker=m, ms=7, color=c, label=name) for m, c, name in marks])
    said = [
        f"{name} {found[name][0]:.2f}, 95 % from {found[name][1]:.2f} to {found[name][2]:.2f}"
        for name in names
    ]
    papers = [f"{name} {value:.2f}" for name, value in theirs.items()]
    return Drawing(
        figure,
        f"Rank correlations of the 27 mean costs. Yours with {'; '.join(said)}. The paper's with {'; '.join(papers)}.",
    )


def agreement(
    own: CostTable, others: Mapping[str, Mapping[Setting, float]], draws: int = 1000
) -> dict[str, tuple[float, float, float]]:
    """Return rank correlations of a student's table: with other tables, and of two halves of its own scenes.

    By the name of the other table, and by `HALVES`, return the correlation (for halves the median) and the two ends of
    the interval that contains 95 % of it when the student's scenes are resampled or halved again.
    """
    from scipy.stats import rankdata  # takes long to import

    costs = as_table(own)
    rows = np.array([costs[key] for key in SETTINGS])
    rng, scenes = np.random.default_rng(0), rows.shape[1]

    def ranks(means: FloatArray) -> FloatArray:
        each = rankdata(np.round(means, 6), axis=-1)  # equal means are equal, whatever the order of their sum
        each = each - each.mean(axis=-1, keepdims=True)
        return np.asarray(each / np.linalg.norm(each, axis=-1, keepdims=True))

    again = ranks(rng.multinomial(scenes, np.full(scenes, 1 / scenes), draws) @ rows.T / scenes)
    orders = np.array([rng.permutation(scenes) for _ in range(draws)])
    one, two = (
        ranks(np.array([rows[:, part].mean(axis=1) for part in parts]))
        for parts in (orders[:, : scenes // 2], orders[:, scenes // 2 :])
    )
    halves = (one * two).sum(axis=1)
    found = {HALVES: (float(np.median(halves)), *_middle(halves))}
    for name, means in others.items():
        theirs = ranks(np.array([means[key] for key in SETTINGS]))
        found[name] = (float(ranks(rows.mean(axis=1)) @ theirs), *_middle(again @ theirs))
    return found


def _middle(values: FloatArray) -> tuple[float, float]:
    low, high = np.quantile(values, [0.025, 0.975])
    return float(low), float(high)


HALVES = "your other fifteen pictures"
AGREEING = ("simulator, other rooms", "a real NAO, eight places", "a real NAO, a walk")
SIZES = {"160 x 120": 0.5, "320 x 240": 1.0, "640 x 480": 2.0}


@course_style()
def draw_sizes() -> Drawing:
    """Draw the settings' costs at other picture sizes, with the same pixels and with pixels in proportion."""
    figure = Figure(figsize=(8.6, 4.2))
    ax = figure.add_subplot()
    words = []
    for name, colour, shift in (("the same pixels", NOTHING, -0.2), ("in proportion", OURS, 0.2)):
        for at, size in enumerate(SIZES):
            means = np.array(recorded()[f"{size}, {name}"]["means"])
            best = means[SETTINGS.index(BEST)]
            across = at + shift + np.linspace(-0.15, 0.15, len(means))
            ax.plot(across, np.sort(means), "o", color=colour, alpha=0.45, ms=4)
            place = across[np.sort(means).searchsorted(best)]
            low, high = recorded()[f"{size}, {name}"]["the paper's best, 95 %"]
            ax.plot([place, place], [low, high], color="black", lw=1.5)
            ax.plot(place, best, "o", color=colour, ms=10, mec="black")
            words.append(
                f"{size}, {name}: {best:.2f}, 95 % from {low:.2f} to {high:.2f}, all from {means.min():.2f} to "
                f"{means.max():.2f}"
            )
    nothing = recorded()["320 x 240, the same pixels"]["nothing"]
    ax.axhline(nothing, color=GREY, ls=":", lw=1.8)
    ax.text(2.48, nothing * 1.04, "nothing", color=GREY, fontsize=10, ha="right")
    ax.set_xticks(range(len(SIZES)), list(SIZES))
    ax.set_yscale("log")
    ax.set_yticks(ticks := [0.8, 1, 1.5, 2, 3, 4, 6, 9], [str(each) for each in ticks])
    ax.minorticks_off()
    ax.set(xlabel="size of the pictures (px)", ylabel="mean cost (logarithmic)", xlim=(-0.5, 2.5))
    keys = [
        Line2D([], [], ls="", marker="o", ms=5, color=NOTHING, label="27 settings, same px"),
        Line2D([], [], ls="", marker="o", ms=5, color=OURS, label="proportional to the size"),
        Line2D(
            [],
            [],
            ls="",
            marker="o",
            ms=10,
            color="white",
            mec="black",
            label="the paper's 120, 5, 40, with 95 %",
        ),
    ]
    legend_below(figure, keys)
    return Drawing(
        figure,
        f"Mean costs of the 27 settings by the pictures' size, lowest first; large the paper's 120, 5, 40. "
        f"{'; '.join(words)}. Nothing costs {nothing:.2f}.",
    )
