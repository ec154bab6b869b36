"""Find code of a solution in what students get, whatever its variables are called and wherever it stands."""

import ast
import builtins
import re
import textwrap
from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass

import nbformat

from nao_course.exercises.earlier import assigned_use
from nao_course.instructor.authoring import lesson_text

SMALLEST = 9  # nodes of a piece of code; smaller ones are alike by accident, such as a shape that is unpacked
# What an author does about a leak; the two are alike, so that either can be changed
WAY_OUT = "write one of the two in another way, with other operations, because other names are not enough"
_BUILTINS = frozenset(dir(builtins))
_FENCE = re.compile(r"^```[^\n]*\n(.*?)^```", re.MULTILINE | re.DOTALL)
_DEFINITIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)
# Their blocks speak for definitions
_SILENT = (ast.Import, ast.ImportFrom, ast.Pass, ast.Raise, *_DEFINITIONS)
_WRAPPERS = (ast.Return, ast.Expr, ast.Assign, ast.AnnAssign, ast.NamedExpr)
_UNSAID = {"annotation", "ctx", "decorator_list", "kind", "name", "returns", "type_comment", "type_params"}


@dataclass(frozen=True)
class Leak:
    """A piece of public code, where a student finds it, that is also part of a secret."""

    where: str
    secret: str

    def __str__(self) -> str:
        """Return both in one line, with what to do."""
        return f"{self.where} holds code of {self.secret}; {WAY_OUT}"


def find_leaks(public: Mapping[str, bytes], secrets: Mapping[str, str]) -> list[Leak]:
    """Return each place in public files, by their names, with the secrets of these fingerprints."""
    found: dict[str, Leak] = {}
    for file, content in public.items():
        for fingerprint, place in fingerprints_in(file, content):
            if fingerprint in secrets:
                where = f"{file}, {place}"
                found.setdefault(where, Leak(where, secrets[fingerprint]))
    return list(found.values())


def fingerprints_in(file: str, content: bytes) -> Iterator[tuple[str, str]]:
    """Yield the fingerprints of all code in a file, also of code in its strings, each with its place in the file."""
    for place, source in _code_in(file, content):
        for fingerprint, line in [*fingerprints(source), *_quoted(source)]:
            yield fingerprint, f"{place}line {line}"


def _code_in(file: str, content: bytes) -> Iterator[tuple[str, str]]:
    """Yield the pieces of Python in a file, each with its place."""
    if file.endswith(".py"):
        yield "", content.decode()
    elif file.endswith(".md"):
        yield from (("example, ", each) for each in _fenced(content.decode()))
    elif file.endswith(".ipynb"):
        for number, cell in enumerate(nbformat.reads(content.decode(), as_version=4).cells, start=1):
            pieces = [lesson_text.python(cell)] if cell.cell_type == "code" else _fenced(cell.source)
            yield from ((f"cell {number}, ", piece) for piece in pieces)


def _fenced(text: str) -> list[str]:
    return [textwrap.dedent(match[1]) for match in _FENCE.finditer(text)]


def fingerprints(source: str, lines: Container[int] | None = None) -> Iterator[tuple[str, int]]:
    """Describe each piece of code so that names of variables, docstrings, comments and layout do not matter.

    A piece is as many statements in a row as make `SMALLEST` nodes, from each statement on. What a statement does with
    its value (returns it, assigns it) does not matter either. Yield descriptions with the line in which their piece
    begins, if it is one of `lines` (all by default). Python that does not parse has no fingerprints.
    """
    try:
        tree = ast.parse(source)
    except (SyntaxError, ValueError):
        return
    for block in _blocks(tree):
        said = [
            each
            for each in block
            if (lines is None or each.lineno in lines)
            and not isinstance(each, _SILENT)
            and not _is_text(each)
            and not assigned_use(each)  # every set-up cell names the earlier exercises that a lesson uses
        ]
        for start, first in enumerate(said):
            piece: list[ast.AST] = []
            for statement in said[start:]:
                piece.append(_value(statement))
                if sum(map(_size, piece)) >= SMALLEST:
                    yield _describe(piece), first.lineno
                    break


def _quoted(source: str) -> Iterator[tuple[str, int]]:
    """Yield the fingerprints of the code in a source's strings, each at the line of its string."""
    try:
        nodes = list(ast.walk(ast.parse(source)))
    except (SyntaxError, ValueError):
        return
    for node in nodes:
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            inside = textwrap.dedent(node.value).strip()
            yield from ((fingerprint, node.lineno) for fingerprint, _ in fingerprints(inside))


def _blocks(tree: ast.AST) -> Iterator[list[ast.stmt]]:
    """Yield all lists of statements; the body of a lambda counts as a list, too."""
    for node in ast.walk(tree):
        for name in ("body", "orelse", "finalbody"):
            block = getattr(node, name, None)
            if isinstance(block, list):
                yield block
        if isinstance(node, ast.Lambda):
            yield [ast.copy_location(ast.Expr(node.body), node)]


def _is_text(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)


def _value(statement: ast.stmt) -> ast.AST:
    value = getattr(statement, "value", None) if isinstance(statement, _WRAPPERS) else None
    return value if isinstance(value, ast.expr) else statement


def _size(node: ast.AST) -> int:
    """Count the words of a piece of code; np.linalg.norm is one word."""
    silent = ast.expr_context | ast.operator | ast.Attribute
    return sum(not isinstance(each, silent) for each in ast.walk(node))


def _describe(piece: list[ast.AST]) -> str:
    """Write a piece down with its variables numbered in the order in which they turn up."""
    numbers: dict[str, int] = {}

    def variable(name: str) -> str:
        return name if name in _BUILTINS else f"v{numbers.setdefault(name, len(numbers))}"

    def write(item: object) -> str:
        if isinstance(item, list):
            return "[" + " ".join(write(each) for each in item) + "]"
        if isinstance(item, ast.Name):
            return variable(item.id)
        if isinstance(item, ast.arg):
            return variable(item.arg)
        if isinstance(item, ast.Constant):
            number = isinstance(item.value, int | float) and not isinstance(item.value, bool)
            return repr(float(item.value)) if number else repr(item.value)  # type: ignore[arg-type]
        if isinstance(item, ast.AST):
            fields = (getattr(item, name, None) for name in item._fields if name not in _UNSAID)
            return f"({type(item).__name__} {' '.join(map(write, fields))})"
        return repr(item)

    return write(piece)
