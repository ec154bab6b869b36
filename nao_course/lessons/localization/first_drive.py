"""The drive that the lesson begins with: a given filter that loses its robot, and the student's parts in its place."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray, Pose, rotation_2d, wrap_angle
from nao_course.lessons.localization.drives import (
    FIELD,
    KINDS,
    LANDMARKS,
    Trace,
    checked,
    follow,
    lap,
    linearised,
)
from nao_course.lessons.localization.figures import add_ellipse, ellipse_of
from nao_course.plotting import (
    STYLES,
    Drawing,
    course_style,
    plot_ellipse,
    plot_field,
    plot_landmarks,
    plot_pose,
)
from nao_course.plotting.halo import HALO
from nao_course.plotting.legends import legend_below, source_key
from nao_course.plotting.style import GREY

FIRST = 6  # seed of the drive
EVERY = 3  # steps between two ellipses on the map
ARROWS = (11, 20)  # steps at which an arrow shows the direction of the true path
LIMIT = 7.81  # a chi-square value with three degrees of freedom is below it with 95 %

Function = Callable[..., Any]


class BearingRecord(NamedTuple):
    """What the filter computed from one measurement: bearings in rad."""

    expected: float
    measured: float
    innovation: float


class GivenFilter:
    """A localisation filter whose `innovation` can be replaced by the student's.

    `records` has a `BearingRecord` for each measurement so far.
    """

    def __init__(self, innovation: Function | None = None) -> None:
        """Begin without a measurement."""
        self._innovation = innovation or _given_innovation
        self.records: list[BearingRecord] = []

    def localize(
        self,
        pose: FloatArray,
        covariance: FloatArray,
        measured: FloatArray,
        landmark: FloatArray,
        noise: FloatArray,
    ) -> tuple[FloatArray, FloatArray]:
        """Return pose and covariance after one measurement of a known landmark."""
        expected, jacobian = linearised(pose, landmark)
        difference = checked(self._innovation(expected.copy(), measured.copy()), (2,), "innovation")
        self.records.append(BearingRecord(expected[0], measured[0], difference[0]))
        new, after = _update_by_information(pose, covariance, difference, jacobian, noise)
        new[2] = wrap_angle(new[2])
        return new, after


def _given_innovation(expected: FloatArray, measured: FloatArray) -> FloatArray:
    return measured - expected


def _update_by_information(
    mean: FloatArray, covariance: FloatArray, difference: FloatArray, jacobian: FloatArray, noise: FloatArray
) -> tuple[FloatArray, FloatArray]:
    added = np.linalg.solve(noise, jacobian).T
    precision = np.linalg.inv(covariance) + added @ jacobian
    return np.asarray(mean + np.linalg.solve(precision, added @ difference)), np.asarray(
        np.linalg.inv(precision)
    )


def _move(pose: FloatArray, control: FloatArray) -> FloatArray:
    return (Pose.from_array(pose) @ Pose(float(control[0]), 0.0, float(control[1]))).as_array()


def _move_covariance(
    covariance: FloatArray, pose: FloatArray, control: FloatArray, noise: FloatArray
) -> FloatArray:
    """Return the covariance after a command; `noise` is in the robot frame."""
    turned, swung = np.eye(3), np.eye(3)
    turned[:2, :2] = rotation_2d(pose[2])
    swung[:2, 2] = control[0] * turned[:2, 1]
    parts = np.stack([covariance, noise])
    return np.asarray(np.einsum("kij,kjl,kml->im", (swung, turned), parts, (swung, turned)))


def run_first_drive(
    innovation: Function | None = None, localize: Function | None = None
) -> tuple[Trace, list[BearingRecord]]:
    """Run the given filter along the first drive.

    `innovation` replaces a part of it, `localize` all of it, and then there are no records of the bearings.
    """
    drive, error = lap(FIRST)
    given = GivenFilter(innovation)
    trace = follow(drive, localize or given.localize, _move, _move_covariance, error=error)
    return trace, given.records


@course_style()
def draw_first_drive(
    innovation: Function | None = None,
    nees: Function | None = None,
    covariance_ellipse: Function | None = None,
    localize: Function | None = None,
) -> Drawing:
    """Draw the first drive as a filter estimates it; parts that the student has written replace the given ones.

    Parameters
    ----------
    innovation, nees, covariance_ellipse, localize : callable, optional
        The student's functions.

    Returns
    -------
    Drawing
        A map with true and estimated poses, and the error of the position or, with `nees`, the NEES of each step.
    """
    broken, _ = run_first_drive()
    trace = broken
    if innovation or localize:
        trace, _ = run_first_drive(innovation, localize)
    figure = Figure(figsize=(10.6, 5.0))
    left, right = figure.subplots(1, 2, width_ratios=(1.0, 1.15))
    _plot_map(left, trace, covariance_ellipse)
    off = np.hypot(*trace.errors[:, :2].T)
    words = (
        f"True and estimated path of a robot on a circle, 30 steps. The position is off by {off.max():.2f} m at "
        f"most, and by {off.mean():.2f} m on average."
    )
    if nees is None:
        _plot_errors(right, trace, None if trace is broken else broken)
    else:
        values = _squares(nees, trace)
        _plot_nees(right, values, None if trace is broken else _squares(nees, broken))
        above = int(np.sum(values > LIMIT))
        words += (
            f" NEES is {np.max(values):.0f} at most, and above {LIMIT} at {above} of {len(values)} poses."
        )
    legend_below(
        figure, [source_key("truth", "true pose"), source_key("ekf", "estimate with its 95 % ellipse")]
    )
    return Drawing(figure, words)


def _squares(nees: Function, trace: Trace) -> FloatArray:
    return np.array(
        [float(nees(e.copy(), P.copy())) for e, P in zip(trace.errors, trace.covariances, strict=True)]
    )


def _plot_map(ax: Axes, trace: Trace, covariance_ellipse: Function | None) -> None:
    plot_field(FIELD, ax)
    plot_landmarks(LANDMARKS, KINDS, ax, GREY, size=6)
    for style, poses in ((STYLES["truth"], trace.truth), (STYLES["ekf"], trace.poses)):
        ax.plot(*poses[:, :2].T, color=style.colour, lw=1.6, ls=style.line, zorder=4)
    for pose, covariance in zip(trace.poses[::EVERY], trace.covariances[::EVERY], strict=True):
        if covariance_ellipse is None:
            plot_ellipse(pose[:2], covariance[:2, :2], ax, "ekf")
        else:
            shape = ellipse_of(covariance_ellipse, covariance[:2, :2], 0.95)
            add_ellipse(ax, pose[:2], *shape, STYLES["ekf"].colour, lw=1.2)
    for step in ARROWS:
        (x0, y0), (x1, y1) = trace.truth[step : step + 2, :2].tolist()
        look = {"arrowstyle": "-|>", "color": STYLES["truth"].colour, "lw": 1.6, "mutation_scale": 16}
        ax.annotate("", (x1, y1), (x0, y0), arrowprops=look, zorder=5)
    x, y = trace.truth[0, :2]
    ax.plot(x, y, "o", color=STYLES["truth"].colour, ms=6, mec="white", zorder=6)
    ax.annotate("start", (x, y), (-7, 3), textcoords="offset points", ha="right", path_effects=HALO, zorder=7)
    plot_pose(Pose.from_array(trace.truth[-1]), ax)
    plot_pose(Pose.from_array(trace.poses[-1]), ax, "ekf")
    ax.set_title("The drive, from above")


def _plot_errors(ax: Axes, trace: Trace, broken: Trace | None) -> None:
    """Plot the position's error by step, and the standard deviation that the filter reports."""
    stated = np.sqrt(trace.covariances[:, 0, 0] + trace.covariances[:, 1, 1])
    if broken is not None:
        ax.plot(
            np.hypot(*broken.errors[:, :2].T), color=GREY, lw=1.2, ls=":", label="error of the given filter"
        )
    ax.plot(
        stated,
        color=STYLES["ekf"].colour,
        lw=1.4,
        ls="--",
        label="standard deviation that the filter reports",
    )
    ax.plot(
        np.hypot(*trace.errors[:, :2].T),
        color=STYLES["ekf"].colour,
        lw=1.6,
        marker=".",
        ms=5,
        label="true error",
    )
    top = float(ax.dataLim.ymax)
    ax.set(title="Error of the position", xlabel="step", ylabel="error (m)", ylim=(0, 1.3 * top))
    ax.legend(fontsize=9, loc="upper right")


