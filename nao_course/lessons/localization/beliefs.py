"""Figures of beliefs on the field: a robot put down wrongly, a cloud in its ellipse, a bearing that is not wrapped."""

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

from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.lessons.localization.drives import (
    FIELD,
    KINDS,
    LANDMARKS,
    Sight,
    checked,
    look_at,
    updated,
)
from nao_course.plotting import STYLES, Drawing, course_style, plot_field, plot_landmarks, plot_pose
from nao_course.plotting.legends import legend_below, source_key
from nao_course.plotting.style import GREY, HALO
from nao_course.sim import SensorNoise

TRUE, BELIEVED = Pose(1.7, 0.5, 0.25), Pose(1.15, 0.1, 0.5)  # of the robot that is put down wrongly
DOUBT = np.diag([0.4**2, 0.4**2, np.radians(15) ** 2])  # m^2, rad^2
LOOK = (9, 7, 6)  # rows of LANDMARKS in one picture: a post and two corners of the goal area
SEED = 12

# Looking over the shoulder, as far as head and camera reach: the landmark is at 149 degrees, expected at -176.
BEHIND_TRUE, BEHIND_BELIEVED = Pose(1.6, 0.9, float(np.radians(-4))), Pose(1.5, 1.0, float(np.radians(-38)))
BEHIND_DOUBT = np.diag([0.3**2, 0.3**2, np.radians(20) ** 2])
BEHIND = 1  # row of LANDMARKS: the corner of halfway line and left touch line


@dataclass(frozen=True, eq=False)
class Belief:
    """A pose (3,) and its covariance (3, 3): m, rad; field frame."""

    pose: FloatArray
    covariance: FloatArray

    def error(self, truth: Pose) -> tuple[float, float]:
        """How far it is off: metres, and degrees without sign."""
        off = self.pose - truth.as_array()
        return float(np.hypot(*off[:2])), float(np.degrees(np.abs(wrap_angle(off[2]))))


def one_look(localize: Callable[..., Any]) -> tuple[list[Sight], list[Belief]]:
    """Let the robot that was put down wrongly look once.

    Parameters
    ----------
    localize : callable
        The student's; called for each landmark in the picture.

    Returns
    -------
    list of Sight, list of Belief
        K landmarks, and K + 1 beliefs: before, and after each of them.
    """
    rng = np.random.default_rng(SEED)
    sights = [look_at(TRUE.as_array(), number, SensorNoise(), rng) for number in LOOK]
    beliefs = [Belief(BELIEVED.as_array(), DOUBT)]
    for sight in sights:
        beliefs.append(Belief(*updated(localize, beliefs[-1].pose, beliefs[-1].covariance, sight)))
    return sights, beliefs


def draw_put_down_wrongly(localize: Callable[..., Any], covariance_ellipse: Callable[..., Any]) -> Drawing:
    """Draw how a robot that was put down in a wrong place finds back with one look.

    Parameters
    ----------
    localize, covariance_ellipse : callable
        The student's.

    Returns
    -------
    Drawing
        Four maps: before the look, and after each of its three landmarks; 95 % ellipses.
    """
    sights, beliefs = one_look(localize)
    titles = ("Put down wrongly", "It sees a post,", "a corner,", "and another corner")
    with course_style():
        figure = Figure(figsize=(11.0, 4.7))
        axes = figure.subplots(1, len(beliefs), sharey=True)
        words = []
        for number, (ax, belief, title) in enumerate(zip(axes, beliefs, titles, strict=True)):
            _plot_map(ax)
            for sight in sights[:number]:
                _plot_sight(ax, TRUE, sight, faint=sight is not sights[number - 1])
            plot_pose(TRUE, ax)
            _plot_belief(ax, belief, covariance_ellipse)
            off, turned = belief.error(TRUE)
            ax.set_title(title)
            ax.set_xlabel(f"x (m)\n{off:.2f} m and {turned:.0f}° off")
            ax.set_ylabel("y (m)" if number == 0 else "")
            words.append(f"{title.rstrip(',')}: {off:.2f} m and {turned:.0f} degrees off")
        legend_below(figure, [*_keys("believed, with its 95 % ellipse"), _sight_key()])
    return Drawing(
        figure,
        "Half a field from above, four times. A robot believes to be in another place than it is, in a "
        "wide ellipse. With "
        f"each landmark that it sees the ellipse shrinks around the true place. {'; '.join(words)}.",
    )


