"""Detection of definitions that are out of date because the cell that should have replaced them failed."""

from __future__ import annotations

import re
import sys
from typing import Any

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
                self._why[name] = _said(result.error_before_exec or result.error_in_exec)
        self._before = {}


def _said(error: BaseException | None) -> str:
    """Describe an error in a few words, with its line in the cell if that is known."""
    if not isinstance(error, SyntaxError):
        return f"{type(error).__name__}: {error}"
    line = f", line {error.lineno}" if error.lineno else ""
    return f"{type(error).__name__}{line}: {error.msg}"


FAILED_CELLS = FailedCells()  # of this kernel
