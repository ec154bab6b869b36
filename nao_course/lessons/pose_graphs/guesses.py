"""How often Gauss-Newton finds the optimum from initial estimates with random errors of positions or headings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray
from nao_course.lessons.pose_graphs.figures import GaussNewton
from nao_course.lessons.pose_graphs.worlds import building, disturbed
from nao_course.plotting import STYLES, Drawing, course_style

POSITIONS = (0.1, 1.0, 10.0, 100.0, 1000.0)  # m
HEADINGS = (10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0)  # degrees
TRIES = 12
STEPS = 15


def arrivals(
    gauss_newton: GaussNewton,
    positions: Sequence[float] = POSITIONS,
    headings: Sequence[float] = HEADINGS,
    tries: int = TRIES,
) -> Mapping[str, FloatArray]:
    """Return the part of the tries in which Gauss-Newton finds the optimum, from initial estimates with random errors.

    Parameters
    ----------
    gauss_newton : callable
        The student's.
    positions : sequence of float
        Standard deviations of each pose's x and y, m; headings are the true ones.
    headings : sequence of float
        Standard deviations of each pose's heading, degrees; positions are the true ones.
    tries : int
        Initial estimates for each.

    Returns
    -------
    mapping of str to ndarray
        "positions" and "headings": parts between 0 and 1.
    """
    world = building(1, 100)
    lowest = float(gauss_newton(world.graph, world.truth.copy(), 6)[1][-1])

    def part(position: float, heading: float) -> float:
        arrived = 0
        for number in range(tries):
            guess = disturbed(world, position, np.radians(heading), np.random.default_rng(number))
            with np.errstate(all="ignore"):
                arrived += bool(gauss_newton(world.graph, guess, STEPS)[1][-1] < 1.01 * lowest)
        return arrived / tries

    return {
        "positions": np.array([part(each, 0.0) for each in positions]),
        "headings": np.array([part(0.0, each) for each in headings]),
    }


def half_of_them(headings: Sequence[float], parts: FloatArray) -> float:
    """Return the heading error (degrees) at which half of the tries fail, by interpolation; NaN if there is none."""
    below = np.flatnonzero(np.asarray(parts) < 0.5)
    if not len(below) or below[0] == 0:
        return float("nan")
    k = int(below[0])
    high, low = parts[k - 1], parts[k]
    return float(headings[k - 1] + (high - 0.5) / (high - low) * (headings[k] - headings[k - 1]))


@course_style()
def draw_arrivals(found: Mapping[str, FloatArray]) -> Drawing:
    """Draw how often Gauss-Newton finds the optimum, by the errors of positions and of headings."""
    graph = STYLES["graph"]
    half = half_of_them(HEADINGS, found["headings"])
    figure = Figure(figsize=(10.0, 3.8))
    left, right = figure.subplots(1, 2, sharey=True)
    for ax, xs, key, label in (
        (left, POSITIONS, "positions", "error of each position (m)"),
        (right, HEADINGS, "headings", "error of each heading (degrees)"),
    ):
        ax.plot(xs, 100 * found[key], color=graph.colour, marker=graph.marker, lw=2, ms=7, mec="white")
        ax.set(xlabel=f"{label}, standard deviation", ylim=(-4, 104))
        ax.grid(alpha=0.3)
    left.set(xscale="log", ylabel="finds the optimum (%)", title="random errors of the positions")
    right.set(title="random errors of the headings")
    if np.isfinite(half):
        right.axvline(half, color=STYLES["truth"].colour, lw=1, ls=":")
        right.annotate(f"half at {half:.0f}°", (half, 50), xytext=(6, 6), textcoords="offset points")
    said = [
        f"{100 * part:.0f} % at {each:g} degrees"
        for each, part in zip(HEADINGS, found["headings"], strict=True)
    ]
    away = ", ".join(f"{100 * part:.0f}" for part in found["positions"])
    return Drawing(
        figure,
        "How often Gauss-Newton finds the optimum. "
        f"With positions off by {POSITIONS[0]:g} to {POSITIONS[-1]:g} m: {away} %. "
        f"With headings off: {', '.join(said)}.",
    )
