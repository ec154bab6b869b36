"""A course of one small lesson whose exercises build on each other, ready to be graded without being built."""

import json
from pathlib import Path

import nbformat

from nao_course.instructor.authoring import stamps
from nao_course.instructor.authoring.course import Course, load_course

LESSON = "90_chain"
SECRET = b"a secret of sixteen bytes, or more"
DECLARATION = """
import numpy as np
from nao_course.exercises import Case, Close, Exercise, LessonPlan, Mistake, Written

def arrays(rng):
    return [Case((rng.uniform(-1000, 1000, (4, 3)),)) for _ in range(3)]

def exercise(name, points, mistake, **more):
    public = [Case((np.array([[1.5, -2.0], [0.25, 3.0]]),), "small"), Case((np.ones((2, 1)),), "ones")]
    wrong = [Mistake("slip", mistake, f"That is the slip in {name}.")]
    return Exercise(name, points, lambda: public, arrays, ("a", "b"), wrong, {}, **more)

PLAN = LessonPlan(
    [
        exercise("double", 2, lambda x: 3 * x),
        exercise("plus_one", 1, lambda x: x + 2),
        exercise("both", 3, lambda x: 2 * x, uses=("double", "plus_one"), with_reference=0.5),
        exercise("total", 1, lambda x: float(x.mean())),
    ],
    written=[Written("why", 2, "Why?", "Because.")],
)
"""
SETUP = "import numpy as np"
Json = dict[str, object]


def _functions(*bodies: str) -> dict[str, str]:
    names = ("double", "plus_one", "both", "total")
    return {name: f"def {name}(x):\n    {body}" for name, body in zip(names, bodies, strict=True)}


RIGHT = _functions("return 2 * x", "return x + 1", "return plus_one(double(x))", "return float(x.sum())")
BLANK = _functions(*["raise NotImplementedError"] * 4)
MISTAKES = _functions("return 3 * x", "return x + 2", "return 2 * x", "return float(x.mean())")


def cell(kind: str, source: str, grading: Json | None = None, role: str = "") -> Json:
    """A cell of a notebook."""
    metadata = ({"nbgrader": grading} if grading else {}) | ({"nao_course": {"role": role}} if role else {})
    code = {"outputs": [], "execution_count": None} if kind == "code" else {}
    number = f"c{abs(hash(source)) % 10**8}"
    return {"cell_type": kind, "id": number, "metadata": metadata, "source": source, **code}


def notebook(functions: dict[str, str] | None = None, answer: str = "", extra: str = "") -> bytes:
    """The lesson with some functions; the others are right."""
    cells = solutions(SETUP, RIGHT | (functions or {}))
    cells.append(cell("markdown", answer, grading("why", grade=True) | {"points": 2}, "written"))
    if extra:
        cells.append(cell("code", extra))
    return as_notebook(LESSON, cells)


def grading(name: str, *, grade: bool = False) -> Json:
    """What nbgrader writes into a cell that a student fills in."""
    return {"schema_version": 3, "grade_id": name, "solution": True, "grade": grade, "locked": False}


def solutions(setup: str, functions: dict[str, str]) -> list[Json]:
    """The set-up cell, and a cell of each function."""
    first = cell("code", setup, role="setup")
    return [first, *(cell("code", source.strip(), grading(name)) for name, source in functions.items())]


def as_notebook(lesson: str, cells: list[Json]) -> bytes:
    stamp = {"nao_course": {"lesson": lesson, "version": "1"}}
    return json.dumps({"nbformat": 4, "nbformat_minor": 5, "metadata": stamp, "cells": cells}).encode()


def make_course(root: Path) -> Course:
    """Lay the course out in a folder."""
    course = lay_out(root, LESSON, DECLARATION, notebook(), notebook(BLANK))
    stamp(course, LESSON)
    return course


def lay_out(root: Path, lesson: str, declaration: str, solution: bytes, blank: bytes) -> Course:
    """Write a course of one lesson, which is not stamped."""
    for folder in ("solutions/exercises", "notebooks"):
        (root / folder).mkdir(parents=True)
    (root / "course.toml").write_text(f'title = "{lesson[3:].title()}"\nversion = "1"\n')
    (root / "solutions" / f"{lesson}.md").write_text(f"# {lesson[3:].title()}\n")
    (root / "solutions" / "exercises" / f"{lesson}.py").write_text(declaration)
    (root / "notebooks" / f"{lesson}.ipynb").write_bytes(blank)
    (root / "solutions" / f"{lesson}.ipynb").write_bytes(solution)
    return load_course(root)


def stamp(course: Course, lesson: str) -> None:
    """Let a solution notebook say that it was built from text and declaration as they are."""
    path = course.solutions / f"{lesson}.ipynb"
    solved, text = nbformat.read(path, as_version=4), course.text(lesson).read_text(encoding="utf-8")
    made = stamps.stamp(course, lesson, text, solved, executed=True)
    solved.metadata.setdefault("nao_course", {}).update(made)
    nbformat.write(solved, path)


def hand_in(root: Path, student: str, content: bytes) -> Path:
    """Put a student's notebook where it is looked for."""
    (root / student).mkdir(parents=True, exist_ok=True)
    path = root / student / f"{LESSON}.ipynb"
    path.write_bytes(content)
    return path
