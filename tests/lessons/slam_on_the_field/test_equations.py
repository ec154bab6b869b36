"""The equations of lesson 11, held against the library and the lesson's solution."""

from dataclasses import replace

import numpy as np
import pytest

from nao_course.field_slam.compass import wrap_quarter
from nao_course.field_slam.observation import CAMERA_HEIGHT, as_observation, picture_covariance, tilt_jacobian
from nao_course.geometry import Pose, wrap_angle
from nao_course.slam import Measurement, range_and_bearing
from tests.lessons.every import text


@pytest.mark.asserts("eq-11-1")
def test_a_small_tilt_about_the_feet_changes_a_range_by_its_square_over_the_height(rng):
    for r, b in zip(rng.uniform(0.8, 4, 20), rng.uniform(-1, 1, 20), strict=True):
        tau = 1e-5
        assert np.isclose((tilted_range(b, r, tau) - r) / tau, r**2 / CAMERA_HEIGHT * np.cos(b), rtol=1e-3)
        assert np.isclose(tilt_jacobian(np.array([[b, r]]))[1, 0], r**2 / CAMERA_HEIGHT * np.cos(b))


def test_the_text_says_how_good_the_approximations_are_and_its_worked_edge_is_that_of_the_equations():
    near, far = (1.0, np.radians(1)), (4.0, np.radians(2))
    (near_1, near_exact), (far_1, far_exact) = (
        (r**2 / CAMERA_HEIGHT * tau, tilted_range(0.0, r, tau) - r) for r, tau in (near, far)
    )
    assert f"At 1 m and 1° it gives {100 * near_1:.1f} cm (exact: {100 * near_exact:.1f} cm)" in text("11")
    assert f"at 4 m and 2° {far_1:.2f} m (exact: {far_exact:.2f} m)" in text("11")
    inverse = 1 / (1 / far[0] - far[1] / CAMERA_HEIGHT) - far[0]
    others = f"(exact: {far_exact:.2f} m; equation 11.1: {far_1:.2f} m)"
    assert f"predicts that the range is {inverse:.2f} m too long {others}" in text("11")
    assert f"at height $h$, here {CAMERA_HEIGHT:.3f} m" in text("11")
    b, r = 0.3, 2.0
    J = np.array([[-r * np.sin(b), np.cos(b)], [r * np.cos(b), np.sin(b)]])
    (xx, xy), (_, yy) = np.linalg.inv(J @ np.diag([0.02**2, 0.2**2]) @ J.T)
    assert f"$z = ({r * np.cos(b):.3f}, {r * np.sin(b):.3f}, 0)$" in text("11")
    assert f"{xx:.1f} & {xy:.1f} & 0 \\\\ {xy:.1f} & {yy:.1f} & 0" in text("11")


@pytest.mark.asserts("eq-11-2")
def test_what_a_picture_shares_is_one_tilt():
    seen = [Measurement(0.3, 2.0), Measurement(-0.4, 3.0, "post"), Measurement(0.0, 1.2)]
    tilt = np.array([[4e-4, 1e-4], [1e-4, 2e-4]])
    G = tilt_jacobian(np.array([(each.bearing, each.range) for each in seen]))
    shared = picture_covariance(seen, tilt) - picture_covariance(seen, np.zeros((2, 2)))
    assert np.allclose(shared, G @ tilt @ G.T)
    alone = picture_covariance(seen, np.zeros((2, 2)))
    assert np.allclose(alone, np.diag(np.diag(alone)))