def _plot_nees(ax: Axes, values: FloatArray, broken: FloatArray | None) -> None:
    """Plot the NEES of each step with the limit that 95 % of a consistent filter's values stay below."""
    ax.axhspan(1e-2, LIMIT, color="#e3e5e8", zorder=0, label=f"95 % limit for a consistent filter: {LIMIT}")
    if broken is not None:
        ax.semilogy(broken, color=GREY, lw=1.2, ls=":", label="the given filter")
    ax.semilogy(values, color=STYLES["ekf"].colour, lw=1.6, marker=".", ms=5, label="this filter")
    ax.set(title="NEES", xlabel="step", ylabel="NEES", ylim=(0.01, 30_000))
    ax.legend(fontsize=9)


@course_style()
def draw_bearings(nis: Function | None = None) -> Drawing:
    """Draw expected and measured bearings of the first drive and their innovations, as the given filter has them.

    Parameters
    ----------
    nis : callable, optional
        The student's; with it the right plot has the NIS of each measurement, computed from these innovations.
    """
    trace, records = run_first_drive()
    expected, measured, difference = np.degrees(np.array(records)).T
    figure = Figure(figsize=(10.6, 3.9))
    left, right = figure.subplots(1, 2)
    left.plot(trace.steps, expected, STYLES["ekf"].marker, color=STYLES["ekf"].colour, ms=5, label="expected")
    left.plot(trace.steps, measured, "x", color=STYLES["truth"].colour, ms=6, label="measured")
    left.set(title="Bearings of the landmarks", xlabel="step", ylabel="bearing (°)")
    left.set_yticks(np.arange(-360, 361, 90))
    left.legend(fontsize=9)
    worst = int(np.abs(difference).argmax())
    words = (
        f"Bearings that the filter expects and measures. At step {trace.steps[worst]} it expects "
        f"{expected[worst]:.1f} degrees and measures {measured[worst]:.1f}: the innovation is {difference[worst]:.1f}."
    )
    if nis is None:
        right.plot(trace.steps, difference, "o", color=STYLES["ekf"].colour, ms=4)
        right.axhline(0, color=GREY, lw=1)
        right.set(title="Innovations of the bearing", xlabel="step", ylabel="measured minus expected (°)")
        right.set_yticks(np.arange(-360, 91, 90))
    else:
        raw = trace.innovations.copy()
        raw[:, 0] = np.radians(difference)
        pairs = zip(raw, trace.innovation_covariances, strict=True)
        values = np.array([float(nis(nu.copy(), S.copy())) for nu, S in pairs])
        right.axhspan(1e-3, 5.99, color="#e3e5e8", zorder=0, label="95 % limit for a consistent filter: 5.99")
        right.semilogy(trace.steps, values, "o", color=STYLES["ekf"].colour, ms=4, label="each measurement")
        right.set(title="NIS, without the true pose", xlabel="step", ylabel="NIS", ylim=(1e-3, 1e6))
        right.legend(fontsize=9, loc="upper right")
        words += f" The largest NIS is {values.max():.0f}, at step {trace.steps[int(values.argmax())]}."
    return Drawing(figure, words)
