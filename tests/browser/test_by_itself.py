"""Lesson 12 in a real browser: the robot goes by itself when a key is pressed, and a room is explored as it plays."""

import shutil

import pytest

from tests.browser.lab import wait_for
from tests.browser.notebook_page import run_notebook, screenshot
from tests.paths import PROJECT

pytestmark = [pytest.mark.browser, pytest.mark.slow]

NAO = "from nao_course.student import my_nao\n\nmy_nao(time_limit=60)"
ROOM = """from nao_course.lessons.beyond import ExplorePanel
from nao_course.student import earlier

ExplorePanel(earlier("12:find_frontiers"), earlier("12:travel_steps"))"""


def fill(folder, *numbers):
    """Put solutions into a folder as a student's saved notebooks."""
    for number in numbers:
        for path in (PROJECT / "solutions").glob(f"{number}_*.ipynb"):
            shutil.copy(path, folder / path.name)


def test_a_key_lets_the_robot_go_by_itself_and_another_stops_it(lab, page):
    fill(lab.folder, "05", "07", "12")
    run_notebook(lab, page, "by_itself.ipynb", NAO, timeout=300)
    board = page.locator(".nao-panel .nao-board")
    board.wait_for(timeout=240_000)
    assert "✔ next move" in page.locator(".nao-ready").inner_text()
    first = board.inner_text()
    page.locator(".nao-chosen").click()
    page.keyboard.press("g")

    def seen():
        return float(board.inner_text().partition("Next move: ")[2].partition("%")[0] or 0)

    wait_for(lambda: seen() > 60, "most of the field seen")
    page.locator(".nao-panel").evaluate("each => each.scrollIntoView({block: 'start'})")
    screenshot(page, "by_itself")
    page.keyboard.press("x")
    status = page.locator(".nao-panel .nao-status")
    wait_for(lambda: "Stopped." in status.inner_text(), "the end of the drive")
    assert board.inner_text() != first


def test_a_room_is_explored_as_it_plays(lab, page):
    fill(lab.folder, "12")
    run_notebook(lab, page, "13_room.ipynb", ROOM, timeout=300)
    said = page.locator(".nao-panel").first
    wait_for(lambda: "After 10 moves" in said.inner_text(), "the tenth move")
    page.locator(".nao-keys").first.click()
    page.keyboard.press(" ")
    wait_for(lambda: "After 13 moves" in said.inner_text(), "three moves more")
    screenshot(page, "explored_room")
