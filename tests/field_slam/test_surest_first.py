"""The order in which the pictures of a stop are used."""

import numpy as np
import pytest

from nao_course.field_slam.observation import Observation
from nao_course.field_slam.surest_first import SurestFirst
from nao_course.slam import Motion

TURN = Motion(0.2, 0.5)


class Noted:
    """A filter whose estimate is the pictures and commands that came, in their order."""

    def __init__(self):
        self.came = []

    def move(self, motion):
        self.came.append("move")

    def observe(self, measurements):
        self.came.append((measurements.direction, measurements.direction_sigma))

    def estimate(self):
        return list(self.came)


def frames(*sigmas):
    return [Observation((), np.zeros((0, 0)), 0.1 * number, sigma) for number, sigma in enumerate(sigmas)]


@pytest.mark.parametrize("asked", [0, 1, 3])
def test_a_stops_surest_compass_comes_first_however_often_an_estimate_is_asked_for(asked):
    slam = SurestFirst(Noted())
    for number, each in enumerate(frames(np.inf, 0.02, 0.01)):
        slam.observe(each)
        if number < asked:
            assert len(slam.estimate()) == len(slam.estimate()) == number + 1
    slam.move(TURN)
    assert slam.inner.came == [(0.2, 0.01), (0.1, 0.02), (0.0, np.inf), "move"]


def test_no_picture_waits_for_the_next_stop_and_those_without_a_compass_keep_their_order():
    slam = SurestFirst(Noted())
    for sigma in (0.02, 0.01):
        slam.observe(*frames(sigma))
        slam.estimate()
        slam.move(TURN)
    assert slam.inner.came == [(0.0, 0.02), "move", (0.0, 0.01), "move"]
    slam = SurestFirst(Noted())
    for each in frames(np.inf, np.inf, np.inf):
        slam.observe(each)
    slam.move(TURN)
    assert [direction for direction, _ in slam.inner.came[:3]] == [0.0, 0.1, 0.2]
