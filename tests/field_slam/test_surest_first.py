"""The order in which the pictures of a stop are used."""

import numpy as np
import pytest

from nao_course.field_slam.drives import OdometryNoisePerMove
from nao_course.field_slam.observation import Observation
from nao_course.field_slam.surest_first import SurestFirst
from nao_course.geometry import Pose
from nao_course.slam import Estimate, Motion

TURN, KNOWN = Motion(0.2, 0.5), np.radians(1.0) ** 2
NOTHING = np.zeros((0, 0))


class Scripted:
    """A filter that moves as commanded and observes landmarks in the order of a script."""

    def __init__(self, script=()):
        self.state, self.covariance, self.kinds = np.zeros(3), np.zeros((3, 3)), []
        self.indices, self.odometry, self.script = (
            np.zeros(0, dtype=int),
            OdometryNoisePerMove(),
            list(script),
        )

    def move(self, motion):
        self.state = self.state + np.pad([motion.distance, 0, motion.turn], (0, len(self.state) - 3))
        noise = np.zeros_like(self.covariance)
        noise[:3, :3] = self.odometry.covariance(motion)
        self.covariance = self.covariance + noise

    def observe(self, measurements):
        self.indices = np.array(self.script.pop(0) if self.script else [], dtype=int)
        for number in range(len(self.kinds), self.indices.max(initial=-1) + 1):
            self.state = np.append(self.state, [number, -number])
            self.covariance = np.pad(self.covariance, (0, 2)) + np.diag(
                [0.0] * (3 + 2 * number) + [1 + number] * 2
            )
            self.kinds.append("corner")

    def estimate(self):
        n = len(self.kinds)
        own = np.array([self.covariance[3 + 2 * i : 5 + 2 * i, 3 + 2 * i : 5 + 2 * i] for i in range(n)])
        return Estimate(
            Pose.from_array(self.state[:3]),
            self.covariance[:3, :3],
            self.state[3:].reshape(-1, 2),
            own.reshape(-1, 2, 2),
            tuple(self.kinds),
        )


class Noted(Scripted):
    """Notes in which order pictures and commands come."""

    def __init__(self):
        super().__init__()
        self.came = []

    def move(self, motion):
        self.came.append("move")

    def observe(self, measurements):
        self.came.append((measurements.direction, measurements.direction_sigma))


def frames(*sigmas):
    return [Observation((), NOTHING, 0.1 * number, sigma) for number, sigma in enumerate(sigmas)]


@pytest.mark.parametrize("asked", [0, 1, 2, 3])
def test_a_stops_surest_compass_comes_first_however_often_an_estimate_is_asked_for(asked):
    slam = SurestFirst(Noted())
    for number, each in enumerate(frames(np.inf, 0.02, 0.01)):
        slam.observe(each)
        if number < asked:
            slam.estimate()
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


def test_an_estimate_holds_all_pictures_so_far():
    slam = SurestFirst(Scripted([[0], [1]]))
    for count, each in enumerate(frames(0.02, 0.01), start=1):
        slam.observe(each)
        assert len(slam.estimate().landmarks) == count
        assert len(slam.estimate().landmarks) == count  # asking again changes nothing
