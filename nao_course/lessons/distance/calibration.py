"""Calibration of a camera that points lower than its robot's joints report, and the remaining errors.

Here they are simulated, marks only; of the real ones the course has the statistics alone (docs/real_data.md).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.exercises import register
from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.distance.looks import usual_view
from nao_course.plotting.drawing import Drawing
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import STYLES, course_style, style_of
from nao_course.sim import CameraView, Field, visible_landmarks

# Real robots' heads hang so much lower than their joints say (docs/real_data.md).
OFFSET = float(np.radians(6.4))
PITCH_SIGMA, ROLL_SIGMA = float(np.radians(0.7)), float(np.radians(0.5))  # per picture, as of the real ones
MARK_SIGMA = 1.0  # px
LARGEST = 0.2  # rad: an offset of exercise 4.7 is at most 10 degrees; a little more for errors of the marks
EDGES = (1.0, 2.0, 3.0, 4.0, 5.0)  # m, of the bins
LEAST = 4  # landmarks of a picture
COLOURS = {"the paper's formula": STYLES["odometry"].colour, "exact": STYLES["ekf"].colour}

# Real pictures, set by set: median and 90 % of the size of the distance's error (m) in each bin, after `estimate_pitch`
# on ten other pictures, by `python -m benchmarks distance`; a test holds both together.
REAL: dict[str, dict[str, tuple[tuple[float, float], ...]]] = {
    "real scenes": {
        "the paper's formula": ((0.048, 0.162), (0.145, 0.389), (0.300, 0.581), (0.427, 0.764)),
        "exact": ((0.037, 0.129), (0.108, 0.336), (0.260, 0.545), (0.165, 0.484)),
    },
    "real walk": {
        "the paper's formula": ((0.051, 0.124), (0.070, 0.113), (0.230, 0.337), (0.325, 0.592)),
        "exact": ((0.036, 0.097), (0.064, 0.165), (0.100, 0.255), (0.191, 0.432)),
    },
}


@register
def small_angle(args: tuple[Any, ...], kwargs: dict[str, Any], answer: Any) -> str:
    """Return a message if the answer of `estimate_pitch` is larger than the text says; otherwise an empty text."""
    if np.abs(answer).max() > LARGEST:
        return "your offset is far larger than 10 degrees, or 0.175 rad. Is it in rad, and is it the offset alone?"
    return ""


@dataclass(frozen=True, eq=False)
class Marked:
    """A picture of which only the marks are kept.

    Parameters
    ----------
    pixels : ndarray, shape (N, 2)
        (u, v) of landmarks.
    ground : ndarray, shape (N, 2)
        Where they are, robot frame, metres.
    view : CameraView
        Assumed view of the camera.
    """

    pixels: FloatArray
    ground: FloatArray
    view: CameraView


def marked_pictures(number: int, rng: int = 0, offset: float = OFFSET) -> list[Marked]:
    """Take pictures on the whole field with a camera that points lower than assumed by `offset` (rad).

    Each picture also has its own tilt, and its marks have errors of about a pixel.
    """
    field, generator = Field(2012, half=False), np.random.default_rng([rng, 7])
    true = usual_view()
    found: list[Marked] = []
    while len(found) < number:
        pose = Pose(*generator.uniform((-2.8, -1.8, -np.pi), (2.8, 1.8, np.pi)))
        pitch, roll = generator.normal(0.0, (PITCH_SIGMA, ROLL_SIGMA))
        view = replace(true, pitch=true.pitch + pitch, roll=true.roll + roll)
        seen = [each for each in visible_landmarks(field, pose, view) if not each.occluded]
        if len(seen) >= LEAST:
            pixels = np.array([each.pixel for each in seen])
            places = pose.to_local([(each.landmark.x, each.landmark.y) for each in seen])
            marks = pixels + MARK_SIGMA * generator.standard_normal(pixels.shape)
            found.append(Marked(marks, places, replace(true, pitch=true.pitch - offset)))
    return found


def range_errors(
    distance: Callable[[FloatArray, CameraView], Any], pictures: Sequence[Marked], offset: float = 0.0
) -> tuple[FloatArray, FloatArray]:
    """Measure all landmarks of pictures.

    Parameters
    ----------
    distance : callable
        ``distance(pixels, view)`` gives (N,) in metres from the robot.
    pictures : sequence of Marked
        Which.
    offset : float
        Angle that is added to the assumed pitch, in rad.

    Returns
    -------
    true, errors : ndarray, shape (M,)
        In metres; the error is the distance less the true one, NaN where there is none.
    """
    true = [np.hypot(*each.ground.T) for each in pictures]
    views = [replace(each.view, pitch=each.view.pitch + offset) for each in pictures]
    found = [
        np.asarray(distance(each.pixels.copy(), view), dtype=float)
        for each, view in zip(pictures, views, strict=True)
    ]
    away = np.concatenate(true)
    return away, np.concatenate(found) - away


def by_distance(true: FloatArray, errors: FloatArray) -> tuple[tuple[float, float], ...]:
    """Return the median and the 90 % quantile of the size of errors in each bin of `EDGES`."""
    size = np.where(np.isnan(errors), np.inf, np.abs(errors))
    bins = [size[(low <= true) & (true < high)] for low, high in pairwise(EDGES)]
    return tuple(
        (float(np.quantile(each, 0.5, method="higher")), float(np.quantile(each, 0.9, method="higher")))
        for each in bins
    )


@course_style()
def draw_calibrated(simulated: Mapping[str, tuple[FloatArray, FloatArray]]) -> Drawing:
    """Draw the size of the distances' errors by distance: simulated pictures, and a real robot's.

    Parameters
    ----------
    simulated : mapping of str to (true, errors)
        From `range_errors`, by "the paper's formula" and "exact".

    Returns
    -------
    Drawing
        The figure; its text has all medians.
    """
    sets = {"simulated": {name: by_distance(*each) for name, each in simulated.items()}, **REAL}
    middles = [(low + high) / 2 for low, high in pairwise(EDGES)]
    said = []
    figure = Figure(figsize=(9.9, 3.8))
    for ax, (title, methods) in zip(
        figure.subplots(1, len(sets), sharey=True, squeeze=False)[0], sets.items(), strict=True
    ):
        for shift, (name, rows) in zip((-0.08, 0.08), methods.items(), strict=False):
            median, most = np.array(rows).T
            x, colour = np.array(middles) + shift, COLOURS[name]
            ax.vlines(x, median, most, color=colour, lw=2, alpha=0.6)
            ax.plot(x, median, STYLES["odometry" if shift < 0 else "ekf"].marker, color=colour, ms=8)
            said.append(f"{title}, {name}: {', '.join(f'{each:.2f}' for each in median)} m")
        ax.set(xlabel="true distance (m)", ylim=(0, 1.6), xticks=EDGES)
        ax.grid(color="#e3e5e8")
        ax.set_title(title, fontsize=11)
    figure.axes[0].set_ylabel("size of the distance's error (m)")
    keys = [
        Line2D(
            [],
            [],
            color=colour,
            marker=style_of(key).marker,
            lw=2,
            ms=8,
            label=f"{name}: median, and up to 90 %",
        )
        for key, (name, colour) in zip(("odometry", "ekf"), COLOURS.items(), strict=True)
    ]
    legend_below(figure, keys)
    return Drawing(figure, f"Median errors at 1-2, 2-3, 3-4 and 4-5 m. {'; '.join(said)}.")
