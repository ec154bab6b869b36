"""The functions and classes that a notebook defines, without running the rest of it."""

from __future__ import annotations
import __future__

import ast
import builtins
import contextlib
import dis
import inspect
import linecache
import re
import sys
import warnings
from collections.abc import Callable, Coroutine, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
from typing import Any

from nao_course.exercises import earlier as earlier_lessons
from nao_course.exercises.cells import GIVEN, NOT_RUN
from nao_course.exercises.notebook_text import NotebookText, read_notebook
from nao_course.exercises.outline import UNKNOWN, Outline
from nao_course.exercises.running import REFERENCE, TimeIsUp, describe
from nao_course.exercises.statements import Program, is_doubled, is_under_main, parse, targets, unwritten
from nao_course.exercises.versions import numbers

MOST_ANALYSED = 2**18  # characters of code; of a larger notebook, only statements of the types in _RUN run
MOST_LISTED = 10  # cells that define one exercise
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
_CHECKED = re.compile(r"\bcheck\(\s*+[\"'](\w+)")
_GONE = object()  # in place of the value of a deleted name
_OF_IPYTHON = {"display", "get_ipython"}
_IMPORTED_AS = {  # modules that a notebook gives a short name
    "np": "import numpy as np",
    "cv": "import cv2 as cv",
    "cv2": "import cv2",
    "plt": "import matplotlib.pyplot as plt",
    "sp": "import sympy as sp",
}
_LONGEST_CHECK = 1000  # characters of a cell that is looked through for calls of check


@dataclass(frozen=True)
class Skipped:
    """A statement that did not run, or failed: cell and line in it, from 1, and the reason; 0 is the whole cell."""

    cell: int
    line: int
    reason: str


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
    remarks : mapping of str to tuple of str
        What is unusual about the cells of an exercise or question, by its name: for the student and the assistant.
    """

    found: Mapping[str, Any]
    skipped: tuple[Skipped, ...] = ()
    namespace: dict[str, Any] = field(default_factory=dict, repr=False)
    text: NotebookText = field(default_factory=lambda: NotebookText(), repr=False)
    remarks: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

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
    released: Outline = UNKNOWN,
) -> Definitions:
    """Load the functions and classes that a notebook defines.

    The statements of solution cells and of cells that the student added run in document order:

    - imports, definitions, assignments, and if, for, try, with and match statements;
    - any other statement, such as ``T.sort()``, ``fill(T)``, ``del T["b"]`` or a while statement, if it may change
      something that an exercise depends on, and so ``if __name__ == "__main__":``. Calls that only show or check
      something do not run.

    An error in one statement does not stop the others. From the set-up cell, only imports and
    ``name = earlier("01:name")`` run. Checks and demonstrations do not run; a statement of a cell that the student has
    changed runs if an exercise depends on it.

    The last definition of a name is used, with two exceptions. A blank definition of an exercise, or one with more
    blank methods, does not replace an earlier one. If a cell deletes or changes what an exercise depends on, after the
    exercise's last check, then the exercise uses it as it was at that check, and others use it as it is later.

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
    released : Outline
        As in `read_notebook`.

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
    text = read_notebook(path, released)
    loading = _Loading(Path(path), text, setup, released)
    loading.run(before, earlier, dict(instead or {}))
    return loading.definitions()


