"""Show the report's figure as a film: ellipses at each half step, and the correlations beside them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import LinearSegmentedColormap, to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from nao_course.geometry import FloatArray
from nao_course.lessons.ekf_slam.homework_log import (
    OWN_SIGMAS,
    LogRun,
    homework_start,
    own_log,
    record_pentagon,
    run_log,
)
from nao_course.plotting import STYLES, Drawing, course_style, ellipse_outlines
from nao_course.plotting.legends import legend_below
from nao_course.plotting.maps import metric_axes
from nao_course.plotting.style import GREY
from nao_course.sim.drives import Function, landmark_blocks

# The report's four colours, in tones that are easy to distinguish.
PREDICTED, UPDATED, INITIAL, IMPROVED = "#c2409c", "#0b5fa5", "#c0392b", "#2e8540"
KEYS = {
    PREDICTED: "robot, predicted",
    UPDATED: "robot, updated",
    INITIAL: "landmark, initial",
    IMPROVED: "landmark, updated",
}
_HARDLY = 0.005  # smaller correlations are white; all others have a visible colour
CORRELATION = LinearSegmentedColormap.from_list(
    "correlation",
    [
        (0.0, "#c84b00"),
        (0.5 - _HARDLY / 2, "#fae3d5"),
        (0.5 - _HARDLY / 2, "#ffffff"),
        (0.5 + _HARDLY / 2, "#ffffff"),
        (0.5 + _HARDLY / 2, "#d6e5f3"),
        (1.0, "#0b5fa5"),
    ],
    N=801,
)
HEADING = 0.05  # length of the heading line as a part of the map's width


@dataclass(frozen=True, eq=False)
class FilterFilm:
    """Frames of a run: 0 is the start, 2 n - 1 the prediction and 2 n the update of step n.

    The true landmarks (k, 2) are in m.
    """

    run: LogRun
    truth: FloatArray

    @property
    def last(self) -> int:
        """Return the number of the last frame."""
        return 2 * len(self.run.predicted_states)

    def at(self, frame: int) -> tuple[int, FloatArray, FloatArray]:
        """Return step, state (n,) and covariance (n, n) of a frame."""
        run, step = self.run, (frame + 1) // 2
        if frame % 2:
            return step, run.predicted_states[step - 1], run.predicted_covariances[step - 1]
        return step, run.states[step], run.covariances[step]


def record_film(init_landmarks: Function, predict: Function, update: Function) -> FilterFilm:
    """Run the lesson's own log with a student's functions, initialised as in the homework."""
    log = own_log()
    start = homework_start(log, init_landmarks, OWN_SIGMAS)
    return FilterFilm(run_log(log, start, predict, update, OWN_SIGMAS), record_pentagon().landmarks)


def correlations(covariance: npt.ArrayLike) -> FloatArray:
    """Return the correlations (n, n) of a covariance (n, n); 0 where a variance is 0."""
    matrix = np.asarray(covariance, dtype=float)
    sigma = np.sqrt(np.maximum(np.diag(matrix), 0))
    with np.errstate(divide="ignore", invalid="ignore"):
        scaled = matrix / np.outer(sigma, sigma)
    return np.clip(np.nan_to_num(scaled, posinf=0.0, neginf=0.0), -1, 1)


def between_landmarks(covariance: npt.ArrayLike) -> float:
    """Return the mean absolute correlation of different landmarks along the same axis; 0 for one landmark."""
    matrix = np.abs(correlations(covariance))[3:, 3:]
    k = len(matrix) // 2
    if k < 2:
        return 0.0
    different = ~np.eye(k, dtype=bool)
    return float(np.mean([matrix[axis::2, axis::2][different].mean() for axis in (0, 1)]))


def plot_half_step(ax: Axes, film: FilterFilm, frame: int) -> None:
    """Plot one half step of a film as a map with all ellipses so far; the axes are the same for every half step."""
    run, (step, state, _) = film.run, film.at(frame)
    landmarks = [
        ellipse_outlines(run.states[n, 3:].reshape(-1, 2), landmark_blocks(run.covariances[n]))
        for n in (0, frame // 2, -1)
    ]
    metric_axes(ax, np.concatenate([run.states[:, :2], *landmarks[0], *landmarks[-1]]), margin=0.3)
    ax.plot(*film.truth.T, "o", color=STYLES["truth"].colour, ms=4, zorder=2)
    for number, position in enumerate(film.truth, start=1):  # like the rows of the matrix
        ax.annotate(str(number), position, (6, 6), textcoords="offset points", fontsize=10, zorder=6)
    before = run.states[: frame // 2 + 1, :2]
    predicted = run.predicted_states[:step, :2], run.predicted_covariances[:step, :2, :2]
    for colour, outlines in (
        (INITIAL, landmarks[0]),
        (PREDICTED, ellipse_outlines(*predicted)),
        (UPDATED, ellipse_outlines(before, run.covariances[: len(before), :2, :2])),
        (IMPROVED, landmarks[1]),
    ):
        ax.add_collection(_outlines(colour, outlines))
    ax.plot(*np.vstack([before, state[:2]]).T, color=GREY, lw=1.0)
    ax.plot(*state[3:].reshape(-1, 2).T, color=IMPROVED, marker="+", ms=9, mew=1.6, ls="")
    x, y, theta = state[:3]
    length, colour = HEADING * float(np.ptp(ax.get_xlim())), PREDICTED if frame % 2 else UPDATED
    ax.plot([x, x + length * np.cos(theta)], [y, y + length * np.sin(theta)], color=colour, lw=2.2)
    ax.plot(x, y, STYLES["ekf"].marker, color=colour, ms=9, mec="white", ls="")


def _outlines(colour: str, outlines: Sequence[FloatArray] | FloatArray = ()) -> PolyCollection:
    """Return ellipses in one colour, almost transparent."""
    return PolyCollection(
        list(outlines), facecolors=[to_rgba(colour, 0.07)], edgecolors=[to_rgba(colour, 0.95)], linewidths=1.3
    )


def keys() -> list[Patch | Line2D]:
    """Return the legend's entries."""
    ellipses: list[Patch | Line2D] = [
        Patch(fc=to_rgba(colour, 0.15), ec=colour, label=label) for colour, label in KEYS.items()
    ]
    truth = Line2D([], [], marker="o", color=STYLES["truth"].colour, ms=4, ls="", label="landmark, true")
    return [*ellipses, truth]


