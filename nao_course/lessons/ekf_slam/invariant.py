"""Compare the invariant filter with the student's filter and with first-estimates Jacobians."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from nao_course.lessons.ekf_slam.consistency import COLOURS, NOISY, NOMINAL, FilterTrace, compare, mean_nees
from nao_course.metrics import band
from nao_course.plotting import Drawing, course_style
from nao_course.plotting.legends import legend_below
from nao_course.sim.drives import Function, Sigmas
from nao_course.widgets.derivation_sheet import DerivationSheet, derivation

INVARIANT = "invariant filter"
HARSH = Sigmas(0.02, 0.01, float(np.radians(4.0)), float(np.radians(6.5)), 0.02)
LEVELS: Mapping[str, Sigmas] = {"nominal": NOMINAL, "noisy": NOISY, "harsh": HARSH}
Traces = Mapping[str, Sequence[FilterTrace]]


def group_sheet() -> DerivationSheet:
    """Return a sheet for the heading's columns of T and H T (equation 7.11), beside the columns of the robot's x.

    V of equation 7.10 is left out, because it is the identity at an error of 0, and its derivative is multiplied by 0.

    Returns
    -------
    DerivationSheet
        Its rows are the true pose, a true landmark, and the bearing and range between them.
    """
    from sympy import Integer, Matrix, atan2, cos, sin, sqrt, symbols  # SymPy takes long to import

    x, y, theta, l_x, l_y = symbols("x y theta l_x l_y")
    errors = xi_x, xi_y, xi_theta, xi_lx, xi_ly = symbols("xi_x xi_y xi_theta xi_lx xi_ly")
    turn = Matrix([[cos(xi_theta), -sin(xi_theta)], [sin(xi_theta), cos(xi_theta)]])
    robot = turn * Matrix([x, y]) + Matrix([xi_x, xi_y])
    landmark = turn * Matrix([l_x, l_y]) + Matrix([xi_lx, xi_ly])
    dx, dy = landmark - robot
    heading = theta + xi_theta
    about_robot = "everything rotates about the origin of the map, not about the robot"
    slips = {(0, 0): y - l_y, (1, 0): l_x - x, (3, 0): y - l_y, (4, 0): l_x - x}
    return derivation(
        "What an error on the group changes",
        Matrix([*robot, heading, *landmark, atan2(dy, dx) - heading, sqrt(dx**2 + dy**2)]),
        by=[xi_theta, xi_x],
        zero=errors,
        rows=("true x", "true y", "true theta", "true l_x", "true l_y", "bearing", "range"),
        known=[["", 1], ["", 0], ["", 0], ["", 0], ["", 0], ["", "dy/r^2"], ["", "-dx/r"]],
        short={"dx": l_x - x, "dy": l_y - y, "r": sqrt((l_x - x) ** 2 + (l_y - y) ** 2)},
        slips={at: {about_robot: wrong} for at, wrong in slips.items()}
        | {
            (5, 0): {
                "that is what the heading changes, but dx and dy rotate, too": Integer(-1),
                "that is what the rotation of dx and dy changes, but the heading is subtracted": Integer(1),
            }
        },
    )


def compare_invariant(
    functions: tuple[Function, Function, Function], invariant_update: Function, sigmas: Sigmas, runs: int
) -> dict[str, list[FilterTrace]]:
    """Run the student's filter, first estimates, and the invariant filter along the same drives."""
    predict, _, add_landmark = functions
    found = compare(*functions, sigmas=sigmas, runs=runs, variants=("your filter", "first estimates"))
    own = compare(predict, invariant_update, add_landmark, sigmas, runs, variants=("your filter",))
    return found | {INVARIANT: own["your filter"]}


@course_style()
def draw_invariant(
    predict: Function,
    update_landmarks: Function,
    add_landmark: Function,
    invariant_update: Function,
    runs: int = 20,
) -> Drawing:
    """Draw the NEES of three filters over time at three levels of noise.

    Parameters
    ----------
    predict, update_landmarks, add_landmark, invariant_update : callable
        The student's functions.
    runs : int
        Number of drives at each level; 20 take about ten seconds.

    Returns
    -------
    Drawing
        One plot for each level of noise, with the 95 % band; the text contains every mean.

    Raises
    ------
    ValueError
        If a function returns something of another shape.
    """
    functions = (predict, update_landmarks, add_landmark)
    found = {
        name: compare_invariant(functions, invariant_update, each, runs) for name, each in LEVELS.items()
    }
    return _draw_levels(found, runs)


def _draw_levels(found: Mapping[str, Traces], runs: int) -> Drawing:
    """Draw a plot for each level of noise."""
    low, high = band(3, runs)
    figure = Figure(figsize=(9.6, 4.2))
    words = []
    for ax, (level, traces) in zip(figure.subplots(1, len(found), sharey=True), found.items(), strict=True):
        ax.axhspan(low, high, color="#e3e5e8", zorder=1, label="95 % band")
        for (name, each), line in zip(traces.items(), ("-", "--", "-"), strict=True):
            nees = np.mean([trace.nees for trace in each], axis=0)
            colour = COLOURS.get(name, "#c84b00")
            ax.plot(np.arange(1, len(nees) + 1), nees, line, color=colour, lw=1.8, zorder=3, label=name)
        means = ", ".join(f"{name} {mean_nees(each):.2f}" for name, each in traces.items())
        words.append(f"{level}: {means}")
        turn, bearing = np.degrees([LEVELS[level].turn, LEVELS[level].bearing])
        ax.set(yscale="log", xlabel="step", title=f"turn {turn:.2g}°, bearing {bearing:.2g}°")
        ax.set_yticks(ticks := [1, 2, 3, 5, 10, 20, 50, 100], labels=[str(tick) for tick in ticks])
        ax.minorticks_off()
    first = figure.axes[0]
    first.set_ylabel(f"pose NEES, mean of {runs} drives")
    legend_below(figure, first.get_legend_handles_labels()[0], columns=4)
    return Drawing(
        figure,
        f"Pose NEES by step at three levels of noise, mean of {runs} drives; for a consistent filter it lies between "
        f"{low:.2f} and {high:.2f}. Mean over all steps: {'; '.join(words)}.",
    )
