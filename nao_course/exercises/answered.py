"""How much of a notebook a student has answered, compared with the released notebook, without running any of it."""

from __future__ import annotations

import json
import re
from collections.abc import Collection

from nao_course.exercises.cells import SHOWN, is_graded, is_solution, metadata, source_of
from nao_course.exercises.exercise import ANSWER_HERE
from nao_course.exercises.notebook_text import without_outputs

_DEFINES = re.compile(r"^[ \t]*+(?:async[ ]+)?(?:def|class)[ ]|\blambda\b", re.MULTILINE)
_NAMED = re.compile(r"^(?:def|class)[ ]++(\w++)", re.MULTILINE)
_UNWRITTEN = "raise NotImplementedError"  # in the released cell of an exercise


def sources(name: str, content: bytes) -> frozenset[str]:
    """Return the texts of a released notebook's cells, for `count_answers`.

    Raises
    ------
    ValueError
        If it is not a notebook.
    """
    return frozenset(source_of(cell).strip() for cell in json.loads(without_outputs(name, content))["cells"])


def count_answers(name: str, content: bytes, released: Collection[str] = ()) -> int:
    """Return how many cells of a notebook answer an exercise or a question.

    Parameters
    ----------
    name : str
        Name of the file, for the message if it is not a notebook.
    content : bytes
        The notebook.
    released : collection of str
        Texts of the released notebook's cells: a cell with one of these texts answers nothing. A notebook that says
        that it is another lesson's answers only what they define.

    Raises
    ------
    ValueError
        If it is not a notebook; the message explains why.
    """
    notebook = json.loads(without_outputs(name, content))
    cells = notebook["cells"]
    stated = metadata(notebook, "nao_course").get("lesson", "")
    if released and stated not in ("", name.removesuffix(".ipynb")):
        own = {each for text in released if _UNWRITTEN in text for each in _NAMED.findall(text)}
        cells = [cell for cell in cells if own.intersection(_NAMED.findall(source_of(cell)))]
    has_roles = any(map(is_solution, cells))
    count = 0
    for cell in cells:
        text = source_of(cell).strip()
        role = metadata(cell, "nao_course").get("role")
        is_given = not is_solution(cell) and (is_graded(cell) or role in ("setup", *SHOWN))
        if text in ("", ANSWER_HERE) or text in released or is_given:
            continue
        if cell["cell_type"] == "code":
            count += _UNWRITTEN not in text and (is_solution(cell) or bool(_DEFINES.search(text)))
        else:
            count += is_solution(cell) or not has_roles
    return count