def draw_cloud(
    covariance: npt.ArrayLike,
    covariance_ellipse: Callable[..., Any],
    probabilities: Sequence[float],
    samples: int = 2000,
) -> Drawing:
    """Draw points of a Gaussian distribution, and the ellipses that should hold given parts of them.

    Parameters
    ----------
    covariance : array_like, shape (2, 2)
        m^2.
    covariance_ellipse : callable
        The student's.
    probabilities : sequence of float
        Parts of the probability.
    samples : int
        How many points, drawn from seed 6.

    Returns
    -------
    Drawing
        The figure; its text has the parts that are inside.
    """
    matrix = np.asarray(covariance, dtype=float)
    points = cloud(matrix, samples)
    with course_style():
        figure = Figure(figsize=(8.6, 4.3))
        ax = figure.add_subplot()
        ax.plot(*points.T, ".", color=GREY, ms=2.5, alpha=0.6, zorder=2)
        words = []
        for probability, line in zip(probabilities, ("-", "--", ":"), strict=False):
            axes, angle = _ellipse_of(covariance_ellipse, matrix, probability)
            part = inside(points, axes, angle)
            colour = STYLES["ekf"].colour
            _add_ellipse(
                ax,
                np.zeros(2),
                axes,
                angle,
                colour,
                ls=line,
                label=f"for {100 * probability:.0f} %: {100 * part:.1f} % inside",
            )
            words.append(f"{100 * part:.1f} % are inside the ellipse for {100 * probability:.0f} %")
        ax.set(aspect="equal", xlim=(-1.1, 1.1), xticks=np.arange(-1, 1.1, 0.5))
        ax.set(xlabel="error along x (m)", ylabel="error along y (m)")
        legend_below(figure, ax.get_legend_handles_labels()[0], columns=3)
    return Drawing(figure, f"{samples} points of a Gaussian distribution: {', '.join(words)}.")


def cloud(covariance: npt.ArrayLike, samples: int = 2000) -> FloatArray:
    """Points (N, 2) of a Gaussian distribution around 0 with this covariance (2, 2); the same at each call."""
    return np.random.default_rng(6).multivariate_normal(
        np.zeros(2), np.asarray(covariance, dtype=float), samples
    )


def inside(points: FloatArray, semi_axes: npt.ArrayLike, angle: float) -> float:
    """Which part of points (N, 2) lies in an ellipse around 0, its first axis at `angle` (rad)."""
    along = points @ np.array([np.cos(angle), np.sin(angle)])
    across = points @ np.array([-np.sin(angle), np.cos(angle)])
    first, second = np.maximum(np.asarray(semi_axes, dtype=float), 1e-12)
    return float(np.mean((along / first) ** 2 + (across / second) ** 2 <= 1))


def behind() -> Sight:
    """The landmark behind the robot, as it is measured."""
    return look_at(BEHIND_TRUE.as_array(), BEHIND, SensorNoise(), np.random.default_rng(SEED))


def jump(localize: Callable[..., Any]) -> float:
    """How far the robot is from where it believes to be after the look over its shoulder, in metres."""
    pose, covariance = updated(localize, BEHIND_BELIEVED.as_array(), BEHIND_DOUBT, behind())
    return Belief(pose, covariance).error(BEHIND_TRUE)[0]


