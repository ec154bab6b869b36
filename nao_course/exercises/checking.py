"""What a lesson calls: `check`, `hint`, questions and predictions."""

from __future__ import annotations

import os
import re
import sys
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from html import escape
from importlib import resources
from typing import Any, Literal

import numpy as np

from nao_course.exercises import judging, running
from nao_course.exercises.asking import ask, reply
from nao_course.exercises.case import Case
from nao_course.exercises.codec import Limits, decode, encode
from nao_course.exercises.comparisons.comparison import Verdict
from nao_course.exercises.earlier import EarlierNotUsable, watching
from nao_course.exercises.exercise import PublicExercise, PublicLesson
from nao_course.exercises.running import Outcome
from nao_course.exercises.trying import Message, advice_on, explain_unknown_names, try_out

CheckState = Literal["right", "not attempted", "not checked", "wrong", "raised", "interrupted"]
_COLOURS = {
    "right": "#1a7f37",
    "not attempted": "#6e7781",
    "not checked": "#6e7781",
    "wrong": "#9a6700",
    "raised": "#9a6700",
    "interrupted": "#6e7781",
}
_WRONG = {
    "nothing": "Nothing came back",
    "type": "Wrong kind of answer",
    "shape": "Wrong shape",
    "nan": "Not a number",
    "value": "Wrong value",
    "law": "Not as it has to be",
    "no error": "No exception",
}
_SIGNS = {
    "right": "✔",
    "not attempted": "○",
    "not checked": "○",
    "wrong": "✘",
    "raised": "✘",
    "interrupted": "■",
}
_AT_FAULT = ("wrong", "raised", "interrupted")  # states of an exercise that somebody has begun
_SECONDS_FOR_A_REASON = 2.0  # wall clock of a case of another exercise that is looked at
_DATA = "checks"


class CheckFailed(AssertionError):  # noqa: N818 - it reads as a sentence in a traceback
    """Raised by a check that is not passed, where something must notice: in tests and under nbgrader."""


@dataclass(frozen=True)
class Report:
    """What a check found; shown by being a cell's last line.

    Parameters
    ----------
    name : str
        Of the exercise.
    state : str
        right, not attempted, not checked (by what an earlier lesson lacks), wrong, raised or interrupted.
    lines : tuple of str
        What to say, the most important first.
    """

    name: str
    state: CheckState
    lines: tuple[str, ...]

    def __bool__(self) -> bool:
        """Whether the exercise is right, as far as the public checks can tell."""
        return self.state == "right"

    def __repr__(self) -> str:
        """Return the lines as text."""
        return "\n".join((f"{_SIGNS[self.state]} {self.lines[0]}", *(f"  {line}" for line in self.lines[1:])))

    def _repr_html_(self) -> str:
        """Return the lines in a box whose colour is also said by a sign."""
        first, *rest = (escape(line) for line in self.lines)
        colour = _COLOURS[self.state]
        body = "".join(f"<div>{line}</div>" for line in rest)
        return (
            f'<div role="status" data-check="{escape(self.name)}" data-state="{self.state}" '
            f'style="border-left: 4px solid {colour}; padding: 0.4em 0.8em; margin: 0.3em 0">'
            f'<div><strong style="color: {colour}">{_SIGNS[self.state]} {first}</strong></div>{body}</div>'
        )


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
    return unpack((resources.files("nao_course.exercises") / _DATA / f"{name}.bin").read_bytes())


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
        kind = type(function).__name__
        text = (
            f"{title}: a function is wanted, got a {kind}. Hand over the function itself, without brackets."
        )
        return Report(exercise.name, "wrong", (text,))
    answer = partial(judging.answer, exercise.comparison)
    seconds = min(max(running.SECONDS, 2 * exercise.seconds), most_seconds)
    with watching(exercise.earlier) as calls:
        outcomes = running.call_all(function, exercise.cases, exercise.driver, seconds, answer)
        report = explain(exercise, outcomes, f"stopped after {seconds:g} seconds")
    stood_in = [f"{why} Recorded answers stood in for it." for why in calls.answered.values()]
    return replace(report, lines=(*report.lines, *stood_in))


