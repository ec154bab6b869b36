"""The challenge of lesson 04: what is given, what is scored, and what is said of wrong answers."""

import numpy as np
import pytest

from nao_course.lessons.distance.challenge import CHALLENGE, judge
from nao_course.lessons.distance.challenge_figure import draw_tilted_lines
from nao_course.lessons.distance.lines import FEWEST, SHORTEST, line_picture_of
from nao_course.sim import Field
from tests.lessons.distance.own import OWN

SCENE = line_picture_of(48)


def test_the_truth_is_off_by_nothing_and_segments_are_long_enough_and_say_nothing_of_the_truth():
    true = SCENE.true_view
    assert judge((true.pitch, true.roll, 0.01), SCENE).score == pytest.approx(0.0)
    assert judge((true.pitch - np.radians(1), true.roll, 0.01), SCENE).score == pytest.approx(1.0)
    scored = judge(np.array([true.pitch, true.roll, 0.0]) + np.radians((1, -2, 0.5)), SCENE)
    assert scored.score == pytest.approx(1.0)
    columns = {"roll error": 2.0, "sigma": 0.5, "within 2 sigma": 100.0, "NEES": 4.0}
    assert scored.columns == pytest.approx(columns)
    for seed in CHALLENGE.seeds[:12]:
        scene = CHALLENGE.scene(seed)
        segments, view = CHALLENGE.given(scene)
        assert len(segments) >= FEWEST and view.k1 == 0.0
        assert view == scene.view and view != scene.true_view
        lengths = np.linalg.norm(segments[:, 2:] - segments[:, :2], axis=1)
        assert lengths.min() > SHORTEST - 2
        assert view.contains(segments.reshape(-1, 2) * 0.98 + 2).mean() > 0.9


def test_about_three_in_ten_pictures_have_a_segment_that_is_no_line_of_the_field():
    off = [(off_the_lines(line_picture_of(seed)) > 0.15).sum() for seed in range(1000, 1050)]
    assert 8 <= off.count(1) <= 22 and off.count(0) + off.count(1) == 50
    words = draw_tilted_lines(OWN["pixel_to_ground"]).alt  # the true camera sees segments at right angles
    assert "assumed pitch and roll: 25.0 degrees off" in words
    assert "true pitch and roll: 2.5 degrees off" in words


def off_the_lines(picture):
    """Return the distances of the segments' midpoints from the nearest line or circle of the field, m."""
    field, view = Field(2012, half=False), picture.true_view
    midpoints = picture.segments.reshape(-1, 2, 2).mean(axis=1)
    right, below = ((midpoints - view.centre) / view.focal).T
    rays = np.column_stack([np.ones(len(right)), -right, -below]) @ view.rotation.T
    points = picture.pose.to_parent(view.offset - view.height * rays[:, :2] / rays[:, 2:])
    lines = [np.linspace((x1, y1), (x2, y2), 300) for x1, y1, x2, y2 in field.lines]
    circles = [np.abs(np.hypot(*(points - (x, y)).T) - radius) for x, y, radius, *_ in field.arcs]
    apart = np.linalg.norm(points[:, None] - np.concatenate(lines), axis=2).min(axis=1)
    return np.minimum.reduce([apart, *circles])
