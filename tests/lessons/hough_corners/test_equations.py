"""The equations of lesson 03, and the laws of its detector."""

import numpy as np
import pytest

from nao_course.lessons.hough_corners.scenes import goal_line_view, rows_between
from nao_course.sim import CameraView
from tests.lessons.every import own


@pytest.mark.asserts("eq-3-1")
def test_a_point_of_the_ground_is_seen_where_the_camera_projects_it(rng):
    for pitch, height, d in rng.uniform((0.0, 0.3, 0.8), (0.5, 0.6, 8.0), (40, 3)):
        view = CameraView((320, 240), 1.0, 0.8, height=height, pitch=pitch)
        ((_, v),) = view.project([(d, 0.0, 0.0)])
        below = height * np.cos(pitch) - d * np.sin(pitch)
        away = d * np.cos(pitch) + height * np.sin(pitch)
        assert v - (240 - 1) / 2 == pytest.approx(view.focal[1] * below / away)


@pytest.mark.asserts("eq-3-2")
def test_a_stretch_of_ground_takes_the_rows_between_its_projected_ends_and_the_texts_numbers_hold(rng):
    for pitch, height, d, length in rng.uniform((0.0, 0.3, 0.8, 0.02), (0.5, 0.6, 6.0, 1.0), (40, 4)):
        view = CameraView((320, 240), 1.0, 0.8, height=height, pitch=pitch)
        near, far = view.project([(d, 0.0, 0.0), (d + length, 0.0, 0.0)])[:, 1]
        assert rows_between(d, length, view) == pytest.approx(near - far)
    view = goal_line_view()
    assert view.focal[1] == pytest.approx(276, abs=0.5)
    assert np.degrees(view.pitch) == pytest.approx(15, abs=0.2)
    assert rows_between([1.0, 3.0], 0.05) == pytest.approx([5.3, 0.7], abs=0.05)
    assert rows_between(3.3, 0.7) == pytest.approx(7, abs=0.05)
    assert rows_between(5.3, 0.7) == pytest.approx(3, abs=0.05)


@pytest.mark.asserts("eq-3-3")
def test_segments_through_one_point_meet_there_whatever_their_directions(rng):
    for meeting in rng.uniform(50, 200, (40, 2)):
        first, second = rng.uniform(0, np.pi) + np.array([0.0, rng.uniform(0.3, np.pi - 0.3)])
        ends = [
            np.concatenate([meeting - 20 * way, meeting + 30 * way])
            for way in (np.array([np.cos(angle), np.sin(angle)]) for angle in (first, second))
        ]
        assert np.allclose(own("03")["segment_intersection"](*ends), meeting)
        assert np.allclose(own("03")["segment_intersection"](*ends[::-1]), meeting)


def test_the_reach_is_measured_along_the_segment_in_pixels_and_segments_nearly_parallel_do_not_meet():
    upright = np.array([50.0, 0.0, 50.0, 40.0])
    for length in (10.0, 100.0):
        level = np.array([46.0 - length, 20.0, 46.0, 20.0])
        assert own("03")["segment_intersection"](level, upright, 3.9) is None
        assert np.allclose(own("03")["segment_intersection"](level, upright, 4.1), (50, 20))
    level = np.array([0.0, 20.0, 100.0, 20.0])
    for degrees, meets in ((8.0, False), (12.0, True)):
        up = 50 * np.tan(np.radians(degrees))
        found = own("03")["segment_intersection"](level, np.array([0.0, 20 - up, 100.0, 20 + up]))
        assert (found is not None) == meets


OWN = own("03")


@pytest.mark.parametrize("label", range(4))
@pytest.mark.parametrize("shape", [(0, 0), (0, 5), (5, 0), (1, 1), (3, 40), (240, 320)])
def test_labels_of_one_kind_have_no_corners_whatever_their_size(label, shape):
    labels = np.full(shape, label, dtype=np.uint8)
    kept = OWN["erase_background"](labels)
    assert kept.shape == shape and kept.dtype == np.uint8
    assert (kept == labels).all() if label == 1 and shape[0] >= 7 else not kept.any()
    assert OWN["find_corners"](labels).shape == (0, 2)


@pytest.mark.parametrize("dtype", [np.uint8, np.int64, float])
def test_labels_of_any_type_of_number_give_the_same_corners(dtype):
    labels = np.ones((60, 80), dtype=np.uint8)
    labels[30:34, 10:70] = labels[30:58, 40:44] = 3
    found = OWN["find_corners"](labels.astype(dtype), 5, 15)
    assert len(found) >= 1 and np.array_equal(found, OWN["find_corners"](labels, 5, 15))
    for wrong in (np.zeros((4, 5, 3), dtype), np.zeros(6, dtype)):
        with pytest.raises(ValueError, match="shape|array|broadcast|dim|axes"):
            OWN["find_corners"](wrong)


def test_erasing_twice_is_erasing_once_and_kept_points_are_apart_and_near_every_point(rng):
    labels = rng.choice(4, (60, 50), p=[0.1, 0.7, 0.1, 0.1]).astype(np.uint8)
    once = OWN["erase_background"](labels, 4)
    assert np.array_equal(OWN["erase_background"](once, 4), once)
    order = rng.permutation(50)
    assert np.array_equal(OWN["erase_background"](labels[:, order], 4), once[:, order])
    assert ((once == labels) | (once == 0)).all()
    points = rng.uniform(0, 100, (60, 2))
    kept = OWN["remove_doubles"](points, 12.0)
    apart = np.linalg.norm(kept[:, None] - kept, axis=2) + 1e3 * np.eye(len(kept))
    assert apart.min() > 12.0
    assert (np.linalg.norm(points[:, None] - kept, axis=2).min(axis=1) <= 12.0).all()


def test_the_centre_line_of_two_edges_turns_with_them_and_the_order_of_pairs_decides_the_crossing_kept(rng):
    level = np.array([[10.0, 20.0, 50.0, 20.0], [20.0, 26.0, 60.0, 26.0]])
    for angle, *shift in rng.uniform((-np.pi, 0, 0), (np.pi, 90, 90), (20, 3)):
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        moved = (level.reshape(-1, 2) @ turn + shift).reshape(-1, 4)
        (found,) = OWN["merge_edges"](moved)
        assert np.allclose(found, (np.array([[10.0, 23.0], [60.0, 23.0]]) @ turn + shift).ravel())
    labels = np.ones((48, 64), dtype=np.uint8)
    labels[20:26, 5:45] = labels[20:46, 40:46] = 3
    found = OWN["find_corners"](labels, 5, 15)
    segments = OWN["hough_segments"](OWN["line_picture"](labels), 5, 15)
    pairs = [(first, second) for i, first in enumerate(segments) for second in segments[i + 1 :]]
    first = next(each for pair in pairs if (each := OWN["segment_intersection"](*pair)) is not None)
    assert np.allclose(found[0], first)
