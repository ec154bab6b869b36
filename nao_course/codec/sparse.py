"""Conversion of sparse matrices to plain arrays and back. SciPy is imported only if there is a sparse matrix.

The formats csr, csc and coo are kept, for arrays and for matrices; other formats are converted to csr. Duplicate
entries are summed and the indices are sorted, so that a solver that sorts them in place changes nothing.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.codec.format import CodecError

MOST_SIDE = 10**6  # rows, or columns
_COMPRESSED = ("csr", "csc")
_KINDS = tuple(f"{form}_{kind}" for form in (*_COMPRESSED, "coo") for kind in ("array", "matrix"))

Array = npt.NDArray[Any]


@dataclass(frozen=True)
class Parts:
    """The arrays of a sparse matrix: data, indices and indptr of csr and csc, or data, rows and columns of coo.

    `kind` is SciPy's class, such as "csr_array".
    """

    kind: str
    shape: tuple[int, int]
    arrays: tuple[Array, Array, Array]


def is_sparse(kind: type) -> bool:
    """Return whether a class is one of SciPy's sparse matrices or a subclass; False if SciPy was never imported."""
    module = sys.modules.get("scipy.sparse")
    # The names may be missing while another thread imports the module.
    bases = (getattr(module, name, None) for name in ("spmatrix", "sparray"))
    return issubclass(kind, tuple(base for base in bases if base is not None))


def taken_apart(item: Any, most: int) -> Parts:
    """Convert a two-dimensional sparse matrix to its arrays; raise a CodecError if invalid or over `most` bytes."""
    base: Any = next(each for each in type(item).__mro__ if each.__module__.startswith("scipy.sparse"))
    _refuse_shape(item.shape)
    _refuse_size(item, most)
    if base.__name__ not in _KINDS:
        item = base.tocsr(item)
        base = type(item)
        _refuse_size(item, most)
    arrays = (
        item.data,
        *((item.row, item.col) if base.__name__.startswith("coo") else (item.indices, item.indptr)),
    )
    plain = tuple(np.asarray(each) for each in arrays)
    if sum(each.nbytes for each in plain) > most:
        raise CodecError("a sparse matrix that is too large")
    return _apart(put_together(base.__name__, list(item.shape), plain), base.__name__)


def put_together(kind: str, shape: Sequence[object], arrays: Sequence[Array]) -> Any:
    """Make a sparse matrix from arrays, which may come from untrusted code.

    Raise a CodecError if they do not describe one, for example if an index is out of range.
    """
    _refuse_shape(shape)
    if kind not in _KINDS or len(arrays) != 3 or any(each.ndim != 1 for each in arrays):
        raise CodecError("not a sparse matrix")
    data, one, other = arrays
    if data.dtype.kind not in "biufc" or any(each.dtype.kind not in "iu" for each in (one, other)):
        raise CodecError("not a sparse matrix")
    rows, columns = (int(size) for size in shape)  # type: ignore[call-overload]
    if data.dtype == np.float16:  # because SciPy has no sparse matrices of this type
        data = data.astype(np.float32)
    if kind.startswith("coo"):
        _refuse_indices(one, rows, len(data))
        _refuse_indices(other, columns, len(data))
        content: Any = (data, (one, other))
    else:
        across, along = (columns, rows) if kind.startswith("csr") else (rows, columns)
        _refuse_indices(one, across, len(data))
        _refuse_pointers(other, along, len(data))
        content = (data, one, other)
    from scipy import sparse  # takes long to import

    matrix = getattr(sparse, kind)(content, shape=(rows, columns), copy=True)
    matrix.sum_duplicates()
    return matrix


def _apart(matrix: Any, kind: str) -> Parts:
    """Return the parts of a matrix, with indices of the same integer type on every machine."""
    places = (matrix.row, matrix.col) if kind.startswith("coo") else (matrix.indices, matrix.indptr)
    first, second = (np.asarray(each, dtype=np.int32) for each in places)
    return Parts(kind, matrix.shape, (matrix.data, first, second))


def _refuse_shape(shape: Sequence[object]) -> None:
    if len(shape) != 2 or not all(
        isinstance(size, int | np.integer) and 0 <= size <= MOST_SIDE for size in shape
    ):
        raise CodecError(f"a sparse matrix has two dimensions, of {MOST_SIDE} at most")


def _refuse_size(item: Any, most: int) -> None:
    if 16 * int(item.nnz) > most:
        raise CodecError("a sparse matrix that is too large")


def _refuse_indices(indices: Array, size: int, count: int) -> None:
    if len(indices) != count or (count and not 0 <= int(indices.min()) <= int(indices.max()) < size):
        raise CodecError("a sparse matrix with an index out of range")


def _refuse_pointers(pointers: Array, size: int, count: int) -> None:
    pointers = pointers.astype(np.int64)
    ends = len(pointers) == size + 1 and pointers[0] == 0 and pointers[-1] == count
    if not ends or (np.diff(pointers) < 0).any():
        raise CodecError("a sparse matrix whose row pointers are not valid")
