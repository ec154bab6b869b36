"""Figures of lesson 12: a lost robot that finds its place, FastSLAM, and drives with chosen moves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course._internal.counts import say_count
from nao_course.datasets import real_walk, recorded_walk
from nao_course.geometry import FloatArray, Pose, wrap_angle
from nao_course.lessons.beyond.particles import FastSlam, ParticleRun, anywhere, find_itself, run_fast_slam
from nao_course.lessons.beyond.planning import Journey, at_random, journey
from nao_course.lessons.beyond.worlds import FIELD, KINDS, LANDMARKS, drive
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
from nao_course.plotting.style import GREY, style_of
from nao_course.sim import Field
from nao_course.sim.drives import Step
from nao_course.slam import Motion, range_and_bearing

Function = Callable[..., Any]
LAP = Motion(0.2, 0.25)  # a circle of 0.8 m
START = Pose(1.4, -0.8, 0.0)
LOST_SEED, LOST_SHOWN = 2, (0, 1, 3, 13)  # the clouds after these numbers of observations are shown
REAL_SHOWN = (1, 16, 24)  # the last of the real walk's pictures with a landmark is the 24th
# Number of filters that get lost, and the standard deviations of their first poses: m, m, rad.
FILTERS, FIRST_SIGMAS = 40, (1.0, 1.5, 1.8)
FOUND = 0.3  # m: a filter or particle that is closer has found the robot
SLAM_SEED, SLAM_MOVES, COUNTS = 5, 30, (10, 30, 100)
TRIED = 12  # drives in a live table
PAYOFF_SEED, BLIND_SEED = 7, 0


def lap(seed: int, moves: int) -> list[Step]:
    """Return the steps of a drive on a circle, with all errors from a seed."""
    return list(drive(START, lambda: LAP, moves, np.random.default_rng([seed, 9])))


def lost_filter(
    predict: Function, update_landmarks: Function, first: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Run a student's filter of lesson 07 from a wrong pose (3,); return the last pose (3,) and covariance (3, 3).

    The map is known. Each measurement is associated with the landmark of its kind that fits the estimate best.
    """
    kinds, k = np.array(KINDS), len(LANDMARKS)
    state = np.append(first, LANDMARKS.ravel())
    covariance = np.diag([*np.square(FIRST_SIGMAS), *np.full(2 * k, 1e-6)])
    for step in lap(LOST_SEED, max(LOST_SHOWN) - 1):
        if step.motion is not None:
            state, covariance = predict(state, covariance, step.control, step.control_covariance, k)
        for number, seen, noise in zip(step.numbers, step.measurements, step.covariances, strict=True):
            same = np.flatnonzero(kinds == kinds[number])
            off = seen - range_and_bearing(state[:3], LANDMARKS[same])
            off[:, 0] = wrap_angle(off[:, 0])
            best = int(same[np.argmin(np.square(off) @ (1 / np.diag(noise)))])
            state, covariance = update_landmarks(state, covariance, [best], seen, noise[None])
    return np.array(state[:3]), np.array(covariance)[:3, :3]


