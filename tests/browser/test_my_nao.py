"""The student's robot in a real browser: their labels over the picture, beside it and off, by mouse and keyboard."""

import cv2
import numpy as np
import pytest

from tests.browser.filter_page import reference
from tests.browser.lab import wait_for
from tests.browser.notebook_page import expect, panel_of, run_notebook, screenshot

pytestmark = pytest.mark.browser

GREEN = np.array([0x3F, 0x9B, 0x55])  # of the label, in all figures


def looked_at(page, camera):
    """What stands in a camera's place, as the page shows it."""
    shot = page.locator(f".nao-image-{camera} img").screenshot()
    return cv2.imdecode(np.frombuffer(shot, np.uint8), cv2.IMREAD_COLOR)[8:-8, 8:-8, ::-1].astype(int)


def painted_green(page, camera):
    """What part of it has the colour of the green label."""
    return float(np.mean(np.abs(looked_at(page, camera) - GREEN).max(axis=2) < 12))


def words(page):
    return (
        page.locator(".nao-panel .nao-status").inner_text()
        + page.locator(".nao-panel .nao-facts").text_content()
    )


def test_the_students_own_labels_drive_along(lab, page):
    imports = "import numpy as np\nfrom nao_course.student import my_nao, so_far\nso_far()"
    run_notebook(lab, page, "mine.ipynb", imports, reference(), "panel = my_nao(time_limit=60)\npanel")
    strip = page.locator(".nao-strip").text_content()
    assert "✔" not in strip and "next: labels (01)" in strip, "nothing was saved"
    page.locator(".nao-panel").wait_for(timeout=240_000)
    expect(lambda: words(page), "labels: green")
    assert "✔ labels" in page.locator(".nao-ready").text_content()
    page.locator(".nao-panel").evaluate("each => each.scrollIntoView({block: 'end'})")
    wait_for(lambda: painted_green(page, "top") > 0.3, "labels beside the picture")
    assert painted_green(page, "bottom") < 0.2

    page.locator(".nao-image-bottom").click(position={"x": 200, "y": 140})  # anywhere in the panel
    before = page.locator(".nao-image-top img").get_attribute("src")
    page.keyboard.press("w")
    expect(lambda: words(page), "Walk 0.20 m ahead: done")
    assert page.locator(".nao-image-top img").get_attribute("src") != before
    assert painted_green(page, "top") > 0.3, "the labels follow the drive"
    screenshot(page, "my_nao")

    told = words(page)
    page.locator(".nao-do-view").click()
    wait_for(lambda: painted_green(page, "top") < 0.2, "the top camera's own picture")
    assert words(page) == told, "another view shows the same results"
    picture = looked_at(page, "bottom")
    page.locator(".nao-chosen").click()
    page.keyboard.press("v")
    wait_for(lambda: np.abs(looked_at(page, "bottom") - picture).mean() > 0.2, "labels over the picture")
    assert painted_green(page, "top") < 0.2


def test_the_keys_that_drive_destroy_nothing_beside_the_panel(lab, page):
    """JupyterLab would delete cells, insert some, turn them into text or interrupt; the menu still deletes."""
    cells = "from nao_course.student import my_nao\nmy_nao()", "1 + 1"
    panel = panel_of(lab, page, "keys.ipynb", *cells, kind=".nao-panel")
    box = panel.bounding_box()
    page.mouse.click(box["x"] + box["width"] + 6, box["y"] + box["height"] / 2)
    for key in "ddiixamvwwssjjkkll":
        page.keyboard.press(key)
    cells = """() => window.jupyterapp.shell.currentWidget.content.widgets
        .filter(each => each.model.type === 'code').length"""
    assert page.evaluate(cells) == 2 and "KeyboardInterrupt" not in "".join(lab.errors(page))
    page.get_by_role("menuitem", name="Edit").click()
    page.get_by_role("menuitem", name="Delete Cell", exact=True).click()
    assert wait_for(lambda: page.evaluate(cells) == 1, None, 20)
