"""A robot that does not know its pose finds it from three pictures: the first and last figure of lesson 00."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course._internal.counts import say_count
from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.plotting.drawing import Drawing
from nao_course.plotting.halo import HALO
from nao_course.plotting.legends import legend_below, source_key
from nao_course.plotting.maps import plot_field, plot_landmarks, plot_measurements
from nao_course.plotting.paths import plot_path, plot_pose
from nao_course.plotting.style import GREY, STYLES, course_style
from nao_course.sim import Field, SensorNoise, SimulatedNao, Truth, repeat_drive
from nao_course.slam import Measurement, Motion

START = Pose(2.2, 1.1, float(np.radians(150)))
SEED = 3
POSSIBLE = 500_000  # poses at the start, anywhere on the field
DRAWN = 500  # poses that are drawn in one map
WALK = 1.0  # m before each turn
_LENS = (0.07, 0.12, 0.42, 0.345)  # left, bottom, width, height, as fractions of the last map
_TITLES = ("Lost", "One picture", "After a walk and a turn", "Found")


@dataclass(frozen=True)
class Search:
    """A drive with observations, and the poses that agree with all of them.

    Poses, true and by odometry from the true start, and measurements have an entry for each observation. `possible` has
    the possible poses (N, 3) before the first observation and after each.
    """

    poses: tuple[Pose, ...]
    odometry: tuple[Pose, ...]
    observations: tuple[tuple[Measurement, ...], ...]
    possible: tuple[FloatArray, ...]


def search(field: Field, turn: float, rng: np.random.Generator, start: Pose = START) -> Search:
    """Return the poses that agree with the observations of a robot that observes, walks and turns (rad) twice.

    Each possible robot starts anywhere, gets the same commands and makes its own errors. It is removed at the first
    observation that does not agree with its pose.
    """
    nao = SimulatedNao(field, start, rng)
    truth = Truth(nao)
    observations, poses, odometry = [nao.sense("bottom")], [truth.pose], [start]
    commands = [Motion(WALK, turn)] * 2
    for command in commands:
        nao.walk(command.distance)
        nao.turn(command.turn)
        observations.append(nao.sense("bottom"))
        poses.append(truth.pose)
        odometry.append(start @ nao.odometry)
    paths = _anywhere(field, repeat_drive(commands, POSSIBLE, rng, nao.odometry_noise), rng)
    possible = [paths[:, 0]]
    for number, seen in enumerate(observations):
        paths = paths[explains(paths[:, number], seen, field, nao.sensor_noise)]
        possible.append(paths[:, number])
    return Search(tuple(poses), tuple(odometry), tuple(observations), tuple(possible))


def _anywhere(field: Field, paths: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Move paths (N, M, 3) from the origin to random poses inside the field lines."""
    (left, right), (low, high) = field.x_range, field.y_range
    x, y, heading = rng.uniform([left, low, -np.pi], [right, high, np.pi], (len(paths), 3)).T
    c, s = np.cos(heading)[:, None], np.sin(heading)[:, None]
    return np.stack(
        [
            x[:, None] + c * paths[..., 0] - s * paths[..., 1],
            y[:, None] + s * paths[..., 0] + c * paths[..., 1],
            heading[:, None] + paths[..., 2],
        ],
        axis=-1,
    )


def explains(
    poses: npt.ArrayLike, seen: Sequence[Measurement], field: Field, noise: SensorNoise, sigmas: float = 3.0
) -> npt.NDArray[np.bool_]:
    """Return which poses (N, 3) in the field frame agree with a landmark of the same kind for each measurement.

    Bearing and range may both differ by `sigmas` standard deviations. Without measurements, all are True.
    """
    array = np.asarray(poses, dtype=float)
    fits = np.ones(len(array), dtype=bool)
    for each in seen:
        places = np.array([(mark.x, mark.y) for mark in field.landmarks if mark.kind == each.kind])
        dx, dy = (places[None, :, axis] - array[:, None, axis] for axis in (0, 1))
        ranges = np.hypot(dx, dy)
        bearings = wrap_angle(np.arctan2(dy, dx) - array[:, 2, None])
        near = np.abs(ranges - each.range) <= sigmas * noise.range_fraction * ranges
        near &= np.abs(wrap_angle(bearings - each.bearing)) <= sigmas * noise.bearing
        fits &= near.any(axis=1)
    return fits


