"""A solution notebook that was edited in JupyterLab comes back into the text, or it is said why not."""

import re
import shutil
from pathlib import Path

import nbformat
import pytest

from nao_course.instructor.authoring import lesson_text, stamps
from tests.toy.course import contents, run, write


def edit(change):
    path = Path("solutions/01_toy.ipynb")
    notebook = nbformat.read(path, as_version=4)
    change(notebook.cells)
    nbformat.write(notebook, path)


def as_jupyterlab_does(cells):
    """Edit words and code, move and add cells, run, fold: what happens in JupyterLab."""
    cells[2].source = "Other **words**.\n\n- a\n- b\n\n```python\nnot_a_cell()\n```\n\n(eq-1)=\n$$ x = 1 $$"
    cells[3].source = cells[3].source.replace("2.0 * value", "value + value  # clearer")
    cells[6].execution_count, cells[6].outputs = 9, [nbformat.v4.new_output("stream", text="other")]
    cells[6].metadata["collapsed"] = True
    cells[6].metadata["execution"] = {"iopub.status.busy": "now"}
    cells.append(nbformat.v4.new_code_cell("%matplotlib inline\nprint('new')", metadata={"tags": ["new"]}))
    cells.append(nbformat.v4.new_markdown_cell("Also new.", metadata={"slideshow": {"slide_type": "notes"}}))
    cells.append(nbformat.v4.new_raw_cell("<i>raw</i>"))
    cells.append(nbformat.v4.new_code_cell(""))
    cells.insert(2, cells.pop(6))


def test_a_notebook_edited_in_jupyterlab_comes_back_into_the_text_with_nothing_lost(built):
    edit(as_jupyterlab_does)
    edited = nbformat.read("solutions/01_toy.ipynb", as_version=4).cells[:-1]  # an empty cell is nothing
    result = run("build", "--from-notebook", "01")
    assert result.exit_code == 0, result.output
    assert "wrote solutions/01_toy.md" in result.output
    again = lesson_text.read_lesson(built.text("01_toy")).cells
    assert [(x.cell_type, x.source) for x in again] == [(x.cell_type, x.source) for x in edited]
    text = built.text("01_toy").read_text()
    assert ":role: display\n:tags: [new]" in text and ":exercise: double" in text and "collapsed" not in text
    assert '+++ {"slideshow": {"slide_type": "notes"}}' in text and "```{raw-cell}\n:format: html" in text
    assert "clearer" not in Path("notebooks/01_toy.ipynb").read_text()
    assert "Nothing has changed." in run("build").output


def test_only_what_was_edited_differs_in_the_text(built):
    before = built.text("01_toy").read_text()
    edit(lambda cells: cells[2].update(source="Changed."))
    assert run("build", "--from-notebook", "01").exit_code == 0
    assert built.text("01_toy").read_text() == before.replace("Words with $x^2$ and `code`.", "Changed.")


def test_an_edited_notebook_is_not_built_over_and_when_both_were_edited_nothing_is_written(built):
    edit(as_jupyterlab_does)
    for words, said in (
        (["build"], "--from-notebook 01"),
        (["build", "--from-notebook", "01"], "were both edited since the last build; nothing is written"),
    ):
        if len(words) > 1:
            write(built.text("01_toy"), "Words", "My words")
        before = contents(built.root)
        result = run(*words)
        assert result.exit_code == 1 and said in result.output
        assert contents(built.root) == before


UNHELD = {
    "nothing": (lambda cells: None, "there is nothing to bring back"),
    "attachment": (lambda cells: cells[2].update(attachments={"a.png": {}}), "cell 3.*a picture was pasted"),
    "a break": (lambda cells: cells[2].update(source="one\n\n+++\n\ntwo"), "cell 3.*MyST would read it"),
    "a graded text": (lambda cells: cells[2].metadata.update(nbgrader={"grade": True}), "cell 3.*a written"),
    "broken code": (lambda cells: cells[3].update(source="def double(value):"), "cell 4.*is not Python"),
    "points": (lambda cells: cells[4].metadata.nbgrader.update(points=7), "points of double were changed"),
}


@pytest.mark.parametrize("what", UNHELD)
def test_what_text_cannot_hold_is_refused(built, what):
    change, said = UNHELD[what]
    edit(change)
    before = contents(built.root)
    result = run("build", "--from-notebook", "01")
    assert result.exit_code == 1 and re.search(said, result.output), result.output
    assert contents(built.root) == before


BUILD, THERE = "was edited since it was built: run `nao-course build 01`", "solutions/01_toy.ipynb"
EDITS = {  # what an author may have done since the build, and what is said of it
    "text": (lambda course: write(course.text("01_toy"), "Words", "More"), f"solutions/01_toy.md {BUILD}"),
    "declaration": (
        lambda course: write(course.declaration("01_toy"), '"Look."', '"See."'),
        f"solutions/exercises/01_toy.py {BUILD}",
    ),
    "notebook": (
        lambda course: edit(lambda cells: cells[2].update(source="Changed.")),
        f"{THERE} was edited since it was built: bring",
    ),
    "no notebook": (lambda course: Path(THERE).unlink(), f"there is no {THERE}: run `nao-course"),
    "not run": (lambda course: run("build", "--no-execute"), f"{THERE} was built without being run: run"),
}
COMMANDS = ("mutate 01", "grade handed_in --out grades", "release --out dist")
ONLY_TO_RELEASE = "not run"  # only a release needs the outputs


@pytest.mark.parametrize(
    ("command", "what"),
    [(each, what) for each in COMMANDS for what in EDITS if what != ONLY_TO_RELEASE or "release" in each],
)
def test_what_was_edited_and_not_built_stops_mutate_grade_and_release(built, secret, command, what):
    stamps.refuse_what_is_not_built(built, ["01_toy"], executed=True)
    (built.root / "handed_in" / "ada").mkdir(parents=True)
    shutil.copy("notebooks/01_toy.ipynb", built.root / "handed_in" / "ada")
    edit_it, said = EDITS[what]
    edit_it(built)
    before = contents(built.root)
    result = run(*command.split())
    assert result.exit_code == 1 and said in result.output, result.output
    assert contents(built.root) == before


def test_a_lesson_that_is_built_without_being_run_has_all_but_outputs_and_its_stamp_is_whole(course):
    assert "wrote solutions/01_toy.ipynb" in run("build", "--no-execute").output
    notebook = nbformat.read("solutions/01_toy.ipynb", as_version=4)
    assert not [cell for cell in notebook.cells if cell.get("outputs")]
    stamps.refuse_what_is_not_built(course, ["01_toy"])
    assert "Nothing has changed." in run("build", "--no-execute").output
