"""Numbers of landmarks are whole: floats that look like them break a later cell far from their cause."""

import numpy as np
import pytest

from nao_course.lessons.slam_on_the_field.laws import whole_numbers


@pytest.mark.parametrize(
    "answer", [np.array([0, -1]), np.array([2], dtype=np.int32), np.zeros(0), np.zeros((0, 1))]
)
def test_whole_numbers_and_none_at_all_are_right(answer):
    assert whole_numbers((), {}, answer) == ""


def test_floats_are_named():
    assert "floats" in whole_numbers((), {}, np.array([0.0, -1.0]))
