"""Lesson 09's panel in a real browser: keys go a step on and back, and the player plays the steps."""

import pytest

from tests.browser.lab import browser_page, wait_for
from tests.paths import PROJECT

pytestmark = pytest.mark.browser
pytest.importorskip("jupyterlab")
pytest.importorskip("playwright")

SCREENSHOTS = PROJECT / "build" / "screenshots"
STUDENT = f"""from nao_course.exercises import load_definitions
from nao_course.lessons.pose_graphs import RelaxPanel

own = load_definitions({str(PROJECT / "solutions" / "09_pose_graphs.ipynb")!r})"""
PANEL = "RelaxPanel(linearize=own['linearize'], gauss_newton=own['gauss_newton'])"


@pytest.fixture
def page(lab, chromium):
    lab.console.clear()
    with browser_page(chromium) as opened:
        yield opened
    assert lab.our_errors() == []


def test_keys_step_on_and_back_and_the_player_goes_to_the_last_step(lab, page):
    lab.write("relax.ipynb", STUDENT, PANEL)
    lab.open(page, "relax.ipynb")
    lab.run_all(page)
    assert lab.errors(page) == []
    root = page.locator(".nao-function").first
    root.wait_for(timeout=60_000)

    def expect(words):
        if not wait_for(lambda: words in root.inner_text(), None, 60):
            raise AssertionError(f"{words!r} is not in the panel's words, which are {root.inner_text()!r}")

    expect("odometry, chi2 123,111, off by 2.62 m.")
    slider = root.locator(".nao-slider-step .noUi-handle")
    slider.focus()
    page.keyboard.press("ArrowRight")
    expect("Step 1: chi2")
    page.keyboard.press("ArrowRight")
    expect("Step 2: chi2")
    page.keyboard.press("ArrowLeft")
    expect("Step 1: chi2")
    root.evaluate("each => each.scrollIntoView({block: 'end'})")
    page.wait_for_timeout(500)
    SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=SCREENSHOTS / "pose_graphs.png")
    root.locator(".nao-do-forwards").click()
    expect("Step 10: chi2")
    page.screenshot(path=SCREENSHOTS / "pose_graphs_end.png")