class _Loading:
    """A notebook while its statements run."""

    def __init__(self, path: Path, text: NotebookText, setup: str, released: Outline) -> None:
        self.path, self.text, self.has_setup = path, text, bool(setup)
        self.cells = [("setup", setup), *text.cells, ("instead", "pass")]
        module = ModuleType(f"notebook_{path.stem}")
        sys.modules[module.__name__] = module  # dataclasses look up the module they are made in
        self.namespace = module.__dict__
        # Since Python 3.14, an annotation may name what is defined later, or nowhere.
        self.flags = __future__.annotations.compiler_flag if numbers(text.python) >= (3, 14) else 0
        self.defined: dict[str, None] = {}
        self.skipped: list[Skipped] = []
        self.parsed: dict[int, list[ast.stmt]] = {}
        self.program = Program(self._all_statements())
        checked = {name for role, source in text.cells for name in _checked(role, source)}
        self.exercises = released.exercises or checked
        self.needed = self.program.needed_by(released.exercises or self.program.bound)
        self.functions: dict[str, tuple[Any, int]] = {}  # the last one of each exercise, and its cell
        self.versions: dict[str, dict[int, None]] = {}  # cells that define an exercise
        self.at_check: dict[str, dict[str, Any]] = {}  # values that an exercise depends on, at its check
        self.not_yet: dict[
            str, list[str]
        ] = {}  # names that an exercise uses and that are not defined at its check
        self.blanks: dict[str, int] = {}  # blank parts of each exercise's definition
        self.set_in: dict[str, int] = {}  # the last cell that set a name

    def _all_statements(self) -> Iterator[ast.stmt]:
        """Parse the cells of a notebook of normal size, and yield their statements; of others, the imports."""
        if sum(len(source) for _, source in self.cells) > MOST_ANALYSED:
            return
        for number, (role, source) in enumerate(self.cells):
            if role in NOT_RUN or not source.strip():
                continue
            try:
                self.parsed[number] = parse(source, self._file(number))
            except (SyntaxError, ValueError, RecursionError, MemoryError):
                continue  # it is named where the cell would run
            yield from (each for each in self.parsed[number] if role != "setup" or isinstance(each, _IMPORTS))

    def _file(self, number: int) -> str:
        return f"<{self.path.stem}, cell {number}>"

    def run(
        self, before: Callable[[int, int], bool], earlier: Callable[[str], Any], instead: dict[str, str]
    ) -> None:
        """Run the statements that define something."""
        missing = dict(instead)
        for number, (role, source) in enumerate(self.cells):
            file = self._file(number)
            if role in NOT_RUN:
                self._note_checks(_checked(role, source))
                continue
            if not source.strip():
                continue
            linecache.cache[file] = (len(source), None, source.splitlines(keepends=True), file)
            try:
                statements = self.parsed.get(number) or parse(source, file)
            except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
                self._skip_cell(number, source, error)
                continue
            for statement, origin in _with_others(statements, file, role, instead, missing):
                if use := earlier_lessons.assigned_use(statement) if role in ("setup", "edited") else None:
                    if number == 0 or not self.has_setup:
                        self._define_earlier(number, statement, use, earlier)
                elif role == "setup" and not isinstance(statement, _IMPORTS):
                    continue
                elif not self._runs(statement, role):
                    if not _is_text(statement):
                        self._skip(number, statement, NO_DEFINITION)
                elif not self._is_worse(statement, number):
                    self._execute(number, statement, origin, before)
                self._note_checks(_checks(statement))

    def _runs(self, statement: ast.stmt, role: str) -> bool:
        """Return whether a statement may define something that is graded."""
        if isinstance(statement, _RUN) and role != "edited" and not is_under_main(statement):
            return True
        if not self.parsed:
            return isinstance(statement, _IMPORTS)
        return self.program.may_set(statement, self.needed)

    def _is_worse(self, statement: ast.stmt, number: int) -> bool:
        """Return whether a statement defines an exercise that has an earlier definition with fewer blank parts."""
        name = getattr(statement, "name", "")
        if name not in self.exercises:
            return False
        self.versions.setdefault(name, {})[number] = None
        return name in self.functions and unwritten(statement) > self.blanks[name]

    def _execute(
        self, number: int, statement: ast.stmt, origin: str, before: Callable[[int, int], bool]
    ) -> None:
        """Run a statement, and record what it defines."""
        if not before(number, statement.lineno):
            self._skip(number, statement, "left out")
            return
        if isinstance(statement, ast.If) and is_under_main(statement):
            statement.test = ast.copy_location(ast.Constant(True), statement)
        held = dict(self.namespace)
        try:
            code = _compile(statement, origin, self.flags)
            self.flags |= code.co_flags & __future__.annotations.compiler_flag
            awaited = eval(code, self.namespace)
            if code.co_flags & inspect.CO_COROUTINE:
                _run_to_its_end(awaited)
        except (KeyboardInterrupt, TimeIsUp):
            raise
        except MemoryError as error:  # there may be none left for more than this
            self._skip(number, statement, describe(error))
            return
        except BaseException as error:  # noqa: BLE001 - whatever it raises, the next statement runs
            self._skip(number, statement, describe(error))
        self.namespace.pop("__annotate__", None)  # Python 3.14 makes this function of `size: int = 3`
        changed = [name for name, value in self.namespace.items() if held.get(name, held) is not value]
        imported = isinstance(statement, _IMPORTS)
        self.set_in.update(dict.fromkeys((*changed, *(held.keys() - self.namespace.keys())), number))
        for name in changed:
            value = self.namespace[name]
            if imported and not _stands_beside(value, self.path):
                continue
            self.defined[name] = None
            if name in self.exercises and callable(value):
                self.functions[name], self.blanks[name] = (value, number), unwritten(statement)
                self.versions.setdefault(name, {})[number] = None

    def _define_earlier(
        self, number: int, statement: ast.stmt, use: tuple[str, str], earlier: Callable[[str], Any]
    ) -> None:
        """Define a function of an earlier lesson."""
        try:
            self.namespace[use[0]] = earlier(use[1])
        except Exception as error:  # noqa: BLE001 - an unknown lesson, or a lesson that cannot be loaded
            self._skip(number, statement, describe(error))

    def _skip(self, number: int, statement: ast.stmt, reason: str) -> None:
        self.skipped.append(Skipped(number, statement.lineno, reason))

    def _skip_cell(self, number: int, source: str, error: Exception) -> None:
        """Record a cell that is not Python."""
        reason = describe(error)
        if is_doubled(source):
            reason = f"{type(error).__name__}: the cell contains its text twice, so delete the second half"
        self.skipped.append(Skipped(number, getattr(error, "lineno", 0) or 0, reason))

    def _note_checks(self, names: Sequence[str]) -> None:
        """Keep the values that exercises depend on, as they are where the exercises are checked."""
        for name in names:
            if name in self.exercises and name in self.functions:
                needs = self.program.needed_by([name], without=self.exercises)
                known = vars(builtins) | self.namespace
                self.at_check[name] = {each: known[each] for each in needs if each in known}
                self.not_yet[name] = self._missing_names(name)

    def definitions(self) -> Definitions:
        """Return what the notebook defines, after all of its statements have run."""
        remarks: dict[str, dict[str, None]] = {}

        def remark(name: str, text: str) -> None:
            remarks.setdefault(name, {})[text] = None

        for name, (function, cell) in self.functions.items():
            if self.namespace.get(name) is not function:
                self.namespace[name] = function
                later = self.set_in.get(name, cell)
                remark(
                    name,
                    f"Code cell {later} deletes the name {name} or gives it to something that is not a function. "
                    f"The function of code cell {cell} is graded.",
                )
            if len(cells := self.versions[name]) > 1:
                listed = ", ".join(map(str, list(cells)[:MOST_LISTED]))
                remark(
                    name,
                    f"It is defined in code cells {listed}. The definition in code cell {cell} is graded.",
                )
        restored: dict[str, Any] = {}  # of exercises that cannot have names of their own, such as a class
        for name, values in self.at_check.items():
            changed = [
                each
                for each, value in values.items()
                if each not in self.functions
                and _is_changed(value, self.namespace.get(each, vars(builtins).get(each, _GONE)))
            ]
            has_own = bool(changed) and self._uses_names_at_check(name)
            for each in changed:
                is_lost = not has_own and callable(self.namespace.get(each))
                restored |= {} if has_own or is_lost else {each: values[each]}
                version = "as it is defined later" if is_lost else "as it was at the check"
                remark(
                    name,
                    f"It depends on {each}, which code cell {self.set_in.get(each, 0)} changes after the check. It is "
                    f"graded with {each} {version}. Give one of the two another name.",
                )
        self.namespace.update(restored)
        for name, names in self.not_yet.items():
            for each in [each for each in names if each in self.namespace][:MOST_LISTED]:
                remark(
                    name,
                    f"Its check comes before code cell {self.set_in.get(each, 0)}, which defines {each}, so the check "
                    f"fails when all cells run in order. It is graded with {each}. Move that cell up.",
                )
        for name in self.functions:
            for each in self._missing_names(name)[:MOST_LISTED]:
                how = _IMPORTED_AS.get(each) or (f"import {each}" if each in sys.stdlib_module_names else "")
                advice = f"Write `{how}` into a cell" if how else "Import or define it in a cell"
                remark(
                    name,
                    f"It uses the name {each}, which no cell that the grader runs defines. {advice}, restart the "
                    "kernel and run all cells.",
                )
        found = {name: self.namespace[name] for name in self.defined if callable(self.namespace.get(name))}
        for name, why in self.text.elsewhere.items():
            if name not in found or self.blanks.get(name):
                remark(name, why)
        for name, why in self.text.remarks.items():
            remark(name, why)
        told = {name: tuple(texts) for name, texts in remarks.items()}
        return Definitions(found, tuple(self.skipped), self.namespace, self.text, told)

    def _missing_names(self, name: str) -> list[str]:
        """Return the global names that an exercise uses and that nothing defines up to now."""
        if all(each in self.namespace or _is_known(each) for each in self.program.needed_by([name])):
            return []
        return _missing_names(self.namespace.get(name), self.namespace)

    def _uses_names_at_check(self, name: str) -> bool:
        """Let an exercise use all names as they were at its check, if its check was of the graded function."""
        function = self.functions[name][0]
        values = self.at_check[name]
        if values.get(name) is not function or not _is_of(function, self.namespace):
            return False
        shared = {each: value for each, value in self.namespace.items() if each not in self.exercises}
        own = _AtCheck(self.namespace, shared)
        own.update((each, _with_globals(value, own)) for each, value in values.items() if each != name)
        self.namespace[name] = _with_globals(function, own)
        return True


