"""The student's own functions, from their own earlier notebooks."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from functools import lru_cache
from io import StringIO
from pathlib import Path
from typing import Any

from nao_course.exercises.checking import Report, grade_public, read_public
from nao_course.exercises.definitions import NO_DEFINITION, Definitions, load_definitions
from nao_course.exercises.exercise import ANSWER_HERE
from nao_course.exercises.trying import Message

__all__ = ["StudentFunctions", "functions"]


@dataclass(frozen=True)
class StudentFunctions(Mapping[str, Callable[..., Any]]):
    """A lesson's exercises as the student solved them: those that pass their public checks.

    Parameters
    ----------
    lesson : str
        Such as "01_hsl_filtering".
    right : mapping of str to callable
        The functions that can be used.
    reports : tuple of Report
        What the checks said of the others.
    unwritten : tuple of str
        Written questions without an answer.
    """

    lesson: str
    right: Mapping[str, Callable[..., Any]]
    reports: tuple[Report, ...] = ()
    unwritten: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> Callable[..., Any]:
        """Return a function.

        Raises
        ------
        KeyError
            If it is missing or wrong: the message says so.
        """
        if name in self.right:
            return self.right[name]
        for report in self.reports:
            if report.name == name:
                raise KeyError(f"{name} of lesson {self.lesson} is not usable yet. {' '.join(report.lines)}")
        raise KeyError(f"lesson {self.lesson} has no exercise {name!r}")

    def __iter__(self) -> Iterator[str]:
        """Names of the functions that can be used."""
        return iter(self.right)

    def __len__(self) -> int:
        """How many can be used."""
        return len(self.right)

    @property
    def complete(self) -> bool:
        """Whether every exercise of the lesson can be used."""
        return not self.reports

    def __repr__(self) -> str:
        """Say what can be used and what cannot."""
        return self._message().text

    def _repr_html_(self) -> str:
        """Say the same in Jupyter."""
        return self._message()._repr_html_()

    def _message(self) -> Message:
        if self.complete:
            return Message(f"Your lesson {self.lesson}: all {len(self)} functions are ready.")
        missing = ", ".join(f"{report.name} ({report.state})" for report in self.reports)
        return Message(
            f"Your lesson {self.lesson}: {len(self)} functions are ready. Not usable yet: {missing}. "
            "The lesson goes on without them, with recorded data or the simulator's ideal sensor."
        )


def functions(lesson: str, folder: str | Path | None = None) -> StudentFunctions:
    """Load the student's own functions of an earlier lesson.

    Parameters
    ----------
    lesson : str
        Such as "01_hsl_filtering".
    folder : str or Path, optional
        Where the notebooks are; by default $NAO_COURSE_NOTEBOOKS, else the working folder.

    Returns
    -------
    StudentFunctions
        Those that pass their public checks; what is missing or wrong is said, never replaced by the answer.

    Raises
    ------
    ValueError
        If there is no such lesson.
    """
    public = read_public(lesson)
    path = (Path(folder or os.environ.get("NAO_COURSE_NOTEBOOKS") or ".") / f"{lesson}.ipynb").resolve()
    try:
        found = _definitions(path, path.stat().st_mtime_ns)
        reasons = [
            f"Cell {each.cell}: {each.reason}." for each in found.skipped if each.reason != NO_DEFINITION
        ]
    except (OSError, ValueError) as error:
        found, reasons = Definitions({}), [f"{path.name} cannot be read: {error}."]
    right: dict[str, Callable[..., Any]] = {}
    reports: list[Report] = []
    for exercise in public.exercises:
        if exercise.name not in found:
            lines = (f"{exercise.number} {exercise.name}: not found in {path.name}.", *reasons)
            reports.append(Report(exercise.name, "raised" if reasons else "not attempted", lines))
            continue
        with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
            report = grade_public(exercise, found[exercise.name])
        if report:
            right[exercise.name] = found[exercise.name]
        else:
            reports.append(report)
    unwritten = [each.number for each in public.written if _blank(found.text.written.get(each.name, ""))]
    return StudentFunctions(lesson, right, tuple(reports), tuple(unwritten))


def _blank(answer: str) -> bool:
    return answer.strip() in ("", ANSWER_HERE)


@lru_cache(maxsize=32)
def _definitions(path: Path, changed: int) -> Definitions:
    """Definitions of a notebook as it was saved at a time; what it prints is not wanted in another one."""
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        return load_definitions(path)


def __dir__() -> list[str]:
    """What tab completion shows: not what this module imports."""
    return __all__
