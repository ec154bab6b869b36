"""The comparison of a student's states, in which the graph says which of the flat numbers are headings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_course.exercises import Case, Close, Comparison, register
from nao_course.exercises.comparisons.comparison import Verdict

MOVED = 1e-6  # m or rad: a larger difference is not a rounding error


@register
@dataclass(frozen=True)
class SolvedStates(Comparison):
    """Compares (states, chi2 history), with headings on the circle."""

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare without knowing which numbers are headings."""
        return Close(names=("your states", "your chi2 history")).compare(expected, got)

    def judge(self, case: Case, answer: Any) -> Verdict:
        """Compare with the expected answer of a case, whose first argument is the graph."""
        graph, expected = case.args[0], case.expected
        verdict = self.compare(expected, _on_the_same_turn(graph.poses, expected, answer))
        said = "" if verdict else _difference_to_plain(case, answer)
        return Verdict("law", said) if said else verdict


def _difference_to_plain(case: Case, answer: Any) -> str:
    """Say how a wrong answer differs from plain Gauss-Newton with the first pose held; empty if it is not clear."""
    try:
        states, history = (np.array(each, dtype=float) for each in answer)
        moved = np.abs(states - case.args[1])[:3].max()
    except (TypeError, ValueError):
        return ""
    expected = np.asarray(case.expected[1], dtype=float)
    if not moved < MOVED:
        return "your first pose moves; solve without its three rows and columns"
    if history.ndim != 1 or len(history) > len(expected):
        return ""
    if len(history) < len(expected):
        return f"your history has {len(history)} of {len(expected)} numbers; take all steps, even if chi2 increases"
    climbs = (expected[1:] > 1.01 * expected[:-1]) & (history[1:] <= history[:-1])
    return (
        "your chi2 does not increase although a plain step increases it; take the full step, and add nothing to H"
        if climbs.any()
        else ""
    )


def _on_the_same_turn(poses: int, expected: Any, answer: Any) -> Any:
    """Move headings by whole turns close to the expected ones; return any other answer unchanged."""
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
