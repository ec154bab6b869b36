"""The challenge of lesson 06: three measurements, and a score that only consistent estimates get."""

import numpy as np
import pytest

from nao_course.challenges.running import run
from nao_course.lessons.localization.challenge import BUDGET, CHALLENGE, DEEPEST, judge, make_robot
from nao_course.lessons.localization.drives import LANDMARKS
from nao_course.metrics import log_density
from tests.paths import SOLUTIONS


def test_without_a_measurement_nothing_is_gained():
    robot = make_robot(5)
    assert judge((robot.pose, robot.covariance), robot).score == 0.0


def test_half_the_standard_deviation_in_one_direction_at_the_true_pose_is_one_bit():
    robot = make_robot(5)
    half = robot.covariance * np.outer((1, 1, 0.5), (1, 1, 0.5))
    there = judge((robot.truth, half), robot).score - judge((robot.truth, robot.covariance), robot).score
    assert there == pytest.approx(1.0)


def test_a_small_covariance_around_a_wrong_pose_costs_more_than_no_measurement():
    robot = make_robot(5)
    wrong = robot.truth + (0.2, 0.0, 0.0)
    scored = judge((wrong, np.diag([0.02, 0.02, 0.02]) ** 2), robot)
    assert scored.score == DEEPEST and scored.columns["NEES"] == pytest.approx(100)
    assert scored.columns["off"] == pytest.approx(20) and scored.columns["stated"] == pytest.approx(
        2 * 2**0.5
    )


def test_the_first_estimates_are_consistent():
    robots = [make_robot(seed) for seed in range(200, 320)]
    squares = [log_density(each.pose, each.covariance, each.truth)[1] for each in robots]
    assert np.mean(squares) == pytest.approx(3.0, abs=0.6)


def test_there_are_three_measurements_and_no_more():
    sensor = make_robot(1).sensor
    measured, noise = sensor.measure(4)
    again, _ = sensor.measure(4)
    assert measured.shape == (2,) and noise.shape == (2, 2) and not np.array_equal(measured, again)
    sensor.measure(0)
    with pytest.raises(ValueError, match=f"all {BUDGET} measurements are used"):
        sensor.measure(1)
    for number in (10, -1, 0.5, True, "post", None, LANDMARKS[0], np.nan):
        with pytest.raises(ValueError, match="row of landmarks, 0 to 9"):
            make_robot(1).sensor.measure(number)


def test_measurements_that_were_not_taken_have_no_public_name():
    sensor = make_robot(1).sensor
    assert [name for name in dir(sensor) if not name.startswith("_")] == ["measure"]


def test_the_text_states_how_far_off_the_robots_are():
    robots = [make_robot(seed) for seed in CHALLENGE.seeds]
    off = np.array([np.hypot(*(each.truth - each.pose)[:2]) for each in robots])
    text = " ".join((SOLUTIONS / "06_localization.md").read_text(encoding="utf-8").split())
    assert (
        f"wrong by more than half a metre for {np.sum(off > 0.5)} robots, and by {off.max():.1f} m for one."
        in text
    )


def test_every_run_has_all_measurements_and_measuring_does_not_change_the_arguments():
    def measure_all(pose, covariance, landmarks, sensor):
        for number in range(BUDGET):
            sensor.measure(number)
        return pose, covariance

    for _ in range(2):
        came = run(CHALLENGE, measure_all)
        assert came.complete and came.problems() == [] and came.score == 0.0


def test_all_robots_stand_on_the_half_field_with_its_landmarks():
    assert LANDMARKS.shape == CHALLENGE.given(make_robot(0))[2].shape
    poses = np.array([make_robot(seed).pose for seed in CHALLENGE.seeds])
    assert (poses[:, 0] > 0).all() and (poses[:, 0] < 3).all() and (np.abs(poses[:, 1]) < 2).all()
