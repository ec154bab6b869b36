"""Large sparse matrices that cannot be converted to dense ones, for drivers of code that must keep them sparse."""

from __future__ import annotations

from typing import Any

import scipy.sparse

MOST_DENSE = 1000  # variables: a dense matrix of more has 8 MB and more


class _TooLarge:
    """A sparse matrix that raises an error instead of filling the memory with a dense copy.

    Slices and solutions have the same class, but a few rows or columns can be made dense.
    """

    def toarray(self, *args: Any, **kwargs: Any) -> Any:
        """Return a dense array; raise an error if both sides are long."""
        rows, columns = self.shape  # type: ignore[attr-defined]
        if min(rows, columns) > MOST_DENSE:
            raise MemoryError(
                f"as a dense array this matrix has {rows} x {columns} numbers, most of them 0: leave it sparse"
            )
        return super().toarray(*args, **kwargs)  # type: ignore[misc]

    def todense(self, *args: Any, **kwargs: Any) -> Any:
        """Return a dense matrix; raise an error like `toarray`."""
        return self.toarray(*args, **kwargs)


class _LargeArray(_TooLarge, scipy.sparse.csc_array):  # type: ignore[misc]  # scipy has no types
    """The same for SciPy's sparse arrays."""


def without_dense(matrix: Any) -> Any:
    """Return a large sparse matrix that cannot be made dense; return any other value unchanged."""
    is_large = scipy.sparse.issparse(matrix) and matrix.shape[0] > MOST_DENSE
    return _LargeArray(matrix) if is_large else matrix
