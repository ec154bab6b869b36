"""Figures of lesson 11: what is seen in three looks, what one tilt does to a picture, and whole drives."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.slam_on_the_field.drivers import taken_from
from nao_course.lessons.slam_on_the_field.system.compass import lean_from_lines
from nao_course.lessons.slam_on_the_field.system.drives import FieldOdometry, drive_over_field
from nao_course.lessons.slam_on_the_field.system.lines import read_lines
from nao_course.lessons.slam_on_the_field.system.observation import (
    POST_SIGMA,
    Observation,
    leaning,
    observation,
    picture_covariance,
)
from nao_course.lessons.slam_on_the_field.worlds import FIELD
from nao_course.plotting import (
    Drawing,
    course_style,
    plot_ellipse,
    plot_estimate,
    plot_field,
    plot_measurements,
    plot_path,
    plot_picture,
    plot_pose,
)
from nao_course.plotting.drawing import say_count
from nao_course.plotting.legends import legend_below, source_key
from nao_course.sim import CameraView
from nao_course.slam import DeadReckoning, Measurement, Motion, measured_points, run_slam

PLACE = Pose(1.45, -0.55, -0.45)
YAWS = (0.75, 0.0, -0.75)  # rad
TILTED = (Measurement(0.25, 2.0), Measurement(-0.2, 3.0))
PAYOFF_SEED, PAYOFF_MOVES = 97, 20
TOLD_BY = {"odometry": "by odometry", "ekf": "your filter", "graph": "your graph"}


def draw_sights(measure: Callable[..., Any]) -> Drawing:
    """Draw three looks from one place, and what a student's `measure` makes of them on the map."""
    pictures = [taken_from(PLACE, yaw) for yaw in YAWS]
    found = [_seen(measure, each.pixels, each.view) for each in pictures]
    with course_style():
        figure = Figure(figsize=(9.6, 5.6))
        grid = figure.add_gridspec(3, 2, width_ratios=(1, 2.2))
        for row, (picture, seen) in enumerate(zip(pictures, found, strict=True)):
            ax = figure.add_subplot(grid[row, 0])
            plot_picture(picture, ax, ticks=False)
            ax.set_title(f"{say_count(len(seen), 'measurement')}", fontsize=10)
        ax = figure.add_subplot(grid[:, 1])
        plot_field(FIELD, ax)
        for seen in found:
            plot_measurements(seen, PLACE, ax)
        plot_pose(PLACE, ax)
        legend_below(figure, [source_key("truth", "robot"), source_key("ekf", "measured")])
    told = ", ".join(f"{each.kind} at {each.range:.2f} m" for seen in found for each in seen)
    return Drawing(
        figure,
        "Three pictures from one place, to the left, ahead and to the right, and their measurements on the map: "
        f"{told or 'none'}.",
        photo=True,
    )


def draw_one_tilt() -> Drawing:
    """Draw two corners of one picture as they are measured under 300 tilts, and what R says of them."""
    rng = np.random.default_rng(11)
    R = picture_covariance(TILTED)
    mean = np.ravel([(each.bearing, each.range) for each in TILTED])
    draws = rng.multivariate_normal(mean, R, 300)
    correlation = R[1, 3] / np.sqrt(R[1, 1] * R[3, 3])
    with course_style():
        figure = Figure(figsize=(9.6, 3.8))
        ax, both = figure.subplots(1, 2, width_ratios=(1.5, 1))
        places = measured_points(TILTED, Pose())
        for n, (each, colour) in enumerate(zip(TILTED, ("#0b5fa5", "#a14566"), strict=True)):
            bearing, away = draws[:, 2 * n : 2 * n + 2].T
            ax.plot(away * np.cos(bearing), away * np.sin(bearing), ".", color=colour, ms=2, alpha=0.6)
            c, s, r = np.cos(each.bearing), np.sin(each.bearing), each.range
            J = np.array([[-r * s, c], [r * c, s]])
            plot_ellipse(places[n], J @ R[2 * n : 2 * n + 2, 2 * n : 2 * n + 2] @ J.T, ax, "ekf")
        plot_pose(Pose(), ax)
        ax.set(aspect="equal", xlabel="ahead (m)", ylabel="left (m)", xlim=(-0.2, 4.2), ylim=(-1.2, 1.2))
        ax.set_title("two corners, each measured in 300 pictures", fontsize=11)
        for place, name in zip(places, ("near", "far"), strict=True):
            ax.annotate(name, place, (0, 16), textcoords="offset points", ha="center", fontsize=10)
        both.plot(draws[:, 1], draws[:, 3], ".", color="#444", ms=3, alpha=0.6)
        both.set(xlabel="range of the near corner (m)", ylabel="range of the far corner (m)")
        both.set_title(f"a dot a picture: correlation {correlation:.2f}", fontsize=11)
    sigmas = np.sqrt(R[[1, 3], [1, 3]])
    return Drawing(
        figure,
        f"Two corners of one picture, at 2 and 3 m, measured 300 times while the body leans by 1.3 degrees. "
        f"Their ranges scatter by "
        f"{sigmas[0]:.2f} and {sigmas[1]:.2f} m, and nearly always together: their correlation is {correlation:.2f}.",
    )


