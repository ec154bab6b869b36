"""The contents of a notebook from any source, read without running any of its code."""

from __future__ import annotations

import ast
import json
import math
import re
import warnings
from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import accumulate
from pathlib import Path
from typing import Any

from nao_course._internal.text_encodings import NotTextError, decode_text
from nao_course.exercises.cells import cell_id, grade_id, metadata, source_of, stated_role
from nao_course.exercises.exercise import ANSWER_HERE
from nao_course.exercises.outline import UNKNOWN, Outline

MOST_BYTES = 50 * 2**20
# Number of Python files beside a notebook that are included, and their largest size in bytes.
MOST_HELPERS, LARGEST_HELPER = 20, 2**20
LARGEST_CODE = 12 * 2**20  # bytes of a notebook without its outputs
LONGEST_NUMBER = 1000  # digits
MOST_WRITTEN = 2**16  # characters of a written answer, and of a text cell
MOST_CHANGED = 3  # text cells of the release that a student has changed; with more, it is another release
BEYOND = 10**9  # in place of the next released cell, after the last one
TEXT = ("markdown", "raw")  # types of cells that do not run
DEFINED = re.compile(r"^[ \t>]*+(?:async[ ]+)?(?:def|class)[ ]+(\w+)", re.MULTILINE)
DEFINES = re.compile(r"^[ \t]*+(?:async[ ]+)?(?:def|class)[ ]|\blambda\b", re.MULTILINE)
# The line above each cell in a script that VS Code or Jupytext has made of a notebook.
_CELL_OF_SCRIPT = re.compile(r"^# ?%%[ \t]*+(\[markdown\])?.*\n?", re.MULTILINE)
# The text cell that Google Colab puts at the top of a notebook from GitHub.
_BADGE = re.compile(r"\s*+<a href=\"https://colab\.research\.google\.com/[^<>]*+><img [^<>]*+></a>\s*+")
_COMMAND = re.compile(r"^([ \t]*+)[%!].*", re.MULTILINE)  # a line that IPython runs
# A first line that keeps the cell from running as a part of the notebook.
_MAGIC = re.compile(r"\s*+(%%(?!(?:time|timeit|capture|prun)\b)\w*)")


@dataclass(frozen=True)
class NotebookText:
    """The contents of a notebook before any of its code runs: role (see `Outline.role`) and source of each code cell.

    `written` are the answers by question, of at most MOST_WRITTEN characters, and `remarks` say what is unusual about a
    question's cells. Lesson, version and Python's version of the kernel that saved it, such as "3.11.7", are empty if
    they are missing. `elsewhere` says why a definition of an exercise does not run although the notebook contains its
    text.
    """

    cells: list[tuple[str, str]] = field(default_factory=list)
    written: Mapping[str, str] = field(default_factory=dict)
    lesson: str = ""
    version: str = ""
    python: str = ""
    remarks: Mapping[str, str] = field(default_factory=dict)
    elsewhere: Mapping[str, str] = field(default_factory=dict)


def read_cells(path: str | Path, released: Outline = UNKNOWN) -> list[tuple[str, str]]:
    """Read a notebook's code cells as (role, source); see `Outline.role` for the roles."""
    return read_notebook(path, released).cells


def read_notebook(path: str | Path, released: Outline = UNKNOWN) -> NotebookText:
    """Read the contents of a notebook; raise a ValueError that explains why if it is not one.

    With the notebook of the same lesson as it was released, cells are also recognised without their metadata.
    """
    file = Path(path)
    return contents(file.name, read_bounded(file), released)


def read_bounded(file: Path) -> bytes:
    """Return the bytes of a file of at most MOST_BYTES; raise as `read_notebook` does."""
    if file.exists() and not file.is_file():
        raise ValueError(f"{file.name}: not a file")
    if file.stat().st_size > MOST_BYTES:
        raise ValueError(f"{file.name}: a notebook may have at most {MOST_BYTES // 2**20} MB")
    return file.read_bytes()


