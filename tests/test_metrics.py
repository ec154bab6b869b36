"""Points that are found, missed and false: pairs of points, one to one, and intervals."""

import numpy as np
import pytest

from nao_course.metrics import PointMatch, match_points, total, wilson_interval


def test_the_truth_itself_is_found_and_nothing_finds_nothing(rng):
    true = rng.uniform(0, 300, (4, 2))
    assert (match := match_points(true, true)).found.all() and match.false == 0 and match.f1 == 1.0
    none = match_points(np.zeros((0, 2)), true)
    assert not none.found.any() and none.false == 0 and none.f1 == 0.0 and none.missed == 4


def test_one_point_finds_one_and_two_points_find_one_once():
    assert match_points([(12, 10)], [(10, 10), (14, 10)]).hits == 1
    doubled = match_points([(10, 10), (11, 10)], [(10, 10)])
    assert doubled.found.tolist() == [True] and doubled.false == 1


def test_the_nearest_pair_goes_first():
    match = match_points([(14, 10), (10, 10)], [(10, 10), (21, 10)])
    assert match.found.all() and match.false == 0


def test_eight_pixels_are_found_and_more_are_not():
    assert match_points([(10, 18)], [(10, 10)]).found.all()
    beyond = match_points([(10, 18.01)], [(10, 10)])
    assert not beyond.found.any() and beyond.false == 1


def test_excused_points_are_neither_right_nor_wrong():
    match = match_points([(-2, 50), (100, 100)], [(100, 100)], excused=[(-3, 50), (np.nan, np.nan)])
    assert match.found.tolist() == [True] and match.false == 0 and match.precision == 1.0


def test_the_order_of_points_does_not_matter_and_inputs_stay(rng):
    true, excused, points = (rng.uniform(0, 60, (n, 2)) for n in (6, 2, 9))
    before = points.copy()
    matches = [match_points(rng.permutation(points), true, excused) for _ in range(5)]
    match_points(points, true, excused)
    assert len({(tuple(match.found), match.false) for match in matches}) == 1 and (points == before).all()


def test_sums_are_those_of_the_parts():
    parts = [match_points([(10, 10), (90, 90)], [(10, 10), (40, 40)]), match_points([(1, 1)], [])]
    whole = total(parts)
    assert (whole.recall, whole.precision, whole.false) == (0.5, pytest.approx(1 / 3), 2)
    assert whole.f1 == pytest.approx(2 / (2 + 3))


def test_no_points_at_all_have_no_recall_and_no_precision():
    nothing = PointMatch(np.zeros(0, dtype=bool), 0)
    assert np.isnan(nothing.recall) and np.isnan(nothing.precision) and nothing.f1 == 0.0


def test_points_of_another_shape_are_refused():
    with pytest.raises(ValueError, match=r"points \(u, v\)"):
        match_points(np.zeros((3, 3)), [(1, 1)])


def test_wilsons_interval_is_his():
    assert wilson_interval(7, 10) == pytest.approx((0.3968, 0.8922), abs=1e-4)
    low, high = wilson_interval(12, 12)
    assert 0.75 < low < 0.76 and high == pytest.approx(1.0)
    assert wilson_interval(0, 0) == (0.0, 1.0)
