"""The lap: 200 robots get the same commands, and the student's functions estimate where one of them is."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from nao_course.geometry import FloatArray
from nao_course.lessons.ekf_derivations.samples import Cloud
from nao_course.plotting import STYLES, Drawing, Guess, course_style, plot_ellipse, plot_path, with_guess
from nao_course.plotting.legends import legend_below
from nao_course.sim import OdometryNoise, repeat_drive
from nao_course.slam import Motion
from nao_course.widgets import PlayerPanel, Slider

Function = Callable[..., Any]

SIDE_STEPS, STEP = 6, 0.25  # commands on each side of the square; m
LAP = tuple(Motion(STEP, np.pi / 2 if number % SIDE_STEPS == 0 else 0.0) for number in range(1, 25))
ROBOTS = 200
NOISE = OdometryNoise()  # the simulated robot's own
TRUTH, ESTIMATE = STYLES["truth"], STYLES["ekf"]
_UNFINISHED = {
    "predict_pose": "Finish exercise 5.1 to see this.",
    "predict_covariance": "Finish exercises 5.4 and 5.5 to see this.",
}


@dataclass(frozen=True, eq=False)
class Estimates:
    """Estimated poses (M, 3) at the start and after each command, and their covariances (M, 3, 3), if there are any."""

    poses: FloatArray
    covariances: FloatArray | None


@cache
def true_paths(robots: int = ROBOTS) -> FloatArray:
    """Simulate the lap with each robot's own errors: poses (robots, 25, 3)."""
    return repeat_drive(list(LAP), robots, np.random.default_rng(5), NOISE)


def typical_distance() -> float:
    """Return the median distance (m) between start and end of the lap, in 5,000 simulated laps."""
    return float(np.median(np.hypot(*true_paths(5000)[:, -1, :2].T)))


def estimates(
    predict_pose: Function | None, predict_covariance: Function | None, steps: int = len(LAP)
) -> Estimates:
    """Estimate the pose after each command with the student's functions.

    Without `predict_pose` the estimate stays at the start; without `predict_covariance` it has no covariance.
    """
    pose, covariance = np.zeros(3), np.zeros((3, 3))
    poses, covariances = [pose], [covariance]
    for motion in LAP[:steps]:
        control = np.array([motion.distance, motion.turn])
        if predict_covariance is not None:
            given = covariance.copy(), pose.copy(), control.copy(), NOISE.covariance(motion)
            covariance = np.asarray(predict_covariance(*given), dtype=float)
        if predict_pose is not None:
            pose = np.asarray(predict_pose(pose.copy(), control.copy()), dtype=float)
        poses.append(pose)
        covariances.append(covariance)
    return Estimates(np.array(poses), None if predict_covariance is None else np.array(covariances))


def share_inside(found: Estimates, robots: int = ROBOTS) -> float:
    """Return the share of robots inside the last 95 % ellipse."""
    if found.covariances is None:
        raise ValueError("share_inside needs covariances, and these estimates have none")
    places = true_paths(robots)[:, len(found.poses) - 1, :2]
    return Cloud(places, found.poses[-1, :2], found.covariances[-1][:2, :2]).inside()


@course_style()
def draw_lap(found: Estimates) -> Drawing:
    """Draw all robots after the commands followed so far, beside the estimated pose and its ellipse."""
    steps = len(found.poses) - 1
    paths = true_paths()
    figure = Figure(figsize=(6.4, 5.2))
    ax = figure.subplots()
    ax.plot(*paths[:, steps, :2].T, ".", color=TRUTH.colour, ms=5, alpha=0.5, mew=0)
    plot_path(paths[0, : steps + 1], ax, "truth")
    plot_path(found.poses, ax, "ekf")
    if steps and found.covariances is not None:
        plot_ellipse(found.poses[-1, :2], found.covariances[-1][:2, :2], ax)
    ax.set(aspect="equal", xlim=(-1.2, 2.8), ylim=(-1.2, 2.6), xlabel="x (m)", ylabel="y (m)")
    keys: list[Line2D | Patch] = [
        Line2D([], [], color=TRUTH.colour, lw=2, marker=TRUTH.marker, ms=6, label="robot 1, true path"),
        Line2D(
            [],
            [],
            color=TRUTH.colour,
            marker=".",
            ls="",
            ms=5,
            alpha=0.5,
            mew=0,
            label=f"all {ROBOTS} robots",
        ),
        Line2D([], [], color=ESTIMATE.colour, lw=2, ls=ESTIMATE.line, label="your estimate"),
    ]
    if found.covariances is not None:
        keys.append(Patch(facecolor="#0b5fa529", edgecolor=ESTIMATE.colour, label="your 95 % ellipse"))
    legend_below(figure, keys, columns=2)
    return Drawing(figure, say_lap(found))


def say_lap(found: Estimates) -> str:
    """Say how far robot 1 is from its estimate, and how many robots are inside the ellipse."""
    steps = len(found.poses) - 1
    away = float(np.hypot(*(true_paths()[0, steps, :2] - found.poses[-1, :2])))
    said = f"After {STEP * steps:.2f} m robot 1 is {away:.2f} m from its estimated position."
    if found.covariances is None:
        return f"{said} The estimate has no covariance yet."
    if not steps:
        return said
    inside = round(ROBOTS * share_inside(found))
    return f"{said} {inside} of {ROBOTS} robots ({100 * inside / ROBOTS:.0f} %) are inside the 95 % ellipse."


class LapPanel(PlayerPanel):
    """A square lap that plays command by command, with the student's estimate of the pose.

    Parameters
    ----------
    predict_pose, predict_covariance : callable, optional
        The student's functions so far. Without the first the estimate stays at the start.
    guess : Guess, optional
        Predicted distance of a typical robot from its start, m, which is drawn as a circle.
    """

    def __init__(
        self,
        predict_pose: Function | None = None,
        predict_covariance: Function | None = None,
        guess: Guess | None = None,
    ) -> None:
        """Draw the start and build the widgets."""
        self._guess = guess
        given = {"predict_pose": predict_pose, "predict_covariance": predict_covariance}
        begin = 3 * SIDE_STEPS if predict_pose is None else len(LAP)
        super().__init__(
            "The lap",
            self._show,
            Slider("command", "Command", 0, len(LAP), 1, begin, tooltip="How many commands were driven"),
            speeds={"6": 6},
            student={name: function for name, function in given.items() if function is not None},
            unfinished=_UNFINISHED,
        )

    def _show(self, values: Any, student: Any) -> Iterator[Any]:
        """Follow the commands with the functions that there are."""
        functions = student.get("predict_pose"), student.get("predict_covariance")
        found = estimates(*functions, int(values.command))
        drawn = draw_lap(found)
        yield {"": with_guess(drawn, self._guess, "radius") if self._guess else drawn}
        yield say_lap(found)