def contents(name: str, content: bytes | bytearray, released: Outline = UNKNOWN) -> NotebookText:
    """Return the contents of a notebook that was read from a file of this name; raise as `read_notebook` does."""
    return _contents(name, content, released)[0]


def without_outputs(name: str, content: bytes | bytearray) -> bytes:
    """Return a notebook that holds only what is graded: its cells without outputs, and its lesson and version.

    Raise a ValueError that names the file and explains why if it is not a notebook, or larger than LARGEST_CODE without
    its outputs.
    """
    _, notebook = _contents(name, content, UNKNOWN)
    cells = [
        {
            "cell_type": cell["cell_type"],
            "id": str(cell.get("id", ""))[:100],
            "metadata": {key: metadata(cell, key) for key in ("nbgrader", "nao_course")},
            "source": _source(cell),
        }
        for cell in _cells(notebook)
        if cell.get("cell_type") in ("code", *TEXT)
    ]
    kept = {key: metadata(notebook, key) for key in ("kernelspec", "language_info", "nao_course")}
    short = json.dumps({"nbformat": 4, "nbformat_minor": 5, "metadata": kept, "cells": cells}).encode()
    if len(short) > LARGEST_CODE:
        raise ValueError(f"{name}: its code and texts may have at most {LARGEST_CODE // 2**20} MB")
    return short


def _contents(
    name: str, content: bytes | bytearray, released: Outline
) -> tuple[NotebookText, dict[str, Any]]:
    """Parse a notebook; return what is graded, and all of it."""
    try:
        notebook = json.loads(decode_text(content), parse_int=_whole_number)
        cells = [
            part
            for cell in _cells(notebook)
            if cell.get("cell_type") in ("code", *TEXT)
            for part in _cells_in(cell)
        ]
        places = released.places(cells)
        code = [
            (released.role(cell, at), source_of(cell))
            for cell, at in zip(cells, places, strict=True)
            if cell["cell_type"] == "code"
        ]
        written, remarks = _written(cells, places, released)
        elsewhere = dict(_elsewhere(cells, places, released))
        text = NotebookText(code, written, *_stamp(notebook), remarks, elsewhere)
        language = _language(notebook)
    except RecursionError:
        raise ValueError(f"{name}: not a notebook of format 4 (it is nested too deeply)") from None
    except (ValueError, TypeError, KeyError, AttributeError, MemoryError) as error:
        raise ValueError(f"{name}: not a notebook of format 4 ({_why_unreadable(error)})") from None
    if language and not any(DEFINES.search(source) for _, source in code):
        raise ValueError(f"{name}: expected a notebook in Python, got {language}")
    return text, notebook


class _NotebookError(ValueError):
    """A reason in plain words why a file is not a notebook."""


def _why_unreadable(error: Exception) -> str:
    """Return the reason why a notebook cannot be read, without Python's own words."""
    match error:
        case _NotebookError():
            return str(error)
        case NotTextError(data=data):
            return "it is compressed with gzip" if data[:2] == b"\x1f\x8b" else str(error)
        case json.JSONDecodeError(doc=doc, pos=at, msg=message, lineno=line):
            if not doc[at:].strip() or message.startswith("Unterminated"):
                end = f"it is incomplete: it breaks off in line {line}; save it again with JupyterLab"
                return end if doc.strip() else "it is empty"
            return f"line {line} is not JSON, the format of notebooks; save it again with JupyterLab"
        case MemoryError():
            return "it is too large to be read; clear all outputs and save it again"
    return "its cells or metadata are damaged; save it again with JupyterLab"


def _whole_number(digits: str) -> float:
    """Return a whole number, or infinity if it has too many digits: Python limits the digits of an int."""
    return int(digits) if len(digits) < LONGEST_NUMBER else math.inf


