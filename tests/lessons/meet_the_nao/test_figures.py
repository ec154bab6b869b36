"""The figures of lesson 00, the same at every run, and the panel that moves the head."""

import numpy as np
import pytest

from nao_course.lessons.meet_the_nao import HeadPanel, draw_cameras, draw_frames, draw_ground_steps
from nao_course.sim import NAO_V4
from tests.drawings import assert_same_bytes_with_words
from tests.plotting.examples import walked

VIEW = NAO_V4.view("bottom", pitch=float(np.radians(-31.0)))


@pytest.mark.slow
@pytest.mark.parametrize(
    "make", [draw_frames, lambda: draw_cameras(walked()[0]), lambda: draw_ground_steps(VIEW)]
)
def test_the_same_drawing_is_the_same_bytes_with_its_words(make):
    assert_same_bytes_with_words(make)


def test_a_step_on_the_ground_is_as_many_pixels_as_its_ends_are_apart():
    (curve, *_), far = draw_ground_steps(VIEW).figure.axes[0].lines, 2.0
    rows = VIEW.project([[far, 0.0], [far + 0.1, 0.0]])[:, 1]
    assert np.interp(far, *curve.get_data()) == pytest.approx(rows[0] - rows[1])
    assert "3.1 at 2 m" in draw_ground_steps(VIEW).alt


def test_the_sliders_move_the_head_to_its_limits_and_both_pictures_follow():
    panel = HeadPanel()
    before = dict(panel.world.contents.pictures)
    assert sorted(before) == ["bottom", "top"]
    panel.set(yaw=40.0, pitch=-20.0)
    contents = panel.world.contents
    assert contents.head == pytest.approx(np.radians([40.0, -20.0]))
    assert all((pixels != before[camera]).mean() > 0.5 for camera, pixels in contents.pictures.items())
    assert "Yaw to the left 40" in panel.summary() and "40° to the left" in panel.summary()
    assert "ahead" not in panel.summary()
    panel.set(yaw=-119.5, pitch=29.5)
    assert panel.world.contents.head == pytest.approx(np.radians([-119.5, 29.5]))
    with pytest.raises(ValueError, match="yaw must be from"):
        panel.set(yaw=120.0)
