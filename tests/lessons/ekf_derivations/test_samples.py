"""Samples and their linearisation: they agree where a function is straight, and part where it is not."""

import numpy as np
import pytest

from nao_course.lessons.ekf_derivations import samples

POSE = (1.0, 2.0, 2.4)
SMALL = np.diag([0.02, 0.01, 0.005]) ** 2
CONTROL_NOISE = np.diag([0.05, 0.01, 0.02]) ** 2
MEASUREMENT_NOISE = np.diag([0.01, 0.02]) ** 2


def agrees(cloud):
    error = np.linalg.norm(cloud.shift) / np.sqrt(np.trace(cloud.covariance) / len(cloud.points))
    ratio = np.linalg.solve(cloud.covariance, cloud.sampled_covariance)
    return error < 4 and np.allclose(ratio, np.eye(2), atol=0.12) and 0.93 < cloud.inside() < 0.97


def test_drawn_samples_have_the_mean_and_covariance_that_are_asked_for(rng):
    covariance = np.array([[2.0, 0.6, 0.0], [0.6, 0.5, -0.1], [0.0, -0.1, 0.3]])
    drawn = samples.draw([1, 2, 3], covariance, 100_000, rng)
    assert np.allclose(drawn.mean(axis=0), [1, 2, 3], atol=0.03)
    assert np.allclose(np.cov(drawn.T), covariance, atol=0.04)
    assert (samples.draw([1, 2], np.zeros((2, 2)), 5, rng) == [1, 2]).all()


def test_where_all_is_nearly_straight_the_right_solution_predicts_its_samples(solution, rng):
    s, z = solution, MEASUREMENT_NOISE
    drive = s["predict_pose"], s["predict_covariance"]
    place = s["landmark_position"], s["landmark_jacobians"]
    seen = s["expected_measurement"], s["measurement_jacobian_pose"]
    assert agrees(samples.motion_cloud(*drive, POSE, SMALL, (1.5, 0.3), CONTROL_NOISE, rng, 3000))
    assert agrees(samples.landmark_cloud(*place, SMALL, (0.7, 2.0), z, rng, 3000))
    assert agrees(samples.measurement_cloud(*seen, SMALL, (-2.0, 0.01), rng, 3000))
    behind = samples.measurement_cloud(*seen, np.diag([0.1, 0.1, 0.2]) ** 2, (-2.0, 0.0), rng)
    assert np.ptp(behind.points[:, 0]) < np.pi  # bearings stay together
    across = samples.motion_cloud(
        *drive, (0, 0, np.pi / 2), 0 * SMALL, (1, 0), np.diag([0.0, 0.2, 0.0]) ** 2, rng
    )
    assert np.allclose(across.points[:, 1], 1)
    assert np.std(across.points[:, 0]) == pytest.approx(0.2, rel=0.15)


def test_a_wrong_sign_in_a_jacobian_shows_in_the_ellipse(solution):
    def wrong(pose, measurement):
        by_pose, by_measurement = solution["landmark_jacobians"](pose, measurement)
        return by_pose * [[1, 1, -1], [1, 1, 1]], by_measurement

    def inside(jacobians):
        large, rng = np.diag([0.01, 0.01, 0.1]) ** 2, np.random.default_rng(1)
        place = solution["landmark_position"]
        return samples.landmark_cloud(place, jacobians, large, (0.8, 2.0), MEASUREMENT_NOISE, rng).inside()

    assert inside(solution["landmark_jacobians"]) > 0.85 and inside(wrong) < 0.7


def test_a_covariance_is_carried_by_both_sides_and_a_cloud_counts_what_is_inside_its_ellipse(rng):
    slopes, root = rng.normal(size=(2, 3)), rng.normal(size=(3, 3))
    assert np.allclose(samples.propagated(slopes, root @ root.T), slopes @ root @ root.T @ slopes.T)
    assert np.allclose(samples.propagated(slopes, np.zeros((3, 3))), 0, atol=1e-15)
    points = np.array([[0.0, 0.0], [2.4, 0.0], [2.5, 0.0], [0.0, -2.4]])
    assert samples.Cloud(points, np.zeros(2), np.eye(2)).inside() == 0.75
    assert samples.Cloud(points, np.zeros(2), np.diag([1.0, 0.01])).inside() == 0.5
