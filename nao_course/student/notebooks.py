"""The student's own functions from earlier notebooks."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass, field, replace
from functools import lru_cache
from html import escape
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from nao_course.exercises.answered import notebooks_in
from nao_course.exercises.checking import grade_public, lessons, read_public
from nao_course.exercises.definitions import NO_DEFINITION, Definitions, Skipped, load_definitions
from nao_course.exercises.earlier import EarlierNotUsable, is_resolved, not_usable, split_use, stand_in
from nao_course.exercises.exercise import PublicExercise
from nao_course.exercises.failed_cells import where_reused, why_missing
from nao_course.exercises.interactive import unattended
from nao_course.exercises.judging import CheckState, Report, with_the_reason
from nao_course.exercises.lesson_names import meant, number_of
from nao_course.exercises.outline import read_outline
from nao_course.exercises.running import TimeIsUp, alarm
from nao_course.exercises.trying import Message, strict
from nao_course.exercises.versions import newer_than_here
from nao_course.student import verdicts

SECONDS = 20.0  # wall clock for loading a notebook
SHORT_TIME = 0.9  # s: a notebook that takes longer than this is not suspected of an endless loop
_NOT_RIGHT = {
    "not attempted": "is not written yet",
    "not checked": "cannot be checked yet",
    "interrupted": "takes too long in its check",
}


@dataclass(frozen=True)
class StudentFunctions(Mapping[str, Callable[..., Any]]):
    """The student's functions of one lesson, such as "01_hsl_filtering", that pass their public checks.

    `reports` are on the exercises that do not pass, `unwritten` are the numbers of the written questions without an
    answer, `remarks` are further remarks of the checks about functions that pass, `problem` says why the notebook
    cannot be read, and `skipped` are its statements that failed.
    """

    lesson: str
    right: Mapping[str, Callable[..., Any]]
    reports: tuple[Report, ...] = ()
    unwritten: tuple[str, ...] = ()
    remarks: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    problem: str = ""
    skipped: tuple[Skipped, ...] = ()

    def __getitem__(self, name: str) -> Callable[..., Any]:
        """Return a function; if it is missing or wrong, raise a KeyError whose message explains why."""
        if name in self.right:
            return self.right[name]
        for report in self.reports:
            if report.name == name:
                raise KeyError(f"{name} of lesson {self.lesson} is not usable yet. {' '.join(report.lines)}")
        raise KeyError(f"lesson {self.lesson} has no exercise {name!r}")

    def __iter__(self) -> Iterator[str]:
        """Return an iterator over the names of the functions that pass."""
        return iter(self.right)

    def __len__(self) -> int:
        """Return the number of functions that pass."""
        return len(self.right)

    @property
    def complete(self) -> bool:
        """Whether every exercise of the lesson passes."""
        return not self.reports

    def __repr__(self) -> str:
        """Return the numbers of ready and missing functions as text."""
        return self._message().text

    def _repr_html_(self) -> str:
        """Return the same text as HTML."""
        return self._message()._repr_html_()

    def _message(self) -> Message:
        if self.complete:
            return Message(f"Your lesson {self.lesson}: all {len(self)} functions are ready.")
        missing = ", ".join(f"{report.name} ({report.state})" for report in self.reports)
        return Message(
            f"Your lesson {self.lesson}: {len(self)} functions are ready. Not usable yet: {missing}. "
            "Without them, the lesson uses recorded data or the simulator's ideal sensor."
        )


def functions(
    lesson: str, folder: str | Path | None = None, most_seconds: float = np.inf, notebook: Path | None = None
) -> StudentFunctions:
    """Load the student's own functions of an earlier lesson.

    Parameters
    ----------
    lesson : str
        Name of the lesson, such as "01_hsl_filtering".
    folder : str or Path, optional
        Folder of the notebooks; by default $NAO_COURSE_NOTEBOOKS, else the working folder.
    most_seconds : float
        Longest wall clock for loading the notebook, and for each case of a check.
    notebook : Path, optional
        The notebook; by default the lesson's notebook in the folder, of several copies the copy that a grader counts.

    Returns
    -------
    StudentFunctions
        The functions that pass their public checks, and reports on the others, which are never replaced by a solution.

    Raises
    ------
    ValueError
        If there is no such lesson.
    """
    public = read_public(lesson)
    loaded = _read(lesson, notebook or notebook_of(lesson, notebooks_folder(folder)), most_seconds)
    found = loaded.found
    alone = {each.name: _report(each, loaded, most_seconds) for each in public.exercises}
    reports = {each.name: with_the_reason(each, alone[each.name], alone) for each in public.exercises}
    right = {name: found[name] for name, report in reports.items() if report}
    unwritten = [each.number for each in public.written if not found.text.written.get(each.name)]
    wrong = tuple(report for report in reports.values() if not report)
    remarks = {name: report.lines[1:] for name, report in reports.items() if report}
    return StudentFunctions(lesson, right, wrong, tuple(unwritten), remarks, loaded.problem, loaded.failed)


def earlier(use: str, folder: str | Path | None = None) -> Any:
    """Return your own function of an earlier lesson; a lesson's set-up cell calls this.

    If your function is missing or wrong, a note explains why, and a call of the function raises an error that refers
    to this note.
    The checks of the lesson use recorded answers instead.

    Parameters
    ----------
    use : str
        Lesson and function: "01:color_labels".
    folder : str or Path, optional
        As in `functions`.

    Returns
    -------
    callable
        The function or class.

    Raises
    ------
    ValueError
        If there is no such lesson or exercise.
    """
    if is_resolved():  # exercises are being declared, without a student's folder
        return stand_in(use, not_usable(use))
    find, like = _finder(notebooks_folder(folder), use)
    try:
        find()
    except EarlierNotUsable as sentence:
        _Missing.show(str(sentence))
        find = not_usable(use, "the set-up cell says why.")  # once, and not again in each later cell
    return stand_in(use, find, like)


class _Missing(Message):
    """The earlier functions that a cell lacks, as one growing list: a box in Jupyter, folded if there are several."""

    # Number, list and display of the running cell
    _cell: tuple[Any, _Missing, Any] | None = None

    @classmethod
    def show(cls, sentence: str) -> None:
        """Add a sentence to the list of the running cell."""
        from IPython import get_ipython  # takes long to import
        from IPython.display import display

        shell = get_ipython()
        number = None if shell is None else (id(shell), shell.execution_count)
        if number is not None and _Missing._cell is not None and _Missing._cell[0] == number:
            _, before, handle = _Missing._cell
            grown = cls(f"{before.text}\n{sentence}")
            handle.update(grown)
        else:
            grown = cls(sentence)
            handle = display(grown, display_id=True) if number is not None else display(grown)
        _Missing._cell = None if handle is None else (number, grown, handle)

    def __repr__(self) -> str:
        """Return the sentences and a note about the recorded answers."""
        what = "them" if "\n" in self.text else "it"
        return f"{self.text} The checks of this lesson have recorded answers for {what}."

    def _repr_html_(self) -> str:
        """Return the box as HTML; several sentences are folded under their number."""
        sentences = self.text.split("\n")
        if len(sentences) == 1:
            return Message(repr(self))._repr_html_()
        items = "".join(f"<li>{escape(each)}</li>" for each in sentences)
        return (
            '<details role="note" style="border-left: 4px solid #888; padding: 0.4em 0.8em; margin: 0.3em 0">'
            f"<summary>{len(sentences)} functions of earlier lessons are not usable yet. The checks of this lesson "
            f"have recorded answers for them.</summary><ul>{items}</ul></details>"
        )


def earlier_in(folder: Path) -> Callable[[str], Any]:
    """Return a function that finds functions of earlier lessons in a folder's notebooks without showing notes."""
    return lambda use: stand_in(use, *_finder(folder, use))


