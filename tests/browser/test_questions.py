"""The questions of all lessons in a real browser: no choice lies over another one, and each circle is visible."""

import re

import pytest

from tests.browser.lab import wait_for
from tests.browser.notebook_page import run_notebook, screenshot
from tests.paths import SOLUTIONS

pytestmark = pytest.mark.browser

LESSONS = sorted(path.stem for path in SOLUTIONS.glob("[0-9]*.ipynb"))
CELL = f"""import ipywidgets
from nao_course.exercises.asking import ask
from nao_course.exercises.checking import read_public

questions = [each for lesson in {LESSONS} for each in read_public(lesson).questions]
ipywidgets.VBox([ask(each) for each in questions])"""
PREDICTION = """from nao_course.exercises import prediction
prediction("How far?", unit="degrees")"""
# Questions with a choice that reaches into the next one, or whose circle is not on the first line of its own label
_WRONG = """() => [...document.querySelectorAll('.nao-question')].filter(question => {
  const labels = [...question.querySelectorAll('.widget-radio-box label')], box = each => each.getBoundingClientRect();
  return labels.some((label, i) => {
    const own = box(label), circle = box(label.querySelector('input')), next = labels[i + 1] && box(labels[i + 1]);
    const words = document.createRange(), line = parseFloat(getComputedStyle(label).lineHeight);
    words.selectNodeContents(label);
    return own.bottom > (next?.top ?? Infinity)
      || box(words).bottom > own.bottom + 1 || box(words).right > own.right + 1
      || circle.width < 8 || circle.left > own.left + 12 || circle.left < own.left - 1
      || circle.right > own.right || circle.bottom > own.bottom
      || Math.abs((circle.top + circle.bottom) / 2 - own.top - line / 2) > 1.5;
  });
}).map(each => each.innerText)"""


def test_no_choice_lies_over_another_one_and_each_circle_is_visible(lab, page):
    page.set_viewport_size({"width": 800, "height": 800})
    run_notebook(lab, page, "questions.ipynb", CELL)
    questions = page.locator(".nao-question")
    questions.first.wait_for(timeout=240_000)
    wait_for(lambda: questions.count() >= len(LESSONS), "the questions of all lessons")
    circles, labels = (
        page.locator(f".nao-question .widget-radio-box {each}").count() for each in ("input", "label")
    )
    assert circles == labels > 2 * questions.count()
    assert page.evaluate(_WRONG) == []
    screenshot(page, "questions")


def test_the_unit_of_a_prediction_is_not_cut_off_in_a_narrow_column(lab, page):
    page.set_viewport_size({"width": 800, "height": 800})
    run_notebook(lab, page, "predictions.ipynb", PREDICTION)
    unit = page.locator(".widget-label", has_text="degrees")
    unit.wait_for(timeout=240_000)
    buttons = page.get_by_role("button", name=re.compile("Write it down|Give up"))
    for each in (unit, buttons.first, buttons.last):
        assert each.evaluate("each => each.scrollWidth <= each.clientWidth")


def test_a_prediction_says_that_the_kernel_was_restarted(lab, page):
    run_notebook(lab, page, "restarted.ipynb", PREDICTION)
    page.locator(".nao-asks").wait_for(timeout=240_000)
    said = "() => getComputedStyle(document.querySelector('.nao-asks'), '::after').content"
    assert page.evaluate(said) == "none"
    page.evaluate(
        "() => window.jupyterapp.shell.currentWidget.sessionContext.session.kernel.restart().then(() => null)"
    )
    wait_for(lambda: "Run All Above" in page.evaluate(said), "words about the restart")
