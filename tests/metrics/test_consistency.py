"""Squared errors and the bounds of their mean."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from nao_course.metrics import band, log_density, squared_distances


def test_the_band_is_bar_shaloms_and_squared_distances_and_bits_are_those_of_gaussian_densities(rng):
    assert np.round(band(3, 100), 2).tolist() == [2.54, 3.50]
    assert np.round(band(2, 50), 2).tolist() == [1.48, 2.59]
    vectors = rng.normal(size=(3, 2))
    covariances = np.array([np.eye(2), 4 * np.eye(2), [[2.0, 1.0], [1.0, 2.0]]])
    wanted = [v @ np.linalg.inv(P) @ v for v, P in zip(vectors, covariances, strict=True)]
    assert np.allclose(squared_distances(vectors, covariances), wanted)
    assert squared_distances(np.zeros((0, 2)), np.zeros((0, 2, 2))).shape == (0,)
    root = rng.normal(size=(3, 3))
    pose, covariance, off = np.array([1.0, 2.0, 3.1]), root @ root.T + np.eye(3), np.array([0.3, -0.2, 0.1])
    bits, squared = log_density(pose, covariance, pose + off - (0, 0, 2 * np.pi))
    assert bits == pytest.approx(multivariate_normal.logpdf(off, cov=covariance) / np.log(2))
    assert squared == pytest.approx(off @ np.linalg.solve(covariance, off))
