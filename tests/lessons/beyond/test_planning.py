"""Drives that choose their next move."""

import numpy as np
import pytest

from nao_course.exercises import decode, encode
from nao_course.field_slam.drives import room_ahead
from nao_course.geometry import Pose
from nao_course.lessons.beyond import planning
from nao_course.lessons.beyond.worlds import AHEAD, LANDMARKS, ODOMETRY, SENSOR
from nao_course.slam import Motion, range_and_bearing
from tests.lessons.every import text

STATE = np.concatenate([(1.2, -0.3, 0.4), LANDMARKS.ravel()])


def test_an_option_says_what_will_be_seen_where_it_leads_if_nothing_errs():
    assert len(planning.options(STATE)) > 3
    for option in planning.options(STATE):
        distance, turn = option.control
        after = (Pose.from_array(STATE[:3]) @ Pose(distance, 0, 0) @ Pose(0, 0, turn)).as_array()
        assert option.indices == np.flatnonzero(AHEAD.sees(after, LANDMARKS)).tolist()
        expected = range_and_bearing(after, LANDMARKS[option.indices])
        assert np.allclose(option.measurements, expected.ravel())
        assert np.allclose(option.measurement_covariance, SENSOR.covariances(expected))
        assert np.allclose(option.control_covariance, ODOMETRY.covariance(Motion(distance, turn)))


def test_after_each_move_that_is_offered_there_is_room(rng):
    for pose in rng.uniform((0.25, -1.75, -np.pi), (2.75, 1.75, np.pi), (60, 3)):
        offered = planning.options(pose)
        assert offered
        for option in offered:
            distance, turn = option.control
            after = (Pose.from_array(pose) @ Pose(distance, 0, turn)).as_array()
            assert (
                0 <= distance <= planning.STEP and option.indices == [] and option.measurements.shape == (0,)
            )
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
    for name, value in (
        ("control", np.zeros(3)),
        ("control_covariance", np.zeros((2, 2))),
        ("measurements", np.zeros(3)),
        ("measurement_covariance", np.zeros((2, 2))),
        ("indices", [0]),
    ):
        with pytest.raises(ValueError, match="must have shape"):
            planning.Option(**good | {name: value})


def test_a_journey_is_the_same_from_its_seed_and_its_map_holds_what_was_seen(ekf):
    one, again = (planning.journey(planning.at_random(3), ekf, 3, 6) for _ in range(2))
    last = one.estimates[-1]
    assert np.array_equal(one.truth, again.truth)
    assert np.array_equal(last.covariance, again.estimates[-1].covariance)
    assert len(one.truth) == len(one.estimates) == len(one.seen) == len(one.sigmas) == len(one.errors) == 7
    assert len(last.landmarks) == len(one.known) == len(set().union(*one.seen)) and one.map_error < 0.5
    assert one.errors[-1] == pytest.approx(np.hypot(*(one.truth[-1] - last.pose.as_array())[:2]))
    assert not np.array_equal(one.truth, planning.journey(planning.at_random(4), ekf, 4, 6).truth)


def test_a_journey_begins_with_the_goal_ahead_or_behind(ekf):
    for seed in range(5):
        for back in (False, True):
            x, y, theta = planning.journey(planning.straight_on, ekf, seed, 0, back=back).truth[0]
            ahead = np.cos(np.arctan2(-y, planning.GOAL_LINE - x) - theta)
            assert ahead < -0.9 if back else ahead > 0.9


def test_what_is_no_number_of_an_option_is_refused_and_a_choice_changes_nothing_of_what_it_is_given(ekf):
    for answer in (None, 1.0, True, 99):
        with pytest.raises(ValueError, match="choose_move must return an index from 0 to"):
            planning.journey(lambda state, covariance, offered, answer=answer: answer, ekf, 0, 1)

    def spoil(state, covariance, offered):
        state[:], covariance[:] = 0, 0
        return 0

    kept = planning.journey(lambda state, covariance, offered: 0, ekf, 1, 4)
    assert planning.journey(spoil, ekf, 1, 4).estimates[-1].pose == kept.estimates[-1].pose


def test_plans_that_know_nothing_turn_as_they_say():
    offered = planning.options(STATE)
    turns = [option.control[1] for option in offered]
    assert turns[planning.in_a_circle(STATE, np.eye(3), offered)] == pytest.approx(planning.TURNS[5])
    assert turns[planning.straight_on(STATE, np.eye(3), offered)] == min(turns, key=abs)


def test_the_text_says_what_drive_0_and_the_path_along_the_edge_look_like(own, ekf):
    sigmas = 100 * planning.journey(own["choose_move"], ekf, 0).sigmas
    assert f"in drive 0 to {sigmas[17]:.0f} cm after 17 moves" in text("12") and sigmas[17] == sigmas.max()
    assert f"to {sigmas[20]:.0f} cm after 20 moves" in text("12")
    edge = [planning.journey(planning.straight_on, ekf, seed) for seed in range(12)]
    assert np.mean([len(seen) <= 1 for each in edge for seen in each.seen[1:]]) > 0.5
    assert "at most one landmark in most moves" in text("12")


def test_from_a_blind_start_the_choice_finds_less_in_four_moves_than_chance(own, ekf):
    def found(choose):
        return np.median(
            [len(planning.journey(choose(seed), ekf, seed, 4, back=True).known) for seed in range(12)]
        )

    assert found(lambda seed: own["choose_move"]) == 1
    assert found(planning.at_random) == 5
