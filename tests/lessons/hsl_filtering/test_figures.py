"""The figures of lesson 01: channels, hues on their circle, a stray pixel, and real pictures or what was recorded."""

import json

import numpy as np
import pytest

from nao_course import datasets
from nao_course.lessons.hsl_filtering import (
    draw_hsl,
    draw_hue_circle,
    draw_real_pictures,
    draw_stray_pixel,
    real_pictures,
)
from nao_course.plotting import painted
from tests.paths import PROJECT


def test_hues_are_drawn_on_their_circle_and_a_picture_beside_its_hue_saturation_and_lightness(rng):
    drawing = draw_hue_circle({"ball": [350, 5]}, {"ball": (348.0, 12.0)})
    (arc,) = [line for line in drawing.figure.axes[0].lines if len(line.get_xdata()) == 200]
    swept = np.degrees(arc.get_xdata())
    assert np.isclose(swept[0], 348) and np.isclose(swept[-1], 372) and (np.diff(swept) > 0).all()
    assert "limits from 348.0 to 12.0 degrees" in drawing.alt
    for wrong, said in (({}, "at least one entry"), ({"a": [1]}, "limits must have the keys")):
        with pytest.raises(ValueError, match=said):
            draw_hue_circle(wrong, {"b": (1.0, 2.0)})
    picture = rng.integers(0, 256, (6, 8, 3), dtype=np.uint8)
    drawing = draw_hsl(picture, np.full((6, 8), 120.0), np.full((6, 8), 0.25), np.full((6, 8), 80.0))
    assert len(drawing.figure.axes) == 4 and "120 degrees, 0.25 and 80" in drawing.alt
    shown = drawing.figure.axes[1].images[0].get_array()
    assert (shown[..., 1] > 200).all() and (shown[..., [0, 2]] == 0).all()
    with pytest.raises(ValueError, match="saturation must have shape"):
        draw_hsl(picture, np.zeros((6, 8)), np.zeros((6, 7)), np.zeros((6, 8)))


def test_a_stray_pixel_stands_between_before_and_after_and_among_all_others(rng):
    before, after = rng.integers(0, 4, (2, 12, 16))
    drawing = draw_stray_pixel(before, after, (5, 7), np.linspace(0, 1, 101), 0.56)
    left, middle, right = drawing.figure.axes
    assert np.array_equal(left.images[0].get_array(), painted(before))
    assert np.array_equal(middle.images[0].get_array(), painted(after))
    (mark,) = middle.lines
    assert (mark.get_xdata()[0], mark.get_ydata()[0]) == (7, 5)
    assert sum(bar.get_height() for bar in right.patches) == 101
    assert all(said in drawing.alt for said in ("56% of the carpet", "5 % to 95 %", "a median of 50 %"))


def test_without_the_recordings_the_numbers_that_the_benchmark_recorded_stand_in_their_place(monkeypatch):
    recorded = json.loads((PROJECT / "benchmarks" / "results" / "colour_filter.json").read_text())
    assert list(real_pictures.FLOORS) == recorded["floors"]
    assert all(list(parts) == recorded["real"][name] for name, parts in real_pictures.PARTS.items())

    def nowhere(name):
        raise FileNotFoundError("not here")

    def never(*_):
        raise AssertionError("asked without a picture")

    monkeypatch.setattr(datasets, "read_pictures", nowhere)
    drawing, again = draw_real_pictures(never), draw_real_pictures(never)
    assert "background labelled green 4.6, 1.4, 0.4, 0.1, 0.1 %" in drawing.alt
    assert [len(ax.lines) for ax in drawing.figure.axes] == [3, 3]  # two curves and the course's floor
    assert drawing.image("png") == again.image("png") and drawing.image("jpeg") == again.image("jpeg")


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
