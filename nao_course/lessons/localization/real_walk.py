"""A real NAO's walk, localised by the student's functions from measurements of its pictures."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from nao_course.datasets.real_walk import FIELD, recorded_walk
from nao_course.lessons.localization.drives import follow
from nao_course.plotting import STYLES, Drawing, course_style, plot_ellipse, plot_field
from nao_course.plotting.legends import legend_below, source_key
from nao_course.sim.drives import Function

WRONG_START = (-0.3, 0.5, float(np.radians(-10.0)))  # error of the first estimate, m and rad
START_SIGMAS = (0.4, 0.4, float(np.radians(12.0)))  # m and rad
EVERY = 4  # pictures between two ellipses


@course_style()
def draw_real_walk(localize: Function, predict_pose: Function, predict_covariance: Function) -> Drawing:
    """Draw the walk of a real NAO as the student's filter estimates it, and its errors beside the stated ones.

    Parameters
    ----------
    localize, predict_pose, predict_covariance : callable
        The student's functions of lessons 05 and 06.

    Returns
    -------
    Drawing
        A map of the whole field, and the errors of position and heading after each picture.
    """
    trace = follow(
        recorded_walk(),
        localize,
        predict_pose,
        predict_covariance,
        np.diag(np.square(START_SIGMAS)),
        WRONG_START,
    )
    figure = Figure(figsize=(10.6, 4.6))
    left, upper, lower = figure.subplot_mosaic("ab;ac", width_ratios=(1.3, 1.0)).values()
    plot_field(FIELD, left)
    for style, poses in ((STYLES["truth"], trace.truth), (STYLES["ekf"], trace.poses)):
        left.plot(*poses[:, :2].T, style.marker, ls=style.line, color=style.colour, ms=3.5, lw=1.2, zorder=4)
    for pose, covariance in zip(trace.poses[::EVERY], trace.covariances[::EVERY], strict=True):
        plot_ellipse(pose[:2], covariance[:2, :2], left, "ekf")
    off = np.hypot(*trace.errors[:, :2].T)
    turned = np.degrees(np.abs(trace.errors[:, 2]))
    variances = np.diagonal(trace.covariances, axis1=1, axis2=2)
    stated = np.sqrt(variances[:, :2].sum(axis=1)), np.degrees(np.sqrt(variances[:, 2]))
    pictures = np.arange(1, len(off) + 1)
    for ax, error, sigma, name in zip(
        (upper, lower), (off, turned), stated, ("position (m)", "heading (°)"), strict=True
    ):
        ax.plot(pictures, error, ".-", color=STYLES["ekf"].colour, ms=5, label="error")
        ax.plot(pictures, sigma, "--", color=STYLES["ekf"].colour, lw=1.2, label="stated standard deviation")
        ax.set(ylabel=name, ylim=(0, None))
    upper.legend(fontsize=9)
    lower.set(xlabel="picture")
    upper.tick_params(labelbottom=False)
    legend_below(
        figure,
        [source_key("truth", "where it was put down"), source_key("ekf", "estimate with its 95 % ellipse")],
    )
    last = max(i for i, step in enumerate(recorded_walk().steps) if len(step.numbers))
    return Drawing(
        figure,
        f"A real walk of {len(off)} pictures. The estimate begins {off[0]:.2f} m and {turned[0]:.0f} degrees off; it "
        f"is {off[last]:.2f} m and {turned[last]:.1f} degrees off after picture {last + 1}, the last with a landmark, "
        f"and {off[-1]:.2f} m and {turned[-1]:.1f} degrees at the end.",
    )
