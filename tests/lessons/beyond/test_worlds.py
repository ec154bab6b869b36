"""Drives of lesson 12 with known data association."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.beyond.worlds import AHEAD, AROUND, LANDMARKS, NEAREST, ODOMETRY, drive, moved
from nao_course.slam import Motion, range_and_bearing

SAMPLES = 4000


def test_a_move_scatters_as_its_covariance_says_in_the_robots_own_frame(rng):
    motion = Motion(0.3, 0.5)
    wanted = np.diag(ODOMETRY.covariance(motion))
    # 10 %, 5 %, and 10 % and 1 degree
    assert np.allclose(np.sqrt(wanted), (0.031, 0.016, np.radians(1) + 0.05))
    draws = rng.standard_normal((SAMPLES, 3))
    poses = moved(np.zeros((SAMPLES, 3)), motion, draws)
    assert np.allclose(poses.var(axis=0), wanted, rtol=0.15)
    assert np.allclose(poses.mean(axis=0), (0.3, 0, 0.5), atol=4 * np.sqrt(wanted / SAMPLES))
    there = Pose(1.0, 0.5, 2.0)
    seen_there = moved(there.as_array()[None], motion, draws[:1])[0]
    assert np.allclose((there @ Pose.from_array(poses[0])).as_array(), seen_there)


def test_without_noise_a_drive_is_what_is_commanded_and_what_is_seen_is_where_it_is(still):
    start, motion = Pose(0.5, 0.0, 0.0), Motion(0.2, 0.1)
    pose = start
    for number, step in enumerate(drive(start, lambda: motion, 8, still, AHEAD)):
        pose = pose @ Pose(0.2, 0.0, 0.0) @ Pose(0.0, 0.0, 0.1) if number else pose
        assert np.allclose(step.pose, pose.as_array())
        assert np.allclose(step.measurements, range_and_bearing(step.pose, LANDMARKS[step.numbers]))
        assert (step.motion is None) == (number == 0)
    assert number == 8


@pytest.mark.parametrize("eye", [AHEAD, AROUND])
def test_all_that_is_seen_is_in_sight_and_all_in_sight_is_seen(eye):
    start = Pose(1.0, 0.0, 0.4)
    for step in drive(start, lambda: Motion(0.1, 0.5), 12, np.random.default_rng(4), eye):
        seen = range_and_bearing(step.pose, LANDMARKS)
        wanted = (np.abs(seen[:, 0]) <= eye.sideways) & (seen[:, 1] <= eye.reach) & (seen[:, 1] >= NEAREST)
        assert step.numbers.tolist() == np.flatnonzero(wanted).tolist()
        assert len(step.measurements) == len(step.numbers)


def test_nothing_nearer_than_40_cm_is_seen():
    place = LANDMARKS[0]
    for away, seen in ((NEAREST - 0.05, False), (NEAREST + 0.05, True)):
        assert AHEAD.sees(np.array([place[0] - away, place[1], 0.0]), LANDMARKS)[0] == seen
