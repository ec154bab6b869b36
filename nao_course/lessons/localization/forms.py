"""The smallest eigenvalue of a covariance during many precise updates: rounding makes it negative."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nao_course.plotting.drawing import Table, table

UPDATES = 300
SIGMAS = (0.1, 1e-4, 1e-5, 1e-8)  # standard deviations of bearing (rad) and range (m)


def smallest_eigenvalue(kalman_update: Callable[..., Any], sigma: float) -> float:
    """Return the smallest eigenvalue that a pose's covariance has after any of `UPDATES` updates of this precision."""
    rng = np.random.default_rng(6)
    covariance, least = np.diag([0.4**2, 0.4**2, np.radians(15) ** 2]), np.inf
    bearings, ranges = rng.uniform(-np.pi, np.pi, UPDATES), rng.uniform(0.5, 3.0, UPDATES)
    for bearing, distance in zip(bearings, ranges, strict=True):
        c, s = np.cos(bearing), np.sin(bearing)
        jacobian = np.array([[s / distance, -c / distance, -1.0], [-c, -s, 0.0]])
        answer = kalman_update(np.zeros(3), covariance.copy(), np.zeros(2), jacobian, np.eye(2) * sigma**2)
        covariance = np.asarray(answer[1], dtype=float)
        least = min(least, float(np.linalg.eigvalsh((covariance + covariance.T) / 2)[0]))
    return least


def as_written(value: float) -> str:
    """Write an eigenvalue with one digit, and a negative one as "negative", because its size is a matter of chance."""
    return f"{value:.0e}" if value > 0 else "negative"


def eigenvalue_table(kalman_update: Callable[..., Any]) -> Table:
    """Return a table of the smallest eigenvalue during 300 updates, by the standard deviation of the measurements."""
    rows = [(f"{sigma:g}", as_written(smallest_eigenvalue(kalman_update, sigma))) for sigma in SIGMAS]
    return table(["standard deviation (rad and m)", "smallest eigenvalue after any update"], rows)
