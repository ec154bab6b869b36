"""How a student's states are compared: a graph says which of the flat numbers are headings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_course.exercises import Case, Close, Comparison, register
from nao_course.exercises.comparisons.comparison import Verdict

MOVED = 1e-6  # m or rad: more is no rounding


@register
@dataclass(frozen=True)
class SolvedStates(Comparison):
    """(states, chi2 history): headings are compared on the circle, the history to a part in ten thousand."""

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare where it is not known which numbers are headings."""
        return Close(names=("your states", "your chi2 history")).compare(expected, got)

    def judge(self, case: Case, answer: Any) -> Verdict:
        """Compare with what a case expects; its first argument is the graph."""
        graph, expected = case.args[0], case.expected
        verdict = self.compare(expected, _on_the_same_turn(graph.poses, expected, answer))
        said = "" if verdict else _what_is_not_plain(case, answer)
        return Verdict("law", said) if said else verdict


def _what_is_not_plain(case: Case, answer: Any) -> str:
    """Say in which way a wrong answer is no plain Gauss-Newton with the first pose held, where one can tell."""
    try:
        states, history = (np.array(each, dtype=float) for each in answer)
        moved = np.abs(states - case.args[1])[:3].max()
    except (TypeError, ValueError):
        return ""
    expected = np.asarray(case.expected[1], dtype=float)
    if not moved < MOVED:
        return "your first pose does not stay where it is; solve without its three rows and columns"
    if history.ndim != 1 or len(history) > len(expected):
        return ""
    if len(history) < len(expected):
        return f"your history has {len(history)} of {len(expected)} numbers; take all steps, also where nothing moves"
    climbs = (expected[1:] > 1.01 * expected[:-1]) & (history[1:] <= history[:-1])
    return (
        "your chi2 does not rise where a plain step makes it larger; take the whole step, with nothing added to H"
        if climbs.any()
        else ""
    )


def _on_the_same_turn(poses: int, expected: Any, answer: Any) -> Any:
    """Move headings by whole turns to where the expected ones are; anything else is left as it is."""
    if not isinstance(answer, tuple | list) or len(answer) != 2:
        return answer
    wanted = np.asarray(expected[0], dtype=float)
    try:
        states = np.array(answer[0], dtype=float)
    except (TypeError, ValueError):
        return answer
    if states.shape != wanted.shape:
        return answer
    with np.errstate(invalid="ignore"):
        headings = slice(2, 3 * poses, 3)
        turns = np.round((wanted[headings] - states[headings]) / (2 * np.pi))
    states[headings] += 2 * np.pi * turns
    return (states, answer[1])
