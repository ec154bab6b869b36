"""A third kind of landmark: whatever depends on the kind refuses it until it is told what to do with it."""

from typing import get_args

import numpy as np
import pytest
from matplotlib.figure import Figure

from nao_course import slam
from nao_course.datasets.pictures import PointKind, shape_on_ground
from nao_course.field_slam.observation import observation, picture_covariance, radius_of
from nao_course.geometry import Pose
from nao_course.plotting import LANDMARK_MARKERS, draw_picture, plot_landmarks, plot_measurements
from nao_course.plotting.pictures import _MARKS
from nao_course.sim import Landmark, VisibleLandmark
from nao_course.sim.field import MarkKind, Shape
from nao_course.slam import Measurement


@pytest.fixture
def third(monkeypatch):
    """A measurement of the new kind."""
    monkeypatch.setattr(slam, "KINDS", (*slam.KINDS, "flag"))
    return Measurement(0.1, 2.0, "flag")


@pytest.mark.parametrize(
    "noise_of", [lambda seen: observation([seen]), lambda seen: picture_covariance([seen])]
)
def test_a_third_kind_has_neither_noise_nor_radius_until_somebody_says_which(third, noise_of):
    with pytest.raises(AssertionError, match="flag"):
        noise_of(third)
    assert [radius_of(kind) for kind in get_args(slam.LandmarkKind)] == [0.0, 0.05]
    with pytest.raises(AssertionError, match="flag"):
        radius_of(third.kind)


def test_a_third_kind_is_not_drawn_as_another_nor_left_out(third, monkeypatch):
    axes = Figure().add_subplot()
    with pytest.raises(ValueError, match="flag"):
        plot_landmarks(np.zeros((1, 2)), ["flag"], axes)
    with pytest.raises(KeyError, match="flag"):
        plot_measurements([third], Pose(), axes)
    mark = VisibleLandmark(Landmark(0.0, 0.0, "post", "post"), (5.0, 5.0), 1.0, 0.0, False)
    monkeypatch.delitem(_MARKS, "post")
    with pytest.raises(ValueError, match="post"):
        draw_picture(np.zeros((10, 10, 3), np.uint8), [mark])


def test_all_kinds_of_marks_have_a_marker_and_each_point_that_people_mark_is_of_one_shape():
    assert set(LANDMARK_MARKERS) == set(get_args(MarkKind)) == set(_MARKS) - {"hidden", "point"}
    assert set(slam.KINDS) == set(get_args(slam.LandmarkKind)) < set(LANDMARK_MARKERS)
    shapes = {kind: shape_on_ground(kind) for kind in get_args(PointKind)}
    assert shapes == {"X": "X", "L": "L", "T": "T", "post_foot": "post", "post_top": None}
    assert set(shapes.values()) - {None} == set(get_args(Shape))
    with pytest.raises(AssertionError, match="flag"):
        shape_on_ground("flag")
