"""Drivers that require residuals to be arrays, and that keep a large matrix from being made dense or inverted."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable
from typing import Any

from nao_course.exercises import register_driver
from nao_course.exercises.comparisons.large_sparse import MOST_DENSE, without_dense

MOST_HELD = 0.5  # part of n x n numbers: a few columns are a hundredth, the whole inverse is 1


class WholeMatrixError(MemoryError):
    """Raised if a function holds as many numbers at a time as the whole dense matrix."""


@register_driver
def blocks_of_inverse(function: Callable[..., Any], information: Any, indices: list[Any]) -> Any:
    """Call ``function(H, indices)`` with an H (N, N) that cannot be made dense if it is large.

    Raise a WholeMatrixError if H is large and the function held N x N numbers at a time, as the whole inverse does.
    """
    size = information.shape[0]
    if size <= MOST_DENSE:
        return function(information, indices)
    tracemalloc.start()
    try:
        tracemalloc.reset_peak()
        before = tracemalloc.get_traced_memory()[0]
        blocks = function(without_dense(information), indices)
        held = tracemalloc.get_traced_memory()[1] - before
    finally:
        tracemalloc.stop()
    if held > MOST_HELD * 8 * size**2:
        raise WholeMatrixError(
            f"your function held {held / 8e6:.1f} million numbers at a time: the whole inverse has {size} x {size}; "
            "the blocks need a few columns of it"
        )
    return blocks


@register_driver
def as_array(function: Callable[..., Any], *pair: Any) -> Any:
    """Call a residual with its three arguments and refuse a list, because `linearize` computes with the answer."""
    answer = function(*pair)
    if isinstance(answer, list | tuple):
        raise TypeError(
            f"the answer is a {type(answer).__name__}: make it one array, as np.array([...]).T does"
        )
    return answer
