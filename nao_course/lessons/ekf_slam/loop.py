"""A loop that closes: the map before and after one picture that shows an early landmark again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.ekf_slam.homework_log import OWN_SIGMAS
from nao_course.plotting import STYLES, Drawing, course_style, ellipse_outlines
from nao_course.plotting.ellipses import filled_outlines
from nao_course.plotting.legends import legend_below
from nao_course.plotting.maps import metric_axes
from nao_course.sim.drives import (
    Belief,
    FieldOfView,
    Function,
    Functions,
    NamedEkf,
    checked_functions,
    landmark_blocks,
    measure_in_view,
    true_path,
)
from nao_course.slam import Motion

SEED = 14
STEPS, STEP = 40, 0.25  # of the circle, and metres to a step
LANDMARKS, OUTSIDE = 12, 0.5  # of them on a circle around the path, and metres from it
VIEW = FieldOfView(float(np.radians(45)), 1.2)  # rad to each side, m
EARLY = 0  # number of the landmark that the last picture shows
LOOP_REMARKS = {  # by typical predictions of the last landmark's standard deviation after the update, cm
    56.0: "The picture corrects the pose, and the last landmark shares the error of the pose.",
    **dict.fromkeys(
        (60.0, 100.0, 200.0),
        "An update never increases a variance, not even for landmarks outside the picture.",
    ),
    0.5: "The noise of the picture and the error between both landmarks remain.",
    5.0: "Landmark 1 is that accurate, but the picture's own noise and the error between both landmarks remain.",
}
BEFORE, AFTER, ROBOT = STYLES["odometry"].colour, STYLES["ekf"].colour, "#c2409c"


@dataclass(frozen=True, eq=False)
class Loop:
    """A drive around a circle: true path (M, 3) and landmarks (k, 2), and the beliefs around its last picture.

    `numbers` are the true landmarks in the order of the state.
    """

    path: FloatArray
    landmarks: FloatArray
    numbers: list[int]
    before: Belief
    after: Belief


def close_loop(functions: Functions, seed: int = SEED) -> Loop:
    """Drive once around a circle and see one early landmark again in the last picture.

    `functions` are predict, update_landmarks and add_landmark. The robot sees only the landmarks ahead, so no early
    landmark is in view before the end.
    """
    rng = np.random.default_rng(seed)
    radius = STEP * STEPS / (2 * np.pi)
    angles = 2 * np.pi * np.arange(LANDMARKS) / LANDMARKS - np.pi / 2 + 0.35
    landmarks = (radius + OUTSIDE) * np.stack([np.cos(angles), np.sin(angles)], axis=1) + [0.0, radius]
    slam = NamedEkf(Pose(), *checked_functions(functions))
    path = [pose.as_array() for pose in true_path([Motion(STEP, 2 * np.pi / STEPS)] * STEPS, OWN_SIGMAS, rng)]
    late = False
    for step, pose in enumerate(path):
        if step:
            slam.move(np.array([STEP, 2 * np.pi / STEPS]), OWN_SIGMAS.control_covariance)
        numbers, seen = measure_in_view(pose, landmarks, OWN_SIGMAS, VIEW, rng, draw_unseen=True)
        late |= LANDMARKS - 1 in slam.known
        again = np.flatnonzero(numbers == EARLY)
        if late and len(again):
            before = slam.state, slam.covariance
            slam.observe(numbers[again], seen[again], OWN_SIGMAS.covariances(seen[again]))
            return Loop(
                np.array(path[: step + 1]), landmarks, slam.known, before, (slam.state, slam.covariance)
            )
        slam.observe(numbers, seen, OWN_SIGMAS.covariances(seen))
    raise RuntimeError("the early landmark is not seen again on this drive")


def deviations(belief: Belief) -> FloatArray:
    """Return the standard deviation of each landmark's position (k,), m: the root of the trace of its block."""
    return np.sqrt(np.trace(landmark_blocks(belief[1]), axis1=1, axis2=2))


def errors(loop: Loop, belief: Belief) -> FloatArray:
    """Return the distance of each landmark from the truth (k,), m."""
    return np.hypot(*(belief[0][3:].reshape(-1, 2) - loop.landmarks[loop.numbers]).T)


def last_deviation(*functions: Function) -> float:
    """Return the standard deviation of the landmark that was added last, after the loop is closed, in cm.

    The functions are predict, update_landmarks and add_landmark.
    """
    predict, update_landmarks, add_landmark = functions
    return float(100 * deviations(close_loop((predict, update_landmarks, add_landmark)).after)[-1])


