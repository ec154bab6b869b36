"""Recorded labels: the lesson's pictures have them, other pictures do not, and own labels come first."""

import numpy as np
import pytest

from nao_course.colours import GREEN, YELLOW, mean_lightness
from nao_course.datasets.recorded_labels import RecordedLabels
from nao_course.exercises import load_definitions
from nao_course.exercises.earlier import EarlierNotUsable
from nao_course.geometry import Pose
from nao_course.lessons.goalposts import labels, or_recorded
from nao_course.sim import Field, SimulatedNao
from tests.paths import PROJECT

COLOURS = load_definitions(PROJECT / "solutions" / "01_hsl_filtering.ipynb")


def label(picture):
    return COLOURS["color_labels"](
        picture, GREEN, YELLOW, COLOURS["white_threshold"](mean_lightness(picture))
    )


@or_recorded
def unusable(picture):
    raise EarlierNotUsable("color_labels of your lesson 01 is not usable yet.")


def scene(x=0.6):
    return SimulatedNao(Field(2012), Pose(x, 0.5, -0.25), rng=41).take_picture("bottom").pixels


def test_an_unfinished_lesson_01_gets_the_references_labels(capsys):
    assert (unusable(scene()) == label(scene())).mean() > 0.999
    assert "have recorded labels" in capsys.readouterr().out
    unusable(scene())
    assert not capsys.readouterr().out, "the note is shown once"


def test_own_labels_come_first():
    own = or_recorded(lambda picture: np.zeros(picture.shape[:2]))
    assert not own(scene()).any()


def test_another_picture_has_none():
    for other in (scene(0.7), scene()[::2], scene().astype(float)):
        assert labels.recorded_labels(other) is None
    with pytest.raises(
        EarlierNotUsable, match="not usable yet. There are no recorded labels for this picture"
    ):
        unusable(scene(0.7))


def test_what_is_written_can_be_read(tmp_path):
    pictures = [scene(x) for x in (0.8, 0.9)]
    RecordedLabels(tmp_path / "labels.npz", lambda: pictures, "").record(label)
    written = RecordedLabels(tmp_path / "labels.npz", lambda: pictures, "")
    assert all((written.find(each) == label(each)).all() for each in pictures)


@pytest.mark.slow
def test_every_picture_of_the_lesson_has_the_references_labels():
    """If the simulator or the solution of lesson 01 changes, `record(label)` writes the file again."""
    for picture in labels.lesson_pictures():
        recorded = labels.recorded_labels(picture)
        assert recorded is not None and (recorded == label(picture)).mean() > 0.999
