"""The equations that lesson 04 displays, held against its solution, the library's camera, and sampling."""

import re
from dataclasses import replace
from statistics import NormalDist

import numpy as np
import pytest

from nao_course.lessons.distance.looks import ahead, points_covariance, tilted_measurements, usual_view
from nao_course.lessons.distance.noise_figures import three_landmarks
from nao_course.sim import CameraView
from tests.lessons.distance.own import GEOMETRY, OWN, polar
from tests.lessons.every import text


def tilts_of(sigma, number):
    """Return quantiles of a normal distribution, which are samples without sampling noise."""
    inverse = NormalDist().inv_cdf
    return sigma * np.array([inverse((i + 0.5) / number) for i in range(number)])


@pytest.mark.asserts("eq-4-1")
def test_the_papers_formula_is_its_four_lines_and_off_by_what_the_text_says(rng):
    view = CameraView((320, 240), 1.04, 0.82, 0.48, 0.6, yaw=0.4, roll=0.1, offset=(0.05, 0.02), k1=-0.08)
    pixels = rng.uniform(0, (319, 239), (20, 2))
    u, v = pixels.T
    angle_c = (np.pi / 2 - view.pitch) - view.vfov / 2
    angle_x = ((u + 0.5) - 320 / 2) * view.hfov / 320
    angle_y = angle_c + (240 - 0.5 - v) * view.vfov / 240
    distances = OWN["paper_distance"](pixels, view)
    assert distances == pytest.approx(view.height * np.tan(angle_y) / np.cos(angle_x))
    assert OWN["paper_bearing"](pixels, view) == pytest.approx(-angle_x)
    view = CameraView((320, 240), 1.0, np.radians(40), height=0.5, pitch=np.radians(45))
    distances = OWN["paper_distance"](np.array([[159.5, 119.5], [159.5, -0.5]]), view)
    assert distances.round(2).tolist() == [0.5, 1.07]
    view = replace(usual_view(lens=False), offset=(0.0, 0.0))
    u, v = np.meshgrid(np.arange(0, 320, 8.0), np.arange(0, 240, 4.0))
    pixels = np.column_stack([u.ravel(), v.ravel()])
    bearing, away = polar(pixels, view).T
    off = np.abs(OWN["paper_distance"](pixels, view) - away)
    assert off[away < 2].max() < 0.035 and off[away < 4].max() == pytest.approx(0.23, abs=0.01)
    turned = np.degrees(np.abs(OWN["paper_bearing"](pixels, view) - bearing))
    assert np.nanmax(turned) == pytest.approx(4.4, abs=0.2)


@pytest.mark.asserts("eq-4-2", "eq-4-3")
def test_a_point_comes_back_from_the_pixel_that_it_is_projected_to_and_the_sky_has_no_ground(rng):
    low, high = (0.3, 0.2, -1, -0.2, -0.1, -0.1, -0.1), (0.6, 0.8, 1, 0.2, 0.1, 0.1, 0.0)
    for height, pitch, yaw, roll, x, y, k1 in rng.uniform(low, high, (30, 7)):
        view = CameraView((320, 240), 1.0, 0.8, height, pitch, yaw, roll, (x, y), k1)
        bearing = view.yaw + rng.uniform(-0.3, 0.3, 10)
        points = rng.uniform(1.0, 3.0, (10, 1)) * np.column_stack([np.cos(bearing), np.sin(bearing)])
        assert OWN["pixel_to_ground"](view.project(points), view) == pytest.approx(points)
    view = CameraView((321, 241), 1.0, 0.8, height=0.5, pitch=0.0)
    ground = OWN["pixel_to_ground"](np.array([[10.0, 20.0], [100.0, 120.0], [100.0, 121.0]]), view)
    assert np.isnan(ground).all(axis=1).tolist() == [True, True, False]
    assert OWN["pixel_to_ground"](np.zeros((0, 2)), view).shape == (0, 2)


@pytest.mark.asserts("eq-4-4", "eq-4-5")
def test_the_sigma_of_a_range_is_the_derivative_of_height_over_tangent():
    for away, height in ((0.0, 0.5), (0.7, 0.48), (2.0, 0.48), (5.0, 0.55)):
        down = np.arctan2(height, away)
        derivative = height * (1 / np.tan(down - 1e-6) - 1 / np.tan(down + 1e-6)) / 2e-6
        assert OWN["range_sigma"](away, height, 0.01) == pytest.approx(0.01 * derivative, abs=1e-9)
    for away, metres in ((2.0, 0.15), (3.0, 0.34), (5.0, 0.92)):
        assert OWN["range_sigma"](away, 0.48, np.radians(1.0)) == pytest.approx(metres, abs=0.006)
    # The question compares larger pictures with a mean of three, at 3 m, 7 cm per pixel and 0.7 degrees of tilt.
    tilt = OWN["range_sigma"](3.0, 0.48, np.radians(0.7))
    errors = 100 * np.array(
        [tilt, np.hypot(tilt, 0.07), np.hypot(tilt, 0.0175), np.hypot(tilt, 0.07) / 3**0.5]
    )
    assert errors == pytest.approx([23, 25, 24, 14], abs=0.6)


