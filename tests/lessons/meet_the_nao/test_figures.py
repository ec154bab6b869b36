"""The figures of lesson 00: the same at every run, and what they say is so."""

import numpy as np
import pytest

from nao_course.lessons.meet_the_nao import draw_cameras, draw_drift, draw_frames
from nao_course.sim import Field, repeat_drive
from nao_course.slam import Motion
from tests.drawings import assert_same_bytes_with_words
from tests.plotting.examples import walked


def drift():
    paths = repeat_drive([Motion(0.5, 0.3)] * 2, 5, np.random.default_rng(1))
    return draw_drift(paths, Field(), commanded=paths[0])


@pytest.mark.parametrize("make", [drift, draw_frames, lambda: draw_cameras(walked()[0])])
def test_the_same_drawing_is_the_same_bytes_with_its_words(make):
    assert_same_bytes_with_words(make)


def test_the_axes_of_a_drift_name_their_units():
    assert [ax.get_xlabel() for ax in drift().figure.axes] == ["x (m)"]


def test_one_robot_and_no_command_are_enough_for_a_drift():
    assert "1 robot" in draw_drift(np.zeros((1, 1, 3))).alt


@pytest.mark.parametrize(
    ("call", "said"),
    [
        (lambda: draw_drift(np.zeros((4, 3))), "robots, steps"),
        (lambda: draw_drift(np.zeros((0, 4, 3))), "at least one robot"),
    ],
)
def test_a_wrong_value_is_refused_in_words(call, said):
    with pytest.raises(ValueError, match=said):
        call()
