"""Messages for failed hidden cases: the type of failure in fixed words, without anything that depends on the input."""

import json
import re
import signal
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import takewhile
from typing import Any

import numpy as np

from nao_course._internal.text_encodings import decode_text
from nao_course.exercises import judging
from nao_course.exercises.case import Case
from nao_course.exercises.cells import source_of
from nao_course.exercises.comparisons.comparison import Verdict
from nao_course.exercises.definitions import Skipped
from nao_course.exercises.exercise import PublicExercise
from nao_course.exercises.failed_cells import defining_cell, why_missing
from nao_course.exercises.interactive import InteractiveCall
from nao_course.exercises.running import Outcome
from nao_course.exercises.versions import Newer
from nao_course.instructor.autograding.tries import NOT_RUN
from nao_course.instructor.collecting.archives import LARGEST_READ
from nao_course.instructor.collecting.files import Files
from nao_course.instructor.gradebook.records import ExerciseResult, State
from nao_course.instructor.sandbox.protocol import SECONDS_IN_ALL, UNREADABLE, USED_UP
from nao_course.instructor.sandbox.worker import TOO_OFTEN

CHANGES_INPUT = "Your function changes its input. Return a new array instead."
NEEDS_A_PERSON = "It waits for a person at the keyboard. Remove calls such as input() and breakpoint()."
# What students meet. Short: which name a call ends with may depend on a hidden input.
_KNOWN_ERRORS = {
    *(
        "AssertionError",
        "AttributeError",
        "AxisError",
        "FloatingPointError",
        "IndexError",
        "KeyError",
        "LinAlgError",
    ),
    *(
        "MemoryError",
        "ModuleNotFoundError",
        "NameError",
        "OverflowError",
        "RecursionError",
        "SystemExit",
        "TypeError",
    ),
    # OpenCV's exception is called error.
    *("RuntimeError", "UnboundLocalError", "ValueError", "ZeroDivisionError", "error"),
}
# Signals that end a process by accident: a choice among all signals would reveal five bits of an input.
_SIGNALS = {
    getattr(signal, each, 0) for each in ("SIGSEGV", "SIGABRT", "SIGKILL", "SIGFPE", "SIGBUS", "SIGILL")
}
_MOST_DIMENSIONS = 4  # that are counted; an array may have 64
_LINE = re.compile(r"line (\d{1,5}): (.+)")
LONGEST_MESSAGE = 200  # characters of it
MOST_LINES = 100  # length of the longest definition whose lines are shown


@dataclass(frozen=True)
class HiddenResult:
    """The outcome of an exercise's hidden cases; where some fail, the parts of which all cases pass."""

    state: State
    passed: int
    text: str = ""
    line: str = ""
    parts: tuple[str, ...] = ()


def describe_failure(name: str, outcome: Outcome, files: Files, seconds: float) -> HiddenResult:
    """Say how a case of an exercise failed, in our words only."""
    match outcome.status:
        case "raised":
            kind = outcome.text.split(":")[0]
            if kind == InteractiveCall.__name__:
                return HiddenResult("raised", 0, NEEDS_A_PERSON, own_line(outcome.line, files, name))
            kind = kind if kind in _KNOWN_ERRORS else "an exception of its own"
            return HiddenResult("raised", 0, f"It raises {kind}.", own_line(outcome.line, files, name))
        case "timed out" if outcome.text.startswith(NOT_RUN):
            return HiddenResult("not run", 0, outcome.text)
        case "timed out" if outcome.text == USED_UP:
            text = f"Its calls took too long together: a submission has {SECONDS_IN_ALL:g} seconds for all exercises."
            return HiddenResult("timed out", 0, text)
        case "timed out":
            return HiddenResult("timed out", 0, f"It took longer than {seconds:g} seconds.")
        case "not attempted":
            return HiddenResult("not attempted", 0)
        case "not found":
            return HiddenResult("not found", 0)
        case "died" if outcome.text.endswith(TOO_OFTEN):
            return HiddenResult("timed out", 0, "It calls a function of another exercise too often.")
        case "died" if outcome.text != UNREADABLE:
            return HiddenResult("died", 0, _how_it_died(outcome.text))
    return HiddenResult("no usable answer", 0, "Its answer is of a kind that cannot be sent.")


def own_line(line: str, files: Files, name: str) -> str:
    """Return the line that raised if it is in the exercise's own definition: others might reveal an input."""
    found = _LINE.fullmatch(line)
    return line if found and (int(found[1]), found[2]) in definition_lines(files.notebook, name) else ""


@lru_cache(maxsize=4)
def definition_lines(notebook: bytes, name: str) -> frozenset[tuple[int, str]]:
    """Return the line numbers and lines, without surrounding blanks, of an exercise's last definition in a notebook.

    The numbers count in its cell, and nothing of the notebook runs. A large notebook or definition has no lines,
    because a choice among many lines reveals much.
    """
    _, lines, start = defining_cell(name, code_cells(notebook))
    body = takewhile(lambda line: not line or line[0] in " \t)#", lines[start + 1 :])
    told = list(enumerate([*lines[start : start + 1], *body], start=start + 1))
    return frozenset((number, line.strip()) for number, line in told if len(told) <= MOST_LINES)


