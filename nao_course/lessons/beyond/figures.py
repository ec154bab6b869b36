"""Figures of lesson 12: a robot that finds itself, particles that die out, and drives that were chosen."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from nao_course.geometry import Pose
from nao_course.lessons.beyond.particles import FastSlam, Run, find_itself, run_fast_slam
from nao_course.lessons.beyond.planning import Journey, at_random, journey
from nao_course.lessons.beyond.worlds import FIELD, KINDS, LANDMARKS, Step, drive
from nao_course.plotting import (
    STYLES,
    Drawing,
    Table,
    course_style,
    plot_ellipse,
    plot_estimate,
    plot_field,
    plot_landmarks,
    plot_path,
    plot_pose,
    table,
)
from nao_course.plotting.legends import legend_below, source_key
from nao_course.plotting.style import GREY
from nao_course.slam import Estimate, Motion

Function = Callable[..., Any]
LAP = Motion(0.2, 0.25)  # a circle of 0.8 m
START = Pose(1.4, -0.8, 0.0)
LOST_SEED, LOST_SHOWN = 2, (0, 1, 3, 13)  # of which the clouds after so many looks are shown
SLAM_SEED, SLAM_MOVES, COUNTS = 5, 30, (10, 30, 100)
TRIED = 12  # journeys in a live table
PAYOFF_SEED, BLIND_SEED = 7, 0


def lap(seed: int, moves: int) -> list[Step]:
    """A drive on a circle, with all errors from a seed."""
    return list(drive(START, lambda: LAP, moves, np.random.default_rng([seed, 9])))


def draw_finding(weigh: Function, resample: Function) -> Drawing:
    """Draw where a robot that woke up anywhere may be: at first, and after some looks."""
    steps = lap(LOST_SEED, max(LOST_SHOWN) - 1)
    clouds = find_itself(weigh, resample, steps, np.random.default_rng(LOST_SEED), 2000)
    truth = np.array([steps[0].pose, *(step.pose for step in steps)])
    said = []
    with course_style():
        figure = Figure(figsize=(9.9, 3.9))
        for ax, looks in zip(figure.subplots(1, len(LOST_SHOWN), sharey=True), LOST_SHOWN, strict=True):
            plot_field(FIELD, ax)
            plot_landmarks(LANDMARKS, KINDS, ax, GREY, size=5)
            ax.plot(
                *clouds[looks][:, :2].T,
                ".",
                color=STYLES["ekf"].colour,
                ms=3 if looks else 2,
                alpha=0.4,
                zorder=4,
            )
            plot_pose(Pose.from_array(truth[looks]), ax)
            ax.set_title(
                "no look" if not looks else "one look" if looks == 1 else f"{looks} looks", fontsize=11
            )
            if ax is not figure.axes[0]:
                ax.set_ylabel("")
            near = np.hypot(*(clouds[looks][:, :2] - truth[looks, :2]).T) < 0.3
            said.append(f"after {looks} looks {near.mean():.0%} of the particles are within 0.3 m")
        legend_below(figure, [source_key("truth", "robot"), source_key("ekf", "particle")])
    return Drawing(figure, f"Two thousand particles on the half field and the true robot: {'; '.join(said)}.")


def depleted(update_particle_landmark: Function, resample: Function, n: int) -> Run:
    """FastSLAM with n particles on one drive, by a student's functions."""
    slam = FastSlam(START, update_particle_landmark, resample, n, np.random.default_rng([SLAM_SEED, n]))
    return run_fast_slam(slam, lap(SLAM_SEED, SLAM_MOVES))


def ancestors_left(update_particle_landmark: Function, resample: Function) -> int:
    """How many of a hundred particles have a descendant at the end of the drive."""
    return int(depleted(update_particle_landmark, resample, COUNTS[-1]).ancestors[-1])


def draw_depletion(update_particle_landmark: Function, resample: Function) -> Drawing:
    """Draw how FastSLAM's particles die out, and the paths of those that are left."""
    runs = {n: depleted(update_particle_landmark, resample, n) for n in COUNTS}
    truth = np.array([step.pose for step in lap(SLAM_SEED, SLAM_MOVES)])
    paths = runs[COUNTS[-1]].paths
    with course_style():
        figure = Figure(figsize=(9.9, 4.9))
        ax, field = figure.subplots(1, 2, width_ratios=(1.15, 1))
        for n, shade in zip(COUNTS, (0.4, 0.7, 1.0), strict=True):
            ax.plot(runs[n].ancestors, color=STYLES["ekf"].colour, alpha=shade, lw=2, drawstyle="steps-post")
            ax.annotate(f"{n} particles", (1.2, n), (4, -2), textcoords="offset points", fontsize=9.5)
        ax.set(xlabel="move", ylabel="particles of the start with descendants", xlim=(0, SLAM_MOVES))
        ax.set(yscale="log", ylim=(0.8, 160))
        ax.set_yticks([1, 3, 10, 30, 100], ["1", "3", "10", "30", "100"])
        ax.minorticks_off()
        ax.grid(color="#e3e5e8")
        plot_field(FIELD, field)
        plot_landmarks(LANDMARKS, KINDS, field, GREY, size=5)
        for path in paths:
            field.plot(*path[:, :2].T, color=STYLES["ekf"].colour, lw=0.7, alpha=0.15, zorder=4)
        plot_path(truth, field)
        legend_below(
            figure, [source_key("truth", "true path"), source_key("ekf", "the 100 particles' paths")]
        )
    ends = ", ".join(f"{int(runs[n].ancestors[-1])} of {n}" for n in COUNTS)
    shared = int(np.argmax(np.ptp(paths[:, 1:, 0], axis=0) > 1e-9))  # the paths hold the start twice
    return Drawing(
        figure,
        f"FastSLAM over {SLAM_MOVES} moves. Particles of the start that still have descendants at the end: {ends}. "
        f"Right, the paths of a hundred particles: one and the same line for the first {shared} moves, "
        "and a broom at the end.",
    )