@course_style()
def draw_lost_filters(predict: Function, update_landmarks: Function) -> Drawing:
    """Draw where forty Kalman filters end that start with different wrong poses, and their stated errors."""
    truth = lap(LOST_SEED, max(LOST_SHOWN) - 1)[-1].pose
    firsts = anywhere(FILTERS, np.random.default_rng(0))
    ends = [lost_filter(predict, update_landmarks, first) for first in firsts]
    errors = np.array([np.hypot(*(pose - truth)[:2]) for pose, _ in ends])
    sigmas = np.array([np.sqrt(np.trace(covariance[:2, :2])) for _, covariance in ends])
    figure = Figure(figsize=(9.9, 4.9))
    field, ax = figure.subplots(1, 2, width_ratios=(1, 1.15))
    plot_field(FIELD, field)
    plot_landmarks(LANDMARKS, KINDS, field, GREY, size=5)
    for pose, covariance in ends:
        plot_pose(Pose.from_array(pose), field, source="ekf")
        plot_ellipse(pose[:2], covariance[:2, :2], field, "ekf")
    plot_pose(Pose.from_array(truth), field)
    ax.plot(100 * sigmas, 100 * errors, "o", color=STYLES["ekf"].colour, ms=7, alpha=0.5, mec="white")
    ax.axhline(100 * FOUND, color=STYLES["truth"].colour, lw=1)
    ax.annotate(
        f"robot found: within {100 * FOUND:.0f} cm",
        (1.0, 100 * FOUND),
        (-4, 4),
        xycoords=("axes fraction", "data"),
        textcoords="offset points",
        ha="right",
        fontsize=9,
    )
    ax.set(xlabel="stated standard deviation (cm)", ylabel="true error (cm)", xlim=(0, None), yscale="log")
    ax.set_yticks([3, 10, 30, 100, 300], ["3", "10", "30", "100", "300"])
    ax.grid(color="#e3e5e8")
    legend_below(figure, [source_key("truth", "robot"), source_key("ekf", "one of the filters")])
    found = errors < FOUND
    return Drawing(
        figure,
        f"{FILTERS} Kalman filters after {max(LOST_SHOWN)} observations, each started with another pose. "
        f"{found.sum()} are within {FOUND} m of the robot, the others {errors[~found].min():.1f} to "
        f"{errors.max():.1f} m away. They state standard deviations of {sigmas.min():.3f} to {sigmas.max():.3f} m.",
    )


@course_style()
def draw_finding(
    weigh: Function, resample: Function, particles: int = 2000, seed: int = LOST_SEED
) -> Drawing:
    """Draw the particles of a robot that does not know its place: at the start and after some measurements."""
    steps = lap(LOST_SEED, max(LOST_SHOWN) - 1)
    clouds = find_itself(weigh, resample, steps, np.random.default_rng(seed), particles)
    truth = np.array([steps[0].pose, *(step.pose for step in steps)])
    said = []
    for count in LOST_SHOWN:
        near = np.hypot(*(clouds[count][:, :2] - truth[count, :2]).T) < FOUND
        said.append(
            f"after {say_count(count, 'observation')} {near.mean():.0%} of the particles are within {FOUND} m"
        )
    return Drawing(
        _clouds(FIELD, clouds, truth, LOST_SHOWN, (9.9, 3.9)),
        f"{particles} particles on the half field and the true robot: {'; '.join(said)}.",
    )


@course_style()
def draw_real_finding(weigh: Function, resample: Function, particles: int = 2000, seed: int = 0) -> Drawing:
    """Draw the particles of a real NAO that does not know its place on a whole field, during its walk."""
    steps = recorded_walk().steps[: REAL_SHOWN[-1]]
    field = real_walk.FIELD
    clouds = find_itself(weigh, resample, steps, np.random.default_rng(seed), particles, field)
    truth = np.array([steps[0].pose, *(step.pose for step in steps)])
    said = []
    for count in REAL_SHOWN:
        here, opposite = (
            np.hypot(*(clouds[count][:, :2] - place).T) < FOUND
            for place in (truth[count, :2], -truth[count, :2])
        )
        said.append(f"after {say_count(count, 'observation')} {here.mean():.0%} and {opposite.mean():.0%}")
    return Drawing(
        _clouds(field, clouds, truth, REAL_SHOWN, (11.4, 3.9)),
        f"{particles} particles on a whole field and a real NAO. Within {FOUND} m of the robot, and of the place "
        f"opposite it through the field's centre, are {'; '.join(said)}.",
    )


def _clouds(
    field: Field, clouds: list[FloatArray], truth: FloatArray, shown: Sequence[int], size: tuple[float, float]
) -> Figure:
    """Draw particles and the true robot on a map for each of some numbers of observations."""
    figure = Figure(figsize=size)
    for ax, count in zip(figure.subplots(1, len(shown), sharey=True), shown, strict=True):
        plot_field(field, ax)
        plot_landmarks(field.detectable_positions, field.detectable_kinds, ax, GREY, size=5)
        ax.plot(
            *clouds[count][:, :2].T,
            ".",
            color=STYLES["ekf"].colour,
            ms=3 if count else 2,
            alpha=0.4,
            zorder=4,
        )
        plot_pose(Pose.from_array(truth[count]), ax)
        ax.set_title("at the start" if not count else f"after {say_count(count, 'observation')}", fontsize=11)
        if ax is not figure.axes[0]:
            ax.set_ylabel("")
    dot = Line2D([], [], color=STYLES["ekf"].colour, marker=".", ls="", ms=8, label="particle (position)")
    legend_below(figure, [source_key("truth", "robot"), dot])
    return figure


