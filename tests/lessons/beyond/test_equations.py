"""The equations of lesson 12, held against its solution, and two cameras of a robot whose body tilts."""

import numpy as np
import pytest
from scipy.stats import multivariate_normal

from nao_course.geometry import wrap_angle
from nao_course.lessons.beyond import two_cameras
from nao_course.lessons.beyond.planning import options
from nao_course.lessons.beyond.worlds import LANDMARKS
from nao_course.sim import NAO_V4
from nao_course.slam import range_and_bearing


def covariance(rng, size, scale):
    root = rng.normal(0, scale, (size, size)) + np.eye(size) * scale
    return root @ root.T


def innovation(measurement, pose, landmark):
    nu = measurement - range_and_bearing(pose, landmark)
    nu[0] = wrap_angle(nu[0])
    return nu


def seen_landmark(rng, sigma):
    """Return a particle's pose, its landmark with a covariance, and a measurement with its covariance."""
    pose = np.append(rng.uniform(0, 3, 2), rng.uniform(-np.pi, np.pi))
    mean, P, R = pose[:2] + rng.uniform(0.7, 2, 2), covariance(rng, 2, 0.1), covariance(rng, 2, 0.1)
    return pose, mean, P, range_and_bearing(pose, mean) + rng.normal(0, sigma, 2), R


@pytest.mark.asserts("eq-12-1")
def test_a_particle_is_kept_as_often_as_a_tooth_of_the_comb_falls_into_its_piece(own):
    for seed, n in enumerate((1, 2, 5, 30, 400)):
        weights = np.random.default_rng(seed).exponential(1, n) ** 3
        weights /= weights.sum()
        q = np.random.default_rng(seed + 50).random()
        ends = np.append(0, np.cumsum(weights))
        kept = own["resample"](weights, np.random.default_rng(seed + 50))
        for i in range(n):
            teeth = [(q + j) / n for j in range(n) if ends[i] < (q + j) / n <= ends[i + 1]]
            assert np.sum(kept == i) == len(teeth)


@pytest.mark.asserts("eq-12-2")
def test_a_particles_weight_is_the_density_of_the_innovation(own, rng):
    particles = np.column_stack([rng.uniform(0, 3, (20, 2)), rng.uniform(-np.pi, np.pi, 20)])
    landmark, R = np.array([1.0, 0.5]), covariance(rng, 2, 0.2)
    z = np.array([-3.1, 1.2])
    wanted = [multivariate_normal(np.zeros(2), R).logpdf(innovation(z, pose, landmark)) for pose in particles]
    assert np.allclose(own["weigh"](particles, landmark, z, R), wanted)


@pytest.mark.asserts("eq-12-3", "eq-12-4")
def test_a_particles_landmark_is_corrected_as_a_kalman_filter_of_two_numbers_as_in_lesson_07(own, ekf, rng):
    for _ in range(20):
        pose, mean, P, z, R = seen_landmark(rng, 0.1)
        nu = innovation(z, pose, mean)
        # The numerical Jacobian of the innovation is minus the Jacobian of the expected measurement.
        steps = 1e-6 * np.eye(2)
        columns = [innovation(z, pose, mean - e) - innovation(z, pose, mean + e) for e in steps]
        H = np.transpose(columns) / 2e-6
        S = H @ P @ H.T + R
        K = P @ H.T @ np.linalg.inv(S)
        moved, left, log_weight = own["update_particle_landmark"](pose, mean, P, z, R)
        assert np.allclose(moved, mean + K @ nu, atol=1e-6)
        assert np.allclose(left, P - K @ H @ P, atol=1e-6)
        assert np.isclose(log_weight, multivariate_normal(np.zeros(2), S).logpdf(nu), atol=1e-6)
        whole = np.zeros((5, 5))  # the pose is certain
        whole[3:, 3:] = P
        state, after = ekf[1](np.append(pose, mean), whole, [0], z, R[None])
        assert np.allclose(state, np.append(pose, moved)) and np.allclose(after[3:, 3:], left)
        assert np.allclose(after[:3], 0)


@pytest.mark.asserts("eq-12-5")
def test_the_shortest_way_between_two_rays_is_at_right_angles_to_both(own, rng):
    met = 0
    for _ in range(60):
        a, b = rng.normal(0, 1, (2, 3))
        u, v = (each / np.linalg.norm(each) for each in rng.normal(0, 1, (2, 3)))
        middle, gap = own["intersect_rays"](a, u, b, v)
        if np.isnan(gap):
            continue
        met += 1
        n = np.cross(u, v) / np.linalg.norm(np.cross(u, v))
        for origin, direction, side in ((a, u, -1), (b, v, 1)):
            near = middle + side * np.sign((b - a) @ n) * gap / 2 * n  # the way's end on this ray
            assert np.allclose(np.cross(near - origin, direction), 0, atol=1e-6)
            assert (near - origin) @ direction >= -1e-9
    assert met >= 10


