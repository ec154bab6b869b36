"""The report of a check: the first wrong case, and the known mistake that gives these answers."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from nao_course.exercises.case import Case
from nao_course.exercises.comparisons.comparison import Verdict
from nao_course.exercises.earlier import EarlierNotUsable
from nao_course.exercises.exercise import Exercise, PublicExercise
from nao_course.exercises.interactive import InteractiveCall, remark_on
from nao_course.exercises.judging.cases import judge
from nao_course.exercises.running import Outcome
from nao_course.exercises.trying import advice_on

CheckState = Literal["right", "not attempted", "not checked", "wrong", "raised", "interrupted"]
_COLOURS = {
    "right": "var(--nao-right, #1a7f37)",
    "not attempted": "var(--nao-open, #6e7781)",
    "not checked": "var(--nao-open, #6e7781)",
    "wrong": "var(--nao-wrong, #9a6700)",
    "raised": "var(--nao-wrong, #9a6700)",
    "interrupted": "var(--nao-open, #6e7781)",
}
_WRONG = {
    "nothing": "Nothing came back",
    "type": "Wrong kind of answer",
    "shape": "Wrong shape",
    "nan": "Not a number",
    "value": "Wrong value",
    "law": "Not as required",
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
TWO_ERRORS = "Your function seems to have two errors."
ENDS_PYTHON = "it ends Python itself"
_ENDED_BY_THE_GRADER = ("it called", "its answer")  # the beginnings of the reasons
SMALL = 9  # numbers: an array of at most this size is a pose, a point or a covariance, not a picture
AT_FAULT = ("wrong", "raised", "interrupted")  # states of an exercise that a student has begun


@dataclass(frozen=True)
class Report:
    """The result of a check; a notebook shows it if it is a cell's last line.

    Parameters
    ----------
    name : str
        Name of the exercise.
    state : str
        right, not attempted, not checked (an earlier lesson is not usable), wrong, raised or interrupted.
    lines : tuple of str
        The sentences of the report, the most important first.
    """

    name: str
    state: CheckState
    lines: tuple[str, ...]

    def __bool__(self) -> bool:
        """Return whether all public checks pass."""
        return self.state == "right"

    def __repr__(self) -> str:
        """Return the lines as text."""
        return "\n".join((f"{_SIGNS[self.state]} {self.lines[0]}", *(f"  {line}" for line in self.lines[1:])))

    def _repr_html_(self) -> str:
        """Return the lines as HTML in a coloured box with a sign."""
        first, *rest = (escape(line) for line in self.lines)
        colour = _COLOURS[self.state]
        body = "".join(f"<div>{line}</div>" for line in rest)
        return (
            f'<div role="status" data-check="{escape(self.name)}" data-state="{self.state}" '
            f'style="border-left: 4px solid {colour}; padding: 0.4em 0.8em; margin: 0.3em 0">'
            f'<div><strong style="color: {colour}">{_SIGNS[self.state]} {first}</strong></div>{body}</div>'
        )


def with_the_reason(exercise: PublicExercise, report: Report, others: Mapping[str, Report]) -> Report:
    """Add to a report that an exercise of the same lesson, which this exercise uses, is wrong itself.

    Parameters
    ----------
    exercise : PublicExercise
        The exercise that was checked.
    report : Report
        Its report.
    others : mapping of str to Report
        The reports of other exercises of the lesson, by name, in the lesson's order.
    """
    if report.state not in AT_FAULT:
        return report
    wrong = [name for name, other in others.items() if name in exercise.uses and other.state in AT_FAULT]
    lines = [
        f"It uses {name}, which does not pass its own check: correct {name} first." for name in wrong[:1]
    ]
    return replace(report, lines=(*report.lines, *lines))


def explain(exercise: PublicExercise, outcomes: Sequence[Outcome], stopped: str) -> Report:
    """Report the outcomes of an exercise's public cases.

    Parameters
    ----------
    exercise : PublicExercise
        The exercise, with the expected answers.
    outcomes : sequence of Outcome
        One for each case; fewer if the last outcome ended the run: not attempted, out of time or a dead process.
    stopped : str
        Clause about how a function that takes too long was stopped.

    Returns
    -------
    Report
        Report for the student.
    """
    report = _explained(exercise, outcomes, stopped)
    remark = remark_on(name for outcome in outcomes for name in outcome.shown)
    return replace(report, lines=(*report.lines, remark)) if remark else report


def _explained(exercise: PublicExercise, outcomes: Sequence[Outcome], stopped: str) -> Report:
    """Report the outcomes without a remark on interactive calls."""
    title = f"{exercise.number} {exercise.name}"
    last = outcomes[-1]
    if last.status == "not attempted":
        return Report(exercise.name, "not attempted", (f"{title}: not written yet.",))
    if last.status == "not found":
        return Report(exercise.name, "not attempted", (f"{title}: your notebook does not define it.",))
    if last.status == "died":
        ended = "" if last.text.startswith(_ENDED_BY_THE_GRADER) else f"{ENDS_PYTHON}; "
        return Report(exercise.name, "raised", (f"{title}: {ended}{last.text}.",))
    if last.status in ("interrupted", "timed out"):
        how = "stopped by you" if last.status == "interrupted" else stopped
        text = f"{title}: {how}. Does it have a loop that never ends, or a method that is too slow for a large case?"
        return Report(exercise.name, "interrupted", (text,))
    verdicts = [
        judge(exercise.comparison, case, outcome)
        for case, outcome in zip(exercise.cases, outcomes, strict=True)
    ]
    wrong = [i for i, verdict in enumerate(verdicts) if not verdict]
    changed = any(outcome.changed for outcome in outcomes)
    if not wrong and not changed:
        lines = (
            f"{title}: {_passed(len(verdicts), len(verdicts))}.",
            "The grader checks your function with other inputs.",
        )
        return Report(exercise.name, "right", lines)
    if not wrong:
        text = f"{title}: your answers are right, but your function changes its input. Return a new array instead."
        return Report(exercise.name, "wrong", (text, *_recognised(exercise, outcomes, wrong)))
    return _explain(exercise, title, outcomes, verdicts, wrong)


def _explain(
    exercise: PublicExercise,
    title: str,
    outcomes: Sequence[Outcome],
    verdicts: list[Verdict | None],
    wrong: list[int],
) -> Report:
    """Describe the first wrong case, and the mistake that explains all wrong cases."""
    first = wrong[0]
    outcome, verdict = outcomes[first], verdicts[first]
    about = f" ({exercise.cases[first].name})" if exercise.cases[first].name else ""
    passed = _passed(len(verdicts) - len(wrong), len(verdicts))
    state: CheckState = "wrong"
    if verdict is not None:
        lines = [_sentence(f"{title}: {passed}. {_WRONG[verdict.kind]}{about}: {verdict.text}")]
        lines += _input_at(exercise.cases[first], verdict)
    elif outcome.status == "unsendable":
        lines = [_sentence(f"{title}: {passed}. {_WRONG['type']}{about}: {outcome.text}")]
    elif outcome.text.startswith(f"{EarlierNotUsable.__name__}: "):
        state, lines = "not checked", [f"{title}: {passed}. {outcome.text.partition(': ')[2]}"]
    else:
        state, lines = "raised", [f"{title}: {passed}; {_raises(outcome.text)}{about}."]
        lines += [outcome.line] if outcome.line else []
        lines += (
            [f"In this case your function should raise {wanted}."]
            if (wanted := exercise.cases[first].raises)
            else []
        )
        if re.search(rf"[ .](?:{exercise.name}(?:\.\w+)?|<lambda>)\(\) .*positional argument", outcome.text):
            lines.append(
                "Keep the function's first line as the lesson gives it: the check calls it with those arguments."
            )
        else:
            lines += advice_on(outcome.text, outcome.line)
            if "is out of bounds for axis" in outcome.text and any(
                map(_is_picture, exercise.cases[first].args)
            ):
                lines.append(
                    "In a picture, the row comes first. Take its size from shape: the check's pictures are small."
                )
    parts = _right_parts(exercise, wrong)
    return Report(exercise.name, state, (*lines, *_recognised(exercise, outcomes, wrong), *parts))


def _right_parts(exercise: PublicExercise, wrong: list[int]) -> list[str]:
    """List the parts of a class that pass; a case's name says which part it tests: "move: a turn"."""
    if exercise.driver != "methods":
        return []
    parts = [case.part for case in exercise.cases]
    failing = {parts[i] for i in wrong}
    right = dict.fromkeys(part for part in parts if part and part not in failing)
    return [f"These parts are right: {', '.join(right)}."] if right else []


