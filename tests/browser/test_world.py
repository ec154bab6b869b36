"""In a real browser: mouse and keys turn the view of the world, and without WebGL it is a picture."""

import cv2
import numpy as np
import pytest

from nao_course.geometry import Pose
from nao_course.sim import Field, Reality
from nao_course.widgets.world.contents import WorldContents
from nao_course.widgets.world.picture import cameras
from nao_course.widgets.world.robot import camera_in_head
from nao_course.widgets.world.scene import WorldScene
from tests.browser.lab import browser, wait_for
from tests.browser.notebook_page import panel_of

pytestmark = pytest.mark.browser

CELL = """import numpy as np
from nao_course.geometry import Pose
from nao_course.sim import SimulatedNao
from nao_course.slam import Estimate
from nao_course.widgets import Ray, WorldView

nao = SimulatedNao(pose=Pose(0.6, -0.5, 0.2), rng=1)
world = WorldView(nao.field)
spread = np.diag([0.01, 0.02, 0.01])
estimate = Estimate(Pose(0.8, -0.4, 0.3), spread, np.array([[3.0, 0.7]]), spread[None, :2, :2], ("post",))
world.update(
    Pose(0.6, -0.5, 0.2),
    estimate,
    head=(0.0, -0.2),
    pictures={"bottom": nao.take_picture().pixels},
    rays=[Ray((3.0, 0.7)), Ray((3.0, 0.6), source="ekf")],
    paths={"truth": [Pose(0, -0.5), Pose(0.6, -0.5)]},
)
world"""
MOVE = """step = 1 - globals().get("step", 1)
world.update(Pose(0.6 + 0.1 * step, -0.5, 0.2), head=(1.0 * step, 0.3 * step))"""
STATE = """() => {
  const { view, controls, model } = document.querySelector('.nao-world').naoWorld;
  const head = view?.robots.truth.links.get('HeadPitch').matrixWorld.elements;
  return { viewpoint: controls.viewpoint, told: model.get('viewpoint'), frames: view?.frames ?? 0,
    truth: view?.now.truth, head: head ? [...head] : null };
}"""


NO_WEBGL = """{ const before = HTMLCanvasElement.prototype.getContext;
HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
  return String(kind).startsWith('webgl') ? null : before.call(this, kind, ...rest);
}; }"""


@pytest.fixture(scope="module")
def context(chromium):
    with browser(chromium, webgl=True) as opened:
        yield opened


def show(lab, page, *cells):
    panel_of(lab, page, "world.ipynb", *cells, kind=".nao-world")


def canvas_pixels(page):
    data = page.locator(".nao-world .stage").screenshot()
    return cv2.imdecode(np.frombuffer(data, dtype=np.uint8), cv2.IMREAD_COLOR)


def settled(page):
    """Return the view's state after no frame has been drawn for a while."""
    last = [-1]

    def still():
        page.wait_for_timeout(400)
        frames = page.evaluate(STATE)["frames"]
        same, last[0] = frames == last[0], frames
        return same and frames > 0

    wait_for(still, "view that has come to rest")
    return page.evaluate(STATE)


def run_last_cell(page):
    page.evaluate(
        """() => { const notebook = window.jupyterapp.shell.currentWidget.content;
        notebook.activeCellIndex = notebook.model.cells.length - 1;
        return window.jupyterapp.commands.execute('notebook:run-cell').then(() => null); }"""
    )


