"""The lesson's detector by law, on the simulator's pictures, and on a real robot's."""

import numpy as np
import pytest

from nao_course.colours import GREEN, YELLOW
from nao_course.datasets import read_pictures
from nao_course.geometry import Pose
from nao_course.lessons.goalposts.measuring import Feet, match_feet
from nao_course.lessons.goalposts.scenes import PostScene, approach, match_scenes, scenes_by_distance
from nao_course.metrics import total
from nao_course.sim import Field, SimulatedNao, Truth, standard_scenes
from tests.lessons.every import label, own, text

OWN = own("02")


def find(picture, *limits):
    return OWN["find_goalposts"](label(picture, *limits))


def test_what_is_found_is_the_posts_front_about_four_centimetres_before_its_middle():
    for scene in approach([0.9, 1.2, 1.6, 2.0]):
        view, feet = scene.view, OWN["find_goalposts"](scene.labels)
        found = feet[np.hypot(*(feet - scene.nearest).T).argmin()]
        down = (np.array([found[1], scene.nearest[1]]) - view.centre[1]) / view.focal[1]
        near, far = view.height / np.tan(view.pitch + np.arctan(down))
        assert 0.02 <= far - near <= 0.06


@pytest.mark.parametrize(
    ("name", "feet", "found", "false"), [("scenes", 39, 36, 1), ("straightwalk", 47, 47, 0)]
)
def test_on_real_pictures_most_feet_are_found_and_one_point_is_false(data_dir, name, feet, found, false):
    matches = []
    for picture in read_pictures(name, data_dir):
        marked = np.array([(p.u, p.v) for p in picture.points if p.kind == "post_foot"]).reshape(-1, 2)
        there = Feet(marked, np.full(len(marked), np.nan), np.zeros((0, 2)))
        matches.append(match_feet(find(picture.pixels), there))
    match = total(matches)
    assert len(match.found) == feet and match.found.sum() >= found and match.false <= false


@pytest.mark.slow
def test_on_the_reporting_set_95_percent_of_the_feet_are_found():
    scenes = [PostScene.of(s.pixels, s.truth, Field(2012)) for s in standard_scenes("report")]
    match = total(scene.match(find(scene.pixels)) for scene in scenes)
    assert match.recall >= 0.95 and match.precision >= 0.95


def test_a_mirrored_picture_has_mirrored_feet_and_clusters_do_not_depend_on_the_order_of_points(rng):
    labels = rng.choice(4, (48, 64), p=[0.1, 0.6, 0.2, 0.1]).astype(np.uint8)
    labels[:30, [10, 11, 12, 50, 51]] = 2
    labels[30:] = 1
    feet, mirrored = (OWN["find_goalposts"](each) for each in (labels, labels[:, ::-1]))
    assert len(feet) == 2
    assert np.allclose(np.sort(feet[:, 0]), np.sort(63 - mirrored[:, 0]))
    for kind in range(4):
        for shape in ((1, 1), (3, 40), (48, 64)):
            assert OWN["find_goalposts"](np.full(shape, kind, dtype=np.uint8)).shape == (0, 2)
    points = rng.uniform(0, 100, (40, 2))

    def clusters(given):
        found = OWN["cluster_points"](given, 9.0)
        return found[np.lexsort(found.T)]

    assert np.allclose(clusters(points), clusters(rng.permutation(points)))
    assert np.allclose(clusters(points) + (5, -7), clusters(points + (5, -7)))


def test_one_candidate_of_the_lessons_scene_is_on_the_side_of_its_post():
    """It is the tenth at the right post, and it joins the cluster at the foot from 13 pixels on."""
    assert f"GREEN, YELLOW = {GREEN}, {YELLOW}" in text("02")
    nao = SimulatedNao(Field(2012), Pose(0.6, 0.5, -0.25), rng=41)
    picture = nao.take_picture("bottom")
    scene = PostScene.of(picture.pixels, Truth(nao).picture, Field(2012))
    candidates = OWN["post_candidates"](label(picture.pixels), 8, 10, 0.1)
    at_right = candidates[candidates[:, 0] > 160]
    assert len(candidates) == 20 and sorted(at_right[:, 1])[:2] == [121, 133]
    assert [len(OWN["cluster_points"](candidates, distance)) for distance in (2, 12, 13, 20)] == [3, 3, 2, 2]
    assert scene.match(OWN["cluster_points"](candidates, 20.0)).found.all()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("limits", "counts"), [((GREEN, YELLOW), (62, 3)), (((109.0, 144.0), (58.0, 62.0)), (10, 1))]
)
def test_with_the_limits_of_lesson_01_ten_feet_of_65_are_found(limits, counts):
    match = total(match_scenes(lambda picture: find(picture, *limits), scenes_by_distance()))
    assert (match.hits, match.false) == counts and len(match.found) == 65
