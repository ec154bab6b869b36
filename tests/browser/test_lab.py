"""The control panel in a real JupyterLab in a real browser: buttons, keys, pictures, and nothing left behind."""

import re
import shutil
import urllib.request

import psutil
import pytest

from tests.browser.lab import jupyter_lab, wait_for
from tests.browser.notebook_page import expect, run_notebook, screenshot
from tests.paths import PROJECT

pytestmark = pytest.mark.browser

LESSON = PROJECT / "notebooks" / "00_meet_the_nao.ipynb"

PANEL = """from nao_course.sim import SimulatedNao, Truth
from nao_course.slam import DeadReckoning
from nao_course.widgets import ControlPanel

nao = SimulatedNao(rng=4)
panel = ControlPanel(nao, truth=Truth(nao), slam=DeadReckoning())
panel"""

FAILING = """from nao_course.sim import SimulatedNao
from nao_course.slam import DeadReckoning
from nao_course.widgets import ControlPanel

class Mine(DeadReckoning):
    def observe(self, measurements):
        print(f"I see {len(measurements)}")
        measurements[99]

panel = ControlPanel(SimulatedNao(rng=4), slam=Mine())
panel"""


@pytest.fixture(autouse=True)
def nothing_fails_in_the_server(lab):
    logged = len(lab.log.read_text())
    yield
    assert not re.search(r'File ".*nao_course', lab.log.read_text()[logged:])


class Panel:
    """The first control panel of a page."""

    def __init__(self, page):
        self.page = page
        self.root = page.locator(".nao-panel:has(.nao-image-bottom)").first
        self.root.wait_for(timeout=240_000)
        wait_for(lambda: self.loaded("bottom") and self.loaded("top"), "pictures")

    def source(self, image):
        return self.root.locator(f".nao-image-{image} img").get_attribute("src")

    def map(self):
        return self.root.locator(".nao-map-canvas").get_attribute("aria-label")

    def loaded(self, image):
        return self.root.locator(f".nao-image-{image} img").evaluate(
            "each => each.complete && each.naturalWidth > 0"
        )

    def press(self, name):
        self.root.locator(f".nao-do-{name}").click()

    def facts(self):
        return self.root.locator(".nao-status").inner_text() + self.root.locator(".nao-facts").text_content()

    def odometry(self):
        x, y, heading = re.search(r"odometry \((.+?), (.+?)\) m, heading (-?\d+)°", self.facts()).groups()
        return float(x), float(y), int(heading)

    def expect(self, words):
        expect(self.facts, words)

    def screenshot(self, name):
        screenshot(self.page, name, self.root)


def open_panel(lab, page, name, code):
    run_notebook(lab, page, name, code)
    return Panel(page)


def test_buttons_drive_and_bring_new_pictures(lab, page):
    panel = open_panel(lab, page, "buttons.ipynb", PANEL)
    panel.screenshot("panel")
    before = {image: panel.source(image) for image in ("top", "bottom")}
    drawn = panel.map()
    panel.press("forward")
    panel.expect("done")
    assert panel.odometry() == (0.2, 0.0, 0)
    assert all(panel.source(image) != before[image] for image in before) and panel.map() != drawn
    panel.press("left")
    panel.expect("heading 15°")
    panel.press("look-left")
    panel.expect("yaw 10°")
    panel.press("slam")
    panel.expect("Measured")
    panel.press("picture")
    panel.expect("1 picture kept")
    panel.screenshot("panel_after_a_drive")


def test_keys_drive_and_jupyterlab_keeps_its_cells(lab, page):
    panel = open_panel(lab, page, "keys.ipynb", PANEL)
    cells = page.locator(".jp-NotebookPanel .jp-Cell").count()
    panel.root.locator(".nao-tile").first.click()  # a click anywhere in the panel
    page.keyboard.press("ArrowUp")
    panel.expect("Walk 0.20 m ahead: done")
    page.keyboard.press("w")
    panel.expect("odometry (0.40, 0.00)")
    page.keyboard.press("ArrowLeft")
    panel.expect("heading 15°")
    for key, words in (("d", "heading 0°"), ("l", "yaw -10°"), ("i", "pitch -36°"), ("h", "pitch -31°")):
        page.keyboard.press(key)
        panel.expect(words)
    page.keyboard.press("Space")
    panel.expect("1 picture kept")
    page.keyboard.press("m")
    panel.expect("Measured")
    for key in "dd" + "abyz" + "00":  # shortcuts of JupyterLab: delete, insert, cut, undo, restart
        page.keyboard.press(key)
    panel.expect("done")
    assert page.locator(".jp-NotebookPanel .jp-Cell").count() == cells
    assert page.locator(".jp-Dialog").count() == 0
    assert panel.root.locator(".nao-keys").input_value() == ""