def with_the_reason(exercise: PublicExercise, report: Report, others: Mapping[str, Report]) -> Report:
    """Say of an exercise that is not right which exercise of the same lesson, one that it uses, is wrong itself.

    Parameters
    ----------
    exercise : PublicExercise
        Whose report it is.
    report : Report
        What its check found.
    others : mapping of str to Report
        What the checks of other exercises of the lesson found, by name, in the lesson's order.
    """
    if report.state not in _AT_FAULT:
        return report
    wrong = [name for name, other in others.items() if name in exercise.uses and other.state in _AT_FAULT]
    lines = [f"It uses {name}, which does not pass its own check: begin with that one." for name in wrong[:1]]
    return replace(report, lines=(*report.lines, *lines))


def explain(exercise: PublicExercise, outcomes: Sequence[Outcome], stopped: str) -> Report:
    """Say what an exercise's public cases came to.

    Parameters
    ----------
    exercise : PublicExercise
        What is asked for.
    outcomes : sequence of Outcome
        One for each case; fewer where the last one ended it all: not attempted, out of time or a dead process.
    stopped : str
        How a function that takes too long was stopped.

    Returns
    -------
    Report
        For the student.
    """
    title = f"{exercise.number} {exercise.name}"
    last = outcomes[-1]
    if last.status == "not attempted":
        return Report(exercise.name, "not attempted", (f"{title}: not written yet.",))
    if last.status == "not found":
        return Report(exercise.name, "not attempted", (f"{title}: your notebook does not define it.",))
    if last.status == "died":
        return Report(exercise.name, "raised", (f"{title}: it ends Python itself; {last.text}.",))
    if last.status in ("interrupted", "timed out"):
        how = "stopped by you" if last.status == "interrupted" else stopped
        text = f"{title}: {how}. Does it have a loop that never ends?"
        return Report(exercise.name, "interrupted", (text,))
    verdicts = [
        judging.judge(exercise.comparison, case, outcome)
        for case, outcome in zip(exercise.cases, outcomes, strict=True)
    ]
    wrong = [i for i, verdict in enumerate(verdicts) if not verdict]
    changed = any(outcome.changed for outcome in outcomes)
    if not wrong and not (changed and exercise.in_place):
        lines = [
            f"{title}: {_passed(len(verdicts), len(verdicts))}.",
            "The grader has others, with other inputs.",
        ]
        if changed:
            lines.append("One thing: your function changes its input. Return a new array instead.")
        return Report(exercise.name, "right", tuple(lines))
    if not wrong:
        text = f"{title}: right answers, but the function changes its input. Return a new array instead."
        return Report(exercise.name, "wrong", (text, *_recognised(exercise, outcomes, wrong)))
    return _explain(exercise, title, outcomes, verdicts, wrong)


def _explain(
    exercise: PublicExercise,
    title: str,
    outcomes: Sequence[Outcome],
    verdicts: list[Verdict | None],
    wrong: list[int],
) -> Report:
    """Tell about the first case that is wrong, and the mistake that all of them look like."""
    first = wrong[0]
    outcome, verdict = outcomes[first], verdicts[first]
    about = f" ({exercise.cases[first].name})" if exercise.cases[first].name else ""
    passed = _passed(len(verdicts) - len(wrong), len(verdicts))
    state: CheckState = "wrong"
    if verdict is not None:
        lines = [f"{title}: {passed}. {_WRONG[verdict.kind]}{about}: {verdict.text}."]
        lines += _input_at(exercise.cases[first], verdict)
    elif outcome.status == "unsendable":
        lines = [f"{title}: {passed}. {_WRONG['type']}{about}: {outcome.text}."]
    elif outcome.text.startswith(f"{EarlierNotUsable.__name__}: "):
        state, lines = "not checked", [f"{title}: {passed}. {outcome.text.partition(': ')[2]}"]
    else:
        state, lines = "raised", [f"{title}: {passed}; {_raises(outcome.text)}{about}."]
        lines += [outcome.line] if outcome.line else []
        lines += [f"Here {wanted} has to be raised."] if (wanted := exercise.cases[first].raises) else []
        lines += advice_on(outcome.text)
        if re.search(rf"[ .](?:{exercise.name}(?:\.\w+)?|<lambda>)\(\) .*positional argument", outcome.text):
            lines.append(
                "Keep the function's first line as it was given: the check calls it with those arguments."
            )
    return Report(exercise.name, state, (*lines, *_recognised(exercise, outcomes, wrong)))


def _raises(text: str) -> str:
    """What a case raises; a part that is still blank by its name."""
    unwritten = re.fullmatch(r"NotImplementedError: ([\w.]+ is not written yet)", text)
    return unwritten[1] if unwritten else f"one raises {text}"