def _finder(folder: Path, use: str) -> tuple[Callable[[], Any], Any]:
    """Return a function that returns an earlier function or raises the reason, and that function, right or not."""
    lesson, exercise = _exercise(use)
    notebook = _read(lesson, notebook_of(lesson, folder.resolve()))
    report, own = _report(exercise, notebook), notebook.found.get(exercise.name)
    return (lambda: own) if report else not_usable(use, " ".join(report.lines)), own


def _exercise(use: str) -> tuple[str, PublicExercise]:
    """Return the lesson's name and the exercise of a use such as "01:color_labels"."""
    number, name = split_use(use)
    found = meant(number, lessons())
    if len(found) != 1:
        raise ValueError(f"{use!r}: there is no lesson {number!r} with checks; choose one of {lessons()}")
    for exercise in read_public(found[0]).exercises:
        if exercise.name == name:
            return found[0], exercise
    raise ValueError(f"{use!r}: lesson {found[0]} has no exercise {name!r}")


def notebooks_folder(folder: str | Path | None = None) -> Path:
    """Return the student's folder of notebooks: `folder`, else $NAO_COURSE_NOTEBOOKS, else the working folder."""
    return Path(folder or os.environ.get("NAO_COURSE_NOTEBOOKS") or ".").resolve()


def own_function(
    use: str, given: Mapping[str, Any], folder: Path, most_seconds: float = np.inf
) -> tuple[Any, str]:
    """Return the student's own function, and an empty text, if it passes its public checks; else None and why not.

    Functions in `given` are used first if they pass their checks, then the saved notebooks in the folder.
    `use` is such as "01:color_labels", and a reason such as "color_labels of lesson 01 is not written yet".
    """
    lesson, exercise = _exercise(use)
    reports = []
    if exercise.name in given:
        reports.append(_quietly_graded(exercise, given[exercise.name], most_seconds))
        if reports[0]:
            return given[exercise.name], ""
    notebook = _read(lesson, notebook_of(lesson, folder), most_seconds)
    reports.append(_report(exercise, notebook, most_seconds))
    if reports[-1]:
        return notebook.found[exercise.name], ""
    if notebook.problem and len(reports) == 1:
        return None, notebook.problem.rstrip(".")
    return None, _lacking(lesson, reports[0])


