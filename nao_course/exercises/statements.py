"""A cell's statements, and the names that they bind, change and read, found without running them."""

from __future__ import annotations

import ast
import contextlib
import re
import warnings
from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, field

# Characters of a cell with commands of IPython, which parses the cell again for each command.
LONGEST_COMMANDED = 20_000
MOST_COMMANDS = 100  # in a cell
_COMMAND = re.compile(r"^[ \t]*+[%!?]|=[ \t]*+[%!]|\?[ \t]*+$", re.MULTILINE)
_BLANKS = re.compile(r"([ \t]{99}|\n{99})[ \t\n]++")  # what goes beyond
_EMPTY = re.compile(r"(?:[ \t\f\r]*+\n)*+")  # the empty lines at the beginning, which IPython drops
_PASTED = re.compile(r"[ \t]|>>>|In \[")  # IPython removes a first line's indentation and copied prompts
_FILE = re.compile(r"(?:\./)?([A-Za-z_]\w*)(?:\.py)?")
_CELL_MAGIC = re.compile(r"\s*%%(?:time|timeit|capture|prun)\b.*")  # magics that run the cell as Python
_ROUNDS = 10  # of calls from function to function
# Functions that only show, ask or check something, and libraries of such functions.
_SHOWS = {"print", "display", "help", "input", "breakpoint", "exit", "quit", "check", "hint", "try_out"}
_SHOWING = {"nao_course", "matplotlib", "pylab", "IPython", "ipywidgets", "seaborn", "plotly"}
# Functions of modules that set something for the whole process: np.random.seed, sys.setrecursionlimit, sys.path.append.
_SETS = re.compile(r"seed|set\w*|filterwarnings|simplefilter|append|insert")
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)
_IDLE = (ast.Constant, ast.expr_context, ast.operator, ast.cmpop)  # frequent nodes without names
_DEFINITIONS = (*_FUNCTIONS, ast.ClassDef)


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
            if len(_COMMAND.findall(source)) > MOST_COMMANDS:
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
    """Transformer that removes IPython's commands, except code that they run; the value of a command becomes None."""

    def visit_Expr(self, node: ast.Expr) -> ast.AST | list[ast.stmt]:
        match node.value:
            case ast.Call(
                ast.Attribute(ast.Call(ast.Name("get_ipython")), "run_line_magic"),
                [ast.Constant(str(magic)), ast.Constant(str(code))],
            ) if run := _run_by(magic, code):
                return [ast.increment_lineno(each, node.lineno - 1) for each in run]
        return self.generic_visit(node)

    def visit_Call(self, node: ast.Call) -> ast.AST:
        match node.func:
            case ast.Attribute(ast.Call(ast.Name("get_ipython"))):
                return ast.Constant(None)
        return self.generic_visit(node)


def _run_by(magic: str, code: str) -> list[ast.stmt]:
    """Return the statements that a line such as `%time x = f()` or `%run mine.py` runs; nothing for other lines."""
    file = _FILE.fullmatch(code.strip()) if magic == "run" else None
    source = f"from {file[1]} import *" if file else code if magic in ("time", "prun") else ""
    with contextlib.suppress(SyntaxError, ValueError):
        return ast.parse(source).body
    return []


