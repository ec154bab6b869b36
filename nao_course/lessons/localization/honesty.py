"""Figures of a filter's honesty: NEES and NIS with their bands, and covariances that stay covariances."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray
from nao_course.lessons.localization.drives import Trace, checked
from nao_course.metrics import band
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.style import GREY

BAND = "#e3e5e8"
OUTSIDE = "#b3261e"
UPDATES = 300  # of each point of the figure with the smallest eigenvalues
SIGMAS = 10.0 ** -np.arange(1, 9)  # rad and m, of bearing and range


def nees_by_step(traces: Sequence[Trace]) -> FloatArray:
    """Mean NEES over the drives, for each step: (M + 1,)."""
    return np.asarray(np.mean([trace.nees for trace in traces], axis=0))


def nis_by_step(traces: Sequence[Trace]) -> tuple[npt.NDArray[np.int_], FloatArray, npt.NDArray[np.int_]]:
    """Steps at which something is seen, the mean NIS there over all drives, and of how many measurements."""
    steps = np.concatenate([trace.steps for trace in traces])
    nis = np.concatenate([trace.nis for trace in traces])
    there, inverse, counts = np.unique(steps, return_inverse=True, return_counts=True)
    return there, np.bincount(inverse, weights=nis) / counts, counts


def draw_bands(traces: Sequence[Trace]) -> Drawing:
    """Draw NEES and NIS over many drives, and NEES over the time of each single drive.

    Parameters
    ----------
    traces : sequence of Trace
        Of independent drives.

    Returns
    -------
    Drawing
        Three plots with 95 % bands; the text says which part lies inside each.
    """
    runs = len(traces)
    with course_style():
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
            title="NIS of each step,\nmean of all it sees", xlabel="step", ylabel="NIS", ylim=(1.0, 3.4)
        )
        means = np.sort([trace.nees[1:].mean() for trace in traces])
        naive = band(3, len(nees) - 1)
        _plot_single(right, means, naive)
        right.set(
            title="NEES of each drive,\nmean of its own steps",
            xlabel="drive, in order of its mean",
            ylabel="NEES",
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
    """Which part of single drives has a mean NEES in the band that would hold if its steps were independent."""
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
    ax.axhspan(*naive, color=BAND, zorder=1, label="band, were steps independent")
    ax.axhline(3.0, color=GREY, lw=1, ls="--", zorder=2)
    out = (means < naive[0]) | (means > naive[1])
    ax.plot(numbers[~out], means[~out], ".", color=STYLES["ekf"].colour, ms=6, zorder=3, label="inside")
    ax.plot(numbers[out], means[out], "x", color=OUTSIDE, ms=5, mew=1.3, zorder=3, label="outside")
    ax.legend(loc="upper left", fontsize=9)


def smallest_eigenvalue(kalman_update: Callable[..., Any], sigma: float) -> float:
    """Update one pose's covariance again and again with exact measurements, and return its smallest eigenvalue ever.

    Parameters
    ----------
    kalman_update : callable
        The student's.
    sigma : float
        Of bearing (rad) and range (m).

    Returns
    -------
    float
        Of the symmetric part; a covariance has none below zero.
    """
    rng = np.random.default_rng(6)
    covariance, least = np.diag([0.4**2, 0.4**2, np.radians(15) ** 2]), np.inf
    noise = np.eye(2) * sigma**2
    for bearing, distance in zip(
        rng.uniform(-np.pi, np.pi, UPDATES), rng.uniform(0.5, 3.0, UPDATES), strict=True
    ):
        c, s = np.cos(bearing), np.sin(bearing)
        slopes = np.array([[s / distance, -c / distance, -1.0], [-c, -s, 0.0]])
        answer = kalman_update(np.zeros(3), covariance.copy(), np.zeros(2), slopes, noise.copy())
        covariance = checked(answer[1], (3, 3), "kalman_update: covariance")
        least = min(least, float(np.linalg.eigvalsh((covariance + covariance.T) / 2)[0]))
    return least


def draw_smallest_eigenvalue(kalman_update: Callable[..., Any]) -> Drawing:
    """Draw the smallest eigenvalue of a covariance after many updates, by how exact they are.

    Parameters
    ----------
    kalman_update : callable
        The student's.

    Returns
    -------
    Drawing
        The figure; its text says where the first negative one is.
    """
    with np.errstate(all="ignore"):
        values = np.array([smallest_eigenvalue(kalman_update, sigma) for sigma in SIGMAS])
    good = values > 0
    with course_style():
        figure = Figure(figsize=(7.4, 3.9))
        ax = figure.add_subplot()
        ax.loglog(SIGMAS[good], values[good], "o", color=STYLES["ekf"].colour, ms=7, label="yours: positive")
        if not good.all():
            ax.loglog(
                SIGMAS[~good],
                -values[~good],
                "x",
                color=OUTSIDE,
                ms=9,
                mew=2,
                label="yours: negative; its size",
            )
        ax.axvspan(0.01, 0.2, color=BAND, zorder=0, label="a NAO's bearings and ranges")
        ax.set(xlabel="standard deviation of bearing (rad) and range (m)", ylabel="smallest eigenvalue")
        ax.invert_xaxis()
        ax.legend(fontsize=9)
    first = SIGMAS[~good]
    said = (
        f"It becomes negative from a standard deviation of {first[0]:.0e} on."
        if len(first)
        else "All are positive."
    )
    return Drawing(
        figure, f"Smallest eigenvalue of a covariance after {UPDATES} updates, by how exact these are. {said}"
    )
