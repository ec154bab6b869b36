"""The report's ten ablations: each sigma ten times as large and a tenth, as a table and as a grid of plots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.datasets import HomeworkLog
from nao_course.geometry import FloatArray
from nao_course.lessons.ekf_slam.homework_log import Function, LogRun, Sigmas, homework_start, run_log
from nao_course.plotting import STYLES, Drawing, Table, course_style, ellipse_outlines, table
from nao_course.plotting.legends import legend_below

NAMES = {"along": "σx", "across": "σy", "turn": "σα", "bearing": "σβ", "range": "σr"}
FACTORS = (10.0, 0.1)
ROBOT, LANDMARK = "#0b5fa5", "#2e8540"  # as in the film: the robot, updated; landmarks, updated


@dataclass(frozen=True, eq=False)
class Ablation:
    """A log run with one sigma changed.

    Parameters
    ----------
    name : str
        Which of `Sigmas`; "" where all are as they were.
    factor : float
        By what it was multiplied.
    run : LogRun
        What was believed.
    """

    name: str
    factor: float
    run: LogRun

    @property
    def title(self) -> str:
        """Such as "σx × 10"."""
        if not self.name:
            return "as they are"
        return f"{NAMES[self.name]} {'× 10' if self.factor > 1 else '/ 10'}"

    @property
    def position(self) -> float:
        """Doubt of the position, mean over all steps: the root of both variances' sum, m; before the updates."""
        return _spread(self.run.predicted_covariances[:, :2, :2])

    @property
    def updated_position(self) -> float:
        """The same after the updates, m."""
        return _spread(self.run.covariances[1:, :2, :2])

    @property
    def heading(self) -> float:
        """Doubt of the heading after each update, mean over all steps, rad."""
        return float(np.sqrt(self.run.covariances[1:, 2, 2]).mean())

    @property
    def landmark(self) -> float:
        """Doubt of a landmark at the end, mean over all: the root of both variances' sum, m."""
        return _spread(self.run.landmark_covariances)

    @property
    def nis(self) -> float:
        """Mean of the normalised innovation squared."""
        return float(self.run.nis.mean())


def _spread(covariances: FloatArray) -> float:
    return float(np.sqrt(np.trace(covariances, axis1=-2, axis2=-1)).mean())


def ablate(
    log: HomeworkLog,
    init_landmarks: Function,
    predict: Function,
    update: Function,
    sigmas: Sigmas | None = None,
    every: int = 1,
) -> list[Ablation]:
    """Run a log with the sigmas as they are, then with each of the five ten times as large and a tenth.

    Parameters
    ----------
    log : HomeworkLog
        The homework's, or the course's own.
    init_landmarks, predict, update : callable
        The student's.
    sigmas : Sigmas, optional
        As they are; by default the homework's.
    every : int
        Only in every so many steps the measurements are used.

    Returns
    -------
    list of Ablation
        Eleven: as they are, then the report's figures 2 to 11 in its order.
    """
    assumed = sigmas or Sigmas()

    def with_sigmas(name: str, factor: float) -> Ablation:
        changed = assumed.scaled(name, factor) if name else assumed
        start = homework_start(log, init_landmarks, changed)
        return Ablation(name, factor, run_log(log, start, predict, update, changed, every))

    return [with_sigmas("", 1.0), *(with_sigmas(name, factor) for name in NAMES for factor in FACTORS)]


def ablation_table(ablations: Sequence[Ablation]) -> Table:
    """Set what each change does in a table: doubts in cm and degrees, and the mean NIS."""
    columns = ("sigmas", "position predicted, cm", "updated, cm", "heading, deg", "landmark, cm", "mean NIS")
    return table(
        columns,
        [
            (
                each.title,
                f"{100 * each.position:.3g}",
                f"{100 * each.updated_position:.3g}",
                f"{np.degrees(each.heading):.2g}",
                f"{100 * each.landmark:.3g}",
                f"{each.nis:.0f}",
            )
            for each in ablations
        ],
    )


