"""The code that a student wrote, read from a submission without running it."""

from __future__ import annotations

import re
from collections.abc import Iterable

from nao_course.exercises import definitions
from nao_course.instructor.autograding.scratch import laid_out
from nao_course.instructor.collecting import files
from nao_course.instructor.collecting.archives import Refused
from nao_course.instructor.collecting.submissions import Submission

_OWN = ("solution", "student")  # roles of the cells that a student writes


def own_cells(submission: Submission) -> tuple[str, ...]:
    """Return the code that a student wrote: exercises, cells that were added, and helper files.

    Raises
    ------
    Refused
        If the notebook cannot be read.
    """
    try:
        with laid_out(files.read(submission, _without_outputs), submission.lesson) as notebook:
            cells = [source for role, source in definitions.read_cells(notebook) if role in _OWN]
            helpers = [
                notebook.with_name(name).read_text(encoding="utf-8", errors="replace")
                for name, _ in submission.helpers
            ]
    except ValueError as error:
        raise Refused(str(error)) from None
    return (*cells, *helpers)


def defining_cell(cells: Iterable[str], name: str) -> str:
    """Return the last cell that defines a function, class or variable of this name; an empty text if none does.

    Examples
    --------
    >>> defining_cell(["def double(x): ...", "double = lambda x: 2 * x", "double(3)"], "double")
    'double = lambda x: 2 * x'
    """
    defines = re.compile(
        rf"^\s*+(?:(?:async\s++)?def|class)\s++{re.escape(name)}\b|^{re.escape(name)}\s*+[=:]", re.M
    )
    return next((cell for cell in reversed(list(cells)) if defines.search(cell)), "")


def _without_outputs(name: str, size: int, parts: Iterable[bytes]) -> bytes:
    return definitions.without_outputs(name, b"".join(parts))