@course_style()
def draw_lost_and_found(to_radians: Callable[[float], float]) -> Drawing:
    """Draw how a robot that may be anywhere finds its pose from three observations.

    Parameters
    ----------
    to_radians : callable
        Converts degrees to radians; the robot turns by its result for 90 degrees.

    Returns
    -------
    Drawing
        Four maps: before the first observation and after each one. The seed is fixed.
    """
    field = Field(2012, half=True)
    found = search(field, float(to_radians(90.0)), np.random.default_rng(SEED))
    figure = Figure(figsize=(10.8, 4.3))
    axes = figure.subplots(1, len(found.possible), sharey=True)
    for number, (ax, title) in enumerate(zip(axes, _TITLES, strict=True)):
        _draw_stage(ax, field, found, number)
        ax.set_title(title)
        ax.set_ylabel("y (m)" if number == 0 else "")
    plot_path(found.odometry, axes[-1], "odometry")
    _draw_close(axes[-1], found)
    keys = [
        Line2D([], [], color=STYLES["ekf"].colour, lw=2, label="possible poses (a sample)"),
        source_key("truth", "true pose"),
        source_key("odometry", "odometry from the true start"),
    ]
    legend_below(figure, keys)
    return Drawing(figure, _in_words(found))


def _draw_stage(ax: Axes, field: Field, found: Search, number: int) -> None:
    """Draw one map with the possible poses, the robot and its last measurements."""
    plot_field(field, ax)
    plot_landmarks(field.detectable_positions, field.detectable_kinds, ax, GREY, size=5)
    _plot_possible(found.possible[number], ax)
    last = max(number - 1, 0)
    if number:
        plot_measurements(found.observations[last], found.poses[last], ax, "truth")
        plot_path(found.poses[: last + 1], ax)
    else:
        plot_pose(found.poses[0], ax)
    ax.text(
        0.5, 0.015, _left(found, number), transform=ax.transAxes, ha="center", path_effects=HALO, zorder=9
    )


def _plot_possible(poses: FloatArray, ax: Axes, length: float = 0.14, order: float = 3.0) -> None:
    """Draw poses (N, 3) as dots with a stroke along each heading; draw only a sample of very many."""
    shown = poses[:: max(1, len(poses) // DRAWN)]
    tips = shown[:, :2] + length * np.column_stack([np.cos(shown[:, 2]), np.sin(shown[:, 2])])
    colour = STYLES["ekf"].colour
    strokes = LineCollection(list(np.stack([shown[:, :2], tips], axis=1)), colors=colour, lw=1.1, alpha=0.55)
    strokes.set_zorder(order)
    ax.add_collection(strokes)
    ax.plot(*shown[:, :2].T, ".", color=colour, ms=2.6, alpha=0.7, zorder=order + 0.1)


def _draw_close(ax: Axes, found: Search) -> None:
    """Draw an enlarged inset at the robot's last pose, because the remaining poses are tiny on the map."""
    x, y = found.poses[-1].as_array()[:2]
    lens = ax.inset_axes(_LENS, xlim=(x - 0.2, x + 0.2), ylim=(y - 0.2, y + 0.2), facecolor="white")
    lens.set(xticks=(), yticks=(), aspect="equal")
    lens.spines[:].set(visible=True, color=GREY)
    plot_pose(found.poses[-1], lens, length=0.12)
    _plot_possible(found.possible[-1], lens, 0.08, order=7)
    lens.text(0.5, 0.97, "0.4 m wide", transform=lens.transAxes, ha="center", va="top", fontsize=9)


def _left(found: Search, number: int) -> str:
    """Return the number of remaining poses in words."""
    return f"{len(found.possible[number]):,} poses"


def _in_words(found: Search) -> str:
    """Describe the figure in words for screen readers."""
    words = [
        f"A robot is lost on half a football field: {_left(found, 0)} that it could have cover the field."
    ]
    for number, seen in enumerate(found.observations, start=1):
        words.append(
            f"Observation {number} has {say_count(len(seen), 'landmark')}: {_left(found, number)} remain."
        )
    last = found.possible[-1]
    if len(last):
        off = np.hypot(*(last[:, :2].mean(axis=0) - found.poses[-1].as_array()[:2]))
        alone = np.hypot(*(found.odometry[-1].as_array() - found.poses[-1].as_array())[:2])
        words.append(f"Their mean is {off:.2f} m off; odometry from the true start is {alone:.2f} m off.")
    return " ".join(words)