def _sentence(text: str) -> str:
    """Add a full stop to a text that has no final punctuation."""
    return text if text.endswith((".", "!", "?")) else f"{text}."


def _raises(text: str) -> str:
    """Describe the exception of a case, or name the part that is not written yet or that needs a person."""
    known = re.fullmatch(
        rf"NotImplementedError: ([\w.]+ is not written yet)|{InteractiveCall.__name__}: (.*)", text
    )
    return known[1] or known[2] if known else f"your function raises {text}"


def _is_picture(argument: object) -> bool:
    """Return whether an argument of a case is a picture: rows and columns of bytes, or a mask."""
    return isinstance(argument, np.ndarray) and argument.ndim >= 2 and argument.dtype in (np.uint8, bool)


def _input_at(case: Case, verdict: Verdict) -> list[str]:
    """Show the element of the first argument that the first wrong element of the answer was computed from.

    It is the element at the same index, or the row at the same index if both are rows of a few numbers, such as points.
    Nothing is shown if the answer has another shape, such as a matrix that depends on all rows, or if the argument is
    a pose beside another array. If the answer has several parts, all of them must be arrays of the argument's shape,
    because the index does not say which part it belongs to.
    """
    given, wanted = (case.args[0] if case.args else None), case.expected
    place = len(verdict.at)
    if not isinstance(given, np.ndarray) or not place or given.ndim not in (place, place + 1):
        return []
    if given.size <= SMALL and any(isinstance(each, np.ndarray) for each in case.args[1:]):
        return []
    parts = list(wanted) if isinstance(wanted, tuple | list) else [wanted]
    if len({isinstance(part, np.ndarray) for part in parts}) > 1:
        return []
    if len({np.ndim(part) for part in parts if isinstance(part, np.ndarray)}) > 1:
        return []
    if any(isinstance(part, np.ndarray) and part.shape[:1] != given.shape[:1] for part in parts):
        return []
    if given.ndim == place == 2 and given.shape[1] <= 3:
        return [f"The same row of the first argument is {_numbers(given[verdict.at[0]])}."]
    if isinstance(wanted, np.ndarray) and wanted.shape[:place] != given.shape[:place]:
        return []
    if (
        any(index >= size for index, size in zip(verdict.at, given.shape, strict=False))
        or given[verdict.at].size > 4
    ):
        return []
    return [f"There the first argument is {_numbers(given[verdict.at])}."]


