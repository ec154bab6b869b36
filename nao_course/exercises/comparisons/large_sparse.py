"""Large sparse matrices that refuse to be made dense: what a driver hands to code that must keep them sparse."""

from __future__ import annotations

from typing import Any

import scipy.sparse

MOST_DENSE = 1000  # variables: a dense matrix of more has 8 MB and more


class _TooLarge:
    """A sparse matrix that refuses to be made dense, so that no computer's memory is filled by trying.

    What is cut out of it, or solved with it, is of its class: a few rows or columns are made dense as ever.
    """

    def toarray(self, *args: Any, **kwargs: Any) -> Any:
        """Refuse, where both sides are long."""
        rows, columns = self.shape  # type: ignore[attr-defined]
        if min(rows, columns) > MOST_DENSE:
            raise MemoryError(
                f"as a dense array this matrix has {rows} x {columns} numbers, most of them 0: leave it sparse"
            )
        return super().toarray(*args, **kwargs)  # type: ignore[misc]

    def todense(self, *args: Any, **kwargs: Any) -> Any:
        """The same."""
        return self.toarray(*args, **kwargs)


class _LargeArray(_TooLarge, scipy.sparse.csc_array):  # type: ignore[misc]  # scipy has no types
    """The same as an array of scipy's."""


def without_dense(matrix: Any) -> Any:
    """Return a sparse matrix that refuses to be made dense where it is large; whatever else as it is."""
    is_large = scipy.sparse.issparse(matrix) and matrix.shape[0] > MOST_DENSE
    return _LargeArray(matrix) if is_large else matrix