def _lacking(lesson: str, report: Report) -> str:
    """Return why an exercise does not pass as a clause."""
    state = _NOT_RIGHT.get(report.state, "does not pass its check yet")
    return f"{report.name} of lesson {number_of(lesson)} {state}"


def stored_result(use: str, folder: Path) -> str | None:
    """Return the stored result of an earlier check of the student's function `use`, such as "01:color_labels".

    It says why the function does not pass, is empty if it does, and None if the notebooks were saved after the check.
    """
    lesson, exercise = _exercise(use)
    return verdicts.kept(notebook_of(lesson, folder), exercise.name)


@dataclass(frozen=True)
class _Notebook:
    """The definitions of a lesson's notebook, and why some or all of them are missing."""

    lesson: str
    path: Path
    found: Definitions
    problem: str = ""

    @property
    def failed(self) -> tuple[Skipped, ...]:
        return tuple(each for each in self.found.skipped if each.reason != NO_DEFINITION)

    @property
    def sources(self) -> list[str]:
        return [source for _, source in self.found.text.cells]

    def of_newer_versions(self, errors: Iterable[str]) -> list[str]:
        """Return a sentence about the notebook's newer versions if they may explain one of these errors."""
        newer = newer_than_here({"python": self.found.text.python})
        if not any(map(newer.explains, (*errors, *(each.reason for each in self.failed)))):
            return []
        written = f"This notebook is written in {newer.against('nao-course')}."
        return [f"{written} This may be the only reason: run nao-course in the notebook's version."]


def notebook_of(lesson: str, folder: Path) -> Path:
    """Return the path of a lesson's notebook in a folder; of several copies, the copy that a grader counts."""
    return notebooks_in(folder, [lesson]).get(lesson, [folder / f"{lesson}.ipynb"])[0]


def _read(lesson: str, path: Path, most_seconds: float = np.inf) -> _Notebook:
    seconds = min(SECONDS, most_seconds)
    try:
        times = tuple(each.stat().st_mtime_ns for each in sorted(path.parent.glob("*.ipynb")))
        with alarm(seconds):
            return _Notebook(lesson, path, _definitions(lesson, path, path.stat().st_mtime_ns, times))
    except FileNotFoundError:
        problem = f"{path.name} is not in your folder {path.parent.resolve().name or path.parent.root}."
    except OSError as error:
        problem = f"{path.name} cannot be read: {error.strerror or error}."
    except ValueError as error:  # it names the file
        problem = f"{error}."
    except TimeIsUp:
        why = (
            "is the computer busy, or does a loop outside a function never end?"
            if seconds > SHORT_TIME
            else "run progress(), which allows more time."
        )
        problem = f"{path.name} takes longer than {seconds:g} s: {why}"
    return _Notebook(lesson, path, Definitions({}), problem)


def _report(exercise: PublicExercise, notebook: _Notebook, most_seconds: float = np.inf) -> Report:
    """Return the report of the public checks on an exercise in a notebook."""
    title = f"{exercise.number} {exercise.name}"
    remarks = notebook.found.remarks.get(exercise.name, ())
    if notebook.problem:
        state: CheckState = "raised" if notebook.path.exists() else "not attempted"
        return Report(exercise.name, state, (f"{title}: {notebook.problem}",))
    if exercise.name not in notebook.found:
        cause = why_missing(exercise.name, notebook.failed, notebook.sources)
        reasons = [*filter(None, [cause]), *remarks] or [
            f"Cell {each.cell}: {each.reason}." for each in notebook.failed
        ]
        lines = (
            f"{title}: not found in {notebook.path.name}.",
            *reasons,
            *notebook.of_newer_versions(reasons),
        )
        return Report(exercise.name, "raised" if reasons else "not attempted", lines)
    report = _quietly_graded(exercise, notebook.found[exercise.name], most_seconds)
    report = replace(report, lines=(*report.lines, *remarks))
    if not report:
        more = (*where_reused(report.lines, notebook.sources), *notebook.of_newer_versions(report.lines))
        report = replace(report, lines=(*report.lines, *more))
    is_copy = notebook.path.stem != notebook.lesson
    # A check with more time may give another result.
    if report.state != "interrupted" and not strict() and not is_copy:
        verdicts.keep(notebook.path, exercise.name, "" if report else _lacking(notebook.lesson, report))
    return report


def _quietly_graded(exercise: PublicExercise, function: Any, most_seconds: float) -> Report:
    """Return the report of the public checks on a function, without its printed output."""
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        return grade_public(exercise, function, most_seconds)


@lru_cache(maxsize=32)
def _definitions(lesson: str, path: Path, changed: int, others: tuple[int, ...]) -> Definitions:
    """Return the definitions of a notebook in its saved state, without its printed output."""

    def before_this(use: str) -> Any:
        # Two lessons that use each other would recurse for ever.
        if split_use(use)[0] >= number_of(lesson):
            return stand_in(use, not_usable(use, f"lesson {lesson} comes first."))
        return earlier_in(path.parent)(use)

    if str(path.parent) not in sys.path:  # of the student's own files; behind the library's, as in the grader
        sys.path.append(str(path.parent))
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()), unattended():
        return load_definitions(path, earlier=before_this, released=read_outline(lesson))
