"""Feet that are found, missed and false: pairs of points and feet, one to one."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.goalposts.measuring import Feet, match_feet, total, wilson_interval
from nao_course.lessons.goalposts.scenes import FIELD, picture_from
from nao_course.sim import Reality


def feet(*pixels, excused=()):
    return Feet(
        np.array(pixels, dtype=float).reshape(-1, 2),
        np.arange(1.0, len(pixels) + 1),
        np.array(excused, dtype=float).reshape(-1, 2),
    )


def test_the_truth_itself_is_found_and_nothing_finds_nothing(rng):
    true = feet(*rng.uniform(0, 300, (4, 2)))
    assert (match := match_feet(true.pixels, true)).found.all() and match.false == 0 and match.f1 == 1.0
    none = match_feet(np.zeros((0, 2)), true)
    assert not none.found.any() and none.false == 0 and none.f1 == 0.0


def test_one_point_finds_one_foot_and_two_points_find_a_foot_once():
    near = feet((10, 10), (14, 10))
    assert match_feet([(12, 10)], near).found.sum() == 1
    doubled = match_feet([(10, 10), (11, 10)], feet((10, 10)))
    assert doubled.found.tolist() == [True] and doubled.false == 1


def test_the_nearest_pair_goes_first():
    match = match_feet([(14, 10), (10, 10)], feet((10, 10), (21, 10)))
    assert match.found.all() and match.false == 0


def test_eight_pixels_are_found_and_more_are_not():
    assert match_feet([(10, 18)], feet((10, 10))).found.all()
    beyond = match_feet([(10, 18.01)], feet((10, 10)))
    assert not beyond.found.any() and beyond.false == 1


def test_points_at_hidden_feet_and_at_feet_outside_are_neither_right_nor_wrong():
    match = match_feet([(-2, 50), (100, 100)], feet((100, 100), excused=[(-3, 50), (np.nan, np.nan)]))
    assert match.found.tolist() == [True] and match.false == 0 and match.precision == 1.0


def test_the_order_of_points_does_not_matter(rng):
    true = feet(*rng.uniform(0, 60, (6, 2)), excused=rng.uniform(0, 60, (2, 2)))
    points = rng.uniform(0, 60, (9, 2))
    matches = [match_feet(rng.permutation(points), true) for _ in range(5)]
    assert len({(tuple(match.found), match.false) for match in matches}) == 1


def test_sums_are_those_of_the_parts():
    parts = [match_feet([(10, 10), (90, 90)], feet((10, 10), (40, 40))), match_feet([(1, 1)], feet())]
    whole = total(parts)
    assert (whole.recall, whole.precision, whole.false) == (0.5, pytest.approx(1 / 3), 2)
    assert whole.f1 == pytest.approx(2 / (2 + 3)) and str(whole) == "1 of 2 feet found, 2 false"
    assert np.isnan(total([]).recall) and total([]).f1 == 0.0


def test_points_of_another_shape_are_refused():
    with pytest.raises(ValueError, match=r"points \(u, v\)"):
        match_feet(np.zeros((3, 3)), feet((1, 1)))


def test_wilsons_interval_is_his():
    assert wilson_interval(7, 10) == pytest.approx((0.3968, 0.8922), abs=1e-4)
    low, high = wilson_interval(12, 12)
    assert 0.75 < low < 0.76 and high == pytest.approx(1.0)
    assert wilson_interval(0, 0) == (0.0, 1.0)


def test_a_pictures_feet_are_its_true_posts_and_the_others_of_the_field_are_excused():
    scene = picture_from(Pose(0.4, 0.2, 0.0), Reality.clean(), np.random.default_rng(0))
    u, v = scene.feet.pixels.T.round().astype(int)
    assert len(u) == 2 and (scene.labels[v - 2, u] == 2).all() and (scene.labels[v + 6, u] != 2).all()
    assert len(scene.feet.excused) == len(FIELD.posts) - 2
    assert scene.feet.distances == pytest.approx(np.hypot(2.6, [-0.9, 0.5]))
