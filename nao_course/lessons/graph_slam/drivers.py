"""Call and judge solve and solve_sparse: free variables must be named, a large matrix and its factor stay sparse."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import scipy.sparse
import scipy.sparse.linalg

from nao_course._internal.counts import say_count
from nao_course.exercises import Case, Close, Comparison, register, register_driver
from nao_course.exercises.comparisons.comparison import RIGHT, Verdict
from nao_course.exercises.comparisons.large_sparse import without_dense

# Whole numbers that are separate words, unlike the 64 in "int64" or the 9 in "1e-9". No system has a variable with a
# number of ten digits, and Python refuses to read numbers of thousands of digits.
_NUMBER = re.compile(r"(?<![\w.-])\d{1,9}(?![\w.]*\w)")

LONGEST_MESSAGE = 100_000  # characters that are read: NumPy writes np.int64(7) for a 7 in a list
_POOR_ORDER = {"order": "poor"}
MANY = 1000  # variables: a message that names more of them may have been cut off
_LONGEST_SAID = 200  # characters of it that a verdict shows

SMALL = 1000  # variables: a system of this size is solved within a second in any order
MOST_FILL = 30  # times as many entries as the lower half of the matrix has: a good order needs 1 to 5
_SPLU, _SPSOLVE = scipy.sparse.linalg.splu, scipy.sparse.linalg.spsolve


@register_driver
def solution_or_unheld(function: Callable[..., Any], omega: Any, xi: Any) -> tuple[str, Any]:
    """Call a solver with omega (N, N) and xi (N,), and return the kind of its outcome and the outcome.

    It is "returned" and the returned value, "raised" and the message of a ValueError, which names the variables that
    nothing holds, or "poor order" and None if the factor of a large system would fill up.
    """
    answer: tuple[str, Any] = ("poor order", None)
    with watched_orders() as found:
        try:
            answer = "returned", function(without_dense(omega), xi)
        except ValueError as error:
            answer = "raised", str(error)[:LONGEST_MESSAGE]
        except PoorOrderError:
            pass
    return ("poor order", None) if found else answer


class PoorOrderError(Exception):
    """The factor would have too many entries."""


def fills_up(matrix: Any) -> bool:
    """Return whether elimination in the order of the numbers gives a factor of more than `MOST_FILL` times the entries.

    Only the pattern is eliminated, by the elimination tree (Davis, 2006, section 4.1), and the count ends at the limit.
    """
    below = scipy.sparse.tril(scipy.sparse.csr_array(matrix), -1, format="csr")
    size = below.shape[0]
    rows, columns = below.indptr.tolist(), below.indices.tolist()
    most, count = MOST_FILL * (len(columns) + size), size
    parent, visited = [-1] * size, [-1] * size
    for row in range(size):
        visited[row] = row
        for column in columns[rows[row] : rows[row + 1]]:
            while visited[column] != row:
                if parent[column] < 0:
                    parent[column] = row
                visited[column] = row
                count += 1
                column = parent[column]
        if count > most:
            return True
    return False


def _with_its_warnings(solver: Callable[..., Any], *args: Any, **options: Any) -> Any:
    """Call one of SciPy's solvers; its warnings name the student's line, two calls above this one."""
    with warnings.catch_warnings(record=True) as said:
        answer = solver(*args, **options)
    for each in said:
        warnings.warn(each.message, stacklevel=3)
    return answer


@contextmanager
def watched_orders() -> Iterator[list[bool]]:
    """Let splu and spsolve raise PoorOrderError instead of filling a factor; the list that it yields is then not empty.

    SuperLU cannot be interrupted, so with a poor order a student would wait for minutes.
    """
    found: list[bool] = []

    def refuse_if_poor(matrix: Any, permc_spec: str | None) -> None:
        if permc_spec == "NATURAL" and matrix.shape[0] > SMALL and fills_up(matrix):
            found.append(True)
            raise PoorOrderError("this order of elimination fills the factor")

    def splu(A: Any, permc_spec: str | None = None, *args: Any, **options: Any) -> Any:
        refuse_if_poor(A, permc_spec)
        return _with_its_warnings(_SPLU, A, permc_spec, *args, **options)

    def spsolve(A: Any, b: Any, permc_spec: str | None = None, *args: Any, **options: Any) -> Any:
        refuse_if_poor(A, permc_spec)
        return _with_its_warnings(_SPSOLVE, A, b, permc_spec, *args, **options)

    scipy.sparse.linalg.splu, scipy.sparse.linalg.spsolve = splu, spsolve
    try:
        yield found
    finally:
        scipy.sparse.linalg.splu, scipy.sparse.linalg.spsolve = _SPLU, _SPSOLVE


def numbers_in(message: str) -> list[int]:
    """Return the whole numbers that are separate words of a message."""
    return [int(each) for each in _NUMBER.findall(message)]


@register
@dataclass(frozen=True)
class SolvedOrNamed(Comparison):
    """Compare solutions by their values, and errors by the variables that they name."""

    def gather(self, case: Case, answers: Iterable[Any]) -> Any:
        """Return what the function returned; of an error a dict of the whole numbers in its message and the message."""
        match next(iter(answers)):
            case ("raised", str(message)):
                named = sorted(set(numbers_in(message[:LONGEST_MESSAGE])))
                return {"named": named, "said": message[:_LONGEST_SAID]}
            case ("poor order", None):
                return dict(_POOR_ORDER)
            case ("returned", answer) if not isinstance(answer, dict):
                return answer
        return {}  # a dict is never a right answer

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare two answers in the form that `gather` returns."""
        if isinstance(got, dict) and got == _POOR_ORDER:
            return Verdict(
                "value",
                "it was stopped, because in this order of elimination the factor has more than "
                f"{MOST_FILL} times as many entries as the lower half of omega, and that takes minutes",
            )
        if _is_error(expected) and _is_error(got):
            wanted, named = expected["named"], got["named"]
            if wanted == named:
                return RIGHT
            count = say_count(len(named), "variable")
            which = "other ones" if len(wanted) == len(named) else f"{len(wanted)} of them"
            more = (
                "; each whole number in the message is read as a variable" if set(wanted) < set(named) else ""
            )
            return Verdict(
                "value", f"your ValueError names {count}, but nothing holds {which}: {got['said']!r}{more}"
            )
        if _is_error(expected):
            return Verdict(
                "no error",
                "it returns something, but should raise a ValueError, because nothing holds a part of the system",
            )
        if _is_error(got):
            return Verdict(
                "value", f"the system has a solution, but your function raises ValueError: {got['said']!r}"
            )
        return Close(rtol=1e-5, atol=1e-6).compare(expected, got)

    def alike(self, answer: Any, got: Any) -> bool:
        """Return whether an answer equals the answer of a mistake, which may be of any kind."""
        if isinstance(got, dict) and got == _POOR_ORDER:
            return isinstance(answer, dict) and answer == _POOR_ORDER
        if (
            _is_error(answer)
            and _is_error(got)
            and (most := min(len(answer["named"]), len(got["named"]))) > MANY
        ):
            return bool(answer["named"][: most - 1] == got["named"][: most - 1])
        try:
            return bool(self.compare(answer, got))
        except ValueError:
            return bool(Close().compare(answer, got))


def _is_error(answer: Any) -> bool:
    return isinstance(answer, dict) and answer.keys() == {"named", "said"}
