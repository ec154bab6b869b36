"""Recorded labels of lessons 02 and 03: those of the solution for their pictures, none for others, own ones first."""

import numpy as np
import pytest

from nao_course.datasets.recorded_labels import RecordedLabels
from nao_course.exercises.earlier import EarlierNotUsable
from nao_course.geometry import Pose
from nao_course.lessons.goalposts import labels as two
from nao_course.lessons.hough_corners import labels as three
from nao_course.sim import Field, SimulatedNao
from tests.lessons.every import label


def scene(x=0.6):
    """Return a picture of lesson 02, or another one beside it."""
    return SimulatedNao(Field(2012), Pose(x, 0.5, -0.25), rng=41).take_picture("bottom").pixels


@pytest.mark.parametrize("labels", [pytest.param(two, marks=pytest.mark.slow), three], ids=["02", "03"])
def test_every_picture_of_the_lesson_has_the_solutions_labels(labels):
    """If the simulator or the solution of lesson 01 changes, `record(label)` writes the file again."""
    for picture in labels.lesson_pictures():
        assert (labels.recorded_labels(picture) == label(picture)).mean() > 0.999


@pytest.mark.parametrize(
    ("labels", "picture"), [(two, scene), (three, lambda: three.lesson_pictures()[0])], ids=["02", "03"]
)
def test_an_unfinished_lesson_01_gets_them_with_one_note_and_own_labels_come_first(labels, picture, capsys):
    @labels.or_recorded
    def unusable(pixels, beta=120.0):
        raise EarlierNotUsable("color_labels of your lesson 01 is not usable yet.")

    known = picture()
    assert (unusable(known) == label(known)).mean() > 0.999
    assert (unusable(known, 60.0) == unusable(known)).all()
    assert capsys.readouterr().out.count("recorded labels") == 1
    for other in (scene(0.7), known[::2], known.astype(float)):
        assert labels.recorded_labels(other) is None
    with pytest.raises(EarlierNotUsable, match="no recorded labels"):
        unusable(scene(0.7))
    assert not labels.or_recorded(lambda pixels: np.zeros(pixels.shape[:2]))(known).any()


def test_what_is_written_can_be_read(tmp_path):
    pictures = [scene(x) for x in (0.8, 0.9)]
    RecordedLabels(tmp_path / "labels.npz", lambda: pictures, "").record(label)
    written = RecordedLabels(tmp_path / "labels.npz", lambda: pictures, "")
    assert all((written.find(each) == label(each)).all() for each in pictures)
