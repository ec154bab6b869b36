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


def test_a_folded_cell_shows_that_it_runs(lab, page):
    lab.write("folded.ipynb", "import time\ntime.sleep(4)\nprint('done')", "print('next')", "1 + 1")
    made = nbformat.read(lab.folder / "folded.ipynb", as_version=4)
    for cell in made.cells:
        cell.metadata["jupyter"] = {"source_hidden": True}
    nbformat.write(made, lab.folder / "folded.ipynb")
    lab.open(page, "folded.ipynb")
    nothing = ["none"] * 3
    assert page.evaluate(_MARKS) == nothing
    page.locator(".jp-Cell").first.click(position={"x": 4, "y": 4})
    page.keyboard.press("Shift+Enter")
    wait_for(lambda: page.evaluate(_MARKS) == ['"[*]:"', "none", "none"], "mark on the first cell")
    screenshot(page, "folded_cell_runs")
    wait_for(lambda: page.evaluate(_MARKS) == nothing, "end of the cell")
