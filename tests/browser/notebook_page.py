"""A notebook on a page of Chromium: its cells found, chosen and clicked into, and pictures of the page kept."""

import shutil
from contextlib import contextmanager

from tests.browser.lab import PATIENCE, browser_page, jupyter_lab, wait_for
from tests.paths import PROJECT

SCREENSHOTS = PROJECT / "build" / "screenshots"


@contextmanager
def student_copies(tmp_path, chromium):
    """JupyterLab on a copy of notebooks/, and a page for it."""
    folder = tmp_path / "notebooks"
    shutil.copytree(PROJECT / "notebooks", folder)
    with jupyter_lab(folder, tmp_path / "jupyter") as lab, browser_page(chromium) as page:
        yield lab, page


def run_notebook(lab, page, name, *cells, timeout=300):
    """Write and open a notebook of these cells, and run all of them without an error."""
    lab.write(name, *cells)
    lab.open(page, name)
    lab.run_all(page, timeout)
    assert lab.errors(page) == []


def panel_of(lab, page, name, *cells, kind=".nao-function", timeout=300):
    """Run a notebook; return its first panel of a kind."""
    run_notebook(lab, page, name, *cells, timeout=timeout)
    root = page.locator(kind).first
    root.wait_for(timeout=240_000)
    return root


def expect(root, words, seconds=PATIENCE):
    """Wait until words are in a panel, or in what a function returns."""
    said = root if callable(root) else root.inner_text
    if not wait_for(lambda: words in said(), None, seconds):
        raise AssertionError(f"{words!r} is not in the panel's words, which are {said()!r}")


def screenshot(page, name, root=None):
    """Keep what the page shows, with a panel's end in view, for whoever wants to look."""
    SCREENSHOTS.mkdir(parents=True, exist_ok=True)
    if root is not None:
        root.evaluate("each => each.scrollIntoView({block: 'end'})")
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
