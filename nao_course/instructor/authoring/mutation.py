"""Tests of the tests: a lesson's solution is changed a little, many times; each change should lose points.

cosmic-ray's operators change operators, numbers and conditions. The others here are what it has not, and what goes
wrong in formulas and arrays: a forgotten term, a lost minus, swapped arguments, the wrong axis.
"""

import ast
import copy
import difflib
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.operators.provider import OperatorProvider
from rich.console import Console
from rich.progress import track
from rich.syntax import Syntax
from rich.table import Table

from nao_course.exercises import judging
from nao_course.exercises.case import Case
from nao_course.exercises.earlier import resolved_by, split_use
from nao_course.exercises.exercise import Exercise, LessonPlan
from nao_course.exercises.lesson_names import PATTERN, number_of
from nao_course.exercises.notebook_text import read_cells
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.authoring.plans import (
    SEEDS,
    SOLUTIONS,
    hidden_cases,
    lesson_name,
    load_plan,
    made_cases,
    reference,
    solution_notebook,
    solutions_beside,
    with_answers,
)
from nao_course.instructor.authoring.stamps import refuse_what_is_not_built
from nao_course.instructor.sandbox.protocol import Allowance, EarlierNotebook
from nao_course.instructor.sandbox.worker import Worker

MORE_SEEDS = range(100, 120)  # of the cases that a mutant must pass which is said to be right
# of its exercise's seconds that a mutant may take for one case: more than any solution that is built.
SHARE = 0.4
_EVERY = re.compile(".*")
_NEED_ARGUMENTS = {"VariableReplacer", "VariableInserter"}  # operators of cosmic-ray that want a name
_TWINS = [
    *(("min", "max"), ("minimum", "maximum"), ("argmin", "argmax"), ("any", "all"), ("floor", "ceil")),
    *(("sin", "cos"), ("arctan2", "hypot"), ("sum", "mean"), ("zeros", "ones"), ("hstack", "vstack")),
    *(("vstack", "hstack"), ("logical_and", "logical_or"), ("append", "extend"), ("mean", "median")),
]
_TWIN = {one: other for pair in _TWINS for one, other in (pair, pair[::-1])}
_SWAP_FREELY = ast.Add | ast.Mult | ast.BitAnd | ast.BitOr | ast.BitXor
_DROPPED = (
    ast.Assign
    | ast.AugAssign
    | ast.Expr
    | ast.Return
    | ast.If
    | ast.For
    | ast.While
    | ast.Continue
    | ast.Break
)


@dataclass(frozen=True)
class Mutant:
    """A changed solution of an exercise: the change, and the source, without docstring and annotations."""

    exercise: str
    operator: str
    original: str
    source: str

    @property
    def lines(self) -> frozenset[str]:
        """The lines that the original does not have, without indents."""
        before = {line.strip() for line in self.original.splitlines()}
        return frozenset(line.strip() for line in self.source.splitlines()) - before

    @property
    def diff(self) -> str:
        """What was changed, as a unified diff."""
        before, after = self.original.splitlines(), self.source.splitlines()
        name = f"{self.exercise} ({self.operator})"
        return "\n".join(difflib.unified_diff(before, after, name, name, lineterm="", n=2))


@dataclass(frozen=True)
class Trial:
    """The outcome of one mutant: whether the hidden cases and the public checks distinguish it from the solution.

    Neither does if it is right; `reason` says why, if the declaration says so and no hidden case contradicts it.
    """

    mutant: Mutant
    hidden: bool
    public: bool
    reason: str = ""


@dataclass(frozen=True)
class MutationReport:
    """What a lesson's tests notice; `unknown` says which lines that a declaration calls right no mutant has."""

    lesson: str
    trials: tuple[Trial, ...]
    unknown: tuple[str, ...] = ()

    @property
    def survivors(self) -> list[Mutant]:
        """Mutants that lose no points though nobody has said that they are right."""
        return [trial.mutant for trial in self.trials if not trial.hidden and not trial.reason]

    @property
    def equivalents(self) -> list[Trial]:
        """Mutants that are right, each with its reason."""
        return [trial for trial in self.trials if trial.reason]

    def caught(self, exercise: str | None = None) -> tuple[int, int, int]:
        """Count the wrong mutants: caught by the hidden cases, caught by the public checks, and in all."""
        trials = [
            trial for trial in self.trials if not trial.reason and exercise in (None, trial.mutant.exercise)
        ]
        return sum(trial.hidden for trial in trials), sum(trial.public for trial in trials), len(trials)


