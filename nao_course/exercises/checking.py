"""What a lesson calls: `check`, `hint`, questions and predictions."""

from __future__ import annotations

import os
import sys
import warnings
import zlib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext, redirect_stderr
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from importlib import resources
from typing import Any

import numpy as np

from nao_course.exercises import judging, running
from nao_course.exercises.asking import ask, reply
from nao_course.exercises.codec import Limits, decode, encode
from nao_course.exercises.comparisons.comparison import with_article
from nao_course.exercises.earlier import watching
from nao_course.exercises.exercise import PublicExercise, PublicLesson
from nao_course.exercises.failed_cells import FAILED_CELLS
from nao_course.exercises.judging import AT_FAULT, Report, explain, with_the_reason
from nao_course.exercises.trying import Message, Remarked, explain_unknown_names, show, try_out

_SECONDS_FOR_A_REASON = 2.0  # wall clock of a case of another exercise that is looked at
_DATA = "checks"


class CheckFailed(AssertionError):  # noqa: N818 - it reads as a sentence in a traceback
    """Raised by a check that is not passed, where something must notice: in tests and under nbgrader."""


def read_public(name: str) -> PublicLesson:
    """Read the data of a lesson's checks.

    Parameters
    ----------
    name : str
        Such as "01_hsl_filtering".

    Returns
    -------
    PublicLesson
        Exercises and questions.

    Raises
    ------
    ValueError
        If there is no such lesson.
    """
    there = lessons()
    if name not in there:
        raise ValueError(f"there is no lesson {name!r} with checks; there are {there}")
    return _unpacked((resources.files("nao_course.exercises") / _DATA / f"{name}.bin").read_bytes())


def lessons() -> list[str]:
    """Return the names of all lessons with checks."""
    folder = resources.files("nao_course.exercises") / _DATA
    return sorted(each.name.removesuffix(".bin") for each in folder.iterdir() if each.name.endswith(".bin"))


def pack(lesson: PublicLesson) -> bytes:
    """Turn a lesson's public data into the bytes of its file, the same each time."""
    return zlib.compress(encode(lesson), 9)


def unpack(data: bytes) -> PublicLesson:
    """Turn the bytes of a data file back into a lesson."""
    frame = zlib.decompressobj().decompress(data, 64 * 2**20)
    lesson = decode(frame, Limits(size=64 * 2**20), trusted=True)  # it comes with this package
    if not isinstance(lesson, PublicLesson):
        raise ValueError("not a lesson's check data")
    return lesson


_unpacked = lru_cache(maxsize=32)(unpack)  # `progress` asks for each lesson half a dozen times


def grade_public(exercise: PublicExercise, function: Any, most_seconds: float = np.inf) -> Report:
    """Run an exercise's public cases on a function.

    Parameters
    ----------
    exercise : PublicExercise
        What is asked for.
    function : callable
        What the student wrote.
    most_seconds : float
        Wall clock that a case gets, where that is less than what the exercise gives.

    Returns
    -------
    Report
        What came of it.
    """
    title = f"{exercise.number} {exercise.name}"
    if not (callable(function) or exercise.driver):
        text = (
            f"{title}: a function is wanted, got {with_article(function)}. "
            "Hand over the function itself, without brackets."
        )
        return Report(exercise.name, "wrong", (text,))
    answer = partial(judging.answer, exercise.comparison)
    seconds = min(max(running.SECONDS, 2 * exercise.seconds), most_seconds)
    with watching(exercise.earlier) as calls, _numpy_warnings() as warned:
        outcomes = running.call_all(function, exercise.cases, exercise.driver, seconds, answer)
        report = explain(exercise, outcomes, f"stopped after {seconds:g} seconds")
    remarks = [f"{why} Recorded answers stood in for it." for why in calls.answered.values()]
    if report and warned:
        remarks.append(_said_of_warning(warned[0]))
    return replace(report, lines=(*report.lines, *remarks))


