"""How a student's states are compared: a graph says which of the flat numbers are headings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_course.exercises import Case, Close, Comparison, register
from nao_course.exercises.comparisons.comparison import Verdict


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
        return self.compare(expected, _on_the_same_turn(graph.poses, expected, answer))


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
