"""Figures of the 27 mean costs: beside the paper's, with intervals, and how often each setting is best."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.geometry import FloatArray
from nao_course.lessons.experiments.paper_table import BETAS, GAPS, LENGTHS, PAPER_MEANS, Setting, say_setting
from nao_course.lessons.experiments.resampling import (
    CostTable,
    as_table,
    called_different,
    optimism,
    placebo,
    rank_correlation,
    shares_won,
)
from nao_course.lessons.experiments.scenes import nothing_costs, search_scenes, simulated_scenes
from nao_course.plotting import STYLES, Drawing, Guess, Table, course_style, with_guess
from nao_course.plotting import table as make_table
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import GREY

Function = Callable[..., Any]
OURS, THEIRS, NOTHING = STYLES["ekf"].colour, STYLES["graph"].colour, STYLES["odometry"].colour
PROBABILITY = 0.95
MOST_BARS = 9  # settings with a bar of their own in the figure of the winners


def interval_of(bootstrap_interval: Function, values: FloatArray) -> tuple[float, float]:
    """Return the 95 % interval of the values' mean from a student's function."""
    low, high = bootstrap_interval(np.array(values), PROBABILITY, np.random.default_rng(0))
    return float(low), float(high)


def best_settings(table: CostTable, rows: int = 6) -> Table:
    """Make a table of the settings with the lowest means, with the standard deviation of a single picture's cost."""
    return make_table(
        ("beta, gap, length", "mean", "sigma"),
        [
            (say_setting(key), f"{costs.mean():.3f}", f"{costs.std(ddof=1):.3f}")
            for key, costs in list(as_table(table).items())[:rows]
        ],
    )


def draw_payoff(grid_search: Function, bootstrap_interval: Function) -> Drawing:
    """Draw the lesson's figure: the paper's landscape, the student's, and the student's intervals."""
    return draw_landscape(search_scenes(grid_search, simulated_scenes()), bootstrap_interval)


@course_style()
def draw_landscape(table: CostTable, bootstrap_interval: Function) -> Drawing:
    """Draw the mean costs of 27 settings beside the paper's, and each one's interval.

    Parameters
    ----------
    table : mapping
        Costs (30,) of the tuning scenes, by (beta, gap, length).
    bootstrap_interval : callable
        ``bootstrap_interval(values, probability, rng)`` returns (low, high).
    """
    costs = as_table(table)
    means = {key: float(each.mean()) for key, each in costs.items()}
    nothing = float(nothing_costs(simulated_scenes()).mean())
    figure = Figure(figsize=(9.9, 6.8))
    halves: Any = figure.subfigures(1, 2, width_ratios=(1.45, 1))
    tiles, right = halves
    rows = tiles.subfigures(2, 1)
    for part, name, values in ((rows[0], "the paper's Table A.1", PAPER_MEANS), (rows[1], "yours", means)):
        scale = f"colours from {min(values.values()):.1f} to {max(values.values()):.1f}"
        part.suptitle(f"Mean cost, {name} ({scale})", x=0.02, ha="left", fontsize=11, fontweight="bold")
        _plot_tiles(part.subplots(1, 3, sharey=True), values)
    tied = _plot_intervals(right.subplots(), costs, bootstrap_interval, nothing)
    best = next(iter(costs))
    return Drawing(
        figure,
        f"Mean costs of 27 settings. The paper's are from {min(PAPER_MEANS.values()):.2f} to "
        f"{max(PAPER_MEANS.values()):.2f}, yours from {means[best]:.2f} at {say_setting(best)} to "
        f"{max(means.values()):.2f}; nothing costs {nothing:.2f}. Of {tied} of the other {len(costs) - 1} the 95 % "
        "interval of the difference from your best contains 0.",
    )


