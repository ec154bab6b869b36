"""Lesson 02's pictures of posts, what is found of them, and its figures."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.lessons.goalposts import figures
from nao_course.lessons.goalposts.challenge import judge
from nao_course.lessons.goalposts.measuring import Feet, FootMatch, match_feet
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
from nao_course.metrics import total
from nao_course.sim import NAO_V4, CameraView, Reality, render


def test_pictures_by_distance_are_the_same_each_time_and_their_feet_are_the_true_posts():
    few = scenes_by_distance(2)
    assert all(np.array_equal(a.pixels, b.pixels) for a, b in zip(few, scenes_by_distance(2), strict=True))
    distances = np.concatenate([each.feet.distances for each in few])
    assert distances.max() > 5.0 and distances.min() > 0.5
    scene = picture_from(Pose(0.4, 0.2, 0.0), Reality.clean(), np.random.default_rng(0))
    u, v = scene.feet.pixels.T.round().astype(int)
    assert len(u) == 2 and (scene.labels[v - 2, u] == 2).all() and (scene.labels[v + 6, u] != 2).all()
    assert len(scene.feet.excused) == len(FIELD.posts) - 2
    assert scene.feet.distances == pytest.approx(np.hypot(2.6, [-0.9, 0.5]))


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


def test_a_robot_before_a_post_hides_its_foot_and_a_scene_at_another_size_has_eight_pixels_of_its_own():
    scene = picture_from(Pose(1.0, 0.7, 0.0), Reality.clean(), np.random.default_rng(0))
    before = scene.pixels.copy()
    u, v = scene.nearest.round().astype(int)
    shown = robot_before(scene.pixels, scene.nearest)
    assert np.ptp(shown[v - 5 : v + 5, u]) == 0 and np.array_equal(scene.pixels, before)
    view = NAO_V4.view("bottom", 0.0, HEAD_PITCH, (640, 480))
    large = PostScene.of(*render(FIELD, Pose(0.4, 0.2, 0.0), view, Reality.clean()), FIELD)
    assert large.match(large.feet.pixels + (0.0, 15.0)).found.all()
    assert not large.match(large.feet.pixels + (0.0, 17.0)).found.any()


FEET = Feet(np.array([[50.0, 90.0], [200.0, 80.0]]), np.array([2.0, 2.5]), np.array([[-5.0, 70.0]]))
BLACK = np.zeros((240, 320), dtype=np.uint8)


def test_feet_are_matched_with_their_distances_and_misses_and_false_points_cost_and_are_counted():
    match = match_feet([(-5, 70), (50, 90)], FEET)
    assert match.found.tolist() == [True, False] and match.false == 0
    assert str(total([match, match])) == "2 of 4 feet found, 0 false"
    assert total([match, match]).distances.tolist() == [2.0, 2.5, 2.0, 2.5]
    scene = PostScene(np.dstack([BLACK] * 3), BLACK, FEET, NAO_V4.view("bottom"))
    assert judge(FEET.pixels, scene).score == judge([(50, 90), (200, 80)], scene).score == 1.0
    assert judge(np.zeros((0, 2)), scene).score == 0.0
    scored = judge([(50, 90), (120, 30), (130, 30), (-5, 70)], scene)
    assert scored.score == pytest.approx(2 * 1 / (2 + 3))
    assert scored.columns == {"feet missed": 1.0, "false points": 2.0}
    assert figures.recall_counts(MATCHES) == {0: (1, 1), 1: (1, 2)}
    assert figures.precision_counts(MATCHES) == {0: (1, 2), 1: (1, 1)}
    assert figures.recall_counts(MATCHES, width=2.0) == {0: (2, 3)}
    at_the_edge = [FootMatch(np.array([True]), 0, np.array([6.0000000004]))]
    assert figures.recall_counts(at_the_edge) == figures.precision_counts(at_the_edge) == {5: (1, 1)}
    (row,) = figures.score_table({"forty": {"yours": MATCHES}}).rows
    assert row == ("forty", "yours", "2 of 3", "21% to 94%", "3")


SMALL = np.zeros((24, 32, 3), dtype=np.uint8)
MATCHES = [
    FootMatch(np.array([True, False]), 1, np.array([0.5, 1.5])),
    FootMatch(np.array([True]), 0, np.array([1.2])),
    FootMatch(np.zeros(0, dtype=bool), 2, np.zeros(0)),
]


def test_figures_say_feet_by_picture_what_a_column_has_and_where_the_height_meets_its_limits():
    drawing = figures.draw_feet({"left": SMALL, "right": SMALL}, [[(3, 4)], np.zeros((0, 2))])
    assert drawing.alt.endswith("left: 1 foot at (3, 4); right: 0 feet.") and drawing.photo
    with pytest.raises(ValueError, match="2 pictures need as many"):
        figures.draw_feet({"left": SMALL, "right": SMALL}, [[(3, 4)]])
    labels = np.array([[0, 2, 2, 2, 1, 3, 1, 1], [0] * 8, [2, 2, 0, 2, 0, 0, 1, 1]], dtype=np.uint8).T
    said = figures.draw_column(labels, [0, 1, 2], look_down=3).alt
    assert "Column 0: lowest yellow at 3, 2 of 3 pixels below it green, run of 3 pixels." in said
    assert "Column 1 has no yellow." in said
    assert "Column 2: lowest yellow at 3, 1 of 3 pixels below it green, run of 1 pixels." in said
    line = np.linspace(1, 8, 701)
    for tenth, said in ((40, "meets a tenth at 6.0 m."), (24, "stays above a tenth.")):
        drawing = figures.draw_heights([2.0], [110], (line, 240 / line), {"a fifth": 48, "a tenth": tenth})
        assert drawing.alt.endswith(f"to 8.0 m. Equation 2.1 meets a fifth at 5.0 m, {said}")
