"""A student in a real browser: the blank lesson runs to its end, an exercise is typed in, its check turns green."""

import shutil

import pytest

from nao_course.grading import building, lessons
from tests.browser.lab import PROJECT, browser_page, jupyter_lab, wait_for

pytestmark = pytest.mark.browser
pytest.importorskip("jupyterlab")
pytest.importorskip("playwright")

SCREENSHOTS = PROJECT / "build" / "screenshots"
NAME = "01_hsl_filtering"
EXERCISE = "rgb_to_hsl"


def cell_index(page, text):
    """Place among all cells of the open notebook of the first one that holds a text."""
    return page.evaluate(
        """text => window.jupyterapp.shell.currentWidget.content.model.sharedModel.cells
        .findIndex(cell => cell.getSource().includes(text))""",
        text,
    )


def select(page, index):
    """Scroll to a cell and make it the active one."""
    page.evaluate(
        """async index => {
            const notebook = window.jupyterapp.shell.currentWidget.content;
            notebook.activeCellIndex = index;
            notebook.deselectAll();
            await notebook.scrollToItem(index, 'center');
        }""",
        index,
    )


def check_state(page, name):
    shown = page.locator(f'[data-check="{name}"]')
    return shown.get_attribute("data-state") if shown.count() else None


def test_the_blank_lesson_runs_and_an_exercise_that_is_typed_in_turns_its_check_green(tmp_path, chromium):
    folder = tmp_path / "notebooks"
    shutil.copytree(PROJECT / "notebooks", folder)
    course = building.load_course(PROJECT)
    solved = lessons.read_lesson(course.text(NAME))
    (cell,) = (
        cell for _, cell in lessons.code_cells(solved, "exercise") if lessons.exercise_name(cell) == EXERCISE
    )
    with jupyter_lab(folder, tmp_path / "jupyter") as lab, browser_page(chromium) as page:
        lab.open(page, f"{NAME}.ipynb")
        lab.run_all(page, timeout=180)
        assert lab.errors(page) == []
        assert page.locator('[data-mime-type="application/vnd.jupyter.stderr"]').count() == 0
        check = cell_index(page, f'check("{EXERCISE}"')
        select(page, check)
        wait_for(
            lambda: check_state(page, EXERCISE) == "not attempted", "check that says 'not written yet'", 20
        )
        SCREENSHOTS.mkdir(parents=True, exist_ok=True)
        page.screenshot(path=SCREENSHOTS / "student_copy_blank.png")

        exercise = cell_index(page, f"def {EXERCISE}")
        select(page, exercise)
        page.locator(f'.jp-Cell[data-windowed-list-index="{exercise}"] .cm-content').click()
        page.keyboard.press("ControlOrMeta+a")
        page.keyboard.insert_text(cell.source)
        page.keyboard.press("Shift+Enter")
        select(page, check)
        page.keyboard.press("Shift+Enter")
        wait_for(lambda: check_state(page, EXERCISE) == "right", "check that turns green", 30)
        select(page, check)
        page.screenshot(path=SCREENSHOTS / "student_copy_one_right.png")
        assert lab.errors(page) == []
        assert lab.our_errors() == []
