"""The challenge of lesson 12: the most certain map in twenty moves, and a score that rewards consistent maps."""

import numpy as np
import pytest

from nao_course.challenges.beliefs import DEEPEST
from nao_course.geometry import Pose
from nao_course.lessons.beyond.challenge import AREA, LEAST, Robot, judge, make_case


def test_a_landmark_counts_its_bits_and_certainty_at_wrong_places_costs_more_than_not_to_look():
    case, sigma = make_case(3), 0.05
    single = judge(([4], np.append(np.zeros(3), case.landmarks[4]), np.eye(5) * sigma**2), case)
    assert single.score == pytest.approx(np.log2(AREA / (2 * np.pi * (sigma**2 + LEAST))), abs=1e-6)
    assert single.columns["found"] == 1 and single.columns["NEES a coordinate"] == 0
    sure = scored((0.3, 0.0), 0.02)
    assert sure.score == DEEPEST and sure.columns["NEES a coordinate"] == pytest.approx(112.5, rel=0.01)
    off = np.random.default_rng(0).normal(0, 0.1, (10, 2))
    scores = [scored(off, sigma).score for sigma in (0.1, 0.03, 0.3)]
    assert scores[0] == max(scores)


def scored(off, sigma):
    """Return the score of a map of ten landmarks that are off by this, with a standard deviation."""
    case = make_case(3)
    state = np.append(np.zeros(3), (case.landmarks + off).ravel())
    return judge((range(10), state, np.eye(23) * sigma**2), case)


def test_the_errors_of_a_look_and_of_the_next_move_are_independent():
    start, ahead = Pose(0.5, 0.0, 0.0), np.tile((2.5, 0.0), (10, 1))
    looks, moves = [], []
    for seed in range(60):
        robot = Robot(start, ahead, seed)
        looks.append(robot.look()[1].ravel()[:3])
        robot.move((0.3, 0.0))
        moves.append(robot.__dict__["_path"][-1])
    between = np.corrcoef(np.transpose(looks), np.transpose(moves))[:3, 3:]
    assert np.abs(between).max() < 0.5  # about 0.13 is the standard deviation by chance


def test_a_robot_makes_twenty_moves_and_no_wild_ones_and_stays_on_the_carpet():
    robot = make_case(5).robot
    for wrong in ((0.4, 0.0), (0.1, 4.0), (np.nan, 0.0), 0.2, (0.1, 0.1, 0.1)):
        with pytest.raises(ValueError, match="a move is"):
            robot.move(wrong)
    for left in range(20, 0, -1):
        assert robot.moves_left == left
        robot.move((0.0, 0.3))
    with pytest.raises(ValueError, match="all 20 moves"):
        robot.move((0.0, 0.3))
    robot = make_case(5).robot
    for _ in range(10):  # 3 m, past the goal line
        robot.move((0.3, 0.0))
    with pytest.raises(ValueError, match="left the carpet with move 11"):
        robot.move((0.3, 0.0))