def draw_not_wrapped(
    localize: Callable[..., Any], unwrapped: Callable[..., Any], covariance_ellipse: Callable[..., Any]
) -> Drawing:
    """Draw what one bearing that is not wrapped does.

    Parameters
    ----------
    localize, unwrapped : callable
        The student's, and the same with a plain difference for an innovation.
    covariance_ellipse : callable
        The student's.

    Returns
    -------
    Drawing
        Three maps: before, with the bearing wrapped, and without.
    """
    start, sight = Belief(BEHIND_BELIEVED.as_array(), BEHIND_DOUBT), behind()
    shown = {
        "Before the look": start,
        "Wrapped": Belief(*updated(localize, start.pose, start.covariance, sight)),
        "Not wrapped": Belief(*updated(unwrapped, start.pose, start.covariance, sight)),
    }
    with course_style():
        figure = Figure(figsize=(10.2, 5.0))
        words = []
        for number, (ax, (title, belief)) in enumerate(
            zip(figure.subplots(1, 3, sharey=True), shown.items(), strict=True)
        ):
            _plot_map(ax)
            _plot_sight(ax, BEHIND_TRUE, sight)
            plot_pose(BEHIND_TRUE, ax)
            _plot_belief(ax, belief, covariance_ellipse)
            off, turned = belief.error(BEHIND_TRUE)
            ax.set_title(title)
            ax.set_xlabel(f"x (m)\n{off:.2f} m and {turned:.0f}° off")
            ax.set_ylabel("y (m)" if number == 0 else "")
            ax.set_ylim(-2.7, 3.4)
            words.append(f"{title}: {off:.2f} m and {turned:.0f} degrees off")
        legend_below(figure, [*_keys("believed, with its 95 % ellipse"), _sight_key()])
    return Drawing(figure, f"One look at a corner behind the robot. {'; '.join(words)}.")


def _plot_map(ax: Axes) -> None:
    plot_field(FIELD, ax)
    plot_landmarks(LANDMARKS, KINDS, ax, GREY, size=6)


def _plot_sight(ax: Axes, pose: Pose, sight: Sight, faint: bool = False) -> None:
    x, y = sight.position
    ax.plot(
        [pose.x, x],
        [pose.y, y],
        color=STYLES["truth"].colour,
        lw=1.2,
        ls=":",
        alpha=0.35 if faint else 0.9,
        zorder=4,
    )


def _plot_belief(ax: Axes, belief: Belief, covariance_ellipse: Callable[..., Any]) -> None:
    axes, angle = _ellipse_of(covariance_ellipse, belief.covariance[:2, :2], 0.95)
    _add_ellipse(ax, belief.pose[:2], axes, angle, STYLES["ekf"].colour)
    plot_pose(Pose.from_array(belief.pose), ax, "ekf")


def _ellipse_of(
    covariance_ellipse: Callable[..., Any], covariance: FloatArray, probability: float
) -> tuple[FloatArray, float]:
    semi_axes, angle = covariance_ellipse(covariance.copy(), probability)
    return checked(semi_axes, (2,), "covariance_ellipse: semi_axes"), float(angle)


def _add_ellipse(
    ax: Axes,
    centre: FloatArray,
    semi_axes: FloatArray,
    angle: float,
    colour: str,
    ls: str = "-",
    label: str = "",
) -> None:
    x, y = centre.tolist()
    width, height = (2 * semi_axes).tolist()
    shape = Ellipse(
        (x, y), width, height, angle=float(np.degrees(angle)), fc="none", ec=colour, lw=1.8, ls=ls, zorder=3.6
    )
    shape.set_label(label)
    ax.add_patch(shape)
    ax.add_patch(
        Ellipse((x, y), width, height, angle=float(np.degrees(angle)), fc=colour, alpha=0.12, zorder=3.5)
    )


def _keys(believed: str) -> list[Line2D]:
    return [source_key("truth", "where it is"), source_key("ekf", believed)]


def _sight_key() -> Line2D:
    return Line2D(
        [], [], color=STYLES["truth"].colour, lw=1.2, ls=":", label="landmark seen", path_effects=HALO
    )
