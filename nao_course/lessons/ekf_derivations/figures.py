"""Figures of lesson 05: samples and the ellipse that a linearisation predicts for them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from nao_course.geometry import FloatArray
from nao_course.lessons.ekf_derivations.samples import SAMPLES, Cloud, draw, each_moved
from nao_course.plotting import STYLES, Drawing, course_style, plot_ellipse
from nao_course.plotting.halo import HALO
from nao_course.plotting.legends import legend_below
from nao_course.plotting.style import GREY

Function = Callable[..., Any]

TRUTH, ESTIMATE = STYLES["truth"], STYLES["ekf"]
STEP = 1.0  # m, each of the payoff's three steps
# Covariance of one step: along and across, m^2, and turn, rad^2.
STEP_NOISE = np.diag([0.04, 0.03, np.radians(1.0)]) ** 2
PAYOFF_DEGREES = (5, 15, 30)  # standard deviations of the heading
START_NOISE = (0.03, 0.03)  # m, standard deviations of the starting position


def plot_cloud(
    cloud: Cloud, ax: Axes, colour: str = TRUTH.colour, scale: Sequence[float] = (1.0, 1.0)
) -> None:
    """Draw samples with their mean, and the predicted mean with its 95 % ellipse, all multiplied by `scale`."""
    factors = np.asarray(scale)
    ax.plot(*(cloud.points * factors).T, ".", color=colour, ms=3, alpha=0.45, mew=0)
    plot_ellipse(cloud.mean * factors, cloud.covariance * np.outer(factors, factors), ax)
    ax.plot(*(cloud.mean * factors), ESTIMATE.marker, color=ESTIMATE.colour, ms=12, mec="white", zorder=5)
    ax.plot(*(cloud.sampled_mean * factors), "X", color=colour, ms=7.5, mec="white", mew=0.9, zorder=6)


def cloud_keys(samples: str = "samples") -> list[Line2D | Patch]:
    """Return the legend entries for `plot_cloud`."""
    return [
        Line2D([], [], color=TRUTH.colour, marker=".", ls="", ms=6, label=samples),
        Line2D(
            [],
            [],
            color=TRUTH.colour,
            marker="X",
            ls="",
            ms=7.5,
            mec="white",
            mew=0.9,
            label="mean of the dots",
        ),
        Line2D(
            [],
            [],
            color=ESTIMATE.colour,
            marker=ESTIMATE.marker,
            ls="",
            ms=9,
            mec="white",
            label="predicted mean",
        ),
        Patch(facecolor="#0b5fa529", edgecolor=ESTIMATE.colour, label="predicted 95 % ellipse"),
    ]


# --- the payoff ---


def bending_clouds(predict_pose: Function, predict_covariance: Function, heading_sigma: float) -> list[Cloud]:
    """Simulate three steps of 1 m from (0, 0, 0) with an uncertain heading (rad): a cloud after each step."""
    rng = np.random.default_rng(5)
    pose, control = np.zeros(3), np.array([STEP, 0.0])
    covariance = np.diag([*START_NOISE, heading_sigma]) ** 2
    robots = draw(pose, covariance, SAMPLES, rng)
    clouds = []
    for _ in range(3):
        robots = each_moved(predict_pose, robots, control, draw(np.zeros(3), STEP_NOISE, SAMPLES, rng))
        covariance = np.asarray(predict_covariance(covariance, pose, control.copy(), STEP_NOISE), dtype=float)
        pose = np.asarray(predict_pose(pose, control.copy()), dtype=float)
        clouds.append(Cloud(robots[:, :2], pose[:2], covariance[:2, :2]))
    return clouds


@course_style()
def draw_bending(predict_pose: Function, predict_covariance: Function) -> Drawing:
    """Draw 500 robots that drive three metres with an uncertain heading, and the ellipses predicted for them.

    Parameters
    ----------
    predict_pose : callable
        ``predict_pose(pose, control)`` returns the next pose (3,).
    predict_covariance : callable
        ``predict_covariance(covariance, pose, control, control_covariance)`` returns the next covariance (3, 3).

    Returns
    -------
    Drawing
        Three panels, for headings known to 5, 15 and 30 degrees; the text says how many robots are inside.
    """
    said = []
    figure = Figure(figsize=(9.0, 5.0))
    for ax, degrees in zip(figure.subplots(1, 3, sharey=True), PAYOFF_DEGREES, strict=True):
        clouds = bending_clouds(predict_pose, predict_covariance, np.radians(degrees))
        for cloud in clouds:
            plot_cloud(cloud, ax)
        ax.plot(0, 0, "o", color=TRUTH.colour, ms=8, mec="white", zorder=6)
        ax.annotate("start", (0, 0), (0, -9), textcoords="offset points", ha="center", va="top")
        ax.set(aspect="equal", xlim=(-0.5, 3.7), ylim=(-4.2, 4.7), xlabel="x (m)")
        ax.set_title(f"heading known to {degrees}°", fontsize=11)
        inside = [round(100 * cloud.inside()) for cloud in clouds]
        for cloud, share in zip(clouds, inside, strict=True):
            top = cloud.mean[1] + 2.45 * np.sqrt(cloud.covariance[1, 1]) + 0.15  # above the ellipse
            ax.text(cloud.mean[0], top, f"{share} %", ha="center", color=ESTIMATE.colour, path_effects=HALO)
        said.append(f"{degrees} degrees: {inside[0]}, {inside[1]} and {inside[2]} % of the robots are inside")
    figure.axes[0].set_ylabel("y (m)")
    legend_below(figure, cloud_keys("500 robots"))
    return Drawing(
        figure,
        "500 robots after 1, 2 and 3 m, with the ellipses that should hold 95 % of them. Heading known to "
        f"{'; to '.join(said)}: the last clouds are bent like bananas, but the ellipses are not.",
    )


# --- two landmarks measured from one pose ---


@course_style()
def draw_correlation(points: FloatArray, correlation: float) -> Drawing:
    """Draw the errors (N, 2) of two landmarks, measured from the same pose, against each other, along y in m."""
    measured = float(np.asarray(np.corrcoef(points.T))[0, 1])
    figure = Figure(figsize=(5.2, 4.4))
    ax = figure.subplots()
    ax.axhline(0, color=GREY, lw=0.8)
    ax.axvline(0, color=GREY, lw=0.8)
    ax.plot(*points.T, ".", color=TRUTH.colour, ms=4, alpha=0.5, mew=0)
    ax.set(aspect="equal", xlabel="error of landmark 1 along y (m)", ylabel="error of landmark 2 along y (m)")
    ax.set_title(f"Correlation: {measured:.2f} (Jacobians: {correlation:.2f})", fontsize=11)
    return Drawing(
        figure,
        f"Errors of two landmarks along y, {len(points)} times. They lie along a rising line: their correlation is "
        f"{measured:.2f}, and the Jacobians give {correlation:.2f}.",
    )


# --- where the linearisation fails ---


@course_style()
def draw_curves(
    sigmas: npt.ArrayLike, measured: Mapping[str, FloatArray], predicted: Mapping[str, FloatArray]
) -> Drawing:
    """Draw the errors of a linearisation against the heading's standard deviation.

    By title, `measured` has (S, 3), the low end, the mean and the high end, and `predicted` (S,), the values of a
    formula. The standard deviations (S,) are in radians.
    """
    degrees = np.degrees(np.asarray(sigmas, dtype=float))
    said = []
    figure = Figure(figsize=(9.9, 3.7))
    for ax, (title, values) in zip(figure.subplots(1, len(measured)), measured.items(), strict=True):
        low, middle, high = values.T
        ax.errorbar(
            degrees,
            middle,
            [middle - low, high - middle],
            color=TRUTH.colour,
            fmt=TRUTH.marker,
            ms=5,
            mec="white",
            lw=1.3,
        )
        if title in predicted:
            ax.plot(degrees, predicted[title], color=ESTIMATE.colour, lw=2, zorder=0)
        else:
            ax.axhline(95, color=ESTIMATE.colour, lw=2, ls=ESTIMATE.line, zorder=0)
        ax.set(xlabel="σ of the heading (degrees)", xticks=range(0, 61, 15))
        ax.set_title(title, fontsize=11)
        at = ", ".join(f"{np.interp(d, degrees, middle):.2g} at {d}°" for d in (5, 15, 30, 45))
        said.append(f"{title}: {at}")
    keys = [
        Line2D(
            [],
            [],
            color=TRUTH.colour,
            marker=TRUTH.marker,
            ls="",
            mec="white",
            label="mean and 95 % of 20 runs with 2,000 samples (drive of 1 m, position known to 3 cm)",
        ),
        Line2D([], [], color=ESTIMATE.colour, lw=2, label="formula"),
        Line2D([], [], color=ESTIMATE.colour, lw=2, ls=ESTIMATE.line, label="should be 95 %"),
    ]
    legend_below(figure, keys)
    return Drawing(figure, "Against the heading's standard deviation. " + ". ".join(said) + ".")
