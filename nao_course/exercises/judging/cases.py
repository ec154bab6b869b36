"""Judge one case: make its calls, and compare the answers with what is expected."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from nao_course.exercises.case import Case
from nao_course.exercises.comparisons.comparison import RIGHT, Comparison, Verdict, with_article
from nao_course.exercises.running import Outcome


def answer(comparison: Comparison, call: Callable[[Case], Outcome], case: Case) -> Outcome:
    """Make the calls of a case, one by one, and let the comparison gather the answers.

    Parameters
    ----------
    comparison : Comparison
        Comparison, which determines the calls.
    call : callable
        Function that makes one call.
    case : Case
        The case.

    Returns
    -------
    Outcome
        Outcome of the first call without a value; otherwise an outcome whose value is compared.
    """
    last = Outcome("value")
    changed, shown = False, dict[str, None]()

    def answers() -> Iterator[Any]:
        nonlocal last, changed
        for each in comparison.calls(case):
            last = call(each)
            changed |= last.changed
            shown.update(dict.fromkeys(last.shown))
            if last.status != "value":
                raise _NoAnswer
            yield last.value

    try:
        gathered = comparison.gather(case, answers())
    except _NoAnswer:
        return last
    return replace(last, value=gathered, changed=changed, shown=tuple(shown))


class _NoAnswer(Exception):  # noqa: N818 - no error: a call gave no value
    """Raised to end the gathering of a case's answers."""


def judge(comparison: Comparison, case: Case, outcome: Outcome) -> Verdict | None:
    """Judge the outcome of a case.

    Returns
    -------
    Verdict or None
        None if there is no answer but, for example, an exception that the case does not expect.
    """
    if case.raises:
        if outcome.status == "value":
            return Verdict(
                "no error",
                f"your function returns {with_article(outcome.value)}, but it should raise {case.raises}",
            )
        return RIGHT if outcome.status == "raised" and case.raises in outcome.errors else None
    if outcome.status != "value":
        return None
    # The numbers are untrusted, and NumPy's warnings during the call have been reported before.
    with np.errstate(all="ignore"):
        return comparison.judge(case, outcome.value)
