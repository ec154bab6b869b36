"""How well copied work is found: ``nao-course similar`` on independently written right answers, and on copies.

The notebooks hold the right answers of solutions/exercises: notebook 0 the reference of each exercise, notebook k the
alternative k. What is taken out as known is the release and the answers that are in neither notebook of a pair, as for
students whose answers the course does not know.
"""

import ast
import random
import subprocess
import sys
import tempfile
import time
import tokenize
from collections.abc import Callable, Iterator
from io import StringIO
from itertools import combinations
from pathlib import Path

import nbformat
from rich.console import Console

from benchmarks import ROOT, Result, Table
from nao_course.instructor.authoring.course import Course, load_course
from nao_course.instructor.similarity.command import find_similar
from nao_course.instructor.similarity.comparing import (
    LEAST_SHARE,
    LEAST_SHARED,
    LENGTH,
    fingerprints,
    overlap,
)
from nao_course.instructor.similarity.known_code import given_code, right_answers

Answers = dict[str, list[str]]  # by exercise: one of each notebook
CLASS, COPIES = 300, 20  # students, and how many of them copied from another one
TIMED = "07_ekf_slam"


def renamed(code: str) -> str:
    """Return a code with other names for everything that it binds, except the names that its calls use as keywords."""
    tree = ast.parse(code)
    bound = {
        each.id for each in ast.walk(tree) if isinstance(each, ast.Name) and isinstance(each.ctx, ast.Store)
    }
    bound |= {each.arg for each in ast.walk(tree) if isinstance(each, ast.arg)} - {"self"}
    bound -= {each.arg for each in ast.walk(tree) if isinstance(each, ast.keyword) and each.arg}
    names = {name: f"my_{name[::-1]}" for name in bound}
    tokens = list(tokenize.generate_tokens(StringIO(code).readline))
    lines = code.splitlines(keepends=True)
    for before, token in reversed(list(zip([None, *tokens], tokens, strict=False))):
        is_attribute = before is not None and before.string == "."
        if token.type == tokenize.NAME and token.string in names and not is_attribute:
            (row, start), (_, end) = token.start, token.end
            lines[row - 1] = lines[row - 1][:start] + names[token.string] + lines[row - 1][end:]
    return "".join(lines)


def reformatted(code: str) -> str:
    """Return a code without its comments, laid out anew in short lines, with a comment of its own."""
    done = subprocess.run(
        [sys.executable, "-m", "ruff", "format", "--isolated", "--line-length", "60", "-"],
        input=ast.unparse(ast.parse(code)),
        capture_output=True,
        text=True,
        check=True,
    )
    return f"# my own work\n{done.stdout}"


def reordered(code: str) -> str:
    """Return a code with its definitions in reverse order, and neighbouring independent assignments swapped."""
    tree = ast.parse(code)
    tree.body = _reversed_definitions(tree.body)
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef):
            node.body = _reversed_definitions(node.body)
        for name in ("body", "orelse"):
            if isinstance(statements := getattr(node, name, None), list):
                setattr(node, name, _swapped(statements))
    return ast.unparse(tree)


def _reversed_definitions(body: list[ast.stmt]) -> list[ast.stmt]:
    places = [at for at, each in enumerate(body) if isinstance(each, ast.FunctionDef | ast.ClassDef)]
    moved = dict(zip(places, reversed(places), strict=True))
    return [body[moved.get(at, at)] for at in range(len(body))]


def _swapped(statements: list[ast.stmt]) -> list[ast.stmt]:
    done, at = list(statements), 0
    while at + 1 < len(done):
        first, second = done[at], done[at + 1]
        if isinstance(first, ast.Assign) and isinstance(second, ast.Assign) and _independent(first, second):
            done[at : at + 2] = second, first
            at += 1
        at += 1
    return done


def _independent(first: ast.Assign, second: ast.Assign) -> bool:
    """Return whether two assignments of plain names may change places: neither uses or replaces the other's names."""

    def names(node: ast.AST, context: type) -> set[str]:
        return {
            each.id for each in ast.walk(node) if isinstance(each, ast.Name) and isinstance(each.ctx, context)
        }

    plain = all(isinstance(target, ast.Name) for each in (first, second) for target in each.targets)
    stores = [names(each, ast.Store) for each in (first, second)]
    loads = [names(each, ast.Load) for each in (first, second)]
    return plain and not (stores[0] & (stores[1] | loads[1]) or stores[1] & loads[0])


def disguised(code: str) -> str:
    """Return a code that was renamed, reordered and reformatted."""
    return reformatted(reordered(renamed(code)))


CHANGES: dict[str, Callable[[str], str]] = {
    "renamed": renamed,
    "reformatted": reformatted,
    "reordered": reordered,
    "all three": disguised,
}


def given(course: Course, lesson: str) -> set[int]:
    """Return the fingerprints of a released notebook."""
    return set[int]().union(*map(fingerprints, given_code(course, lesson)))


