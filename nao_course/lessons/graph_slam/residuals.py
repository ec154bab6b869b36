"""The drive of lesson 08 by its residuals: dead reckoning and a filter leave some that a graph does not."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course._internal.counts import say_count
from nao_course.geometry import FloatArray
from nao_course.lessons.graph_slam.drives import Constraint, LinearDrive, field_drive, odometry
from nao_course.lessons.graph_slam.figures import map_keys, plot_graph_map
from nao_course.lessons.graph_slam.matrices import plot_matrix, sign_keys
from nao_course.lessons.graph_slam.systems import Builders, Function, map_error, solve_axes
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import GREY, style_of

_UNKNOWN = 1e6  # m^2: the variance of a landmark before its first measurement
_KINDS = {"start": "truth", "motion": "odometry", "measurement": "graph"}


def dead_reckoning(drive: LinearDrive) -> FloatArray:
    """Add up the motions, and place each landmark where it was first measured: positions (N, 2) in metres."""
    path = odometry(drive.constraints)
    positions = np.vstack([path, np.full((len(drive.landmarks), 2), np.nan)])
    for each in drive.constraints:
        if each.kind == "measurement" and np.isnan(positions[each.second, 0]):
            positions[each.second] = positions[each.first] + each.value
    return positions


def filtered(drive: LinearDrive) -> FloatArray:
    """Run a Kalman filter over a drive, one constraint after the other.

    Its state is the current pose and all landmarks, as in lesson 07. Without a heading it is linear.

    Returns
    -------
    ndarray, shape (N, 2)
        Each pose as it was estimated when the robot left it, and the landmarks at the end, in metres.
    """
    marks = len(drive.landmarks)
    state = np.zeros((1 + marks, 2))  # the current pose, and the landmarks
    covariance = np.diag([0.0, *np.full(marks, _UNKNOWN)])  # of each axis: both have the same
    path: list[FloatArray] = []
    for each in drive.constraints:
        if each.kind == "measurement":
            row = np.zeros(1 + marks)
            row[[0, 1 + each.second - len(drive.path)]] = -1.0, 1.0
            gain = covariance @ row / (row @ covariance @ row + each.epsilon)
            state = state + np.outer(gain, each.value - row @ state)
            covariance = covariance - np.outer(gain, row @ covariance)
            continue
        if each.kind == "motion":
            path.append(state[0].copy())
        state[0] += each.value
        covariance[0, 0] += each.epsilon
    return np.vstack([*path, state])


def residuals(drive: LinearDrive, positions: FloatArray) -> FloatArray:
    """Return the residual of each constraint in standard deviations, (C,), the larger one of both axes."""
    return np.asarray(np.abs(_scaled(drive, positions)).max(axis=1))


def sum_of_squares(drive: LinearDrive, positions: FloatArray) -> float:
    """Return the sum of all squared residuals of both axes, each divided by its variance."""
    return float((_scaled(drive, positions) ** 2).sum())


def _scaled(drive: LinearDrive, positions: FloatArray) -> FloatArray:
    """Return the residuals in standard deviations, (C, 2)."""
    missed = []
    for each in drive.constraints:
        before = 0.0 if each.kind == "start" else positions[each.first]
        missed.append((positions[each.second] - before - each.value) / np.sqrt(each.epsilon))
    return np.array(missed)


def path_error(drive: LinearDrive, positions: FloatArray) -> float:
    """Return the root mean square distance of the poses from the true ones, m, without poses that are NaN."""
    away = positions[: len(drive.path)] - drive.path
    return float(np.sqrt(np.nanmean((away**2).sum(axis=1))))


@course_style()
def draw_residuals(**maps: FloatArray) -> Drawing:
    """Draw maps of the drive over the half field, and below each one its residuals.

    Parameters
    ----------
    **maps : ndarray, shape (N, 2)
        Positions of all variables by the name of the method, with _ for a space.

    Returns
    -------
    Drawing
        A column for each method.
    """
    drive, words = field_drive(), []
    figure = Figure(figsize=(4.9 * len(maps), 7.4))
    axes = figure.subplots(2, len(maps), height_ratios=(1.5, 1.0), squeeze=False)
    for (name, positions), (above, below) in zip(maps.items(), axes.T, strict=True):
        plot_graph_map(drive, drive.constraints, positions, above)
        said = _say_errors(drive, positions)
        above.set_title(f"{name.replace('_', ' ')}: {said}", fontsize=10)
        for stop in _without_landmark(drive):
            label = f"$x_{{{stop}}}$"
            line = {"arrowstyle": "-", "lw": 0.7, "shrinkA": 0}
            above.annotate(
                label,
                positions[stop],
                (-32, -14),
                textcoords="offset points",
                fontsize=11,
                zorder=8,
                arrowprops=line,
            )
            true = STYLES["truth"].colour
            above.plot(*np.array([positions[stop], drive.path[stop]]).T, ":", color=true, lw=1.3, zorder=7)
            above.plot(*drive.path[stop], "o", mfc="none", mec=true, mew=1.4, ms=6, zorder=7)
        missed = residuals(drive, positions)
        _plot_residuals(drive.constraints, missed, below)
        total = f"sum of squares {sum_of_squares(drive, positions):.0f}, largest residual {missed.max():.1f} sigma"
        below.set_title(total, fontsize=10)
        words.append(f"{name.replace('_', ' ')}: {said}, {total}")
    for ax in axes[0, 1:]:
        ax.set(ylabel="")
    stops = ", ".join(f"$x_{{{stop}}}$" for stop in _without_landmark(drive))
    place = Line2D([], [], color=STYLES["truth"].colour, marker="o", mfc="none", ms=6, ls=":")
    place.set_label(f"true place of {stops}")
    legend_below(figure, [*map_keys("estimated"), place], columns=3)
    return Drawing(figure, f"Maps of one drive, and the residuals of its constraints. {'; '.join(words)}.")


def _without_landmark(drive: LinearDrive) -> list[int]:
    """Return the stops from which no landmark was measured."""
    measured = {each.first for each in drive.constraints if each.kind == "measurement"}
    return [stop for stop in range(len(drive.path)) if stop not in measured]


def _say_errors(drive: LinearDrive, positions: FloatArray) -> str:
    error = map_error(drive, positions)
    marks = "no landmark" if np.isnan(error) else f"map by {100 * error:.0f} cm"
    return f"path off by {100 * path_error(drive, positions):.0f} cm, {marks}"


def _plot_residuals(constraints: Sequence[Constraint], missed: FloatArray, ax: Axes) -> None:
    """Draw a bar for each constraint, in the order in which they arrived."""
    colours = [style_of(_KINDS[each.kind]).colour for each in constraints]
    ax.bar(np.arange(1, len(missed) + 1), missed, color=colours, width=0.8)
    ax.axhline(2.0, color=GREY, lw=1.0, ls="--")
    ax.set(xlabel="constraint", ylabel="residual (sigma)", ylim=(0.0, max(4.0, 1.08 * missed.max())))
    largest = int(np.argmax(missed))
    if missed[largest] < 1e-6:
        ax.text(0.5, 0.6, "all residuals are 0", transform=ax.transAxes, ha="center")
    else:
        ax.annotate(
            f"{largest + 1}",
            (largest + 1, missed[largest]),
            (0, 3),
            textcoords="offset points",
            ha="center",
            fontsize=9,
        )
    for kind in ("motion", "measurement"):
        ax.bar([0], [0], color=style_of(_KINDS[kind]).colour, label=kind)
    ax.legend(loc="upper left", fontsize=9)


@course_style()
def draw_drive(
    add_initial_position: Function | None = None,
    add_relative_motion: Function | None = None,
    add_relative_measurement: Function | None = None,
    solve: Function | None = None,
) -> Drawing:
    """Draw the drive over the half field by the functions that are finished so far.

    Parameters
    ----------
    add_initial_position, add_relative_motion, add_relative_measurement, solve : callable, optional
        The student's functions. Constraints whose function is missing are left out. Without `solve`, the course's
        solver is used.

    Returns
    -------
    Drawing
        The matrix of the x axis, the map, and the residuals of all constraints.
    """
    drive = field_drive()
    given = {
        "start": add_initial_position,
        "motion": add_relative_motion,
        "measurement": add_relative_measurement,
    }
    used = [each for each in drive.constraints if given[each.kind]]
    builders = Builders(*(each or _missing for each in given.values()))
    positions, omega = solve_axes(used, drive.size, builders, solve or _solve)
    placed = int(np.isfinite(positions[: len(drive.path), 0]).sum())
    figure = Figure(figsize=(13.2, 4.9))
    left, middle, right = figure.subplots(1, 3)
    plot_matrix(omega, left, len(drive.path))
    left.set_title(rf"your $\Omega$: {len(used)} of {len(drive.constraints)} constraints", fontsize=11)
    plot_graph_map(drive, used, positions, middle)
    said = _say_errors(drive, positions)
    middle.set_title(f"your map, {placed} of {len(drive.path)} stops:\n{said}", fontsize=10)
    missed = residuals(drive, positions)
    _plot_residuals(drive.constraints, np.nan_to_num(missed), right)
    said_residuals = f"{say_count(len(used), 'residual')}, the largest {np.nanmax(missed):.1f} sigma"
    right.set_title(said_residuals, fontsize=11)
    legend_below(figure, [*sign_keys(), *map_keys("estimated")], columns=4)
    return Drawing(
        figure,
        f"The matrix holds {len(used)} of {len(drive.constraints)} constraints. Your map has {placed} of "
        f"{len(drive.path)} stops: {said}; {said_residuals}.",
    )


def _solve(omega: FloatArray, xi: FloatArray) -> FloatArray:
    """Solve a system in place of the student's function, and raise ValueError if it is singular."""
    if np.linalg.matrix_rank(omega) < len(xi):
        raise ValueError("your Omega has no inverse here: check exercises 8.1 to 8.3")
    return np.asarray(np.linalg.solve(omega, xi))


def _missing(*given: object) -> None:
    """Raise NotImplementedError in place of a missing function."""
    raise NotImplementedError
