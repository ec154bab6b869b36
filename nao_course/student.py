"""The student's own functions, from their own earlier notebooks."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from nao_course.exercises.checking import Report, grade_public, read_public
from nao_course.exercises.definitions import Definitions, load_definitions
from nao_course.exercises.trying import Message


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
    """

    lesson: str
    right: Mapping[str, Callable[..., Any]]
    reports: tuple[Report, ...] = ()

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
                raise KeyError(f"{name} of lesson {self.lesson} is not usable yet. {report.lines[0]}")
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
    path = Path(folder or os.environ.get("NAO_COURSE_NOTEBOOKS") or ".") / f"{lesson}.ipynb"
    found = _definitions(path, path.stat().st_mtime_ns) if path.is_file() else Definitions({})
    right: dict[str, Callable[..., Any]] = {}
    reports: list[Report] = []
    for exercise in public.exercises:
        if exercise.name not in found:
            text = f"{exercise.number} {exercise.name}: not found in {path.name}."
            reports.append(Report(exercise.name, "not attempted", (text,)))
            continue
        report = grade_public(exercise, found[exercise.name])
        if report:
            right[exercise.name] = found[exercise.name]
        else:
            reports.append(report)
    return StudentFunctions(lesson, right, tuple(reports))


@lru_cache(maxsize=32)
def _definitions(path: Path, changed: int) -> Definitions:
    """Definitions of a notebook as it was saved at a time."""
    try:
        return load_definitions(path)
    except ValueError:
        return Definitions({})
