"""The public cases are what their names say."""

import numpy as np

from nao_course.exercises.checking import read_public
from nao_course.lessons.distance.calibration import REAL
from tests.lessons.distance.own import own


def case(exercise, name):
    (public,) = [each for each in read_public("04_distance").exercises if each.name == exercise]
    (found,) = [each for each in public.cases if each.name == name]
    return found


def test_points_above_the_assumed_horizon_are_above_it():
    pixels, ground, view = case("estimate_pitch", "points above the assumed horizon").args
    seen = np.isfinite(own()["pixel_to_ground"](pixels, view)).all(axis=1)
    assert 0 < np.count_nonzero(~seen) < len(ground)


def test_a_head_turned_behind_the_shoulder_sees_points_behind_the_robot():
    answer = case("pixel_to_ground", "the head turned past the shoulder").expected
    assert (answer[:, 0] < 0).any() and np.isnan(answer).any()


def test_three_far_marks_decide_on_the_ground_and_not_in_the_picture():
    marks = case("estimate_pitch", "thirty marks with errors of a pixel, three of them far away")
    pixels, ground, _ = marks.args
    assert abs(marks.expected - 0.05) < 0.001
    assert np.count_nonzero(np.hypot(*ground.T) > 4) == 3 and len(pixels) == 30


def test_the_real_robots_exact_distances_have_the_shorter_tail_far_away():
    for place, methods in REAL.items():
        exact, paper = methods["exact"], methods["the paper's formula"]
        assert exact[-1][1] < paper[-1][1], place