@course_style()
def draw_loop(*functions: Function) -> Drawing:
    """Draw the map before and after the picture that closes the loop.

    Parameters
    ----------
    *functions : callable
        The student's predict, update_landmarks and add_landmark.

    Returns
    -------
    Drawing
        Two maps with 95 % ellipses, and the standard deviation of each landmark in the order of the state.
    """
    predict, update_landmarks, add_landmark = functions
    loop = close_loop((predict, update_landmarks, add_landmark))
    figure = Figure(figsize=(11.4, 4.6))
    *maps, right = figure.subplots(1, 3, width_ratios=(1, 1, 0.8))
    beliefs = {"Before the last picture": (loop.before, BEFORE), "After it": (loop.after, AFTER)}
    for ax, (title, (belief, colour)) in zip(maps, beliefs.items(), strict=True):
        _plot_map(ax, loop, belief, colour)
        ax.set_title(
            f"{title}:\nsum of variances {_trace(belief):.2f} m²,\n{100 * errors(loop, belief).mean():.0f} cm off"
        )
    for (belief, colour), marker in zip(beliefs.values(), "o^", strict=True):
        right.plot(
            np.arange(1, len(loop.numbers) + 1), 100 * deviations(belief), marker=marker, color=colour, lw=1.2
        )
    right.set(xlabel="landmark, as first seen", ylabel="standard deviation of a landmark (cm)")
    right.set(xticks=range(1, len(loop.numbers) + 1, 2), ylim=(0, None))
    right.set_title("Each landmark")
    legend_below(figure, _keys(), columns=4)
    return Drawing(figure, _say(loop))


def _plot_map(ax: Axes, loop: Loop, belief: Belief, colour: str) -> None:
    """Plot the truth, and the estimates of the robot and of all landmarks with their ellipses."""
    state, covariance = belief
    positions, widest = state[3:].reshape(-1, 2), loop.before
    ax.plot(*loop.path[:, :2].T, color=STYLES["truth"].colour, lw=1.2)
    ax.plot(*loop.landmarks[loop.numbers].T, "o", color=STYLES["truth"].colour, ms=4, zorder=4)
    ax.add_collection(filled_outlines(ellipse_outlines(positions, landmark_blocks(covariance)), colour))
    ax.add_collection(filled_outlines(ellipse_outlines(state[None, :2], covariance[None, :2, :2]), ROBOT))
    ax.plot(*positions.T, "+", color=colour, ms=8, mew=1.5)
    ax.plot(*state[:2], STYLES["ekf"].marker, color=ROBOT, ms=8, mec="white")
    ax.annotate("1", loop.landmarks[EARLY], (6, 6), textcoords="offset points", fontsize=10, zorder=6)
    outlines = ellipse_outlines(widest[0][3:].reshape(-1, 2), landmark_blocks(widest[1]))
    metric_axes(ax, np.concatenate([*outlines, loop.path[:, :2]]), margin=0.1)


def _keys() -> list[Line2D]:
    """Return the legend's entries."""
    return [
        Line2D(
            [], [], color=STYLES["truth"].colour, marker="o", ms=4, lw=1.2, label="true path and landmarks"
        ),
        Line2D([], [], color=BEFORE, marker="+", ms=8, lw=1.5, label="landmark, before"),
        Line2D([], [], color=AFTER, marker="+", ms=8, lw=1.5, label="landmark, after"),
        Line2D([], [], color=ROBOT, marker=STYLES["ekf"].marker, ms=8, lw=1.5, label="robot"),
    ]


def _trace(belief: Belief) -> float:
    return float(np.trace(belief[1][3:, 3:]))


def _say(loop: Loop) -> str:
    """Describe the map before and after in words."""
    said = [
        f"{when} the sum of the variances of all {len(loop.numbers)} landmarks is {_trace(belief):.2f} square metres, "
        f"their standard deviation is {100 * deviations(belief).mean():.0f} cm on average and "
        f"{100 * deviations(belief)[-1]:.0f} cm for the last landmark, and they are "
        f"{100 * errors(loop, belief).mean():.0f} cm off on average; the robot's standard deviation is "
        f"{100 * np.sqrt(np.trace(belief[1][:2, :2])):.0f} cm."
        for when, belief in (("Before the last picture", loop.before), ("After it", loop.after))
    ]
    return " ".join(["A drive around a circle, at whose end landmark 1 is seen again.", *said])
