"""The filter panel in a real JupyterLab in a real browser: mouse and keys move it, and it keeps up."""

import re

import numpy as np
import pytest

from tests.browser.lab import PROJECT, browser_page, jupyter_lab, wait_for

pytestmark = pytest.mark.browser
pytest.importorskip("jupyterlab")
pytest.importorskip("playwright")

SCREENSHOTS = PROJECT / "build" / "screenshots"
LESSON = PROJECT / "solutions" / "01_hsl_filtering.md"
WANTED = 10.0  # updates a second while a slider is dragged

SCENE = """import cv2
import numpy as np
from nao_course.geometry import Pose
from nao_course.sim import Field, SimulatedNao, Truth
from nao_course.widgets import FilterPanel

nao = SimulatedNao(Field(2012), Pose(0.6, 0.5, -0.25), rng=41)
scene = nao.take_picture("bottom").pixels
truth = Truth(nao).picture"""
LABEL = """def label(picture, green, yellow, beta, min_saturation):
    mean = average_lightness(rgb_to_hsl(picture)[2], 1000, np.random.default_rng(0))
    return color_labels(picture, green, yellow, white_threshold(mean, beta), min_saturation)
"""
PANEL = "FilterPanel(scene, truth, label, green=(114.3, 139.4), yellow=(58.7, 61.3))"
SLOW = "import time\ntaken = []\n" + LABEL.replace(
    "    mean", "    taken.append(beta); time.sleep(0.4); print(len(taken), 'pictures')\n    mean"
)
ENDLESS = LABEL.replace("    mean", "    while beta > 200: pass\n    mean")

# In the page's own clock: when each new picture of labels was decoded.
WATCH = """() => {
  window.naoLoads = [];
  document.querySelector('img.nao-image-labels').addEventListener(
    'load', () => window.naoLoads.push(performance.now()));
}"""


def reference():
    """The lesson's six exercises with their solutions."""
    return "\n".join(
        re.findall(r"```\{code-cell\} ipython3\n:exercise: \w+\n\n(.*?)```", LESSON.read_text(), re.S)
    )


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    folder = tmp_path_factory.mktemp("notebooks")
    with jupyter_lab(folder, tmp_path_factory.mktemp("jupyter")) as running:
        yield running


@pytest.fixture
def page(lab, chromium):
    lab.console.clear()
    with browser_page(chromium) as opened:
        yield opened
    assert lab.our_errors() == []


class Panel:
    """The filter panel of a page."""

    def __init__(self, lab, page, name, label=LABEL, panel=PANEL):
        lab.write(name, SCENE, reference(), label, panel)
        lab.open(page, name)
        lab.run_all(page)
        assert lab.errors(page) == []
        self.page, self.root = page, page.locator(".nao-filter").first
        self.root.wait_for(timeout=60_000)
        self.root.evaluate("each => each.scrollIntoView({block: 'end'})")
        page.wait_for_timeout(1000)

    def source(self):
        return self.root.locator("img.nao-image-labels").get_attribute("src")

    def words(self):
        return self.root.locator(".nao-status").inner_text()

    def numbers(self):
        return self.root.locator(".nao-scores").inner_text()

    def handle(self, slider):
        return self.root.locator(f".nao-slider-{slider} .noUi-handle")

    def value(self, slider):
        return float(self.root.locator(f".nao-slider-{slider} .widget-readout").inner_text())

    def expect(self, words):
        if not wait_for(lambda: words in self.words(), None, 20):
            pytest.fail(f"{words!r} is not in the panel's words, which are {self.words()!r}")

    def drag(self, slider, pixels, steps, pause=0):
        """Drag a slider with the mouse, there and back again, and hold it."""
        grip = self.handle(slider).bounding_box()
        x, y = grip["x"] + grip["width"] / 2, grip["y"] + grip["height"] / 2
        self.page.mouse.move(x, y)
        self.page.mouse.down()
        for step in range(1, steps + 1):
            self.page.mouse.move(x + pixels * np.sin(np.pi * step / steps * 2.5), y)
            self.page.wait_for_timeout(pause)

    def screenshot(self, name):
        SCREENSHOTS.mkdir(parents=True, exist_ok=True)
        self.page.wait_for_timeout(300)
        self.page.screenshot(path=SCREENSHOTS / f"{name}.png")


