"""Drives over the half field: their odometry and the way they take."""

import numpy as np
import pytest

from nao_course.field_slam import drives
from nao_course.field_slam.drives import (
    CARRIED,
    INSIDE,
    STEP,
    Driver,
    OdometryNoisePerMove,
    drive_over_field,
    room_ahead,
    start_of,
)
from nao_course.geometry import Pose, wrap_angle
from nao_course.slam import Motion


def test_odometry_is_a_tenth_of_the_way_and_of_the_turn_alike_to_both_sides():
    sd = np.sqrt(np.diag(OdometryNoisePerMove().covariance(Motion(1.0, 0.5))))
    assert sd == pytest.approx([0.101, 0.051, 0.05 + np.radians(1)])
    double, single = (OdometryNoisePerMove(factor=each).covariance(Motion(1.0)) for each in (2.0, 1.0))
    assert np.allclose(double, 4 * single)
    covariances = [OdometryNoisePerMove().covariance(Motion(d, t)) for d in (0.5, -0.5) for t in (0.7, -0.7)]
    assert np.allclose(covariances, covariances[0])


def test_a_drive_is_long_and_turns_and_stays_on_the_field_and_walks_whole_steps_where_there_is_room():
    for seed in range(5):
        pose, driver, motions = start_of(seed), Driver(np.random.default_rng([seed, 13])), []
        for _ in range(60):
            motions.append(driver.next(pose))
            pose = pose @ motions[-1].as_pose()
            assert 0 < pose.x < 3 and -2 < pose.y < 2
        assert sum(motion.distance for motion in motions) >= 12
        assert np.degrees(sum(abs(motion.turn) for motion in motions)) >= 720
        assert abs(wrap_angle(start_of(seed).theta)) < np.pi / 2
    ahead = Pose(1.5, -1.5, np.pi / 2)  # a goal straight ahead can be far enough away
    turns = [abs(np.degrees(Driver(np.random.default_rng(seed)).next(ahead).turn)) for seed in range(40)]
    assert min(turns) > 30 and max(turns) == pytest.approx(50)
    for degrees in (0, 90, 180, -90, 45):  # with room ahead it walks a whole step in every direction
        pose = Pose(1.5, 0.0, np.radians(degrees))
        assert Driver(np.random.default_rng(1)).next(pose).distance == pytest.approx(STEP)


def test_room_ends_at_the_edge_where_a_robot_stops():
    assert room_ahead(np.array([1.0, 0.0, 0.0]), 0.3) == 0.3
    assert room_ahead(np.array([INSIDE[1][0] - 0.1, 0.0, 0.0]), 0.3) == pytest.approx(0.1)
    assert room_ahead(np.array([1.0, INSIDE[0][1], -np.pi / 2]), 0.3) == pytest.approx(0)
    assert room_ahead(np.array([1.0, INSIDE[1][1] + 0.2, np.pi / 2]), 0.3) == 0  # beyond the edge, outwards
    slanted = room_ahead(np.array([1.0, INSIDE[1][1] - 0.1, np.pi / 6]), 0.3)
    assert slanted == pytest.approx(0.2)
    for pose, room in (
        (Pose(2.65, 0, 0), 0.1),
        (Pose(1, -1.75, -np.pi / 2), 0),
        (Pose(0.35, 1.0, np.pi), 0.1),
    ):
        assert Driver(np.random.default_rng(1)).next(pose).distance == pytest.approx(room, abs=1e-9)


def test_a_robot_is_carried_away_without_a_motion_and_drives_on_from_there(monkeypatch):
    def driven(carried, moves=2, yaws=(0.0, 0.5)):
        return list(drive_over_field(2, moves=moves, yaws=yaws, carried=carried))

    as_usual, away = driven(None, 1), driven(1)
    assert [shot.pose for shot in away[:2]] == [shot.pose for shot in as_usual[:2]]
    assert (away[1].picture.pixels == as_usual[1].picture.pixels).all()
    assert [shot.carried for shot in away] == [False, False, True, False, False, False]
    assert away[2].motion == Motion() and away[3].motion is None
    start, there, later = (shot.pose for shot in away[::2])
    assert np.hypot(there.x - start.x, there.y - start.y) >= CARRIED
    assert 0 < np.hypot(later.x - there.x, later.y - there.y) < 2 * STEP
    assert INSIDE[0][0] < there.x < INSIDE[1][0] and INSIDE[0][1] < there.y < INSIDE[1][1]
    monkeypatch.setattr(drives, "CARRIED", 100.0)  # as far away as possible
    far = driven(1, 1, (0.0,))[1].pose
    assert np.hypot(far.x - start.x, far.y - start.y) > 2.0
