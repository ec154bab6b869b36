"""The challenge of lesson 02: what is scored, and what is said of wrong answers."""

import numpy as np
import pytest

from nao_course.lessons.goalposts.challenge import judge
from nao_course.lessons.goalposts.measuring import Feet
from nao_course.lessons.goalposts.scenes import PostScene
from nao_course.sim import NAO_V4

SCENE = PostScene(
    np.zeros((240, 320, 3), dtype=np.uint8),
    np.zeros((240, 320), dtype=np.uint8),
    Feet(np.array([[50.0, 90.0], [200.0, 80.0]]), np.array([2.0, 2.5]), np.array([[-5.0, 70.0]])),
    NAO_V4.view("bottom"),
)


def test_the_truth_scores_one_and_nothing_scores_nothing():
    assert judge(SCENE.feet.pixels, SCENE).score == judge([(50, 90), (200, 80)], SCENE).score == 1.0
    assert judge(np.zeros((0, 2)), SCENE).score == 0.0


def test_a_missed_foot_and_a_false_point_cost_and_are_told():
    scored = judge([(50, 90), (120, 30), (130, 30), (-5, 70)], SCENE)
    assert scored.score == pytest.approx(2 * 1 / (2 + 3))
    assert scored.columns == {"feet missed": 1.0, "false points": 2.0}
