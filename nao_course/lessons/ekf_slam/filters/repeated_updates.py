"""Many updates in a row, which show in a moment whether a covariance stays symmetric."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nao_course.exercises import register, register_driver

# m^2 and rad^2, what is added to the pose's covariance before each update.
DRIFT = np.diag([0.05, 0.03, 0.03]) ** 2
LARGEST_ASYMMETRY = (
    1e-9  # of the largest entry; symmetric forms stay below 1e-12, the others pass 1e-6 in 60 updates
)


@register_driver
def repeated_updates(
    update_landmarks: Callable[..., Any],
    state: Any,
    covariance: Any,
    indices: Any,
    measurements: Any,
    measurement_covariance: Any,
) -> Any:
    """Call ``update_landmarks`` once, or once for each of several states.

    The state (3 + 2k,) or (updates, 3 + 2k) is where each update is linearised. The covariance (3 + 2k, 3 + 2k) is from
    before the first update; each update gets the covariance that the previous one returned. Measurements (2m,) or
    (updates, 2m) are bearings in rad and ranges in m. After several updates, return the last state, and the covariance
    divided by its largest entry.
    """
    if np.ndim(state) == 1:
        return update_landmarks(state, covariance, indices, measurements, measurement_covariance)
    after = state[-1]
    for before, measured, values in zip(state, indices, measurements, strict=True):
        covariance = np.array(covariance, dtype=float)
        covariance[:3, :3] += DRIFT
        covariance[3:, :3] = covariance[:3, 3:].T
        try:
            after, covariance = update_landmarks(
                before.copy(), covariance, list(measured), values, measurement_covariance
            )
        except np.linalg.LinAlgError:  # rounding errors made S singular; the covariance shows their asymmetry
            break
    return after, covariance / np.abs(covariance).max()


@register
def stays_symmetric(args: tuple[Any, ...], kwargs: dict[str, Any], answer: Any) -> str:
    """Check that the covariance is symmetric after several updates."""
    states = args[0]
    if np.ndim(states) == 1:
        return ""
    covariance = np.asarray(answer[1], dtype=float)
    asymmetry = float(np.abs(covariance - covariance.T).max())
    if asymmetry <= LARGEST_ASYMMETRY:
        return ""
    share = f"{asymmetry:.0e} of its largest entry" if np.isfinite(asymmetry) else "infinitely much"
    return (
        f"After {len(states)} updates your covariance differs from its transpose by {share}. A rounding error made it "
        "slightly asymmetric, and each update amplified the asymmetry. Return (P + P.T) / 2, or subtract a product "
        "that is symmetric, such as A.T @ A"
    )
