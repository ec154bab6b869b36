"""The live map: what it sends is what has changed, and a page that opens later gets everything."""

import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.plotting import STYLES
from nao_course.sim import Field
from nao_course.slam import Estimate, Measurement
from nao_course.widgets.vector_map import MapContents, ShortAxis, VectorMap

PATH = [Pose(0.1 * number, 0.0, 0.2) for number in range(6)]
ESTIMATE = Estimate(PATH[-1], np.diag([0.01, 0.02, 0.01]), [(3.0, 0.7)], [np.diag([0.01, 0.04])], ("post",))


@pytest.fixture
def live():
    chart = VectorMap(Field(), {"truth": "truth", "ekf": "your EKF"})
    chart.sent = []
    chart.widget.send = chart.sent.append
    return chart


class Page:
    """The browser's side: it keeps what it was sent."""

    def __init__(self):
        self.layers = {}

    def receive(self, message):
        for name, change in message["layers"].items():
            added = isinstance(change, dict)
            self.layers[name] = [*self.layers.get(name, []), *change["add"]] if added else change


def everything(live):
    live._answer(live.widget, {"ask": "everything"}, [])
    message = live.sent.pop()
    assert message["whole"]
    return message["layers"]


def test_of_a_path_that_grew_only_the_new_poses_are_sent_and_nothing_where_nothing_has_changed(live):
    live.update(MapContents({"truth": PATH[:3]}))
    live.update(MapContents({"truth": PATH[:5]}))
    assert live.sent[-1]["layers"] == {"path truth": {"add": [300, 0, 200, 400, 0, 200]}}
    contents = MapContents({"truth": PATH}, ESTIMATE, cells=np.array([(1.0, 1.0)]))
    live.update(contents)
    count = len(live.sent)
    assert live.update(contents) == 0 and len(live.sent) == count


def test_a_page_that_followed_all_changes_shows_what_a_new_page_gets(live):
    page, rng = Page(), np.random.default_rng(1)
    steps = [MapContents({"truth": PATH[:n], "ekf": PATH[:n]}, observer="ekf") for n in (1, 2, 5)]
    steps += [
        MapContents({"truth": PATH}, ESTIMATE, [Measurement(0.1, 1.0)], "truth", rng.random((3, 2))),
        MapContents({"truth": PATH}, cells=rng.random((4, 2)), view=(0.3, 0.5, 2.0)),
        MapContents({"truth": PATH[2:]}, ESTIMATE),
    ]
    for contents in steps:
        live.update(contents)
    for message in live.sent:
        page.receive(message)
    numbers = [message["number"] for message in live.sent]
    assert numbers == list(range(1, len(numbers) + 1))
    whole = everything(live)
    assert {name: page.layers.get(name, []) for name in whole} == whole


def test_measurements_points_and_view_are_placed_from_the_robot_that_measured(live):
    robot = Pose(1.0, 0.5, np.pi / 2)
    seen = [Measurement(0.0, 2.0, "post")], "truth", np.array([(1.0, 0.0)])
    live.update(MapContents({"truth": [robot]}, None, *seen, view=(0.1, 0.5, 2.0)))
    layers = live.sent[-1]["layers"]
    assert layers["rays"] == [1000, 500, 1000, 2500] and layers["seen"] == [1000, 2500, 1]
    assert layers["points"] == [1000, 1500]
    assert layers["view"] == [1000, 500, 1671, 500, 2000]
    live.update(MapContents({"truth": [robot]}, view=(0.1, 0.5, np.inf)))
    x0, y0, x1, y1 = live.widget.scene["bounds"]
    diagonal = np.hypot(x1 - x0, y1 - y0)
    assert live.sent[-1]["layers"]["view"][4] == pytest.approx(diagonal, abs=1), "not infinite"


def test_cells_are_under_everything_and_words_say_where_each_robot_is_and_invalid_ellipses_are_left_out(live):
    layers = live.widget.scene["layers"]
    assert layers[0]["name"] == "cells" and layers[0]["label"] == "frontiers"
    assert {each["label"]: each["colour"] for each in layers if each["kind"] == "path"} == {
        "truth": STYLES["truth"].colour,
        "your EKF": STYLES["ekf"].colour,
    }
    live.update(MapContents({"truth": PATH}, ESTIMATE, cells=np.array([(1.0, 1.0)])))
    assert live.sent[-1]["alt"] == live.alt
    assert "truth: (0.50, 0.00) m" in live.alt and "Landmarks on the map: 1." in live.alt
    unknown = Estimate(PATH[0], np.full((3, 3), np.nan), [(3.0, 0.7)], [np.eye(2)], ("post",))
    live.update(MapContents({"truth": PATH}, unknown))
    assert len(live.sent[-1]["layers"]["ellipses"]) == 5


def test_an_axis_that_is_too_small_is_sent_with_its_error_and_a_heading_as_a_wedge(live):
    at = [500, 0]
    for is_heading, name, other in ((False, "axis", "wedge"), (True, "wedge", "axis")):
        short = ShortAxis("across the heading", -1.2, 0.02, 0.05, is_heading)
        live.update(MapContents({"truth": PATH}, ESTIMATE, short=short))
        layers = everything(live)
        assert layers[name] == [*at, -1200, 20, 50] and layers[other] == []
    live.update(MapContents({"truth": PATH}, ESTIMATE))
    assert everything(live)["wedge"] == []
