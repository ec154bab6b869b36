"""Lesson 12's drives: what is seen and how moves scatter, and drives that choose their next move."""

import numpy as np
import pytest

from nao_course.exercises import decode, encode
from nao_course.field_slam.drives import room_ahead
from nao_course.geometry import Pose
from nao_course.lessons.beyond import planning
from nao_course.lessons.beyond.worlds import AHEAD, AROUND, LANDMARKS, NEAREST, ODOMETRY, SENSOR, drive, moved
from nao_course.slam import Motion, range_and_bearing
from tests.lessons.every import text

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


STATE = np.concatenate([(1.2, -0.3, 0.4), LANDMARKS.ravel()])


def test_an_option_says_what_will_be_seen_where_it_leads_and_that_there_is_room(rng):
    assert len(planning.options(STATE)) > 3
    for option in planning.options(STATE):
        distance, turn = option.control
        after = (Pose.from_array(STATE[:3]) @ Pose(distance, 0, 0) @ Pose(0, 0, turn)).as_array()
        assert option.indices == np.flatnonzero(AHEAD.sees(after, LANDMARKS)).tolist()
        expected = range_and_bearing(after, LANDMARKS[option.indices])
        assert np.allclose(option.measurements, expected.ravel())
        assert np.allclose(option.measurement_covariance, SENSOR.covariances(expected))
        assert np.allclose(option.control_covariance, ODOMETRY.covariance(Motion(distance, turn)))
    for pose in rng.uniform((0.25, -1.75, -np.pi), (2.75, 1.75, np.pi), (60, 3)):
        offered = planning.options(pose)
        assert offered
        for option in offered:
            distance, turn = option.control
            after = (Pose.from_array(pose) @ Pose(distance, 0, turn)).as_array()
            assert 0 <= distance <= planning.STEP and option.indices == []
            assert len(offered) == 1 or room_ahead(after, planning.STEP) >= planning.ROOM


def test_an_option_travels_to_the_grader_as_it_is_and_one_of_other_shapes_is_refused():
    option = planning.options(STATE)[1]
    back = decode(encode(option))
    assert isinstance(back, planning.Option) and back.indices == option.indices
    assert np.array_equal(back.measurement_covariance, option.measurement_covariance)
    good = {
        "control": np.zeros(2),
        "control_covariance": np.zeros((3, 3)),
        "indices": [0, 1],
        "measurements": np.zeros(4),
        "measurement_covariance": np.zeros((2, 2, 2)),
    }
    planning.Option(**good)
    for name, value in (("control", np.zeros(3)), ("measurement_covariance", np.eye(2)), ("indices", [0])):
        with pytest.raises(ValueError, match="must have shape"):
            planning.Option(**good | {name: value})


def test_a_journey_begins_with_the_goal_ahead_or_behind_is_of_its_seed_and_maps_what_was_seen(ekf):
    one, again = (planning.journey(planning.at_random(3), ekf, 3, 6) for _ in range(2))
    last = one.estimates[-1]
    assert np.array_equal(one.truth, again.truth)
    assert np.array_equal(last.covariance, again.estimates[-1].covariance)
    assert len(one.truth) == len(one.estimates) == len(one.seen) == len(one.sigmas) == len(one.errors) == 7
    assert len(last.landmarks) == len(one.known) == len(set().union(*one.seen)) and one.map_error < 0.5
    assert one.errors[-1] == pytest.approx(np.hypot(*(one.truth[-1] - last.pose.as_array())[:2]))
    assert not np.array_equal(one.truth, planning.journey(planning.at_random(4), ekf, 4, 6).truth)
    for seed in range(5):
        for back in (False, True):
            x, y, theta = planning.journey(planning.straight_on, ekf, seed, 0, back=back).truth[0]
            ahead = np.cos(np.arctan2(-y, planning.GOAL_LINE - x) - theta)
            assert ahead < -0.9 if back else ahead > 0.9


def test_no_index_is_refused_a_choice_changes_nothing_and_plans_that_know_nothing_turn_as_they_say(ekf):
    for answer in (None, 1.0, True, 99):
        with pytest.raises(ValueError, match="choose_move must return an index from 0 to"):
            planning.journey(lambda state, covariance, offered, answer=answer: answer, ekf, 0, 1)

    def spoil(state, covariance, offered):
        state[:], covariance[:] = 0, 0
        return 0

    kept = planning.journey(lambda state, covariance, offered: 0, ekf, 1, 4)
    assert planning.journey(spoil, ekf, 1, 4).estimates[-1].pose == kept.estimates[-1].pose
    offered = planning.options(STATE)
    turns = [option.control[1] for option in offered]
    assert turns[planning.in_a_circle(STATE, np.eye(3), offered)] == pytest.approx(planning.TURNS[5])
    assert turns[planning.straight_on(STATE, np.eye(3), offered)] == min(turns, key=abs)


def test_the_text_says_what_drives_look_like_and_that_the_choice_finds_less_than_chance_if_blind(own, ekf):
    sigmas = 100 * planning.journey(own["choose_move"], ekf, 0).sigmas
    assert f"in drive 0 to {sigmas[17]:.0f} cm after 17 moves" in text("12") and sigmas[17] == sigmas.max()
    assert f"to {sigmas[20]:.0f} cm after 20 moves" in text("12")
    edge = [planning.journey(planning.straight_on, ekf, seed) for seed in range(12)]
    assert np.mean([len(seen) <= 1 for each in edge for seen in each.seen[1:]]) > 0.5
    assert "at most one landmark in most moves" in text("12")

    def found(choose):
        journeys = [planning.journey(choose(seed), ekf, seed, 4, back=True) for seed in range(12)]
        return np.median([len(each.known) for each in journeys])

    assert found(lambda seed: own["choose_move"]) == 1
    assert found(planning.at_random) == 5
