"""From the solution notebook back to the text: an author may edit either, and no edit is lost."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import nbformat
from nbformat import NotebookNode

from nao_course.exercises import lesson_names
from nao_course.exercises.cells import metadata
from nao_course.instructor.authoring import lesson_text
from nao_course.instructor.authoring.course import Course, LessonError


def stamp(
    course: Course, name: str, text: str, notebook: NotebookNode, *, executed: bool
) -> dict[str, object]:
    """What a solution notebook carries, to tell later whether it, its text or its declaration was edited since."""
    cells = lesson_text.fingerprint(notebook)
    declared = _declared(course, name)
    return {
        "text": lesson_text.text_hash(text),
        "cells": cells,
        "declaration": declared,
        "executed": executed,
    }


def _declared(course: Course, name: str) -> str:
    """Hash a lesson's declaration; that of nothing where it has none."""
    path = course.declaration(name)
    return lesson_text.text_hash(path.read_text(encoding="utf-8") if path.is_file() else "")


def edited(course: Course, name: str) -> tuple[bool, bool]:
    """Return whether a lesson's text and its solution notebook were edited since the notebook was built."""
    path = course.solutions / f"{name}.ipynb"
    if not path.is_file():
        return True, False
    notebook = read_notebook(path)
    stamp = metadata(notebook, "nao_course")
    text = course.text(name).read_text(encoding="utf-8")
    return stamp.get("text") != lesson_text.text_hash(text), stamp.get("cells") != lesson_text.fingerprint(
        notebook
    )


def read_notebook(path: Path) -> NotebookNode:
    """Read a notebook.

    Raises
    ------
    LessonError
        If it is none.
    """
    try:
        return nbformat.read(path, as_version=4)
    except (ValueError, KeyError, AttributeError, OSError) as error:
        raise LessonError(f"{path.name}: not a notebook ({type(error).__name__}: {error})") from None


def text_from_notebook(course: Course, name: str) -> str:
    """Return the text of a lesson whose solution notebook was edited.

    Raises
    ------
    LessonError
        If there is nothing to bring back, the text was edited too, or it does not fit into text.
    """
    text_edited, notebook_edited = edited(course, name)
    file = f"solutions/{name}.ipynb"
    if not notebook_edited:
        raise LessonError(
            f"{file}: nothing in it differs from what was built; there is nothing to bring back"
        )
    if text_edited:
        raise LessonError(
            f"{file} and solutions/{name}.md were both edited since the last build; nothing is written. Keep one: "
            f"`git checkout solutions/{name}.md` keeps the notebook, deleting {file} keeps the text"
        )
    notebook = read_notebook(course.solutions / f"{name}.ipynb")
    points = course.plan(name).points
    for _, cell in (*lesson_text.code_cells(notebook, "check"), *lesson_text.written_cells(notebook)):
        exercise = lesson_text.exercise_name(cell)
        if cell.metadata.nbgrader.get("points") != points.get(exercise):
            raise LessonError(
                f"{file}: the points of {exercise} were changed in the notebook; they are declared in "
                f"solutions/exercises/{name}.py, and for one course in course.toml"
            )
    return lesson_text.write_lesson(notebook)


def refuse_what_is_not_built(course: Course, names: Sequence[str], *, executed: bool = False) -> None:
    """Refuse to go on with lessons that are not what was built: nobody would know which of the two counts.

    Parameters
    ----------
    course : Course
        The course.
    names : sequence of str
        Whole names of lessons.
    executed : bool
        Whether lessons that were built without being run are refused, too.

    Raises
    ------
    LessonError
        If there is one: a line for each file that was edited.
    """
    problems = [problem for name in names for problem in _not_built(course, name, executed)]
    if problems:
        raise LessonError("\n".join(problems))


def _not_built(course: Course, name: str, executed: bool) -> Iterator[str]:
    """What of a lesson is not what was built, and what to say."""
    build = f"run `nao-course build {lesson_names.number_of(name)}`"
    file = f"solutions/{name}.ipynb"
    path = course.solutions / f"{name}.ipynb"
    if not path.is_file():
        yield f"there is no {file}: {build}"
        return
    text_edited, notebook_edited = edited(course, name)
    kept = metadata(read_notebook(path), "nao_course")
    if text_edited:
        yield f"solutions/{name}.md was edited since it was built: {build}"
    if notebook_edited:
        yield _edited_notebook(name)
    if kept.get("declaration") != _declared(course, name):
        yield f"solutions/exercises/{name}.py was edited since it was built: {build}"
    if executed and not kept.get("executed"):
        yield f"{file} was built without being run: {build}"


def refuse_to_lose_edits(course: Course, names: Sequence[str]) -> None:
    """Refuse to build over solution notebooks that were edited in JupyterLab.

    Raises
    ------
    LessonError
        If there is one.
    """
    lost = [name for name in names if edited(course, name)[1]]
    if lost:
        raise LessonError("\n".join(map(_edited_notebook, lost)))


def _edited_notebook(name: str) -> str:
    """What to say of a solution notebook that was edited in JupyterLab."""
    return (
        f"solutions/{name}.ipynb was edited since it was built: bring that back into the text with "
        f"`nao-course build --from-notebook {lesson_names.number_of(name)}`, or delete the notebook"
    )
