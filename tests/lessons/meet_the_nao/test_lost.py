"""The robot that is lost: a pose stays possible as long as it explains what was seen, and the true one does."""

from itertools import pairwise

import numpy as np
import pytest

from nao_course.geometry import Pose, wrap_angle
from nao_course.lessons.meet_the_nao import draw_lost_and_found, lost
from nao_course.sim import Field, SensorNoise
from nao_course.slam import Measurement
from tests.drawings import assert_same_bytes_with_words

FIELD = Field(2012, half=True)


def measured(pose, mark):
    """What a robot without noise measures of a landmark."""
    (x, y) = pose.to_local([mark.x, mark.y])[0]
    return Measurement(np.arctan2(y, x), np.hypot(x, y), mark.kind)


@pytest.fixture
def fewer(monkeypatch):
    monkeypatch.setattr(lost, "POSSIBLE", 20_000)


def test_the_true_pose_explains_every_measurement_without_noise_and_one_that_is_turned_or_moved_does_not(rng):
    for x, y, heading in rng.uniform([0, -2, -np.pi], [3, 2, np.pi], (50, 3)):
        seen = [measured(Pose(x, y, heading), mark) for mark in FIELD.landmarks if mark.kind != "cross"]
        assert lost.explains([(x, y, heading)], seen, FIELD, SensorNoise()).all()
    behind = [Measurement(bearing, 2.0, "post") for bearing in (3.13, -3.13)]
    for side in (0.01, -0.01):
        assert lost.explains([(1.0, 0.7, np.pi - side)], behind, FIELD, SensorNoise()).all()
    pose, noise = Pose(1.0, 0.0, 0.0), SensorNoise()
    (post,) = [mark for mark in FIELD.landmarks if mark.kind == "post" and mark.y > 0]
    seen = measured(pose, post)
    slack = 3 * noise.bearing
    poses = [(1.0, 0.0, 0.9 * slack), (1.0, 0.0, -1.1 * slack), (0.6, 0.0, 0.0)]
    assert lost.explains(poses, [seen], FIELD, noise).tolist() == [True, False, False]
    corner = Measurement(seen.bearing, seen.range, "corner")
    assert not lost.explains([pose.as_array()], [corner], FIELD, noise).any()
    assert lost.explains(poses, [], FIELD, noise).all()


@pytest.mark.usefixtures("fewer")
def test_each_look_leaves_fewer_poses_and_those_are_near_the_robot():
    found = lost.search(FIELD, np.pi / 2, np.random.default_rng(lost.SEED))
    counts = [len(poses) for poses in found.possible]
    assert counts[0] == lost.POSSIBLE
    assert all(after <= before for before, after in pairwise(counts))
    first = found.possible[1]
    assert lost.explains(first, found.observations[0], FIELD, SensorNoise()).all()
    assert counts[1] < 0.1 * counts[0] and counts[2] < 0.01 * counts[0]


def test_all_of_them_find_the_robot():
    """What the figure shows: the poses that are left lie nearer than the odometry does."""
    found = lost.search(FIELD, np.pi / 2, np.random.default_rng(lost.SEED))
    truth, last = found.poses[-1].as_array(), found.possible[-1]
    assert len(last) >= 3
    off = np.hypot(*(last[:, :2] - truth[:2]).T)
    alone = np.hypot(*(found.odometry[-1].as_array() - truth)[:2])
    assert off.max() < 0.3 and off.mean() < alone / 2


@pytest.mark.slow
@pytest.mark.usefixtures("fewer")
def test_the_figure_is_the_same_bytes_with_its_words_and_a_wrong_turn_is_another_drive():
    assert_same_bytes_with_words(lambda: draw_lost_and_found(np.radians))
    right, half = (lost.search(FIELD, turn, np.random.default_rng(1)) for turn in (np.pi / 2, np.pi / 4))
    assert abs(wrap_angle(right.poses[1].theta - half.poses[1].theta)) > 0.5
