"""The control panel in a real browser: it fits on a screen, nothing moves in it, and its keys are its own."""

import pytest

from nao_course.widgets.control_panel.screen import WORLD_HINT
from tests.browser.lab import wait_for
from tests.browser.notebook_page import panel_of, screenshot

pytestmark = pytest.mark.browser

PANEL = """from nao_course.sim import SimulatedNao, Truth
from nao_course.slam import DeadReckoning
from nao_course.widgets import ControlPanel

nao = SimulatedNao(rng=4)
panel = ControlPanel(nao, truth=Truth(nao), slam=DeadReckoning())
panel"""
# Where everything in the panel is
_BOXES = """root => [...root.querySelectorAll('button, .nao-stage > *, .nao-map-canvas, .nao-tile')].map(each => {
  const box = each.getBoundingClientRect(), own = root.getBoundingClientRect();
  return [box.left - own.left, box.top - own.top, box.width, box.height].map(Math.round).join(' '); })"""

# Words in a line that is hidden, or too long for theirs
_CUT = """all => all.filter(each => each.offsetTop + each.offsetHeight > each.parentElement.clientHeight + 2
|| each.scrollWidth > each.clientWidth).map(each => each.innerText)"""


def place(page, selector):
    return page.locator(selector).first.bounding_box()


@pytest.fixture
def panel(lab, page):
    page.set_viewport_size({"width": 1280, "height": 800})
    root = panel_of(lab, page, "control_panel.ipynb", PANEL, "1 + 1", kind=".nao-cockpit")
    page.locator(".nao-image-bottom img").wait_for()
    root.evaluate("each => each.scrollIntoView({block: 'start'})")
    return root


def test_picture_and_map_are_beside_each_other_and_the_panel_fits_at_every_width(page, panel):
    for width, highest in ((1280, 640), (1024, 560), (900, 680)):
        page.set_viewport_size({"width": width, "height": 800})
        page.wait_for_timeout(800)
        picture, field_map = place(page, ".nao-cameras"), place(page, ".nao-face")
        assert panel.bounding_box()["height"] <= highest, width
        assert picture["y"] == field_map["y"] and picture["height"] == pytest.approx(
            field_map["height"], abs=1
        )
        assert picture["x"] + picture["width"] < field_map["x"]
        assert place(page, ".nao-map-canvas")["height"] > 0.8 * picture["height"]
        words = page.locator(".nao-map-legend .path, .nao-caption .widget-html-content").evaluate_all(_CUT)
        assert words == [] or width == 900, width
        screenshot(page, f"control_panel_{width}")
    page.evaluate("window.jupyterapp.commands.execute('application:toggle-left-area').then(() => null)")
    page.set_viewport_size({"width": 540, "height": 800})
    wait_for(lambda: not page.locator(".nao-face").is_visible(), "a picture that is alone")
    alone = place(page, ".nao-cameras")
    page.locator(".nao-chosen img").click()
    wait_for(lambda: page.locator(".nao-map-canvas").is_visible(), "the map in its place")
    assert place(page, ".nao-face")["y"] == pytest.approx(alone["y"], abs=2)


def test_nothing_moves_when_the_robot_does_or_a_view_changes(page, panel):
    before = panel.evaluate(_BOXES)
    page.locator(".nao-chosen img").click()
    for key in "wal ":
        page.keyboard.press(key)
    wait_for(lambda: "Picture taken" in page.locator(".nao-over").inner_text(), "a picture")
    wait_for(lambda: "…" not in page.locator(".nao-over").inner_text(), "the drive's end")
    assert panel.evaluate(_BOXES) == before
    page.keyboard.press("t")
    page.locator(".nao-face .nao-world").wait_for()
    page.keyboard.press("t")
    page.locator(".nao-map-canvas").wait_for()
    assert panel.evaluate(_BOXES) == before


