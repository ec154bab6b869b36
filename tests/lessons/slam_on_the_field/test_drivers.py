"""Association indices must be integers, because floats break a later cell far from their cause."""

import numpy as np
import pytest

from nao_course.lessons.slam_on_the_field.drivers import whole_numbers


@pytest.mark.parametrize(
    "answer", [np.array([0, -1]), np.array([2], dtype=np.int32), np.zeros(0), np.zeros((0, 1))]
)
def test_integers_and_empty_answers_are_right(answer):
    assert whole_numbers((), {}, answer) == ""


def test_floats_are_rejected():
    assert "floats" in whole_numbers((), {}, np.array([0.0, -1.0]))
