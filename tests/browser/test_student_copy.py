"""In a real browser: a student types an exercise in and its check turns green; an instructor edits a solution."""

import shutil

import pytest

from nao_course.instructor.authoring import build, lesson_text, stamps
from nao_course.instructor.authoring.course import load_course
from tests.browser.lab import browser_page, jupyter_lab, wait_for
from tests.browser.notebook_page import cell_index, in_sight, into, screenshot, select, student_copies
from tests.paths import PROJECT

pytestmark = pytest.mark.browser

NAME = "01_hsl_filtering"
EXERCISE = "rgb_to_hsl"


def check_state(page, name):
    shown = page.locator(f'[data-check="{name}"]')
    return shown.get_attribute("data-state") if shown.count() else None


def test_the_page_that_a_student_opens_has_the_lesson_its_contents_and_nothing_that_distracts(
    tmp_path, chromium
):
    with student_copies(tmp_path, chromium) as (lab, page):
        lab.open(page, f"{NAME}.ipynb")
        page.locator('.jp-SideBar [data-id="table-of-contents"]').click()
        entries = page.locator(".jp-TableOfContents-content .jp-tocItem-content")
        wait_for(lambda: entries.count() > 8, "table of contents")
        screenshot(page, "student_page")
        sides = page.locator(".jp-SideBar [data-id]").evaluate_all("tabs => tabs.map(tab => tab.dataset.id)")
        assert "filebrowser" in sides and not [each for each in sides if "nbgrader" in each]
        assert page.locator(".Toastify__toast, .jp-Dialog").count() == 0
        top = page.locator("h1", has_text="HSL filtering")
        assert in_sight(top)
        entries.last.click()
        wait_for(lambda: not in_sight(top), "last section, to which the click scrolls")


def test_the_blank_lesson_runs_and_an_exercise_that_is_typed_in_turns_its_check_green(tmp_path, chromium):
    folder = tmp_path / "notebooks"
    shutil.copytree(PROJECT / "notebooks", folder)
    course = load_course(PROJECT)
    solved = lesson_text.read_lesson(course.text(NAME))
    (cell,) = (
        cell
        for _, cell in lesson_text.code_cells(solved, "exercise")
        if lesson_text.exercise_name(cell) == EXERCISE
    )
    with jupyter_lab(folder, tmp_path / "jupyter") as lab, browser_page(chromium) as page:
        lab.open(page, f"{NAME}.ipynb")
        lab.run_all(page, timeout=300)
        assert lab.errors(page) == []
        assert page.locator('[data-mime-type="application/vnd.jupyter.stderr"]').count() == 0
        check = cell_index(page, f'check("{EXERCISE}"')
        select(page, check)
        wait_for(lambda: check_state(page, EXERCISE) == "not attempted", "check that says 'not written yet'")
        screenshot(page, "student_copy_blank")

        exercise = cell_index(page, f"def {EXERCISE}")
        select(page, exercise)
        into(page, exercise)
        page.keyboard.press("ControlOrMeta+a")
        page.keyboard.insert_text(cell.source)
        page.keyboard.press("Shift+Enter")
        select(page, check)
        page.keyboard.press("Shift+Enter")
        wait_for(lambda: check_state(page, EXERCISE) == "right", "check that turns green")
        select(page, check)
        screenshot(page, "student_copy_one_right")
        assert lab.errors(page) == []
        assert lab.our_errors() == []


def test_a_solution_that_is_edited_and_saved_in_jupyterlab_comes_back_into_the_text(tmp_path, chromium):
    shutil.copytree(PROJECT / "solutions", tmp_path / "solutions")
    shutil.copy(PROJECT / "course.toml", tmp_path)
    course = load_course(tmp_path)
    text = course.text(NAME).read_text(encoding="utf-8")
    with jupyter_lab(course.solutions, tmp_path / "jupyter") as lab, browser_page(chromium) as page:
        lab.open(page, f"{NAME}.ipynb")
        check = cell_index(page, f'check("{EXERCISE}"')
        exercise = cell_index(page, f"def {EXERCISE}")
        select(page, exercise)
        into(page, exercise)
        page.keyboard.press("ControlOrMeta+End")
        page.keyboard.insert_text("\n\n# edited in JupyterLab")
        page.keyboard.press("Escape")
        select(page, check)
        page.evaluate(
            "() => window.jupyterapp.commands.execute('notebook:insert-cell-below').then(() => null)"
        )
        into(page, check + 1)
        page.keyboard.insert_text('print("new")')
        page.evaluate("() => window.jupyterapp.commands.execute('docmanager:save').then(() => null)")
        wait_for(lambda: stamps.edited(course, NAME) == (False, True), "a notebook that is saved")
    again = build.text_from_notebook(course, NAME)
    solution_end, check_end = "    ### END SOLUTION\n", f'check("{EXERCISE}", {EXERCISE})\n```\n'
    wanted = text.replace(solution_end, f"{solution_end}\n# edited in JupyterLab\n", 1)
    cell = '\n```{code-cell} ipython3\n:role: display\n\nprint("new")\n```\n'
    assert again == wanted.replace(check_end, check_end + cell, 1)
