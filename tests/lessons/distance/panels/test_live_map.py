"""The live map: it draws what it is given and forgets what it drew before."""

import numpy as np

from nao_course.geometry import Pose
from nao_course.lessons.distance.panels.live_map import LiveMap
from nao_course.sim import Field
from nao_course.slam import Estimate, Measurement
from nao_course.widgets.vector_map import MapContents


def test_the_live_map_of_a_whole_field_is_a_picture_that_forgets_what_it_drew_before():
    chart = LiveMap(Field(2025, half=False), {"truth": "truth", "odometry": "odometry", "ekf": "EKF"})
    empty = chart.draw(MapContents({}))
    assert empty.dtype == np.uint8 and empty.shape[2] == 3
    estimate = Estimate(Pose(), np.eye(3), np.array([[1.0, 1.0]]), np.eye(2)[None], ("post",))
    paths = {"truth": [Pose(), Pose(1, 0, 0)]}
    full = chart.draw(MapContents(paths, estimate, [Measurement(0.1, 1.0)], "truth"))
    assert not np.array_equal(full, empty)
    assert np.array_equal(chart.draw(MapContents({})), empty)


def test_the_legend_names_what_is_shown_and_nothing_else():
    chart = LiveMap(Field(), {"truth": "truth", "odometry": "odometry"})
    told = {"odometry": [Pose()]}
    for contents, names in (
        (MapContents(told), ["odometry"]),
        (MapContents({"truth": [Pose()], **told}), ["truth", "odometry"]),
        (MapContents(told, seen=[Measurement(0.1, 1.0)]), ["odometry", "measured from here"]),
    ):
        chart.draw(contents)
        (legend,) = chart._canvas.figure.legends
        assert [each.get_text() for each in legend.get_texts()] == names
