"""Figures of estimates on the field: a robot that starts with a wrong estimate, and samples in their ellipses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse
from scipy.special import chdtri

from nao_course.geometry import FloatArray, Pose, pose_errors
from nao_course.lessons.localization.drives import (
    FIELD,
    KINDS,
    LANDMARKS,
    LandmarkMeasurement,
    checked,
    measure_landmark,
    updated,
)
from nao_course.metrics import squared_distances
from nao_course.plotting import (
    STYLES,
    Drawing,
    Guess,
    course_style,
    guessed,
    plot_field,
    plot_landmarks,
    plot_pose,
)
from nao_course.plotting.guesses import GUESS
from nao_course.plotting.halo import HALO
from nao_course.plotting.legends import legend_below, source_key
from nao_course.plotting.style import GREY
from nao_course.sim import SensorNoise

TRUE, START = Pose(1.7, 0.5, 0.25), Pose(1.15, 0.1, 0.5)  # true pose, and the wrong estimate at the start
START_COVARIANCE = np.diag([0.4**2, 0.4**2, np.radians(15) ** 2])  # m^2, rad^2
IN_PICTURE = (9, 7, 6)  # rows of LANDMARKS in one picture: a post and two corners of the goal area
SEED = 12
PICTURES = 60  # repetitions with other noise
LINE = 0.4  # m, length of the line in a pose's heading
SMALL = 5.0  # points, width of a marker that does not cover a small ellipse
ONE_SIGMA = 1 - np.exp(-0.5)  # fraction of a plane Gaussian inside its one-sigma ellipse


@dataclass(frozen=True, eq=False)
class PoseEstimate:
    """An estimated pose (3,) and its covariance (3, 3): m, rad; field frame."""

    pose: FloatArray
    covariance: FloatArray

    def error(self, truth: Pose) -> tuple[float, float]:
        """Return the distance to the true pose in metres, and the absolute heading error in degrees."""
        off = pose_errors(self.pose, truth.as_array())
        return float(np.hypot(*off[:2])), float(np.degrees(np.abs(off[2])))


def measure_one_picture(
    localize: Callable[..., Any], seed: int = SEED
) -> tuple[list[LandmarkMeasurement], list[PoseEstimate]]:
    """Update the wrong estimate with K landmarks of one picture; return them and the K + 1 estimates around them."""
    rng = np.random.default_rng(seed)
    measured = [measure_landmark(TRUE, number, SensorNoise(), rng) for number in IN_PICTURE]
    estimates = [PoseEstimate(START.as_array(), START_COVARIANCE)]
    for each in measured:
        estimates.append(PoseEstimate(*updated(localize, estimates[-1].pose, estimates[-1].covariance, each)))
    return measured, estimates


@course_style()
def draw_wrong_start(localize: Callable[..., Any], covariance_ellipse: Callable[..., Any]) -> Drawing:
    """Draw how one picture corrects a wrong estimate.

    Parameters
    ----------
    localize, covariance_ellipse : callable
        The student's functions.

    Returns
    -------
    Drawing
        Four maps: before the picture, and after each of its three landmarks; 95 % ellipses.
    """
    measured, estimates = measure_one_picture(localize)
    titles = ("A wrong estimate", "After a post", "After a corner", "After a second corner")
    figure = Figure(figsize=(11.0, 4.7))
    axes = figure.subplots(1, len(estimates), sharey=True)
    words = []
    for number, (ax, estimate, title) in enumerate(zip(axes, estimates, titles, strict=True)):
        plot_field(FIELD, ax)
        plot_landmarks(LANDMARKS, KINDS, ax, GREY, size=6)
        for each in measured[:number]:
            _plot_measurement(ax, TRUE, each, faint=each is not measured[number - 1])
        plot_pose(TRUE, ax, length=LINE, size=SMALL)
        axes_and_angle = ellipse_of(covariance_ellipse, estimate.covariance[:2, :2], 0.95)
        add_ellipse(ax, estimate.pose[:2], *axes_and_angle, STYLES["ekf"].colour, order=7)
        plot_pose(Pose.from_array(estimate.pose), ax, "ekf", LINE, SMALL)
        off, turned = estimate.error(TRUE)
        ax.set_title(title)
        ax.set_xlabel(f"x (m)\nerror {off:.2f} m and {turned:.0f}°")
        ax.set_ylabel("y (m)" if number == 0 else "")
        words.append(f"{title}: {off:.2f} m and {turned:.0f} degrees")
    legend_below(
        figure,
        [
            source_key("truth", "true pose"),
            source_key("ekf", "estimate with its 95 % ellipse"),
            Line2D(
                [],
                [],
                color=STYLES["truth"].colour,
                lw=1.2,
                ls=":",
                label="measured landmark",
                path_effects=HALO,
            ),
        ],
    )
    return Drawing(
        figure,
        "Half a field from above, four times, with the true pose of a robot, its estimate and the "
        "estimate's 95 % ellipse. Each landmark makes the ellipse smaller. "
        f"Errors: {'; '.join(words)}.",
    )


def nees_of_pictures(localize: Callable[..., Any]) -> FloatArray:
    """Return the NEES of the last estimate for each of `PICTURES` repetitions of the picture, smallest first."""
    last = [measure_one_picture(localize, seed)[1][-1] for seed in range(PICTURES)]
    errors = pose_errors(np.array([each.pose for each in last]), TRUE.as_array())
    return np.sort(squared_distances(errors, np.array([each.covariance for each in last])))


@course_style()
def draw_wrong_starts(localize: Callable[..., Any]) -> Drawing:
    """Draw the NEES of the estimate after the picture, for many repetitions with other noise of the measurements.

    Parameters
    ----------
    localize : callable
        The student's function.

    Returns
    -------
    Drawing
        The NEES in ascending order, beside the values that a consistent filter would have.
    """
    nees = nees_of_pictures(localize)
    shares = (np.arange(len(nees)) + 0.5) / len(nees)
    median = float(np.median(nees))
    figure = Figure(figsize=(7.0, 3.8))
    ax = figure.subplots()
    ax.plot(100 * shares, nees, "o", color=STYLES["ekf"].colour, ms=5, mec="white", label="your filter")
    ax.plot(
        100 * shares, chdtri(3, 1 - shares), color=GREY, lw=2, label="a consistent filter (chi-square, 3)"
    )
    ax.set(xlabel=f"share of the {len(nees)} pictures (%)", ylabel="NEES or less", yscale="log")
    ax.set_title(f"median NEES {median:.1f}, a consistent filter: {chdtri(3, 0.5):.1f}", fontsize=11)
    legend_below(figure, ax.get_legend_handles_labels()[0])
    return Drawing(
        figure,
        f"NEES of the estimate after three landmarks, for {len(nees)} pictures with other noise, in ascending order. "
        f"Their median is {median:.1f}; a consistent filter has {chdtri(3, 0.5):.1f}.",
    )


@course_style()
def draw_cloud(
    covariance: npt.ArrayLike,
    covariance_ellipse: Callable[..., Any],
    probabilities: Sequence[float],
    samples: int = 2000,
    guess: Guess | None = None,
) -> Drawing:
    """Draw samples of a Gaussian, and the ellipses that should contain given fractions of them.

    Parameters
    ----------
    covariance : array_like, shape (2, 2)
        m^2.
    covariance_ellipse : callable
        The student's function.
    probabilities : sequence of float
        One for each ellipse.
    samples : int
        Number of points, drawn from seed 6.
    guess : Guess, optional
        Predicted percentage inside the one-sigma ellipse; the ellipse that contains it is added.

    Returns
    -------
    Drawing
        The figure; its text states the fraction inside each ellipse.
    """
    matrix = np.asarray(covariance, dtype=float)
    points = cloud(matrix, samples)
    figure = Figure(figsize=(8.6, 4.3))
    ax = figure.add_subplot()
    ax.plot(*points.T, ".", color=GREY, ms=2.5, alpha=0.6, zorder=2)
    words = []
    for probability, line in zip(probabilities, ("-", "--", ":"), strict=False):
        axes, angle = ellipse_of(covariance_ellipse, matrix, probability)
        part = inside(points, axes, angle)
        colour = STYLES["ekf"].colour
        add_ellipse(
            ax,
            np.zeros(2),
            axes,
            angle,
            colour,
            ls=line,
            label=f"{_name_of(probability)}: {100 * part:.1f} % inside",
        )
        words.append(f"{100 * part:.1f} % are inside the {_name_of(probability)}")
    percent = guess and guessed(guess)
    if percent and percent < 100:
        axes, angle = ellipse_of(covariance_ellipse, matrix, percent / 100)
        add_ellipse(ax, np.zeros(2), axes, angle, GUESS, ls=":", label=f"you: {percent:g} % inside")
        words.append(f"a dotted ellipse contains the {percent:g} % that you predicted")
    ax.set(aspect="equal", xlim=(-1.1, 1.1), xticks=np.arange(-1, 1.1, 0.5))
    ax.set(xlabel="error along x (m)", ylabel="error along y (m)")
    legend_below(figure, ax.get_legend_handles_labels()[0], columns=3)
    return Drawing(figure, f"{samples} points of a Gaussian distribution: {', '.join(words)}.")


def _name_of(probability: float) -> str:
    """Return the name of the ellipse with this probability."""
    if np.isclose(probability, ONE_SIGMA):
        return "one-sigma ellipse"
    return f"{100 * probability:.0f} % ellipse"


def cloud(covariance: npt.ArrayLike, samples: int = 2000) -> FloatArray:
    """Draw points (N, 2) from a Gaussian around 0 with this covariance (2, 2); the same at each call."""
    return np.random.default_rng(6).multivariate_normal(
        np.zeros(2), np.asarray(covariance, dtype=float), samples
    )


def inside(points: FloatArray, semi_axes: npt.ArrayLike, angle: float) -> float:
    """Return the fraction of points (N, 2) inside an ellipse around 0 whose first axis is at `angle` (rad)."""
    along = points @ np.array([np.cos(angle), np.sin(angle)])
    across = points @ np.array([-np.sin(angle), np.cos(angle)])
    first, second = np.maximum(np.asarray(semi_axes, dtype=float), 1e-12)
    return float(np.mean((along / first) ** 2 + (across / second) ** 2 <= 1))


def _plot_measurement(ax: Axes, pose: Pose, seen: LandmarkMeasurement, faint: bool = False) -> None:
    x, y = seen.position
    ax.plot(
        [pose.x, x],
        [pose.y, y],
        color=STYLES["truth"].colour,
        lw=1.2,
        ls=":",
        alpha=0.35 if faint else 0.9,
        zorder=4,
    )


def ellipse_of(
    covariance_ellipse: Callable[..., Any], covariance: FloatArray, probability: float
) -> tuple[FloatArray, float]:
    """Return semi-axes (2,) and angle from a student's `covariance_ellipse`; refuse other shapes."""
    semi_axes, angle = covariance_ellipse(covariance.copy(), probability)
    return checked(semi_axes, (2,), "covariance_ellipse: semi_axes"), float(angle)


def add_ellipse(
    ax: Axes,
    centre: FloatArray,
    semi_axes: FloatArray,
    angle: float,
    colour: str,
    ls: str = "-",
    label: str = "",
    lw: float = 1.8,
    order: float = 3.6,
) -> None:
    """Draw an ellipse, given its semi-axes (2,) and the angle of the first one (rad)."""
    x, y = centre.tolist()
    width, height = (2 * semi_axes).tolist()
    degrees = float(np.degrees(angle))
    edge = Ellipse((x, y), width, height, angle=degrees, fc="none", ec=colour, lw=lw, ls=ls, zorder=order)
    edge.set_label(label)
    ax.add_patch(edge)
    ax.add_patch(Ellipse((x, y), width, height, angle=degrees, fc=colour, alpha=0.12, zorder=3.5))
