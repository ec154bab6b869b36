"""Goal feet in a picture: which can be found, which are excused, and what was found of them; the score of lesson 02."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.goalposts.challenge import judge
from nao_course.lessons.goalposts.measuring import Feet, match_feet
from nao_course.lessons.goalposts.scenes import FIELD, PostScene, picture_from
from nao_course.metrics import total
from nao_course.sim import NAO_V4, Reality

FEET = Feet(np.array([[50.0, 90.0], [200.0, 80.0]]), np.array([2.0, 2.5]), np.array([[-5.0, 70.0]]))
BLACK = np.zeros((240, 320), dtype=np.uint8)


def test_feet_are_matched_as_points_and_keep_their_distances():
    match = match_feet([(-5, 70), (50, 90)], FEET)
    assert match.found.tolist() == [True, False] and match.false == 0
    assert str(total([match, match])) == "2 of 4 feet found, 0 false"
    assert total([match, match]).distances.tolist() == [2.0, 2.5, 2.0, 2.5]


def test_a_missed_foot_and_a_false_point_cost_and_nothing_scores_nothing():
    scene = PostScene(np.dstack([BLACK] * 3), BLACK, FEET, NAO_V4.view("bottom"))
    assert judge(FEET.pixels, scene).score == judge([(50, 90), (200, 80)], scene).score == 1.0
    assert judge(np.zeros((0, 2)), scene).score == 0.0
    scored = judge([(50, 90), (120, 30), (130, 30), (-5, 70)], scene)
    assert scored.score == pytest.approx(2 * 1 / (2 + 3))
    assert scored.columns == {"feet missed": 1.0, "false points": 2.0}


def test_a_pictures_feet_are_its_true_posts_and_the_others_of_the_field_are_excused():
    scene = picture_from(Pose(0.4, 0.2, 0.0), Reality.clean(), np.random.default_rng(0))
    u, v = scene.feet.pixels.T.round().astype(int)
    assert len(u) == 2 and (scene.labels[v - 2, u] == 2).all() and (scene.labels[v + 6, u] != 2).all()
    assert len(scene.feet.excused) == len(FIELD.posts) - 2
    assert scene.feet.distances == pytest.approx(np.hypot(2.6, [-0.9, 0.5]))
