"""The live map in a real browser: it draws what Python sends, also on a page that is opened later."""

from functools import partial

import numpy as np
import pytest

from nao_course.films import script
from nao_course.geometry import Pose
from nao_course.sim import Field
from nao_course.slam import Estimate
from nao_course.widgets.vector_map import MapContents, VectorMap
from tests.browser.lab import wait_for
from tests.browser.notebook_page import run_notebook, screenshot

pytestmark = pytest.mark.browser

CARPET = [0xB5, 0xD1, 0xAC]
MAKE = """import numpy as np
from nao_course.geometry import Pose
from nao_course.sim import Field
from nao_course.slam import Estimate, Measurement
from nao_course.widgets.vector_map import MapContents, VectorMap

live = VectorMap(Field(), {"truth": "truth", "ekf": "your EKF"})
live.widget"""
DRIVE = """path = [Pose(0.5 + 0.05 * step, 0.0, 0.1 * step) for step in range(20)]
estimate = Estimate(path[-1], np.eye(3) / 50, [(3.0, 0.7)], [np.eye(2) / 50], ("post",))
for step in range(1, 20):
    live.update(MapContents({"truth": path[:step]}, observer="truth", cells=np.array([(1.0, 1.0)])))
live.update(MapContents({"truth": path, "ekf": path}, estimate, [Measurement(0.1, 1.0)], "ekf", view=(0.0, 0.5, 2.0),
                        cells=np.array([(1.0, 1.0)])))"""
SURE = """estimate = Estimate(path[-1], np.eye(3) / 2000, [], [])
live.update(MapContents({"truth": path, "ekf": path}, estimate, (), "ekf"))"""
AGAIN = "live.widget"
SHORT = """from nao_course.widgets.vector_map import ShortAxis
true = Pose(1.49, 0.03, 2.0)
axis, heading = ShortAxis("across", 0.6, 0.02, 0.05), ShortAxis("of heading", 1.9, 0.02, 0.1, True)
estimate = Estimate(path[-1], np.diag([0.02, 0.02, 0.01]) ** 2, [], [])
live.update(MapContents({"truth": [true], "ekf": path}, estimate, (), "ekf", short=axis))"""
HEADING = """live.update(MapContents({"truth": [true], "ekf": path}, estimate, (), "ekf", short=heading))"""
AWAY = """live.update(MapContents({"truth": [true], "ekf": [*path, Pose(2.0, 6.1, 1.5)]}, None, (), "ekf"))"""
# The part of a canvas that has the colour of the axis that is too small
RED = """canvas => { const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
  let red = 0;
  for (let i = 0; i < data.length; i += 4) red += data[i] > 150 && data[i + 1] < 30 && data[i + 2] < 60;
  return red / data.length * 4; }"""
# The colour of a pixel of the map by its position on the field, mm
COLOUR = """([number, x, y]) => {
  const canvas = document.querySelectorAll('.nao-map-canvas')[number], ratio = devicePixelRatio || 1;
  const own = canvas.getBoundingClientRect(), scale = (own.width - 34 - 14) / 4400;
  const at = [34 + (x + 700) * scale, 8 + (2700 - y) * scale].map(each => Math.round(each * ratio));
  return [...canvas.getContext('2d').getImageData(...at, 1, 1).data].slice(0, 3);
}"""
# The colour of a pixel of the lens below its centre, px; the ellipse's half axis of 5.5 cm is 32 px
IN_THE_LENS = """below => {
  const canvas = document.querySelector('.nao-map-lens canvas'), ratio = devicePixelRatio || 1;
  return [...canvas.getContext('2d').getImageData(58 * ratio, (58 + below) * ratio, 1, 1).data].slice(0, 3);
}"""
# Shows a map, and counts how often it is drawn and how often its canvases get a size
COUNT = """scene => {
  const live = window.live = new NaoLive.LiveMap(document.body, scene), draw = live.map.draw;
  window.drawn = window.sized = 0;
  live.map.draw = function() { drawn += 1; draw.call(this); };
  new MutationObserver(all => { sized += all.length; })
    .observe(document.body, { subtree: true, attributeFilter: ["width"] });
}"""


