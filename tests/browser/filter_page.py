"""The filter panel on a page of Chromium, for its tests and its benchmark."""

from __future__ import annotations

import re

import numpy as np

from tests.browser.notebook_page import expect, panel_of
from tests.paths import PROJECT

LESSON = PROJECT / "solutions" / "01_hsl_filtering.md"
SCENE = """import cv2
import numpy as np
from nao_course.geometry import Pose
from nao_course.sim import Field, SimulatedNao, Truth
from nao_course.lessons.hsl_filtering import FilterPanel

nao = SimulatedNao(Field(2012), Pose(0.6, 0.5, -0.25), rng=41)
scene = nao.take_picture("bottom").pixels
truth = Truth(nao).picture"""
LABEL = """def label(picture, green, yellow, beta, min_saturation):
    mean = average_lightness(rgb_to_hsl(picture)[2], 1000, np.random.default_rng(0))
    return color_labels(picture, green, yellow, white_threshold(mean, beta), min_saturation)
"""
PANEL = """FilterPanel(
    scene, truth, label, green=(114.3, 139.4), yellow=(58.7, 61.3), threshold=white_threshold, calibrate=calibrate_hue,
    examples={"green": np.s_[200:, 100:220], "yellow": truth.labels == 2})"""

# In the page's own clock: when each new picture of labels was decoded.
_WATCH = """() => {
  window.naoLoads = [];
  document.querySelectorAll('.nao-filter img')[1].addEventListener(
    'load', () => window.naoLoads.push(performance.now()));
}"""


def reference():
    """The lesson's six exercises with their solutions."""
    return "\n".join(
        re.findall(r"```\{code-cell\} ipython3\n:exercise: \w+\n\n(.*?)```", LESSON.read_text(), re.S)
    )


class FilterPage:
    """The filter panel of a page."""

    def __init__(self, lab, page, name, label=LABEL, panel=PANEL):
        self.page = page
        self.root = panel_of(lab, page, name, SCENE, reference(), label, panel, kind=".nao-filter")
        self.root.evaluate("each => each.scrollIntoView({block: 'end'})")
        page.wait_for_timeout(1000)

    def source(self):
        return self.root.locator("img").nth(1).get_attribute("src")

    def words(self):
        return self.root.locator(".nao-status").inner_text()

    def numbers(self):
        return self.root.locator(".nao-scores").inner_text()

    def handle(self, slider):
        return self.root.locator(f".nao-slider-{slider} .noUi-handle")

    def value(self, slider):
        return float(self.root.locator(f".nao-slider-{slider} .widget-readout").inner_text())

    def expect(self, words):
        expect(self.words, words)

    def drag(self, slider, pixels, steps, pause=0):
        """Drag a slider with the mouse, evenly there and back again, and hold it."""
        grip = self.handle(slider).bounding_box()
        x, y = grip["x"] + grip["width"] / 2, grip["y"] + grip["height"] / 2
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        for step in range(1, steps + 1):
            there_and_back = 2 / np.pi * np.arcsin(np.sin(np.pi * step / steps * 2.5))
            self.page.mouse.move(x + pixels * there_and_back, y)
            self.page.wait_for_timeout(pause)

    def updates(self, steps=240, pause=12, slider="light"):
        """Drag a slider to and fro; return when each new picture of labels was decoded, ms."""
        self.page.evaluate(_WATCH)
        # The light's slider ends after 46 pixels, and then nothing changes.
        self.drag(slider, 44, steps, pause)
        self.page.mouse.up()
        self.page.wait_for_timeout(500)
        return np.array(self.page.evaluate("() => window.naoLoads"))
