"""Lesson 07's player in a real browser: it plays, forwards and backwards, at the speed that it says."""

import time

import pytest

from tests.browser.lab import browser_page, wait_for
from tests.paths import PROJECT

pytestmark = pytest.mark.browser
pytest.importorskip("jupyterlab")
pytest.importorskip("playwright")

SCREENSHOTS = PROJECT / "build" / "screenshots"
STUDENT = f"""from nao_course.instructor.authoring.plans import load_solution
from nao_course.lessons.ekf_slam import FilmPanel
from pathlib import Path

own = load_solution(Path({str(PROJECT / "solutions" / "07_ekf_slam.ipynb")!r}))"""
FILM = "FilmPanel(*(own[name] for name in ('init_landmarks', 'predict', 'update')))"


@pytest.fixture
def root(lab, chromium):
    lab.console.clear()
    with browser_page(chromium) as page:
        lab.write("film.ipynb", STUDENT, FILM)
        lab.open(page, "film.ipynb")
        lab.run_all(page)
        assert lab.errors(page) == []
        panel = page.locator(".nao-function").first
        panel.wait_for(timeout=60_000)
        yield panel
    assert lab.our_errors() == []


def frame(root):
    return int(root.locator(".nao-slider-frame .widget-readout").inner_text())


def press(root, key):
    field = root.locator(".nao-keys")
    field.focus()
    field.press(key)


def show_all(root, name):
    """A picture of the panel for who reads the tests."""
    SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    root.evaluate("each => each.scrollIntoView({block: 'end'})")
    root.page.wait_for_timeout(500)
    root.page.screenshot(path=SCREENSHOTS / name)


HELD = """([key, times, apart]) => {
  const field = document.querySelector('.nao-function .nao-keys'), button = document.querySelector('.nao-do-on');
  let clicks = 0;
  const count = event => { clicks += 1; event.stopImmediatePropagation(); };
  button.addEventListener('click', count, true);
  for (let i = 0; i < times; i++) {
    const event = new KeyboardEvent('keydown', {key, repeat: i > 0, bubbles: true, cancelable: true});
    Object.defineProperty(event, 'timeStamp', {value: 1e6 + i * apart});
    field.dispatchEvent(event);
  }
  button.removeEventListener('click', count, true);
  return clicks;
}"""  # as if a key were held, by a clock that no busy machine delays


def test_there_is_one_master_and_a_held_key_keeps_the_speed(root):
    speed, play = root.locator(".nao-choice-speed select"), root.locator(".nao-do-forwards")
    assert play.inner_text().strip() == "Play"
    speed.select_option(label="1 a second")
    play.click()
    assert wait_for(lambda: play.inner_text().strip() == "Pause", None, 30)
    speed.select_option(label="8 a second")
    assert wait_for(lambda: frame(root) >= 3, None, 30)
    show_all(root, "film_playing.png")
    root.locator(".nao-do-reset").click()
    assert wait_for(lambda: play.inner_text().strip() == "Play" and frame(root) == 0, None, 30)
    root.page.wait_for_timeout(800)
    assert frame(root) == 0
    play.click()
    assert wait_for(lambda: frame(root) >= 2, None, 30)
    handle, track = (
        root.locator(".nao-slider-frame .noUi-handle"),
        root.locator(".nao-slider-frame .noUi-base"),
    )
    start, whole = handle.bounding_box(), track.bounding_box()
    y = start["y"] + start["height"] / 2
    root.page.mouse.move(start["x"] + start["width"] / 2, y)
    root.page.mouse.down()
    root.page.mouse.move(whole["x"] + 0.6 * whole["width"], y, steps=5)
    root.page.mouse.up()
    assert wait_for(lambda: play.inner_text().strip() == "Play" and 25 <= frame(root) <= 35, None, 30)
    dragged = frame(root)
    root.page.wait_for_timeout(800)
    assert frame(root) == dragged
    assert "slows the panel down" not in root.inner_text()
    assert wait_for(lambda: root.page.evaluate(HELD, ["ArrowRight", 61, 30]) in (14, 15), None, 30)  # 1.8 s
    speed.select_option(label="1 a second")
    assert wait_for(lambda: root.page.evaluate(HELD, ["ArrowRight", 61, 30]) == 2, None, 30)


def test_the_keys_hint_is_not_cut(root):
    field = root.locator(".nao-keys")
    assert "Step on" in field.get_attribute("placeholder")
    widths = field.evaluate("""field => {
      const style = getComputedStyle(field), pen = document.createElement('canvas').getContext('2d');
      pen.font = `${style.fontSize} ${style.fontFamily}`;
      const inside = field.clientWidth - parseFloat(style.paddingLeft) - parseFloat(style.paddingRight);
      return [pen.measureText(field.placeholder).width, inside];
    }""")
    assert widths[0] <= widths[1], widths


def test_keys_go_on_and_back_play_and_stop(root):
    press(root, "ArrowRight")
    press(root, "ArrowRight")
    assert wait_for(lambda: frame(root) == 2, None, 30)
    assert wait_for(lambda: "After step 1, updated" in root.inner_text(), None, 30)
    press(root, "ArrowLeft")
    assert wait_for(lambda: frame(root) == 1, None, 30)
    root.locator(".nao-choice-speed select").select_option(label="8 a second")
    press(root, " ")
    assert wait_for(lambda: frame(root) >= 12, None, 30)
    began, first = time.monotonic(), frame(root)
    root.page.wait_for_timeout(2000)
    rate = (frame(root) - first) / (time.monotonic() - began)
    print(f"{rate:.1f} half steps a second")
    assert rate > 1  # 8 where the machine has nothing else to do; no test fails for being late
    press(root, " ")
    root.page.wait_for_timeout(600)
    stopped = frame(root)
    root.page.wait_for_timeout(600)
    assert frame(root) == stopped
    press(root, "b")
    assert wait_for(lambda: frame(root) < stopped, None, 30)
    assert wait_for(lambda: frame(root) == 0, None, 60)
    press(root, " ")
    assert wait_for(lambda: frame(root) == 50, None, 90)
    show_all(root, "film.png")
