"""The panels of all lessons in a real browser: how wide their pictures are, and what a screen reader reads."""

import numpy as np
import pytest

from tests.browser.lesson_panels import PanelPage, panel_cells

pytestmark = [pytest.mark.browser, pytest.mark.slow]

PANELS = panel_cells()
LARGE = 480  # px of a picture on a page of 1280 px without the list of files
# What a panel shows: its cell's width, its pictures, and everything that sticks out or would have to be scrolled.
_MEASURE = """root => {
  const cell = root.getBoundingClientRect();
  const shown = [...root.querySelectorAll('*')].filter(each => each.getBoundingClientRect().width > 0);
  const scrolls = each => ['X', 'Y'].some(axis => getComputedStyle(each)['overflow' + axis] !== 'visible'
    && !each.matches('input, select, textarea, .nao-printed')
    && each['scroll' + (axis === 'X' ? 'Width' : 'Height')] > each['client' + (axis === 'X' ? 'Width' : 'Height')] + 1);
  return {
    cell: cell.width,
    pictures: [...root.querySelectorAll('.nao-main img, .nao-film-views > *')].map(each => {
      const box = each.getBoundingClientRect();
      return {width: box.width, top: Math.round(box.top), right: box.right - cell.left};
    }),
    names: [...root.querySelectorAll('img, canvas[role=img]')].map(each => each.alt || each.ariaLabel || ''),
    outside: shown.filter(each => { const box = each.getBoundingClientRect();
      return box.right > cell.right + 1 || box.left < cell.left - 1; }).map(each => each.className),
    scrolled: shown.filter(scrolls).map(each => each.className),
    words: root.innerText,
  };
}"""


@pytest.fixture(scope="module")
def panels(lab, context):
    yield PanelPage(lab, context.new_page())
    assert lab.our_errors() == []


def test_pictures_of_every_panel_are_wide_on_a_wide_page_and_nothing_sticks_out_of_any_page(panels):
    wrong = []
    for index, (lesson, number) in enumerate(PANELS):
        for width in (1280, 900):
            seen = panels.show(index, width).evaluate(_MEASURE)
            where = f"{lesson}, code cell {number}, at {width} px: "
            widths = [round(each["width"]) for each in seen["pictures"]]
            ends = {each["top"]: each["right"] for each in seen["pictures"]}  # of each row of pictures
            if not seen["names"] or not all(map(str.strip, seen["names"])):
                wrong.append(f"{where}the text alternatives of its pictures are {seen['names']}")
            if width == 1280 and np.mean(widths) < LARGE:
                wrong.append(f"{where}its pictures are {widths} px wide, on average less than {LARGE}")
            if width == 900 and min(ends.values()) < 0.6 * seen["cell"]:
                wrong.append(f"{where}its pictures, {widths} px, leave much of {seen['cell']:.0f} px empty")
            if seen["outside"] or seen["scrolled"]:
                wrong.append(f"{where}outside {seen['outside']}, scrolled {seen['scrolled']}")
    assert not wrong, "\n".join(wrong)