def depleted(update_particle_landmark: Function, resample: Function, n: int) -> ParticleRun:
    """Run FastSLAM with n particles on one drive, with a student's functions."""
    slam = FastSlam(START, update_particle_landmark, resample, n, np.random.default_rng([SLAM_SEED, n]))
    return run_fast_slam(slam, lap(SLAM_SEED, SLAM_MOVES))


def ancestors_left(update_particle_landmark: Function, resample: Function) -> int:
    """Return how many of a hundred particles have a descendant at the end of the drive."""
    return int(depleted(update_particle_landmark, resample, COUNTS[-1]).ancestors[-1])


@course_style()
def draw_depletion(update_particle_landmark: Function, resample: Function) -> Drawing:
    """Draw how many of FastSLAM's particles still have descendants, and the paths of the last particles."""
    runs = {n: depleted(update_particle_landmark, resample, n) for n in COUNTS}
    truth = np.array([step.pose for step in lap(SLAM_SEED, SLAM_MOVES)])
    paths = runs[COUNTS[-1]].paths
    figure = Figure(figsize=(9.9, 4.9))
    ax, field = figure.subplots(1, 2, width_ratios=(1.15, 1))
    for n, shade, dashes in zip(COUNTS, (0.4, 0.7, 1.0), (":", "--", "-"), strict=True):
        style = {"color": STYLES["ekf"].colour, "alpha": shade, "ls": dashes}
        ax.plot(runs[n].ancestors, lw=2, drawstyle="steps-post", label=f"{n} particles", **style)
    ax.legend(loc="upper right", reverse=True)
    ax.set(xlabel="move", ylabel="initial particles with descendants", xlim=(0, SLAM_MOVES))
    ax.set(yscale="log", ylim=(0.8, 160))
    ax.set_yticks([1, 3, 10, 30, 100], ["1", "3", "10", "30", "100"])
    ax.minorticks_off()
    ax.grid(color="#e3e5e8")
    plot_field(FIELD, field)
    plot_landmarks(LANDMARKS, KINDS, field, GREY, size=5)
    for path in paths:
        field.plot(*path[:, :2].T, color=STYLES["ekf"].colour, lw=0.7, alpha=0.15, zorder=4)
    plot_path(truth, field)
    line = Line2D([], [], color=STYLES["ekf"].colour, lw=1.2, label="the 100 particles' paths")
    legend_below(figure, [source_key("truth", "true path"), line])
    ends = ", ".join(f"{int(runs[n].ancestors[-1])} of {n}" for n in COUNTS)
    shared = int(np.argmax(np.ptp(paths[:, 1:, 0], axis=0) > 1e-9))  # the paths hold the start twice
    return Drawing(
        figure,
        f"FastSLAM over {SLAM_MOVES} moves. Initial particles that still have descendants at the end: {ends}. "
        f"Right, the paths of a hundred particles: a single line for the first {shared} moves, "
        "then they spread.",
    )


# --- moves ---


@course_style()
def draw_journeys(
    choose_move: Function, predict: Function, update_landmarks: Function, add_landmark: Function
) -> Drawing:
    """Draw a drive with random moves and a drive with moves of a student's `choose_move`, from the same start."""
    ekf = predict, update_landmarks, add_landmark
    both = {
        "random moves": journey(at_random(PAYOFF_SEED), ekf, PAYOFF_SEED),
        "your choice": journey(choose_move, ekf, PAYOFF_SEED),
    }
    figure = Figure(figsize=(9.9, 5.4))
    for ax, (name, each) in zip(figure.subplots(1, 2, sharey=True), both.items(), strict=True):
        plot_field(FIELD, ax)
        plot_path(each.truth, ax)
        plot_estimate(each.estimates[-1], ax, "ekf")
        for estimate in each.estimates[::4]:
            plot_ellipse((estimate.pose.x, estimate.pose.y), estimate.covariance[:2, :2], ax, "ekf")
        ax.set_title(f"{name}: standard deviation {100 * each.sigmas[-1]:.0f} cm", fontsize=11)
    figure.axes[1].set_ylabel("")
    legend_below(
        figure,
        [
            source_key("truth", "true path"),
            source_key("ekf", "estimate, 95 % (on the path after every 4th move)"),
        ],
    )
    said = "; ".join(
        f"with {name} the standard deviation is {each.sigmas[-1]:.2f} m at the end "
        f"and the error {each.errors[-1]:.2f} m"
        for name, each in both.items()
    )
    return Drawing(
        figure, f"Two drives of {len(both['random moves'].truth) - 1} moves from the same place: {said}."
    )


