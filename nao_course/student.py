"""The student's own functions, from their own earlier notebooks."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass, field
from functools import lru_cache
from io import StringIO
from pathlib import Path
from typing import Any

from nao_course.exercises.checking import Report, grade_public, lessons, read_public
from nao_course.exercises.definitions import NO_DEFINITION, Definitions, load_definitions
from nao_course.exercises.earlier import EarlierNotUsable, is_resolved, not_usable, split_use, stand_in
from nao_course.exercises.exercise import ANSWER_HERE, PublicExercise
from nao_course.exercises.lesson_names import PATTERN, meant, number_of
from nao_course.exercises.trying import Message

__all__ = ["StudentFunctions", "earlier", "earlier_in", "functions"]


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
    remarks : mapping of str to tuple of str
        What the checks said of the right ones, besides that they are.
    """

    lesson: str
    right: Mapping[str, Callable[..., Any]]
    reports: tuple[Report, ...] = ()
    unwritten: tuple[str, ...] = ()
    remarks: Mapping[str, tuple[str, ...]] = field(default_factory=dict)

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
    path = _folder(folder) / f"{lesson}.ipynb"
    found, reasons = _read(path)
    reports = {each.name: _report(each, path, found, reasons) for each in public.exercises}
    right = {name: found[name] for name, report in reports.items() if report}
    unwritten = [each.number for each in public.written if _blank(found.text.written.get(each.name, ""))]
    wrong = tuple(report for report in reports.values() if not report)
    remarks = {name: report.lines[1:] for name, report in reports.items() if report}
    return StudentFunctions(lesson, right, wrong, tuple(unwritten), remarks)


def earlier(use: str, folder: str | Path | None = None) -> Any:
    """Return your own function of an earlier lesson; a lesson's set-up cell calls this.

    Where yours is missing or wrong, it says so once; then calling it raises that sentence, but for the checks of the
    lesson, which have recorded what it would answer.

    Parameters
    ----------
    use : str
        Lesson and function: "01:color_labels".
    folder : str or Path, optional
        As in `functions`.

    Returns
    -------
    callable
        The function; of a class, that class.

    Raises
    ------
    ValueError
        If there is no such lesson or exercise.
    """
    if is_resolved():  # in a declaration of exercises: no student's folder is meant
        return stand_in(use, not_usable(use))
    made = earlier_in(_folder(folder))(use)
    if not isinstance(made, type):
        try:
            made.find()
        except EarlierNotUsable as sentence:
            from IPython.display import display  # it takes long to import

            display(Message(f"{sentence} The checks of this lesson have recorded answers for it."))
    return made


def earlier_in(folder: Path) -> Callable[[str], Any]:
    """Return what finds functions of earlier lessons in the notebooks of a folder; it says nothing by itself."""

    def find(use: str) -> Any:
        lesson, exercise = _exercise(use)
        path = folder.resolve() / f"{lesson}.ipynb"
        found, reasons = _read(path)
        report = _report(exercise, path, found, reasons)
        if report:
            return stand_in(use, lambda: found[exercise.name])
        return stand_in(use, not_usable(use, " ".join(report.lines)))

    return find


def _exercise(use: str) -> tuple[str, PublicExercise]:
    """Name of the lesson, and the exercise, of "01:color_labels"."""
    number, name = split_use(use)
    found = meant(number, lessons())
    if len(found) != 1:
        raise ValueError(f"{use!r}: there is no lesson {number!r} with checks; there are {lessons()}")
    for exercise in read_public(found[0]).exercises:
        if exercise.name == name:
            return found[0], exercise
    raise ValueError(f"{use!r}: lesson {found[0]} has no exercise {name!r}")


def _folder(folder: str | Path | None) -> Path:
    return Path(folder or os.environ.get("NAO_COURSE_NOTEBOOKS") or ".").resolve()


def _read(path: Path) -> tuple[Definitions, list[str]]:
    """A notebook's definitions, and why some of them are missing."""
    try:
        times = tuple(each.stat().st_mtime_ns for each in sorted(path.parent.glob(f"{PATTERN}.ipynb")))
        found = _definitions(path, path.stat().st_mtime_ns, times)
    except (OSError, ValueError) as error:
        return Definitions({}), [f"{path.name} cannot be read: {error}."]
    reasons = [f"Cell {each.cell}: {each.reason}." for each in found.skipped if each.reason != NO_DEFINITION]
    return found, reasons


def _report(exercise: PublicExercise, path: Path, found: Definitions, reasons: list[str]) -> Report:
    """What the public checks say of an exercise in a notebook; nothing that it prints is shown."""
    if exercise.name not in found:
        lines = (f"{exercise.number} {exercise.name}: not found in {path.name}.", *reasons)
        return Report(exercise.name, "raised" if reasons else "not attempted", lines)
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        return grade_public(exercise, found[exercise.name])


def _blank(answer: str) -> bool:
    return answer.strip() in ("", ANSWER_HERE)


@lru_cache(maxsize=32)
def _definitions(path: Path, changed: int, others: tuple[int, ...]) -> Definitions:
    """Definitions of a notebook as it and the others were saved; what it prints is not wanted in another one."""

    def before_this(use: str) -> Any:
        if split_use(use)[0] >= number_of(path.stem):  # two lessons that use each other would never end
            return stand_in(use, not_usable(use, f"lesson {path.stem} comes first."))
        return earlier_in(path.parent)(use)

    with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        return load_definitions(path, earlier=before_this)


def __dir__() -> list[str]:
    """What tab completion shows: not what this module imports."""
    return __all__
