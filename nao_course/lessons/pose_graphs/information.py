"""The frame of an edge's information, found from residuals at the truth in standard deviations."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray
from nao_course.lessons.pose_graphs.worlds import ODOMETRY_SIGMA, building
from nao_course.plotting import STYLES, Drawing, course_style
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import FOUND, GREY

Residual = Callable[[FloatArray, FloatArray, FloatArray], FloatArray]

SEEDS = range(1, 31)
FRAMES = ("the frame of the pose that z predicts", "the first pose's frame")


def missed_steps(pose_residual: Residual, seeds: Sequence[int] = SEEDS) -> tuple[FloatArray, FloatArray]:
    """Return residuals at the truth and measurements, (S, 3) each, in m, m, rad, of the odometry in some buildings."""
    residuals, measured = [], []
    for seed in seeds:
        world = building(seed)
        edges, poses = world.graph.pose_edges, world.graph.split(world.truth)[0]
        steps = ~world.closures()
        ends = poses[edges.first[steps]], poses[edges.second[steps]]
        residuals.append(np.asarray(pose_residual(*ends, edges.z[steps]), dtype=float))
        measured.append(edges.z[steps])
    return np.concatenate(residuals), np.concatenate(measured)


def scaled(residuals: FloatArray, measured: FloatArray, frame: str) -> FloatArray:
    """Return the x and y of residuals (S, 2) in standard deviations along and across, in one of the frames."""
    away = residuals[:, :2]
    if frame == FRAMES[1]:
        c, s = np.cos(measured[:, 2]), np.sin(measured[:, 2])
        away = np.einsum("ijk,kj->ki", np.array([[c, -s], [s, c]]), away)
    return away / ODOMETRY_SIGMA[:2]


@course_style()
def draw_information_frames(pose_residual: Residual) -> Drawing:
    """Draw the residuals across straight steps and across corners, for two frames of the information.

    Parameters
    ----------
    pose_residual : callable
        The student's.

    Returns
    -------
    Drawing
        Two plots.
    """
    residuals, measured = missed_steps(pose_residual)
    corners = np.abs(np.sin(measured[:, 2])) > 0.5
    said = []
    figure = Figure(figsize=(11.4, 3.9))
    axes = figure.subplots(1, 2, sharex=True, sharey=True)
    for ax, frame in zip(axes, FRAMES, strict=True):
        found = scaled(residuals, measured, frame)
        spread = [np.sqrt(np.mean(found[chosen] ** 2, axis=0)) for chosen in (~corners, corners)]
        _plot_spread(found[~corners, 1], found[corners, 1], ax)
        ax.set_title(
            f"σ given in {frame}\nat corners {spread[1][0]:.2f} σ along and {spread[1][1]:.2f} σ across",
            fontsize=11,
        )
        said.append(
            f"in {frame}, the residuals of straight steps are {spread[0][0]:.2f} and {spread[0][1]:.2f} standard "
            f"deviations along and across, of corners {spread[1][0]:.2f} and {spread[1][1]:.2f}"
        )
    axes[0].set_ylabel("density (per σ)")
    legend_below(figure, axes[0].get_legend_handles_labels()[0], columns=3)
    return Drawing(
        figure,
        f"{len(residuals):,} steps at the truth. With the odometry's standard deviations {'; '.join(said)}.",
    )


def _plot_spread(straight: FloatArray, corners: FloatArray, ax: Axes) -> None:
    """Plot histograms of the residuals across, and the density of a normal distribution."""
    bins = np.linspace(-5, 5, 41).tolist()
    at = np.linspace(-5, 5, 201)
    ax.hist(straight, bins, density=True, color=GREY, alpha=0.45, label="straight steps")
    ax.hist(corners, bins, density=True, histtype="step", color=FOUND, lw=2.0, label="steps around a corner")
    bell = np.exp(-(at**2) / 2) / np.sqrt(2 * np.pi)
    ax.plot(
        at, bell, color=STYLES["truth"].colour, lw=1.4, ls="--", label="predicted by Ω: standard deviation 1"
    )
    ax.set(xlabel="residual across the path (in σ)", xlim=(-5, 5))
