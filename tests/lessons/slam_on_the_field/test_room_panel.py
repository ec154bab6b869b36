"""The lesson's drive in the room: the true robot always, and the student's filter beside it."""

import numpy as np
import pytest

from nao_course.lessons.slam_on_the_field import RoomPanel
from nao_course.lessons.slam_on_the_field.one_drive import the_drive
from nao_course.lessons.slam_on_the_field.worlds import LANDMARKS


def test_the_filter_drives_beside_the_true_robot(own):
    panel = RoomPanel(own["EkfSlam"])
    last = len(the_drive().log) - 1
    panel.set(step=last)
    contents = panel.world.contents
    assert contents.truth.as_array() == pytest.approx(the_drive().poses[last])
    apart = np.hypot(*(contents.estimate.pose.as_array() - contents.truth.as_array())[:2])
    assert apart < 0.1 and f"Off by {100 * apart:.0f} cm" in panel.summary()
    assert [len(contents.paths[source]) for source in ("truth", "ekf")] == [last + 1] * 2
    ends = {
        source: [ray.point[:2] for ray in contents.rays if ray.source == source]
        for source in ("truth", "ekf")
    }
    assert len(ends["truth"]) == len(ends["ekf"]) > 0
    for end in ends["truth"]:
        assert np.linalg.norm(LANDMARKS - end, axis=1).min() < 1e-9
    # Each measurement lies within a metre of one of the landmarks.
    for end in ends["ekf"]:
        assert np.linalg.norm(LANDMARKS - end, axis=1).min() < 1.0


def test_an_unfinished_filter_leaves_the_true_robot():
    def unfinished(*arguments, **options):
        raise NotImplementedError

    panel = RoomPanel(unfinished)
    assert panel.world.contents.truth is not None and panel.world.contents.estimate is None
    assert "Finish exercise 11.5" in panel.summary()
