"""Run the report's ten ablations: each standard deviation times ten and divided by ten."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.datasets import HomeworkLog
from nao_course.geometry import FloatArray
from nao_course.lessons.ekf_slam.homework_log import LogRun, homework_start, run_log
from nao_course.metrics import band
from nao_course.plotting import STYLES, Drawing, Table, course_style, ellipse_outlines, table
from nao_course.plotting.legends import legend_below
from nao_course.sim.drives import Function, Sigmas

NAMES = {"along": "σx", "across": "σy", "turn": "σα", "bearing": "σβ", "range": "σr"}
FACTORS = (10.0, 0.1)
ROBOT, LANDMARK = "#0b5fa5", "#2e8540"  # as in the film


@dataclass(frozen=True, eq=False)
class Ablation:
    """Run of a log with one standard deviation, a field of `Sigmas` or "" for none, multiplied by a factor."""

    name: str
    factor: float
    run: LogRun

    @property
    def title(self) -> str:
        """Return a title such as "σx × 10"."""
        if not self.name:
            return "unchanged"
        return f"{NAMES[self.name]} {'× 10' if self.factor > 1 else '/ 10'}"

    @property
    def position(self) -> float:
        """Return the mean standard deviation of the predicted position over all steps, m."""
        return _mean_sigma(self.run.predicted_covariances[:, :2, :2])

    @property
    def updated_position(self) -> float:
        """Return the mean standard deviation of the updated position over all steps, m."""
        return _mean_sigma(self.run.covariances[1:, :2, :2])

    @property
    def heading(self) -> float:
        """Return the mean standard deviation of the updated heading over all steps, rad."""
        return float(np.sqrt(self.run.covariances[1:, 2, 2]).mean())

    @property
    def landmark(self) -> float:
        """Return the mean standard deviation of the landmarks at the end, m."""
        return _mean_sigma(self.run.landmark_covariances)

    @property
    def nis(self) -> float:
        """Return the mean normalised innovation squared."""
        return float(self.run.nis.mean())


def _mean_sigma(covariances: FloatArray) -> float:
    """Return the mean over all covariances of the square root of the trace."""
    return float(np.sqrt(np.trace(covariances, axis1=-2, axis2=-1)).mean())


def ablate(
    log: HomeworkLog,
    init_landmarks: Function,
    predict: Function,
    update: Function,
    sigmas: Sigmas | None = None,
    every: int = 1,
) -> list[Ablation]:
    """Run a log unchanged, then with each of the five standard deviations times ten and divided by ten.

    Parameters
    ----------
    log : HomeworkLog
        The homework's log or the course's own.
    init_landmarks, predict, update : callable
        The student's functions.
    sigmas : Sigmas, optional
        Unchanged values; by default the homework's.
    every : int
        The filter updates in every `every`-th step only.

    Returns
    -------
    list of Ablation
        Eleven: unchanged, then the report's figures 2 to 11 in its order.
    """
    assumed = sigmas or Sigmas()

    def with_sigmas(name: str, factor: float) -> Ablation:
        changed = assumed.scaled(name, factor) if name else assumed
        start = homework_start(log, init_landmarks, changed)
        return Ablation(name, factor, run_log(log, start, predict, update, changed, every))

    return [with_sigmas("", 1.0), *(with_sigmas(name, factor) for name in NAMES for factor in FACTORS)]


def ablation_table(ablations: Sequence[Ablation]) -> Table:
    """Return a table of the standard deviations, in cm and degrees, and the mean NIS of each ablation."""
    first = ablations[0].run
    low, high = band(2 * first.k, len(first.nis))
    nis = f"mean NIS ({low:.1f} to {high:.1f})"
    columns = ("sigmas", "position predicted, cm", "updated, cm", "heading, deg", "landmark, cm", nis)
    return table(
        columns,
        [
            (
                each.title,
                f"{100 * each.position:.3g}",
                f"{100 * each.updated_position:.3g}",
                f"{np.degrees(each.heading):.2g}",
                f"{100 * each.landmark:.3g}",
                f"{each.nis:.1f}",
            )
            for each in ablations
        ],
    )


@course_style()
def draw_ablations(ablations: Sequence[Ablation]) -> Drawing:
    """Draw the map of each ablation, the larger standard deviation above the smaller.

    Parameters
    ----------
    ablations : sequence of Ablation
        Result of `ablate`.

    Returns
    -------
    Drawing
        The unchanged map, then two rows of five, with the robot's ellipses before each update and the
        landmarks' ellipses at the end.
    """
    changed = [each for each in ablations if each.name]
    base = next(each for each in ablations if not each.name)
    rows = [[each for each in changed if (each.factor > 1) is larger] for larger in (True, False)]
    figure = Figure(figsize=(14.4, 6.9))
    grid = figure.subplots(2, 1 + len(rows[0]), squeeze=False)
    grid[1, 0].set_axis_off()
    shown = [(grid[0, 0], base), *zip(grid[:, 1:].flat, [*rows[0], *rows[1]], strict=True)]
    for ax, each in shown:
        _plot_run(ax, each.run)
        _frame(ax, *(each.run for each in ablations))
        ax.set_title(each.title)
    grid[0, 0].set_xlabel("x (m)")
    grid[0, 0].tick_params(labelbottom=True)
    grid[1, 1].set_ylabel("y (m)")
    grid[1, 1].tick_params(labelleft=True)
    legend_below(figure, _keys())
    changes = "; ".join(
        f"{each.title}: {each.position / base.position:.2g} and {each.landmark / base.landmark:.2g} times"
        for each in changed
    )
    return Drawing(
        figure,
        f"{len(changed)} maps of the same log. Standard deviations of the robot's predicted position and of the "
        "landmarks at the end, compared with the unchanged run "
        f"({100 * base.position:.1f} and {100 * base.landmark:.1f} cm): {changes}.",
    )


def _frame(ax: Axes, *runs: LogRun) -> None:
    """Set equal axes in metres around the paths and the ellipses of robot and landmarks, with a margin."""
    outlines = [
        ellipse_outlines(*each)
        for run in runs
        for each in (
            (run.predicted_states[:, :2], run.predicted_covariances[:, :2, :2]),
            (run.landmarks, run.landmark_covariances),
        )
    ]
    around = np.vstack([*(run.states[:, :2] for run in runs), *(each.reshape(-1, 2) for each in outlines)])
    low, high = around.min(axis=0), around.max(axis=0)
    margin = 0.05 * float((high - low).max())
    ax.set(aspect="equal", xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin))
    ax.set(xlabel="x (m)", ylabel="y (m)")
    ax.label_outer()


def _keys() -> list[Artist]:
    """Return the legend's entries."""
    ellipses = ((ROBOT, "robot, predicted, 95 %"), (LANDMARK, "landmark, at the end, 95 %"))
    return [
        Line2D([], [], color=STYLES["truth"].colour, lw=0.8, label="estimated path"),
        *(
            PolyCollection([], facecolor=to_rgba(colour, 0.2), edgecolor=colour, label=label)
            for colour, label in ellipses
        ),
    ]


def _plot_run(ax: Axes, run: LogRun) -> None:
    """Plot the path, the landmarks, and the 95 % ellipses of robot and landmarks."""
    robots = ellipse_outlines(run.predicted_states[:, :2], run.predicted_covariances[:, :2, :2])
    landmarks = ellipse_outlines(run.landmarks, run.landmark_covariances)
    for outlines, colour in ((robots, ROBOT), (landmarks, LANDMARK)):
        ax.add_collection(
            PolyCollection(
                list(outlines), facecolors=[to_rgba(colour, 0.07)], edgecolors=[to_rgba(colour, 0.9)], lw=0.9
            )
        )
    ax.plot(*run.states[:, :2].T, "-", color=STYLES["truth"].colour, lw=0.8)
    ax.plot(*run.landmarks.T, "+", color=LANDMARK, ms=6)
