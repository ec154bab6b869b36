"""The equations that lesson 06 displays, each held against the solution."""

import numpy as np
import pytest
from scipy.stats import chi2

from nao_course.geometry import rotation_2d
from nao_course.lessons.localization.figures import inside


def random_covariance(rng, size):
    root = rng.normal(size=(size, size)) + np.eye(size)
    return root @ root.T


def short_form(mean, covariance, innovation, H, R):
    K = covariance @ H.T @ np.linalg.inv(H @ covariance @ H.T + R)
    return mean + K @ innovation, (np.eye(len(mean)) - K @ H) @ covariance


@pytest.mark.asserts("eq-6-1", "eq-6-2")
def test_no_other_weight_leaves_a_smaller_variance(own, rng):
    for a, b, va, vb in np.column_stack([rng.normal(size=(20, 2)), rng.uniform(0.05, 4, (20, 2))]):
        mean, variance = own["fuse"](a, va, b, vb)
        weights = np.linspace(0, 1, 1001)
        variances = (1 - weights) ** 2 * va + weights**2 * vb
        assert variance <= variances.min() + 1e-12 and variance == pytest.approx(variances.min(), rel=1e-4)
        best = weights[variances.argmin()]
        assert mean == pytest.approx(a + best * (b - a), abs=1e-3 * abs(b - a))


def test_the_numbers_of_the_first_section_are_right_and_the_update_of_one_number_is_a_fusion(own):
    mean, variance = own["fuse"](2.0, 0.3**2, 2.5, 0.15**2)
    assert (mean, variance) == pytest.approx((2.4, 0.134**2), abs=2e-4)
    one = np.ones((1, 1))
    new, left = own["kalman_update"](np.array([2.0]), 0.09 * one, np.array([0.5]), one, 0.0225 * one)
    assert (new[0], left[0, 0]) == pytest.approx((mean, variance))
    assert 1 - own["fuse"](0.0, 1.0, 1.0, 100.0)[1] == pytest.approx(1 / 101)


@pytest.mark.asserts("eq-6-3")
def test_an_innovation_turns_from_the_expected_to_the_measured_bearing_the_short_way(own, rng):
    for expected, measured in rng.uniform(-np.pi, np.pi, (200, 2)):
        bearing, distance = own["innovation"](np.array([expected, 1.0]), np.array([measured, 3.5]))
        assert abs(bearing) <= np.pi + 1e-12 and distance == 2.5
        assert np.exp(1j * (expected + bearing)) == pytest.approx(np.exp(1j * measured))


@pytest.mark.asserts("eq-6-4", "eq-6-5")
def test_the_squares_of_a_consistent_filters_errors_are_chi_square(own, rng):
    covariance = random_covariance(rng, 3)
    errors = rng.multivariate_normal(np.zeros(3), covariance, 4000)
    squares = [own["nees"](error, covariance) for error in errors]
    assert np.mean(squares) == pytest.approx(3.0, abs=0.15)
    assert np.mean(np.array(squares) < chi2.ppf(0.9, 3)) == pytest.approx(0.9, abs=0.02)


def test_the_covariance_of_an_innovation_is_that_of_the_expected_measurement_plus_the_noise(report, rng):
    """S = H P H' + R, against sampling."""
    pose, landmark = np.array([1.0, 0.2, 0.3]), np.array([3.0, 0.7])
    P, R = np.diag([1e-4, 2e-4, 1e-4]), np.diag([4e-4, 1e-3])
    H = report["measurement_jacobian_pose"](pose, landmark)
    poses = rng.multivariate_normal(pose, P, 4000)
    seen = np.array([report["expected_measurement"](each, landmark) for each in poses])
    seen = seen + rng.multivariate_normal(np.zeros(2), R, 4000)
    assert np.cov(seen.T) == pytest.approx(H @ P @ H.T + R, rel=0.1, abs=3e-5)


@pytest.mark.asserts("eq-6-6")
def test_an_ellipse_holds_the_part_that_it_is_asked_for(own, rng):
    covariance = random_covariance(rng, 2)
    points = rng.multivariate_normal(np.zeros(2), covariance, 20_000)
    for probability in (0.2, 0.5, 0.95):
        axes, angle = own["covariance_ellipse"](covariance, probability)
        assert inside(points, axes, angle) == pytest.approx(probability, abs=0.015)
        for end in rotation_2d(angle).T * np.reshape(axes, (2, 1)):
            assert own["nees"](end, covariance) == pytest.approx(-2 * np.log(1 - probability))


@pytest.mark.asserts("eq-6-7", "eq-6-8")
def test_no_other_gain_leaves_a_smaller_covariance_and_both_forms_are_one(own, rng):
    for n, m in ((1, 1), (3, 2), (4, 2)):
        mean, nu, H = rng.normal(size=n), rng.normal(size=m), rng.normal(size=(m, n))
        P, R = random_covariance(rng, n), random_covariance(rng, m)
        new, left = own["kalman_update"](mean, P, nu, H, R)
        new_short, left_short = short_form(mean, P, nu, H, R)
        assert np.allclose(new, new_short) and np.allclose(left, left_short)
        gain = np.column_stack([own["kalman_update"](mean, P, each, H, R)[0] - mean for each in np.eye(m)])
        for _ in range(20):
            other = gain + 0.05 * rng.normal(size=gain.shape)
            factor = np.eye(n) - other @ H
            assert np.trace(factor @ P @ factor.T + other @ R @ other.T) > np.trace(left)