def _input_at(case: Case, verdict: Verdict) -> list[str]:
    """Show the element of the first argument that the first wrong element of the answer was made from."""
    given = case.args[0] if case.args else None
    place = len(verdict.at)
    if not isinstance(given, np.ndarray) or not place or given.ndim not in (place, place + 1):
        return []
    if (
        any(index >= size for index, size in zip(verdict.at, given.shape, strict=False))
        or given[verdict.at].size > 4
    ):
        return []
    return [f"There the input is {' '.join(f'{float(value):g}' for value in given[verdict.at].ravel())}."]


def _passed(right: int, checks: int) -> str:
    if right == checks:
        return f"all {checks} public checks pass" if checks > 1 else "the public check passes"
    return f"{right} of {checks} public checks pass" if checks > 1 else "the public check does not pass"


def _recognised(exercise: PublicExercise, outcomes: Sequence[Outcome], wrong: list[int]) -> list[str]:
    """The message of the first mistake that gives all the wrong answers and no others."""
    for mistake in exercise.mistakes:
        if sorted(map(int, mistake.answers)) == wrong and all(
            _same(exercise, mistake.answers[str(i)], outcomes[i]) for i in wrong
        ):
            return [mistake.message]
    return []


def _same(exercise: PublicExercise, answer: Any, outcome: Outcome) -> bool:
    """Whether an outcome is a mistake's; where that raises or gives no answer, `answer` says {"raises": what}."""
    if isinstance(answer, dict) and set(answer) == {"raises"}:
        return outcome.status != "value" and outcome.text.split(":")[0] == answer["raises"]
    return outcome.status == "value" and exercise.comparison.alike(answer, outcome.value)


@dataclass
class Checks:
    """A lesson's `check`: call it with an exercise's name and your function.

    Parameters
    ----------
    lesson : PublicLesson
        What it checks.
    """

    lesson: PublicLesson
    _hints_given: dict[str, int] = field(default_factory=dict)

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

    def __call__(self, name: str, function: Any) -> Report | Message:
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
            Shown below the cell.

        Raises
        ------
        CheckFailed
            If it is not right, and NBGRADER_EXECUTION or NAO_COURSE_STRICT is set.
        """
        try:
            report: Report | Message = self._report(self.exercise(name), function)
        except ValueError as error:
            report = Message(str(error))
        if strict() and not (isinstance(report, Report) and report):
            raise CheckFailed(repr(report))
        return report

    def _report(self, exercise: PublicExercise, function: Any) -> Report:
        report = grade_public(exercise, function)
        if report.state not in _AT_FAULT:
            return report
        beside = _defined_beside(function)
        others = {
            each.name: grade_public(each, beside[each.name], _SECONDS_FOR_A_REASON)
            for each in self.lesson.exercises
            if each.name in exercise.uses and each.name in beside
        }
        return with_the_reason(exercise, report, others)

    def hint(self, name: str) -> Message:
        """Give an exercise's first hint, and the second when asked again."""
        try:
            hints = self.exercise(name).hints
        except ValueError as error:
            return Message(str(error))
        given = self._hints_given.get(name, 0)
        self._hints_given[name] = given + 1
        number = min(given, len(hints) - 1)
        more = " Ask again for the next one." if number + 1 < len(hints) else " There is no further one."
        return Message(f"Hint {number + 1} of {len(hints)}: {hints[number]}{more}")

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
            What `draw` returned, or a `Message`.
        """
        shown = try_out(partial(draw, **functions))
        if not isinstance(shown, Message):
            return shown
        exercises = [self.exercise(name) for name in functions]
        missing = [each.number for each in exercises if not grade_public(each, functions[each.name])]
        if not missing:
            return shown
        some = "exercise" if len(missing) == 1 else "exercises"
        return Message(
            f"This figure needs your {some} {', '.join(missing)}: write and check first, then run this."
        )


def _defined_beside(function: Any) -> Mapping[str, Any]:
    """What is defined in the notebook in which a function, or class, is."""
    module = sys.modules.get(str(getattr(function, "__module__", "")))
    found = getattr(function, "__globals__", None) or vars(module or object)
    return found if isinstance(found, Mapping) else {}


def strict() -> bool:
    """Whether a check that is not passed must raise: under nbgrader, and in tests."""
    return bool(os.environ.get("NBGRADER_EXECUTION") or os.environ.get("NAO_COURSE_STRICT"))


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
    checks = Checks(read_public(name))
    return checks, checks.hint
