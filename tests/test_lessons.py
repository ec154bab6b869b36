"""Every lesson: built from its text, blank from top to bottom without a stop, and short enough to read."""

import sys
from itertools import pairwise
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "solutions"))
import build  # noqa: E402

SOURCES = sorted((ROOT / "solutions").glob("[0-9][0-9]_*.md"))
LESSONS = sorted((ROOT / "notebooks").glob("*.ipynb"))


def execute(notebook, folder):
    resources = {"metadata": {"path": str(folder)}}
    NotebookClient(notebook, timeout=60, store_widget_state=False, resources=resources).execute()


def words(notebook):
    return sum(len(cell.source.split()) for cell in notebook.cells if cell.cell_type == "markdown")


def test_there_is_a_notebook_for_every_lesson_and_no_other():
    assert [path.stem for path in LESSONS] == [path.stem for path in SOURCES] != []


@pytest.mark.parametrize("source", SOURCES, ids=lambda path: path.stem)
def test_a_notebook_is_what_its_source_builds(source, tmp_path):
    build.build(tmp_path)
    committed = (ROOT / "notebooks" / f"{source.stem}.ipynb").read_text(encoding="utf-8")
    assert (tmp_path / f"{source.stem}.ipynb").read_text(encoding="utf-8") == committed, "run `make build`"


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda path: path.stem)
def test_a_lesson_has_one_title_and_no_solution(lesson):
    notebook = nbformat.read(lesson, as_version=4)
    headings = [
        line
        for cell in notebook.cells
        if cell.cell_type == "markdown"
        for line in cell.source.splitlines()
        if line.startswith("#")
    ]
    assert sum(line.startswith("# ") for line in headings) == 1
    levels = [len(line.split(" ")[0]) for line in headings]
    assert all(after <= before + 1 for before, after in pairwise(levels))
    assert 20 <= len(notebook.cells) <= 70
    assert 900 <= words(notebook) <= 3000
    assert "SOLUTION" not in lesson.read_text(encoding="utf-8")


@pytest.mark.parametrize("lesson", LESSONS, ids=lambda path: path.stem)
def test_a_blank_lesson_runs_to_its_end_within_a_minute(lesson, tmp_path):
    notebook = nbformat.read(lesson, as_version=4)
    execute(notebook, tmp_path)
    outputs = [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]
    assert not [output for output in outputs if output.get("name") == "stderr"]
    assert any("Finish exercise" in str(output) for output in outputs)
    assert len(nbformat.writes(notebook)) < 1_000_000


@pytest.mark.parametrize("source", SOURCES, ids=lambda path: path.stem)
def test_a_solved_lesson_runs_to_its_end_without_a_message(source, tmp_path):
    notebook = build.solved(source)
    execute(notebook, tmp_path)
    assert not any("Finish exercise" in str(cell.get("outputs", "")) for cell in notebook.cells)
