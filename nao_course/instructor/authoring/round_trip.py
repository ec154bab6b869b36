"""From the solution notebook back to the text: an author may edit either, and no edit is lost."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import nbformat
from nbformat import NotebookNode

from nao_course.exercises import lesson_names
from nao_course.exercises.cells import metadata
from nao_course.instructor.authoring import lesson_text
from nao_course.instructor.authoring.course import Course, LessonError


def stamp(text: str, notebook: NotebookNode) -> dict[str, str]:
    """What a solution notebook carries, to tell later whether it or its text was edited since."""
    return {"text": lesson_text.text_hash(text), "cells": lesson_text.fingerprint(notebook)}


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


def refuse_to_lose_edits(course: Course, names: Sequence[str]) -> None:
    """Refuse to build over solution notebooks that were edited in JupyterLab.

    Raises
    ------
    LessonError
        If there is one.
    """
    lost = [name for name in names if edited(course, name)[1]]
    if lost:
        raise LessonError(
            "\n".join(
                f"solutions/{name}.ipynb was edited since it was built: bring that back into the text with "
                f"`nao-course build --from-notebook {lesson_names.number_of(name)}`, or delete the notebook"
                for name in lost
            )
        )
