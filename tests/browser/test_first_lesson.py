"""In a real browser: lesson 00 opens with its figure and folded cells, and a prediction is typed, kept and resolved."""

import pytest

from tests.browser.lab import wait_for
from tests.browser.notebook_page import cell_index, in_sight, screenshot, select, student_copies

pytestmark = pytest.mark.browser

NAME = "00_meet_the_nao"
FIELD = '.widget-text input[placeholder="your prediction"]'


def test_it_opens_with_its_figure_and_a_prediction_is_written_with_enter_and_laid_beside(tmp_path, chromium):
    with student_copies(tmp_path, chromium) as (lab, page):
        lab.open(page, f"{NAME}.ipynb")
        payoff = page.locator('img[alt^="Four maps"]')
        wait_for(lambda: in_sight(payoff), "the figure on the first screen")
        assert payoff.first.evaluate("image => image.naturalWidth") > 600
        screenshot(page, "lesson_00_first_screen")
        lab.run_all(page, timeout=300)
        assert lab.errors(page) == []
        guess = cell_index(page, "pitch_guess = prediction")
        select(page, guess)
        cell = page.locator(f'.jp-Cell[data-windowed-list-index="{guess}"]')
        assert cell.locator(".jp-InputArea-editor").count() == 0 or not in_sight(
            cell.locator(".jp-InputArea-editor")
        )
        field = cell.locator(FIELD)
        field.click()
        page.keyboard.type("asdf")
        page.keyboard.press("Enter")
        wait_for(lambda: "is not a number in" in cell.inner_text(), "a sentence for what is no number")
        field.click()
        page.keyboard.press("ControlOrMeta+a")
        page.keyboard.type("-30 deg")
        page.keyboard.press("Enter")
        wait_for(lambda: "You predicted -30°" in cell.inner_text(), "the prediction, kept")
        screenshot(page, "lesson_00_prediction")
        beside = cell_index(page, "pitch_guess.beside")
        select(page, beside)
        page.evaluate("() => window.jupyterapp.commands.execute('notebook:run-cell').then(() => null)")
        line = page.locator(f'.jp-Cell[data-windowed-list-index="{beside}"]')
        wait_for(lambda: "You predicted -30°, and so it is." in line.inner_text(), "both side by side")
        screenshot(page, "lesson_00_beside")
        last = cell_index(page, "check.payoff(")
        select(page, last)
        shown = page.locator(f'.jp-Cell[data-windowed-list-index="{last}"]')
        wait_for(lambda: "needs your exercise 0.1" in shown.inner_text(), "which exercise is missing")
        screenshot(page, "lesson_00_payoff_blank")
        assert lab.our_errors() == []
