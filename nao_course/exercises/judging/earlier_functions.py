"""Compare a student's functions of earlier lessons with the reference's on the calls that a check has recorded."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping
from contextlib import redirect_stdout, suppress
from copy import deepcopy
from io import StringIO
from itertools import count
from typing import Any

import numpy as np

from nao_course.exercises.case import Case
from nao_course.exercises.comparisons.values import Close
from nao_course.exercises.earlier import EarlierCall, in_words, split_use
from nao_course.exercises.exercise import PublicExercise
from nao_course.exercises.judging.cases import judge
from nao_course.exercises.running import Outcome, TimeIsUp, alarm, call_all

SECONDS = 2.0  # wall clock for all recorded calls of a check
MOST_SHOWN = 60  # characters of a call


def differing(
    exercise: PublicExercise,
    called: Mapping[str, Callable[..., Any]],
    find: Callable[[str], PublicExercise | None],
) -> dict[str, str]:
    """Return why each of a student's earlier functions differs from the reference's, by uses such as "07:warp2pi".

    Parameters
    ----------
    exercise : PublicExercise
        The exercise whose check has recorded the reference's calls.
    called : mapping of str to callable
        The student's functions, which pass their own public checks.
    find : callable
        Returns the exercise of a use, whose comparison decides whether two answers differ; None if it is not known.

    Returns
    -------
    dict of str to str
        A sentence about the first recorded call for which a function differs. Functions that do not differ are left
        out.
    """
    found: dict[str, str] = {}
    if not called:
        return found  # the recorded calls are not read
    own = {use: find(use) for use in called}
    # In turn, so that each function is called within the time
    numbers = defaultdict[str, Iterator[int]](count)
    calls = sorted(exercise.earlier, key=lambda each: next(numbers[each.use]))
    ends = time.monotonic() + SECONDS
    for each in calls:
        if (left := ends - time.monotonic()) <= 0:
            break
        if each.use in called and each.use not in found:
            why = _why_it_differs(each, called[each.use], own[each.use], left)
            if why:
                found[each.use] = (
                    f"{in_words(each.use)} passes its own check, but not with an input of this one{_shown(each)}: {why}"
                )
    return found


def _why_it_differs(
    recorded: EarlierCall, function: Callable[..., Any], own: PublicExercise | None, seconds: float
) -> str:
    """Return why a function's answer to a recorded call is wrong as a sentence; nothing if it is right."""
    if _clearly_right(recorded, function, seconds):
        return ""
    by_position = list(recorded.given) == recorded.parameters[: len(recorded.given)]
    values = tuple(recorded.given.values())
    case = Case(
        values if by_position else (), kwargs={} if by_position else recorded.given, expected=recorded.answer
    )
    with redirect_stdout(StringIO()):
        (outcome,) = call_all(function, [case], seconds=seconds)
    if outcome.status != "value":
        return _said_of(outcome)
    comparison = Close(rtol=1e-6, atol=1e-9) if own is None or own.driver else own.comparison
    verdict = judge(comparison, case, outcome)
    if verdict is not None and not verdict:
        return f"{verdict.text.rstrip('.')}."
    return "it changes its input." if outcome.changed else ""


def _clearly_right(recorded: EarlierCall, function: Callable[..., Any], seconds: float) -> bool:
    """Return whether a call returns the recorded answer and changes no input; this is much faster than a verdict."""
    given = deepcopy(recorded.given)
    with (
        redirect_stdout(StringIO()),
        suppress(Exception, TimeIsUp),
        np.errstate(all="ignore"),
        alarm(seconds),
    ):
        answer = function(*given.values())
        return _alike(answer, recorded.answer) and _alike(list(given.values()), list(recorded.given.values()))
    return False


def _alike(one: Any, other: Any) -> bool:
    """Return whether two answers are the same up to rounding; types other than plain ones differ."""
    if isinstance(other, list | tuple):
        return isinstance(one, list | tuple) and len(one) == len(other) and all(map(_alike, one, other))
    if isinstance(other, np.ndarray | np.number | float | int):
        first, second = np.asarray(one), np.asarray(other)
        return (
            first.shape == second.shape
            and first.dtype.kind in "biuf"
            and bool(
                np.abs(first - second).max(initial=0.0) <= 1e-9 * max(1.0, np.abs(second).max(initial=0.0))
            )
        )
    return False


def _said_of(outcome: Outcome) -> str:
    """Return a sentence about a call without a value; nothing if the time was too short to say."""
    if outcome.status == "raised":
        return f"it raises {outcome.text.rstrip('.')}."
    return "its answer cannot be compared." if outcome.status == "unsendable" else ""


def _shown(recorded: EarlierCall) -> str:
    """Return a call as text, ", warp2pi([0.1])", if it is short."""
    call = f"{split_use(recorded.use)[1]}({', '.join(map(_as_text, recorded.given.values()))})"
    return f", {call}" if len(call) <= MOST_SHOWN else ""


def _as_text(value: Any) -> str:
    """Return a number or an array with four significant digits; any other value as Python writes it."""
    if isinstance(value, np.ndarray) and value.size <= MOST_SHOWN:
        return np.array2string(value, precision=4, separator=", ")
    return f"{float(value):.4g}" if isinstance(value, float | np.floating) else repr(value)
