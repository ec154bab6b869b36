"""The figure that the course begins and ends with: a robot that does not know where it is, and looks around."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.plotting.drawing import Drawing, say_count
from nao_course.plotting.legends import legend_below, source_key
from nao_course.plotting.maps import plot_field, plot_landmarks, plot_measurements
from nao_course.plotting.paths import plot_path, plot_pose
from nao_course.plotting.style import GREY, HALO, STYLES, course_style
from nao_course.sim import Field, SensorNoise, SimulatedNao, Truth, repeat_drive
from nao_course.slam import Measurement, Motion

START = Pose(2.2, 1.1, float(np.radians(150)))
SEED = 3
POSSIBLE = 500_000  # poses at first, anywhere on the field
DRAWN = 500  # of them in one map
WALK = 1.0  # m before each turn
_LENS = (0.07, 0.12, 0.5, 0.42)  # left, low, width, height, in parts of the last map
_TITLES = ("Lost", "One look", "A walk, a turn, a look", "Found")


@dataclass(frozen=True)
class Search:
    """A drive with looks on the way, and the poses that explain all that was seen.

    Parameters
    ----------
    poses : tuple of Pose
        Where the robot truly was at each look.
    odometry : tuple of Pose
        Where it would believe to be, had somebody told it where it started.
    looks : tuple of tuple of Measurement
        What it saw there.
    possible : tuple of ndarray, shape (N, 3)
        Poses that are possible before the first look, and after each one.
    """

    poses: tuple[Pose, ...]
    odometry: tuple[Pose, ...]
    looks: tuple[tuple[Measurement, ...], ...]
    possible: tuple[FloatArray, ...]


def search(field: Field, turn: float, rng: np.random.Generator, start: Pose = START) -> Search:
    """Let a robot look, walk and turn twice, and keep the poses that agree with what it saw.

    Each possible robot starts anywhere, gets the same commands and has its own errors. It drops out at the first look
    that it cannot explain.

    Parameters
    ----------
    field : Field
        The map, which is known here.
    turn : float
        Radians that the robot turns after each walk.
    rng : numpy.random.Generator
        Of the robot, and of all possible ones.
    start : Pose
        Where the robot truly is at first.

    Returns
    -------
    Search
        With three looks.
    """
    nao = SimulatedNao(field, start, rng)
    truth = Truth(nao)
    looks, poses, odometry = [nao.sense("bottom")], [truth.pose], [start]
    commands = [Motion(WALK, turn)] * 2
    for command in commands:
        nao.walk(command.distance)
        nao.turn(command.turn)
        looks.append(nao.sense("bottom"))
        poses.append(truth.pose)
        odometry.append(start @ nao.odometry)
    paths = _anywhere(field, repeat_drive(commands, POSSIBLE, rng, nao.odometry_noise), rng)
    possible = [paths[:, 0]]
    for number, seen in enumerate(looks):
        paths = paths[explains(paths[:, number], seen, field, nao.sensor_noise)]
        possible.append(paths[:, number])
    return Search(tuple(poses), tuple(odometry), tuple(looks), tuple(possible))


def _anywhere(field: Field, paths: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Let paths (N, M, 3), which begin at the origin, begin anywhere inside the lines."""
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
    """Return which poses have, for each measurement, a landmark of its kind where it says.

    Parameters
    ----------
    poses : array_like, shape (N, 3)
        In the field frame.
    seen : sequence of Measurement
        Nothing says which landmark each one is.
    field : Field
        With its landmarks.
    noise : SensorNoise
        Of bearing and range.
    sigmas : float
        Standard deviations by which both may be off.

    Returns
    -------
    ndarray of bool, shape (N,)
        All True where nothing was seen.
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


def draw_lost_and_found(to_radians: Callable[[float], float]) -> Drawing:
    """Draw how a robot that may be anywhere finds out where it is, from three looks.

    Parameters
    ----------
    to_radians : callable
        Turns degrees into radians; the robot turns by its 90 degrees.

    Returns
    -------
    Drawing
        Four maps, seeded: before the first look, and after each one.
    """
    field = Field(2012, half=True)
    found = search(field, float(to_radians(90.0)), np.random.default_rng(SEED))
    with course_style():
        figure = Figure(figsize=(10.8, 4.3))
        axes = figure.subplots(1, len(found.possible), sharey=True)
        for number, (ax, title) in enumerate(zip(axes, _TITLES, strict=True)):
            _draw_stage(ax, field, found, number)
            ax.set_title(title)
            ax.set_ylabel("y (m)" if number == 0 else "")
        plot_path(found.odometry, axes[-1], "odometry")
        _draw_close(axes[-1], found)
        keys = [
            Line2D([], [], color=STYLES["ekf"].colour, lw=2, label="where it could be"),
            source_key("truth", "where it is"),
            source_key("odometry", "where its commands alone would put it"),
        ]
        legend_below(figure, keys)
    return Drawing(figure, _in_words(found))


def _draw_stage(ax: Axes, field: Field, found: Search, number: int) -> None:
    """One map: possible poses, the robot, and what it saw last."""
    plot_field(field, ax)
    marks = [mark for mark in field.landmarks if mark.kind != "cross"]
    plot_landmarks([(mark.x, mark.y) for mark in marks], [mark.kind for mark in marks], ax, GREY, size=5)
    _plot_possible(found.possible[number], ax)
    looked = max(number - 1, 0)
    if number:
        plot_measurements(found.looks[looked], found.poses[looked], ax, "truth")
        plot_path(found.poses[: looked + 1], ax)
    else:
        plot_pose(found.poses[0], ax)
    ax.text(
        0.5, 0.015, _left(found, number), transform=ax.transAxes, ha="center", path_effects=HALO, zorder=9
    )


def _plot_possible(poses: FloatArray, ax: Axes, length: float = 0.14, order: float = 3.0) -> None:
    """Draw poses (N, 3) as dots with a stroke where each is heading; of very many, some."""
    shown = poses[:: max(1, len(poses) // DRAWN)]
    tips = shown[:, :2] + length * np.column_stack([np.cos(shown[:, 2]), np.sin(shown[:, 2])])
    colour = STYLES["ekf"].colour
    strokes = LineCollection(list(np.stack([shown[:, :2], tips], axis=1)), colors=colour, lw=1.1, alpha=0.55)
    strokes.set_zorder(order)
    ax.add_collection(strokes)
    ax.plot(*shown[:, :2].T, ".", color=colour, ms=2.6, alpha=0.7, zorder=order + 0.1)


def _draw_close(ax: Axes, found: Search) -> None:
    """A lens over the robot at the end: one would not see on the map that anything is left."""
    x, y = found.poses[-1].as_array()[:2]
    lens = ax.inset_axes(_LENS, xlim=(x - 0.2, x + 0.2), ylim=(y - 0.2, y + 0.2), facecolor="white")
    lens.set(xticks=(), yticks=(), aspect="equal")
    lens.spines[:].set(visible=True, color=GREY)
    plot_pose(found.poses[-1], lens, length=0.12)
    _plot_possible(found.possible[-1], lens, 0.08, order=7)
    lens.set_title("close up, 0.4 m wide", fontsize=9, loc="center", fontweight="normal", pad=3)


def _left(found: Search, number: int) -> str:
    """How many poses are left."""
    return f"{len(found.possible[number]):,} poses"


def _in_words(found: Search) -> str:
    """What the figure shows, for who cannot see it."""
    words = [
        f"A robot is lost on half a football field: {_left(found, 0)} that it could have cover the field."
    ]
    for number, seen in enumerate(found.looks, start=1):
        words.append(
            f"Look {number} shows {say_count(len(seen), 'landmark')}: {_left(found, number)} are left."
        )
    last = found.possible[-1]
    if len(last):
        off = np.hypot(*(last[:, :2].mean(axis=0) - found.poses[-1].as_array()[:2]))
        alone = np.hypot(*(found.odometry[-1].as_array() - found.poses[-1].as_array())[:2])
        words.append(
            f"They are {off:.2f} m off in the mean; commands alone, from a known start, {alone:.2f} m."
        )
    return " ".join(words)
