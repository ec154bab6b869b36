"""The functions and classes that a notebook defines, without running the rest of it."""

from __future__ import annotations
import __future__

import ast
import json
import linecache
import math
import re
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

from nao_course._internal.text_encodings import NotTextError, decode_text
from nao_course.exercises import earlier as earlier_lessons
from nao_course.exercises.cells import GIVEN, NOT_RUN, grade_id, is_graded, is_solution, metadata, source_of
from nao_course.exercises.running import REFERENCE, TimeIsUp, describe
from nao_course.exercises.versions import numbers

MOST_BYTES = 50 * 2**20
LARGEST_CODE = 12 * 2**20  # bytes of a notebook without its outputs
# Number of Python files beside a notebook that are included, and their largest size in bytes.
MOST_HELPERS, LARGEST_HELPER = 20, 2**20
# Characters of a cell with commands of IPython, which parses the cell again for each command.
LONGEST_COMMANDED = 20_000
LONGEST_NUMBER = 1000  # digits
MOST_WRITTEN = 2**16  # characters of a written answer
NO_DEFINITION = "not a definition"
_IMPORTS = (ast.Import, ast.ImportFrom)
_RUN = (
    *_IMPORTS,
    ast.FunctionDef,
    ast.AsyncFunctionDef,
    ast.ClassDef,
    ast.Assign,
    ast.AugAssign,
    ast.AnnAssign,
    ast.If,
    ast.For,
    ast.Try,
    ast.TryStar,
    ast.With,
    ast.Match,
    getattr(ast, "TypeAlias", ast.Assign),  # since Python 3.12
)
# Methods that add to a list, set or dict.
_FILLS = {"append", "extend", "insert", "add", "update", "setdefault"}
_BLANKS = re.compile(r"([ \t]{99}|\n{99})[ \t\n]++")  # what goes beyond
_EMPTY = re.compile(r"(?:[ \t\f\r]*+\n)*+")  # the empty lines at the beginning, which IPython drops
_PASTED = re.compile(r"[ \t]|>>>|In \[")  # IPython removes a first line's indentation and copied prompts
_CELL_MAGIC = re.compile(r"\s*%%(?:time|timeit|capture|prun)\b.*")  # magics that run the cell as Python
_DEFINES = re.compile(r"^[ \t]*+(?:async[ ]+)?(?:def|class)[ ]|\blambda\b", re.MULTILINE)


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
        Why it did not run.
    """

    cell: int
    line: int
    reason: str


@dataclass(frozen=True)
class NotebookText:
    """The contents of a notebook before any of its code runs.

    Parameters
    ----------
    cells : list of (str, str)
        Role and source of each code cell; roles are solution, setup, check, display and student.
    written : mapping of str to str
        Written answers by the name of their cell; at most MOST_WRITTEN characters each.
    lesson, version : str
        Lesson and version in the notebook's metadata; empty if they are missing.
    python : str
        Version of Python of the kernel that saved it, such as "3.11.7"; empty if it is missing.
    """

    cells: list[tuple[str, str]] = field(default_factory=list)
    written: Mapping[str, str] = field(default_factory=dict)
    lesson: str = ""
    version: str = ""
    python: str = ""


@dataclass(frozen=True, eq=False)
class Definitions(Mapping[str, Any]):
    """The functions and classes that a notebook defines, as a read-only mapping.

    Parameters
    ----------
    found : mapping of str to object
        Functions and classes by name.
    skipped : tuple of Skipped
        Statements that did not run.
    namespace : dict
        Global namespace of the functions.
    text : NotebookText
        Further contents of the notebook.
    """

    found: Mapping[str, Any]
    skipped: tuple[Skipped, ...] = ()
    namespace: dict[str, Any] = field(default_factory=dict, repr=False)
    text: NotebookText = field(default_factory=lambda: NotebookText(), repr=False)

    def __getitem__(self, name: str) -> Any:
        """Return a function or class."""
        return self.found[name]

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names in the order of their definition."""
        return iter(self.found)

    def __len__(self) -> int:
        """Count the names."""
        return len(self.found)


def not_asked_for(use: str) -> Any:
    """Replace a function of an earlier lesson if the caller has not chosen a version of it."""
    return earlier_lessons.stand_in(use, earlier_lessons.not_usable(use, "its notebook is missing."))


