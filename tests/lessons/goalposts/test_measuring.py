"""Goal feet in a picture: which can be found, which are excused, and what of them was found."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.goalposts.measuring import Feet, match_feet
from nao_course.lessons.goalposts.scenes import FIELD, picture_from
from nao_course.metrics import total
from nao_course.sim import Reality


def test_feet_are_matched_as_points_and_keep_their_distances():
    feet = Feet(np.array([[100.0, 100.0], [40.0, 40.0]]), np.array([1.0, 2.0]), np.array([[-3.0, 50.0]]))
    match = match_feet([(-2, 50), (100, 100)], feet)
    assert match.found.tolist() == [True, False] and match.false == 0
    assert str(total([match, match])) == "2 of 4 feet found, 0 false"
    assert total([match, match]).distances.tolist() == [1.0, 2.0, 1.0, 2.0]


def test_a_pictures_feet_are_its_true_posts_and_the_others_of_the_field_are_excused():
    scene = picture_from(Pose(0.4, 0.2, 0.0), Reality.clean(), np.random.default_rng(0))
    u, v = scene.feet.pixels.T.round().astype(int)
    assert len(u) == 2 and (scene.labels[v - 2, u] == 2).all() and (scene.labels[v + 6, u] != 2).all()
    assert len(scene.feet.excused) == len(FIELD.posts) - 2
    assert scene.feet.distances == pytest.approx(np.hypot(2.6, [-0.9, 0.5]))
