"""The numbers of each student's personal world, for those who mark written answers."""

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping
from functools import cache
from inspect import signature
from pathlib import Path

from rich.progress import track

from nao_course._internal.personal_world import PersonalWorld
from nao_course._internal.tables import read_table
from nao_course.exercises.definitions import Definitions
from nao_course.exercises.earlier import resolved_by
from nao_course.exercises.notebook_text import read_cells
from nao_course.instructor.authoring.course import Course
from nao_course.instructor.authoring.plans import PlanError, load_solution, solutions_beside
from nao_course.instructor.autograding.assignment import library_digest
from nao_course.instructor.gradebook.records import SubmissionResult

Numbers = Mapping[str, float]  # by what they are
Compute = Callable[..., Numbers]  # see `Written.numbers`


class PersonalNumbers:
    """Numbers that a student's answer to a written question must contain, if the question asks for any.

    They are computed with the solution and kept in a file, because some take seconds for each student. The file at
    `path` may be deleted; lessons with such questions must be built. `names` are the names in the students' copies of
    the course, where they differ from the names in the gradebook.
    """

    def __init__(self, course: Course, path: Path, names: Mapping[str, str] | None = None) -> None:
        """Read the numbers that are kept."""
        self._course, self._path, self._names = course, path, names or {}
        try:
            self._kept: dict[str, dict[str, float]] = json.loads(path.read_bytes())
        except (OSError, ValueError):
            self._kept = {}
        self._questions, self._solution, self._version = (
            cache(self._questions_of),
            cache(self._solution_of),
            cache(self._version_of),
        )

    def needs(self, lesson: str, question: str) -> bool:
        """Return whether a question asks for numbers of the personal world."""
        return question in self._questions(lesson)

    def __call__(self, lesson: str, question: str, student: str) -> Numbers:
        """Return the numbers of a student; none if the question asks for none, the example's if the name is empty."""
        compute = self._questions(lesson).get(question)
        if compute is None:
            return {}
        name = self._names.get(student, student)
        key = "/".join([lesson, question, name, self._version(lesson)])
        if key not in self._kept:
            with resolved_by(solutions_beside(self._notebook(lesson))):
                found = numbers_of(PersonalWorld(name), compute, self._solution(lesson))
            self._kept[key] = {name: float(value) for name, value in found.items()}
        return self._kept[key]

    def compute(self, results: Iterable[SubmissionResult]) -> None:
        """Compute the numbers of all answers that need any, with a progress bar, and write them to the file."""
        wanted = [
            (result.lesson, answer.name, result.student)
            for result in results
            for answer in result.written
            if answer.text.strip() and self.needs(result.lesson, answer.name)
        ]
        try:
            for lesson, question, student in track(wanted, "personal numbers", disable=not wanted):
                self(lesson, question, student)
        finally:
            self._keep()

    def _keep(self) -> None:
        """Write all numbers to the file; no file if there are none."""
        if self._kept:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._path.write_text(json.dumps(self._kept, ensure_ascii=False), encoding="utf-8")

    def _notebook(self, lesson: str) -> Path:
        return self._course.solutions / f"{lesson}.ipynb"

    def _questions_of(self, lesson: str) -> Mapping[str, Compute]:
        if lesson not in self._course.names():
            return {}
        return {
            each.name: each.numbers for each in self._course.plan(lesson).written if each.numbers is not None
        }

    def _solution_of(self, lesson: str) -> Definitions:
        return load_solution(self._notebook(lesson))

    def _version_of(self, lesson: str) -> str:
        cells = json.dumps(read_cells(self._notebook(lesson)))
        return hashlib.sha256(f"{library_digest(lesson)}{cells}".encode()).hexdigest()[:16]


def numbers_of(world: PersonalWorld, compute: Compute, solution: Definitions) -> Numbers:
    """Return the numbers of a world by what they are, computed with the solution's functions.

    Raise a PlanError if the solution lacks a function that `compute` needs.
    """
    names = list(signature(compute).parameters)[1:]
    if missing := [name for name in names if name not in solution.namespace]:
        raise PlanError(
            f"{compute.__qualname__} needs {', '.join(missing)}, which the solution does not define"
        )
    return compute(world, *(solution.namespace[name] for name in names))


def read_worlds(path: Path) -> dict[str, str]:
    """Read the names in the students' copies from a CSV file with the columns "student" and "world".

    Raise a TableError if it is not such a file.
    """
    return {row["student"].strip(): row["world"] for row in read_table(path, ("student", "world"))}