def mutate(
    lesson: str,
    jobs: int = 2,
    solutions: Path = SOLUTIONS,
    seeds: Sequence[int] = SEEDS,
    every: int = 1,
    more_seeds: Sequence[int] = MORE_SEEDS,
) -> MutationReport:
    """Run the mutants of a solution against the tests, in `jobs` processes, with hidden cases of these seeds.

    `every` n-th mutant is tried, and `every` n-th line that the declarations call right; a mutant with such a line must
    also pass the hidden cases of `more_seeds`.
    """
    name = lesson_name(lesson, solutions)
    plan, functions = load_plan(solutions / "exercises" / f"{name}.py"), reference(name, solutions)
    notebook = solution_notebook(name, solutions)
    sources = _sources(notebook, [exercise.name for exercise in plan.exercises])
    with resolved_by(solutions_beside(notebook)):
        tests = {each.name: _tests(each, functions[each.name], seeds) for each in plan.exercises}
        more = {
            each.name: _tests(each, functions[each.name], more_seeds)[0]
            for each in plan.exercises
            if each.equivalents
        }
    made = {each.name: list(make_mutants(each.name, sources[each.name])) for each in plan.exercises}
    said_right = {each.name: {*[*each.equivalents][::every]} for each in plan.exercises}
    mutants = [
        mutant
        for of_one in made.values()
        for number, mutant in enumerate(of_one)
        if number % every == 0 or mutant.lines & said_right[mutant.exercise]
    ]
    unknown = tuple(
        f"{each.name}: no mutant has the line {line}"
        for each in plan.exercises
        for line in each.equivalents
        if not any(line in mutant.lines for mutant in made[each.name])
    )
    with ExitStack() as stack:
        free: SimpleQueue[Worker] = SimpleQueue()
        for _ in range(jobs):
            free.put(stack.enter_context(Worker(notebook, earlier=_earlier(notebook, plan))))

        def trial(mutant: Mutant) -> Trial:
            worker = free.get()
            try:
                worker.overrides = {mutant.exercise: mutant.source}
                worker.allowance = Allowance()  # each mutant is a submission of its own
                exercise, hidden, public = plan[mutant.exercise], *tests[mutant.exercise]
                reason = "; ".join(
                    text for line, text in exercise.equivalents.items() if line in mutant.lines
                )
                if reason and _passes_in_two_trials(worker, exercise, [*hidden, *more[mutant.exercise]]):
                    return Trial(mutant, hidden=False, public=False, reason=reason)
                caught = _fails(worker, exercise, hidden)
                return Trial(mutant, caught, _fails(worker, exercise, public))
            finally:
                free.put(worker)

        pool = stack.enter_context(ThreadPoolExecutor(jobs))
        running = pool.map(trial, mutants)
        trials = tuple(track(running, f"mutants of {name}", len(mutants), transient=True))
        return MutationReport(name, trials, unknown)


def _earlier(notebook: Path, plan: LessonPlan) -> list[EarlierNotebook]:
    """Return the solutions that a lesson's exercises use, directly or through others, in their order."""
    numbers = {split_use(use)[0] for each in plan.exercises for use in each.uses} - {""}
    if not numbers:
        return []
    paths = sorted(each for each in notebook.parent.glob(f"{PATTERN}.ipynb") if each.stem < notebook.stem)
    return [
        EarlierNotebook(each.stem, each.read_bytes())
        for each in paths
        if number_of(each.stem) <= max(numbers)
    ]


