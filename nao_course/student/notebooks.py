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

import numpy as np

from nao_course.exercises.checking import grade_public, lessons, read_public, strict
from nao_course.exercises.definitions import NO_DEFINITION, Definitions, Skipped, load_definitions
from nao_course.exercises.earlier import EarlierNotUsable, is_resolved, not_usable, split_use, stand_in
from nao_course.exercises.exercise import ANSWER_HERE, PublicExercise
from nao_course.exercises.judging import CheckState, Report, with_the_reason
from nao_course.exercises.lesson_names import PATTERN, meant, number_of
from nao_course.exercises.running import TimeIsUp, alarm
from nao_course.exercises.trying import Message
from nao_course.student import verdicts

SECONDS = 20.0  # wall clock of loading a notebook
GLANCE = 0.9  # s: who has no more than this on a busy machine may not speak of endless loops
_NOT_RIGHT = {
    "not attempted": "is not written yet",
    "not checked": "cannot be checked yet",
    "interrupted": "takes too long in its check",
}


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
    problem : str
        Why the notebook cannot be read, in a sentence; empty where it can.
    skipped : tuple of Skipped
        Statements of the notebook that failed.
    """

    lesson: str
    right: Mapping[str, Callable[..., Any]]
    reports: tuple[Report, ...] = ()
    unwritten: tuple[str, ...] = ()
    remarks: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    problem: str = ""
    skipped: tuple[Skipped, ...] = ()

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


def functions(
    lesson: str, folder: str | Path | None = None, most_seconds: float = np.inf
) -> StudentFunctions:
    """Load the student's own functions of an earlier lesson.

    Parameters
    ----------
    lesson : str
        Such as "01_hsl_filtering".
    folder : str or Path, optional
        Where the notebooks are; by default $NAO_COURSE_NOTEBOOKS, else the working folder.
    most_seconds : float
        Wall clock that loading the notebook, and each case of a check, gets at most.

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
    path = notebooks_folder(folder) / f"{lesson}.ipynb"
    notebook = _read(path, most_seconds)
    found = notebook.found
    alone = {each.name: _report(each, notebook, most_seconds) for each in public.exercises}
    reports = {each.name: with_the_reason(each, alone[each.name], alone) for each in public.exercises}
    right = {name: found[name] for name, report in reports.items() if report}
    unwritten = [each.number for each in public.written if _blank(found.text.written.get(each.name, ""))]
    wrong = tuple(report for report in reports.values() if not report)
    remarks = {name: report.lines[1:] for name, report in reports.items() if report}
    return StudentFunctions(
        lesson, right, wrong, tuple(unwritten), remarks, notebook.problem, notebook.failed
    )


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
    find, like = _finder(notebooks_folder(folder), use)
    try:
        find()
    except EarlierNotUsable as sentence:
        from IPython.display import display  # it takes long to import

        display(Message(f"{sentence} The checks of this lesson have recorded answers for it."))
    return stand_in(use, find, like)


def earlier_in(folder: Path) -> Callable[[str], Any]:
    """Return what finds functions of earlier lessons in the notebooks of a folder; it says nothing by itself."""
    return lambda use: stand_in(use, *_finder(folder, use))


def _finder(folder: Path, use: str) -> tuple[Callable[[], Any], Any]:
    """Return what finds an earlier function, or raises why not; and the function as it is, right or not, if any."""
    lesson, exercise = _exercise(use)
    notebook = _read(folder.resolve() / f"{lesson}.ipynb")
    report, own = _report(exercise, notebook), notebook.found.get(exercise.name)
    return (lambda: own) if report else not_usable(use, " ".join(report.lines)), own


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


def notebooks_folder(folder: str | Path | None = None) -> Path:
    """Return where the student's notebooks are: as said, else $NAO_COURSE_NOTEBOOKS, else the working folder."""
    return Path(folder or os.environ.get("NAO_COURSE_NOTEBOOKS") or ".").resolve()


