"""The functions and classes that a notebook defines, without running the rest of it."""

from __future__ import annotations

import ast
import json
import linecache
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import Any

MOST_BYTES = 50 * 2**20
_RUN = (
    ast.Import,
    ast.ImportFrom,
    ast.FunctionDef,
    ast.AsyncFunctionDef,
    ast.ClassDef,
    ast.Assign,
    ast.AugAssign,
    ast.AnnAssign,
    ast.If,
    ast.For,
    ast.Try,
    ast.With,
)


@dataclass(frozen=True)
class Skipped:
    """A statement that did not run, or failed.

    Parameters
    ----------
    cell : int
        Number of the code cell, from 1.
    line : int
        Line in the cell, from 1; 0 for the whole cell.
    reason : str
        Why.
    """

    cell: int
    line: int
    reason: str


@dataclass(frozen=True)
class Definitions(Mapping[str, Any]):
    """What a notebook defines: a read-only mapping of its functions and classes.

    Parameters
    ----------
    found : mapping of str to object
        By name.
    skipped : tuple of Skipped
        What did not run.
    """

    found: Mapping[str, Any]
    skipped: tuple[Skipped, ...] = field(default=())

    def __getitem__(self, name: str) -> Any:
        """Return a function or class."""
        return self.found[name]

    def __iter__(self) -> Iterator[str]:
        """Names, in the order of their definition."""
        return iter(self.found)

    def __len__(self) -> int:
        """How many there are."""
        return len(self.found)


def load_definitions(path: str | Path) -> Definitions:
    """Load the functions and classes that a notebook defines.

    Runs, in document order, the imports, definitions, assignments and if, for, try and with statements of solution
    cells and of cells the student added, each guarded; of the set-up cell only its imports. Checks and
    demonstrations do not run. The last definition of a name wins.

    Parameters
    ----------
    path : str or Path
        A notebook.

    Returns
    -------
    Definitions
        What it defines.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        If it is no notebook; the message says what is wrong.
    """
    cells = read_cells(path)
    namespace: dict[str, Any] = {"__name__": "student", "__builtins__": __builtins__}
    defined: dict[str, None] = {}
    skipped: list[Skipped] = []
    for number, (role, source) in enumerate(cells, start=1):
        if role in ("check", "display"):
            continue
        file = f"<{Path(path).stem}, cell {number}>"
        linecache.cache[file] = (len(source), None, source.splitlines(keepends=True), file)
        try:
            statements = ast.parse(_without_magics(source), file).body
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            skipped.append(
                Skipped(number, getattr(error, "lineno", 0) or 0, f"{type(error).__name__}: {error}")
            )
            continue
        for statement in statements:
            imports = isinstance(statement, ast.Import | ast.ImportFrom)
            if role == "setup" and not imports:
                continue
            if not isinstance(statement, _RUN):
                if not _is_text(statement):
                    skipped.append(Skipped(number, statement.lineno, "not a definition"))
                continue
            before = dict(namespace)
            try:
                exec(compile(ast.Module([statement], []), file, "exec"), namespace)
            except KeyboardInterrupt:
                raise
            except BaseException as error:  # noqa: BLE001 - whatever it raises, the next statement runs
                skipped.append(Skipped(number, statement.lineno, f"{type(error).__name__}: {error}"))
            if not imports:
                defined.update(
                    dict.fromkeys(
                        name
                        for name, value in namespace.items()
                        if name not in before or before[name] is not value
                    )
                )
    found = {
        name: namespace[name]
        for name in defined
        if name in namespace and callable(namespace[name]) and not isinstance(namespace[name], ModuleType)
    }
    return Definitions(found, tuple(skipped))


def read_cells(path: str | Path) -> list[tuple[str, str]]:
    """Code cells of a notebook as (role, source); roles are solution, setup, check, display and student."""
    file = Path(path)
    if file.stat().st_size > MOST_BYTES:
        raise ValueError(
            f"{file.name}: larger than {MOST_BYTES // 2**20} MB, which no notebook of this course is"
        )
    try:
        notebook = json.loads(file.read_bytes().decode("utf-8-sig"))
        cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
        return [(_role(cell), _source(cell)) for cell in cells]
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
        raise ValueError(
            f"{file.name}: not a notebook of format 4 ({type(error).__name__}: {error})"
        ) from None


def _role(cell: dict[str, Any]) -> str:
    metadata = cell.get("metadata") or {}
    grading = metadata.get("nbgrader") or {}
    if grading.get("solution"):
        return "solution"
    if grading.get("grade"):
        return "check"
    return str((metadata.get("nao_course") or {}).get("role", "student"))


def _source(cell: dict[str, Any]) -> str:
    source = cell["source"]
    return source if isinstance(source, str) else "".join(source)


def _without_magics(source: str) -> str:
    """Source with IPython's own lines commented out: they are no Python."""
    lines = source.splitlines(keepends=True)
    return "".join("#" + line if line.lstrip().startswith(("%", "!", "?")) else line for line in lines)


def _is_text(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)
