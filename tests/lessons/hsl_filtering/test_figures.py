"""The figures of lesson 01: channels beside their picture, hues on their circle, a stray pixel."""

import numpy as np
import pytest

from nao_course.lessons.hsl_filtering import draw_hsl, draw_hue_circle, draw_stray_pixel
from nao_course.plotting import painted


def test_hues_are_drawn_on_their_circle_with_intervals_through_zero():
    drawing = draw_hue_circle({"ball": [350, 5]}, {"ball": (348.0, 12.0)})
    (arc,) = [line for line in drawing.figure.axes[0].lines if len(line.get_xdata()) == 200]
    swept = np.degrees(arc.get_xdata())
    assert np.isclose(swept[0], 348) and np.isclose(swept[-1], 372) and (np.diff(swept) > 0).all()
    assert "limits from 348.0 to 12.0 degrees" in drawing.alt
    for wrong in ({}, {"a": [1]}):
        with pytest.raises(ValueError, match=r"at least one entry|limits must have the keys"):
            draw_hue_circle(wrong, {"b": (1.0, 2.0)})


def test_a_picture_is_drawn_beside_its_hue_saturation_and_lightness(rng):
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
    assert (
        "56% of the carpet" in drawing.alt
        and "5 % to 95 %" in drawing.alt
        and "a median of 50 %" in drawing.alt
    )