def test_a_slider_is_dragged_and_labels_and_numbers_follow_at_least_ten_times_a_second(lab, page):
    panel = Panel(lab, page, "drag.ipynb")
    panel.screenshot("filter_panel")
    picture, numbers = panel.source(), panel.numbers()
    page.evaluate(WATCH)
    panel.drag("beta", 120, 240, pause=12)
    page.mouse.up()
    page.wait_for_timeout(500)
    loads = page.evaluate("() => window.naoLoads")
    rate = (len(loads) - 1) / (loads[-1] - loads[0]) * 1000
    print(f"\n{rate:.1f} updates a second, longest gap {np.diff(loads).max():.0f} ms")
    assert panel.source() != picture
    assert panel.numbers() != numbers
    assert panel.value("beta") > 150
    panel.expect(f"beta {panel.value('beta'):.0f}")
    panel.screenshot("filter_panel_dragged")
    assert rate >= WANTED


def test_arrow_keys_move_every_slider_and_jupyterlab_keeps_its_cells(lab, page):
    panel = Panel(lab, page, "keys.ipynb")
    cells = page.locator(".jp-NotebookPanel .jp-Cell").count()
    for slider in ("green-low", "green-high", "yellow-low", "yellow-high", "beta"):
        before = panel.value(slider)
        panel.handle(slider).focus()
        for key in ("ArrowRight", "ArrowRight", "ArrowLeft", "ArrowUp", "ArrowUp", "ArrowDown"):
            page.keyboard.press(key)
        wait_for(lambda s=slider, b=before: panel.value(s) == b + 2, f"{slider} two steps up", 5)
    panel.handle("min-saturation").focus()
    page.keyboard.press("ArrowRight")
    panel.expect("least saturation 0.17")
    panel.expect("green 116° to 141°, yellow 61° to 63°, beta 122")
    assert page.locator(".jp-NotebookPanel .jp-Cell").count() == cells
    panel.root.locator(".nao-do-reset").focus()
    page.keyboard.press("Space")
    panel.expect("green 114° to 139°, yellow 59° to 61°, beta 120, least saturation 0.16")


def test_the_errors_of_white_are_shown_with_what_their_colours_mean(lab, page):
    panel = Panel(lab, page, "errors.ipynb")
    before = panel.source()
    panel.root.locator("select").last.select_option("Errors in white")
    wait_for(lambda: panel.source() != before, "the errors", 10)
    assert "called white, but is not" in panel.root.locator(".nao-legend").inner_text()
    panel.screenshot("filter_panel_errors")


def test_a_slow_filter_ends_at_the_newest_value_and_skips_most_of_those_before(lab, page):
    panel = Panel(lab, page, "slow.ipynb", SLOW)
    panel.drag("beta", 120, 100, pause=20)
    page.mouse.up()
    last = f"beta {panel.value('beta'):.0f}"
    page.wait_for_timeout(1500)
    assert last in panel.words()
    assert "The panel follows slowly" in panel.words()
    pictures = int(re.search(r"(\d+) pictures", panel.words())[1])
    print(f"\n{pictures} pictures for 100 steps of the mouse")
    assert pictures < 25
    panel.screenshot("filter_panel_slow")


def test_a_filter_that_never_ends_is_stopped_and_the_panel_lives(lab, page):
    panel = Panel(lab, page, "endless.ipynb", ENDLESS)
    panel.handle("beta").focus()
    page.keyboard.press("End")
    panel.expect("not done after 10 s")
    panel.screenshot("filter_panel_stopped")
    panel.root.locator(".nao-do-reset").click()
    panel.expect("beta 120")
    panel.expect("Your code labels a picture in")