def blind_sigma(
    choose_move: Function, predict: Function, update_landmarks: Function, add_landmark: Function
) -> float:
    """Return the median standard deviation (m) after drives of `choose_move` that start with the back to the goal."""
    ends = [each.sigmas[-1] for each in _blind(choose_move, (predict, update_landmarks, add_landmark))]
    return round(float(np.median(ends)), 2)


def _blind(choose_move: Function, ekf: Sequence[Function]) -> list[Journey]:
    return [journey(choose_move, ekf, seed, back=True) for seed in range(TRIED)]


@course_style()
def draw_blind_start(
    choose_move: Function, predict: Function, update_landmarks: Function, add_landmark: Function
) -> Drawing:
    """Draw stated standard deviation and true error over drives with the back to the goal, and one of these drives."""
    ekf = predict, update_landmarks, add_landmark
    both = {
        "your choice": ("ekf", _blind(choose_move, ekf)),
        "random moves": (
            "odometry",
            [journey(at_random(seed), ekf, seed, back=True) for seed in range(TRIED)],
        ),
    }
    said, off = [], []
    figure = Figure(figsize=(9.9, 4.9))
    ax, field = figure.subplots(1, 2, width_ratios=(1.15, 1))
    for name, (source, journeys) in both.items():
        low, middle, high = 100 * np.quantile([each.sigmas for each in journeys], (0.25, 0.5, 0.75), axis=0)
        style = style_of(source)
        ax.fill_between(range(len(middle)), low, high, color=style.colour, alpha=0.13, lw=0)
        ax.plot(
            middle,
            color=style.colour,
            ls=style.line,
            lw=2,
            marker=style.marker,
            markevery=4,
            mec="white",
            label=f"{name}: stated σ",
        )
        error = 100 * np.median([each.errors for each in journeys], axis=0)
        ax.plot(error, color=style.colour, ls=":", lw=2, label=f"{name}: true error")
        said.append(f"{name} {middle[-1]:.0f} cm")
        off.append(f"{name} {error[-1]:.0f} cm")
    ax.set(xlabel="move", ylabel="median (cm)", xlim=(0, len(middle) - 1), ylim=(0, None))
    ax.set_xticks(range(0, len(middle), 5))
    ax.grid(color="#e3e5e8")
    ax.legend(loc="upper left")
    one = both["your choice"][1][BLIND_SEED]
    plot_field(FIELD, field)
    plot_landmarks(LANDMARKS, KINDS, field, GREY, size=5)
    plot_path(one.truth, field)
    plot_estimate(one.estimates[-1], field, "ekf")
    field.plot(*one.truth[0, :2], "o", color="white", mec=STYLES["truth"].colour, ms=9, zorder=6)
    legend_below(
        figure, [source_key("truth", "true path, from the white dot"), source_key("ekf", "estimate, 95 %")]
    )
    return Drawing(
        figure,
        f"{TRIED} drives that start with the back to the goal. Median standard deviation at the end: "
        f"{'; '.join(said)}. Median true error: {'; '.join(off)}. Right, one drive with your choice and "
        f"{len(one.known)} landmarks on its map at the end.",
    )


def journeys_table(choose_move: Function, ekf: Sequence[Function]) -> Table:
    """Return the medians of standard deviation and error after twelve drives, for random and chosen moves."""
    rows = []
    for name, make in (("random", at_random), ("choose_move", lambda seed: choose_move)):
        ends = [journey(make(seed), ekf, seed) for seed in range(TRIED)]
        sigma, error = np.median([(each.sigmas[-1], each.errors[-1]) for each in ends], axis=0)
        rows.append((name, f"{sigma:.3f}", f"{error:.3f}"))
    return table(("moves", "standard deviation (m)", "error (m)"), rows)
