"""The challenge of lesson 06: three measurements, and a score that only consistent estimates get."""

import numpy as np
import pytest

from nao_course.challenges.running import run
from nao_course.lessons.localization.challenge import BUDGET, CHALLENGE, DEEPEST, judge, make_robot
from nao_course.lessons.localization.drives import LANDMARKS
from nao_course.metrics import log_density
from tests.lessons.every import text


def test_bits_are_gained_by_measurements_and_first_estimates_are_consistent_and_as_far_off_as_the_text_says():
    robot = make_robot(5)
    assert judge((robot.pose, robot.covariance), robot).score == 0.0
    half = robot.covariance * np.outer((1, 1, 0.5), (1, 1, 0.5))  # of the standard deviation of the heading
    there = judge((robot.truth, half), robot).score - judge((robot.truth, robot.covariance), robot).score
    assert there == pytest.approx(1.0)
    scored = judge((robot.truth + (0.2, 0.0, 0.0), np.diag([0.02, 0.02, 0.02]) ** 2), robot)
    assert scored.score == DEEPEST
    assert scored.columns == pytest.approx({"NEES": 100, "off": 20, "stated": 2 * 2**0.5})
    many = [make_robot(seed) for seed in range(200, 320)]
    squares = [log_density(each.pose, each.covariance, each.truth)[1] for each in many]
    assert np.mean(squares) == pytest.approx(3.0, abs=0.6)
    assert LANDMARKS.shape == CHALLENGE.given(make_robot(0))[2].shape
    robots = [make_robot(seed) for seed in CHALLENGE.seeds]
    x, y, _ = np.transpose([each.pose for each in robots])
    assert (x > 0).all() and (x < 3).all() and (np.abs(y) < 2).all()
    off = np.array([np.hypot(*(each.truth - each.pose)[:2]) for each in robots])
    said = f"more than half a metre for {np.sum(off > 0.5)} robots, and by {off.max():.1f} m for one."
    assert said in " ".join(text("06").split())


def test_there_are_three_measurements_in_every_run_and_measuring_does_not_change_the_arguments():
    sensor = make_robot(1).sensor
    assert [name for name in dir(sensor) if not name.startswith("_")] == ["measure"]
    measured, noise = sensor.measure(4)
    again, _ = sensor.measure(4)
    assert measured.shape == (2,) and noise.shape == (2, 2) and not np.array_equal(measured, again)
    sensor.measure(0)
    with pytest.raises(ValueError, match=f"all {BUDGET} measurements are used"):
        sensor.measure(1)
    for number in (10, -1, 0.5, True, "post"):
        with pytest.raises(ValueError, match="row of landmarks, 0 to 9"):
            make_robot(1).sensor.measure(number)

    def measure_all(pose, covariance, landmarks, sensor):
        for number in range(BUDGET):
            sensor.measure(number)
        return pose, covariance

    for _ in range(2):
        came = run(CHALLENGE, measure_all)
        assert came.complete and came.problems() == [] and came.score == 0.0