def test_a_key_right_after_a_click_is_the_panels_and_a_frame_says_so(lab, page, panel):
    cells = "() => window.jupyterapp.shell.currentWidget.content.widgets.length"
    page.evaluate(
        """() => { window.naoKeys = [];
        document.querySelector('.nao-keys').addEventListener('keydown', event => window.naoKeys.push(event.key)); }"""
    )
    places = ".nao-chosen img", ".nao-map-canvas", ".nao-tile", ".nao-do-stop"
    for number, selector in enumerate(places * 3, start=1):
        page.evaluate("document.activeElement.blur()")
        box = place(page, selector)
        page.mouse.move(box["x"] + box["width"] / 3, box["y"] + box["height"] / 2)
        page.mouse.down()
        page.mouse.up()
        page.keyboard.press("x")
        assert page.evaluate("window.naoKeys.length") == number, selector
    numbers = lab.counts(page)
    for key in ("Shift+Enter", "Control+Enter", "Alt+Enter"):
        page.keyboard.press(key)
        page.wait_for_timeout(300)
        assert lab.counts(page) == numbers, f"{key} would run the cell again, and its drive would be lost"
    assert page.evaluate(cells) == 2
    # An outline of the panel itself would be painted again with everything that moves in it.
    outlines = "each => [null, '::before'].map(part => getComputedStyle(each, part).outlineStyle)"
    assert panel.evaluate(outlines) == ["none", "solid"]


def test_in_three_dimensions_the_caption_is_true(page, panel):
    place_of = "() => document.querySelector('.nao-face .nao-world').naoWorld.controls.viewpoint"
    panel.locator(".nao-do-world").click()
    world = page.locator(".nao-face .nao-world")
    world.wait_for()
    assert world.locator(".keys").inner_text() == WORLD_HINT
    box = world.locator(".stage").bounding_box()
    page.evaluate("document.activeElement.blur()")
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    seen = [page.evaluate(place_of)]

    def after(act):
        act()
        page.wait_for_timeout(200)
        seen.append(page.evaluate(place_of))
        return seen[-1]

    assert after(lambda: page.mouse.wheel(0, -150)) == seen[0], "without a click the wheel scrolls the page"
    page.mouse.wheel(0, 150)
    page.locator(".nao-keys").focus()
    assert after(lambda: page.mouse.wheel(0, -150)) == seen[0], "also while the robot has the keys"
    page.mouse.wheel(0, 150)
    panel.evaluate("each => each.scrollIntoView({block: 'start'})")
    page.keyboard.down("Shift")
    assert after(lambda: page.mouse.wheel(0, -150))["distance"] < seen[0]["distance"]
    page.keyboard.up("Shift")
    page.mouse.down()
    page.mouse.move(box["x"] + box["width"] / 2 + 40, box["y"] + box["height"] / 2, steps=4)
    assert after(page.mouse.up)["azimuth"] < seen[0]["azimuth"]
    assert after(lambda: page.mouse.wheel(0, -150))["distance"] < seen[-2]["distance"]
    page.keyboard.press("Escape")
    assert after(lambda: page.mouse.wheel(0, -30)) == seen[-2], "after Escape the wheel scrolls the page"
    screenshot(page, "control_panel_3d")
    page.keyboard.press("ArrowUp")
    wait_for(lambda: "ahead: done" in page.locator(".nao-over").inner_text(), "a walk")
    assert page.evaluate(place_of) == seen[-1], "the arrows drive the robot"


def test_after_a_restart_a_sentence_says_what_to_do_instead_of_broken_icons(lab, page, panel):
    page.evaluate(
        """() => { window.jupyterapp.shell.currentWidget.context.sessionContext.session.kernel.restart(); }"""
    )
    sentence = "each => getComputedStyle(each, '::after').content"
    wait_for(lambda: "Run All Above Selected Cell; then" in panel.evaluate(sentence), "the sentence", 300)
    middle = "each => parseFloat(getComputedStyle(each, '::after').top) / each.clientHeight"
    assert panel.evaluate(middle) == pytest.approx(0.5, abs=0.01), (
        "below the toolbar where half of it is seen"
    )
    icons = """root => [root, ...root.querySelectorAll('*')]
    .filter(each => getComputedStyle(each, '::before').fontFamily.includes('Awesome')
      && getComputedStyle(each, '::before').content !== 'none').length"""
    assert panel.evaluate(icons) == 0
    screenshot(page, "control_panel_restarted")
    wait_for(lab._is_ready, "the new kernel", 300)
    # The cells' numbers of the old kernel may still stand there, and new ones are not larger.
    page.evaluate(
        "() => window.jupyterapp.commands.execute('notebook:clear-all-cell-outputs').then(() => null)"
    )
    lab.run_all(page)
    again = page.locator(".nao-cockpit").first
    again.wait_for(timeout=300_000)
    wait_for(lambda: again.evaluate(sentence) == "none", "a panel that works", 300)
