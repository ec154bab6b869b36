"""The limits of a linearisation: the error of mean, covariance and shape as the heading becomes more uncertain."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.optimize import brentq

from nao_course.geometry import FloatArray
from nao_course.lessons.ekf_derivations.figures import draw_curves
from nao_course.lessons.ekf_derivations.samples import Cloud, draw
from nao_course.plotting import Drawing

Function = Callable[..., Any]

SIGMAS = np.radians([2, 5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60])
RUNS, NUMBER = 20, 2000
POSITION_SIGMA = 0.03  # m; with an exact position the ellipse would have no width
TITLES = (
    "predicted mean too far ahead (%)",
    "cross-track σ too large (%)",
    "samples in the 95 % ellipse (%)",
)


def short_mean(sigma: FloatArray) -> FloatArray:
    """Return the fraction of the distance by which the mean falls short, for a heading's standard deviation (rad)."""
    return 1 - np.exp(-(sigma**2) / 2)


def across_too_large(sigma: FloatArray) -> FloatArray:
    """Return the fraction by which a linearisation overstates the cross-track standard deviation."""
    return sigma / np.sqrt((1 - np.exp(-2 * sigma**2)) / 2) - 1


def heading_clouds(
    predict_pose: Function, predict_covariance: Function, sigma: float, position_sigma: float = POSITION_SIGMA
) -> list[Cloud]:
    """Simulate drives of 1 m from an uncertain heading (rad) and position (m): one cloud for each run."""
    rng = np.random.default_rng(7)
    pose, control = np.zeros(3), np.array([1.0, 0.0])
    covariance = np.diag([position_sigma, position_sigma, sigma]) ** 2
    predicted = np.asarray(
        predict_covariance(covariance.copy(), pose.copy(), control.copy(), np.zeros((3, 3))), dtype=float
    )
    mean = np.asarray(predict_pose(pose.copy(), control.copy()), dtype=float)
    # One call for each heading on a fine grid; the starting positions are added afterwards.
    grid = np.linspace(-5 * sigma, 5 * sigma, 1001)
    ends = np.array(
        [np.asarray(predict_pose(np.array([0.0, 0.0, each]), control.copy()))[:2] for each in grid]
    )
    clouds = []
    for _ in range(RUNS):
        start = draw(pose, covariance, NUMBER, rng)
        moved = np.column_stack([np.interp(start[:, 2], grid, ends[:, axis]) for axis in (0, 1)])
        clouds.append(Cloud(start[:, :2] + moved, mean[:2], predicted[:2, :2]))
    return clouds


def measure_limits(predict_pose: Function, predict_covariance: Function) -> dict[str, FloatArray]:
    """Measure the errors of a linearisation at each of `SIGMAS`.

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


def limit_of_mean(predict_pose: Function, percent: float) -> float:
    """Return the heading's standard deviation (degrees) at which the mean of a 1 m drive falls short by `percent`.

    The mean is integrated over the heading, so the answer does not depend on any samples. The largest standard
    deviation that is tried is 60 degrees.
    """
    headings = np.linspace(-5.5, 5.5, 4001)
    control = np.array([1.0, 0.0])
    ahead = np.array(
        [float(predict_pose(np.array([0.0, 0.0, each]), control.copy())[0]) for each in headings]
    )

    def short(sigma: float) -> float:
        weights = np.exp(-0.5 * (headings / sigma) ** 2)
        return float(1 - ahead @ weights / weights.sum() - percent / 100)

    low, high = np.radians([0.5, 60])
    if short(high) < 0:
        return float("inf")
    return round(float(np.degrees(brentq(short, low, high))), 2)


def draw_limits(measured: dict[str, FloatArray]) -> Drawing:
    """Draw the results of `measure_limits` beside the formulas for mean and covariance."""
    formulas = {TITLES[0]: 100 * short_mean(SIGMAS), TITLES[1]: 100 * across_too_large(SIGMAS)}
    return draw_curves(SIGMAS, measured, formulas)