def _cells(notebook: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the cells, and leave out everything that cannot be a cell.

    A cell without an id has the id in its metadata, if it is there: Google Colab moves it.
    """
    if not isinstance(notebook, dict):
        raise _NotebookError("it contains other data than a notebook; save it again with JupyterLab")
    if notebook.get("nbformat", 4) != 4:
        raise _NotebookError(f"its format is {str(notebook['nbformat'])[:20]}; save it again with JupyterLab")
    if not isinstance(notebook.get("cells"), list):
        raise _NotebookError("it has no list of cells; save it again with JupyterLab")
    cells = [cell for cell in notebook["cells"] if isinstance(cell, dict)]
    if notebook["cells"] and not any(_is_whole(cell) for cell in cells):
        raise _NotebookError("none of its cells has a type and a source; save it again with JupyterLab")
    return [{"id": cell_id(cell), **cell} for cell in cells]


def _cells_in(cell: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the cells of a notebook that was put as a script into one cell; of other cells, the cell."""
    if cell["cell_type"] != "code" or stated_role(cell) or "%%" not in (source := source_of(cell)):
        return [cell]
    before, *parts = _CELL_OF_SCRIPT.split(source)
    if len(parts) < 4:  # two cells, each with its kind
        return [cell]
    made = [{**cell, "source": before}] if before.strip() else []
    for kind, text in zip(parts[::2], parts[1::2], strict=True):
        text = re.sub(r"^# ?", "", text, flags=re.MULTILINE) if kind else text
        made.append({**cell, "id": "", "cell_type": "markdown" if kind else "code", "source": text})
    return made


def _is_whole(cell: dict[str, Any]) -> bool:
    source = cell.get("source")
    lines = source if isinstance(source, list) else [source]
    return isinstance(cell.get("cell_type"), str) and all(isinstance(line, str) for line in lines)


def _language(notebook: dict[str, Any]) -> str:
    """Return the language of a notebook's kernel if it is not Python."""
    language = _text(metadata(notebook, "kernelspec").get("language") or "", 40)
    return "" if "python" in language.lower() else language


def _text(value: Any, most: int) -> str:
    """Return a text that can be written to any file: without lone surrogates."""
    return str(value)[:most].encode("utf-8", "replace").decode()


def _stamp(notebook: dict[str, Any]) -> tuple[str, str, str]:
    stamp, language = metadata(notebook, "nao_course"), metadata(notebook, "language_info")
    stated = language.get("version", "") if language.get("name", "python") == "python" else ""
    # VS Code puts the build behind the version, and PyCharm names Python 2 in every notebook that it creates.
    python = next(iter(_text(stated, 20).split()), "")
    python = "" if python.startswith("2.") else python
    return _text(stamp.get("lesson", ""), 100), _text(stamp.get("version", ""), 100), python


def _source(cell: dict[str, Any]) -> str:
    """Return a cell's text; of a text cell, the part that may be an answer."""
    return source_of(cell) if cell["cell_type"] == "code" else source_of(cell)[:MOST_WRITTEN]


# --- written answers ---


def _written(
    cells: Sequence[dict[str, Any]], places: Sequence[int], released: Outline
) -> tuple[dict[str, str], dict[str, str]]:
    """Return the written answers, and remarks on the questions whose answer is not only in its own cell.

    An answer's own cell is found by its metadata or its id. Text that a student added between the released cell before
    it and the one after it also belongs to the answer, and so does a change of one of these two.
    """
    answers: dict[str, dict[str, None]] = {}
    beside, added, before = set[str](), 0, -1
    changed = {at for cell, at in zip(cells, places, strict=True) if _is_changed_text(cell, at, released)}
    changed = changed if len(changed) <= MOST_CHANGED else set()
    there = sorted({at for at in places if at >= 0})
    for cell, at, then in zip(cells, places, _next_places(places), strict=True):
        text = _source(cell).replace(ANSWER_HERE, "").strip()
        before = at if at >= 0 else before
        if stated_role(cell) == "written":
            name = _text(grade_id(cell), 100)
        elif at >= 0 and released.cells[at].role == "written":
            name = released.cells[at].name
        else:
            added += at < 0 and text != "" and _is_prose(cell)
            near = [
                each
                for each, home in released.questions.items()
                if (abs(at - home) == 1 if at >= 0 else _is_beside(before, then, home, there))
            ]
            if not near or not text or (at not in changed if at >= 0 else not _is_prose(cell)):
                continue
            name = near[0]
            beside.add(name)
        answers.setdefault(name, {}).update(dict.fromkeys([text] if text else []))
    written = {name: _text("\n\n".join(texts), MOST_WRITTEN) for name, texts in answers.items()}
    remarks = dict.fromkeys(beside, "Text beside the cell for this answer is taken as a part of the answer.")
    for name in released.questions if added else ():
        if not written.get(name):
            remarks[name] = "The notebook has text cells of the student's own, but none at this question."
    return written, remarks


def _is_beside(before: int, then: int, home: int, there: Sequence[int]) -> bool:
    """Return whether a cell between two released ones is where an answer's cell is or was, or directly below it."""
    first = bisect_left(there, home)
    above = there[first - 1] if first else None
    below = next(iter(there[bisect_right(there, home) : bisect_right(there, home) + 1]), BEYOND)
    return before == home or (before == above and then in (home, below))


def _next_places(places: Sequence[int]) -> list[int]:
    """Return the place of the next released cell after each cell; BEYOND after the last one."""
    after = list(accumulate(reversed(places), lambda then, at: at if at >= 0 else then, initial=BEYOND))
    return after[-2::-1] if places else []


def _is_changed_text(cell: dict[str, Any], at: int, released: Outline) -> bool:
    """Return whether a student changed a text cell of the release, other than the cell for an answer."""
    return (
        at >= 0
        and {cell["cell_type"], released.cells[at].kind} <= set(TEXT)
        and released.cells[at].role != "written"
        and not released.is_released(_source(cell))
    )


def _is_prose(cell: dict[str, Any]) -> bool:
    """Return whether a cell holds text, also if it is a code cell that Python cannot read or that only has texts."""
    source = source_of(cell)
    if cell["cell_type"] in TEXT:
        return not _BADGE.fullmatch(source)
    if len(source) > MOST_WRITTEN or DEFINED.search(source):
        return False
    try:
        statements = _statements(source)
    except SyntaxError:
        return not (source.lstrip().startswith(("%", "!")) or _is_python(_COMMAND.sub(r"\1pass", source)))
    except (ValueError, RecursionError, MemoryError):
        return False
    return all(_is_only_text(each) for each in statements)


def _statements(source: str) -> list[ast.stmt]:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return ast.parse(source).body


def _is_python(source: str) -> bool:
    try:
        _statements(source)
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return False
    return True


def _is_only_text(statement: ast.stmt) -> bool:
    """Return whether a statement only writes down, prints or names a text, or a constant on its own."""
    match statement:
        case (
            ast.Expr(ast.Constant() | ast.Call(ast.Name("print"), [ast.Constant(str())], []))
            | ast.Assign(value=ast.Constant(str()))
        ):
            return True
    return False


# --- definitions in cells that do not run ---


def _elsewhere(
    cells: Sequence[dict[str, Any]], places: Sequence[int], released: Outline
) -> Iterator[tuple[str, str]]:
    """Yield the exercises that a cell defines which does not run as a part of the notebook, and why not."""
    number = 0
    for cell, at in zip(cells, places, strict=True):
        source, kind = _source(cell), cell["cell_type"]
        number += kind == "code"
        names = released.exercises.intersection(DEFINED.findall(source)) if released.cells else ()
        if kind == "code" and names and (magic := _MAGIC.match(source)):
            why = (
                f"Code cell {number} begins with {magic[1][:20]}, so its definition is not a part of the notebook. "
                "Delete that line and run the cell."
            )
        elif kind in TEXT and (at < 0 or released.cells[at].kind == "code"):
            why = (
                f"Its definition is in a {kind.capitalize()} cell, which does not run. Select the cell, press Y to "
                "make it a code cell, and run it."
            )
        else:
            continue
        for name in sorted(names):
            yield name, why
