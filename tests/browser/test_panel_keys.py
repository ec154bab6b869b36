"""Every key in every kind of panel: none of them adds, deletes or changes a cell of the notebook."""

import string

import pytest

from tests.browser.lesson_panels import IMPORT, panels_by_kind

pytestmark = [pytest.mark.browser, pytest.mark.slow]

CONTROL = """from nao_course.sim import SimulatedNao, Truth
from nao_course.slam import DeadReckoning
from nao_course.widgets import ControlPanel
nao = SimulatedNao(rng=4)
ControlPanel(nao, truth=Truth(nao), slam=DeadReckoning())"""
SHEET = "from nao_course.lessons.ekf_derivations import motion_sheet\nmotion_sheet()"
KINDS = ("HeadPanel", "FilterPanel", "RealityDial", "PhoneLab", "LapPanel", "FilmPanel", "RelaxPanel")
KINDS += ("AssociationPanel", "ExplorePanel", "ControlPanel", "motion_sheet")
KEYS = [*string.ascii_lowercase, *string.digits, "+", "-", "Shift+M", "Space", "Enter", "Backspace", "Delete"]
KEYS += ["Home", "End", "PageUp", "PageDown", "ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight", "Escape"]
# Of these JupyterLab's own are tried at every place, and the others at a panel's first place.
JUPYTER = [*"abcdijkmrsvxyz01", "Shift+M", "Space", "Enter", "Delete", "Escape"]
# What a reader clicks to use a panel
PLACES = ("button:enabled", ".noUi-handle", ".nao-keys", ".nao-film", ".nao-world canvas, .nao-world img")
PLACES += (".nao-chosen img, .nao-pad-over", ".nao-face canvas")
_SOURCES = """() => window.jupyterapp.shell.currentWidget.content.model.sharedModel.cells
.map(cell => cell.getSource())"""


@pytest.fixture(scope="module")
def notebook(lab, context):
    """Return a page with one panel of each kind, in the cells after the first."""
    lessons = panels_by_kind()
    made = [f"panel_of{lessons[kind]!r}" for kind in KINDS if kind in lessons]
    lab.write("keys.ipynb", IMPORT, *made, CONTROL, SHEET)
    page = context.new_page()
    lab.open(page, "keys.ipynb")
    lab.run_all(page, 300)
    assert lab.errors(page) == []
    yield page
    assert lab.our_errors() == []


@pytest.mark.parametrize("kind", KINDS)
def test_no_key_in_a_panel_changes_the_notebook(notebook, kind):
    before, cell = notebook.evaluate(_SOURCES), KINDS.index(kind) + 1
    assert len(before) == len(KINDS) + 1
    notebook.evaluate(
        "cell => window.jupyterapp.shell.currentWidget.content.scrollToItem(cell, 'start')", cell
    )
    panel = notebook.locator(f'.jp-Cell[data-windowed-list-index="{cell}"] :is(.nao-panel, .nao-sheet)').first
    panel.wait_for(timeout=240_000)
    places = [place for place in PLACES if panel.locator(place).count()]
    assert places
    for place in places:
        panel.locator(place).first.click()
        for key in KEYS if place == places[0] else JUPYTER:
            for _ in range(2):  # D D, I I and 0 0 are JupyterLab's
                notebook.keyboard.press(key)
            assert notebook.evaluate(_SOURCES) == before, (place, key)
        assert notebook.locator(".jp-Dialog").count() == 0, place
