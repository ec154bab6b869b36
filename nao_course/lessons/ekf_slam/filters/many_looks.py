"""Look after look without a drive: rounding that lets a long drive end in nonsense shows in a moment."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nao_course.exercises import register, register_driver

DRIFT = (
    np.diag([0.05, 0.03, 0.03]) ** 2
)  # m^2 and rad^2, what the pose's covariance grows by before each look
MOST_LOPSIDED = 1e-9  # of the largest entry; healthy filters stay below 1e-12, others pass 1e-6 in 60 looks


@register_driver
def look_after_look(
    update_landmarks: Callable[..., Any],
    state: Any,
    covariance: Any,
    indices: Any,
    measurements: Any,
    measurement_covariance: Any,
) -> Any:
    """Call ``update_landmarks``: once, or once for each of several states.

    Parameters
    ----------
    update_landmarks : callable
        The lesson's.
    state : ndarray, shape (3 + 2k,) or (looks, 3 + 2k)
        Where the look is linearised, or each of the looks.
    covariance : ndarray, shape (3 + 2k, 3 + 2k)
        Before the first look; it is handed on from look to look.
    indices : list of int, or list of these
        Which landmarks are measured, in each look.
    measurements : ndarray, shape (2m,) or (looks, 2m)
        Bearing in rad and range in m.
    measurement_covariance : ndarray
        Of each look.

    Returns
    -------
    object
        What it returned. After several looks: the last state, and the covariance divided by its largest entry.
    """
    if np.ndim(state) == 1:
        return update_landmarks(state, covariance, indices, measurements, measurement_covariance)
    after = state[-1]
    for before, seen, values in zip(state, indices, measurements, strict=True):
        covariance = np.array(covariance, dtype=float)
        covariance[:3, :3] += DRIFT
        covariance[3:, :3] = covariance[:3, 3:].T
        try:
            after, covariance = update_landmarks(
                before.copy(), covariance, list(seen), values, measurement_covariance
            )
        except np.linalg.LinAlgError:  # where rounding has led before; what is lopsided then, shows that
            break
    return after, covariance / np.abs(covariance).max()


@register
def even_after_all(args: tuple[Any, ...], kwargs: dict[str, Any], answer: Any) -> str:
    """Law: after several looks the covariance is what its transpose is."""
    looks = args[0]
    if np.ndim(looks) == 1:
        return ""
    covariance = np.asarray(answer[1], dtype=float)
    lopsided = float(np.abs(covariance - covariance.T).max())
    if lopsided <= MOST_LOPSIDED:
        return ""
    share = f"{lopsided:.0e} of its largest entry" if np.isfinite(lopsided) else "all there is"
    return (
        f"After {len(looks)} looks your covariance differs from its transpose by {share}. Rounding begins it, and "
        "each look makes it larger, until the filter ends in nonsense. Return (P + P.T) / 2, or subtract a product "
        "that is symmetric: A.T @ A"
    )