def is_doubled(source: str) -> bool:
    r"""Return whether a cell contains its text twice, with or without a line end between.

    >>> is_doubled("x = 1\nx = 1"), is_doubled("x = 1x = 1"), is_doubled("x = 1")
    (True, True, False)
    """
    text = source.strip()
    halves = ((text[: (len(text) - gap) // 2], gap) for gap in range(len(text) % 2, 5, 2))
    return any(half and text == half + text[len(half) : len(half) + gap] + half for half, gap in halves)


def unwritten(statement: ast.stmt) -> int:
    """Return how many functions of a definition end with `raise NotImplementedError`, as in the blank notebook."""
    functions = [each for each in ast.walk(statement) if isinstance(each, _FUNCTIONS)]
    return sum(_is_blank(each) for each in functions)


def _is_blank(function: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    match function.body[-1]:
        case ast.Raise(ast.Name("NotImplementedError") | ast.Call(ast.Name("NotImplementedError"), [], [])):
            return True
    return False


def is_under_main(statement: ast.stmt) -> bool:
    """Return whether a statement is ``if __name__ == "__main__":``, which is true in a notebook."""
    match statement:
        case ast.If(ast.Compare(ast.Name("__name__"), [ast.Eq()], [ast.Constant("__main__")])):
            return True
    return False


@dataclass
class Effects:
    """The global names that a statement, or a call of a function, binds, changes and reads.

    `changes` has the names whose values it may change, such as T in `T[0] = 1` and `T.sort()`; `passes` has the names
    whose values it passes to a function, and `calls` the functions, a method with a point before its name.
    """

    binds: set[str] = field(default_factory=set)
    changes: set[str] = field(default_factory=set)
    passes: set[str] = field(default_factory=set)
    reads: set[str] = field(default_factory=set)
    calls: set[str] = field(default_factory=set)
    sets: bool = False  # whether it sets something for the whole process


@dataclass
class _Scope:
    """The local names of a function, class or comprehension."""

    parent: _Scope | None
    is_class: bool = False
    names: set[str] = field(default_factory=set)
    shared: set[str] = field(default_factory=set)  # declared as global

    def has(self, name: str) -> bool:
        """Return whether a name that is read here is local here or in a surrounding function."""
        scope: _Scope | None = self
        while scope is not None:
            if (
                name in scope.names
                and name not in scope.shared
                and not (scope.is_class and scope is not self)
            ):
                return True
            scope = scope.parent
        return False


class Program:
    """The statements of a notebook, and which of them the functions of some names depend on.

    It is made from all statements that may run, and the imports of the others.
    """

    def __init__(self, statements: Iterable[ast.stmt]) -> None:
        self._statements = list(statements)  # keeps the ids valid
        self._modules, self._shows = set[str](), set(_SHOWS)
        for each in self._statements:
            self._add_imports(each)
        self._functions: dict[str, Effects] = {}  # of calls, by name
        self._effects = {id(each): self._effects_of(each) for each in self._statements}
        for _ in range(_ROUNDS):
            for effects in self._functions.values():
                self._add_calls(effects)
        values = {
            name
            for each in self._statements
            if not isinstance(each, (*_DEFINITIONS, ast.Import))
            for name in self._effects[id(each)].binds
        }
        self._writers: dict[str, list[Effects]] = {}
        for effects in self._effects.values():
            self._add_calls(effects)
            effects.changes |= effects.passes & values
            for name in effects.binds | effects.changes:
                self._writers.setdefault(name, []).append(effects)

    @property
    def bound(self) -> set[str]:
        """All names that a statement binds."""
        return set().union(*(each.binds for each in self._effects.values()))

    def needed_by(self, names: Iterable[str], without: Collection[str] = ()) -> set[str]:
        """Return the names that some names depend on: themselves, and all that is read where one of them is set.

        What some other names depend on is left out.
        """
        found = set(names)
        waiting, seen = list(found), set[int]()
        while waiting:
            for effects in self._writers.get(waiting.pop(), ()):
                if id(effects) not in seen:
                    seen.add(id(effects))
                    new = effects.reads.difference(found, without)
                    found |= new
                    waiting += new
        return found

    def may_set(self, statement: ast.stmt, names: set[str]) -> bool:
        """Return whether a statement may bind or change one of some names, or sets something for the whole process."""
        effects = self._effects.get(id(statement), Effects())
        return effects.sets or not names.isdisjoint(effects.binds | effects.changes)

    def _add_imports(self, statement: ast.stmt) -> None:
        """Remember the names that an import gives to modules, and to what only shows something."""
        match statement:
            case ast.Import(names):
                self._modules |= {each.asname or each.name.partition(".")[0] for each in names}
                shows = {
                    each.asname or each.name for each in names if each.name.partition(".")[0] in _SHOWING
                }
            case ast.ImportFrom(str(module), names) if module.partition(".")[0] in _SHOWING:
                shows = {each.asname or each.name for each in names}
            case _:
                return
        self._shows |= shows

    def _add_calls(self, effects: Effects) -> None:
        """Add the changes that the called functions make."""
        for name in effects.calls & self._functions.keys():
            effects.changes |= self._functions[name].changes
            effects.sets |= self._functions[name].sets

    def _effects_of(self, statement: ast.stmt) -> Effects:
        """Return what happens when a statement runs, and keep what happens in calls of the functions it defines."""
        found = Effects()
        waiting: list[tuple[ast.AST, _Scope | None, Effects]] = [(statement, None, found)]
        uses: list[tuple[set[str], Iterable[str], _Scope | None]] = []
        while waiting:
            node, scope, running = waiting.pop()
            if isinstance(node, _IDLE):
                continue
            bound = scope.names if scope else found.binds
            inner, inside = scope, running
            outside: list[ast.AST] = []
            match node:
                case ast.FunctionDef(name) | ast.AsyncFunctionDef(name):
                    bound.add(name)
                    outside = [
                        *node.decorator_list,
                        *node.args.defaults,
                        *filter(None, node.args.kw_defaults),
                    ]
                    inner = _Scope(scope)
                    if scope is None or (scope.is_class and scope.parent is None):
                        inside = self._functions.setdefault(name if scope is None else f".{name}", Effects())
                case ast.ClassDef(name):
                    bound.add(name)
                    outside = [*node.decorator_list, *node.bases]
                    inner = _Scope(scope, is_class=True)
                case ast.Lambda():
                    inner, inside = _Scope(scope), Effects()
                case ast.ListComp() | ast.SetComp() | ast.DictComp() | ast.GeneratorExp():
                    inner = _Scope(scope)
                case ast.arg(name):
                    bound.add(name)
                case ast.Global(shared) if scope:
                    scope.shared |= set(shared)
                    running.changes |= set(shared)
                case ast.Name(name, ast.Load()):
                    uses.append((found.reads, [name], scope))
                case ast.Name(name):
                    bound.add(name)
                case ast.Import() | ast.ImportFrom():
                    bound |= {each.asname or each.name.partition(".")[0] for each in node.names}
                case (
                    ast.ExceptHandler(name=str(name)) | ast.MatchAs(name=str(name)) | ast.MatchStar(str(name))
                ):
                    bound.add(name)
                case ast.Attribute(ctx=ast.Store() | ast.Del()) | ast.Subscript(ctx=ast.Store() | ast.Del()):
                    uses.append((running.changes, [_root(node)], scope))
                case ast.Call(function):
                    uses += [(*each, scope) for each in self._uses_of_call(node, function, running)]
            waiting += [(each, scope, running) for each in outside]
            kept_outside = set(map(id, outside))
            waiting += [
                (each, inner, inside) for each in ast.iter_child_nodes(node) if id(each) not in kept_outside
            ]
        for kept, names, where in uses:
            kept.update(name for name in names if not (where and where.has(name)))
        return found

    def _uses_of_call(
        self, node: ast.Call, function: ast.expr, running: Effects
    ) -> Iterator[tuple[set[str], Iterable[str]]]:
        """Yield the names that a call may change: the object of a method, and what is passed to a function."""
        root = _root(function)
        match function:
            case ast.Name("exec") | ast.Attribute(ast.Call(ast.Name("globals" | "locals" | "vars"))):
                running.sets = True
            case ast.Name():
                running.calls.add(root)
            case ast.Attribute(_, name) if root in self._modules:
                running.sets |= root not in self._shows and bool(_SETS.fullmatch(name))
            case ast.Attribute(_, name):
                yield running.changes, {root} - self._shows
                running.calls.add(f".{name}")
        if root not in self._shows:
            for part in (*node.args, *(each.value for each in node.keywords)):
                yield running.passes, _names_in(part, stop=(ast.Call, ast.Lambda))


def _names_in(node: ast.AST, stop: tuple[type[ast.AST], ...] = ()) -> set[str]:
    """Return the names that are read in a node, outside of nodes of some types."""
    found, waiting = set[str](), [node]
    while waiting:
        each = waiting.pop()
        if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Load):
            found.add(each.id)
        if not isinstance(each, stop):
            waiting += ast.iter_child_nodes(each)
    return found


def _root(node: ast.AST) -> str:
    """Return the name at the beginning of an expression such as a.b[0].c; empty if there is none."""
    while isinstance(node, ast.Attribute | ast.Subscript | ast.Starred):
        node = node.value
    return node.id if isinstance(node, ast.Name) else ""


def targets(statement: ast.stmt) -> Iterator[str]:
    """Yield the names that a statement defines or assigns, without its imports."""
    if isinstance(statement, _DEFINITIONS):
        yield statement.name
        return
    for node in ast.walk(statement):
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            yield node.id
