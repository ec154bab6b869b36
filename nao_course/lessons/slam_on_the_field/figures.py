"""Figures of lesson 11: measurements in three pictures, the effect of one tilt on a picture, and whole drives."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from nao_course._internal.counts import say_count
from nao_course.field_slam.drives import OdometryNoisePerMove, drive_over_field
from nao_course.field_slam.observation import Observation, picture_covariance
from nao_course.geometry import FloatArray, Pose
from nao_course.lessons.slam_on_the_field.drivers import taken_from
from nao_course.lessons.slam_on_the_field.worlds import FIELD, checked_measurements, observe
from nao_course.plotting import (
    STYLES,
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
from nao_course.plotting.legends import legend_below, source_key
from nao_course.slam import DeadReckoning, Measurement, Motion, measured_points, run_slam

PLACE = Pose(1.45, -0.55, -0.45)
YAWS = (0.75, 0.0, -0.75)  # rad
TILTED = (Measurement(0.25, 2.0), Measurement(-0.2, 3.0))
PAYOFF_SEED, PAYOFF_MOVES = 97, 20
TITLES = {"odometry": "odometry", "ekf": "your filter", "graph": "your graph"}


@course_style()
def draw_measurements(measure: Callable[..., Any]) -> Drawing:
    """Draw three pictures from one place, and a student's measurements of them on the map."""
    pictures = [taken_from(PLACE, yaw) for yaw in YAWS]
    found = [checked_measurements(measure(each.pixels.copy(), each.view)) for each in pictures]
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
    listed = ", ".join(f"{each.kind} at {each.range:.2f} m" for seen in found for each in seen)
    return Drawing(
        figure,
        "Three pictures from one place, to the left, ahead and to the right, and their measurements on the map: "
        f"{listed or 'none'}.",
        photo=True,
    )


@course_style()
def draw_one_tilt() -> Drawing:
    """Draw two corners as they are measured in 300 pictures with different tilts, and their ellipses from R."""
    rng = np.random.default_rng(11)
    R = picture_covariance(TILTED)
    mean = np.ravel([(each.bearing, each.range) for each in TILTED])
    draws = rng.multivariate_normal(mean, R, 300)
    correlation = R[1, 3] / np.sqrt(R[1, 1] * R[3, 3])
    figure = Figure(figsize=(9.6, 3.8))
    ax, both = figure.subplots(1, 2, width_ratios=(1.5, 1))
    places, keys = measured_points(TILTED, Pose()), list[Line2D]()
    for n, (each, colour) in enumerate(zip(TILTED, ("#2a7f4f", "#8a5a00"), strict=True)):
        bearing, away = draws[:, 2 * n : 2 * n + 2].T
        ax.plot(away * np.cos(bearing), away * np.sin(bearing), ".", color=colour, ms=2, alpha=0.6)
        keys.append(
            Line2D([], [], ls="", marker="o", ms=4, color=colour, label=f"corner at {each.range:g} m")
        )
        c, s, r = np.cos(each.bearing), np.sin(each.bearing), each.range
        J = np.array([[-r * s, c], [r * c, s]])
        plot_ellipse(places[n], J @ R[2 * n : 2 * n + 2, 2 * n : 2 * n + 2] @ J.T, ax, "ekf")
    plot_pose(Pose(), ax)
    ax.set(aspect="equal", xlabel="ahead (m)", ylabel="left (m)", xlim=(-0.2, 4.2), ylim=(-1.2, 1.2))
    ax.set_title("two corners, each measured in 300 pictures", fontsize=11)
    both.plot(draws[:, 1], draws[:, 3], ".", color="#444", ms=3, alpha=0.6)
    keys += [
        Line2D([], [], ls="", marker="o", ms=10, mfc="none", mec=STYLES["ekf"].colour, label="95 % ellipse"),
        source_key("truth", "robot"),
        Line2D([], [], ls="", marker="o", ms=4, color="#444", label="one picture (right)"),
    ]
    legend_below(figure, keys, columns=5)
    both.set(xlabel="measured range of the nearer corner (m)", ylabel="of the farther corner (m)")
    both.set_title(f"each picture: correlation {correlation:.2f}", fontsize=11)
    sigmas = np.sqrt(R[[1, 3], [1, 3]])
    return Drawing(
        figure,
        "Two corners at 2 and 3 m, measured in 300 pictures; the pitch has a standard deviation of 1.3 degrees. "
        f"Their ranges have standard deviations of "
        f"{sigmas[0]:.2f} and {sigmas[1]:.2f} m, and they are wrong together: their correlation is {correlation:.2f}.",
    )


@course_style()
def draw_drives(
    measure: Callable[..., Any],
    EkfSlam: Callable[..., Any],  # noqa: N803 - the students' names
    GraphSlam: Callable[..., Any],  # noqa: N803
) -> Drawing:
    """Draw one drive as estimated by odometry and by a student's filter and graph, from the student's measurements."""
    log, true = measured_drive(measure)
    start = Pose.from_array(true[0])
    algorithms = {
        "odometry": DeadReckoning(start),
        "ekf": EkfSlam(start, OdometryNoisePerMove()),
        "graph": GraphSlam(start, OdometryNoisePerMove()),
    }
    estimates = {source: run_slam(algorithm, log) for source, algorithm in algorithms.items()}
    off = {
        source: 100 * float(np.hypot(*(found[-1].pose.as_array() - true[-1])[:2]))
        for source, found in estimates.items()
    }
    figure = Figure(figsize=(9.9, 4.9))
    for number, (source, name) in enumerate(TITLES.items(), start=1):
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
    said = ", ".join(f"{name} {off[source]:.0f} cm" for source, name in TITLES.items())
    maps = [len(estimates[source][-1].kinds) for source in ("ekf", "graph")]
    return Drawing(
        figure,
        f"One drive of {PAYOFF_MOVES} moves over the half field, {len(log)} pictures. Off at its end: {said}. "
        f"The filter's map has {maps[0]} landmarks, the graph's {maps[1]}.",
    )


def measured_drive(measure: Callable[..., Any]) -> tuple[list[tuple[Motion | None, Observation]], FloatArray]:
    """Return a drive's log with a student's measurements, and the true poses (S, 3).

    The body's tilt, and with it each picture's view, comes from the field's lines, and so does a heading.
    """
    log, true = [], []
    for shot in drive_over_field(PAYOFF_SEED, moves=PAYOFF_MOVES):
        seen = observe(measure, shot.picture.pixels, shot.picture.view)
        log.append((shot.motion, seen))
        true.append(shot.pose.as_array())
    return log, np.array(true)
