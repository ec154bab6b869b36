"""Detection of definitions that are missing or out of date because a cell failed or uses their name again."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from nao_course.exercises.definitions import Skipped

_SYNTAX_ERRORS = {"SyntaxError", "IndentationError", "TabError"}
_PLACE = re.compile(r" \(<[^<>]*>, line \d+\)$")  # which Python adds to the message of a syntax error
_LONGEST_MESSAGE = 200  # characters of an error's message
_REUSED = re.compile(r"\bthe notebook's name (\w{1,100}) is of type ")
# The names before "=" or "in" at the beginning of a line; one pass, because a line may be as long as a notebook.
_ASSIGNED = re.compile(r"^(?:for\b)?([\w., ]+?)(?:=(?!=)|(?<![\w.])in\b)", re.MULTILINE)
_DEFINITION = re.compile(r"^(?:async +def|def|class) +(\w+)", re.MULTILINE)


class FailedCells:
    """A record of the definitions that are missing because a notebook's cell failed.

    A cell with a syntax error does not run at all; a cell that raises may end before a definition. In both cases the
    name refers to an older definition, or to nothing.
    """

    def __init__(self) -> None:
        """Create an empty record."""
        self._shell: Any = None
        self._before: dict[str, object] = {}
        self._why: dict[str, str] = {}

    def watch(self) -> None:
        """Record the failures of this notebook's cells; do nothing outside of Jupyter or if it is recorded already."""
        ipython = sys.modules.get("IPython")
        shell = ipython.get_ipython() if ipython else None
        if shell is None or shell is self._shell:
            return
        self._shell = shell
        self._why.clear()
        shell.events.register("pre_run_cell", self._begin)
        shell.events.register("post_run_cell", self._end)

    def why_old(self, name: str) -> str:
        """Return why the latest cell that should define a name failed; empty if it succeeded."""
        if name in self._before and self._shell.user_ns.get(name) is not self._before[name]:
            return ""  # the cell that is running has defined it before it called the check
        why = self._why.get(name)
        return f"The cell that defines {name} did not run: {why}." if why else ""

    def _begin(self, info: Any) -> None:
        names = _DEFINITION.findall(str(info.raw_cell or ""))
        self._before = {name: self._shell.user_ns.get(name) for name in names}

    def _end(self, result: Any) -> None:
        for name, before in self._before.items():
            if result.success or self._shell.user_ns.get(name) is not before:
                self._why.pop(name, None)
            else:
                self._why[name] = _describe_error(result.error_before_exec or result.error_in_exec)
        self._before = {}


def _describe_error(error: BaseException | None) -> str:
    """Describe an error in a few words, with its line in the cell if that is known."""
    if not isinstance(error, SyntaxError):
        return f"{type(error).__name__}: {error}"
    line = f", line {error.lineno}" if error.lineno else ""
    return f"{type(error).__name__}{line}: {error.msg}"


FAILED_CELLS = FailedCells()  # of this kernel


def defining_cell(name: str, sources: Sequence[str]) -> tuple[int, list[str], int]:
    """Find the last code cell that begins to define a function or class, without running anything.

    Return the cell's number from 1, its lines, and the index of the definition's line; the number is 0 if there is
    none.
    """
    begins = re.compile(rf"(?:async +)?(?:def|class) +{re.escape(name)}\b")
    for number in range(len(sources), 0, -1):
        lines = sources[number - 1].splitlines()
        if starts := [index for index, line in enumerate(lines) if begins.match(line)]:
            return number, lines, starts[-1]
    return 0, [], 0


def why_missing(name: str, skipped: Iterable[Skipped], sources: Sequence[str]) -> str:
    """Return why the cell that defines a function or class failed, in a sentence; empty if it did not fail."""
    cell, _, start = defining_cell(name, sources)
    for each in skipped:
        kind, _, message = each.reason.partition(":")
        said = f"{kind}: {_PLACE.sub('', message)[:_LONGEST_MESSAGE].strip()}"
        if each.cell == cell > 0 and kind in _SYNTAX_ERRORS:
            return (
                f"Code cell {cell}, which defines it, cannot run: {kind} in line {each.line}:{said.partition(':')[2]}. "
                "Correct this line, restart the kernel and run all cells."
            )
        if each.cell == cell > 0 and each.line == start + 1:
            return (
                f"Code cell {cell}, which defines it, stops in line {each.line}: {said}. Correct this cell, restart "
                "the kernel and run all cells."
            )
    return ""


def where_reused(lines: Iterable[str], sources: Sequence[str]) -> list[str]:
    """Name the code cell that uses the name of a module or function for a value, if a report says that one does."""
    for name in _REUSED.findall("\n".join(lines))[:1]:
        cells = [
            number
            for number, source in enumerate(sources, start=1)
            if any(name in re.split(" *, *", found[1].strip()) for found in _ASSIGNED.finditer(source))
        ]
        if cells:
            return [f"Code cell {cells[-1]} gives the name {name} to that value."]
    return []
