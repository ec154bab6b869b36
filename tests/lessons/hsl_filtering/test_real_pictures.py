"""Lesson 01 on real pictures: one where they are, the recorded numbers elsewhere."""

import json

import numpy as np
import pytest

from nao_course import datasets
from nao_course.lessons.hsl_filtering import draw_real_pictures, real_pictures
from tests.paths import PROJECT


def test_the_numbers_are_those_that_the_benchmark_recorded():
    recorded = json.loads((PROJECT / "benchmarks" / "results" / "colour_filter.json").read_text())
    assert list(real_pictures.FLOORS) == recorded["floors"]
    for name, parts in real_pictures.PARTS.items():
        assert list(parts) == recorded["real"][name]


def test_without_the_recordings_the_numbers_stand_in_their_place(monkeypatch):
    def nowhere(name):
        raise FileNotFoundError("not here")

    def never(*_):
        raise AssertionError("asked without a picture")

    monkeypatch.setattr(datasets, "read_pictures", nowhere)
    drawing = draw_real_pictures(never)
    assert "background labelled green 4.6, 1.4, 0.4, 0.1, 0.1 %" in drawing.alt
    assert [len(ax.lines) for ax in drawing.figure.axes] == [3, 3]  # two curves and the course's floor


def test_with_the_recordings_a_picture_is_labelled_without_and_with_the_floor(monkeypatch):
    class Real:
        pixels = np.full((6, 8, 3), 90, dtype=np.uint8)

    floors = []

    def label(picture, green, yellow, min_saturation):
        floors.append(min_saturation)
        return np.ones(picture.shape[:2], dtype=np.uint8)

    monkeypatch.setattr(datasets, "read_pictures", lambda name: [Real()] * 3)
    drawing = draw_real_pictures(label)
    assert floors == [0.0, 0.16] and "a real picture" in drawing.alt


@pytest.mark.parametrize("kind", ["png", "jpeg"])
def test_the_figure_of_the_numbers_is_the_same_each_time(kind):
    assert real_pictures.draw_real_floors().image(kind) == real_pictures.draw_real_floors().image(kind)
