"""Figures of a filter's consistency: NEES and NIS with their bands."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray
from nao_course.lessons.localization.drives import Trace
from nao_course.metrics import band
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.style import GREY

BAND = "#e3e5e8"
OUTSIDE = "#b3261e"


def median_band(degrees: int, runs: npt.ArrayLike, probability: float = 0.95) -> FloatArray:
    """Return the limits (2, N) between which the median of `runs` (N,) chi-square values lies with this probability.

    The remaining probability is split equally between both sides. The cumulative probability of the median of n values
    follows a beta distribution, whatever distribution the values have.
    """
    from scipy.special import betainccinv, chdtri  # SciPy's stats would take long to import

    half = (np.asarray(runs) + 1) / 2
    parts = np.array([[(1 - probability) / 2], [(1 + probability) / 2]])
    return np.asarray(chdtri(degrees, betainccinv(half, half, parts)))


def nees_by_step(traces: Sequence[Trace]) -> FloatArray:
    """Return the mean NEES over the drives for each step, (M + 1,)."""
    return np.asarray(np.mean([trace.nees for trace in traces], axis=0))


def nis_by_step(traces: Sequence[Trace]) -> tuple[npt.NDArray[np.int_], FloatArray, npt.NDArray[np.int_]]:
    """Return the steps with measurements, the mean NIS of each over all drives, and the number of measurements."""
    steps = np.concatenate([trace.steps for trace in traces])
    nis = np.concatenate([trace.nis for trace in traces])
    there, inverse, counts = np.unique(steps, return_inverse=True, return_counts=True)
    return there, np.bincount(inverse, weights=nis) / counts, counts


@course_style()
def draw_bands(traces: Sequence[Trace]) -> Drawing:
    """Draw NEES and NIS over many drives, and NEES over the time of each single drive.

    Parameters
    ----------
    traces : sequence of Trace
        Of independent drives.

    Returns
    -------
    Drawing
        Three plots with 95 % bands; the text states the fraction inside each band.
    """
    runs = len(traces)
    figure = Figure(figsize=(11.0, 4.0))
    left, middle, right = figure.subplots(1, 3)
    nees = nees_by_step(traces)
    low, high = band(3, runs)
    _plot_band(left, np.arange(len(nees)), nees, np.full(len(nees), low), np.full(len(nees), high), 3.0)
    left.set(
        title=f"NEES of each step,\nmean of {runs} drives", xlabel="step", ylabel="NEES", ylim=(2.0, 4.0)
    )
    steps, nis, counts = nis_by_step(traces)
    limits = np.array([band(2, int(count)) for count in counts])
    _plot_band(middle, steps, nis, limits[:, 0], limits[:, 1], 2.0)
    middle.set(
        title="NIS of each step,\nmean of its measurements", xlabel="step", ylabel="NIS", ylim=(1.0, 3.4)
    )
    means = np.sort([trace.nees[1:].mean() for trace in traces])
    naive = band(3, len(nees) - 1)
    _plot_single(right, means, naive)
    right.set(
        title="NEES of each drive,\nmean of its own steps", xlabel="drive, sorted by its mean", ylabel="NEES"
    )
    within = float(np.mean((low <= nees) & (nees <= high)))
    within_nis = float(np.mean((limits[:, 0] <= nis) & (nis <= limits[:, 1])))
    alone = float(np.mean((naive[0] <= means) & (means <= naive[1])))
    return Drawing(
        figure,
        f"Left: the mean NEES of {runs} drives, step by step: {nees.mean():.2f} in all; {within:.0%} of "
        "the steps lie in the band "
        f"from {low:.2f} to {high:.2f}. Middle: the mean NIS: {np.average(nis, weights=counts):.2f} in "
        f"all, {within_nis:.0%} of the steps in their "
        f"bands. Right: the mean NEES of each single drive over its steps, from {means[0]:.1f} to "
        f"{means[-1]:.1f}; only {alone:.0%} of the "
        f"drives lie in the band from {naive[0]:.2f} to {naive[1]:.2f} that would hold if steps were "
        "independent.",
    )


def inside_naive_band(traces: Sequence[Trace]) -> float:
    """Return the fraction of drives whose mean NEES is in the band for independent steps."""
    low, high = band(3, len(traces[0].nees) - 1)
    return float(np.mean([low <= trace.nees[1:].mean() <= high for trace in traces]))


def _plot_band(
    ax: Axes, x: npt.ArrayLike, values: FloatArray, low: FloatArray, high: FloatArray, ideal: float
) -> None:
    steps = np.asarray(x)
    ax.fill_between(steps, low, high, color=BAND, zorder=1, label="95 % band")
    ax.axhline(ideal, color=GREY, lw=1, ls="--", zorder=2, label="ideal")
    ax.plot(steps, values, color=STYLES["ekf"].colour, lw=1.4, marker=".", ms=5, zorder=3, label="yours")
    ax.legend(loc="upper right", fontsize=9)


def _plot_single(ax: Axes, means: FloatArray, naive: tuple[float, float]) -> None:
    numbers = np.arange(1, len(means) + 1)
    ax.axhspan(*naive, color=BAND, zorder=1, label="95 % band for independent steps")
    ax.axhline(3.0, color=GREY, lw=1, ls="--", zorder=2)
    out = (means < naive[0]) | (means > naive[1])
    ax.plot(numbers[~out], means[~out], ".", color=STYLES["ekf"].colour, ms=6, zorder=3, label="inside")
    ax.plot(numbers[out], means[out], "x", color=OUTSIDE, ms=5, mew=1.3, zorder=3, label="outside")
    ax.legend(loc="upper left", fontsize=9)
