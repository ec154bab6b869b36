"""The course's style sheet in a real JupyterLab: figures follow the theme, photographs do not, lines are readable."""

import io

import nbformat
import numpy as np
import pytest
from PIL import Image

from tests.browser.lab import wait_for
from tests.browser.notebook_page import run_notebook, screenshot

pytestmark = pytest.mark.browser

DRAWN = "from nao_course import plotting as draw\nfrom nao_course.sim import Field\ndraw.draw_map(Field())"
PHOTO = """import numpy as np
draw.draw_picture(np.full((60, 80, 3), (250, 20, 30), np.uint8), title="red")"""
TEXT = "A robot measures bearings and ranges of landmarks. " * 20


@pytest.fixture
def notebook(lab, page):
    cells = [nbformat.v4.new_code_cell(DRAWN), nbformat.v4.new_code_cell(PHOTO)]
    lab.write("look.ipynb")
    made = nbformat.read(lab.folder / "look.ipynb", as_version=4)
    made.cells = [nbformat.v4.new_markdown_cell(TEXT), *cells]
    nbformat.write(made, lab.folder / "look.ipynb")
    page.set_viewport_size({"width": 1280, "height": 1600})  # an element is photographed with what is over it
    lab.open(page, "look.ipynb")
    lab.run_all(page)
    page.wait_for_selector(".nao-photos img")
    return page


def choose(page, theme):
    page.evaluate(
        "theme => window.jupyterapp.commands.execute('apputils:change-theme', {theme}).then(() => null)",
        f"JupyterLab {theme}",
    )
    light = "true" if theme == "Light" else "false"
    page.wait_for_selector(f'body[data-jp-theme-light="{light}"]', state="attached")


def pixels(page, selector):
    element = page.locator(selector).first
    element.scroll_into_view_if_needed()
    with Image.open(io.BytesIO(element.screenshot())) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def test_a_figure_follows_the_theme_without_being_drawn_again_and_a_photograph_stays(notebook):
    counts = notebook.locator(".jp-InputPrompt").all_inner_texts()
    seen = {}
    for theme in ("Light", "Dark", "Light"):
        choose(notebook, theme)
        drawn = "() => getComputedStyle(document.querySelector('img.nao-figure')).filter !== 'none'"
        wait_for(lambda drawn=drawn, theme=theme: notebook.evaluate(drawn) is (theme == "Dark"), theme)
        seen[theme] = pixels(notebook, "img.nao-figure"), pixels(notebook, ".nao-photos")
    assert counts == notebook.locator(".jp-InputPrompt").all_inner_texts()
    for figure in seen["Light"]:
        assert (figure[4, 4] > 250).all()
    for figure in seen["Dark"]:
        assert (figure[4, 4] < 30).all()
    red = [np.abs(photo - (250, 20, 30)).max(axis=2) < 12 for _, photo in seen.values()]
    assert red[0].mean() > 0.4
    assert (red[0] == red[1]).mean() > 0.99


def test_a_line_of_text_has_75_to_80_characters(notebook):
    lines, length = notebook.evaluate(
        """() => { const p = document.querySelector('.jp-RenderedMarkdown p');
        const lines = Math.round(p.getBoundingClientRect().height / parseFloat(getComputedStyle(p).lineHeight));
        return [lines, p.textContent.length]; }"""
    )
    assert 72 <= length / lines <= 82


WIDE = """from matplotlib.figure import Figure
from nao_course import plotting as draw
figure = Figure(figsize=(10.6, 3))
figure.add_subplot().set_title("Small letters", fontsize=9)
draw.Drawing(figure, "wide")"""
WIDER = WIDE.replace("10.6", "14.4")
WIDE_PHOTO = """import numpy as np
figure = Figure(figsize=(10.6, 3))
figure.add_subplot().imshow(np.full((60, 80, 3), (250, 20, 30), np.uint8))
draw.Drawing(figure, "wide", photo=True)"""
# The widths of a figure as it was drawn and as it is shown, and of its place
_WIDTHS = """each => { const place = each.closest('.jp-OutputArea-output');
  return [each.naturalWidth, each.getBoundingClientRect().width, place.clientWidth, place.scrollWidth]; }"""
# What stands before the bar of each folded cell
_MARKS = """() => [...document.querySelectorAll('.jp-InputPlaceholder .jp-InputPrompt')]
  .map(each => getComputedStyle(each, '::before').content)"""