def load_definitions(
    path: str | Path,
    before: Callable[[int, int], bool] = lambda cell, line: True,
    setup: str = "",
    earlier: Callable[[str], Any] = not_asked_for,
    instead: Mapping[str, str] | None = None,
) -> Definitions:
    """Load the functions and classes that a notebook defines.

    The statements of solution cells and of cells that the student added run in document order: imports, definitions,
    assignments, calls such as `table.append(x)` and `exec(text)`, and if, for, try, with and match statements. An error
    in one of them does not stop the others. From the set-up cell, only imports and ``name = earlier("01:name")`` run.
    Checks and demonstrations do not run. The last definition of a name is used.

    Parameters
    ----------
    path : str or Path
        Path of the notebook.
    before : callable
        Called with cell and line before each statement; a statement is skipped if it returns False.
    setup : str
        Source of a set-up cell that runs first, as cell 0, because a student may have edited the notebook's own. Only
        its functions of earlier lessons are then available.
    earlier : callable
        Called with "01:name"; returns the function to use for that function of an earlier lesson.
    instead : mapping of str to str, optional
        Sources by class name. A source runs in place of the notebook's definition of the class, or at the end if the
        notebook does not define it.

    Returns
    -------
    Definitions
        The functions and classes.

    Raises
    ------
    FileNotFoundError
        If the file does not exist.
    ValueError
        If it is not a notebook; the message explains why.
    TimeIsUp
        If the time of an `alarm` around it is up.
    """
    text = read_notebook(path)
    missing = dict(instead or {})
    module = ModuleType(f"notebook_{Path(path).stem}")
    sys.modules[module.__name__] = module  # dataclasses look up the module they are made in
    namespace = module.__dict__
    defined: dict[str, None] = {}
    skipped: list[Skipped] = []
    # Since Python 3.14, an annotation may name what is defined later, or nowhere.
    flags = __future__.annotations.compiler_flag if numbers(text.python) >= (3, 14) else 0
    for number, (role, source) in enumerate([("setup", setup), *text.cells, ("instead", "pass")]):
        if role in NOT_RUN or not source.strip():
            continue
        file = f"<{Path(path).stem}, cell {number}>"
        linecache.cache[file] = (len(source), None, source.splitlines(keepends=True), file)
        try:
            statements = parse(source, file)
        except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
            skipped.append(Skipped(number, getattr(error, "lineno", 0) or 0, describe(error)))
            continue
        for statement, origin in _with_others(statements, file, role, instead or {}, missing):
            imports = isinstance(statement, _IMPORTS)
            if role == "setup" and not imports:
                if (number == 0 or not setup) and (use := earlier_lessons.assigned_use(statement)):
                    try:
                        namespace[use[0]] = earlier(use[1])
                    except Exception as error:  # noqa: BLE001 - an unknown lesson, or a lesson that cannot be loaded
                        skipped.append(Skipped(number, statement.lineno, describe(error)))
                continue
            if not isinstance(statement, _RUN) and not _may_define(statement):
                if not _is_text(statement):
                    skipped.append(Skipped(number, statement.lineno, NO_DEFINITION))
                continue
            if not before(number, statement.lineno):
                skipped.append(Skipped(number, statement.lineno, "left out"))
                continue
            held = dict(namespace)
            try:
                code = _compile(statement, origin, flags)
                flags |= code.co_flags & __future__.annotations.compiler_flag
                exec(code, namespace)
            except (KeyboardInterrupt, TimeIsUp):
                raise
            except BaseException as error:  # noqa: BLE001 - whatever it raises, the next statement runs
                skipped.append(Skipped(number, statement.lineno, describe(error)))
            changed = [name for name, value in namespace.items() if held.get(name, namespace) is not value]
            if imports:
                changed = [name for name in changed if _stands_beside(namespace[name], Path(path))]
            defined.update(dict.fromkeys(changed))
    found = {name: namespace[name] for name in defined if callable(namespace.get(name))}
    return Definitions(found, tuple(skipped), namespace, text)


def demonstrated(cells: Sequence[tuple[str, str]]) -> list[str]:
    """Return the names that are assigned only in cells which the grader does not run.

    Parameters
    ----------
    cells : sequence of (str, str)
        Role and source of each code cell, as `read_cells` returns them.

    Returns
    -------
    list of str
        In alphabetical order.

    Examples
    --------
    >>> demonstrated([("setup", "import numpy as np"), ("display", "mean = 3"), ("solution", "def double(x): ...")])
    ['mean']
    """
    shown, run = set[str](), set[str]()
    for role, source in cells:
        (shown if role in GIVEN else run).update(_assigned(source))
    return sorted(shown - run)