def test_sampled_ranges_have_that_sigma_near_by_and_a_long_tail_far_away_as_the_text_says():
    view = replace(usual_view(), offset=(0.0, 0.0))
    away = np.array([1.0, 2.0, 4.0])
    tilts = tilts_of(np.radians(1), 801)
    ranges = tilted_measurements(**GEOMETRY, view=view, points=ahead(away, view), tilts=tilts)[..., 1]
    sigma = [OWN["range_sigma"](each, view.height, np.radians(1)) for each in away]
    assert ranges.std(axis=0) == pytest.approx(sigma, rel=0.12)
    assert ranges.std(axis=0)[:2] == pytest.approx(sigma[:2], rel=0.03)
    short, long = np.abs(np.quantile(ranges[:, 2], [0.025, 0.975]) - 4.0)
    assert long > 1.5 * short
    assert ranges.mean(axis=0)[2] == pytest.approx(4.10, abs=0.02)
    # What the text reads from one figure of 2000 pictures is typical of a thousand such figures.
    tilts = np.radians(1.0) * np.random.default_rng(0).standard_normal((1000, 2000))
    errors = view.height / np.tan(np.arctan2(view.height, 4.0) - tilts) - 4.0
    stated = float(re.search(r"a standard deviation of ([\d.]+) m instead of", text("04"))[1])
    low, high = np.quantile(errors.std(axis=1), [0.025, 0.975])
    assert low < stated < high and high - low < 0.2
    said = re.search(r"between ([\d.]+) m too short and ([\d.]+) m too long", text("04"))
    for each, ends in zip(said.groups(), np.abs(np.quantile(errors, [0.025, 0.975], axis=1)), strict=True):
        least, most = np.quantile(ends, [0.025, 0.975])
        assert least - 0.05 < float(each) < most + 0.05, (each, least, most)


@pytest.mark.asserts("eq-4-6")
def test_variances_of_independent_tilts_add_up_in_the_range_too():
    camera, torso = np.random.default_rng(0).normal(0, (1.0, 1.5), (100_000, 2)).T
    assert np.var(camera + torso) == pytest.approx(1.0**2 + 1.5**2, rel=0.02)
    assert np.mean(camera * torso < 0) == pytest.approx(0.5, abs=0.01)
    view = replace(usual_view(), offset=(0.0, 0.0))
    one, other = np.radians([[0.3], [0.4]]) * np.random.default_rng(1).standard_normal((2, 1500))
    sampled = [
        tilted_measurements(**GEOMETRY, view=view, points=ahead([3.0], view), tilts=tilts)[:, 0, 1].std()
        for tilts in (one, other, one + other)
    ]
    assert sampled[2] == pytest.approx(np.hypot(*sampled[:2]), rel=0.06)


@pytest.mark.asserts("eq-4-7")
def test_each_entry_of_a_pictures_covariance_is_within_ten_percent_of_sampling():
    view, places, sigma = usual_view(), three_landmarks(), np.radians(1.0)
    assert np.linalg.norm(places, axis=1) == pytest.approx([1, 2, 3])
    computed = OWN["measurement_covariance"](view.project(places), view, 0.7, sigma)
    tilts, copies = tilts_of(sigma, 301), 60
    errors = np.random.default_rng(3).standard_normal((copies, 6))
    both = np.concatenate([errors, -errors])
    # As if there were many more
    white = 0.7 * both @ np.linalg.inv(np.linalg.cholesky(both.T @ both / len(both))).T
    many = []
    for tilt in tilts:
        pixels = replace(view, pitch=view.pitch + tilt).project(places) + white.reshape(-1, 3, 2)
        many.append(polar(pixels.reshape(-1, 2), view).reshape(-1, 6))
    sampled = np.cov(np.concatenate(many).T)
    assert np.abs(computed / sampled - 1).max() < 0.10
    worst = np.unravel_index(np.argmax(np.abs(computed / sampled - 1)), (6, 6))
    assert worst == (5, 5), "the text says that the range at 3 m is the worst"
    assert computed[5, 5] / sampled[5, 5] == pytest.approx(0.91, abs=0.01)


def test_points_have_the_covariance_of_their_measurements_turned_and_an_offset_of_the_pitch_is_found(rng):
    polar = np.array([[0.0, 2.0], [np.pi / 2, 3.0]])
    full = np.diag([0.01, 0.04, 0.02, 0.09])
    expected = np.array([np.diag([0.04, 0.04]), np.diag([0.18, 0.09])])
    assert points_covariance(polar, full) == pytest.approx(expected)
    with pytest.raises(ValueError, match="2 measurements"):
        points_covariance(polar, np.eye(3))
    view = replace(usual_view(), yaw=0.4, roll=0.05)
    bearing, away = view.yaw + rng.uniform(-0.4, 0.4, 12), rng.uniform(1.0, 4.0, 12)
    points = np.column_stack([away * np.cos(bearing), away * np.sin(bearing)])
    wrong = replace(view, pitch=view.pitch - np.radians(6.4))
    found = OWN["estimate_pitch"](view.project(points), points, wrong)
    assert found == pytest.approx(np.radians(6.4), abs=1e-4)
