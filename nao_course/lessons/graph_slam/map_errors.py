"""The error of lesson 08's map over the turn of the drive, and over the weights of the measurements."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray, rotation_2d
from nao_course.lessons.graph_slam.drives import LinearDrive, field_drive
from nao_course.lessons.graph_slam.systems import (
    Builders,
    Function,
    assemble,
    inverse_of,
    map_error,
    solve_axes,
)
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.style import GREY, style_of
from nao_course.sim import OdometryNoise

DRIVES_PER_TURN = 8
ANGLES = np.radians([0.0, 1, 2.5, 5, 10, 20, 30, 45, 60, 90])
HEADINGS = {  # the headings that the graph uses, and the style of the curve
    "no heading: the robot never turned": "graph",
    "heading by odometry": "odometry",
    "true heading": "truth",
}
DRIVES_PER_POWER = 25
POWERS = (0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 4.0)
NEAR, FAR = 0.02, 0.5  # m, standard deviations of the best and the worst measurement of a drive


def with_headings(drive: LinearDrive, headings: FloatArray) -> LinearDrive:
    """Rotate the values in the robot frame by the assumed headings (P,), in rad."""
    turned = [
        each if each.kind == "start" else replace(each, value=rotation_2d(headings[each.first]) @ each.value)
        for each in drive.constraints
    ]
    return replace(drive, constraints=tuple(turned))


def assumed_headings(kind: str, turn: float, stops: int, rng: np.random.Generator) -> FloatArray:
    """Return the headings (P,) in rad that the graph uses for a drive that turns by `turn` in total."""
    true = np.linspace(0.0, turn, stops)
    if kind == "true heading":
        return true
    if kind == "heading by odometry":
        sigma = OdometryNoise().turn_per_turn * np.sqrt(np.abs(np.diff(true, prepend=0.0)))
        return true + np.cumsum(sigma * rng.standard_normal(stops))
    return np.zeros(stops)


def errors_by_turn(kind: str, builders: Builders, solve: Function) -> FloatArray:
    """Return the median error of the map in m over some drives, for each of `ANGLES`."""
    found = []
    for turn in ANGLES:
        errors = []
        for seed in range(DRIVES_PER_TURN):
            drive = field_drive(seed, turn=float(turn))
            rng = np.random.default_rng([seed, 8])
            turned = with_headings(drive, assumed_headings(kind, float(turn), len(drive.path), rng))
            errors.append(map_error(turned, solve_axes(turned.constraints, turned.size, builders, solve)[0]))
        found.append(float(np.median(errors)))
    return np.array(found)


_SHIFT = "An angle shifts a landmark 3 m away by 3 m times the angle: ten degrees are already 52 cm."
TURN_REMARKS = dict.fromkeys((10.0, 15.0, 20.0, 30.0, 45.0, 90.0), _SHIFT)  # by typical predictions, degrees


def doubling_turn(errors: FloatArray) -> float:
    """Return the turn in degrees at which the error is twice the error without a turn; NaN if it never is."""
    above = np.flatnonzero(errors > 2 * errors[0])
    if not len(above):
        return float("nan")
    last = int(above[0])
    degrees = np.degrees(ANGLES)
    part = (2 * errors[0] - errors[last - 1]) / (errors[last] - errors[last - 1])
    return float(degrees[last - 1] + part * (degrees[last] - degrees[last - 1]))


_LINE: dict[str, Any] = {
    "textcoords": "offset points",
    "arrowprops": {"arrowstyle": "-", "color": "black", "shrinkB": 7},
}


@course_style()
def draw_turning(errors: dict[str, FloatArray]) -> Drawing:
    """Draw the error of the map over the turn of the drive.

    Parameters
    ----------
    errors : dict of str to ndarray
        Errors in m for each of `ANGLES`, by the keys of `HEADINGS`.

    Returns
    -------
    Drawing
        The figure with a curve for each key.
    """
    degrees = np.degrees(ANGLES)
    figure = Figure(figsize=(7.6, 4.4))
    ax = figure.add_subplot()
    for name, values in errors.items():
        style = style_of(HEADINGS[name])
        ax.plot(
            degrees, values, color=style.colour, marker=style.marker, ls=style.line, lw=2, ms=6, label=name
        )
    no_turn = next(iter(errors.values()))
    if np.isfinite(doubled := doubling_turn(no_turn)):
        ax.plot(doubled, 2 * no_turn[0], "o", mfc="none", mec="black", ms=12, mew=1.6, zorder=5)
        ax.annotate(f"doubled at {doubled:.1f}°", (doubled, 2 * no_turn[0]), (-60, 60), **_LINE)
    ax.set(xlabel="total turn of the drive (degrees)", ylabel="error of the map (m)", yscale="log")
    # The axis is linear up to one degree, because a logarithmic axis has no 0.
    ax.set_xscale("symlog", linthresh=1.0, linscale=0.4)
    ax.set(xlim=(0, 95), xticks=(ticks := (0, 1, 2, 5, 10, 20, 45, 90)), xticklabels=map(str, ticks))
    ax.set(yticks=(errors_shown := (0.05, 0.1, 0.2, 0.5, 1, 2)), yticklabels=map(str, errors_shown))
    ax.minorticks_off()
    ax.grid(color="#e3e5e8")
    ax.legend()
    said = "; ".join(
        f"{name}: {values[0]:.2f} m without a turn, {values[5]:.2f} m at 20 degrees, {values[-1]:.2f} m at 90"
        for name, values in errors.items()
    )
    return Drawing(
        figure, f"Error of the map over the turn of a drive, median of {DRIVES_PER_TURN} drives. {said}."
    )


def unlike_drive(seed: int) -> LinearDrive:
    """Return a drive with a different standard deviation for each measurement, between `NEAR` and `FAR`."""
    clean, rng = field_drive(noise=0.0), np.random.default_rng([seed, 88])
    sigmas = np.exp(rng.uniform(np.log(NEAR), np.log(FAR), len(clean.constraints)))
    made = (
        each if each.kind == "start" else replace(each, epsilon=float(sigma) ** 2)
        for each, sigma in zip(clean.constraints, sigmas, strict=True)
    )
    return replace(clean, constraints=tuple(made))


def expected_error(drive: LinearDrive, builders: Builders, power: float) -> float:
    """Return the expected root mean square error of the map, in metres, if each weight is ``1 / sigma ** power``.

    The map is linear in the measurements, so its covariance follows from theirs. With the weights w it is inv(omega) @
    M @ inv(omega), where M is built like omega with w * w * sigma**2 in place of each w. The start has no error.
    """
    used = [replace(each, epsilon=each.epsilon ** (power / 2)) for each in drive.constraints]
    errors = [
        replace(each, epsilon=weighted.epsilon**2 / each.epsilon)
        for each, weighted in zip(drive.constraints, used, strict=True)
        if each.kind != "start"
    ]
    inverse = inverse_of(assemble(used, drive.size, builders, 0)[0])
    covariance = inverse @ assemble(errors, drive.size, builders, 0)[0] @ inverse
    return float(np.sqrt(2 * np.diag(covariance)[len(drive.path) :].mean()))  # two axes


def errors_by_power(builders: Builders) -> FloatArray:
    """Return the expected root mean square error of the map in m, for each power p of the weights in `POWERS`."""
    drives = [unlike_drive(seed) for seed in range(DRIVES_PER_POWER)]
    errors = [[expected_error(each, builders, power) for each in drives] for power in POWERS]
    return np.asarray(np.sqrt(np.mean(np.square(errors), axis=1)))


@course_style()
def draw_powers(errors: FloatArray) -> Drawing:
    """Draw the expected error of the map over the power p of the weights, for each p of `POWERS`."""
    best = int(np.argmin(errors))
    figure = Figure(figsize=(7.4, 3.9))
    ax = figure.add_subplot()
    style = STYLES["graph"]
    ax.axvline(2, color=GREY, lw=0.8)
    ax.plot(POWERS, 100 * errors, color=style.colour, marker=style.marker, lw=2, ms=7, mec="white")
    for power, words in (
        (0, "all equal"),
        (1, r"1 / $\sigma$"),
        (2, r"1 / $\sigma^2$"),
        (4, r"1 / $\sigma^4$"),
    ):
        ax.annotate(
            words,
            (power, 100 * errors[POWERS.index(power)]),
            (0, 10),
            textcoords="offset points",
            ha="center",
        )
    ax.set(xlabel=r"p: each measurement has the weight 1 / $\sigma^p$", ylabel="expected error (cm)")
    ax.set(xlim=(-0.4, 4.4), ylim=(0, 1.25 * 100 * errors.max()))
    ax.grid(color="#e3e5e8")
    said = ", ".join(
        f"{100 * error:.1f} cm for p = {power:g}" for power, error in zip(POWERS, errors, strict=True)
    )
    return Drawing(
        figure,
        f"Expected error of the map over {DRIVES_PER_POWER} drives by the power of the weight: {said}. "
        f"The smallest is at p = {POWERS[best]:g}.",
    )