@lru_cache(maxsize=4)
def code_cells(notebook: bytes) -> tuple[str, ...]:
    """Return the source of each code cell of a notebook; nothing if it is large or cannot be read."""
    try:
        cells = json.loads(decode_text(notebook))["cells"] if len(notebook) <= LARGEST_READ else []
        return tuple(source_of(cell) for cell in cells if cell.get("cell_type") == "code")
    except (ValueError, TypeError, KeyError, AttributeError, RecursionError):
        return ()


def with_causes(
    results: Iterable[ExerciseResult], skipped: Sequence[Skipped], notebook: bytes, newer: Newer
) -> tuple[ExerciseResult, ...]:
    """Add to results why a definition is missing; a person decides what may be due to an older version here.

    `skipped` did not run when the notebook was loaded, before there was any hidden input; nothing of the notebook runs
    here. `newer` are the versions of the notebook that are newer than the grader's.
    """
    unread = next((each for each in skipped if each.cell and newer.explains(each.reason)), None)

    def with_cause(result: ExerciseResult) -> ExerciseResult:
        cause = why_missing(result.name, skipped, code_cells(notebook)) if result.state == "not found" else ""
        if result.state in ("not found", "raised"):
            where = (
                f"code cell {unread.cell}, line {unread.line}: {unread.reason[:LONGEST_MESSAGE]}"
                if unread
                else ""
            )
            error = where or next((line for line in result.public if newer.explains(line)), "")
            if error:
                written = f"Your notebook is written in {newer.against('the grader')}."
                text = f"{written} This may be the only reason for this error: {error}"
                return replace(result, state="undecided", text=text)
        return replace(result, state="raised", text=cause, public=()) if cause else result

    return tuple(map(with_cause, results))


def describe_outcome(
    exercise: PublicExercise, case: Case, outcome: Outcome, files: Files, seconds: float
) -> HiddenResult | None:
    """Return in which way the outcome of a hidden case is wrong; None if it is right."""
    verdict = _judged(exercise, case, outcome)
    if verdict is None:
        return describe_failure(exercise.name, outcome, files, seconds)
    if verdict:
        return None
    state: State = "no usable answer" if verdict.text == UNREADABLE else "wrong"
    return HiddenResult(state, 0, _told(verdict, case.expected, outcome.value))


def _judged(exercise: PublicExercise, case: Case, outcome: Outcome) -> Verdict | None:
    """Judge the outcome of a case; an answer that the comparison cannot read is wrong."""
    try:
        with np.errstate(all="ignore"):
            return judging.judge(exercise.comparison, case, outcome)
    except Exception:  # noqa: BLE001 - whatever a stranger's answer is, the grader goes on
        return Verdict("type", UNREADABLE)


def _told(verdict: Verdict, expected: Any, got: Any) -> str:
    """Say in which way an answer differs, and nothing that depends on the values of a hidden input."""
    match verdict.kind:
        case "nothing":
            return "It returns None, or None in place of a value. Is a return missing?"
        case "shape":
            return f"Its answer has the wrong shape: {_shapes(expected, got) or 'another one is expected'}."
        case "nan":
            return "Its answer is NaN where it should not be, or is not where it should be."
        case "type":
            return "Its answer is of the wrong kind."
        case "law":
            return "Its answer is not as it has to be: it does not have a property that is asked for."
        case "no error":
            return "It returns an answer where it has to raise an exception."
    return "Its answer has the right kind and shape, but not the right values."


def _shapes(expected: Any, got: Any) -> str:
    """Return in which dimension two answers differ, without sizes, because a size could reveal the input."""
    if isinstance(expected, tuple | list) and isinstance(got, tuple | list):
        pairs = zip(expected, got, strict=False)
        return next((text for one, other in pairs if (text := _shapes(one, other))), "")
    if isinstance(expected, dict) and isinstance(got, dict):
        return _shapes(list(expected.values()), [got.get(name) for name in expected])
    try:
        wanted, have = np.shape(expected), np.shape(got)
    except ValueError:
        return ""
    if len(wanted) != len(have):
        many = len(have) if len(have) <= _MOST_DIMENSIONS else "many"
        return f"{many} dimensions instead of {len(wanted)}"
    wrong = [str(axis) for axis, (one, other) in enumerate(zip(wanted, have, strict=True)) if one != other]
    return f"another size along axis {', '.join(wrong)}" if wrong else ""


def _how_it_died(text: str) -> str:
    found = re.match(r"the process was ended by signal (\d{1,2})\b", text)
    name = signal.strsignal(int(found[1])) if found and int(found[1]) in _SIGNALS else ""
    return f"It ends Python itself{f' ({name})' if name else ''}."
