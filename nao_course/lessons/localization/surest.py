"""Which landmark makes a robot surest: what is left of its doubt after one look at a landmark, wherever that stands."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.geometry import FloatArray, Pose, rotation_2d
from nao_course.lessons.localization.drives import FIELD, KINDS, LANDMARKS, Sight, updated
from nao_course.plotting import (
    STYLES,
    Drawing,
    course_style,
    plot_ellipse,
    plot_field,
    plot_landmarks,
    plot_pose,
)
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import GREY, HALO
from nao_course.sim import SensorNoise
from nao_course.slam import Measurement, range_and_bearing

ROBOT = Pose(1.0, -0.4, 0.3)
_TURNED = rotation_2d(ROBOT.theta)
DOUBT = np.zeros((3, 3))  # m^2, rad^2: long along the heading, as after a walk straight ahead
DOUBT[:2, :2] = _TURNED @ np.diag([0.45**2, 0.15**2]) @ _TURNED.T
DOUBT[2, 2] = np.radians(8) ** 2
GRID = 0.1  # m between two places
NO_RANGE = 1e6  # m^2: a range that says nothing
NEAREST = 0.2  # m: nothing is measured nearer


def left_after(
    localize: Callable[..., Any], landmark: FloatArray, use_range: bool = True
) -> tuple[float, float]:
    """What is left of the robot's doubt after one look at a landmark (2,) that is where it is expected.

    Parameters
    ----------
    localize : callable
        The student's.
    landmark : ndarray, shape (2,)
        m, field frame.
    use_range : bool
        Whether the range is measured, or the bearing alone.

    Returns
    -------
    (float, float)
        Standard deviations of the position in the plane (m; root of both variances' sum) and of the heading (rad).
    """
    expected = range_and_bearing(ROBOT.as_array(), landmark)
    noise = SensorNoise().covariance(Measurement(float(expected[0]), float(expected[1])))
    if not use_range:
        noise[1, 1] = NO_RANGE
    _, left = updated(localize, ROBOT.as_array(), DOUBT, _At(landmark, expected, noise))
    return float(np.sqrt(left[0, 0] + left[1, 1])), float(np.sqrt(left[2, 2]))


class _At(Sight):
    """A sight of a landmark that is anywhere."""

    def __init__(self, position: FloatArray, measurement: FloatArray, covariance: FloatArray) -> None:
        super().__init__(-1, measurement, covariance)
        object.__setattr__(self, "_position", position)

    @property
    def position(self) -> FloatArray:
        """Where it is, (2,), m."""
        return np.array(self._position)  # type: ignore[attr-defined]


def draw_surest(localize: Callable[..., Any]) -> Drawing:
    """Draw what one look leaves of the robot's doubt, by where the landmark stands.

    Parameters
    ----------
    localize : callable
        The student's.

    Returns
    -------
    Drawing
        Three maps: the position's doubt after bearing and range, after the bearing alone, and the heading's.
    """
    x0, y0, x1, y1 = FIELD.carpet
    xs, ys = np.arange(x0, x1 + 1e-9, GRID), np.arange(y0, y1 + 1e-9, GRID)
    both = _over_grid(localize, xs, ys, True)
    alone = _over_grid(localize, xs, ys, False)
    panels = (
        ("Position, bearing and range", both[0], "cm", 100.0, (15, 20, 25, 30, 35)),
        ("Position, bearing only", alone[0], "cm", 100.0, (25, 30, 35, 40, 45)),
        ("Heading, bearing and range", np.degrees(both[1]), "°", 1.0, (4, 5, 6, 7, 8)),
    )
    with course_style():
        figure = Figure(figsize=(11.0, 5.3))
        for number, (ax, (title, values, unit, scale, levels)) in enumerate(
            zip(figure.subplots(1, 3, sharey=True), panels, strict=True)
        ):
            _plot_left(ax, xs, ys, values * scale, unit, levels)
            ax.set_title(title)
            ax.set_ylabel("y (m)" if number == 0 else "")
        keys = [
            Line2D([], [], color=STYLES["ekf"].colour, marker="^", ls="", ms=8, label="robot"),
            Line2D([], [], color=GREY, marker="o", ls="", ms=7, label="post"),
            Line2D([], [], color=GREY, marker="P", ls="", ms=7, label="corner"),
        ]
        legend_below(figure, keys)
    words = []
    for name, number in (
        ("the post at (3.0, 0.7)", 9),
        ("the corner at (2.4, -1.1)", 5),
        ("the corner at (0, 2)", 1),
    ):
        position, heading = left_after(localize, LANDMARKS[number])
        bearing_only, _ = left_after(localize, LANDMARKS[number], use_range=False)
        words.append(
            f"{name} leaves {100 * position:.0f} cm and {np.degrees(heading):.1f} degrees, its bearing "
            f"alone {100 * bearing_only:.0f} cm"
        )
    return Drawing(
        figure,
        "What one look leaves of a doubt of 47 cm, which lies along the heading, and of 8 degrees, by "
        "where the landmark stands. With bearing "
        "and range, near landmarks leave least of the position's doubt, far ones least of the heading's. "
        "The bearing alone tells the "
        f"position only where the landmark stands beside the robot. {'; '.join(words)}.",
    )


def _over_grid(localize: Callable[..., Any], xs: FloatArray, ys: FloatArray, use_range: bool) -> FloatArray:
    """Position (m) and heading (rad) left at each place: (2, len(ys), len(xs)); NaN right before the robot's feet."""
    left = np.full((2, len(ys), len(xs)), np.nan)
    for row, y in enumerate(ys):
        for column, x in enumerate(xs):
            if np.hypot(x - ROBOT.x, y - ROBOT.y) > NEAREST:
                left[:, row, column] = left_after(localize, np.array([x, y]), use_range)
    return left


def _plot_left(
    ax: Axes, xs: FloatArray, ys: FloatArray, values: FloatArray, unit: str, levels: tuple[int, ...]
) -> None:
    plot_field(FIELD, ax)
    ax.pcolormesh(
        xs, ys, values, cmap="cividis_r", zorder=0.15, shading="nearest", vmin=levels[0], vmax=levels[-1]
    )
    lines = ax.contour(xs, ys, values, levels=levels, colors="black", linewidths=0.9, zorder=2)
    for text in ax.clabel(
        lines, fmt=lambda value: f"{value:.0f} {unit}".replace(" °", "°"), fontsize=9, zorder=8
    ):
        text.set(path_effects=HALO, color="black")
    plot_landmarks(LANDMARKS, KINDS, ax, GREY, size=7)
    plot_ellipse((ROBOT.x, ROBOT.y), DOUBT[:2, :2], ax, probability=0.39)
    plot_pose(ROBOT, ax, "ekf")
