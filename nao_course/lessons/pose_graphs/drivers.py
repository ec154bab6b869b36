"""How marginal_covariances is called: a large matrix stays sparse."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from nao_course.exercises import register_driver
from nao_course.exercises.comparisons.large_sparse import without_dense


@register_driver
def blocks_of_inverse(function: Callable[..., Any], information: Any, indices: list[Any]) -> Any:
    """Call ``function(H, indices)`` with an H that refuses to be made dense where it is large.

    Parameters
    ----------
    function : callable
        Returns a list of blocks, one for each of the indices.
    information : sparse matrix, shape (N, N)
        H, positive definite.
    indices : list of ndarray of int
        Rows and columns of each block.

    Returns
    -------
    object
        What it returned.
    """
    return function(without_dense(information), indices)