def test_a_live_map_shows_what_python_sends_on_every_page(lab, page):
    run_notebook(lab, page, "live.ipynb", MAKE, DRIVE, AGAIN)
    assert wait_for(lambda: page.locator(".nao-map-canvas").count() == 2)
    for number in (0, 1):
        frontier, grass, post = (
            partial(page.evaluate, COLOUR, [number, *place])
            for place in ((1000, 1000), (2000, -2300), (3000, 700))
        )
        wait_for(lambda frontier=frontier: frontier() != CARPET, "a frontier")
        assert grass() == CARPET and post() == [0x0B, 0x5F, 0xA5]  # a landmark of the estimate
    legend = page.locator(".nao-map-legend").last.inner_text()
    for name in ("frontiers", "camera's view", "95 % ellipse", "truth", "your EKF", "true lines and posts"):
        assert name in legend
    assert "estimated goal posts" in legend and "corners" not in legend  # the map has one post
    assert page.locator(".nao-map-lens:visible").count() == 0  # the ellipse is large enough without
    assert "truth: (1.45, 0.00) m" in page.locator(".nao-map-canvas").last.get_attribute("aria-label")
    screenshot(page, "live_map")
    run_notebook(lab, page, "sure.ipynb", MAKE, DRIVE, SURE)
    page.locator(".nao-map-lens").wait_for(timeout=240_000)
    assert page.locator(".nao-map-lens").inner_text() == "10 cm around the estimate, enlarged"
    assert page.evaluate(IN_THE_LENS, 25) != [0xB5, 0xD1, 0xAC] == page.evaluate(IN_THE_LENS, 45)


def test_the_lens_shows_the_axis_or_heading_that_is_too_small_and_an_arrow_the_robot_outside(lab, page):
    lens = page.locator(".nao-map-lens")
    for number, (cells, words) in enumerate(
        (([SHORT], "10 cm around the estimate, enlarged"), ([SHORT, HEADING], "; angles 10 × as wide"))
    ):
        run_notebook(lab, page, f"short{number}.ipynb", MAKE, DRIVE, *cells)
        lens.wait_for(timeout=240_000)
        wait_for(lambda: lens.locator("canvas").evaluate(RED) > 0.003, "the axis in the lens")
        assert lens.inner_text().endswith(words)
        screenshot(page, f"live_map_short_{number}")
    run_notebook(lab, page, "away.ipynb", MAKE, DRIVE, SHORT, AWAY)
    page.locator(".nao-map-canvas").wait_for(timeout=240_000)
    screenshot(page, "live_map_away")
    # Above the field, whose upper edge is at 2.7 m, and below its middle
    assert (
        page.evaluate(COLOUR, [0, 2000, 2600]) == [0x0B, 0x5F, 0xA5] != page.evaluate(COLOUR, [0, 2000, 2000])
    )


def test_messages_of_one_frame_are_drawn_once_a_movement_30_times_a_second_and_no_canvas_gets_its_size_again(
    context,
):
    live, messages = VectorMap(Field(), {"truth": "truth", "ekf": "your EKF"}), []
    live.widget.send = messages.append
    path = [Pose(0.05 * step, 0.0, 0.0) for step in range(4)]
    for step in range(1, 5):
        estimate = Estimate(path[step - 1], np.eye(3) / 2000, [], [])
        live.update(MapContents({"truth": path[:step], "ekf": path[:step]}, estimate, (), "ekf"))
    page = context.new_page()
    page.clock.install()
    page.set_content("<body></body>")
    page.add_script_tag(content=f"{script('map', 'live')}; Object.assign(window, {{ NaoLive }})")
    page.evaluate(COUNT, live.widget.scene)
    page.evaluate("message => live.receive({...message, whole: true})", messages[0])
    page.clock.run_for(1000)
    assert page.locator(".nao-map-lens:visible").count() == 1
    page.evaluate("drawn = sized = 0")
    page.evaluate("messages => messages.forEach(each => live.receive(each))", messages[1:3])
    page.clock.run_for(20)
    assert page.evaluate("drawn") == 1
    page.clock.run_for(1000)
    page.evaluate("drawn = 0")
    page.evaluate("message => live.receive(message)", messages[3])
    page.clock.run_for(1000)
    assert 4 <= page.evaluate("drawn") <= 6  # a movement takes 150 ms
    assert page.evaluate("sized") == 0
    page.close()
