"""Every sibling of an exercise runs by itself, prints what students read, and does not solve the exercise."""

import ast
import io
from contextlib import redirect_stdout
from functools import cache

import pytest

from nao_course.exercises.checking import grade_public
from nao_course.instructor.authoring import lesson_text
from nao_course.instructor.authoring.leaks import fingerprints
from tests.lessons.every import (
    COURSE,
    NAMES,
    earlier_functions_are_the_references,  # noqa: F401 - for every test here
    public_exercise,
    solved,
)

LONGEST = 12  # lines of code, without empty ones
COMMON = 25  # characters of a line that may be in the solution, too
SIBLINGS = [
    (name, exercise)
    for name in NAMES
    for exercise in COURSE.plan(name).exercises
    if exercise.sibling is not None
]

each_sibling = pytest.mark.parametrize(
    ("name", "exercise"), SIBLINGS, ids=[exercise.name for _, exercise in SIBLINGS]
)


def lines(source):
    """Return the lines of code that are not empty."""
    return [line.strip() for line in source.splitlines() if line.strip()]


def run(code):
    """Run code as in a notebook that was just opened; return what it prints and the names that it defines."""
    names, printed = {"__name__": "sibling"}, io.StringIO()
    with redirect_stdout(printed):
        exec(code, names)
    return printed.getvalue().rstrip(), names


@cache
def solutions():
    """Return the long lines of all solutions, and the fingerprints of their code."""
    cells = [cell for name in NAMES for _, cell in lesson_text.code_cells(solved(name), "exercise")]
    long = {line for cell in cells for line in lines(cell.source) if len(line) > COMMON}
    pieces = (fingerprints(lesson_text.python(cell), lesson_text.solution_lines(cell)) for cell in cells)
    return long, {piece for each in pieces for piece, _ in each}


@each_sibling
def test_rubric_9_a_sibling_is_short_needs_only_numpy_and_prints_what_is_shown(name, exercise):
    code, output = exercise.sibling.blocks
    assert len(lines(code)) <= LONGEST
    imported = [each for each in ast.walk(ast.parse(code)) if isinstance(each, ast.Import | ast.ImportFrom)]
    assert {ast.unparse(each) for each in imported} <= {"import numpy as np"}
    assert run(code)[0] == output


@each_sibling
def test_rubric_9_a_sibling_does_not_solve_the_exercise_and_shares_no_code_with_a_solution(name, exercise):
    code, _ = exercise.sibling.blocks
    long, pieces = solutions()
    assert not {*lines(code)} & long
    assert not {piece for piece, _ in fingerprints(code)} & pieces
    own = [each.name for each in ast.parse(code).body if isinstance(each, ast.FunctionDef | ast.ClassDef)]
    assert exercise.name not in own
    names = run(code)[1]
    for each in own:  # renamed, it would be handed in as this function
        assert not grade_public(public_exercise(name, exercise.name), names[each]), each