def draw_drives(
    measure: Callable[..., Any],
    EkfSlam: Callable[..., Any],  # noqa: N803 - the students' names
    GraphSlam: Callable[..., Any],  # noqa: N803
) -> Drawing:
    """Drive over the field and draw it as odometry, a student's filter and a student's graph tell it, by their eyes."""
    log, true = _looks(measure)
    start = Pose.from_array(true[0])
    algorithms = {
        "odometry": DeadReckoning(start),
        "ekf": EkfSlam(start, FieldOdometry()),
        "graph": GraphSlam(start, FieldOdometry()),
    }
    estimates = {source: run_slam(algorithm, log) for source, algorithm in algorithms.items()}
    off = {
        source: 100 * float(np.hypot(*(found[-1].pose.as_array() - true[-1])[:2]))
        for source, found in estimates.items()
    }
    with course_style():
        figure = Figure(figsize=(9.9, 4.9))
        for number, (source, name) in enumerate(TOLD_BY.items(), start=1):
            ax = figure.add_subplot(1, 3, number)
            plot_field(FIELD, ax)
            plot_path(true, ax)
            path = np.array([each.pose.as_array() for each in estimates[source]])
            plot_path(path if source == "odometry" else path[:, :2], ax, source, robot=source == "odometry")
            if source != "odometry":
                plot_estimate(estimates[source][-1], ax, source)
            ax.set_title(f"{name}: off by {off[source]:.0f} cm", fontsize=11)
            if number > 1:
                ax.set_ylabel("")
        keys = [
            source_key("truth", "true path"),
            source_key("odometry"),
            source_key("ekf", "EKF, 95 %"),
            source_key("graph", "graph, 95 %"),
        ]
        legend_below(figure, keys)
    said = ", ".join(f"{name} {off[source]:.0f} cm" for source, name in TOLD_BY.items())
    maps = [len(estimates[source][-1].kinds) for source in ("ekf", "graph")]
    return Drawing(
        figure,
        f"One drive of {PAYOFF_MOVES} moves over the half field, {len(log)} pictures. Off at its end: {said}. "
        f"The filter's map has {maps[0]} landmarks, the graph's {maps[1]}.",
    )


def _looks(measure: Callable[..., Any]) -> tuple[list[tuple[Motion | None, Observation]], FloatArray]:
    """What a student's `measure` makes of a drive's pictures, with the commands, and the true poses (S, 3).

    The field's lines tell how the body leans, and with it what the picture's view is, and a heading.
    """
    log, true = [], []
    for shot in drive_over_field(PAYOFF_SEED, moves=PAYOFF_MOVES):
        pixels, view = shot.picture.pixels, shot.picture.view
        lean = lean_from_lines(read_lines(pixels, view), view)
        found = _seen(measure, pixels, leaning(view, lean.pitch, lean.roll))
        seen = observation(
            found,
            lean.covariance[:2, :2],
            direction=lean.direction,
            direction_sigma=lean.direction_sigma,
            post_sigma=POST_SIGMA,
        )
        log.append((shot.motion, seen))
        true.append(shot.pose.as_array())
    return log, np.array(true)


def _seen(measure: Callable[..., Any], pixels: npt.NDArray[np.uint8], view: CameraView) -> list[Measurement]:
    """What a student's `measure` sees in a picture; refused in words where that is something else."""
    found = measure(pixels.copy(), view)
    if not isinstance(found, list | tuple) or any(not isinstance(each, Measurement) for each in found):
        raise TypeError("measure must return a list of Measurement")
    return list(found)
