"""The posts panel: its values reach the student's functions, and what is missing is named."""

import numpy as np
import pytest

from nao_course.lessons.goalposts.measuring import Feet
from nao_course.lessons.goalposts.panel import PostPanel, mark_feet
from nao_course.lessons.goalposts.scenes import PostScene
from nao_course.sim import NAO_V4
from tests.lessons.every import blank

LABELS = np.zeros((24, 32), dtype=np.uint8)


def scene(foot):
    feet = Feet(np.array([foot], dtype=float), np.array([1.0]), np.zeros((0, 2)))
    return PostScene(np.full((24, 32, 3), 90, dtype=np.uint8), LABELS, feet, NAO_V4.view("bottom"))


SCENES = {"a": scene((5, 6)), "b": scene((30, 20))}


def panel(
    candidates=lambda *given: np.array([[5.0, 6.0], [7.0, 6.0]]),
    cluster=lambda points, gap: points[:1],
    scenes=SCENES,
):
    return PostPanel(scenes, lambda pixels: LABELS, candidates, cluster)


def test_every_slider_reaches_its_function_and_what_was_found_in_the_chosen_scene_is_said():
    got = []
    shown = panel(
        lambda labels, *values: got.append(values) or np.zeros((0, 2)),
        lambda points, gap: got.append(gap) or points,
    )
    shown.set(min_green=3, look_down=7, min_height=0.25, max_distance=31)
    assert got[-2:] == [(3, 7, 0.25), 31]
    shown = panel()
    assert "2 candidates in 1 cluster: 1 of 1 foot found, 0 false." in shown.summary()
    shown.set(scene="b")
    assert "0 of 1 foot found, 1 false." in shown.summary()
    shown.set(min_green=20, look_down=10)
    assert (
        "No column can pass: of the 10 pixels below the foot, 20 would have to be green." in shown.summary()
    )


def test_the_true_foot_is_shown_once_feet_are_found_and_marks_lie_at_their_pixels_on_a_copy():
    def dark(shown):
        return (shown.shown.pictures["What you find"] == 0).all(axis=2).any()

    assert dark(panel()) and not dark(panel(cluster=blank))
    picture = np.full((240, 320, 3), 90, dtype=np.uint8)
    marked = mark_feet(picture, [(100, 50)], [(200, 150)], [(200, 50)])
    assert marked.shape == (480, 640, 3) and (picture == 90).all() and (marked[101, 201] == 90).all()
    v, u = np.nonzero((marked != 90).any(axis=2))
    for (column, row), part in {(100, 50): u < 300, (200, 150): (u > 300) & (v > 200)}.items():
        assert (u[part].mean(), v[part].mean()) == pytest.approx((2 * column + 0.5, 2 * row + 0.5), abs=0.6)
