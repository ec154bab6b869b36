"""Catalogues of mistakes: each mistake is written as a small change of the exercise's solution."""

from __future__ import annotations
import __future__

import ast
import linecache
import textwrap
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from typing import Any

from nao_course.exercises.definitions import Definitions
from nao_course.exercises.exercise import Exercise, LessonPlan, Mistake
from nao_course.exercises.running import describe

ONCE, EVERYWHERE, INSERTED = " =>", " =>>", "+ "
_FLAGS = __future__.annotations.compiler_flag


class ChangeError(ValueError):
    """A change that does not fit the solution; its message says what to write instead."""


@dataclass(frozen=True)
class Change:
    """A change of a solution's text: substitutions and inserted lines in their order, written as in `catalogue`."""

    lines: tuple[str, ...]

    @property
    def inserted(self) -> str:
        """The inserted lines, as one piece of code."""
        return "\n".join(line.removeprefix(INSERTED) for line in self.lines if line.startswith(INSERTED))

    def __call__(self, *args: object, **kwargs: object) -> object:
        """Raise a ChangeError: only a change that was applied to a solution can be called."""
        raise ChangeError("this mistake is a change of a solution: apply it with with_functions()")

    def applied_to(self, source: str, name: str) -> str:
        """Return the cell that defines a function or class with this change.

        Raise a ChangeError if a fragment that should be replaced occurs nowhere, or several times.
        """
        lines = source.splitlines()
        documented = set(_docstring_lines(ast.parse(source)))
        at, indent = _first_line(ast.parse(source), name)
        for change in self.lines:
            if change.startswith(INSERTED):
                lines.insert(at, indent + change.removeprefix(INSERTED))
                documented = {each + (each >= at) for each in documented}
                at += 1
                continue
            old, new, everywhere = _substitution(change)
            found = [number for number, line in enumerate(lines) if number not in documented and old in line]
            occurrences = sum(lines[number].count(old) for number in found)
            if not occurrences:
                raise ChangeError(f"the solution has no {old!r}")
            if occurrences > 1 and not everywhere:
                raise ChangeError(
                    f"the solution has {old!r} {occurrences} times; quote more of the line, or write =>>"
                )
            for number in found:
                lines[number] = lines[number].replace(old, new)
            at = found[-1] + 1
            indent = " " * (len(lines[found[-1]]) - len(lines[found[-1]].lstrip()))
        return "\n".join(lines) + "\n"


def catalogue(text: str) -> list[Mistake]:
    """Read mistakes that are written as changes of the exercise's solution.

    A mistake begins with its name and a change. Below it, indented, follow further changes, if any, and then the
    message to the student::

        half degrees: 60 * sixths => 30 * sixths
            Your hues are half of what they should be.
        red and blue swapped: + picture = picture[..., ::-1]
            Red and blue have changed places.

    A long change may also stand on a line of its own below the name.

    ``old => new`` replaces a fragment that occurs once in the solution, docstrings aside; ``old =>> new`` replaces it
    wherever it occurs. ``+ line`` inserts a line: after the last line that a substitution changed, with the same
    indentation, or at the beginning of the function's body if no substitution precedes it. Several changes are applied
    one after the other. Each mistake's function is a `Change` until `with_functions` applies it. Raise a ChangeError if
    a mistake lacks a change or a message.
    """
    records: list[tuple[str, list[str], list[str]]] = []
    for line in textwrap.dedent(text.strip("\n")).splitlines():
        if not line.strip():
            continue
        if not line.startswith(" "):
            name, _, change = line.strip().partition(": ")
            records.append((name, [change], []) if _is_change(change) else (line.strip(), [], []))
            continue
        if not records:
            raise ChangeError(f"a catalogue begins with a mistake's name, not with {line.strip()!r}")
        _, changes, message = records[-1]
        (changes if not message and _is_change(line.strip()) else message).append(line.strip())
    for name, changes, message in records:
        if not changes or not message:
            missing = "change" if not changes else "message"
            raise ChangeError(f"mistake {name!r} has no {missing}")
    return [Mistake(name, Change(tuple(changes)), " ".join(message)) for name, changes, message in records]


