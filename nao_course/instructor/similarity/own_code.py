"""The code that a student wrote, read from a submission without running it."""

import ast
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from nao_course.exercises import notebook_text
from nao_course.exercises.cells import GIVEN
from nao_course.exercises.outline import read_outline
from nao_course.exercises.statements import parse
from nao_course.instructor.autograding.scratch import laid_out
from nao_course.instructor.collecting import files
from nao_course.instructor.collecting.archives import Refused
from nao_course.instructor.collecting.submissions import Submission
from nao_course.instructor.similarity.comparing import LENGTH, LONGEST

_RUNS_TEXT = {"exec", "eval", "compile"}
# Further names by which code outside the cells can be made or run.
_HIDES_CODE = {"__builtins__", "__import__", "builtins", "marshal", "runpy", "CodeType", "FunctionType"}
_MOST_STEPS = 100_000  # for the texts of one notebook


@dataclass(frozen=True)
class OwnCode:
    """The code that a student wrote: exercises, added cells, helper files, and their texts for exec, eval or compile.

    `hidden` are places of code that is made while the notebook runs, so that it cannot be read here. `written` are the
    answers in words by question.
    """

    cells: tuple[str, ...]
    hidden: tuple[str, ...] = ()
    written: Mapping[str, str] = field(default_factory=dict)


def own_code(submission: Submission) -> OwnCode:
    """Return the code that a student wrote: all that the grader runs, except the set-up.

    Raise Refused if the notebook cannot be read.
    """
    try:
        with laid_out(files.read(submission, _without_outputs), submission.lesson) as notebook:
            text = notebook_text.read_notebook(notebook, read_outline(submission.lesson))
            sources = {
                f"code cell {number}": source
                for number, (role, source) in enumerate(text.cells, 1)
                if role not in GIVEN
            }
            for name, _ in submission.helpers:
                sources[name] = notebook.with_name(name).read_text(encoding="utf-8", errors="replace")
    except ValueError as error:
        raise Refused(str(error)) from None
    return replace(with_executed_texts(sources), written=text.written)


def with_executed_texts(sources: Mapping[str, str]) -> OwnCode:
    r"""Return sources, by a place such as "code cell 3", with the texts that they execute, each behind its source.

    >>> sources = {"cell 1": "a = 'total = sum('", "cell 2": "exec(a + 'weights)')\nexec(open('b').read())"}
    >>> found = with_executed_texts(sources)
    >>> found.cells[-1], found.hidden
    ('total = sum(weights)', ('cell 2, line 2',))
    """
    trees = {place: _parsed(source) for place, source in sources.items()}
    reader = _TextReader(trees.values())
    cells = list[str]()
    hidden = dict[str, None]()
    for place, source in sources.items():
        cells.append(source)
        waiting, read = [trees[place]], set[str]()
        while waiting:
            nodes = list(ast.walk(waiting.pop()))
            calls = [each for each in nodes if isinstance(each, ast.Call) and _name(each.func) in _RUNS_TEXT]
            texts = [reader.read(each) for each in calls]
            known = {id(each.func) for each, (_, whole) in zip(calls, texts, strict=True) if whole}
            for text in dict.fromkeys(text for text, _ in texts if text not in read):
                if len(text) >= LENGTH and (tree := _parsed(text)).body:
                    read.add(text)
                    cells.append(text)
                    waiting.append(tree)
            hidden |= {
                f"{place}, line {getattr(each, 'lineno', 1)}": None
                for each in nodes
                if _name(each) in _RUNS_TEXT | _HIDES_CODE and id(each) not in known
            }
    return OwnCode(tuple(cells), tuple(hidden))


class _TextReader:
    """Reads the texts of expressions without running them, within a number of steps for the whole notebook."""

    def __init__(self, trees: Iterable[ast.Module]) -> None:
        self.left = _MOST_STEPS
        nodes = (node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.Assign))
        self.assigned = {_name(target): node.value for node in nodes for target in node.targets}

    def read(self, call: ast.Call) -> tuple[str, bool]:
        """Return the text that a call of exec, eval or compile is given, and whether all of it could be read."""
        pieces, whole, size = list[str](), bool(call.args), 0
        waiting: list[tuple[ast.AST, frozenset[str]]] = [(each, frozenset()) for each in call.args[:1]]
        while waiting and self.left > 0 and size <= LONGEST:  # names in names make a text of any length
            self.left -= 1
            node, within = waiting.pop()
            parts: Iterable[ast.AST] = ()
            match node:
                case ast.Constant(str(text)):
                    pieces.append(text[:LONGEST])
                    size += len(text)
                case ast.Constant(bytes(code)):
                    pieces.append(code[:LONGEST].decode("utf-8", "replace"))
                    size += len(code)
                case ast.BinOp(left, ast.Add(), right):
                    parts = (left, right)
                case ast.Call(
                    ast.Attribute(ast.Constant(str()) as between, "join"), [ast.List(of) | ast.Tuple(of)]
                ):
                    parts = [each for part in of for each in (part, between)]
                case ast.Call(ast.Name("compile"), [first, *_]):
                    parts = (first,)
                case ast.Name(name) if name in self.assigned and name not in within:
                    parts, within = (self.assigned[name],), within | {name}
                case _:
                    whole, parts = False, list(ast.iter_child_nodes(node))
            waiting += [(part, within) for part in reversed(list(parts))]
        return "".join(pieces), whole and not waiting


def _name(node: ast.AST) -> str:
    """Return the name that a part of a program looks up or imports; empty if it does neither.

    An attribute such as `re.compile` counts only as one of the names that hide code.
    """
    match node:
        case ast.Name(name):
            return name
        case ast.Attribute(_, name) | ast.alias(name) if name in _HIDES_CODE:
            return name
    return ""


def _parsed(source: str) -> ast.Module:
    """Return a source's statements; none if it is no Python, because such a source is not run either."""
    try:
        return ast.Module(parse(source[:LONGEST], "<own>"), [])
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return ast.Module([], [])


def defining_cell(cells: Iterable[str], name: str) -> str:
    """Return the last cell that defines a function, class or variable of this name; an empty text if none does.

    >>> defining_cell(["def double(x): ...", "double = lambda x: 2 * x", "double(3)"], "double")
    'double = lambda x: 2 * x'
    """
    defines = re.compile(
        rf"^\s*+(?:(?:async\s++)?def|class)\s++{re.escape(name)}\b|^{re.escape(name)}\s*+[=:]", re.M
    )
    return next((cell for cell in reversed(list(cells)) if defines.search(cell)), "")


def _without_outputs(name: str, size: int, parts: Iterable[bytes]) -> bytes:
    return notebook_text.without_outputs(name, b"".join(parts))
