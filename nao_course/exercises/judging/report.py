"""What a check found, told to a student: the first thing that is wrong, and the mistake that it looks like."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from typing import Any, Literal

import numpy as np

from nao_course.exercises.case import Case
from nao_course.exercises.comparisons.comparison import Verdict
from nao_course.exercises.earlier import EarlierNotUsable
from nao_course.exercises.exercise import PublicExercise
from nao_course.exercises.judging.cases import judge
from nao_course.exercises.running import Outcome
from nao_course.exercises.trying import advice_on

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
ENDS_PYTHON = "it ends Python itself"
SMALL = 9  # numbers of an array that is a pose, a point or a covariance, and no picture
AT_FAULT = ("wrong", "raised", "interrupted")  # states of an exercise that somebody has begun


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
    if report.state not in AT_FAULT:
        return report
    wrong = [name for name, other in others.items() if name in exercise.uses and other.state in AT_FAULT]
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
        return Report(exercise.name, "raised", (f"{title}: {ENDS_PYTHON}; {last.text}.",))
    if last.status in ("interrupted", "timed out"):
        how = "stopped by you" if last.status == "interrupted" else stopped
        text = f"{title}: {how}. Does it have a loop that never ends?"
        return Report(exercise.name, "interrupted", (text,))
    verdicts = [
        judge(exercise.comparison, case, outcome)
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
        lines = [_sentence(f"{title}: {passed}. {_WRONG[verdict.kind]}{about}: {verdict.text}")]
        lines += _input_at(exercise.cases[first], verdict)
    elif outcome.status == "unsendable":
        lines = [_sentence(f"{title}: {passed}. {_WRONG['type']}{about}: {outcome.text}")]
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


def _sentence(text: str) -> str:
    """A text with a full stop, where it has none."""
    return text if text.endswith((".", "!", "?")) else f"{text}."


def _raises(text: str) -> str:
    """What a case raises; a part that is still blank by its name."""
    unwritten = re.fullmatch(r"NotImplementedError: ([\w.]+ is not written yet)", text)
    return unwritten[1] if unwritten else f"one raises {text}"


def _input_at(case: Case, verdict: Verdict) -> list[str]:
    """Show what of the first argument the first wrong element of the answer was made from.

    That is the element at the same place; where both are rows of a few numbers, such as points, the row. An answer of
    another shape, such as a matrix about all rows, was made from no one of them; nor is that of a pose of three numbers
    beside another array. Of an answer of several parts nobody knows in which the place is: then all are as the input.
    """
    given, wanted = (case.args[0] if case.args else None), case.expected
    place = len(verdict.at)
    if not isinstance(given, np.ndarray) or not place or given.ndim not in (place, place + 1):
        return []
    if given.size <= SMALL and any(isinstance(each, np.ndarray) for each in case.args[1:]):
        return []
    parts = list(wanted) if isinstance(wanted, tuple | list) else [wanted]
    if any(isinstance(part, np.ndarray) and part.shape[:1] != given.shape[:1] for part in parts):
        return []
    if given.ndim == place == 2 and given.shape[1] <= 3:
        return [f"There the input is {' '.join(f'{float(value):g}' for value in given[verdict.at[0]])}."]
    if isinstance(wanted, np.ndarray) and wanted.shape[:place] != given.shape[:place]:
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
