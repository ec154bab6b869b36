"""Two cameras of a robot whose body tilts."""

import numpy as np
import pytest

from nao_course.lessons.beyond import two_cameras
from nao_course.sim import NAO_V4

SIZE = (640, 480)


def test_a_pixels_ray_leads_back_to_the_point_that_it_shows(rng):
    for camera in ("top", "bottom"):
        view = NAO_V4.view(camera, 0.2, two_cameras.pitch_for(2.0), size=SIZE, torso_pitch=0.02)
        for place in rng.uniform((1.6, 0.1), (2.4, 0.6), (10, 2)):
            origin, direction = two_cameras.ray(view, view.project(place[None])[0])
            assert np.linalg.norm(direction) == pytest.approx(1)
            assert np.allclose((origin - origin[2] / direction[2] * direction)[:2], place, atol=2e-3)


def test_without_tilt_both_methods_return_the_true_distance_and_tilt_changes_that_of_one_camera(
    cameras, monkeypatch
):
    monkeypatch.setattr("nao_course.lessons.beyond.two_cameras.PIXEL_SIGMA", 0.0)
    for distance in two_cameras.DISTANCES:
        distances = two_cameras.measure_again(*cameras, distance, SIZE, tilt=(0.0, 0.0), count=2)
        assert distances.seen == 1 and np.allclose(distances.one, distance, rtol=1e-3)
        assert np.allclose(distances.both, distance, rtol=5e-3)
    one, both = two_cameras.measure_again(*cameras, 2.0, SIZE, count=60).sigmas
    assert one == pytest.approx(two_cameras.expected_sigmas(2.0, 640)[0], rel=0.35) and both < one / 20


@pytest.mark.parametrize(("pitched", "bottom_sees"), [(0.2, False), (-0.2, True)])
def test_a_point_that_one_camera_alone_sees_is_not_measured_by_both(cameras, pitched, bottom_sees):
    distances = two_cameras.measure_again(
        *cameras, 2.0, SIZE, pitch=two_cameras.pitch_for(2.0) + pitched, count=5
    )
    assert distances.seen == 0 and np.isnan(distances.sigmas[1])
    assert np.isnan(distances.one).all() != bottom_sees


def test_the_head_is_pitched_within_its_limits():
    low, high = NAO_V4.pitch_limits
    pitches = [two_cameras.pitch_for(distance) for distance in (0.05, *two_cameras.DISTANCES, 100.0)]
    assert all(low <= pitch <= high for pitch in pitches) and pitches == sorted(pitches, reverse=True)


def test_scatter_is_the_standard_deviation_of_a_gaussian_and_no_outlier_moves_it(rng):
    errors = rng.normal(0, 0.1, 4000)
    errors[:20] = np.inf
    distances = two_cameras.Distances(2 + errors, np.full(4000, np.nan), 2.0)
    assert distances.sigmas[0] == pytest.approx(0.1, rel=0.05)
    assert np.isnan(distances.sigmas[1]) and distances.seen == 0


def test_the_formulas_grow_with_the_square_of_the_distance():
    near, far = two_cameras.expected_sigmas(2.0, 640), two_cameras.expected_sigmas(4.0, 640)
    assert np.allclose(np.divide(far, near), 4, rtol=0.03)
    assert near[0] == pytest.approx(
        4 / NAO_V4.view("bottom", 0.0, two_cameras.pitch_for(2.0)).height * two_cameras.TILT[0]
    )