def test_mouse_and_keys_turn_it_and_the_head_moves(lab, page):
    show(lab, page, CELL)
    before = settled(page)
    colours = canvas_pixels(page).reshape(-1, 3).astype(int)
    blue, green, red = colours.T
    assert ((green > red + 40) & (green > blue + 20)).mean() > 0.2  # carpet
    canvas = page.locator(".nao-world canvas")
    assert "robot at (0.60, -0.50) m" in canvas.get_attribute("aria-label")
    box = canvas.bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    # The wheel scrolls the page until the view is clicked.
    page.mouse.move(*middle)
    page.mouse.wheel(0, -300)
    assert settled(page)["viewpoint"] == before["viewpoint"]
    page.mouse.move(*middle)
    page.mouse.down()
    page.mouse.move(middle[0] - 100, middle[1] + 40, steps=4)
    page.mouse.up()
    dragged = settled(page)
    assert dragged["viewpoint"]["azimuth"] == pytest.approx(before["viewpoint"]["azimuth"] + 0.8, abs=0.02)
    assert dragged["viewpoint"]["elevation"] > before["viewpoint"]["elevation"] + 0.2
    page.mouse.wheel(0, -300)
    nearer = settled(page)
    assert nearer["viewpoint"]["distance"] < 0.8 * dragged["viewpoint"]["distance"]
    page.keyboard.press("Escape")
    page.mouse.wheel(0, -30)
    assert settled(page)["viewpoint"] == nearer["viewpoint"], "after Escape the wheel scrolls the page"
    canvas.focus()
    page.keyboard.press("ArrowLeft")
    page.keyboard.press("-")
    keyed = settled(page)
    assert keyed["viewpoint"]["azimuth"] == pytest.approx(nearer["viewpoint"]["azimuth"] - 0.08)
    assert keyed["viewpoint"]["distance"] > nearer["viewpoint"]["distance"]
    for key, follows in (("2", False), ("3", False), ("1", True)):
        page.keyboard.press(key)
        chosen = settled(page)
        assert chosen["viewpoint"]["follows"] is follows
    assert chosen["viewpoint"] == before["viewpoint"] == chosen["told"]
    page.locator(".nao-world .views button", has_text="Above").click()
    assert settled(page)["viewpoint"]["elevation"] > 1.5
    assert page.locator(".nao-world .views button", has_text="Above").get_attribute("aria-pressed") == "true"


def test_an_update_moves_the_robot_and_its_head_to_the_pose_of_the_simulator(lab, page):
    show(lab, page, CELL, MOVE)
    settled(page)
    run_last_cell(page)
    wait_for(lambda: page.evaluate(STATE)["truth"][0] > 0.69, "robot at its new pose")
    state = settled(page)
    head = np.array(state["head"]).reshape(4, 4).T
    pose, scene = Pose(0.7, -0.5, 0.2), WorldScene(Field(), Reality())
    contents = WorldContents(pose, head=(1.0, 0.3))
    for name, wanted in cameras(scene, contents, pose, (0.0, 0.0)).items():
        np.testing.assert_allclose(head @ camera_in_head(name), wanted, atol=1e-3)


def test_without_webgl_it_is_a_picture_that_turns_too(lab, page):
    page.add_init_script(NO_WEBGL)
    show(lab, page, CELL)
    image = page.locator(".nao-world img")
    wait_for(lambda: image.evaluate("image => image.naturalWidth") == 640, "picture of the view")
    before = image.get_attribute("src")
    assert "robot at (0.60, -0.50) m" in image.get_attribute("alt")
    image.click()
    page.keyboard.press("2")
    wait_for(lambda: image.get_attribute("src") != before, "picture from above")
    assert page.evaluate(STATE)["viewpoint"]["follows"] is False
    wait_for(lambda: image.evaluate("image => image.naturalWidth") == 640, "picture from above")


def test_it_fits_a_narrow_page_in_light_and_dark(lab, page):
    show(lab, page, CELL)
    page.set_viewport_size({"width": 900, "height": 800})
    settled(page)
    root = page.locator(".nao-world")
    for theme, dark in (("JupyterLab Dark", True), ("JupyterLab Light", False)):
        page.evaluate(
            "theme => window.jupyterapp.commands.execute('apputils:change-theme', {theme}).then(() => null)",
            theme,
        )
        wait_for(lambda dark=dark: ("dark" in root.get_attribute("class").split()) == dark, theme)
    # JupyterLab may take a cell out of the page for a moment when its size or theme changes.
    wait_for(lambda: page.locator(".nao-world .stage").bounding_box(), "view on the page")
    assert root.evaluate("root => root.scrollWidth <= root.clientWidth + 1")
    right = root.evaluate("root => root.getBoundingClientRect().right")
    assert right <= 900
