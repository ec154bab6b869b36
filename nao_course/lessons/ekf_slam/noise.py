"""Combine the noise of several landmarks in one covariance, and check the range of angles."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.codec import register
from nao_course.geometry import FloatArray

SLACK = 1e-9  # rad, for rounding at the half turn


@register
def joint_noise(measurement_covariance: npt.ArrayLike, k: int) -> FloatArray:
    """Return the joint covariance of the noise of k landmarks, in the order (bearing, range, bearing, range, ...).

    Parameters
    ----------
    measurement_covariance : array_like, shape (2, 2), (k, 2, 2) or (2k, 2k)
        The same for each landmark, one for each, or the joint covariance: rad^2 and m^2.
    k : int
        Number of landmarks.

    Returns
    -------
    ndarray, shape (2k, 2k)
        Blocks on the diagonal, unless the joint covariance was given; a new array.

    Raises
    ------
    ValueError
        If the covariance has another shape.

    Examples
    --------
    >>> joint_noise([[1.0, 0.0], [0.0, 4.0]], 2).diagonal().tolist()
    [1.0, 4.0, 1.0, 4.0]
    """
    given = np.array(measurement_covariance, dtype=float)
    if given.shape == (2 * k, 2 * k):
        return given
    if given.shape not in ((2, 2), (k, 2, 2)):
        raise ValueError(
            f"measurement_covariance of {k} landmarks must have shape (2, 2), ({k}, 2, 2) or "
            f"({2 * k}, {2 * k}), got {given.shape}"
        )
    joint = np.zeros((k, 2, k, 2))
    joint[np.arange(k), :, np.arange(k), :] = given
    return joint.reshape(2 * k, 2 * k)


@register
def in_one_turn(args: Any, kwargs: Any, answer: Any) -> str:
    """Check that all angles returned by `warp2pi` lie between -pi and pi."""
    angles = np.asarray(answer, dtype=float)
    if np.all(np.abs(angles) <= np.pi + SLACK):
        return ""
    return "some of your angles are outside the range from -pi to pi"
