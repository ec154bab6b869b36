"""Pictures of posts: from where they say, the same each time; and the height that equation 2.1 gives."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.goalposts.scenes import (
    FIELD,
    HEAD_PITCH,
    PostScene,
    approach,
    picture_from,
    post_height,
    robot_before,
    scenes_by_distance,
)
from nao_course.sim import NAO_V4, CameraView, Reality, render


def test_pictures_by_distance_are_the_same_each_time_and_reach_from_near_to_far():
    few = scenes_by_distance(2)
    assert all(np.array_equal(a.pixels, b.pixels) for a, b in zip(few, scenes_by_distance(2), strict=True))
    distances = np.concatenate([each.feet.distances for each in few])
    assert distances.max() > 5.0 and distances.min() > 0.5


def test_a_robot_that_approaches_sees_the_foot_sink_until_it_leaves_the_picture_where_the_lesson_says():
    rows = [each.nearest[1] if len(each.feet.pixels) else np.inf for each in approach([2.0, 1.2, 0.7, 0.6])]
    assert rows == sorted(rows) and rows[2] < 240 and rows[3] == np.inf
    assert [each.feet.distances.min() for each in approach([2.0, 1.2])] == pytest.approx([2.0, 1.2])
    view = NAO_V4.view("bottom", 0.0, HEAD_PITCH)
    assert np.degrees(view.pitch + view.vfov / 2) == pytest.approx(38.6, abs=0.1)
    assert [len(each.feet.pixels) for each in approach([0.66, 0.62])] == [1, 0]


@pytest.mark.asserts("eq-2-1")
def test_a_posts_height_is_the_difference_of_foot_and_top_as_the_camera_projects_them(rng):
    for pitch, height, distance in rng.uniform((-0.2, 0.3, 1.5), (0.5, 1.2, 9.0), (40, 3)):
        view = CameraView((320, 240), 1.0, 0.8, height=height, pitch=pitch)
        (_, foot), (_, top) = view.project([(distance, 0.0, 0.0), (distance, 0.0, 0.8)])
        assert post_height(distance, view, 0.8) == pytest.approx(foot - top)
    view = CameraView((320, 240), 1.0, 0.8, height=0.5, pitch=0.0)  # a level camera sees f h / d
    assert post_height([1.0, 4.0], view, 0.8) == pytest.approx(view.focal[1] * 0.8 / np.array([1.0, 4.0]))
    for scene in approach([3.0, 5.0]):
        distance = scene.feet.distances.min() - scene.view.offset[0]
        assert scene.post_pixels() == pytest.approx(post_height(distance, scene.view), rel=0.06)


def test_a_robot_before_a_post_hides_its_foot_and_leaves_the_picture_as_it_was():
    scene = picture_from(Pose(1.0, 0.7, 0.0), Reality.clean(), np.random.default_rng(0))
    before = scene.pixels.copy()
    u, v = scene.nearest.round().astype(int)
    shown = robot_before(scene.pixels, scene.nearest)
    assert np.ptp(shown[v - 5 : v + 5, u]) == 0 and np.array_equal(scene.pixels, before)


def test_a_scene_at_another_size_has_eight_pixels_of_its_own():
    view = NAO_V4.view("bottom", 0.0, HEAD_PITCH, (640, 480))
    large = PostScene.of(*render(FIELD, Pose(0.4, 0.2, 0.0), view, Reality.clean()), FIELD)
    assert large.match(large.feet.pixels + (0.0, 15.0)).found.all()
    assert not large.match(large.feet.pixels + (0.0, 17.0)).found.any()
