"""The limits of a linearisation: the error of mean and covariance measured at growing uncertainty of the heading."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nao_course.geometry import FloatArray
from nao_course.lessons.ekf_derivations.figures import draw_curves
from nao_course.lessons.ekf_derivations.samples import Cloud, draw
from nao_course.plotting import Drawing

Function = Callable[..., Any]

SIGMAS = np.radians([2, 5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60])
RUNS, NUMBER = 20, 2000
PLACE_SIGMA = 0.03  # m: a heading alone would make an ellipse without any width
TITLES = ("mean too far ahead by (%)", "σ across too large by (%)", "samples in the 95 % ellipse (%)")


def short_mean(sigma: FloatArray) -> FloatArray:
    """Part of a drive by which the mean of all robots falls short, with a heading's standard deviation (rad)."""
    return 1 - np.exp(-(sigma**2) / 2)


def across_too_large(sigma: FloatArray) -> FloatArray:
    """Part by which a linearisation overstates the standard deviation across: sigma against that of sin(heading)."""
    return sigma / np.sqrt((1 - np.exp(-2 * sigma**2)) / 2) - 1


def heading_clouds(
    predict_pose: Function, predict_covariance: Function, sigma: float, place_sigma: float = PLACE_SIGMA
) -> list[Cloud]:
    """Drives of 1 m with an uncertain heading (rad) from an uncertain place (m), in several runs of many robots."""
    rng = np.random.default_rng(7)
    pose, control = np.zeros(3), np.array([1.0, 0.0])
    covariance = np.diag([place_sigma, place_sigma, sigma]) ** 2
    spread = np.asarray(
        predict_covariance(covariance.copy(), pose.copy(), control.copy(), np.zeros((3, 3))), dtype=float
    )
    mean = np.asarray(predict_pose(pose.copy(), control.copy()), dtype=float)
    # one call for each heading on a fine grid: the places of the robots are added behind it
    grid = np.linspace(-5 * sigma, 5 * sigma, 1001)
    ends = np.array(
        [np.asarray(predict_pose(np.array([0.0, 0.0, each]), control.copy()))[:2] for each in grid]
    )
    clouds = []
    for _ in range(RUNS):
        start = draw(pose, covariance, NUMBER, rng)
        moved = np.column_stack([np.interp(start[:, 2], grid, ends[:, axis]) for axis in (0, 1)])
        clouds.append(Cloud(start[:, :2] + moved, mean[:2], spread[:2, :2]))
    return clouds


def measure_limits(predict_pose: Function, predict_covariance: Function) -> dict[str, FloatArray]:
    """Measure what linearising the heading costs, at each of `SIGMAS`.

    Returns
    -------
    dict of str to ndarray, shape (S, 3)
        By `TITLES`, in percent: the 2.5 % quantile of all runs, the mean, the 97.5 % quantile.
    """
    found: dict[str, list[FloatArray]] = {title: [] for title in TITLES}
    for sigma in SIGMAS:
        clouds = heading_clouds(predict_pose, predict_covariance, float(sigma))
        across = [np.sqrt(each.covariance[1, 1] / each.sampled_covariance[1, 1]) - 1 for each in clouds]
        values = ([-each.shift[0] for each in clouds], across, [each.inside() for each in clouds])
        for title, runs in zip(TITLES, values, strict=True):
            low, high = np.quantile(runs, [0.025, 0.975])
            found[title].append(100 * np.array([low, np.mean(runs), high]))
    return dict(zip(found, map(np.array, found.values()), strict=True))


def limit_at(measured: FloatArray, percent: float) -> float:
    """Standard deviation of the heading (degrees) at which a measured curve (S, 3) first passes a value.

    Between two measured ones it is looked for on a parabola, as the curves are near zero, and not on a straight line.
    """
    return round(float(np.sqrt(np.interp(percent, measured[:, 1], np.degrees(SIGMAS) ** 2))), 1)


def draw_limits(measured: dict[str, FloatArray]) -> Drawing:
    """Draw what `measure_limits` measured, with the formulas for mean and covariance."""
    formulas = {TITLES[0]: 100 * short_mean(SIGMAS), TITLES[1]: 100 * across_too_large(SIGMAS)}
    return draw_curves(SIGMAS, measured, formulas)