def draw_ablations(ablations: Sequence[Ablation]) -> Drawing:
    """Draw the map of each change, the larger sigma above the smaller.

    Parameters
    ----------
    ablations : sequence of Ablation
        What `ablate` gives.

    Returns
    -------
    Drawing
        The map with all as they are, then two rows of five, with the robot's ellipses before each update and the
        landmarks' at the end.
    """
    changed = [each for each in ablations if each.name]
    base = next(each for each in ablations if not each.name)
    rows = [[each for each in changed if (each.factor > 1) is larger] for larger in (True, False)]
    with course_style():
        figure = Figure(figsize=(14.4, 6.4))
        grid = figure.subplots(2, 1 + len(rows[0]), squeeze=False)
        grid[1, 0].set_axis_off()
        shown = [(grid[0, 0], base), *zip(grid[:, 1:].flat, [*rows[0], *rows[1]], strict=True)]
        for ax, each in shown:
            _plot_run(ax, each.run)
            _frame(ax, base.run)
            ax.set_title(each.title)
        grid[0, 0].set_xlabel("x (m)")
        grid[0, 0].tick_params(labelbottom=True)
        grid[1, 1].set_ylabel("y (m)")
        grid[1, 1].tick_params(labelleft=True)
        handles = [
            Line2D([], [], color=STYLES["truth"].colour, lw=0.8, label="believed path"),
            *(
                PolyCollection([], facecolor=to_rgba(colour, 0.2), edgecolor=colour, label=label)
                for colour, label in (
                    (ROBOT, "robot, predicted, 95 %"),
                    (LANDMARK, "landmark, at the end, 95 %"),
                )
            ),
        ]
        legend_below(figure, handles)
    told = "; ".join(
        f"{each.title}: {each.position / base.position:.2g} and {each.landmark / base.landmark:.2g} times"
        for each in changed
    )
    return Drawing(
        figure,
        f"{len(changed)} maps of the same log. The robot's predicted doubt and the landmarks' at the end, beside those "
        f"with the sigmas as they are ({100 * base.position:.1f} and {100 * base.landmark:.1f} cm): {told}.",
    )


def _frame(ax: Axes, run: LogRun) -> None:
    """Equal axes in metres round path and landmarks, with a fifth of their extent to spare."""
    around = np.vstack([run.states[:, :2], run.landmarks])
    low, high = around.min(axis=0), around.max(axis=0)
    margin = 0.2 * float((high - low).max())
    ax.set(aspect="equal", xlim=(low[0] - margin, high[0] + margin), ylim=(low[1] - margin, high[1] + margin))
    ax.set(xlabel="x (m)", ylabel="y (m)")
    ax.label_outer()


def _plot_run(ax: Axes, run: LogRun) -> None:
    """Path, the robot's predicted ellipses, landmarks and their ellipses at the end: all of 95 %."""
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


# --- what turning last hides ---


def draw_turn_last(
    log: HomeworkLog,
    init_landmarks: Function,
    predict: Function,
    update: Function,
    sigmas: Sigmas | None = None,
    every: int = 5,
) -> Drawing:
    """Draw what a larger sigma of the turn does when every step is corrected at once, and when it is not.

    Parameters
    ----------
    log : HomeworkLog
        Its steps drive first and turn last.
    init_landmarks, predict, update : callable
        The student's.
    sigmas : Sigmas, optional
        By default the homework's.
    every : int
        Beside an update in each step, one in so many.

    Returns
    -------
    Drawing
        Two rows of maps: the sigma as it is, and ten times.
    """
    assumed = sigmas or Sigmas()
    told = []
    with course_style():
        figure = Figure(figsize=(8.4, 8.6))
        grid = figure.subplots(2, 2, sharex=True, sharey=True)
        for axes, often in zip(grid, (1, every), strict=True):
            for ax, factor in zip(axes, (1.0, 10.0), strict=True):
                changed = assumed.scaled("turn", factor)
                start = homework_start(log, init_landmarks, changed)
                each = Ablation("turn", factor, run_log(log, start, predict, update, changed, often))
                _plot_run(ax, each.run)
                _frame(ax, each.run)
                size = "as it is" if factor == 1 else "× 10"
                when = "each step" if often == 1 else f"every {often}th step"
                ax.set_title(f"σα {size}, update in {when}")
                told.append(f"{when}, {size}: {100 * each.position:.1f} cm")
    return Drawing(figure, f"The robot's predicted doubt, mean over all steps. Update in {'; '.join(told)}.")