def _plot_tiles(axes: Sequence[Axes], means: Mapping[Setting, float]) -> None:
    """Draw nine means by beta and gap for each length, with a frame around the best setting."""
    low, high = min(means.values()), max(means.values())
    best = min(means, key=lambda key: means[key])
    for ax, length in zip(axes, LENGTHS, strict=True):
        values = np.array([[means[beta, gap, length] for beta in BETAS] for gap in GAPS])
        ax.imshow(values, cmap="cividis_r", vmin=low, vmax=high, aspect="auto")
        for (row, column), value in np.ndenumerate(values):
            dark = (value - low) / (high - low) > 0.55
            ax.text(column, row, f"{value:.2f}", ha="center", va="center", color="white" if dark else "black")
        if best[2] == length:
            at = (BETAS.index(best[0]), GAPS.index(best[1]))
            ax.plot(*at, "s", ms=30, mfc="none", mec=NOTHING, mew=2.5)
        ax.set_xticks(range(3), [str(each) for each in BETAS])
        ax.set_yticks(range(3), [f"{each} px" for each in GAPS])
        ax.set_title(f"length {length} px", fontsize=10, fontweight="normal", loc="center")
        ax.set_xlabel("beta")
        ax.tick_params(length=0)
        ax.spines[:].set_visible(False)
    axes[0].set_ylabel("gap")


def _plot_intervals(ax: Axes, costs: CostTable, bootstrap_interval: Function, nothing: float) -> int:
    """Draw means with intervals, the best at the top; return the number of others that may be equally good."""
    best = next(iter(costs))
    tied = 0
    for row, (key, each) in enumerate(costs.items()):
        low, high = interval_of(bootstrap_interval, each)
        apart = interval_of(bootstrap_interval, each - costs[best])
        same = key == best or apart[0] <= 0 <= apart[1]
        tied += same and key != best
        colour = OURS if same else GREY
        ax.plot([low, high], [row, row], color=colour, lw=2, alpha=0.55)
        ax.plot(each.mean(), row, "o", color=colour, mfc=colour if same else "white", ms=6)
    ax.plot([nothing, nothing], [-0.6, len(costs)], color=NOTHING, ls=":", lw=1.8)
    ax.text(nothing, -1.1, "reporting nothing", color=NOTHING, ha="center", fontsize=10)
    ax.set_yticks(range(len(costs)), [say_setting(key) for key in costs], fontsize=10)
    ax.set(xlabel="mean cost, with its 95 % interval", ylim=(len(costs) - 0.4, -1.6))
    ax.set_title("filled: paired difference\nfrom the best may be 0", fontsize=10, fontweight="normal")
    ax.tick_params(axis="y", length=0)
    return tied


@course_style()
def draw_beside_paper(table: CostTable) -> Drawing:
    """Draw each setting's mean against the paper's, and each scatter against the paper's sigma."""
    from nao_course.lessons.experiments.paper_table import PAPER_SIGMAS

    costs = as_table(table)
    means = {key: float(each.mean()) for key, each in costs.items()}
    sigmas = {key: float(each.std(ddof=1)) for key, each in costs.items()}
    errors = {key: sigma / np.sqrt(len(costs[key])) for key, sigma in sigmas.items()}
    markers = dict(zip(LENGTHS, ("o", "s", "^"), strict=True))
    figure = Figure(figsize=(9.6, 4.2))
    left, right = figure.subplots(1, 2)
    for key, mean in means.items():
        left.plot(PAPER_MEANS[key], mean, markers[key[2]], color=OURS, ms=7, mec="white")
        right.plot(PAPER_MEANS[key], PAPER_SIGMAS[key], "D", color=THEIRS, ms=5)
        right.plot(mean, sigmas[key], "P", color=OURS, ms=7)
        right.plot(mean, errors[key], "P", color=OURS, ms=7, mfc="white")
    rho = rank_correlation(PAPER_MEANS, means)
    left.set(xlabel="mean cost in the paper", ylabel="your mean cost")
    left.set_title(f"rank correlation {rho:.2f}", fontsize=11)
    right.set(xlabel="mean cost", ylabel="sigma")
    right.set_title("what is the paper's sigma?", fontsize=11)
    left.legend(
        handles=[
            Line2D([], [], color=OURS, marker=markers[each], ls="", label=f"length {each} px")
            for each in LENGTHS
        ],
        loc="upper left",
    )
    right.legend(
        handles=[
            Line2D([], [], color=THEIRS, marker="D", ls="", label="the paper's sigma"),
            Line2D([], [], color=OURS, marker="P", ls="", label="yours, of a picture"),
            Line2D([], [], color=OURS, marker="P", mfc="white", ls="", label="yours, of the mean"),
        ]
    )
    return Drawing(
        figure,
        f"Left: your 27 mean costs against the paper's, rank correlation {rho:.2f}. Right: sigma against mean; the "
        f"paper's is from {min(PAPER_SIGMAS.values()):.2f} to {max(PAPER_SIGMAS.values()):.2f}, yours of a single "
        f"picture from {min(sigmas.values()):.2f} to {max(sigmas.values()):.2f}, of the mean from "
        f"{min(errors.values()):.2f} to {max(errors.values()):.2f}.",
    )


