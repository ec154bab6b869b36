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
    SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    root.evaluate("each => each.scrollIntoView({block: 'end'})")
    root.page.wait_for_timeout(500)
    root.page.screenshot(path=SCREENSHOTS / "film.png")