# --- moves ---


def draw_journeys(
    choose_move: Function, predict: Function, update_landmarks: Function, add_landmark: Function
) -> Drawing:
    """Draw a drive at random and one whose moves a student's `choose_move` chose, from the same start."""
    ekf = predict, update_landmarks, add_landmark
    both = {
        "at random": journey(at_random(PAYOFF_SEED), ekf, PAYOFF_SEED),
        "by your choice": journey(choose_move, ekf, PAYOFF_SEED),
    }
    with course_style():
        figure = Figure(figsize=(9.9, 5.4))
        for ax, (name, each) in zip(figure.subplots(1, 2, sharey=True), both.items(), strict=True):
            plot_field(FIELD, ax)
            plot_path(each.truth, ax)
            plot_estimate(estimate_of(each), ax, "ekf")
            for pose, covariance in zip(each.believed[::4], each.covariances[::4], strict=True):
                plot_ellipse(pose[:2], covariance[:2, :2], ax, "ekf")
            ax.set_title(f"{name}: sure to {100 * each.doubts[-1]:.0f} cm", fontsize=11)
        figure.axes[1].set_ylabel("")
        legend_below(figure, [source_key("truth", "true path"), source_key("ekf", "believed, 95 %")])
    said = "; ".join(
        f"{name} its standard deviation is {each.doubts[-1]:.2f} m at the end, and it is {each.off:.2f} m off"
        for name, each in both.items()
    )
    return Drawing(
        figure, f"Two drives of {len(both['at random'].truth) - 1} moves from the same place: {said}."
    )


def estimate_of(each: Journey) -> Estimate:
    """What is believed at the end of a journey."""
    k = len(each.known)
    blocks = each.covariance[3:, 3:].reshape(k, 2, k, 2)
    return Estimate(
        Pose.from_array(each.state[:3]),
        each.covariance[:3, :3],
        np.column_stack([each.state[3::2], each.state[4::2]]),
        np.einsum("iaib->iab", blocks),
        tuple(KINDS[number] for number in each.known),
    )


def blind_doubt(
    choose_move: Function, predict: Function, update_landmarks: Function, add_landmark: Function
) -> float:
    """Median doubt (m) after drives by a student's `choose_move` that begin with the back to the goal."""
    ends = [each.doubts[-1] for each in _blind(choose_move, (predict, update_landmarks, add_landmark))]
    return round(float(np.median(ends)), 2)


def _blind(choose_move: Function, ekf: Sequence[Function]) -> list[Journey]:
    return [journey(choose_move, ekf, seed, back=True) for seed in range(TRIED)]


def draw_blind_start(
    choose_move: Function, predict: Function, update_landmarks: Function, add_landmark: Function
) -> Drawing:
    """Draw what a start with the back to the goal does to a choice of moves: doubt over the moves, and one drive."""
    ekf = predict, update_landmarks, add_landmark
    both = {
        "by your choice": ("ekf", _blind(choose_move, ekf)),
        "at random": (
            "odometry",
            [journey(at_random(seed), ekf, seed, back=True) for seed in range(TRIED)],
        ),
    }
    said = []
    with course_style():
        figure = Figure(figsize=(9.9, 4.9))
        ax, field = figure.subplots(1, 2, width_ratios=(1.15, 1))
        for name, (source, journeys) in both.items():
            low, middle, high = 100 * np.quantile(
                [each.doubts for each in journeys], (0.25, 0.5, 0.75), axis=0
            )
            look = STYLES[source]
            ax.fill_between(range(len(middle)), low, high, color=look.colour, alpha=0.13, lw=0)
            ax.plot(
                middle,
                color=look.colour,
                ls=look.line,
                lw=2,
                marker=look.marker,
                markevery=4,
                mec="white",
                label=name,
            )
            said.append(f"{name} {middle[-1]:.0f} cm")
        ax.set(
            xlabel="move", ylabel="stated standard deviation (cm)", xlim=(0, len(middle) - 1), ylim=(0, None)
        )
        ax.set_xticks(range(0, len(middle), 5))
        ax.grid(color="#e3e5e8")
        ax.legend(loc="upper left")
        one = both["by your choice"][1][BLIND_SEED]
        plot_field(FIELD, field)
        plot_landmarks(LANDMARKS, KINDS, field, GREY, size=5)
        plot_path(one.truth, field)
        plot_estimate(estimate_of(one), field, "ekf")
        field.plot(*one.truth[0, :2], "o", color="white", mec=STYLES["truth"].colour, ms=9, zorder=6)
        legend_below(
            figure,
            [source_key("truth", "true path, from the white dot"), source_key("ekf", "believed, 95 %")],
        )
    return Drawing(
        figure,
        f"{TRIED} drives from a start with the back to the goal. Median of the doubt after {len(middle) - 1} moves: "
        f"{'; '.join(said)}. Right, one drive by your choice, with {len(one.known)} landmarks on its map at the end.",
    )


def journeys_table(choose_move: Function, ekf: Sequence[Function]) -> Table:
    """Twelve drives by each way to choose: medians of doubt and error at the end."""
    rows = []
    for name, make in (("at random", at_random), ("choose_move", lambda seed: choose_move)):
        ends = [journey(make(seed), ekf, seed) for seed in range(TRIED)]
        doubt, off = np.median([each.doubts[-1] for each in ends]), np.median([each.off for each in ends])
        rows.append((name, f"{doubt:.3f}", f"{off:.3f}"))
    return table(("moves", "standard deviation (m)", "error (m)"), rows)
