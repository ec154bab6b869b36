"""How solve and solve_sparse are called and judged: what nothing holds must be named, a large matrix stays sparse."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from nao_course.exercises import Case, Close, Comparison, register, register_driver
from nao_course.exercises.comparisons.comparison import RIGHT, Verdict
from nao_course.exercises.comparisons.large_sparse import without_dense

_NUMBER = re.compile(
    r"(?<![\w.-])\d+(?![\w.]*\w)"
)  # whole numbers of their own: not that of "int64" or "1e-9"


LONGEST_MESSAGE = 10_000  # characters that are read
_LONGEST_SAID = 200  # of them, told


@register_driver
def solution_or_unheld(function: Callable[..., Any], omega: Any, xi: Any) -> tuple[str, Any]:
    """Call a solver.

    Parameters
    ----------
    function : callable
        ``function(omega, xi)`` returns x, or raises a ValueError that names the variables that nothing holds.
    omega : ndarray or sparse matrix, shape (N, N)
        Information matrix.
    xi : ndarray, shape (N,)
        Right-hand side.

    Returns
    -------
    (str, object)
        "returned" and what it returned, or "raised" and the message of a ValueError.
    """
    try:
        return "returned", function(without_dense(omega), xi)
    except ValueError as error:
        return "raised", str(error)[:LONGEST_MESSAGE]


def numbers_in(message: str) -> list[int]:
    """Return the whole numbers that stand in a message by themselves."""
    return [int(each) for each in _NUMBER.findall(message)]


@register
@dataclass(frozen=True)
class SolvedOrNamed(Comparison):
    """Answers that are close; or, where nothing holds some variables, an error that names just these."""

    def gather(self, case: Case, answers: Iterable[Any]) -> Any:
        """Return what the function returned; of an error a dict of the whole numbers in its message and the message."""
        match next(iter(answers)):
            case ("raised", str(message)):
                named = sorted(set(numbers_in(message[:LONGEST_MESSAGE])))
                return {"named": named, "said": message[:_LONGEST_SAID]}
            case ("returned", answer) if not isinstance(answer, dict):
                return answer
        return {}  # no dict is an answer, whatever stands in it

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare what `gather` made of an answer."""
        if _is_error(expected) and _is_error(got):
            wanted, named = expected["named"], got["named"]
            if wanted == named:
                return RIGHT
            count = f"{len(named)} variable{'' if len(named) == 1 else 's'}"
            which = "other ones" if len(wanted) == len(named) else f"{len(wanted)} of them"
            return Verdict(
                "value", f"your ValueError names {count}, and nothing holds {which}: {got['said']!r}"
            )
        if _is_error(expected):
            return Verdict(
                "no error",
                "it answers, and has to raise a ValueError: nothing holds a part of the system",
            )
        if _is_error(got):
            return Verdict(
                "value", f"there is an answer, and your function raises ValueError: {got['said']!r}"
            )
        return Close(rtol=1e-5, atol=1e-6).compare(expected, got)

    def alike(self, answer: Any, got: Any) -> bool:
        """Whether an answer is a mistake's, which may be of any kind."""
        try:
            return bool(self.compare(answer, got))
        except ValueError:
            return bool(Close().compare(answer, got))


def _is_error(answer: Any) -> bool:
    return isinstance(answer, dict) and answer.keys() == {"named", "said"}