def with_functions(plan: LessonPlan, reference: Mapping[str, Callable[..., Any]]) -> LessonPlan:
    """Apply the changes of a plan's mistakes to the solution, so that every mistake can be called.

    The solution's functions are a `Definitions`, if a mistake is a change. Raise a ChangeError with a line for each
    change that does not fit the solution.
    """
    problems: list[str] = []

    def runnable(exercise: Exercise, mistake: Mistake) -> Mistake:
        if not isinstance(mistake.function, Change):
            return mistake
        try:
            return replace(mistake, function=changed(exercise.name, mistake, reference))
        except ChangeError as error:
            problems.append(f"{exercise.name}: mistake {mistake.name!r}: {error}")
            return mistake

    exercises = [
        replace(
            each,
            mistakes=[runnable(each, mistake) for mistake in each.mistakes],
            pairs=partial(changed_twice, each, reference),
        )
        for each in plan.exercises
    ]
    if problems:
        raise ChangeError("\n".join(problems))
    return replace(plan, exercises=exercises)


def changed(exercise: str, mistake: Mistake, reference: Mapping[str, Callable[..., Any]]) -> Any:
    """Return the function or class of a solution with a mistake's change.

    Raise a ChangeError if the change does not fit the solution, or the changed text is not Python.
    """
    assert isinstance(mistake.function, Change)
    if not isinstance(reference, Definitions):
        raise ChangeError("it is a change of the solution, and only functions of the solution are given")
    source = mistake.function.applied_to(_defining_cell(exercise, reference), exercise)
    file = f"<{exercise}, mistake {mistake.name!r}>"
    try:
        tree = ast.parse(source, file)
        tree.body = [each for each in tree.body if not isinstance(each, ast.Expr)]
        code = compile(tree, file, "exec", _FLAGS, dont_inherit=True)
        namespace = dict(reference.namespace)
        exec(code, namespace)
    except Exception as error:
        raise ChangeError(f"the changed solution cannot be run: {describe(error)}") from error
    linecache.cache[file] = (len(source), None, source.splitlines(keepends=True), file)
    return namespace[exercise]


def changed_twice(
    exercise: Exercise, reference: Mapping[str, Callable[..., Any]]
) -> Iterator[tuple[int, int, Any]]:
    """Yield the solution with two mistakes at once, for all pairs whose changes touch different places.

    Yield the numbers of both mistakes, and the function or class with both changes; a mistake that is a function is
    left out.
    """
    changes = [
        (number, each.name, each.function)
        for number, each in enumerate(exercise.mistakes)
        if isinstance(each.function, Change)
    ]
    source = (
        _defining_cell(exercise.name, reference) if isinstance(reference, Definitions) and changes else ""
    )
    for (i, name, first), (j, other, second) in combinations(changes, 2):
        both, swapped = Change(first.lines + second.lines), Change(second.lines + first.lines)
        try:
            texts = [each.applied_to(source, exercise.name) for each in (both, swapped)]
            # Two lines that are inserted at the same place may change their order.
            if sorted(texts[0].splitlines()) == sorted(texts[1].splitlines()):
                yield i, j, changed(exercise.name, Mistake(f"{name} and {other}", both, ""), reference)
        except (ChangeError, SyntaxError):
            continue


@contextmanager
def without_numeric_warnings() -> Iterator[None]:
    """Silence what NumPy and SciPy report about a wrong implementation, such as a division by zero."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        # SciPy gives this one as another kind of warning
        warnings.filterwarnings("ignore", "Matrix is exactly singular")
        yield


def _defining_cell(name: str, reference: Definitions) -> str:
    """Return the last solution cell that defines a function or class of this name."""
    for role, source in reversed(reference.text.cells):
        if role == "solution" and any(_defines(node, name) for node in ast.parse(source).body):
            return source
    raise ChangeError(f"no cell of the solution defines {name}")


def _defines(node: ast.stmt, name: str) -> bool:
    return isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name == name


def _is_change(line: str) -> bool:
    return ONCE in line or line.startswith(INSERTED)


def _substitution(change: str) -> tuple[str, str, bool]:
    """Return the fragment to replace, its replacement, and whether every occurrence is replaced."""
    everywhere = EVERYWHERE in change
    old, _, new = change.partition(EVERYWHERE if everywhere else ONCE)
    return old.strip(), new.strip(), everywhere


def _first_line(tree: ast.Module, name: str) -> tuple[int, str]:
    """Return the first line, counted from 0, of a definition's body after its docstring, and the indentation."""
    (node,) = [each for each in tree.body if _defines(each, name)][-1:]
    assert isinstance(node, ast.FunctionDef | ast.ClassDef)
    first = node.body[ast.get_docstring(node) is not None :] or node.body
    return first[0].lineno - 1, " " * first[0].col_offset


def _docstring_lines(tree: ast.Module) -> Iterator[int]:
    """Yield the lines, counted from 0, of the docstrings of all definitions."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and ast.get_docstring(node) is not None:
            text = node.body[0]
            yield from range(text.lineno - 1, text.end_lineno or text.lineno)
