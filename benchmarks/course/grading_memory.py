"""How much memory the largest notebooks take: six of lesson 01 at once, and lesson 11 with the seven that it uses.

``python -m benchmarks grading_memory`` grades both with two jobs. Each notebook is filled up with a stored output.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path

import nbformat

from benchmarks import ROOT, Result, Table
from benchmarks.course.grading import LESSON, grade, notebooks, write_secret
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.autograding.assignment import lessons_used

LATE = "11_slam_on_the_field"
JOBS = 2


def filled_up(text: str, megabytes: float) -> str:
    """Return a notebook with a stored output, so that its file has a size."""
    notebook = nbformat.reads(text, as_version=4)
    output = nbformat.v4.new_output("stream", name="stdout", text="")
    next(each for each in notebook.cells if each.cell_type == "code").outputs = [output]
    output.text = "x" * (int(2**20 * megabytes) - len(nbformat.writes(notebook).encode()))
    return nbformat.writes(notebook)


def six_of_a_class() -> Iterator[tuple[str, str, str]]:
    """Yield student, lesson and text of six submissions of 49.5 MB."""
    for number, (_, text) in enumerate(islice(notebooks(), 6)):
        yield f"student{number}", LESSON, filled_up(text, 49.5)


def with_all_that_it_uses() -> Iterator[tuple[str, str, str]]:
    """Yield student, lesson and text of eight notebooks of 48 MB: lesson 11 and the lessons that it uses."""
    course = load_course(ROOT)
    for lesson in (*lessons_used(course, LATE), LATE):
        text = (course.solutions / f"{lesson}.ipynb").read_text(encoding="utf-8")
        yield "ada", lesson, filled_up(text, 48.0)


CLASSES: dict[str, tuple[Callable[[], Iterator[tuple[str, str, str]]], str]] = {
    "six of 49.5 MB": (six_of_a_class, LESSON),
    "lesson 11, eight of 48 MB": (with_all_that_it_uses, LATE),
}


def measured(folder: Path, made: Iterator[tuple[str, str, str]], lesson: str) -> dict[str, float]:
    """Grade some large notebooks, and return the largest memory of all processes and of the grader, in MB."""
    write_secret(folder)
    for student, name, text in made:
        path = folder / "class" / student / f"{name}.ipynb"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    number = lesson.partition("_")[0]
    found, results = grade(folder / "class", folder / "grades", JOBS, "--lesson", number)
    return found | {"points": sum(result.earned for result in results if result.lesson == lesson)}


def main() -> Result:
    """Grade both."""
    values = {}
    for name, (make, lesson) in CLASSES.items():
        with tempfile.TemporaryDirectory(prefix="nao_course_bench_") as folder:
            values[name] = measured(Path(folder), make(), lesson)
    return Result("grading_memory", values, (Table.of(f"large notebooks, {JOBS} jobs", values),))