def show(report: MutationReport, console: Console | None = None) -> None:
    """Print a report: the survivors' diffs, then how many were caught in each exercise."""
    console = console or Console()
    for mutant in report.survivors:
        console.print(Syntax(mutant.diff, "diff", background_color="default", word_wrap=True))
    for trial in report.equivalents:
        console.print(f"{trial.mutant.exercise}: {', '.join(sorted(trial.mutant.lines))}", markup=False)
        console.print(f"    is right: {trial.reason}", markup=False)
    for each in report.unknown:
        console.print(f"{each}, which the declaration calls right", markup=False)
    columns = (
        "exercise",
        "mutants",
        "right ones",
        "of the others: caught by hidden cases",
        "by public checks",
    )
    table = Table(*columns, title=report.lesson)
    for name in [*dict.fromkeys(trial.mutant.exercise for trial in report.trials), None]:
        hidden, public, total = report.caught(name)
        right = sum(name in (None, trial.mutant.exercise) for trial in report.equivalents)
        table.add_row(
            name or "all", str(total + right), str(right), _share(hidden, total), _share(public, total)
        )
    console.print(table)


def main(lesson: str, jobs: int = 2) -> int:
    """Run `nao-course mutate`; return its exit status.

    Raise a LessonError if there is no such lesson, or it is not what was built.
    """
    course = load_course()
    refuse_what_is_not_built(course, course.names([lesson]))
    show(mutate(lesson, jobs))
    return 0


def _share(caught: int, total: int) -> str:
    return f"{caught} ({caught / max(total, 1):.0%})"


def _tests(
    exercise: Exercise, function: Callable[..., Any], seeds: Sequence[int]
) -> tuple[list[Case], list[Case]]:
    """Return hidden cases of several seeds, and the public cases."""
    hidden = [case for seed in seeds for case in hidden_cases(exercise, function, seed)]
    return hidden, with_answers(exercise, made_cases(exercise), function)


def _fails(worker: Worker, exercise: Exercise, cases: Iterable[Case]) -> bool:
    """Return whether a case distinguishes the worker's function from the solution; a timeout does."""
    worker.seconds = SHARE * exercise.seconds
    for case in cases:
        outcome = judging.answer(
            exercise.comparison, lambda each: worker.call(exercise.name, each, exercise.driver), case
        )
        if outcome.changed or not judging.judge(exercise.comparison, case, outcome):
            return True
    return False


def _passes_in_two_trials(worker: Worker, exercise: Exercise, cases: list[Case]) -> bool:
    """Return whether a mutant passes all cases in one of two trials: a busy machine may delay or end one of them."""
    return not _fails(worker, exercise, cases) or not _fails(worker, exercise, cases)


# --- making them ---


def make_mutants(exercise: str, source: str, operators: re.Pattern[str] = _EVERY) -> list[Mutant]:
    """Make all mutants of a function or class, each once and all different from the original.

    Only the operators whose whole name matches the pattern are used.
    """
    tree = _bare(ast.parse(source))
    original = ast.unparse(tree)
    seen = {original}
    mutants = []
    by_us = ((operator, changed) for operator, changed in _by_us(tree) if operators.fullmatch(operator))
    for operator, changed in [*_by_cosmic_ray(original, operators), *by_us]:
        try:
            plain = ast.unparse(ast.parse(changed))
        except SyntaxError:
            continue
        if plain not in seen:
            seen.add(plain)
            mutants.append(Mutant(exercise, operator, original, plain))
    return mutants


def _sources(notebook: Path, names: Iterable[str]) -> Mapping[str, str]:
    """Return the source of the last definitions of these functions and classes in a notebook."""
    sources = dict.fromkeys(names, "")
    for role, text in read_cells(notebook):
        for node in ast.parse(text).body if role in ("solution", "student") else ():
            if isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name in sources:
                sources[node.name] = ast.unparse(node)
    return sources


