"""Measurements of one picture: their covariance, the body tilt they share, and what follows from them."""

from dataclasses import replace

import numpy as np
import pytest

from nao_course.field_slam.observation import (
    CAMERA_HEIGHT,
    as_observation,
    observation,
    picture_covariance,
    tilt_jacobian,
    tilted,
)
from nao_course.sim import NAO_V4
from nao_course.slam import Measurement

HEAD_PITCH = float(np.radians(-31.0))
VIEW = NAO_V4.view("bottom", 0.5, HEAD_PITCH)


def some(number: int = 3) -> list[Measurement]:
    rng = np.random.default_rng(number)
    return [Measurement(b, r) for b, r in rng.uniform((-0.8, 0.8), (0.8, 3.5), (number, 2))]


def ground(pixels, view) -> np.ndarray:
    """Return bearing and range of pixels by the exact geometry."""
    right, below = ((view.undistort(pixels) - view.centre) / view.focal).T
    rays = np.column_stack([np.ones(len(right)), -right, -below]) @ view.rotation.T
    points = np.array(view.offset) - view.height * rays[:, :2] / rays[:, 2:]
    return np.column_stack([np.arctan2(points[:, 1], points[:, 0]), np.hypot(*points.T)])


def test_a_tilted_view_is_that_of_the_robots_kinematics_and_the_tilt_jacobian_that_of_its_camera():
    points = np.array([(1.2, 0.4), (2.0, 1.5), (2.8, 0.2)])
    pixels, step = VIEW.project(points), 1e-4
    by_pitch, by_roll = (
        (ground(pixels, tilted(VIEW, *tilt)) - ground(pixels, tilted(VIEW, *-tilt))) / (2 * step)
        for tilt in step * np.eye(2)
    )
    expected = -tilt_jacobian(ground(pixels, VIEW)).reshape(-1, 2, 2)
    # The camera is not above the point about which it tilts, but 5 cm ahead of it.
    assert np.allclose(by_pitch, expected[..., 0], rtol=0.12, atol=0.12)
    assert np.allclose(by_roll, expected[..., 1], rtol=0.12, atol=0.12)
    tilt = 0.02, -0.015
    true = NAO_V4.view("bottom", 0.5, HEAD_PITCH, torso_pitch=tilt[0], torso_roll=tilt[1])
    made = tilted(VIEW, *tilt)
    assert np.allclose(made.rotation, true.rotation) and np.allclose(made.position, true.position)


def test_a_covariance_is_independent_noise_and_a_common_tilt_which_a_part_keeps():
    measured = some()
    alone, together = picture_covariance(measured, (0.0, 0.0)), picture_covariance(measured, (0.02, 0.0))
    assert np.allclose(alone, np.diag(np.diag(alone)))
    assert np.linalg.matrix_rank(together - alone, tol=1e-12) == 1
    seen = as_observation(some(3))
    assert np.allclose(seen.part([2, 0]).covariance[:2, 2:], seen.covariance[4:6, :2])
    by_mask = seen.part([True, False, True])
    assert list(by_mask) == [seen[0], seen[2]]
    assert np.array_equal(by_mask.covariance, seen.part([0, 2]).covariance)
    assert list(seen.part(np.nonzero([1, 0, 1]))) == list(by_mask) and list(seen.part(-1)) == [seen[2]]
    with pytest.raises(IndexError, match="boolean"):
        seen.part([True, False])
    assert len(seen.part([])) == 0 and seen.part([]).covariance.shape == (0, 0)


def test_a_post_is_known_to_its_thickness_and_decorrelated_measurements_determine_the_tilt_no_better():
    near = [Measurement(0.1, 1.0, "post"), Measurement(0.1, 1.0, "corner")]
    as_points, thick = (observation(near, post_sigma=sigma).covariance for sigma in (0.0, 0.02))
    assert np.allclose(thick - as_points, np.diag([0.02**2, 0.02**2, 0, 0]))
    far = [Measurement(0.1, 4.0, "post")]
    more = observation(far, post_sigma=0.02).covariance - observation(far).covariance
    assert np.allclose(np.diag(more), [(0.02 / 4) ** 2, 0.02**2])
    seen = observation([Measurement(0.0, 2.0)] * 4, (0.02, 0.0))
    _, R = seen.decorrelated([2.0] * 4)
    together = np.ones(4) @ np.linalg.inv(seen.covariance[1::2, 1::2]) @ np.ones(4)
    assert np.sum(1 / R[:, 1, 1]) == pytest.approx(together, rel=1e-6)


def test_the_inverse_range_is_linear_in_the_tilt_and_its_covariance_is_propagated_by_its_jacobian():
    true = np.array([3.0, 2.0])
    for error in (0.02, -0.02):
        measured = 1 / (1 / true + error / CAMERA_HEIGHT)
        seen = as_observation([Measurement(0.0, r) for r in measured])
        values, _ = seen.linearised_at(true)
        assert np.allclose(values[1::2] - true, -(true**2) * error / CAMERA_HEIGHT)
    seen = as_observation(some())
    values, covariance = seen.linearised_at(seen.values[:, 1])
    assert np.allclose(values, seen.values.ravel()) and np.allclose(covariance, seen.covariance)
    seen, step = as_observation(some()), 1e-6
    expected, measured = seen.values[:, 1] * (0.8, 1.1, 1.3), seen.values.ravel()
    J = np.zeros((measured.size, measured.size))
    for column in range(measured.size):
        ends = []
        for sign in (1, -1):
            moved = measured.copy()
            moved[column] += sign * step
            again = tuple(Measurement(bearing, distance) for bearing, distance in moved.reshape(-1, 2))
            ends.append(replace(seen, measurements=again).linearised_at(expected)[0])
        J[:, column] = (ends[0] - ends[1]) / (2 * step)
    assert np.allclose(seen.linearised_at(expected)[1], J @ seen.covariance @ J.T, rtol=1e-6)


@pytest.mark.parametrize("distance", [0.4, 1.0, 3.0])
def test_a_corners_range_is_known_to_a_pixel_of_its_depression(distance):
    seen = observation([Measurement(0.0, distance)], (0.0, 0.0), corner_sigma=0.5)
    angle = np.sqrt(seen.covariance[0, 0])
    down = np.arctan2(CAMERA_HEIGHT, distance)
    change = CAMERA_HEIGHT / np.tan(down - angle / 2) - CAMERA_HEIGHT / np.tan(down + angle / 2)
    assert np.sqrt(seen.covariance[1, 1]) == pytest.approx(change, rel=1e-3)
