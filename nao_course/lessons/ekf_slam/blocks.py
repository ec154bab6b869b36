"""The covariance block by block: which blocks change with a motion, an update and a first measurement."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.ekf_slam.film import plot_blocks
from nao_course.lessons.ekf_slam.homework_log import OWN_SIGMAS, own_log
from nao_course.plotting import Drawing, course_style
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import GREY
from nao_course.sim.drives import Function, NamedEkf, checked_functions

FIRST, MEASURED = 3, 1  # landmarks on the map at first, and number of the measured landmark
SAME = 1e-12  # largest difference of an entry that has not changed
CHANGED = ListedColormap(["#ffffff", "#f6c9ad"])


def block_steps(
    predict: Function, update_landmarks: Function, add_landmark: Function
) -> dict[str, FloatArray]:
    """Return the covariance at first, and after each of three steps on the lesson's own log, by the step's name."""
    log = own_log()
    slam = NamedEkf(Pose(), *checked_functions((predict, update_landmarks, add_landmark)))

    def observe(numbers: range, step: int) -> None:
        seen = log.measurements[step].reshape(-1, 2)[numbers]
        slam.observe(numbers, seen, OWN_SIGMAS.covariances(seen))

    for control in log.controls[:2]:  # the robot is uncertain before it sees its first landmark
        slam.move(control, OWN_SIGMAS.control_covariance)
    observe(range(FIRST), 2)
    slam.move(log.controls[2], OWN_SIGMAS.control_covariance)
    # Measured once, landmarks share only the error of the pose, about which no later measurement has information
    observe(range(FIRST), 3)
    steps = {"Before": slam.covariance}
    slam.move(log.controls[3], OWN_SIGMAS.control_covariance)
    steps["Motion"] = slam.covariance
    observe(range(MEASURED, MEASURED + 1), 4)
    steps[f"Update: landmark {MEASURED + 1}"] = slam.covariance
    observe(range(FIRST, FIRST + 1), 4)
    steps[f"New: landmark {FIRST + 1}"] = slam.covariance
    return steps


def changed(before: FloatArray, after: FloatArray) -> FloatArray:
    """Return 1 for each entry of a covariance that has changed or is new, and 0 for the others."""
    same = np.zeros(after.shape, dtype=bool)
    n = len(before)
    same[:n, :n] = np.abs(after[:n, :n] - before) <= SAME
    return np.asarray(~same, dtype=float)


@course_style()
def draw_blocks(predict: Function, update_landmarks: Function, add_landmark: Function) -> Drawing:
    """Draw the covariance of pose and map through a motion, an update and a first measurement.

    Parameters
    ----------
    predict, update_landmarks, add_landmark : callable
        The student's functions.

    Returns
    -------
    Drawing
        Four matrices divided by the standard deviations before, and below them the entries that each step changes.
    """
    steps = block_steps(predict, update_landmarks, add_landmark)
    *_, last = steps.values()
    sigma = np.sqrt(np.diag(last))
    first = next(iter(steps.values()))
    sigma[: len(first)] = np.sqrt(np.diag(first))
    figure = Figure(figsize=(11.4, 5.6))
    axes = figure.subplots(2, len(steps))
    before, said = first, []
    for (above, below), (title, covariance) in zip(axes.T, steps.items(), strict=True):
        n = len(covariance)
        image = plot_blocks(above, np.clip(covariance / np.outer(sigma[:n], sigma[:n]), -1, 1))
        above.set_title(title, fontsize=11)
        marks = changed(before, covariance)
        _plot_changed(below, marks)
        said.append(f"{title}: {_say_changed(marks)}")
        before = covariance
    figure.colorbar(
        image, ax=list(axes[0]), label="divided by the standard\ndeviations before", ticks=[-1, 0, 1]
    )
    # An invisible bar, so that both rows have the same width
    figure.colorbar(image, ax=list(axes[1])).ax.set_visible(False)
    legend_below(figure, [Patch(fc=CHANGED(1.0), ec=GREY, label="changed or new in this step")])
    return Drawing(figure, "Covariance of pose and map, and the entries that change. " + " ".join(said[1:]))


def _plot_changed(ax: Axes, marks: FloatArray) -> None:
    """Plot the changed entries, with the names of the blocks."""
    plot_blocks(ax, marks).set(cmap=CHANGED, clim=(0, 1))
    middle = (2 + len(marks)) / 2
    for x, y, name in ((1, 1, "pp"), (middle, 1, "pl"), (1, middle, "lp"), (middle, middle, "ll")):
        ax.text(x, y, f"$P_{{{name}}}$", ha="center", va="center", fontsize=13)


def _say_changed(marks: FloatArray) -> str:
    """Describe in words which share of each block has changed."""
    blocks: Mapping[str, FloatArray] = {"P_pp": marks[:3, :3], "P_pl": marks[:3, 3:], "P_ll": marks[3:, 3:]}
    return ", ".join(f"{100 * block.mean():.0f} % of {name}" for name, block in blocks.items()) + "."
