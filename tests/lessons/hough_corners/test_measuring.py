"""Where corners are lost: each step loses those that it should, and only those."""

import numpy as np
import pytest

from nao_course.lessons.hough_corners.measuring import (
    STEPS,
    all_crossings,
    count_corners,
    near_segments,
    near_white,
    with_others,
)
from nao_course.lessons.hough_corners.scenes import CornerPicture
from nao_course.metrics import CornerTruth

LABELS = np.ones((48, 64), dtype=np.uint8)
LABELS[20, 10:50] = LABELS[20:40, 30] = 3
PICTURE = CornerPicture(
    np.zeros((48, 64, 3), dtype=np.uint8),
    CornerTruth(np.array([[30.0, 20.0], [5.0, 45.0]]), np.zeros((0, 2))),
)
CROSS = np.array([[10.0, 20.0, 50.0, 20.0], [30.0, 20.0, 30.0, 40.0]])


def counts(labels=LABELS, erase=lambda labels: labels, segments=CROSS):
    return list(count_corners([PICTURE], lambda pixels: labels, erase, lambda kept: segments).values())


def test_a_corner_with_white_and_two_segments_stays_to_the_end_and_one_without_white_goes_first():
    assert counts() == [2, 1, 1, 1, 1]
    assert counts(labels=np.zeros_like(LABELS), segments=np.zeros((0, 4))) == [2, 0, 0, 0, 0]


def test_each_step_loses_its_own():
    assert counts(erase=np.zeros_like, segments=np.zeros((0, 4))) == [2, 1, 0, 0, 0]
    assert counts(segments=np.zeros((0, 4))) == [2, 1, 1, 0, 0]
    assert counts(segments=CROSS[:1]) == [2, 1, 1, 1, 0]
    parallel = np.array([[10.0, 20.0, 50.0, 20.0], [10.0, 23.0, 50.0, 23.0]])
    assert counts(segments=parallel) == [2, 1, 1, 1, 0]


def test_each_segment_is_crossed_with_each_later_one():
    segments = [[1.0, 0, 0, 0], [2.0, 0, 0, 0], [3.0, 0, 0, 0]]
    pairs = all_crossings(segments, lambda first, second: np.array([first[0], second[0]]))
    assert pairs.tolist() == [[1, 2], [1, 3], [2, 3]]
    assert all_crossings(segments, lambda first, second: None).shape == (0, 2)
    assert all_crossings([], None).shape == (0, 2)


def test_the_steps_get_what_the_one_before_returned():
    got = []
    count_corners(
        [PICTURE], lambda pixels: LABELS, lambda labels: labels * 0, lambda kept: got.append(kept) or []
    )
    assert (got[0] == 0).all() and got[0].shape == LABELS.shape
    assert list(count_corners([], None, None, None)) == list(STEPS)


@pytest.mark.parametrize(("distance", "near"), [(3.0, True), (3.1, False)])
def test_white_is_near_within_three_pixels(distance, near):
    assert near_white(LABELS, np.array([10.0 - distance, 20.0])) == near


def test_ten_degrees_are_parallel_and_more_is_not():
    for degrees, crossing in ((9.0, False), (11.0, True)):
        up = 20 * np.tan(np.radians(degrees))
        segments = np.array([[10.0, 20.0, 50.0, 20.0], [10.0, 20 - up, 50.0, 20 + up]])
        assert near_segments(segments, np.array([30.0, 20.0])) == (True, crossing)
    assert near_segments(CROSS, np.array([30.0, 13.9])) == (False, False)


def double(x):
    return 2 * x


def use(x, factor=1, *, added=0):
    return factor * double(x) + added


def test_a_function_finds_others_behind_its_names_and_stays_what_it_was():
    other = with_others(use, double=lambda x: 10 * x)
    assert (other(2), other(2, 3), other(2, added=1)) == (20, 60, 21)
    assert use(2) == 4 and other.__name__ == "use"