@pytest.mark.asserts("eq-12-6")
def test_both_cameras_scatter_as_a_pixels_angle_and_the_baseline_say(cameras):
    distance, size = 2.0, (640, 480)
    pitch = two_cameras.pitch_for(distance)
    top, bottom = (NAO_V4.view(camera, 0.0, pitch, size=size) for camera in ("top", "bottom"))
    angle = two_cameras.PIXEL_SIGMA / bottom.focal[1] * np.cos(two_cameras.OFF_AXIS) ** 2
    both = distance**2 / np.linalg.norm(top.position - bottom.position) * np.sqrt(2) * angle
    assert np.isclose(two_cameras.expected_sigmas(distance, size[0])[1], both)
    found = two_cameras.measure_again(*cameras, distance, size, count=200)
    assert found.sigmas[1] == pytest.approx(both, rel=0.15)


@pytest.mark.asserts("eq-12-7")
def test_the_move_is_chosen_whose_position_has_the_least_variances(own, ekf, rng):
    predict, update_landmarks, _ = ekf
    for _ in range(10):
        pose = np.append(rng.uniform((0.5, -1), (2, 1)), rng.uniform(-np.pi, np.pi))
        state = np.concatenate([pose, LANDMARKS[:4].ravel()])
        P = covariance(rng, len(state), 0.05)
        offered, sums = options(state), []
        for each in offered:
            after = predict(state, P, each.control, each.control_covariance, 4)
            if each.indices:
                after = update_landmarks(*after, each.indices, each.measurements, each.measurement_covariance)
            sums.append(np.trace(after[1][:2, :2]))
        assert own["choose_move"](state, P, offered) == int(np.argmin(sums))


SIZE = (640, 480)


def test_a_pixels_ray_leads_back_to_its_point_and_scatter_is_the_standard_deviation_without_outliers(rng):
    for camera in ("top", "bottom"):
        view = NAO_V4.view(camera, 0.2, two_cameras.pitch_for(2.0), size=SIZE, torso_pitch=0.02)
        for place in rng.uniform((1.6, 0.1), (2.4, 0.6), (10, 2)):
            origin, direction = two_cameras.ray(view, view.project(place[None])[0])
            assert np.linalg.norm(direction) == pytest.approx(1)
            assert np.allclose((origin - origin[2] / direction[2] * direction)[:2], place, atol=2e-3)
    errors = rng.normal(0, 0.1, 4000)
    errors[:20] = np.inf
    distances = two_cameras.Distances(2 + errors, np.full(4000, np.nan), 2.0)
    assert distances.sigmas[0] == pytest.approx(0.1, rel=0.05)
    assert np.isnan(distances.sigmas[1]) and distances.seen == 0


def test_without_tilt_both_methods_return_the_distance_and_tilt_changes_one_cameras(cameras, monkeypatch):
    monkeypatch.setattr("nao_course.lessons.beyond.two_cameras.PIXEL_SIGMA", 0.0)
    for distance in two_cameras.DISTANCES:
        distances = two_cameras.measure_again(*cameras, distance, SIZE, tilt=(0.0, 0.0), count=2)
        assert distances.seen == 1 and np.allclose(distances.one, distance, rtol=1e-3)
        assert np.allclose(distances.both, distance, rtol=5e-3)
    one, both = two_cameras.measure_again(*cameras, 2.0, SIZE, count=60).sigmas
    assert one == pytest.approx(two_cameras.expected_sigmas(2.0, 640)[0], rel=0.35) and both < one / 20


@pytest.mark.parametrize(("pitched", "bottom_sees"), [(0.2, False), (-0.2, True)])
def test_a_point_that_one_camera_alone_sees_is_not_measured_by_both(cameras, pitched, bottom_sees):
    pitch = two_cameras.pitch_for(2.0) + pitched
    distances = two_cameras.measure_again(*cameras, 2.0, SIZE, pitch=pitch, count=5)
    assert distances.seen == 0 and np.isnan(distances.sigmas[1])
    assert np.isnan(distances.one).all() != bottom_sees


def test_the_head_is_pitched_within_its_limits_and_the_formulas_grow_with_the_square_of_the_distance():
    low, high = NAO_V4.pitch_limits
    pitches = [two_cameras.pitch_for(distance) for distance in (0.05, *two_cameras.DISTANCES, 100.0)]
    assert all(low <= pitch <= high for pitch in pitches) and pitches == sorted(pitches, reverse=True)
    near, far = two_cameras.expected_sigmas(2.0, 640), two_cameras.expected_sigmas(4.0, 640)
    assert np.allclose(np.divide(far, near), 4, rtol=0.03)
    height = NAO_V4.view("bottom", 0.0, two_cameras.pitch_for(2.0)).height
    assert near[0] == pytest.approx(4 / height * two_cameras.TILT[0])
