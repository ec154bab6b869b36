"""The lesson's detector by law: pictures of any size and kind, mirrored ones, and what is no lines at all."""

import numpy as np
import pytest

from nao_course.exercises import load_definitions
from tests.paths import PROJECT

OWN = load_definitions(PROJECT / "solutions" / "03_hough_corners.ipynb")


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


def test_erasing_twice_is_erasing_once_and_the_order_of_columns_does_not_matter(rng):
    labels = rng.choice(4, (60, 50), p=[0.1, 0.7, 0.1, 0.1]).astype(np.uint8)
    once = OWN["erase_background"](labels, 4)
    assert np.array_equal(OWN["erase_background"](once, 4), once)
    order = rng.permutation(50)
    assert np.array_equal(OWN["erase_background"](labels[:, order], 4), once[:, order])
    assert ((once == labels) | (once == 0)).all()


def test_kept_points_are_apart_and_every_point_is_near_one(rng):
    points = rng.uniform(0, 100, (60, 2))
    kept = OWN["remove_doubles"](points, 12.0)
    apart = np.linalg.norm(kept[:, None] - kept, axis=2) + 1e3 * np.eye(len(kept))
    assert apart.min() > 12.0
    assert (np.linalg.norm(points[:, None] - kept, axis=2).min(axis=1) <= 12.0).all()


@pytest.mark.parametrize("wrong", [np.zeros((4, 5, 3), dtype=np.uint8), np.zeros(6, dtype=np.uint8)])
def test_what_is_no_picture_of_labels_is_refused(wrong):
    with pytest.raises(ValueError, match="shape|array|broadcast|dim|axes"):
        OWN["find_corners"](wrong)


def test_the_centre_line_of_two_edges_turns_and_moves_with_them(rng):
    level = np.array([[10.0, 20.0, 50.0, 20.0], [20.0, 26.0, 60.0, 26.0]])
    for angle, *shift in rng.uniform((-np.pi, 0, 0), (np.pi, 90, 90), (20, 3)):
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        moved = (level.reshape(-1, 2) @ turn + shift).reshape(-1, 4)
        (found,) = OWN["merge_edges"](moved)
        assert np.allclose(found, (np.array([[10.0, 23.0], [60.0, 23.0]]) @ turn + shift).ravel())


def test_the_order_of_pairs_decides_which_of_several_near_crossings_is_kept():
    labels = np.ones((48, 64), dtype=np.uint8)
    labels[20:26, 5:45] = labels[20:46, 40:46] = 3
    found = OWN["find_corners"](labels, 5, 15)
    segments = OWN["hough_segments"](OWN["line_picture"](labels), 5, 15)
    pairs = [(first, second) for i, first in enumerate(segments) for second in segments[i + 1 :]]
    first = next(each for pair in pairs if (each := OWN["segment_intersection"](*pair)) is not None)
    assert np.allclose(found[0], first)
