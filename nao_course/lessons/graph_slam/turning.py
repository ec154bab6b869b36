"""What a turn does to a linear graph: it has no heading, so it must be told one, and believes it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray, rotation_2d
from nao_course.lessons.graph_slam.drives import Drive, field_drive
from nao_course.lessons.graph_slam.systems import Builders, Function, map_error, solve_axes
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.sim import OdometryNoise

DRIVES = 8  # for each angle
ANGLES = np.radians([0.0, 2.5, 5, 10, 20, 30, 45, 60, 75, 90])
HEADINGS = {  # what the graph is told of the heading, and how it is drawn
    "no heading: the robot never turned": "graph",
    "heading by odometry": "odometry",
    "true heading": "truth",
}


def with_headings(drive: Drive, headings: FloatArray) -> Drive:
    """Turn what was measured in the robot's frame by the headings (P,) that are believed, rad."""
    turned = [
        each if each.kind == "start" else replace(each, value=rotation_2d(headings[each.first]) @ each.value)
        for each in drive.constraints
    ]
    return replace(drive, constraints=tuple(turned))


def believed_headings(kind: str, turn: float, stops: int, rng: np.random.Generator) -> FloatArray:
    """Headings (P,) in rad that a graph is told for a drive that turns by `turn` on its whole way."""
    true = np.linspace(0.0, turn, stops)
    if kind == "true heading":
        return true
    if kind == "heading by odometry":
        sigma = OdometryNoise().turn_per_turn * np.sqrt(np.abs(np.diff(true, prepend=0.0)))
        return true + np.cumsum(sigma * rng.standard_normal(stops))
    return np.zeros(stops)


def errors_by_turn(kind: str, builders: Builders, solve: Function) -> FloatArray:
    """Median error of the map over some drives, m, for each of `ANGLES`."""
    found = []
    for turn in ANGLES:
        errors = []
        for seed in range(DRIVES):
            drive = field_drive(seed, turn=float(turn))
            rng = np.random.default_rng([seed, 8])
            told = with_headings(drive, believed_headings(kind, float(turn), len(drive.path), rng))
            errors.append(map_error(told, solve_axes(told.constraints, told.size, builders, solve)[0]))
        found.append(float(np.median(errors)))
    return np.array(found)


def turn_that_doubles(errors: FloatArray) -> float:
    """Degrees of turn from which on an error, for each of `ANGLES`, is twice that without a turn; NaN for none."""
    above = np.flatnonzero(errors > 2 * errors[0])
    if not len(above):
        return float("nan")
    last = int(above[0])
    degrees = np.degrees(ANGLES)
    part = (2 * errors[0] - errors[last - 1]) / (errors[last] - errors[last - 1])
    return float(degrees[last - 1] + part * (degrees[last] - degrees[last - 1]))


def draw_turning(errors: dict[str, FloatArray]) -> Drawing:
    """Draw the error of the map over the turn of the drive.

    Parameters
    ----------
    errors : dict of str to ndarray
        By what the graph is told of the heading, a key of `HEADINGS`; metres for each of `ANGLES`.

    Returns
    -------
    Drawing
        A curve for each.
    """
    degrees = np.degrees(ANGLES)
    with course_style():
        figure = Figure(figsize=(7.6, 4.4))
        ax = figure.add_subplot()
        for name, values in errors.items():
            look = STYLES[HEADINGS[name]]
            ax.plot(
                degrees, values, color=look.colour, marker=look.marker, ls=look.line, lw=2, ms=6, label=name
            )
        ax.set(xlabel="turn on the whole way (degrees)", ylabel="error of the map (m)", ylim=0, xlim=0)
        ax.grid(color="#e3e5e8")
        ax.legend()
    said = "; ".join(
        f"{name}: {values[0]:.2f} m without a turn, {values[4]:.2f} m at 20 degrees, {values[-1]:.2f} m at 90"
        for name, values in errors.items()
    )
    return Drawing(figure, f"Error of the map over the turn of a drive, median of {DRIVES} drives. {said}.")