def _assigned(source: str) -> Iterator[str]:
    """Yield the names that a cell assigns or defines, without its imports and its functions of earlier lessons."""
    for statement in parse(source, "<cell>"):
        if isinstance(statement, ast.FunctionDef | ast.ClassDef):
            yield statement.name
        elif not earlier_lessons.assigned_use(statement):
            yield from (
                node.id
                for node in ast.walk(statement)
                if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
            )


def read_cells(path: str | Path) -> list[tuple[str, str]]:
    """Read a notebook's code cells as (role, source); roles are solution, setup, check, display and student."""
    return read_notebook(path).cells


def read_notebook(path: str | Path) -> NotebookText:
    """Read the contents of a notebook.

    Raises
    ------
    FileNotFoundError
        If the file does not exist.
    ValueError
        If it is not a notebook; the message explains why.
    """
    file = Path(path)
    if file.exists() and not file.is_file():
        raise ValueError(f"{file.name}: not a file")
    if file.stat().st_size > MOST_BYTES:
        raise ValueError(f"{file.name}: a notebook may have at most {MOST_BYTES // 2**20} MB")
    return _contents(file.name, file.read_bytes())[0]


def without_outputs(name: str, content: bytes | bytearray) -> bytes:
    """Return a notebook that holds only what is graded: its code, its written answers, and its lesson and version.

    Parameters
    ----------
    name : str
        Name of the file, for the message if it is not a notebook.
    content : bytes
        The notebook.

    Raises
    ------
    ValueError
        If it is not a notebook, or larger than LARGEST_CODE without its outputs; the message explains why.
    """
    text, notebook = _contents(name, content)
    cells = [
        {
            "cell_type": cell["cell_type"],
            "metadata": {key: metadata(cell, key) for key in ("nbgrader", "nao_course")},
            "source": source_of(cell) if cell["cell_type"] == "code" else source_of(cell)[:MOST_WRITTEN],
        }
        for cell in _cells(notebook)
        if cell.get("cell_type") == "code"
        or (cell.get("cell_type") == "markdown" and grade_id(cell) in text.written)
    ]
    kept = {key: metadata(notebook, key) for key in ("kernelspec", "language_info", "nao_course")}
    short = json.dumps({"nbformat": 4, "nbformat_minor": 5, "metadata": kept, "cells": cells}).encode()
    if len(short) > LARGEST_CODE:
        raise ValueError(f"{name}: its code and metadata may have at most {LARGEST_CODE // 2**20} MB")
    return short


def _contents(name: str, content: bytes | bytearray) -> tuple[NotebookText, dict[str, Any]]:
    """Parse a notebook; return what is graded, and all of it."""
    try:
        notebook = json.loads(decode_text(content), parse_int=_whole_number)
        cells = _cells(notebook)
        code = [(_role(cell), source_of(cell)) for cell in cells if cell.get("cell_type") == "code"]
        text = NotebookText(code, _written(cells), *_stamp(notebook))
        language = _language(notebook)
    except RecursionError:
        raise ValueError(f"{name}: not a notebook of format 4 (it is nested too deeply)") from None
    except (ValueError, TypeError, KeyError, AttributeError, MemoryError) as error:
        raise ValueError(f"{name}: not a notebook of format 4 ({_why_unreadable(error)})") from None
    if language and not any(_DEFINES.search(source) for _, source in code):
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
    """Return the cells, and leave out everything that cannot be a cell."""
    if not isinstance(notebook, dict):
        raise _NotebookError("it contains other data than a notebook; save it again with JupyterLab")
    if notebook.get("nbformat", 4) != 4:
        raise _NotebookError(f"its format is {str(notebook['nbformat'])[:20]}; save it again with JupyterLab")
    if not isinstance(notebook.get("cells"), list):
        raise _NotebookError("it has no list of cells; save it again with JupyterLab")
    cells = [cell for cell in notebook["cells"] if isinstance(cell, dict)]
    if notebook["cells"] and not any(_is_whole(cell) for cell in cells):
        raise _NotebookError("none of its cells has a type and a source; save it again with JupyterLab")
    return cells


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


