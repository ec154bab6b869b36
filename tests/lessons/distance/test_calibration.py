"""Calibration on marked pictures: the offset is found, and the distances after it are what the text says."""

import numpy as np
import pytest

from nao_course.lessons.distance.calibration import (
    EDGES,
    OFFSET,
    REAL,
    Marked,
    by_distance,
    draw_calibrated,
    marked_pictures,
    range_errors,
)
from tests.lessons.distance.own import OWN, polar
from tests.lessons.every import public_exercise


def exact(pixels, view):
    return polar(pixels, view)[:, 1]


def case(exercise, name):
    """Return a public case of an exercise."""
    return next(each for each in public_exercise("04_distance", exercise).cases if each.name == name)


def test_the_public_cases_are_what_their_names_say():
    pixels, ground, view = case("estimate_pitch", "points above the assumed horizon").args
    seen = np.isfinite(OWN["pixel_to_ground"](pixels, view)).all(axis=1)
    assert 0 < np.count_nonzero(~seen) < len(ground)
    answer = case("pixel_to_ground", "the head turned past the shoulder").expected
    assert (answer[:, 0] < 0).any() and np.isnan(answer).any()
    marks = case("estimate_pitch", "thirty marks with errors of a pixel, three of them far away")
    pixels, ground, _ = marks.args
    assert abs(marks.expected - 0.05) < 0.001
    assert np.count_nonzero(np.hypot(*ground.T) > 4) == 3 and len(pixels) == 30


def test_ten_pictures_tell_the_offset_to_a_few_tenths_of_a_degree():
    found = [
        OWN["estimate_pitch"](each.pixels, each.ground, each.view) for each in marked_pictures(10, rng=3)
    ]
    assert np.median(found) == pytest.approx(OFFSET, abs=np.radians(0.5))


def test_uncalibrated_distances_are_metres_off_and_calibrated_ones_decimetres():
    pictures = marked_pictures(25, rng=2)
    before, after = (by_distance(*range_errors(exact, pictures, offset)) for offset in (0.0, OFFSET))
    assert before[1][0] > 1.0
    assert after[0][0] < 0.08 and after[1][0] < 0.2


def test_errors_of_the_range_from_the_robot_are_binned_by_it_and_a_missing_one_is_infinite():
    view = marked_pictures(1)[0].view
    mark = Marked(np.array([[100.0, 200.0]]), np.array([[3.0, 4.0]]), view)
    true, errors = range_errors(lambda pixels, view: np.array([6.5]), [mark])
    assert true.tolist() == [5.0] and errors.tolist() == [1.5]
    found = by_distance(np.array([1.5, 1.6, 2.5, 3.5, 4.5]), np.array([-0.1, 0.3, np.nan, 0.2, 1.0]))
    assert found[0] == (0.3, 0.3) and found[1] == (np.inf, np.inf) and found[3] == (1.0, 1.0)
    assert len(found) == len(EDGES) - 1


def test_the_figure_has_the_real_robots_numbers_beside_the_simulated():
    errors = (np.array([1.5, 2.5, 3.5, 4.5]), np.array([0.1, 0.2, 0.3, 0.4]))
    words = draw_calibrated({"the paper's formula": errors, "exact": errors}).alt
    assert "simulated, exact: 0.10, 0.20, 0.30, 0.40 m" in words
    assert "real walk, exact: 0.04, 0.06, 0.10, 0.19 m" in words
    assert set(REAL) == {"real scenes", "real walk"}
    for methods in REAL.values():  # the exact distances have the shorter tail far away
        assert methods["exact"][-1][1] < methods["the paper's formula"][-1][1]
