"""The functions that a lesson calls: `check`, `hint`, questions and predictions."""

from __future__ import annotations

import dis
import inspect
import sys
import warnings
import zlib
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, redirect_stderr
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, partial
from html import escape
from importlib import resources
from textwrap import indent
from types import CodeType
from typing import Any

import numpy as np

from nao_course.codec import Limits, decode, encode
from nao_course.exercises import judging, running
from nao_course.exercises.asking import ask, reply
from nao_course.exercises.comparisons.comparison import with_article
from nao_course.exercises.earlier import Calls, split_use, watching
from nao_course.exercises.exercise import PublicExercise, PublicLesson, Sibling
from nao_course.exercises.failed_cells import FAILED_CELLS
from nao_course.exercises.judging import AT_FAULT, Report, explain, with_the_reason
from nao_course.exercises.lesson_names import number_of
from nao_course.exercises.trying import (
    Message,
    Remarked,
    explain_unknown_names,
    show,
    strict,
    try_out,
    under_nbgrader,
)

_SECONDS_FOR_A_REASON = 2.0  # wall clock for a case of another exercise that the report mentions
_DATA = "checks"
_WHEN_NEEDED = ("cases", "mistakes", "pairs", "earlier")  # of an exercise: most of a lesson's data


class CheckFailed(AssertionError):  # noqa: N818 - it reads as a sentence in a traceback
    """Raised by a failed check in tests and under nbgrader."""


def read_public(name: str) -> PublicLesson:
    """Read the checks' data of a lesson such as "01_hsl_filtering"; raise a ValueError if there is no such lesson."""
    there = lessons()
    if name not in there:
        raise ValueError(f"there is no lesson {name!r} with checks; choose one of {there}")
    return _read(name, zlib.crc32(_data(name)))


def _data(name: str) -> bytes:
    """Return the bytes of a lesson's file."""
    return (resources.files("nao_course.exercises") / _DATA / f"{name}.bin").read_bytes()


@lru_cache(maxsize=32)  # `progress` calls it several times for each lesson
def _read(name: str, checksum: int) -> PublicLesson:
    """Read a lesson's data; what only a check needs is decoded when a check needs it."""
    lesson, parts = _opened(_data(name))
    return _with_parts(lesson, parts, _WhenNeeded)


def lessons() -> list[str]:
    """Return the names of all lessons with checks."""
    folder = resources.files("nao_course.exercises") / _DATA
    return sorted(each.name.removesuffix(".bin") for each in folder.iterdir() if each.name.endswith(".bin"))


def pack(lesson: PublicLesson) -> bytes:
    """Encode a lesson's public data as the bytes of its file, which holds the large parts of each exercise apart."""
    parts = [{name: _packed(list(getattr(each, name))) for name in _WHEN_NEEDED} for each in lesson.exercises]
    return _packed([_with_parts(lesson, parts, lambda _: []), parts])


def unpack(data: bytes) -> PublicLesson:
    """Decode a lesson's public data from the bytes of its file."""
    return _with_parts(*_opened(data), _value)


def _opened(data: bytes) -> tuple[PublicLesson, list[dict[str, bytes]]]:
    """Return a lesson without the large parts of its exercises, and these parts by their names, packed."""
    match _value(data):
        case [PublicLesson() as lesson, parts]:
            return lesson, parts
    raise ValueError("not a lesson's check data")


def _with_parts(
    lesson: PublicLesson, parts: list[dict[str, bytes]], read: Callable[[bytes], Any]
) -> PublicLesson:
    """Return a lesson whose exercises have the large parts that `read` makes of their bytes."""
    exercises = [
        replace(each, **{name: read(packed) for name, packed in own.items()})
        for each, own in zip(lesson.exercises, parts, strict=True)
    ]
    return replace(lesson, exercises=exercises)


def _packed(value: Any) -> bytes:
    return zlib.compress(encode(value), 9)


def _value(packed: bytes) -> Any:
    frame = zlib.decompressobj().decompress(packed, 64 * 2**20)
    # The file is part of this package.
    return decode(frame, Limits(size=64 * 2**20), trusted=True)


class _WhenNeeded(Sequence[Any]):
    """A list that is decoded when it is first used, and kept from then on."""

    def __init__(self, packed: bytes) -> None:
        self._packed = packed

    @cached_property
    def _values(self) -> list[Any]:
        return list(_value(self._packed))

    def __len__(self) -> int:
        return len(self._values)

    def __getitem__(self, index: Any) -> Any:
        return self._values[index]