@contextmanager
def _numpy_warnings() -> Iterator[list[warnings.WarningMessage]]:
    """Gather what NumPy warns of, a division by 0 say, and let all other warnings through at the end."""
    warned: list[warnings.WarningMessage] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", RuntimeWarning)
        yield warned
        warned += [each for each in caught if each.category is RuntimeWarning]
    for each in caught:
        if each not in warned:
            warnings.warn_explicit(each.message, each.category, each.filename, each.lineno)


def _said_of_warning(warning: warnings.WarningMessage) -> str:
    return (
        f"One thing: NumPy warns: {warning.message}, in a step of your own code. The answers are right all the same. "
        "Where such a value is thrown away, put something harmless in its place first, a 1 for a divisor of 0, say; "
        "for an angle, np.arctan2 divides nothing."
    )


@dataclass(frozen=True)
class Hint(Message):
    """A hint, which knows whether it was shown: of two asked for in one cell a notebook shows the last only.

    Parameters
    ----------
    text : str
        What to say.
    number : int
        Which of the exercise's hints it is, from 0.
    missed : tuple of Hint
        Those before it that it says, too, for nobody saw them.
    """

    number: int = 0
    missed: tuple[Hint, ...] = ()

    @property
    def shown(self) -> bool:
        """Whether it was, by itself or by a later one."""
        return "_seen" in vars(self)

    def _show(self) -> None:
        for each in (self, *self.missed):
            vars(each)["_seen"] = True

    def __repr__(self) -> str:
        """The text alone; now it is shown."""
        self._show()
        return super().__repr__()

    def _repr_html_(self) -> str:
        self._show()
        return super()._repr_html_()