class _AtCheck(dict[str, Any]):
    """Global names of an exercise and its helpers; the exercises in it are always the notebook's own."""

    def __init__(self, notebook: Mapping[str, Any], names: Mapping[str, Any]) -> None:
        super().__init__(names)
        self._notebook = notebook

    def __missing__(self, name: str) -> Any:
        return self._notebook[name]


def _missing_names(function: Any, namespace: Mapping[str, Any]) -> list[str]:
    """Return the global names that a function and its helpers in the notebook read and that nothing defines."""
    missing = dict[str, None]()
    waiting, seen = [function.__code__] if type(function) is FunctionType else [], set[int]()
    while waiting:
        code = waiting.pop()
        if id(code) in seen:
            continue
        seen.add(id(code))
        waiting += [each for each in code.co_consts if isinstance(each, CodeType)]
        for name in {each.argval for each in dis.get_instructions(code) if each.opname == "LOAD_GLOBAL"}:
            if type(value := namespace.get(name)) is FunctionType:
                waiting.append(value.__code__)
            elif name not in namespace and not _is_known(name):
                missing[name] = None
    return sorted(missing)


def _is_known(name: str) -> bool:
    return hasattr(builtins, name) or name in _OF_IPYTHON


def _is_of(value: Any, namespace: Mapping[str, Any]) -> bool:
    """Return whether a value is a function with these global names; a student's object is not asked for its class."""
    return type(value) is FunctionType and value.__globals__ is namespace


