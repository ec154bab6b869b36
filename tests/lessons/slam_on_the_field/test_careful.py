"""The careful filter: what is learnt of odometry, and which landmarks stay."""

from __future__ import annotations

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.slam_on_the_field.system.careful import (
    PATIENCE,
    SIGHTINGS,
    CarefulSlam,
    LearntOdometry,
    SurestFirst,
)
from nao_course.lessons.slam_on_the_field.system.drives import FieldOdometry
from nao_course.lessons.slam_on_the_field.system.observation import Observation
from nao_course.slam import Estimate, Motion

TURN, KNOWN = Motion(0.2, 0.5), np.radians(1.0) ** 2
NOTHING = np.zeros((0, 0))


class Scripted:
    """A filter that moves by what it is told, and sees landmarks by their numbers: a script."""

    def __init__(self, sights=()):
        self.state, self.covariance, self.kinds = np.zeros(3), np.zeros((3, 3)), []
        self.indices, self.odometry, self.sights = np.zeros(0, dtype=int), FieldOdometry(), list(sights)

    def move(self, motion):
        self.state = self.state + np.pad([motion.distance, 0, motion.turn], (0, len(self.state) - 3))
        noise = np.zeros_like(self.covariance)
        noise[:3, :3] = self.odometry.covariance(motion)
        self.covariance = self.covariance + noise

    def observe(self, measurements):
        self.indices = np.array(self.sights.pop(0) if self.sights else [], dtype=int)
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


@pytest.mark.parametrize("factor", [1.0, 2.0, 3.0])
def test_the_compass_tells_how_bad_odometry_is(factor):
    learnt, rng = LearntOdometry(FieldOdometry()), np.random.default_rng(3)
    sigma = np.sqrt(factor**2 * FieldOdometry().covariance(TURN)[2, 2] + KNOWN)
    for error in rng.normal(0, sigma, 60):
        learnt.learn(error, KNOWN, TURN)
    assert learnt.factor == pytest.approx(factor, rel=0.2)


def test_a_few_wrong_compasses_do_not_make_odometry_bad():
    learnt, rng = LearntOdometry(FieldOdometry()), np.random.default_rng(4)
    sigma = np.sqrt(FieldOdometry().covariance(TURN)[2, 2] + KNOWN)
    for error in [*rng.normal(0, sigma, 60), 0.6, -0.7]:
        learnt.learn(error, KNOWN, TURN)
    assert learnt.factor == pytest.approx(1.0, abs=0.2)


def test_what_odometry_is_worse_by_is_worse_in_every_direction():
    learnt = LearntOdometry(FieldOdometry(), (2.0,))
    assert np.allclose(learnt.covariance(TURN), FieldOdometry(factor=2.0).covariance(TURN))


def test_a_move_is_taken_in_once_and_as_surely_as_its_own_turn_has_shown():
    careful = CarefulSlam(Scripted())
    before = careful.odometry.factor
    careful.move(TURN)
    careful.observe(Observation((), NOTHING, direction=-0.5 - 0.4, direction_sigma=0.01))  # 23 degrees more
    inner, after = careful.inner, careful.odometry.factor
    assert after > before and np.allclose(inner.state, [0.2, 0, 0.5])
    assert np.allclose(inner.covariance, after**2 * FieldOdometry().covariance(TURN))


def test_a_landmark_that_is_not_seen_again_goes_and_takes_nothing_along():
    script = [[0, 1, 2], [1, 2], [1, 2]]  # 0 is seen once
    careful = CarefulSlam(Scripted(script))
    for _ in range(PATIENCE):
        careful.observe([])
    assert len(careful.inner.kinds) == 3
    careful.observe([])
    careful.observe([])
    inner = careful.inner
    assert len(inner.kinds) == 2 and np.allclose(inner.state[3:], [1, -1, 2, -2])
    assert np.allclose(np.diag(inner.covariance)[3:], [2, 2, 3, 3]) and inner.covariance.shape == (7, 7)


def test_a_landmark_is_told_of_when_it_was_seen_often_enough():
    careful = CarefulSlam(Scripted([[0, 1]] + [[0]] * (SIGHTINGS - 1)))
    told = []
    for _ in range(SIGHTINGS):
        careful.observe([])
        told.append(len(careful.estimate().landmarks))
    assert told == [0] * (SIGHTINGS - 1) + [1]


def test_without_doubts_it_is_the_filter_itself():
    script = [[0, 1], [], [2]] + [[]] * (PATIENCE + 2)
    plain, careful = Scripted(script), CarefulSlam(Scripted(script), sightings=1, factors=(1.0,))
    for _ in script:
        for each in (plain, careful):
            each.move(TURN)
            each.observe(Observation((), NOTHING, direction=0.1, direction_sigma=0.02))
    for name in ("landmarks", "covariance", "landmark_covariances", "kinds"):
        assert np.array_equal(getattr(plain.estimate(), name), getattr(careful.estimate(), name))


class Noted(Scripted):
    """Notes in which order pictures and commands come."""

    def __init__(self):
        super().__init__()
        self.came = []

    def move(self, motion):
        self.came.append("move")

    def observe(self, measurements):
        self.came.append(measurements.direction_sigma)


def test_a_stops_surest_compass_comes_first_and_no_picture_waits_for_the_next_stop():
    slam = SurestFirst(Noted())
    for sigma in (np.inf, 0.02, 0.01):
        slam.observe(Observation((), NOTHING, 0.0, sigma))
    slam.move(TURN)
    slam.observe(Observation((), NOTHING, 0.0, 0.03))
    slam.estimate()
    slam.move(TURN)
    assert slam.inner.came == [0.01, 0.02, np.inf, "move", 0.03, "move"]


def test_pictures_without_a_compass_keep_their_order():
    slam, given = SurestFirst(Noted()), [Observation((), NOTHING) for _ in range(3)]
    slam.inner.observe = slam.inner.came.append
    for each in given:
        slam.observe(each)
    slam.estimate()
    assert all(came is each for came, each in zip(slam.inner.came, given, strict=True))
