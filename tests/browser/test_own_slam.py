"""The student's own SLAM in a real browser: it follows the drive, and goes on where an exercise is missing."""

import re
import shutil

import pytest

from tests.browser.lab import wait_for
from tests.browser.notebook_page import run_notebook, screenshot
from tests.paths import PROJECT

pytestmark = [pytest.mark.browser, pytest.mark.slow]

PANEL = "from nao_course.student import my_nao\n\npanel = my_nao(time_limit=60)\npanel"


def fill(folder, unsolved=""):
    """Put the solutions into a folder as a student's saved notebooks; that of one lesson is as it was handed out."""
    for path in sorted((PROJECT / "solutions").glob("*.ipynb")):
        own = unsolved and path.name.startswith(unsolved)
        shutil.copy(PROJECT / "notebooks" / path.name if own else path, folder / path.name)


def words(page):
    return page.locator(".nao-panel .nao-status").inner_text()


def drive(lab, page, name):
    """Open the panel, hold a key until pictures have come, and stop."""
    run_notebook(lab, page, name, PANEL, timeout=300)
    page.locator(".nao-panel .nao-board").wait_for(timeout=240_000)
    seen = page.locator(".nao-image-bottom img"), page.locator(".nao-map-canvas")
    before = seen[0].get_attribute("src"), seen[1].get_attribute("aria-label")
    page.evaluate(
        """() => { window.naoSteps = 0; document.querySelector('.nao-image-bottom img')
        .addEventListener('load', () => window.naoSteps += 1); }"""
    )
    page.locator(".nao-chosen").click()

    def held(steps):
        page.keyboard.down("w")  # again and again: as a key that is held repeats itself
        return page.evaluate("() => window.naoSteps") >= steps

    wait_for(lambda: held(8), "eight steps while the key is held", 120)
    page.keyboard.up("w")
    page.keyboard.press("x")
    wait_for(lambda: "…" not in words(page), "end of the drive")
    after = seen[0].get_attribute("src"), seen[1].get_attribute("aria-label")
    assert before[0] != after[0] and before[1] != after[1]
    return page.locator(".nao-panel .nao-board").inner_text()


def test_a_solved_course_drives_with_its_map_and_board_by_the_key_that_is_held(lab, page):
    fill(lab.folder)
    board = drive(lab, page, "solved.ipynb")
    assert "✔ estimate" in page.locator(".nao-ready").inner_text()
    assert "Next move: " in board
    numbers = page.locator(".nao-tile b").all_inner_texts()
    assert re.fullmatch(r"< 1 cm|\d+ cm|[\d.]+ m", numbers[0]) and numbers[2].endswith("consistent"), numbers
    facts = page.locator(".nao-facts").text_content()
    for said in ("estimate: off ", "NEES", "on the map", "by your measure"):
        assert said in facts
    assert " 0 landmarks on the map" not in facts
    page.locator(".nao-panel").evaluate("each => each.scrollIntoView({block: 'start'})")
    screenshot(page, "own_slam")


def test_with_an_exercise_missing_the_panel_says_which_and_goes_on_with_sense(lab, page):
    fill(lab.folder, unsolved="02")
    drive(lab, page, "missing.ipynb")
    ready = page.locator(".nao-ready").inner_text()
    facts = page.locator(".nao-facts").text_content()
    assert "Still to come: goal posts" in ready and "✔ estimate" in ready
    assert "not yet: goal posts, because find_goalposts of lesson 02 is not written yet" in facts
    assert "by sense(), for find_goalposts of your lesson 02 is not usable yet" in facts and "NEES" in facts
    screenshot(page, "own_slam_missing")