def grade_public(exercise: PublicExercise, function: Any, most_seconds: float = np.inf) -> Report:
    """Run an exercise's public cases on a function.

    `most_seconds` limits a case, if it is shorter than the exercise's own limit.
    """
    title = f"{exercise.number} {exercise.name}"
    if not (callable(function) or exercise.driver):
        text = (
            f"{title}: expected a function, got {with_article(function)}. "
            "Pass the function itself, without brackets."
        )
        return Report(exercise.name, "wrong", (text,))
    seconds = min(max(running.SECONDS, 2 * exercise.seconds), most_seconds)
    report, calls = _run(exercise, function, seconds)
    not_right = report.state in ("wrong", "raised", "not checked")
    # One of the student's own functions of earlier lessons may be the cause.
    if not_right and (reasons := judging.differing(exercise, calls.called, _exercise_of)):
        report, calls = _run(exercise, function, seconds, replaced=reasons)
        place = "its place" if len(reasons) == 1 else "their places"
        used = f"The reference's answers were used in {place}."
        report = replace(report, lines=(*report.lines, *reasons.values(), used))
    remarks = [_said_of_recorded(calls.answered)] if calls.answered else []
    return replace(report, lines=(*report.lines, *remarks))


def _run(
    exercise: PublicExercise, function: Any, seconds: float, replaced: Collection[str] = ()
) -> tuple[Report, Calls]:
    """Run the public cases, with the reference's answers in the place of some earlier functions."""
    answer = partial(judging.answer, exercise.comparison)
    with watching(exercise.earlier, replaced=replaced) as calls, _numpy_warnings() as warned:
        outcomes = running.call_all(function, exercise.cases, exercise.driver, seconds, answer)
        report = explain(exercise, outcomes, f"stopped after {seconds:g} seconds")
    if report and warned:
        report = replace(report, lines=(*report.lines, _said_of_warning(warned[0])))
    return report, calls


def _exercise_of(use: str) -> PublicExercise | None:
    """Return the exercise of a use such as "07:warp2pi"; None if this course has none."""
    number, name = split_use(use)
    found = [each for each in lessons() if number_of(each) == number]
    return next(
        (each for lesson in found for each in read_public(lesson).exercises if each.name == name), None
    )


@contextmanager
def _numpy_warnings() -> Iterator[list[warnings.WarningMessage]]:
    """Collect NumPy's warnings, such as a division by 0, and issue all other warnings at the end."""
    warned: list[warnings.WarningMessage] = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", RuntimeWarning)
        yield warned
        warned += [each for each in caught if each.category is RuntimeWarning]
    for each in caught:
        if each not in warned:
            warnings.warn_explicit(each.message, each.category, each.filename, each.lineno)


def _said_of_recorded(answered: Mapping[str, str]) -> str:
    """Say which functions of earlier lessons were not usable; the set-up cell gives the reason of each."""
    reason, *others = answered.values()
    if others:
        names = ", ".join(f"{name} ({lesson})" for lesson, name in map(split_use, answered))
        reason = f"These functions of earlier lessons are not usable yet: {names}."
    return f"{reason} Recorded answers were used instead."


def _said_of_warning(warning: warnings.WarningMessage) -> str:
    return (
        f"Your answers are right, but NumPy warns about a step of your code: {warning.message}. "
        "If you discard such values later, replace them first, for example a divisor of 0 by 1. "
        "For an angle, use np.arctan2, which does not divide."
    )


@dataclass(frozen=True)
class Hint(Message):
    """A hint that records whether it was shown, because a notebook shows only the last value of a cell.

    `number` counts from 0, and `missed` are earlier hints that were not shown, which are shown together with this hint.
    A `sibling`'s code and output are shown below the text.
    """

    number: int = 0
    missed: tuple[Hint, ...] = ()
    sibling: Sibling | None = None

    @property
    def shown(self) -> bool:
        """Whether the hint was shown, by itself or together with a later hint."""
        return "_seen" in vars(self)

    def _show(self) -> None:
        for each in (self, *self.missed):
            vars(each)["_seen"] = True

    def __repr__(self) -> str:
        """Return the text, with the code and its output below it, and mark the hint as shown."""
        self._show()
        return "\n\n".join([super().__repr__(), *self._blocks()])

    def _repr_html_(self) -> str:
        self._show()
        below = (f'<pre style="margin: 0.3em 1em">{escape(each)}</pre>' for each in self._blocks())
        return f"<div>{super()._repr_html_()}{''.join(below)}</div>"

    def _blocks(self) -> Iterator[str]:
        """Yield the sibling's code, and its output as comments so that both can be copied into a cell."""
        if self.sibling:
            code, output = self.sibling.blocks
            yield code
            yield indent(f"It prints:\n{output}", "# ")


