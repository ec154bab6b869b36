"""The challenge of lesson 06: three looks, and a score that only honest beliefs get."""

import numpy as np
import pytest

from nao_course.challenges import CaseResult, Run
from nao_course.challenges.running import run
from nao_course.lessons.localization.challenge import (
    CHALLENGE,
    DEEPEST,
    LOOKS,
    judge,
    make_robot,
)
from nao_course.lessons.localization.drives import LANDMARKS
from nao_course.metrics import log_density
from tests.paths import SOLUTIONS


def test_who_does_not_look_gains_nothing():
    robot = make_robot(5)
    assert judge((robot.pose, robot.covariance), robot).score == 0.0


def test_to_be_twice_as_sure_in_one_direction_and_right_is_one_bit():
    robot = make_robot(5)
    sure = robot.covariance * np.outer((1, 1, 0.5), (1, 1, 0.5))
    there = judge((robot.truth, sure), robot).score - judge((robot.truth, robot.covariance), robot).score
    assert there == pytest.approx(1.0)


def test_to_be_sure_of_a_wrong_place_costs_more_than_not_to_look():
    robot = make_robot(5)
    wrong = robot.truth + (0.2, 0.0, 0.0)
    scored = judge((wrong, np.diag([0.02, 0.02, 0.02]) ** 2), robot)
    assert scored.score == DEEPEST and scored.columns["NEES"] == pytest.approx(100)
    assert scored.columns["off"] == pytest.approx(20) and scored.columns["stated"] == pytest.approx(
        2 * 2**0.5
    )


def test_the_density_is_a_gaussians_also_across_the_half_turn():
    from scipy.stats import multivariate_normal

    robot = make_robot(7)
    bits, squared = log_density(robot.pose, robot.covariance, robot.truth + (0, 0, 2 * np.pi))
    off = robot.truth - robot.pose
    off[2] = (off[2] + np.pi) % (2 * np.pi) - np.pi
    assert bits == pytest.approx(multivariate_normal.logpdf(off, np.zeros(3), robot.covariance) / np.log(2))
    assert squared == pytest.approx(off @ np.linalg.inv(robot.covariance) @ off)


def test_beliefs_at_first_are_honest():
    robots = [make_robot(seed) for seed in range(200, 320)]
    squares = [log_density(each.pose, each.covariance, each.truth)[1] for each in robots]
    assert np.mean(squares) == pytest.approx(3.0, abs=0.6)


def test_there_are_three_looks_and_no_more():
    looks = make_robot(1).looks
    measured, noise = looks.at(4)
    again, _ = looks.at(4)
    assert measured.shape == (2,) and noise.shape == (2, 2) and not np.array_equal(measured, again)
    looks.at(0)
    with pytest.raises(ValueError, match=f"all {LOOKS} looks are taken"):
        looks.at(1)
    for number in (10, -1, 0.5, True, "post", None, LANDMARKS[0], np.nan):
        with pytest.raises(ValueError, match="number is 0 to 9"):
            make_robot(1).looks.at(number)


def test_what_a_robot_has_not_looked_at_has_no_name_to_read():
    looks = make_robot(1).looks
    assert [name for name in dir(looks) if not name.startswith("_")] == ["at"]


def test_the_text_says_how_lost_the_robots_are():
    robots = [make_robot(seed) for seed in CHALLENGE.seeds]
    off = np.array([np.hypot(*(each.truth - each.pose)[:2]) for each in robots])
    text = " ".join((SOLUTIONS / "06_localization.md").read_text(encoding="utf-8").split())
    assert f"{np.sum(off > 0.5)} are farther off than that, one by {off.max():.1f} m" in text


def test_every_robot_gets_its_looks_anew_and_looking_is_no_change_of_what_is_given():
    def looks_around(pose, covariance, landmarks, looks):
        for number in range(LOOKS):
            looks.at(number)
        return pose, covariance

    for _ in range(2):
        came = run(CHALLENGE, looks_around)
        assert came.complete and came.problems() == [] and came.score == 0.0


def test_the_figure_shows_the_robots_that_lose_most():
    robots = [make_robot(seed) for seed in range(3)]
    answers = [
        (robots[0].pose + (0.3, 0, 0), 1e-4 * np.eye(3)),
        (robots[1].truth, 1e-2 * np.eye(3)),
        (robots[2].pose, robots[2].covariance),
    ]
    scored = [judge(answer, robot) for answer, robot in zip(answers, robots, strict=True)]
    results = tuple(
        CaseResult(n, f"robot {n}", each.score, each.columns, each.kept) for n, each in enumerate(scored)
    )
    alt = CHALLENGE.figure(Run(CHALLENGE, results)).alt
    assert "The worst are robot 0 with -20.0 bits, robot 2 with 0.0 bits" in alt


def test_the_lesson_says_what_the_board_says():
    text = (SOLUTIONS / "06_localization.md").read_text(encoding="utf-8")
    rows = {row.name: row for row in CHALLENGE.rows}
    assert f"Its NEES is {rows['the three nearest'].columns['NEES']:.0f}" in text
    better = rows["a better filter"]
    assert f"gains {better.score:.1f} bits with a NEES of {better.columns['NEES']:.1f}" in text
    assert rows["the reference"].score > rows["the three nearest"].score > rows["no look"].score == 0.0


def test_all_robots_stand_on_the_half_field_with_its_landmarks():
    assert LANDMARKS.shape == CHALLENGE.given(make_robot(0))[2].shape
    poses = np.array([make_robot(seed).pose for seed in CHALLENGE.seeds])
    assert (poses[:, 0] > 0).all() and (poses[:, 0] < 3).all() and (np.abs(poses[:, 1]) < 2).all()
