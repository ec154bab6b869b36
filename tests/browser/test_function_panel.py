"""A ten-line panel in a real browser: mouse and keys set every control, and what is shown follows."""

import re

import numpy as np
import pytest

from tests.browser.lab import wait_for
from tests.browser.notebook_page import expect, panel_of, screenshot

pytestmark = pytest.mark.browser

STUDENT = """import numpy as np
from nao_course.sim import SimulatedNao
from nao_course import plotting as draw
from nao_course.widgets import *

scene = SimulatedNao(rng=41).take_picture("bottom").pixels
def brighter(picture, level):
    return picture.mean(axis=2) > level
def unwritten(picture):
    raise NotImplementedError"""
PICTURES = """def show(values, student):
    yield {"The scene": scene, "Your mask": student.brighter(scene, values.level)}
    yield draw.table(["", "R", "G", "B"], [["pixel", *scene[values.pixel[::-1]]]])
    yield f"Random: {values.rng.integers(1000)}."
    if values.strict:
        yield {"Nothing yet": student.unwritten(scene)}
panel = FunctionPanel("Brightness", show, [
    Slider("level", "Level", 0, 255, 1, 120), RangeSlider("rows", "Rows", 0, 239, 1, (0, 100), unit="px"),
    Pixel("pixel", "Pixel", (320, 240)), Choice("colour", "Colour", ("red", "green")), Toggle("strict", "Strict"),
    Action("again", "Draw again", key="n")], student={"brighter": brighter, "unwritten": unwritten},
    unfinished={"unwritten": "Finish exercise 1.3 to see this."})
panel"""
FIGURE = """def show(values, student):
    yield {"The scene": scene, "The field": draw.draw_map(SimulatedNao().field, [[0, 0, 0], [values.x, 0, 0]])}
    yield f"The robot stands at x = {values.x} m."
panel = FunctionPanel("Place", show, [Slider("x", "Place x", 0, 3, 0.05, 1, unit="m")])
panel"""
SLOW = """import time
def show(values, student):
    time.sleep(2.0 * values.slow)
    return f"It took {2 * values.slow} s."
panel = FunctionPanel("Slow", show, [Slider("slow", "Slow", 0, 1, 1, 0)])
panel"""
_WATCH = """() => {
  window.naoLoads = [];
  const images = document.querySelectorAll('.nao-function img');
  images[images.length - 1].addEventListener('load', () => window.naoLoads.push(performance.now()));
}"""


class Panel:
    """The first function panel of a page."""

    def __init__(self, lab, page, name, panel):
        self.page, self.root = page, panel_of(lab, page, name, STUDENT, panel)
        self.root.evaluate("each => each.scrollIntoView({block: 'end'})")
        page.wait_for_timeout(1000)

    def pixel(self):
        return self.root.locator(".nao-pixel-pixel input").input_value()

    def words(self):
        return self.root.inner_text()

    def expect(self, words):
        expect(self.words, words)

    def screenshot(self, name):
        screenshot(self.page, name, self.root)


def test_keys_in_a_menu_and_at_a_question_are_no_commands_of_the_notebook(lab, page):
    asks = "from nao_course.exercises import lesson\ncheck, hint = lesson('06_localization')\n"
    panel = Panel(
        lab, page, "menu.ipynb", PICTURES + "\n\n" + asks + "display(panel)\ncheck.question('near_or_far')"
    )
    cells = page.locator(".jp-NotebookPanel .jp-Cell").count()
    menu = panel.root.locator(".nao-choice-colour select")
    menu.focus()
    page.keyboard.press("ArrowDown")
    wait_for(lambda: menu.input_value() == "green", "the colour below")
    for key in ("b", "a", "x", "m", "ArrowUp"):
        page.keyboard.press(key)
    wait_for(lambda: menu.input_value() == "red", "the colour above")
    panel.root.locator(".nao-do-reset").focus()
    for key in ("d", "d", "a"):
        page.keyboard.press(key)
    radios = page.locator(".widget-radio input[type=radio]")
    radios.first.focus()
    page.keyboard.press("Space")
    page.keyboard.press("ArrowDown")
    wait_for(radios.nth(1).is_checked, "the second choice")
    wait_for(lambda: "Right." in page.locator(".jp-NotebookPanel").inner_text(), "its answer")
    assert page.locator(".jp-NotebookPanel .jp-Cell").count() == cells