def _written(cells: list[dict[str, Any]]) -> dict[str, str]:
    """Return the written answers; the texts of several cells of one name are kept in their order."""
    answers: dict[str, str] = {}
    for cell in cells:
        if cell.get("cell_type") == "markdown" and is_graded(cell) and is_solution(cell):
            name = _text(grade_id(cell), 100)
            answers[name] = _text(
                "\n\n".join(filter(None, [answers.get(name), source_of(cell)])), MOST_WRITTEN
            )
    return answers


def _stamp(notebook: dict[str, Any]) -> tuple[str, str, str]:
    stamp, language = metadata(notebook, "nao_course"), metadata(notebook, "language_info")
    python = _text(language.get("version", ""), 20) if language.get("name", "python") == "python" else ""
    return _text(stamp.get("lesson", ""), 100), _text(stamp.get("version", ""), 100), python


def _role(cell: dict[str, Any]) -> str:
    if is_solution(cell):
        return "solution"
    if is_graded(cell):
        return "check"
    return str(metadata(cell, "nao_course").get("role", "student"))


def parse(source: str, file: str) -> list[ast.stmt]:
    """Parse a cell's statements; if it is not plain Python, parse it as IPython does, without IPython's commands."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about a student's escapes in strings: their own kernel tells them
        try:
            return ast.parse(source, file).body
        except SyntaxError:
            if len(source) > LONGEST_COMMANDED:
                # A cat on the keyboard; lines are then counted without them
                source = _BLANKS.sub(r"\1", source)
            start = _EMPTY.match(source).end()  # type: ignore[union-attr]
            commands = any(sign in source for sign in "%!?")
            if len(source) > LONGEST_COMMANDED or not (commands or _PASTED.match(source, start)):
                raise
        tree = ast.parse(_as_ipython_reads(source), file)
        return ast.fix_missing_locations(_WithoutCommands().visit(tree)).body


def _as_ipython_reads(source: str) -> str:
    """Return a cell as Python with unchanged line numbers."""
    # The import takes half a second, and few notebooks need it.
    from IPython.core.inputtransformer2 import TransformerManager

    if found := _CELL_MAGIC.match(source):
        source = "#\n" * found[0].count("\n") + "#" + source[found.end() :]
    empty = _EMPTY.match(source)[0]  # type: ignore[index]
    read: str = TransformerManager().transform_cell(source[len(empty) :])
    return "\n" * empty.count("\n") + read


class _WithoutCommands(ast.NodeTransformer):
    """Transformer that removes IPython's commands; the value of a command becomes None."""

    def visit_Call(self, node: ast.Call) -> ast.AST:
        match node.func:
            case ast.Attribute(ast.Call(ast.Name("get_ipython"))):
                return ast.Constant(None)
        return self.generic_visit(node)


def _with_others(
    statements: list[ast.stmt], file: str, role: str, instead: Mapping[str, str], missing: dict[str, str]
) -> Iterator[tuple[ast.stmt, str]]:
    """Yield a cell's statements and their sources, with some classes replaced; the missing classes come last."""
    for statement in statements:
        if isinstance(statement, ast.ClassDef) and statement.name in instead:
            missing.pop(statement.name, None)
            yield from ((each, REFERENCE) for each in ast.parse(instead[statement.name]).body)
        elif role != "instead":
            yield statement, file
    if role == "instead":
        for source in missing.values():
            yield from ((each, REFERENCE) for each in ast.parse(source).body)


def _compile(statement: ast.stmt, file: str, flags: int) -> CodeType:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return compile(ast.Module([statement], []), file, "exec", flags, dont_inherit=True)


def _stands_beside(value: Any, notebook: Path) -> bool:
    """Return whether an object comes from a file of the student's own, in the notebook's folder."""
    file = getattr(sys.modules.get(getattr(value, "__module__", None) or ""), "__file__", None)
    return bool(file) and Path(str(file)).resolve().parent == notebook.resolve().parent


def _may_define(statement: ast.stmt) -> bool:
    """Return whether a statement adds to a list, set or dict that has a name, is `(name := value)`, or calls exec."""
    match statement:
        case ast.Expr(ast.NamedExpr() | ast.Call(ast.Name("exec"))):
            return True
        case ast.Expr(ast.Call(ast.Attribute(ast.Name(), name))):
            return name in _FILLS
    return False


def _is_text(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)