def test_every_control_is_reached_by_tab_and_pressed_by_space(lab, page):
    panel = open_panel(lab, page, "tab.ipynb", PANEL)
    panel.root.locator(".nao-do-more").click()
    panel.root.locator(".nao-do-forward").focus()
    page.keyboard.press("Space")
    panel.expect("Walk 0.20 m ahead: done")
    panel.root.locator(".nao-keys").focus()
    reached = []
    for _ in range(24):
        reached.append(page.evaluate("document.activeElement.className + document.activeElement.tagName"))
        page.keyboard.press("Tab")
    for name in ("left", "stop", "right", "back", "look-up", "look-ahead", "picture", "slam"):
        assert any(f"nao-do-{name}" in each for each in reached), name
    assert any("nao-keys" in each for each in reached)
    assert sum("SELECT" in each for each in reached) == 4


def test_stop_stops_a_long_drive(lab, page):
    panel = open_panel(lab, page, "stop.ipynb", PANEL)
    panel.root.locator(".nao-do-more").click()
    panel.root.locator("select").nth(2).select_option("1 m")
    before = panel.source("bottom")
    panel.press("forward")
    wait_for(lambda: panel.source("bottom") != before, "a first picture")
    panel.press("stop")
    panel.expect("Stopped")
    panel.press("forward")
    page.keyboard.press("Escape")
    panel.expect("Stopped")
    assert 0.0 < panel.odometry()[0] < 1.8


def test_an_exception_of_the_students_is_a_line_in_the_panel(lab, page):
    panel = open_panel(lab, page, "failing.ipynb", FAILING)
    panel.press("slam")
    panel.expect("IndexError in observe(), line 8: tuple index out of range")
    panel.expect("I see")
    panel.screenshot("panel_with_a_students_mistake")
    panel.press("forward")
    panel.expect("Walk 0.20 m ahead: done")


def test_running_the_cell_again_during_a_drive_gives_a_new_panel_that_drives(lab, page):
    panel = open_panel(lab, page, "again.ipynb", PANEL)
    panel.root.locator(".nao-do-more").click()
    panel.root.locator("select").nth(2).select_option("1 m")
    panel.press("forward")
    lab.run_all(page)
    panel = Panel(page)
    panel.expect("Ready")
    panel.press("forward")
    panel.expect("odometry (0.20, 0.00)")


def test_the_first_lesson_runs_and_its_panel_drives(lab, page):
    if not LESSON.exists():
        pytest.skip("the first lesson is not written yet")
    shutil.copytree(LESSON.parent, lab.folder, dirs_exist_ok=True)
    lab.open(page, LESSON.name)
    lab.run_all(page, timeout=300)
    assert lab.errors(page) == []
    panel = Panel(page)
    panel.root.scroll_into_view_if_needed()
    before = panel.source("bottom")
    panel.press("forward")
    wait_for(lambda: panel.source("bottom") != before, "a new picture")
    panel.screenshot("lesson_00")


def test_no_process_stays_behind(tmp_path):
    (tmp_path / "notebooks").mkdir()
    before = set(psutil.Process().children())
    with jupyter_lab(tmp_path / "notebooks", tmp_path / "jupyter") as lab:
        urllib.request.urlopen(urllib.request.Request(f"{lab.url}/api/kernels", b"{}", method="POST")).close()
        # An open browser, whose pages come and go, is a child of another process.
        (server,) = set(psutil.Process().children()) - before
        started = [server, *server.children(recursive=True)]
        assert len(started) >= 2  # the server and the kernel
    assert not [each for each in started if each.is_running() and each.status() != psutil.STATUS_ZOMBIE]
