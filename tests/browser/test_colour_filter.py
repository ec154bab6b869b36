"""The filter panel in a real JupyterLab in a real browser: mouse and keys move it, and it keeps up."""

import re

import pytest

from tests.browser.filter_page import LABEL, FilterPage
from tests.browser.lab import wait_for
from tests.browser.notebook_page import screenshot

pytestmark = pytest.mark.browser


SLOW = "import time\ntaken = []\n" + LABEL.replace(
    "    mean",
    "    taken.append(beta); time.sleep(0.4); print(len(taken), f'pictures, beta {beta:.0f}')\n    mean",
)


def test_a_slider_is_dragged_and_labels_and_numbers_follow(lab, page):
    panel = FilterPage(lab, page, "drag.ipynb")
    screenshot(page, "filter_panel")
    picture, numbers = panel.source(), panel.numbers()
    assert len(panel.updates()) > 2  # while it was dragged
    assert panel.source() != picture
    assert panel.numbers() != numbers
    assert panel.value("light") > 1.1
    panel.expect(f"light {panel.value('light'):.2f}")
    screenshot(page, "filter_panel_dragged")


def test_a_pixel_is_clicked_and_added_and_the_arc_and_the_sliders_jump(lab, page):
    panel = FilterPage(lab, page, "pixel.ipynb")
    pad = panel.root.locator(".nao-pad-over")
    drawn = pad.bounding_box()
    pad.click(position={"x": drawn["width"] * 150 / 320, "y": drawn["height"] * 180 / 240})
    wait_for(lambda: "hue 1" in panel.words(), "a pixel of grass")
    circle = panel.root.locator("img").nth(3).get_attribute("src")
    panel.root.locator(".nao-do-to-yellow").click()
    wait_for(lambda: panel.value("yellow-high") > 100, "yellow up to the grass")
    wait_for(lambda: panel.root.locator("img").nth(3).get_attribute("src") != circle, "another circle")
    screenshot(page, "filter_panel_pixel")
    before = panel.words()
    pad.focus()
    page.keyboard.press("ArrowLeft")
    wait_for(lambda: panel.words() != before, "the pixel at its left")


def test_a_slow_filter_ends_at_the_newest_value_and_skips_most_of_those_before(lab, page):
    panel = FilterPage(lab, page, "slow.ipynb", SLOW)
    panel.drag("beta", 120, 100, pause=20)
    page.mouse.up()
    last = f"beta {panel.value('beta'):.0f}"
    page.wait_for_timeout(1500)
    assert last in panel.words()
    assert "This is slow." in panel.words()
    pictures = int(re.search(r"(\d+) pictures", panel.words())[1])
    print(f"\n{pictures} pictures for 100 steps of the mouse")
    assert pictures < 50  # some ten; more where a busy machine moves the mouse slowly
    screenshot(page, "filter_panel_slow")