def own_function(
    use: str, given: Mapping[str, Any], folder: Path, most_seconds: float = np.inf
) -> tuple[Any, str]:
    """Return the student's own function, if it passes its public checks.

    Parameters
    ----------
    use : str
        Lesson and function: "01:color_labels".
    given : mapping of str to object
        Functions at hand, by name; one of them that is right is taken.
    folder : Path
        Of the saved notebooks, for the others.
    most_seconds : float
        As in `functions`.

    Returns
    -------
    function : object
        None where there is none that is right.
    why : str
        Then the reason, in words: "color_labels of lesson 01 is not written yet".
    """
    lesson, exercise = _exercise(use)
    reports = []
    if exercise.name in given:
        reports.append(_quietly_graded(exercise, given[exercise.name], most_seconds))
        if reports[0]:
            return given[exercise.name], ""
    notebook = _read(folder / f"{lesson}.ipynb", most_seconds)
    reports.append(_report(exercise, notebook, most_seconds))
    if reports[-1]:
        return notebook.found[exercise.name], ""
    if notebook.problem and len(reports) == 1:
        return None, notebook.problem.rstrip(".")
    return None, _lacking(lesson, reports[0])


def _lacking(lesson: str, report: Report) -> str:
    """What an exercise that is not right lacks, in words."""
    state = _NOT_RIGHT.get(report.state, "does not pass its check yet")
    return f"{report.name} of lesson {number_of(lesson)} {state}"


def looked_at(use: str, folder: Path) -> str | None:
    """Return what the student's own function lacks, by what was kept of an earlier look at the saved notebooks.

    Parameters
    ----------
    use : str
        Lesson and function: "01:color_labels".
    folder : Path
        Of the saved notebooks.

    Returns
    -------
    str or None
        Empty where it passes its public checks; None where nobody has looked since the notebooks were saved.
    """
    lesson, exercise = _exercise(use)
    return verdicts.kept(folder / f"{lesson}.ipynb", exercise.name)


@dataclass(frozen=True)
class _Notebook:
    """A notebook's definitions, and why some of them, or all, are missing."""

    path: Path
    found: Definitions
    problem: str = ""

    @property
    def failed(self) -> tuple[Skipped, ...]:
        return tuple(each for each in self.found.skipped if each.reason != NO_DEFINITION)


def _read(path: Path, most_seconds: float = np.inf) -> _Notebook:
    seconds = min(SECONDS, most_seconds)
    try:
        times = tuple(each.stat().st_mtime_ns for each in sorted(path.parent.glob(f"{PATTERN}.ipynb")))
        with alarm(seconds):
            return _Notebook(path, _definitions(path, path.stat().st_mtime_ns, times))
    except FileNotFoundError:
        problem = f"{path.name} is not in your folder {path.parent.name}."
    except OSError as error:
        problem = f"{path.name} cannot be read: {error.strerror or error}."
    except ValueError as error:  # it names the file
        problem = f"{error}."
    except TimeIsUp:
        why = (
            "is the computer busy, or does a loop outside a function never end?"
            if seconds > GLANCE
            else "progress() gives it more time."
        )
        problem = f"{path.name} takes longer than {seconds:g} s: {why}"
    return _Notebook(path, Definitions({}), problem)


def _report(exercise: PublicExercise, notebook: _Notebook, most_seconds: float = np.inf) -> Report:
    """What the public checks say of an exercise in a notebook."""
    title = f"{exercise.number} {exercise.name}"
    if notebook.problem:
        state: CheckState = "raised" if notebook.path.exists() else "not attempted"
        return Report(exercise.name, state, (f"{title}: {notebook.problem}",))
    if exercise.name not in notebook.found:
        reasons = [f"Cell {each.cell}: {each.reason}." for each in notebook.failed]
        lines = (f"{title}: not found in {notebook.path.name}.", *reasons)
        return Report(exercise.name, "raised" if reasons else "not attempted", lines)
    report = _quietly_graded(exercise, notebook.found[exercise.name], most_seconds)
    if report.state != "interrupted" and not strict():  # a longer look may say otherwise
        verdicts.keep(notebook.path, exercise.name, "" if report else _lacking(notebook.path.stem, report))
    return report


def _quietly_graded(exercise: PublicExercise, function: Any, most_seconds: float) -> Report:
    """What the public checks say of a function; nothing that it prints is shown."""
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        return grade_public(exercise, function, most_seconds)


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
