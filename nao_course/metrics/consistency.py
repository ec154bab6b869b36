"""Consistency of an estimator: squared errors (NEES and NIS), their bounds, and the log density at the truth."""

from __future__ import annotations

import numpy as np

from nao_course.geometry import FloatArray, wrap_angle

__all__ = ["band", "log_density", "squared_distances"]


def band(degrees: int, runs: int, probability: float = 0.95) -> tuple[float, float]:
    """Return the chi-square bounds for the mean of `runs` independent squared errors.

    Parameters
    ----------
    degrees : int
        Degrees of freedom of each error: 3 for a pose's NEES, 2 for the NIS of bearing and range.
    runs : int
        Number of errors that are averaged.
    probability : float
        Probability that the mean lies between the bounds; it is as likely to be below them as above.

    Returns
    -------
    (float, float)
        Lower and upper bound: quantiles of chi-square with ``degrees * runs`` degrees of freedom, divided by `runs`
        (Bar-Shalom et al. 2001, section 5.4).

    Examples
    --------
    >>> [round(each, 2) for each in band(3, 100)]
    [2.54, 3.5]
    """
    from scipy.special import chdtri  # SciPy's stats would take long to import

    low, high = chdtri(degrees * runs, [(1 + probability) / 2, (1 - probability) / 2]) / runs
    return float(low), float(high)


def squared_distances(vectors: FloatArray, covariances: FloatArray) -> FloatArray:
    """Return the squared Mahalanobis distances (K,) of vectors (K, n) with covariances (K, n, n): NEES or NIS."""
    if not len(vectors):
        return np.zeros(0)
    scaled = np.linalg.solve(covariances, vectors[..., None])[..., 0]
    return np.asarray(np.einsum("ki,ki->k", vectors, scaled))


def log_density(pose: FloatArray, covariance: FloatArray, truth: FloatArray) -> tuple[float, float]:
    """Return the base-2 logarithm of the estimated density at the true pose, and the NEES of the estimate.

    Parameters
    ----------
    pose, truth : ndarray, shape (3,)
        Estimated and true pose, m and rad.
    covariance : ndarray, shape (3, 3)
        Covariance of the estimate, positive definite.

    Returns
    -------
    (float, float)
        Log density in bits, and NEES without a unit. A smaller covariance increases the density only if the true pose
        is near the estimate.
    """
    error = np.append(truth[:2] - pose[:2], wrap_angle(truth[2] - pose[2]))
    root = np.linalg.cholesky(covariance)
    squared = float(np.sum(np.linalg.solve(root, error) ** 2))
    nats = -squared / 2 - float(np.log(np.diag(root)).sum()) - 1.5 * np.log(2 * np.pi)
    return float(nats / np.log(2)), squared