def plot_correlations(ax: Axes, covariance: npt.ArrayLike) -> Any:
    """Draw the correlations of a covariance as a matrix, and return the image."""
    return plot_blocks(ax, correlations(covariance))


def plot_blocks(ax: Axes, matrix: FloatArray) -> Any:
    """Draw a matrix of pose and landmarks with values from -1 to 1, its blocks separated by lines; return the image."""
    k = (len(matrix) - 3) // 2
    image = ax.imshow(matrix, cmap=CORRELATION, vmin=-1, vmax=1, interpolation="nearest")
    for edge in (3 + 2 * i for i in range(k)):
        ax.axhline(edge - 0.5, color=GREY, lw=1.4 if edge == 3 else 0.5)
        ax.axvline(edge - 0.5, color=GREY, lw=1.4 if edge == 3 else 0.5)
    centres = [1, *(3.5 + 2 * i for i in range(k))]
    names = ["pose", *map(str, range(1, k + 1))]
    ax.set(xticks=centres, yticks=centres)
    ax.set_xticklabels(names, fontsize=9)
    ax.set_yticklabels(names, fontsize=9)
    ax.tick_params(length=0)
    ax.spines[:].set_visible(True)
    return image


def say_frame(film: FilterFilm, frame: int) -> str:
    """Describe one half step in words."""
    step, state, covariance = film.at(frame)
    when = (
        "at the start" if frame == 0 else f"after step {step}, {'updated' if frame % 2 == 0 else 'predicted'}"
    )
    robot, sides = np.sqrt(np.trace(covariance[:2, :2])), np.diag(covariance)[3:].reshape(-1, 2).sum(axis=1)
    said = (
        f"{when.capitalize()}: standard deviation of the robot {100 * robot:.1f} cm and "
        f"{np.degrees(np.sqrt(covariance[2, 2])):.1f} degrees, of the landmarks {100 * np.sqrt(sides.mean()):.1f} cm; "
        f"correlation between landmarks {between_landmarks(covariance):.2f}"
    )
    off = np.hypot(*(state[3:].reshape(-1, 2) - film.truth).T)
    return f"{said}. The landmarks are {100 * off.mean():.1f} cm off."


@course_style()
def draw_frames(film: FilterFilm, frames: Sequence[int] | None = None) -> Drawing:
    """Draw some half steps of a film, each with its correlations below.

    By default they are the start, the first update, the middle and the end.
    """
    chosen = (0, 2, film.last // 4 * 2, film.last) if frames is None else frames
    figure = Figure(figsize=(11.0, 6.3))
    axes = figure.subplots(2, len(chosen), height_ratios=(1.25, 1), squeeze=False)
    image: Any = None
    for number, frame in enumerate(chosen):
        above, below = axes[:, number]
        plot_half_step(above, film, frame)
        step, _, covariance = film.at(frame)
        above.set_title("Start" if frame == 0 else f"Step {step}")
        above.set_ylabel("y (m)" if number == 0 else "")
        image = plot_correlations(below, covariance)
    bar = figure.colorbar(image, ax=list(axes[1]), label="correlation", shrink=0.9, ticks=[-0.5, 0, 0.5, 1])
    lowest = min(correlations(film.at(frame)[2]).min() for frame in chosen)
    # The palette of the small PNG has no room for colours that do not occur.
    bar.ax.set_ylim(np.floor(10 * lowest) / 10, 1)
    legend_below(figure, keys(), columns=5)
    words = " ".join(say_frame(film, frame) for frame in chosen)
    return Drawing(figure, f"Maps of robot and landmarks with 95 % ellipses, the correlations below. {words}")


def draw_film(init_landmarks: Function, predict: Function, update: Function) -> Drawing:
    """Draw four half steps of the lesson's own log, run with a student's functions."""
    return draw_frames(record_film(init_landmarks, predict, update))
