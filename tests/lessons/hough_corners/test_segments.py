"""Segments are compared by what they cover, not by their order or number."""

import tracemalloc

import numpy as np
import pytest

from nao_course.lessons.hough_corners.segments import (
    BytePicture,
    Crossing,
    Segments,
    coverage,
    distances_to_segments,
    sample,
)

TWO = np.array([[10.0, 10.0, 60.0, 10.0], [30.0, 20.0, 30.0, 70.0]])


def test_order_direction_and_cuts_do_not_matter_but_a_segment_that_lacks_or_is_too_much_is_wrong():
    cut = np.array([[30, 70, 30, 45], [30, 46, 30, 20], [60, 10, 10, 10]])
    for same in (TWO, TWO[::-1], TWO[:, [2, 3, 0, 1]], cut, np.vstack([TWO, TWO])):
        assert Segments().compare(TWO, same)
    lacking = Segments().compare(TWO, TWO[:1])
    extra = Segments().compare(TWO[:1], TWO)
    assert (lacking.kind, extra.kind) == ("value", "value")
    assert lacking.text == "your 1 segment misses 50% of the expected length"
    assert extra.text == "50% of the length of your 2 segments lies where no segment is expected"
    none = np.zeros((0, 4))
    assert Segments().compare(none, none)
    assert not Segments().compare(none, TWO)
    assert not Segments().compare(TWO, none)


@pytest.mark.parametrize(
    "hostile", [[[0, 0, 1e12, 0]], [[-1e308, 0, 1e308, 0]], [[0.0, 0, 1, 0]] * 5000, [[0, 0, 1000, 0]] * 500]
)
def test_what_is_far_too_long_is_wrong_before_points_are_made_along_it(hostile):
    tracemalloc.start()
    verdict = Segments().compare(TWO, np.array(hostile))
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert verdict.kind == "value" and "longer" in verdict.text and peak < 2**22


def test_the_tolerance_and_the_share_are_where_right_ends_and_a_wrong_answer_is_recognised_by_what_it_covers():
    beside = TWO + np.array([0.0, 1.5, 0.0, 1.5])
    assert Segments(tolerance=2.0).compare(TWO[:1], beside[:1])
    assert not Segments(tolerance=1.0).compare(TWO[:1], beside[:1])
    shorter = np.array([[10.0, 10.0, 50.0, 10.0]])
    assert Segments(share=0.7).compare(TWO[:1], shorter)
    assert not Segments(share=0.9).compare(TWO[:1], shorter)
    assert Segments().alike(TWO, TWO[::-1])
    assert not Segments().alike(TWO, TWO[:1])
    assert not Segments().alike(None, TWO)


@pytest.mark.parametrize(
    "wrong", [np.zeros(0), TWO[:, None], TWO[:, :2]], ids=["(0,)", "(N, 1, 4)", "(N, 2)"]
)
def test_another_shape_and_numbers_that_are_none_are_said(wrong):
    verdict = Segments().compare(TWO, wrong)
    assert verdict.kind == "shape" and str(wrong.shape) in verdict.text
    assert Segments().compare(TWO, np.full((1, 4), np.nan)).kind == "nan"
    assert Segments().compare(TWO, None).kind != "right"


def test_coverage_is_the_part_of_the_length_that_is_near_and_distances_are_those_to_the_segment(rng):
    half = np.array([[10.0, 10.0, 35.0, 10.0]])
    assert coverage(TWO[:1], half, 0.5) == pytest.approx(0.5, abs=0.03)
    assert coverage(half, TWO[:1], 0.5) == 1.0
    segments = rng.uniform(0, 100, (6, 4))
    for each in segments:
        points = sample(each[None])
        assert np.allclose(points[[0, -1]].ravel(), each)
        assert np.allclose(distances_to_segments(points, each[None]), 0.0, atol=1e-9)
    assert distances_to_segments(np.array([[63.0, 14.0]]), TWO[:1])[0, 0] == pytest.approx(5.0)


def test_a_picture_for_opencv_is_of_bytes_and_none_is_an_answer_about_segments_and_no_missing_return():
    black = np.zeros((2, 3), np.uint8)
    assert BytePicture().compare(black, black) and not BytePicture().compare(black, black + 1)
    for kind in (np.int64, bool):
        verdict = BytePicture().compare(black, black.astype(kind))
        assert verdict.kind == "type" and f"dtype {np.dtype(kind)}" in verdict.text
    assert BytePicture().alike(black.astype(bool), black.astype(bool))
    assert not BytePicture().alike(black.astype(bool), black)
    meeting = np.array([3.0, 4.0])
    assert Crossing().compare(None, None) and Crossing().compare(meeting, meeting)
    verdict = Crossing().compare(meeting, None)
    assert verdict.kind == "value" and "these segments meet" in verdict.text
    assert not Crossing().compare(None, meeting)
