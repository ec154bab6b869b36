"""Pictures by a camera that hangs lower than its robot's joints say: what a calibration finds, and what is left.

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

from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.distance.looks import usual_view
from nao_course.plotting.drawing import Drawing
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import STYLES, course_style
from nao_course.sim import CameraView, Field, visible_landmarks

OFFSET = float(
    np.radians(6.4)
)  # real robots' heads hang so much lower than their joints say (docs/real_data.md)
PITCH_SIGMA, ROLL_SIGMA = float(np.radians(0.7)), float(np.radians(0.5))  # per picture, as of the real ones
MARK_SIGMA = 1.0  # px
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
        What the robot believes of its camera.
    """

    pixels: FloatArray
    ground: FloatArray
    view: CameraView


def marked_pictures(number: int, rng: int = 0, offset: float = OFFSET) -> list[Marked]:
    """Take pictures all over the whole field, by a camera that looks lower by `offset` (rad) than its robot believes.

    Each picture has a lean of its own beside that, and marks that are about a pixel off.
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
        Added to the believed pitch, rad.

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
    """Median and 90 % of the size of errors in each bin of `EDGES`; no distance is infinitely wrong."""
    size = np.where(np.isnan(errors), np.inf, np.abs(errors))
    bins = [size[(low <= true) & (true < high)] for low, high in pairwise(EDGES)]
    return tuple(
        (float(np.quantile(each, 0.5, method="higher")), float(np.quantile(each, 0.9, method="higher")))
        for each in bins
    )


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
    with course_style():
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
        figure.axes[0].set_ylabel("error of the distance (m)")
        keys = [
            Line2D(
                [],
                [],
                color=colour,
                marker=STYLES[key].marker,
                lw=2,
                ms=8,
                label=f"{name}: median, and up to 90 %",
            )
            for key, (name, colour) in zip(("odometry", "ekf"), COLOURS.items(), strict=True)
        ]
        legend_below(figure, keys)
    return Drawing(figure, f"Median errors at 1-2, 2-3, 3-4 and 4-5 m. {'; '.join(said)}.")
