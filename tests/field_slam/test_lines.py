"""Lines and corners are read from a rendered picture."""

from dataclasses import replace

import numpy as np
import pytest

from nao_course.field_slam.lines import corners_of_lines, read_lines
from nao_course.geometry import Pose
from nao_course.sim import Field, Reality, render
from tests.field_slam.test_observation import VIEW


def test_lines_and_corners_of_a_rendered_picture_are_where_they_are():
    pose = Pose(1.3, 0.2, 0.4)
    picture, truth = render(Field(2012), pose, VIEW, Reality.lab(3), np.random.default_rng(3))
    lines = read_lines(picture, VIEW)
    corners = corners_of_lines(lines, VIEW)
    marks = np.array([mark.pixel for mark in truth.landmarks if mark.landmark.kind == "corner"])
    off = np.linalg.norm(corners[:, None] - marks, axis=2).min(axis=1)
    assert len(corners) >= 1 and off.max() < 1.5


@pytest.mark.parametrize(
    ("way", "corners"),
    [
        ([(0.0, 0.0), (0.6, 0.0)], 1),  # an L
        ([(-0.6, 0.0), (0.6, 0.0)], 1),  # a T
        ([(-0.6, 0.0), (-0.3, 0.0)], 0),  # too far from it
        ([(-0.6, 0.3), (0.6, 0.3)], 0),  # a crossing
    ],
)
def test_lines_that_meet_at_an_end_are_a_corner(way, corners):
    assert len(corners_of_lines(ground_lines([(0.0, 0.0), (0.0, 0.6)], way), VIEW)) == corners


def ground_lines(*ends):
    """Lines between points about a place 1.4 m ahead of the camera, as a picture without the lens shows them."""
    there = Pose(1.4 * np.cos(VIEW.yaw), 1.4 * np.sin(VIEW.yaw), VIEW.yaw)
    return replace(VIEW, k1=0.0).project(there.to_parent(np.concatenate(ends))).reshape(-1, 4)