@dataclass
class Checks:
    """The checks of a lesson; call them with an exercise's name and your function.

    Parameters
    ----------
    lesson : PublicLesson
        The lesson.
    """

    lesson: PublicLesson
    _hints_given: dict[str, list[Hint]] = field(default_factory=dict)

    def __repr__(self) -> str:
        """Return how to use it, without the expected answers."""
        return f"The checks of {self.lesson.name}: check(name, function)"

    def exercise(self, name: str) -> PublicExercise:
        """Return an exercise by its name.

        Raises
        ------
        ValueError
            If the lesson has no exercise of that name.
        """
        for exercise in self.lesson.exercises:
            if exercise.name == name:
                return exercise
        names = [each.name for each in self.lesson.exercises]
        raise ValueError(f"lesson {self.lesson.name} has no exercise {name!r}; it has {names}")

    def __call__(self, name: str, function: Any) -> Report | Message | None:
        """Check your function and return a report, which is shown below the cell.

        The report is None under nbgrader, after it was shown: nbgrader reads a cell's value as points, and any output
        on stderr, such as a warning, makes them 0. If NBGRADER_EXECUTION or NAO_COURSE_STRICT is set, a wrong function
        raises CheckFailed.
        """
        with redirect_stderr(sys.stdout) if under_nbgrader() else nullcontext():
            report = self._report_on(name, function)
        if strict() and not (isinstance(report, Report) and report):
            raise CheckFailed(repr(report))
        if under_nbgrader():
            show(report)
            return None
        return report

    def _report_on(self, name: str, function: Any) -> Report | Message:
        try:
            return _unless_old(self._report(self.exercise(name), function))
        except ValueError as error:
            return Message(str(error))

    def _report(self, exercise: PublicExercise, function: Any) -> Report:
        report = grade_public(exercise, function)
        beside = _defined_beside(function)
        if report.state == "right" and (names := self._only_in_the_notebook(function, beside)):
            return Report(report.name, report.state, (*report.lines, _DEFINE_INSIDE.format(", ".join(names))))
        if report.state not in AT_FAULT:
            return report
        used = _names_used(function, beside)
        others = {
            each.name: grade_public(each, beside[each.name], _SECONDS_FOR_A_REASON)
            for each in self.lesson.exercises
            if each.name in exercise.uses and each.name in beside and each.name in used
        }
        return with_the_reason(exercise, report, others)

    def _only_in_the_notebook(self, function: Any, beside: Mapping[str, Any]) -> list[str]:
        """Return the values that a function uses and only the lesson's demonstrations define."""
        return [
            name for name in _global_names(function) if name in self.lesson.demonstrated and name in beside
        ]

    def hint(self, name: str) -> Message:
        """Return an exercise's first hint, and the next one at each call; a hint that was not shown is repeated.

        The third hint is a solved problem with the same idea, if the exercise has one.
        """
        try:
            exercise = self.exercise(name)
        except ValueError as error:
            return Message(str(error))
        hints = [f": {each}" for each in exercise.hints]
        if exercise.sibling:
            hints.append(f", a solved problem: {exercise.sibling.alike}")
        given = self._hints_given.setdefault(name, [])
        number = min(len(given), len(hints) - 1)
        missed = tuple(each for each in given if each.number < number and not each.shown)
        said = [
            f"Hint {each + 1} of {len(hints)}{hints[each]}" for each in (*(m.number for m in missed), number)
        ]
        is_last = number + 1 == len(hints)
        more = _LAST_HINT if is_last else "Call hint again for the next hint."
        given.append(Hint(" ".join([*said, more]), number, missed, exercise.sibling if is_last else None))
        return given[-1]

    def question(self, name: str, answer: str | None = None) -> Any:
        """Ask a concept question.

        Parameters
        ----------
        name : str
            Name of the question.
        answer : str, optional
            One of its choices, or the number of a choice from 1, for places without widgets.

        Returns
        -------
        object
            Buttons, or the reply to the answer.
        """
        for question in self.lesson.questions:
            if question.name == name:
                return ask(question) if answer is None else reply(question, str(answer))
        return Message(
            f"there is no question {name!r}; there are {[each.name for each in self.lesson.questions]}"
        )

    def payoff(self, draw: Callable[..., object], **functions: Any) -> object:
        """Draw a lesson's figure with your functions, or list the exercises that are missing.

        Parameters
        ----------
        draw : callable
            Function that draws the figure; it receives the functions as keyword arguments.
        **functions : callable
            Your functions, by the names of their exercises.

        Returns
        -------
        object
            The result of `draw`, with a remark above it if one of the functions is wrong; or a `Message`.
        """
        shown = try_out(partial(draw, **functions))
        for name in functions:
            self.exercise(name)  # a name that is not in the lesson is an error
        exercises = [each for each in self.lesson.exercises if each.name in functions]
        states = {each.number: grade_public(each, functions[each.name]).state for each in exercises}
        unwritten = [number for number, state in states.items() if state == "not attempted"]
        wrong = [number for number, state in states.items() if state not in ("not attempted", "right")]
        if not unwritten and not wrong:
            return shown
        if not isinstance(shown, Message):
            used, fail = _listed([*unwritten, *wrong], "does not pass", "do not pass")
            return Remarked(f"This is drawn with your {used}, which {fail} the public checks.", shown)
        if unwritten:
            needed, still = _listed([each for each, state in states.items() if state != "right"], "is", "are")
            how = "finished" if wrong else "written"
            return Message(f"This figure needs your {needed}, which {still} not {how} yet.")
        needed, fail = _listed(wrong, "does not pass", "do not pass")
        why = f"Correct your code and run this cell again. The error was: {shown.text}"
        return Message(f"This figure needs your {needed}, which {fail} the public checks. {why}")


