"""The code of a lesson that the proof of one exercise rests on: what its declaration mentions, and what that mentions.

A name counts as mentioned wherever it stands, also in a text, so that too much is proven again and never too little.
"""

import ast
import re
from collections.abc import Collection, Sequence
from typing import NamedTuple


class _Piece(NamedTuple):
    """A statement of a declaration or a cell of a solution; without `names`, all exercises rest on it."""

    text: str
    names: frozenset[str] = frozenset()


def code_by_exercise(
    declaration: str, solution: Sequence[tuple[str, str]], exercises: Collection[str]
) -> dict[str, str]:
    """Return the code that each exercise rests on, by the exercise's name.

    `solution` are the cells that define something, as (role, source). Each exercise rests on everything unless the
    declaration has a statement ``NAME = Exercise(name="...")`` for each, and a plan that lists these names.
    """
    statements = _statements(declaration)
    declared = {name: each for each in statements if (name := _declared(each))}
    cells = [
        _Piece(source, _names_of_cell(source) if role == "solution" else frozenset())
        for role, source in solution
    ]
    if not set(exercises) <= declared.keys() or not any(map(_is_plain_plan, statements)):
        return dict.fromkeys(exercises, "\n".join([declaration, *(each.text for each in cells)]))
    pieces = [_Piece(ast.unparse(each), _names(each)) for each in statements if not _is_plain_plan(each)]
    return {name: _reached(pieces + cells, ast.unparse(declared[name])) for name in exercises}


def _reached(pieces: Sequence[_Piece], text: str) -> str:
    """Return a text with the pieces that it and these mention, and those without names."""
    reached = {each for each in pieces if not each.names}
    words = set[str]()
    while (
        more := {word for each in (text, *(piece.text for piece in reached)) for word in _WORD.findall(each)}
        - words
    ):
        words |= more
        reached |= {each for each in pieces if each.names & words}
    return "\n".join([text, *(each.text for each in pieces if each in reached)])


_WORD = re.compile(r"\w+")


def _statements(source: str) -> list[ast.stmt]:
    try:
        return ast.parse(source).body
    except SyntaxError:
        return []


def _declared(node: ast.stmt) -> str:
    """Return the name of the exercise that a statement declares; empty if it declares none."""
    if not (isinstance(node, ast.Assign) and isinstance(node.value, ast.Call)):
        return ""
    named = [each.value for each in node.value.keywords if each.arg == "name"]
    is_exercise = isinstance(node.value.func, ast.Name) and node.value.func.id == "Exercise"
    return str(named[0].value) if is_exercise and named and isinstance(named[0], ast.Constant) else ""


def _is_plain_plan(node: ast.stmt) -> bool:
    """Return whether a statement is a plan that lists its exercises by their names."""
    if not (isinstance(node, ast.Assign) and isinstance(node.value, ast.Call) and _names(node) == {"PLAN"}):
        return False
    lists = [*node.value.args[:1], *(each.value for each in node.value.keywords if each.arg == "exercises")]
    return (
        len(lists) == 1
        and isinstance(lists[0], ast.List)
        and all(isinstance(each, ast.Name) for each in lists[0].elts)
    )


def _names(node: ast.stmt) -> frozenset[str]:
    """Return the names that a statement defines; none if it does something else as well."""
    if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.decorator_list:
        return frozenset({node.name})
    if isinstance(node, ast.Assign) and all(isinstance(each, ast.Name) for each in node.targets):
        return frozenset(each.id for each in node.targets if isinstance(each, ast.Name))
    return frozenset()


def _names_of_cell(source: str) -> frozenset[str]:
    """Return the names that a cell defines; none if a part of it does something else."""
    found = [_names(each) for each in _statements(source)]
    return frozenset[str]().union(*found) if all(found) else frozenset()
