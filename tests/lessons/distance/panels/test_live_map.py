"""The live map: it draws what it is told and forgets what it drew before."""

import numpy as np

from nao_course.geometry import Pose
from nao_course.lessons.distance.panels.live_map import LiveMap
from nao_course.sim import Field
from nao_course.slam import Estimate, Measurement
from nao_course.widgets.vector_map import MapContents


def test_the_live_map_of_a_whole_field_is_a_picture():
    pixels = LiveMap(Field(2025, half=False), {"odometry": "odometry"}).draw(
        MapContents({"odometry": [Pose()]})
    )
    assert pixels.dtype == np.uint8
    assert pixels.shape[2] == 3


def test_the_live_map_forgets_what_it_drew_before():
    chart = LiveMap(Field(), {"truth": "truth", "odometry": "odometry", "ekf": "EKF"})
    empty = chart.draw(MapContents({}))
    estimate = Estimate(Pose(), np.eye(3), np.array([[1.0, 1.0]]), np.eye(2)[None], ("post",))
    full = chart.draw(
        MapContents({"truth": [Pose(), Pose(1, 0, 0)]}, estimate, [Measurement(0.1, 1.0)], "truth")
    )
    assert not np.array_equal(full, empty)
    assert np.array_equal(chart.draw(MapContents({})), empty)


def test_the_legend_names_what_is_shown_and_nothing_else():
    chart = LiveMap(Field(), {"truth": "truth", "odometry": "odometry"})

    def named(contents):
        chart.draw(contents)
        (legend,) = chart._canvas.figure.legends
        return [text.get_text() for text in legend.get_texts()]

    told = {"odometry": [Pose()]}
    first = chart.draw(MapContents(told))
    assert named(MapContents(told)) == ["odometry"]
    assert named(MapContents({"truth": [Pose()], **told})) == ["truth", "odometry"]
    assert named(MapContents(told, seen=[Measurement(0.1, 1.0)])) == ["odometry", "measured from here"]
    assert np.array_equal(chart.draw(MapContents(told)), first)