def test_mouse_and_keys_set_every_control_and_what_is_shown_follows(lab, page):
    panel = Panel(lab, page, "mouse.ipynb", PICTURES)
    cells = page.locator(".jp-NotebookPanel .jp-Cell").count()
    panel.screenshot("function_panel")
    pad = panel.root.locator(".nao-pad-over")
    box = pad.bounding_box()
    page.mouse.click(box["x"] + box["width"] * 80.5 / 320, box["y"] + box["height"] * 60.5 / 240)
    wait_for(lambda: panel.pixel() == "80, 60", "the pixel that was clicked")
    for key in ("ArrowRight", "ArrowRight", "ArrowDown", "Shift+ArrowLeft", "d", "d"):
        page.keyboard.press(key)
    wait_for(lambda: panel.pixel() == "72, 61", "the pixel that the keys reach")
    mark = panel.root.locator(".nao-cursor")
    wait_for(lambda: "22.656%" in mark.get_attribute("style"), "the mark at u = 72")
    mask = panel.root.locator("img").nth(1)
    before = mask.get_attribute("src")
    panel.root.locator(".nao-slider-level .noUi-handle").focus()
    panel.screenshot("function_panel_focus")
    page.keyboard.press("PageUp")
    wait_for(lambda: mask.get_attribute("src") != before, "another mask")
    panel.root.locator(".nao-slider-rows .noUi-handle").first.focus()
    page.keyboard.press("ArrowRight")
    wait_for(lambda: "1 " in panel.root.locator(".nao-slider-rows .widget-readout").inner_text(), "row 1")
    said = re.search(r"Random: \d+", panel.words())[0]
    panel.root.locator(".nao-keys").click()
    page.keyboard.press("n")
    wait_for(lambda: said not in panel.words(), "another random number")
    panel.root.locator(".nao-toggle-strict input").focus()
    page.keyboard.press("Space")
    panel.expect("Finish exercise 1.3 to see this.")
    panel.screenshot("function_panel_unfinished")
    panel.root.locator(".nao-do-reset").click()
    panel.expect(said)
    wait_for(lambda: panel.pixel() == "160, 120", "the pixel of the start")
    assert page.locator(".jp-NotebookPanel .jp-Cell").count() == cells


_HANDLES = """root => [...root.querySelectorAll('[role=slider]')].map(each =>
  ['aria-label', 'aria-valuenow', 'aria-valuetext'].map(key => each.getAttribute(key)))"""


def test_a_screen_reader_hears_what_a_slider_sets_and_its_value_to_the_last_digit(lab, page):
    panel = Panel(lab, page, "named.ipynb", PICTURES)
    names = [each[0] for each in panel.root.evaluate(_HANDLES)]
    assert names == ["Level", "Rows (px), from", "Rows (px), to"]
    typed = panel.root.locator(".widget-readout").evaluate_all("all => all.map(each => each.ariaLabel)")
    assert typed == ["Level, typed", "Rows (px), typed"]
    panel = Panel(lab, page, "digits.ipynb", FIGURE)
    panel.root.locator(".noUi-handle").focus()
    page.keyboard.press("ArrowRight")
    wait_for(lambda: panel.root.evaluate(_HANDLES) == [["Place x (m)", "1.05", "1.05"]], "1.05 m")


def test_a_dragged_slider_brings_pictures_as_fast_as_they_come_and_ends_at_the_newest(lab, page):
    panel = Panel(lab, page, "drag.ipynb", FIGURE)
    page.evaluate(_WATCH)
    grip = panel.root.locator(".nao-slider-x .noUi-handle").bounding_box()
    x, y = grip["x"] + grip["width"] / 2, grip["y"] + grip["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    for step in range(240):
        page.mouse.move(x + 100 * np.sin(np.pi * step / 240 * 2.5), y)
        page.wait_for_timeout(12)
    page.mouse.up()
    page.wait_for_timeout(1000)
    loads = page.evaluate("() => window.naoLoads")
    print(f"\n{(len(loads) - 1) / (loads[-1] - loads[0]) * 1000:.1f} updates a second")
    value = panel.root.locator(".nao-slider-x .widget-readout").inner_text()
    assert len(loads) > 1
    panel.expect(f"x = {float(value)} m")


def test_a_slow_panel_says_that_it_computes_and_space_at_a_slider_does_not_scroll_the_page(lab, page):
    page.set_viewport_size({"width": 1280, "height": 500})
    root = panel_of(lab, page, "slow.ipynb", STUDENT, SLOW, *["1 + 1"] * 12)
    said = "() => getComputedStyle(document.querySelector('.nao-function .nao-status'), '::after').content"
    assert page.evaluate(said) == "none"
    root.locator("[role=slider]").focus()
    page.wait_for_timeout(500)
    before = page.locator(".jp-WindowedPanel-outer").evaluate("each => each.scrollTop")
    page.keyboard.press(" ")
    page.wait_for_timeout(700)
    assert page.locator(".jp-WindowedPanel-outer").evaluate("each => each.scrollTop") == before
    page.keyboard.press("ArrowRight")
    wait_for(lambda: "Computing" in page.evaluate(said), "a word that the panel computes")
    expect(root, "It took 2 s.")
    wait_for(lambda: page.evaluate(said) == "none", "end of the word")
