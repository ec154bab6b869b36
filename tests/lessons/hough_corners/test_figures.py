"""Figures of lesson 03's pictures: what they say is what they show."""

import numpy as np
import pytest

from nao_course.lessons.hough_corners.figures import draw_close_up, draw_segments

BLACK = np.zeros((24, 32, 3), dtype=np.uint8)
TWO = [(2, 3, 20, 3), (2, 3, 2, 20)]


def test_segments_and_corners_are_counted_and_corners_placed():
    assert draw_segments({"here": BLACK}, [TWO]).alt.endswith("here: 2 segments.")
    both = draw_segments({"a": BLACK, "b": BLACK}, [TWO, np.zeros((0, 4))], [[(2, 3)], np.zeros((0, 2))]).alt
    assert "a: 2 segments and 1 corner at (2, 3)" in both and "b: 0 segments and 0 corners." in both


def test_pictures_without_as_many_segments_are_refused():
    for given in (({}, []), ({"a": BLACK}, []), ({"a": BLACK}, [TWO], [[], []])):
        with pytest.raises(ValueError, match="pictures need"):
            draw_segments(*given)
    with pytest.raises(ValueError, match=r"segments \(u1, v1, u2, v2\)"):
        draw_segments({"a": BLACK}, [[(1, 2, 3)]])


def test_a_close_up_counts_what_is_in_its_part():
    lines = np.zeros((48, 64), dtype=np.uint8)
    lines[20:26, 10:60] = 255
    segments = [(10, 20, 59, 20), (10, 25, 59, 25), (0, 45, 8, 45)]
    drawn = draw_close_up(lines, segments, (30, 23), (20, 12))
    assert "120 white pixels, 40 edge pixels, 2 segments along the edges" in drawn.alt
