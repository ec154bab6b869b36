"""The judging of a case: the calls that it takes, and whether what came of them is right."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from nao_course.exercises.case import Case
from nao_course.exercises.comparisons.comparison import RIGHT, Comparison, Verdict, with_article
from nao_course.exercises.running import Outcome


def answer(comparison: Comparison, call: Callable[[Case], Outcome], case: Case) -> Outcome:
    """Make the calls of a case, one by one, and let the comparison gather what they answer.

    Parameters
    ----------
    comparison : Comparison
        That says which calls.
    call : callable
        Makes one.
    case : Case
        Any.

    Returns
    -------
    Outcome
        Of the first call that gave no value; else with what is compared as its value.
    """
    last = Outcome("value")
    changed = False

    def answers() -> Iterator[Any]:
        nonlocal last, changed
        for each in comparison.calls(case):
            last = call(each)
            changed |= last.changed
            if last.status != "value":
                raise _NoAnswer
            yield last.value

    try:
        gathered = comparison.gather(case, answers())
    except _NoAnswer:
        return last
    return replace(last, value=gathered, changed=changed)


class _NoAnswer(Exception):  # noqa: N818 - no error: a call gave no value
    """Ends the gathering of a case's answers."""


def judge(comparison: Comparison, case: Case, outcome: Outcome) -> Verdict | None:
    """Judge what came of a case.

    Returns
    -------
    Verdict or None
        None where there is no answer, but an exception that the case does not ask for, or worse.
    """
    if case.raises:
        if outcome.status == "value":
            return Verdict(
                "no error", f"it returns {with_article(outcome.value)} and has to raise {case.raises}"
            )
        return RIGHT if outcome.status == "raised" and case.raises in outcome.errors else None
    if outcome.status != "value":
        return None
    with np.errstate(all="ignore"):  # a stranger's numbers; what NumPy warned of in the call was said there
        return comparison.judge(case, outcome.value)