_LAST_HINT = (
    "This is the last hint. If it is not enough, read the text above the exercise once more, or ask your teacher or a "
    "classmate."
)


def _listed(numbers: Sequence[str], one: str, several: str) -> tuple[str, str]:
    """Return the exercises with these numbers in words, and the verb that fits their number."""
    if len(numbers) == 1:
        return f"exercise {numbers[0]}", one
    return f"exercises {', '.join(numbers)}", several


def _unless_old(report: Report) -> Report:
    """Return a note that the cell above did not run if the function is an older version, else the report."""
    if not (why := FAILED_CELLS.why_old(report.name)):
        return report
    old = "This check would use an older version. Correct that cell, run it, then check again."
    return Report(report.name, "not checked", (why, old))


def _defined_beside(function: Any) -> Mapping[str, Any]:
    """Return the names that are defined in the notebook that defines a function or class."""
    module = sys.modules.get(str(getattr(function, "__module__", "")))
    found = getattr(function, "__globals__", None) or vars(module or object)
    return found if isinstance(found, Mapping) else {}


_DEFINE_INSIDE = (
    "However, your function uses names that the lesson's set-up or demonstrations define: {}. The grader does not run "
    "these cells, so define them inside the function or in a cell of your own."
)


def _global_names(function: Any) -> list[str]:
    """Return the global names that a function uses, also in functions within it; any other object uses none."""
    code = getattr(function, "__code__", None)
    return list(dict.fromkeys(_loaded([code] if isinstance(code, CodeType) else [])))


def _names_used(function: Any, beside: Mapping[str, Any]) -> set[str]:
    """Return the global names that a function or class uses, also through functions of `beside`."""
    found: set[str] = set()
    waiting = [function]
    while waiting:
        each = waiting.pop()
        parts = [each, *vars(each).values()] if isinstance(each, type) else [each]
        new = {name for part in parts for name in _global_names(inspect.unwrap(part))} - found
        found |= new
        waiting += [beside[name] for name in new if name in beside]
    return found


def _loaded(codes: Iterable[CodeType]) -> Iterator[str]:
    for code in codes:
        for step in dis.get_instructions(code):
            if step.opname in ("LOAD_GLOBAL", "LOAD_NAME"):
                yield step.argval
        yield from _loaded(each for each in code.co_consts if isinstance(each, CodeType))


def lesson(name: str) -> tuple[Checks, Callable[[str], Message]]:
    """Return a lesson's `check` and `hint`.

    Parameters
    ----------
    name : str
        Name of the lesson, such as "01_hsl_filtering".

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