@course_style()
def draw_winners(table: CostTable) -> Drawing:
    """Draw how often each setting is the best when the scenes are resampled, and a placebo of the filled points.

    The placebo are tables in which all settings are equal: in how many settings is the paired difference from the best
    called different from 0?
    """
    costs = as_table(table)
    shares = shares_won(costs)
    names = sorted(shares, key=lambda key: -shares[key])
    shown = names[:MOST_BARS]
    bars = {say_setting(key): 100 * shares[key] for key in shown}
    if len(names) > len(shown):
        bars[f"{len(names) - len(shown)} others"] = 100 * sum(shares[key] for key in names[MOST_BARS:])
    figure = Figure(figsize=(10.4, 3.9))
    ax, beside = figure.subplots(1, 2, width_ratios=(1.3, 1))
    ax.barh(range(len(bars)), list(bars.values()), color=OURS)
    ax.set_yticks(range(len(bars)), list(bars), fontsize=10)
    ax.set(xlabel="lowest mean in % of the draws", ylim=(len(bars) - 0.4, -0.6))
    ax.set_title("which setting is the best?", fontsize=11)
    ax.tick_params(axis="y", length=0)
    found = placebo(costs)
    own = called_different(np.array(list(costs.values())), np.random.default_rng(0))
    beside.hist(found, np.arange(-0.5, len(names)).tolist(), color=GREY, label="27 equal settings")
    beside.axvline(own, color=OURS, lw=2, label=f"your table: {own}")
    beside.set(
        xlabel=f"called different from the best, of {len(names) - 1}", ylabel="number of placebo tables"
    )
    beside.set_title(f"placebo: {found.mean():.0f} on average", fontsize=11)
    beside.legend()
    low, high = np.quantile(found, (0.1, 0.9))
    said = "; ".join(f"{say_setting(key)}: {100 * shares[key]:.0f} %" for key in names[:6])
    never = sum(shares[key] == 0 for key in names)
    return Drawing(
        figure,
        f"How often each of {len(names)} settings has the lowest mean cost when the scenes are drawn again. {said}. "
        f"{never} never have it. In {len(found)} placebo tables of equal settings {found.mean():.0f} of "
        f"{len(names) - 1} are called different from the best on average, 10 % to 90 %: {low:.0f} to {high:.0f}; in "
        f"your table {own}.",
    )


@course_style()
def draw_optimism(table: CostTable, guess: Guess | None = None) -> Drawing:
    """Draw the cost of the best setting of one half of the scenes, on that half and on the other half.

    A `guess` of how much higher the second cost is on average is marked.
    """
    found = optimism(as_table(table))
    figure = Figure(figsize=(8.6, 3.6))
    ax = figure.add_subplot()
    bins = np.linspace(
        min(found.promised.min(), found.kept.min()), max(found.promised.max(), found.kept.max()), 36
    )
    for values, colour, name in (
        (found.promised, OURS, "on the half used to choose it"),
        (found.kept, NOTHING, "on the other half"),
    ):
        ax.hist(values, bins.tolist(), color=colour, alpha=0.55, label=f"{name}: {values.mean():.2f}")
        ax.axvline(values.mean(), color=colour, lw=2)
    ax.axvline(
        found.any_setting, color=GREY, ls=":", lw=2, label=f"mean of all settings: {found.any_setting:.2f}"
    )
    ax.set(xlabel="mean cost of the chosen setting on fifteen scenes", ylabel="number of divisions")
    legend_below(figure, ax.get_legend_handles_labels()[0])
    drawn = Drawing(
        figure,
        f"The scenes were divided into halves {len(found.promised)} times. The setting that is best on one half costs "
        f"{found.promised.mean():.2f} there on average and {found.kept.mean():.2f} on the other half; the mean of all "
        f"settings is {found.any_setting:.2f}.",
    )
    promised = float(found.promised.mean())
    return with_guess(drawn, guess, "x", place=lambda more: promised + more) if guess else drawn


def broken_promise(table: CostTable) -> float:
    """Return the mean increase in cost of the best setting of one half when it is used on the other half."""
    found = optimism(as_table(table))
    return float(found.kept.mean() - found.promised.mean())