@pytest.mark.asserts("eq-11-3")
def test_pairs_together_are_as_far_as_their_whole_covariance_says(own, rng):
    state = np.array([0.3, -0.2, 0.5, 2.0, 1.0, 1.5, -1.0])
    root = rng.normal(0, 0.1, (7, 7))
    P, R = root @ root.T, np.diag([0.01, 0.04, 0.01, 0.04])
    exact = range_and_bearing(state[:3], state[3:].reshape(2, 2))
    seen = [Measurement(float(b), float(r)) for b, r in exact + rng.normal(0, 0.1, (2, 2))]
    values = np.ravel([(each.bearing, each.range) for each in seen])

    def innovation(x):
        away = values - range_and_bearing(x[:3], x[3:].reshape(2, 2)).ravel()
        away[::2] = wrap_angle(away[::2])
        return away

    H = -np.column_stack([(innovation(state + e) - innovation(state - e)) / 2e-6 for e in 1e-6 * np.eye(7)])
    away = innovation(state)
    wanted = np.sqrt(away @ np.linalg.inv(H @ P @ H.T + R) @ away)
    assert np.isclose(own["joint_distance"](state, P, [0, 1], seen, R), wanted, rtol=1e-5)
    assert own["joint_distance"](state, P, [-1, -1], seen, R) == 0
    moved = [replace(each, bearing=each.bearing + 0.3) for each in seen]
    both, one = (own["joint_distance"](state, P, pairs, moved, R) for pairs in ([0, 1], [0, -1]))
    assert both > one


def tilted_range(bearing, distance, tau):
    """The range at which an upright robot would see a landmark if its body tilts forward by `tau` about its feet."""
    x, y = distance * np.cos(bearing), distance * np.sin(bearing)
    ahead, up = x * np.cos(tau), x * np.sin(tau)  # in the body's frame
    return float(np.hypot(ahead, y) * CAMERA_HEIGHT / (CAMERA_HEIGHT - up))


def turned(own, off, sigma, gate=4.0):
    """Return a filter with an uncertain heading, after a compass that measures it to be `off`."""
    slam = own["EkfSlam"](Pose(0.0, 0.0, 1.0), gate=gate)
    slam.covariance = np.array([[0.01, 0.0, 0.002], [0.0, 0.01, 0.001], [0.002, 0.001, 0.0025]])
    slam.use_compass(float(wrap_quarter(-(1.0 + off))), sigma)
    return slam


@pytest.mark.asserts("eq-11-4")
def test_a_compass_corrects_all_that_shares_the_headings_error_however_far_it_is(own):
    slam = turned(own, 0.1, 0.05)
    assert np.isclose(slam.state[2], 1.0 + 0.1 * 0.0025 / 0.005) and np.isclose(slam.heading, 1.1)
    assert np.isclose(slam.state[0], 0.1 * 0.002 / 0.005)
    assert np.isclose(slam.covariance[2, 2], 1 / (1 / 0.0025 + 1 / 0.05**2))
    assert np.isclose(turned(own, 0.6, 0.01).heading, 1.6)
    assert turned(own, 0.0, np.inf).heading is None


@pytest.mark.asserts("eq-11-5")
def test_the_inverse_of_a_range_is_linear_in_the_tilt():
    b, r, tau = 0.4, 3.0, np.radians(2.0)
    tilted = 1 / (1 / r - np.cos(b) * tau / CAMERA_HEIGHT)
    expected = 2.8
    values, _ = as_observation([Measurement(b, tilted)]).linearised_at([expected])
    straight, _ = as_observation([Measurement(b, r)]).linearised_at([expected])
    assert np.isclose(values[1], expected + expected**2 * (1 / expected - 1 / tilted))
    assert np.isclose(values[1] - straight[1], expected**2 * np.cos(b) * tau / CAMERA_HEIGHT)


def test_a_new_landmark_shares_its_pictures_tilt(own):
    seen = [Measurement(0.3, 2.0), Measurement(-0.3, 3.0)]
    slam = own["EkfSlam"](Pose())
    slam.observe(seen)
    shared = slam.covariance[3:5, 5:7]
    apart = picture_covariance(seen)[0:2, 2:4]
    turn = [
        np.array([[-r * np.sin(b), np.cos(b)], [r * np.cos(b), np.sin(b)]]) for b, r in ((0.3, 2), (-0.3, 3))
    ]
    assert np.allclose(shared, turn[0] @ apart @ turn[1].T, rtol=2e-3)