def _numbers(values: npt.NDArray[Any]) -> str:
    """Write a number as it is, and more numbers in brackets."""
    written = ", ".join(f"{float(value):g}" for value in values.ravel())
    return written if values.size == 1 else f"[{written}]"


def _passed(right: int, checks: int) -> str:
    if right == checks:
        return f"all {checks} public checks pass" if checks > 1 else "the public check passes"
    return f"{right} of {checks} public checks pass" if checks > 1 else "the public check does not pass"


def _recognised(exercise: PublicExercise, outcomes: Sequence[Outcome], wrong: list[int]) -> list[str]:
    """Return the message of the mistake whose answers these are, or both messages if two mistakes give them together.

    A mistake has to be wrong in the same cases and give the same answers there: in all cases, or in the first
    wrong part (a method), because the methods after it may not be written yet. No mistake is recognised by a part
    that is not written, or if it gives wrong answers in a part that is right. An unstable answer matches any
    wrong answer, so several mistakes may match. Then the mistake with the most answers that are really the same is
    chosen, and among equals the first one.
    """
    part = exercise.cases[wrong[0]].part if wrong else ""
    of_part = {number for number, case in enumerate(exercise.cases) if case.part == part}
    return (
        _one_mistake(exercise, outcomes, wrong, set(range(len(outcomes))))
        or _recognised_pair(exercise, outcomes, wrong)
        or (_one_mistake(exercise, outcomes, wrong, of_part) if part and exercise.driver == "methods" else [])
    )


def _one_mistake(
    exercise: PublicExercise, outcomes: Sequence[Outcome], wrong: list[int], among: set[int]
) -> list[str]:
    """Return the message of the mistake that explains the wrong cases among some; an empty list if none does."""
    best, most = [], -1
    failing = {exercise.cases[i].part for i in wrong}
    for mistake in exercise.mistakes:
        given = {int(i): answer for i, answer in mistake.answers.items()}
        answers = {i: answer for i, answer in given.items() if i in among}
        if sorted(answers) != [i for i in wrong if i in among]:
            continue
        if answers and all(map(_is_unwritten, answers.values())):
            continue
        written = {i for i, answer in given.items() if i < len(outcomes) and not _is_unwritten(answer)}
        if {exercise.cases[i].part for i in written} - failing:
            continue
        found = [(answer, outcomes[i]) for i, answer in answers.items()]
        if all(is_unstable(each[0]) or same_answer(exercise, *each) for each in found):
            same = sum(same_answer(exercise, *each) for each in found)
            if same > most:
                best, most = [mistake.message], same
    return best


def _recognised_pair(exercise: PublicExercise, outcomes: Sequence[Outcome], wrong: list[int]) -> list[str]:
    """Return the messages of the two mistakes that give these answers together; nothing if two pairs match."""
    found = [
        pair
        for pair in exercise.pairs
        if pair.wrong == wrong
        and all(same_answer(exercise, answer, outcomes[int(i)]) for i, answer in pair.answers.items())
    ]
    if len(found) != 1:
        return []
    return [TWO_ERRORS, *(exercise.mistakes[number].message for number in found[0].mistakes)]


def _is_unwritten(answer: Any) -> bool:
    """Return whether a mistake's answer says that a method is not written."""
    return isinstance(answer, dict) and answer.get("raises") == "NotImplementedError"


def is_unstable(answer: Any) -> bool:
    """Return whether a mistake's answer is a rounding error, so that any wrong answer may be the same mistake."""
    return isinstance(answer, dict) and set(answer) == {"unstable"}


def same_answer(exercise: Exercise | PublicExercise, answer: Any, outcome: Outcome) -> bool:
    """Return whether an outcome equals a mistake's answer, which has one of the forms of `PublicMistake`."""
    if is_unstable(answer):
        return same_answer(exercise, answer["unstable"], outcome)
    if isinstance(answer, dict) and set(answer) == {"raises"}:
        return outcome.status != "value" and re.split("[: ]", outcome.text)[0] == answer["raises"]
    return outcome.status == "value" and exercise.comparison.alike(answer, outcome.value)
