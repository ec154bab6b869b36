"""The panels of all lessons in a real browser: how large they and their pictures are, and what is read aloud."""

import numpy as np
import pytest

from tests.browser.lesson_panels import PanelPage, panel_cells

pytestmark = [pytest.mark.browser, pytest.mark.slow]

PANELS = panel_cells()
LARGE = 380  # px: sqrt(width * height) of a picture, on a page of 1280 px without the list of files
TALLEST = {1280: 640, 900: 680}  # px of a panel by the width of the page; a laptop of 1366 x 768 shows 647
# What a panel shows: its cell's width, its pictures, and everything that sticks out or would have to be scrolled.
_MEASURE = """root => {
  const cell = root.getBoundingClientRect();
  const shown = [...root.querySelectorAll('*')].filter(each => each.getBoundingClientRect().width > 0);
  const scrolls = each => ['X', 'Y'].some(axis => getComputedStyle(each)['overflow' + axis] !== 'visible'
    && !each.matches('input, select, textarea, .nao-printed')
    && each['scroll' + (axis === 'X' ? 'Width' : 'Height')] > each['client' + (axis === 'X' ? 'Width' : 'Height')] + 1);
  return {
    cell: cell.width,
    height: cell.height,
    controlsBelow: !root.querySelector('.nao-side')
      || root.querySelector('.nao-side').getBoundingClientRect().left < cell.left + 10,
    pictures: [...root.querySelectorAll('.nao-main img, .nao-film-views > *')].map(each => {
      const box = each.getBoundingClientRect();
      return {width: box.width, height: box.height, top: Math.round(box.top), right: box.right - cell.left};
    }),
    names: [...root.querySelectorAll('img, canvas[role=img]')].map(each => each.alt || each.ariaLabel || ''),
    outside: shown.filter(each => { const box = each.getBoundingClientRect();
      return box.right > cell.right + 1 || box.left < cell.left - 1; }).map(each => each.className),
    scrolled: shown.filter(scrolls).map(each => each.className),
    bar: (output => output.scrollHeight > output.clientHeight)(root.closest('.jp-OutputArea-output')),
    words: root.innerText,
  };
}"""


@pytest.fixture(scope="module")
def panels(lab, context):
    yield PanelPage(lab, context.new_page())
    assert lab.our_errors() == []


def test_every_panel_is_on_one_screen_with_large_pictures_and_nothing_sticks_out_of_any_page(panels):
    wrong = []
    for index, (lesson, number) in enumerate(PANELS):
        for width in (1280, 900):
            seen = panels.show(index, width).evaluate(_MEASURE)
            where = f"{lesson}, code cell {number}, at {width} px: "
            widths = [round(each["width"]) for each in seen["pictures"]]
            ends = {each["top"]: each["right"] for each in seen["pictures"]}  # of each row of pictures
            if not seen["names"] or not all(map(str.strip, seen["names"])):
                wrong.append(f"{where}the text alternatives of its pictures are {seen['names']}")
            sizes = [np.sqrt(each["width"] * each["height"]) for each in seen["pictures"]]
            if seen["height"] > TALLEST[width]:
                wrong.append(f"{where}it is {seen['height']:.0f} px high, more than {TALLEST[width]}")
            if width == 1280 and np.mean(sizes) < LARGE:
                wrong.append(f"{where}its pictures are {widths} px wide, with a mean size below {LARGE}")
            if width == 900 and seen["controlsBelow"] and min(ends.values()) < 0.55 * seen["cell"]:
                wrong.append(f"{where}its pictures, {widths} px, leave much of {seen['cell']:.0f} px empty")
            if seen["outside"] or seen["scrolled"]:
                wrong.append(f"{where}outside {seen['outside']}, scrolled {seen['scrolled']}")
            if seen["bar"]:
                wrong.append(f"{where}its output has a scroll bar, which hides a pixel or more")
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("width", [1280, 900])
def test_the_robots_stages_and_the_small_pictures_caption_are_not_cut_off(panels, width):
    root = panels.show(panels.labels.index("my_nao(), nothing solved"), width)
    for words in (
        ".nao-ready p:first-child",
        ".nao-camera:not(.nao-chosen) .nao-caption .widget-html-content",
    ):
        assert root.locator(words).evaluate("each => each.scrollWidth <= each.clientWidth"), words


@pytest.mark.parametrize("width", [1280, 1024, 900])
def test_no_word_on_the_robots_buttons_is_cut_off_in_any_view(panels, width):
    root = panels.show(panels.labels.index("my_nao(), everything solved"), width)
    cut = "all => all.filter(each => each.scrollWidth > each.clientWidth).map(each => each.innerText)"
    for _ in range(3):
        root.locator(".nao-do-view").click()
        panels.page.wait_for_timeout(1000)
        assert root.locator(".nao-actions button").evaluate_all(cut) == []
