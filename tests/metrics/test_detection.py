"""Scores of a detector: found, missed and false points are counted one to one."""

import numpy as np
import pytest

from nao_course.datasets import AnnotatedPoint
from nao_course.geometry import Pose
from nao_course.metrics import CornerTruth, PointMatch, corner_cost, match_points, total
from nao_course.sim import NAO_V4, Field, Reality, render


def test_the_truth_itself_is_found_and_nothing_finds_nothing_and_the_order_of_points_does_not_matter(rng):
    true = rng.uniform(0, 300, (4, 2))
    assert (match := match_points(true, true)).found.all() and match.false == 0 and match.f1 == 1.0
    none = match_points(np.zeros((0, 2)), true)
    assert not none.found.any() and none.false == 0 and none.f1 == 0.0 and none.missed == 4
    with pytest.raises(ValueError, match=r"points \(u, v\)"):
        match_points(np.zeros((3, 3)), [(1, 1)])
    true, excused, points = (rng.uniform(0, 60, (n, 2)) for n in (6, 2, 9))
    before = points.copy()
    matches = [match_points(rng.permutation(points), true, excused) for _ in range(5)]
    match_points(points, true, excused)
    assert len({(tuple(match.found), match.false) for match in matches}) == 1 and (points == before).all()


def test_one_point_finds_one_and_the_nearest_pair_goes_first_within_eight_pixels():
    assert match_points([(12, 10)], [(10, 10), (14, 10)]).hits == 1
    doubled = match_points([(10, 10), (11, 10)], [(10, 10)])
    assert doubled.found.tolist() == [True] and doubled.false == 1
    for points in ([(14, 10), (10, 10)], [(16, 10), (10, 10)]):
        match = match_points(points, [(10, 10), (21, 10)])
        assert match.found.all() and match.false == 0
    assert match_points([(10, 18)], [(10, 10)]).found.all()
    beyond = match_points([(10, 18.01)], [(10, 10)])
    assert not beyond.found.any() and beyond.false == 1
    match = match_points([(-2, 50), (100, 100)], [(100, 100)], excused=[(-3, 50), (np.nan, np.nan)])
    assert match.found.tolist() == [True] and match.false == 0 and match.precision == 1.0


def test_sums_are_those_of_the_parts_and_a_cost_is_the_papers_weights_times_the_counts():
    parts = [match_points([(10, 10), (90, 90)], [(10, 10), (40, 40)]), match_points([(1, 1)], [])]
    whole = total(parts)
    assert (whole.recall, whole.precision, whole.false) == (0.5, pytest.approx(1 / 3), 2)
    assert whole.f1 == pytest.approx(2 / (2 + 3))
    nothing = PointMatch(np.zeros(0, dtype=bool), 0)
    assert np.isnan(nothing.recall) and np.isnan(nothing.precision) and nothing.f1 == 0.0
    assert corner_cost(match_points([], [(1, 1), (50, 50)])) == 2.0
    match = match_points([(1, 1), (20, 20), (30, 30)], [(1, 1), (80, 80)])
    assert corner_cost(match) == pytest.approx(-1.333 + 2 * 5 + 1)


def test_corners_count_and_crossings_and_posts_are_excused():
    marks = [AnnotatedPoint(kind, 10.0 * i, 5.0) for i, kind in enumerate(("L", "T", "X", "post_foot"))]
    truth = CornerTruth.marked(marks)
    assert truth.corners.tolist() == [[0.0, 5.0], [10.0, 5.0]]
    match = truth.match([(1, 5), (20, 6), (30, 7), (60, 60)])
    assert (match.hits, match.false, match.missed) == (1, 1, 1)
    assert CornerTruth.marked([]).match([(1, 1)]).false == 1


@pytest.mark.parametrize("size", [(320, 240), (640, 480)])
def test_a_simulated_picture_has_the_corners_that_it_shows(size):
    view = NAO_V4.view("bottom", 0.0, -0.43, size)
    _, truth = render(Field(2012), Pose(0.6, 0.5, -0.25), view, Reality.clean(), np.random.default_rng(0))
    corners = CornerTruth.of(truth)
    assert len(corners.corners) == sum(mark.landmark.kind == "corner" for mark in truth.landmarks) > 0
    assert len(corners.excused) == sum(mark.landmark.kind != "corner" for mark in truth.landmarks) > 0
    assert corners.reach == 8.0 * size[1] / 240
    beside = corners.corners + np.array([corners.reach - 0.01, 0.0])
    assert corners.match(beside[:1]).hits == 1 and corners.match(beside[:1] + (0.02, 0.0)).hits == 0
