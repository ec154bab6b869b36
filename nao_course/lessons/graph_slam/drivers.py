"""How solve and solve_sparse are called: a system that nothing holds must be named, a large one never made dense."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, NoReturn

import scipy.sparse

from nao_course.exercises import register_driver

MOST_DENSE = 1000  # variables: a dense matrix of more has 8 MB and more
_NUMBER = re.compile(
    r"(?<![\w.-])\d+(?![\w.]*\w)"
)  # whole numbers of their own: not that of "int64" or "1e-9"


class _TooLarge:
    """A sparse matrix that refuses to be made dense, so that no computer's memory is filled by trying."""

    def toarray(self, *args: Any, **kwargs: Any) -> NoReturn:
        """Refuse."""
        size = self.shape[0]  # type: ignore[attr-defined]
        raise MemoryError(
            f"as a dense array this matrix has {size} x {size} numbers, most of them 0: leave it sparse"
        )

    todense = toarray


class _LargeArray(_TooLarge, scipy.sparse.csc_array):  # type: ignore[misc]  # scipy has no types
    """The same as an array of scipy's."""


def without_dense(matrix: Any) -> Any:
    """Return a sparse matrix that refuses to be made dense where it is large; whatever else as it is."""
    is_large = scipy.sparse.issparse(matrix) and matrix.shape[0] > MOST_DENSE
    return _LargeArray(matrix) if is_large else matrix


@register_driver
def solution_or_unheld(function: Callable[..., Any], omega: Any, xi: Any) -> Any:
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
    object
        What it returned; where it raised a ValueError, the whole numbers in its message, in a dict.
    """
    try:
        return function(without_dense(omega), xi)
    except ValueError as error:
        return {"named": sorted(set(numbers_in(str(error))))}


def numbers_in(message: str) -> list[int]:
    """Return the whole numbers that stand in a message by themselves."""
    return [int(each) for each in _NUMBER.findall(message)]
