"""A notebook on a page of Chromium: its cells found, chosen and clicked into, and pictures of the page kept."""

import shutil
from contextlib import contextmanager

from tests.browser.lab import browser_page, jupyter_lab
from tests.paths import PROJECT

SCREENSHOTS = PROJECT / "build" / "screenshots"


@contextmanager
def student_copies(tmp_path, chromium):
    """JupyterLab on a copy of notebooks/, and a page for it."""
    folder = tmp_path / "notebooks"
    shutil.copytree(PROJECT / "notebooks", folder)
    with jupyter_lab(folder, tmp_path / "jupyter") as lab, browser_page(chromium) as page:
        yield lab, page


def screenshot(page, name):
    """Keep what the page shows, for whoever wants to look."""
    SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    page.wait_for_timeout(300)
    page.screenshot(path=SCREENSHOTS / f"{name}.png")


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


def into(page, index):
    """Click into a cell that is in sight."""
    page.locator(f'.jp-Cell[data-windowed-list-index="{index}"] .cm-content').click()


def in_sight(found):
    """Whether the first of what was found is on the visible part of the page."""
    box = found.first.bounding_box() if found.count() else None
    return box is not None and 0 < box["y"] < 700
