"""Recorded labels: every picture of the lesson has those of the solution, and an unfinished lesson 01 gets them."""

import numpy as np
import pytest

from nao_course.colours import GREEN, YELLOW, mean_lightness
from nao_course.exercises import load_definitions
from nao_course.exercises.earlier import EarlierNotUsable
from nao_course.lessons.hough_corners import goal_line_left, or_recorded
from nao_course.lessons.hough_corners.labels import DISTANCES, lesson_pictures, recorded_labels
from tests.paths import PROJECT

COLOURS = load_definitions(PROJECT / "solutions" / "01_hsl_filtering.ipynb")


def label(picture):
    return COLOURS["color_labels"](
        picture, GREEN, YELLOW, COLOURS["white_threshold"](mean_lightness(picture))
    )


def test_every_picture_has_the_labels_of_the_solution():
    for picture in lesson_pictures():
        assert (recorded_labels(picture) == label(picture)).mean() > 0.999


def test_the_walk_from_the_goal_line_uses_them():
    def keep(labels, run):
        return labels

    recorded = goal_line_left(DISTANCES, recorded_labels, keep)
    assert recorded[0] == pytest.approx(goal_line_left(DISTANCES, label, keep)[0], abs=0.05)


def test_an_unfinished_lesson_01_gets_them_whatever_beta_is(capsys):
    @or_recorded
    def unusable(picture, beta=120.0):
        raise EarlierNotUsable("color_labels of your lesson 01 is not usable yet.")

    picture = lesson_pictures()[0]
    assert (unusable(picture) == unusable(picture, 60.0)).all()
    assert capsys.readouterr().out.count("have recorded labels") == 1
    with pytest.raises(EarlierNotUsable, match="no recorded labels for this picture"):
        unusable(np.zeros_like(picture))