@dataclass
class Checks:
    """A lesson's `check`: call it with an exercise's name and your function.

    Parameters
    ----------
    lesson : PublicLesson
        What it checks.
    """

    lesson: PublicLesson
    _hints_given: dict[str, list[Hint]] = field(default_factory=dict)

    def __repr__(self) -> str:
        """Say how it is used; what it holds is what it checks with."""
        return f"The checks of {self.lesson.name}: check(name, function)"

    def exercise(self, name: str) -> PublicExercise:
        """Return an exercise by its name.

        Raises
        ------
        ValueError
            If the lesson has none of that name.
        """
        for exercise in self.lesson.exercises:
            if exercise.name == name:
                return exercise
        names = [each.name for each in self.lesson.exercises]
        raise ValueError(f"lesson {self.lesson.name} has no exercise {name!r}; it has {names}")

    def __call__(self, name: str, function: Any) -> Report | Message | None:
        """Check what you wrote.

        Parameters
        ----------
        name : str
            Of the exercise.
        function : callable
            Your function.

        Returns
        -------
        Report
            Shown below the cell. Nothing under nbgrader, where it has been shown already: a cell's value is read as
            points there, and whatever a right answer writes to stderr, such as a warning, makes them 0.

        Raises
        ------
        CheckFailed
            If it is not right, and NBGRADER_EXECUTION or NAO_COURSE_STRICT is set.
        """
        with redirect_stderr(sys.stdout) if _under_nbgrader() else nullcontext():
            report = self._said(name, function)
        if strict() and not (isinstance(report, Report) and report):
            raise CheckFailed(repr(report))
        if _under_nbgrader():
            show(report)
            return None
        return report

    def _said(self, name: str, function: Any) -> Report | Message:
        try:
            return _unless_old(self._report(self.exercise(name), function))
        except ValueError as error:
            return Message(str(error))

    def _report(self, exercise: PublicExercise, function: Any) -> Report:
        report = grade_public(exercise, function)
        if report.state not in AT_FAULT:
            return report
        beside = _defined_beside(function)
        others = {
            each.name: grade_public(each, beside[each.name], _SECONDS_FOR_A_REASON)
            for each in self.lesson.exercises
            if each.name in exercise.uses and each.name in beside
        }
        return with_the_reason(exercise, report, others)

    def hint(self, name: str) -> Message:
        """Give an exercise's first hint, and the second when asked again; one that was never shown stands before it."""
        try:
            hints = self.exercise(name).hints
        except ValueError as error:
            return Message(str(error))
        given = self._hints_given.setdefault(name, [])
        number = min(len(given), len(hints) - 1)
        missed = tuple(each for each in given if each.number < number and not each.shown)
        said = [
            f"Hint {each + 1} of {len(hints)}: {hints[each]}"
            for each in (*(m.number for m in missed), number)
        ]
        more = "Ask again for the next one." if number + 1 < len(hints) else "There is no further one."
        given.append(Hint(" ".join([*said, more]), number, missed))
        return given[-1]

    def question(self, name: str, answer: str | None = None) -> Any:
        """Ask a concept question.

        Parameters
        ----------
        name : str
            Of the question.
        answer : str, optional
            One of its choices, or the number of one from 1: for where no buttons can live.

        Returns
        -------
        object
            Buttons, or the reply to an answer.
        """
        for question in self.lesson.questions:
            if question.name == name:
                return ask(question) if answer is None else reply(question, str(answer))
        return Message(
            f"there is no question {name!r}; there are {[each.name for each in self.lesson.questions]}"
        )

    def payoff(self, draw: Callable[..., object], **functions: Any) -> object:
        """Draw a lesson's figure with what you wrote; where something is missing, say which exercises.

        Parameters
        ----------
        draw : callable
            Takes the functions by their names.
        **functions : callable
            Yours, by the names of their exercises.

        Returns
        -------
        object
            What `draw` returned, below a remark where a function that it was drawn with is not right; or a `Message`.
        """
        shown = try_out(partial(draw, **functions))
        for name in functions:
            self.exercise(name)  # a name that the lesson has not is an error
        exercises = [each for each in self.lesson.exercises if each.name in functions]
        missing = [each.number for each in exercises if not grade_public(each, functions[each.name])]
        if not missing:
            return shown
        some, does = ("exercise", "does") if len(missing) == 1 else ("exercises", "do")
        which = f"your {some} {', '.join(missing)}"
        if isinstance(shown, Message):
            return Message(f"This figure needs {which}: write and check first, then run this.")
        return Remarked(f"This is drawn with {which}, which {does} not pass the public checks.", shown)


def _unless_old(report: Report) -> Report:
    """Say instead of a report that the cell above did not run, where the function is an older one."""
    if not (why := FAILED_CELLS.why_old(report.name)):
        return report
    old = "What is checked here would be an older version. Mend that cell, run it, then check again."
    return Report(report.name, "not checked", (why, old))


def _defined_beside(function: Any) -> Mapping[str, Any]:
    """What is defined in the notebook in which a function, or class, is."""
    module = sys.modules.get(str(getattr(function, "__module__", "")))
    found = getattr(function, "__globals__", None) or vars(module or object)
    return found if isinstance(found, Mapping) else {}


def strict() -> bool:
    """Whether a check that is not passed must raise: under nbgrader, and in tests."""
    return _under_nbgrader() or bool(os.environ.get("NAO_COURSE_STRICT"))


def _under_nbgrader() -> bool:
    return bool(os.environ.get("NBGRADER_EXECUTION"))


def lesson(name: str) -> tuple[Checks, Callable[[str], Message]]:
    """Return a lesson's `check` and `hint`.

    Parameters
    ----------
    name : str
        Such as "01_hsl_filtering".

    Returns
    -------
    check : Checks
        ``check("rgb_to_hsl", rgb_to_hsl)``.
    hint : callable
        ``hint("rgb_to_hsl")``.

    Raises
    ------
    ValueError
        If there is no such lesson.
    """
    explain_unknown_names()
    FAILED_CELLS.watch()
    checks = Checks(read_public(name))
    return checks, checks.hint
