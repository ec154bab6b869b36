"""Figure of the uncertainty that remains after one measurement, by where the landmark is."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.geometry import FloatArray, Pose, rotation_2d
from nao_course.lessons.localization.drives import FIELD, KINDS, LANDMARKS, LandmarkMeasurement, updated
from nao_course.plotting import (
    LANDMARK_MARKERS,
    STYLES,
    Drawing,
    course_style,
    plot_field,
    plot_landmarks,
    plot_pose,
)
from nao_course.plotting.ellipses import ellipse_outlines
from nao_course.plotting.halo import HALO
from nao_course.plotting.legends import legend_below, source_key
from nao_course.plotting.style import GREY
from nao_course.sim import SensorNoise
from nao_course.slam import Measurement, range_and_bearing

ROBOT = Pose(1.0, -0.4, 0.3)
_TURNED = rotation_2d(ROBOT.theta)
COVARIANCE = np.zeros((3, 3))  # m^2, rad^2: long along the heading, as after a walk straight ahead
COVARIANCE[:2, :2] = _TURNED @ np.diag([0.45**2, 0.15**2]) @ _TURNED.T
COVARIANCE[2, 2] = np.radians(8) ** 2
GRID = 0.1  # m between two positions
NO_RANGE = 1e6  # m^2: a range without information
NEAREST = 0.2  # m: nearer landmarks are not measured


def remaining_after(
    localize: Callable[..., Any], landmark: FloatArray, use_range: bool = True
) -> tuple[float, float]:
    """Return the standard deviations of position (m) and heading (rad) after one measurement of a landmark as expected.

    The landmark (2,) is in m, field frame. The position's is the root of the sum of both variances. Without
    `use_range`, only the bearing is measured.
    """
    expected = range_and_bearing(ROBOT.as_array(), landmark)
    noise = SensorNoise().covariance(Measurement(float(expected[0]), float(expected[1])))
    if not use_range:
        noise[1, 1] = NO_RANGE
    _, left = updated(localize, ROBOT.as_array(), COVARIANCE, LandmarkMeasurement(landmark, expected, noise))
    return float(np.sqrt(left[0, 0] + left[1, 1])), float(np.sqrt(left[2, 2]))


@course_style()
def draw_remaining_uncertainty(localize: Callable[..., Any]) -> Drawing:
    """Draw the uncertainty that remains after one measurement, by where the landmark is.

    Parameters
    ----------
    localize : callable
        The student's function.

    Returns
    -------
    Drawing
        Three maps of standard deviations: position after bearing and range, position after the bearing alone, heading.
    """
    x0, y0, x1, y1 = FIELD.carpet
    xs, ys = np.arange(x0, x1 + 1e-9, GRID), np.arange(y0, y1 + 1e-9, GRID)
    both = _over_grid(localize, xs, ys, True)
    alone = _over_grid(localize, xs, ys, False)
    panels = (
        ("Position, bearing and range", both[0], "cm", 100.0, (5, 10, 15, 20, 25, 30, 35)),
        ("Position, bearing only", alone[0], "cm", 100.0, (25, 30, 35, 40, 45)),
        ("Heading, bearing and range", np.degrees(both[1]), "°", 1.0, (4, 5, 6, 7, 8)),
    )
    figure = Figure(figsize=(11.0, 5.3))
    for number, (ax, (title, values, unit, scale, levels)) in enumerate(
        zip(figure.subplots(1, 3, sharey=True), panels, strict=True)
    ):
        mesh = _plot_remaining(ax, xs, ys, values * scale, levels)
        label = f"remaining standard deviation ({'degrees' if unit == '°' else unit})"
        bar = figure.colorbar(
            mesh, ax=ax, location="bottom", extend="both", shrink=0.9, aspect=30, pad=0.02, label=label
        )
        bar.set_ticks(levels)
        ax.set_title(title)
        ax.set_ylabel("y (m)" if number == 0 else "")
    keys = [
        source_key("ekf", "estimated pose with its 95 % ellipse"),
        *(
            Line2D([], [], color=GREY, marker=LANDMARK_MARKERS[k], ls="", ms=7, label=k)
            for k in sorted(set(KINDS), reverse=True)
        ),
    ]
    legend_below(figure, keys)
    return Drawing(
        figure,
        "Standard deviations after one measurement, by the position of the landmark; before it, the position has "
        "47 cm, mostly along the heading, and the heading has 8 degrees. With bearing and range, near "
        "landmarks reduce the uncertainty of the position most, and far landmarks the uncertainty of the heading. "
        "The bearing alone improves the position only if the landmark is beside the robot. "
        f"{_say_remaining(localize)}.",
    )


def _say_remaining(localize: Callable[..., Any]) -> str:
    """State the remaining uncertainty after a measurement of each of three landmarks."""
    words = []
    for name, number in (
        ("the post at (3.0, 0.7)", 9),
        ("the corner at (2.4, -1.1)", 5),
        ("the corner at (0, 2)", 1),
    ):
        position, heading = remaining_after(localize, LANDMARKS[number])
        bearing_only, _ = remaining_after(localize, LANDMARKS[number], use_range=False)
        words.append(
            f"{name} leaves {100 * position:.0f} cm and {np.degrees(heading):.1f} degrees, its bearing "
            f"alone {100 * bearing_only:.0f} cm"
        )
    return "; ".join(words)


def _over_grid(localize: Callable[..., Any], xs: FloatArray, ys: FloatArray, use_range: bool) -> FloatArray:
    """Return remaining sigmas of position (m) and heading (rad), (2, len(ys), len(xs)); NaN next to the robot."""
    left = np.full((2, len(ys), len(xs)), np.nan)
    for row, y in enumerate(ys):
        for column, x in enumerate(xs):
            if np.hypot(x - ROBOT.x, y - ROBOT.y) > NEAREST:
                left[:, row, column] = remaining_after(localize, np.array([x, y]), use_range)
    return left


def _plot_remaining(
    ax: Axes, xs: FloatArray, ys: FloatArray, values: FloatArray, levels: tuple[int, ...]
) -> ScalarMappable:
    plot_field(FIELD, ax)
    mesh = ax.pcolormesh(
        xs, ys, values, cmap="cividis_r", zorder=0.15, shading="nearest", vmin=levels[0], vmax=levels[-1]
    )
    contours = ax.contour(xs, ys, values, levels=levels, colors="black", linewidths=0.9, zorder=2)
    ax.clabel(contours, fontsize=8, inline_spacing=2)
    plot_landmarks(LANDMARKS, KINDS, ax, GREY, size=7)
    (outline,) = ellipse_outlines((ROBOT.x, ROBOT.y), COVARIANCE[None, :2, :2])
    ax.plot(
        *np.vstack([outline, outline[:1]]).T,
        color=STYLES["ekf"].colour,
        lw=1.4,
        path_effects=HALO,
        zorder=3.6,
    )
    plot_pose(ROBOT, ax, "ekf")
    return mesh