class Lesson:
    """The right answers of a lesson as notebooks."""

    def __init__(self, given: set[int], answers: Answers) -> None:
        self.answers = answers
        self.many = max(map(len, answers.values()))
        self.given = given
        self.prints = {
            exercise: [fingerprints(code) for code in codes] for exercise, codes in answers.items()
        }

    def known(self, *but: int) -> set[int]:
        """Return the fingerprints of the release and of the answers that are not in some notebooks."""
        others = [each for prints in self.prints.values() for k, each in enumerate(prints) if k not in but]
        return self.given.union(*others)

    def notebook(self, number: int) -> set[int]:
        """Return the fingerprints of a notebook."""
        return set[int]().union(*(each[number] for each in self.prints.values() if number < len(each)))

    def codes(self, number: int) -> dict[str, str]:
        """Return the code of a notebook by exercise."""
        return {name: codes[number] for name, codes in self.answers.items() if number < len(codes)}

    def independent(self) -> Iterator[tuple[int, float]]:
        """Yield the overlap of all pairs of notebooks."""
        for i, j in combinations(range(self.many), 2):
            known = self.known(i, j)
            yield overlap(self.notebook(i) - known, self.notebook(j) - known)

    def copied(self, change: Callable[[str], str]) -> Iterator[tuple[int, float, int]]:
        """Yield the overlap of each notebook with a changed copy of it, and the fingerprints that the original has."""
        for k in range(self.many):
            known = self.known(k)
            copy = set[int]().union(*(fingerprints(change(code)) for code in self.codes(k).values()))
            mine = self.notebook(k) - known
            yield *overlap(mine, copy - known), len(mine)

    def half_copied(self) -> Iterator[tuple[int, float, int]]:
        """Yield the overlap with notebooks in which every second exercise is a copy with all changes."""
        for k in range(self.many):
            other = (k + 1) % self.many
            known = self.known(k, other)
            copied, own = self.codes(k), self.codes(other)
            half = [
                fingerprints(disguised(copied[name]) if at % 2 == 0 else own.get(name, ""))
                for at, name in enumerate(copied)
            ]
            mine = self.notebook(k) - known
            yield *overlap(mine, set[int]().union(*half) - known), len(mine)


def listed(shared: int, share: float) -> bool:
    """Return whether a pair is on the page."""
    return shared >= LEAST_SHARED and share >= LEAST_SHARE


def seconds_of_a_class(course: Course, students: int = CLASS, copies: int = COPIES) -> float:
    """Return the processor time for a class in which some copied.

    Each notebook holds right answers, drawn from the known ones, and a piece of code that no other one has.
    """
    chance, answers = random.Random(0), right_answers(course, TIMED)
    rest = (right_answers(course, name).values() for name in course.names() if name != TIMED)
    others = {code for lesson in rest for codes in lesson for code in codes}
    own = sorted(others, key=lambda code: (len(code), code))[copies - students :]
    written = ["\n\n".join([*map(chance.choice, answers.values()), each]) for each in own]
    blank = nbformat.read(ROOT / "notebooks" / f"{TIMED}.ipynb", as_version=4)
    with tempfile.TemporaryDirectory() as folder:
        for number, code in enumerate([*written, *map(disguised, written[:copies])]):
            notebook = nbformat.from_dict(blank)
            notebook.cells.append(nbformat.v4.new_code_cell(code))
            path = Path(folder, "class", f"student{number:03d}", f"{TIMED}.ipynb")
            path.parent.mkdir(parents=True)
            nbformat.write(notebook, path)
        start = time.process_time()
        list(find_similar(Console(quiet=True), Path(folder, "class"), [], Path(folder, "out")))
        return time.process_time() - start


def main() -> Result:
    """Measure false alarms, hits and time."""
    course = load_course(ROOT)
    answers = {name: right_answers(course, name) for name in course.names()}
    made = [Lesson(given(course, name), each) for name, each in answers.items() if each]
    independent = [each for lesson in made for each in lesson.independent()]
    copies = {name: [each for lesson in made for each in lesson.copied(way)] for name, way in CHANGES.items()}
    copies["half of the exercises, all three"] = [each for lesson in made for each in lesson.half_copied()]
    hits: dict[str, dict[str, float]] = {}
    for name, found in copies.items():
        large = [each[:2] for each in found if each[2] >= LEAST_SHARED]
        listed_copies, least = sum(listed(*each) for each in large), min(share for _, share in large)
        hits[name] = {"copies": len(large), "listed": listed_copies, "least_share": least}
    largest = sorted((share for _, share in independent), reverse=True)[:3]
    alarms, seconds = sum(listed(*each) for each in independent), seconds_of_a_class(course)
    values = {
        "length": LENGTH,
        "least_share": LEAST_SHARE,
        "least_shared": LEAST_SHARED,
        "independent": {"pairs": len(independent), "listed": alarms, "largest_shares": largest},
        "copies": hits,
        "class": {"notebooks": CLASS, "copies": COPIES, "seconds": seconds},
    }
    shares = ", ".join(f"{each:.2f}" for each in largest)
    notes = (
        f"{len(independent)} pairs of independent right answers: {alarms} listed, largest shares {shares}",
        f"A class of {CLASS} with {COPIES} copies in lesson {TIMED[:2]}: {seconds:.0f} s.",
    )
    return Result("similar", values, (Table.of("Copies", hits),), notes)