def _with_globals(value: Any, own: _AtCheck) -> Any:
    """Return a function of the notebook with other global names, and any other value as it is."""
    if not _is_of(value, own._notebook):
        return value
    made = FunctionType(value.__code__, own, value.__name__, value.__defaults__, value.__closure__)
    made.__kwdefaults__ = value.__kwdefaults__
    made.__dict__.update(value.__dict__)
    return made


def demonstrated(cells: Sequence[tuple[str, str]]) -> list[str]:
    """Return, in alphabetical order, the names that are assigned only in cells which the grader does not run.

    The cells are roles and sources, as `read_cells` returns them.

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
        if not earlier_lessons.assigned_use(statement):
            yield from targets(statement)


def _checked(role: str, source: str) -> list[str]:
    """Return the exercises that a released check is about."""
    return _CHECKED.findall(source[:_LONGEST_CHECK]) if role == "check" else []


def _checks(statement: ast.stmt) -> list[str]:
    """Return the exercise that a statement of the student's checks."""
    match statement:
        case ast.Expr(ast.Call(ast.Name("check"), [ast.Constant(str(name)), *_])):
            return [name]
    return []


def _is_changed(before: Any, now: Any) -> bool:
    """Return whether a name that had one value has another value; the same cell run twice changes nothing."""
    # isinstance and == would ask a student's class.
    if before is now or (
        type(before) is type(now) and type(now) in (bool, int, float, str) and before == now
    ):
        return False
    if type(now) is FunctionType and type(before) is FunctionType:
        return before.__code__ != now.__code__
    is_function = type(now) is FunctionType and type(before) is BuiltinFunctionType
    return is_function or not (callable(before) and callable(now))


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
    flags |= ast.PyCF_ALLOW_TOP_LEVEL_AWAIT  # as in Jupyter
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return compile(ast.Module([statement], []), file, "exec", flags, dont_inherit=True)


def _run_to_its_end(awaited: Coroutine[Any, Any, Any]) -> None:
    """Run a cell's coroutine; without an event loop, because a sandboxed process cannot have one."""
    with contextlib.suppress(StopIteration):
        while True:
            awaited.send(None)


def _stands_beside(value: Any, notebook: Path) -> bool:
    """Return whether an object comes from a file of the student's own, in the notebook's folder."""
    file = getattr(sys.modules.get(getattr(value, "__module__", None) or ""), "__file__", None)
    return bool(file) and Path(str(file)).resolve().parent == notebook.resolve().parent


def _is_text(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)