def test_in_a_narrow_column_the_letters_of_a_figure_stay_readable_and_it_scrolls(lab, page):
    page.set_viewport_size({"width": 900, "height": 700})
    run_notebook(lab, page, "narrow.ipynb", WIDE, WIDE_PHOTO, WIDER)
    figures = page.locator("img.nao-figure")
    points = (figures.first, 9), (figures.last, 9), (page.locator(".nao-photos img"), 12)
    for shown_as, smallest in points:
        drawn, shown, place, scrolled = shown_as.evaluate(_WIDTHS)
        assert place < 600 and smallest * 100 / 72 * shown / drawn >= 8.5  # px
        assert scrolled >= shown - 1 and page.evaluate("document.documentElement.scrollWidth") == 900
    page.set_viewport_size({"width": 1500, "height": 700})
    wait_for(lambda: figures.first.evaluate(_WIDTHS)[1] > 1000, "figure as it was drawn")
    _, _, place, scrolled = figures.first.evaluate(_WIDTHS)
    assert scrolled <= place + 1


def open_folded(lab, page, name, *cells, text=""):
    """Write and open a notebook of folded cells, below a text if there is one."""
    lab.write(name, *cells)
    made = nbformat.read(lab.folder / name, as_version=4)
    for cell in made.cells:
        cell.metadata["jupyter"] = {"source_hidden": True}
    made.cells[:0] = [nbformat.v4.new_markdown_cell(text)] if text else []
    nbformat.write(made, lab.folder / name)
    lab.open(page, name)


def test_a_folded_cell_shows_that_it_runs(lab, page):
    open_folded(
        lab, page, "folded.ipynb", "import time\ntime.sleep(4)\nprint('done')", "print('next')", "1 + 1"
    )
    nothing = ["none"] * 3
    assert page.evaluate(_MARKS) == nothing
    page.locator(".jp-Cell").first.click(position={"x": 4, "y": 4})
    page.keyboard.press("Shift+Enter")
    wait_for(lambda: page.evaluate(_MARKS) == ['"[*]:"', "none", "none"], "mark on the first cell")
    screenshot(page, "folded_cell_runs")
    wait_for(lambda: page.evaluate(_MARKS) == nothing, "end of the cell")


def test_a_long_folded_line_ends_within_the_page(lab, page):
    page.set_viewport_size({"width": 1280, "height": 700})
    open_folded(lab, page, "long.ipynb", f"'{TEXT[:300]}'")
    page.locator(".jp-InputPlaceholder").wait_for()
    sticking_out = "each => each.scrollWidth - each.clientWidth"
    assert page.locator(".jp-WindowedPanel-outer").evaluate(sticking_out) <= 1


def test_a_folded_cell_opens_by_a_click_and_by_enter(lab, page):
    open_folded(lab, page, "opens.ipynb", "1 + 1", "2 + 2")
    bars = page.locator(".jp-InputPlaceholder")
    bars.first.click()
    wait_for(lambda: bars.count() == 1, "first cell's code")
    page.keyboard.press("Shift+Enter")
    page.keyboard.press("Enter")
    wait_for(lambda: bars.count() == 0, "second cell's code")


PANEL = """import numpy as np
from nao_course.widgets import FunctionPanel
FunctionPanel("Grey", lambda values, student: np.zeros((240, 320), np.uint8), [])"""
TALL = "from IPython.display import HTML\nHTML('<div style=\"height: 900px\">tall</div>')"


@pytest.mark.parametrize(("code", "kind"), [(PANEL, ".nao-panel"), (TALL, "div[style]")])
def test_an_output_begins_in_the_window_and_a_panel_is_all_in_it(lab, page, code, kind):
    page.set_viewport_size({"width": 1280, "height": 800})
    open_folded(lab, page, f"{len(code)}.ipynb", "0", code, "1", "2", text=TEXT * 3)
    page.locator(".jp-InputPlaceholder").nth(1).click()
    page.keyboard.press("Shift+Enter")
    shown = page.locator(f".jp-OutputArea-output {kind}").first
    shown.wait_for(timeout=240_000)
    page.wait_for_timeout(1000)
    top, bottom = shown.evaluate(
        "each => { const at = each.getBoundingClientRect(); return [at.top, at.bottom]; }"
    )
    screen = page.locator(".jp-WindowedPanel-outer").bounding_box()
    screenshot(page, "output_in_window")
    assert top >= screen["y"] - 1 and (kind == "div[style]" or bottom <= screen["y"] + screen["height"] + 1)
