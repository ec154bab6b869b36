"""The panel that moves the head: the view shows the head and the pictures that its cameras take."""

import numpy as np
import pytest

from nao_course.lessons.meet_the_nao import HeadPanel


def test_the_sliders_move_the_head_and_both_pictures_follow():
    panel = HeadPanel()
    before = dict(panel.world.contents.pictures)
    assert sorted(before) == ["bottom", "top"]
    panel.set(yaw=40.0, pitch=-20.0)
    contents = panel.world.contents
    assert contents.head == pytest.approx(np.radians([40.0, -20.0]))
    for camera, pixels in contents.pictures.items():
        assert (pixels != before[camera]).mean() > 0.5
    assert "Head yaw 40" in panel.summary() and "bottom camera" in panel.summary()


def test_the_joints_reach_their_limits():
    panel = HeadPanel()
    panel.set(yaw=-119.5, pitch=29.5)
    assert panel.world.contents.head == pytest.approx(np.radians([-119.5, 29.5]))
    with pytest.raises(ValueError, match="yaw must be from"):
        panel.set(yaw=120.0)
