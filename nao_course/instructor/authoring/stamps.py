"""What a solution notebook was built from: an author may edit text, notebook or declaration, and no edit is lost.

`grade` asks before each run, so nothing here loads more than JSON: nbformat takes seconds to import.
"""

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from nao_course.exercises import lesson_names
from nao_course.exercises.cells import metadata, source_of
from nao_course.instructor.authoring.course import Course, LessonError

# What JupyterLab and its extensions write into a cell's metadata of their own accord.
VOLATILE = {
    "collapsed",
    "deletable",
    "editable",
    "execution",
    "ExecuteTime",
    "jupyter",
    "scrolled",
    "trusted",
}


def stamp(
    course: Course, name: str, text: str, notebook: Mapping[str, Any], *, executed: bool
) -> dict[str, object]:
    """Return the stamp of a solution notebook, which later shows whether it, its text or its declaration was edited."""
    return {
        "text": _hash(text),
        "cells": _fingerprint(notebook),
        "declaration": _declared(course, name),
        "executed": executed,
    }


def _declared(course: Course, name: str) -> str:
    """Hash a lesson's declaration; the hash of nothing if it has none."""
    path = course.declaration(name)
    return _hash(path.read_text(encoding="utf-8") if path.is_file() else "")


def edited(course: Course, name: str) -> tuple[bool, bool]:
    """Return whether a lesson's text and its solution notebook were edited since the notebook was built."""
    path = course.solutions / f"{name}.ipynb"
    if not path.is_file():
        return True, False
    kept, cells = _read(path)
    text = course.text(name).read_text(encoding="utf-8")
    return kept.get("text") != _hash(text), kept.get("cells") != cells


def refuse_what_is_not_built(course: Course, names: Sequence[str], *, executed: bool = False) -> None:
    """Raise a LessonError with a line for each file of these lessons that was edited since it was built.

    Nobody would know whether the file or what was built counts. With `executed`, lessons that were built without being
    run are refused, too.
    """
    problems = [problem for name in names for problem in _not_built(course, name, executed)]
    if problems:
        raise LessonError("\n".join(problems))


def _not_built(course: Course, name: str, executed: bool) -> Iterator[str]:
    """Yield messages about the parts of a lesson that differ from what was built."""
    build = f"run `nao-course build {lesson_names.number_of(name)}`"
    file = f"solutions/{name}.ipynb"
    path = course.solutions / f"{name}.ipynb"
    if not path.is_file():
        yield f"there is no {file}: {build}"
        return
    text_edited, notebook_edited = edited(course, name)
    kept, _ = _read(path)
    if text_edited:
        yield f"solutions/{name}.md was edited since it was built: {build}"
    if notebook_edited:
        yield _edited_notebook(name)
    if kept.get("declaration") != _declared(course, name):
        yield f"solutions/exercises/{name}.py was edited since it was built: {build}"
    if executed and not kept.get("executed"):
        yield f"{file} was built without being run: {build}"


def differs_in_version_alone(course: Course, name: str, notebook: Mapping[str, Any]) -> bool:
    """Return whether the solution notebook has the same cells as this one, and another version of the release."""
    path = course.solutions / f"{name}.ipynb"
    if not path.is_file():
        return False
    kept, cells = _read(path)
    return kept.get("version") != course.version and cells == _fingerprint(notebook)


def refuse_to_lose_edits(course: Course, names: Sequence[str]) -> None:
    """Raise a LessonError instead of building over solution notebooks that were edited in JupyterLab."""
    lost = [name for name in names if edited(course, name)[1]]
    if lost:
        raise LessonError("\n".join(map(_edited_notebook, lost)))


def _edited_notebook(name: str) -> str:
    """Explain what to do about a solution notebook that was edited in JupyterLab."""
    return (
        f"solutions/{name}.ipynb was edited since it was built: bring that back into the text with "
        f"`nao-course build --from-notebook {lesson_names.number_of(name)}`, or delete the notebook"
    )


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def _fingerprint(notebook: Mapping[str, Any]) -> str:
    """Hash what an author edits of a notebook: its cells' text and options, not their outputs."""
    cells = [
        [
            cell["cell_type"],
            source_of(cell),
            {key: value for key, value in cell["metadata"].items() if key not in VOLATILE},
            cell.get("attachments", {}),
        ]
        for cell in notebook["cells"]
    ]
    return _hash(json.dumps(cells, sort_keys=True))


def _read(path: Path) -> tuple[dict[str, Any], str]:
    """Read a solution notebook's stamp and its present fingerprint; raise a LessonError if it is not a notebook."""
    try:
        notebook = json.loads(path.read_bytes())
        return metadata(notebook, "nao_course"), _fingerprint(notebook)
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError, OSError) as error:
        raise LessonError(f"{path.name}: not a notebook ({type(error).__name__}: {error})") from None