def _bare(tree: ast.Module) -> ast.Module:
    """Return the tree without docstrings and annotations, because no test depends on them."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and ast.get_docstring(node) is not None:
            node.body = node.body[1:] or [ast.Pass()]
        if isinstance(node, ast.FunctionDef):
            node.returns = None
        if isinstance(node, ast.arg):
            node.annotation = None
    return tree


def _by_cosmic_ray(source: str, wanted: re.Pattern[str]) -> Iterator[tuple[str, str]]:
    operators = OperatorProvider()
    nodes = list(ast_nodes(get_ast(source)))
    for name in operators:
        if name in _NEED_ARGUMENTS or not wanted.fullmatch(name):
            continue
        operator = operators[name]()
        places = sum(1 for node in nodes for _ in operator.mutation_positions(node))
        for occurrence in range(places):
            changed = mutate_code(source, operators[name](), occurrence)
            if changed is not None:
                yield name, changed


def _by_us(tree: ast.Module) -> Iterator[tuple[str, str]]:
    for holder, field, place, node in _places(tree):
        for operator, replacement in _variants(node):
            _put(holder, field, place, replacement)
            yield operator, ast.unparse(ast.fix_missing_locations(tree))
        _put(holder, field, place, node)


def _places(tree: ast.AST) -> list[tuple[ast.AST, str, int, ast.AST]]:
    """Yield all nodes except the tree itself: parent, field, index in a list (else -1), and the node."""
    found: list[tuple[ast.AST, str, int, ast.AST]] = []
    for holder in ast.walk(tree):
        for field, value in ast.iter_fields(holder):
            several = enumerate(value) if isinstance(value, list) else [(-1, value)]
            found += [(holder, field, place, each) for place, each in several if isinstance(each, ast.AST)]
    return found


def _put(holder: ast.AST, field: str, place: int, node: ast.AST) -> None:
    """Put a node in a place; the node that it replaces keeps its own place."""
    if place < 0:
        setattr(holder, field, node)
    else:
        getattr(holder, field)[place] = node


def _variants(node: ast.AST) -> Iterator[tuple[str, ast.AST]]:
    """Yield the nodes that may replace a node."""
    match node:
        case ast.BinOp(left, operator, right):
            yield "first term alone", left
            yield "second term alone", right
            if not isinstance(operator, _SWAP_FREELY):
                yield "terms swapped", ast.BinOp(right, operator, left)
        case ast.BoolOp(_, values):
            for value in values:
                yield "one condition alone", value
        case ast.Call(ast.Name(name) | ast.Attribute(_, name), arguments, keywords):
            yield from _calls(node, name, arguments, keywords)
        case ast.Subscript(value, ast.Tuple(indices), context):
            yield "indices in reverse", ast.Subscript(value, ast.Tuple(indices[::-1], ast.Load()), context)
        case ast.Slice(lower, upper, step):
            yield "from the beginning", ast.Slice(None, upper, step)
            yield "to the end", ast.Slice(lower, None, step)
            if upper:
                yield "one less", ast.Slice(lower, ast.BinOp(upper, ast.Sub(), ast.Constant(1)), step)
        case ast.Attribute(value, "T"):
            yield "not transposed", value
        case ast.If(_, body, otherwise):
            yield "always", ast.If(ast.Constant(True), body, otherwise)
            yield "never", ast.If(ast.Constant(False), body, otherwise)
        case ast.IfExp(_, body, otherwise):
            yield "always", body
            yield "never", otherwise
        case ast.Tuple([first, second, *rest], ast.Load()) | ast.List([first, second, *rest], ast.Load()):
            yield "first two swapped", type(node)([second, first, *rest], ast.Load())
    if isinstance(node, ast.Return) and node.value:
        yield "nothing returned", ast.Return(ast.Constant(None))
    if isinstance(node, _DROPPED):
        yield "statement dropped", ast.Pass()


def _calls(
    node: ast.Call, name: str, arguments: list[ast.expr], keywords: list[ast.keyword]
) -> Iterator[tuple[str, ast.AST]]:
    for argument in arguments[:2]:
        if not isinstance(argument, ast.Starred):
            yield "not called", argument
    if isinstance(node.func, ast.Attribute):
        yield "method not called", node.func.value
    if len(arguments) >= 2:
        yield "arguments swapped", ast.Call(node.func, [arguments[1], arguments[0], *arguments[2:]], keywords)
    for keyword in keywords:
        yield (
            "argument dropped",
            ast.Call(node.func, arguments, [each for each in keywords if each is not keyword]),
        )
        if keyword.arg == "axis":
            other = ast.keyword("axis", ast.parse(f"1 - ({ast.unparse(keyword.value)})", mode="eval").body)
            rest = [each for each in keywords if each is not keyword]
            yield "other axis", ast.Call(node.func, arguments, [*rest, other])
    if name in _TWIN:
        twin = copy.copy(node.func)
        setattr(twin, "id" if isinstance(twin, ast.Name) else "attr", _TWIN[name])
        yield f"{_TWIN[name]} for {name}", ast.Call(twin, arguments, keywords)
