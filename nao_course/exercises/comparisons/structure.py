"""Traversal of tuples, dicts and dataclasses down to the numbers that a comparison compares."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from nao_course._internal.counts import say_count
from nao_course.codec.sparse import is_sparse
from nao_course.exercises.comparisons.comparison import RIGHT, Verdict, as_text, with_article

Array = np.ndarray[Any, Any]
Mask = Literal["", "upper", "lower", "diagonal"] | tuple[Any, ...]
Numbers = float | tuple[float, ...]
MOST_IN_LISTS = 2_000_000  # largest number of values in nested lists, including their arrays
KINDS = {
    "b": "True and False",
    "i": "whole numbers",
    "u": "whole numbers",
    "f": "floating-point numbers",
    "c": "complex numbers",
}

_COMPLEX = (
    ": since NumPy 2.5, np.linalg.eig returns them for every matrix. Use np.linalg.eigh for a symmetric one, or take "
    ".real"
)


@dataclass(frozen=True)
class Elements:
    """Corresponding elements of two arrays, or the elements that are stored in one of two sparse matrices.

    `where` is the name of the answer, or of its part, in messages, `shape` the whole array's; `rows` and `columns` are
    the index of each element in the last two axes, if it does not follow from the shape. The numbers of a tuple or
    dataclass are columns, `width` many.
    """

    wanted: Array
    have: Array
    where: str
    shape: tuple[int, ...]
    rows: Array | None = None
    columns: Array | None = None
    width: int = 1
    names: tuple[str, ...] = ()

    @property
    def row(self) -> Array | None:
        """Index of each element in the last axis but one, to be broadcast; None without such an axis."""
        if self.rows is None and len(self.shape) > 1:
            return np.arange(self.shape[-2])[:, None]
        return self.rows

    @property
    def column(self) -> Array | None:
        """Index of each element in the last axis, to be broadcast; None without such an axis."""
        if self.columns is None and self.shape:
            return np.arange(self.shape[-1])
        return self.columns

    def of_column(self, values: Numbers, name: str) -> Any:
        """Return one value for all elements, or each column's value; a tuple is repeated along the last axis.

        Raise a ValueError if the number of columns is not a multiple of the number of values.
        """
        if not isinstance(values, tuple):
            return values
        column = self.column
        if column is None or not values or self.width % len(values):
            raise ValueError(
                f"{name} has {len(values)} values; the last axis of {self.where} has {self.width}"
            )
        return np.asarray(values)[column % len(values)]

    def counted(self, mask: Mask) -> npt.NDArray[np.bool_] | np.bool_:
        """Return which elements count, to be broadcast."""
        if not mask:
            return np.True_
        everywhere = np.ones(self.wanted.shape, dtype=bool)
        if isinstance(mask, tuple):
            given = np.broadcast_to(np.asarray(mask, dtype=bool), self.shape)
            return given[self.row, self.column] if self.wanted.shape != self.shape else given
        row, column = self.row, self.column
        if row is None or column is None:
            return everywhere
        sides = {"upper": row <= column, "lower": row >= column, "diagonal": row == column}
        if mask not in sides:
            raise ValueError(f"mask must be one of {list(sides)} or a tuple of True and False, got {mask!r}")
        return everywhere & sides[mask]

    def place(self, index: npt.NDArray[np.intp]) -> tuple[int, ...]:
        """Return the index of an element in the whole array."""
        if self.wanted.shape == self.shape:
            return tuple(int(i) for i in index)
        assert self.rows is not None and self.columns is not None  # element of a sparse matrix
        return int(self.rows[index[0]]), int(self.columns[index[0]])

    def first(self, wrong: npt.NDArray[np.bool_]) -> tuple[tuple[int, ...], Any, str]:
        """Return index, value and name of the first selected element of the student's array."""
        index = np.argwhere(wrong)[0]
        at = self.place(index)
        named = self.names and at and self.width % len(self.names) == 0
        name = f" ({self.names[at[-1] % len(self.names)]})" if named else ""
        return at, self.have[tuple(index)], name

    def differences(self, wrong: Any, allowed: float = 0.0, size: int | None = None) -> Verdict:
        """Return how many elements are wrong as text, with the student's value of the first one.

        A fraction `allowed` may be wrong; `size` is the number of all elements, if not all of them count.
        """
        count = int(np.count_nonzero(wrong))
        size = int(np.prod(self.shape, dtype=np.int64)) if size is None else size
        if count <= allowed * size:
            return RIGHT
        at, value, name = self.first(np.asarray(wrong))
        if self.shape == ():
            return Verdict("value", f"{self.where} is {as_text(value)}, which is not right")
        verb = "is" if count == 1 else "are"
        share = f"{count} of {say_count(size, 'element')} of {self.where} {verb} wrong"
        return Verdict("value", f"{share}, the first at {list(at)}{name}: you have {as_text(value)}", at)


Compare = Callable[[Elements], Verdict]


def compare_structure(
    expected: Any, got: Any, compare: Compare, where: str = "your answer", names: tuple[str, ...] = ()
) -> Verdict:
    """Compare tuples, lists, dicts and dataclasses down to their numbers and arrays.

    The values are as decoded by the codec. `compare` compares the elements of arrays of the same shape and kind; a
    number is an array without axes. `where` is the name of the answer in messages, and `names` are the names of a
    tuple's values, or of an array's columns.
    """
    if got is None and expected is not None:
        return Verdict("nothing", f"{where} is None: a return may be missing")
    of_a_kind = expected is None or isinstance(expected, str | bytes | dict) or is_dataclass(expected)
    if of_a_kind and type(got) is not type(expected):
        return Verdict("type", f"{where} is {with_article(got)}; expected {with_article(expected)}")
    if expected is None:
        return RIGHT
    if isinstance(expected, str | bytes):
        return (
            RIGHT if got == expected else Verdict("value", f"{where}, {got[:40]!r}, is not the expected text")
        )
    if callable(expected):
        return RIGHT if got is expected else Verdict("value", f"{where} is not the expected function")
    parts = parts_of(expected)
    if parts is None:
        elements = _elements(expected, got, where, names)
        return elements if isinstance(elements, Verdict) else compare(elements)
    return _compare_parts(expected, parts, got, compare, where, names)


def _compare_parts(
    expected: Any, parts: dict[str, Any], got: Any, compare: Compare, where: str, names: tuple[str, ...]
) -> Verdict:
    if isinstance(got, np.ndarray) and got.shape[:1] == (len(parts),):
        got = tuple(got)
    have = parts_of(got)
    if have is None or set(parts) != set(have):
        size = "" if have is None else f" of {len(have)}"
        wanted = "other keys" if isinstance(expected, dict) else f"{len(parts)} values"
        if names:
            wanted += f" ({', '.join(names)})"
        return Verdict("type", f"{where} is {with_article(got)}{size}; expected {wanted}")
    called = dict(zip(parts, names, strict=False))
    numbers = [name for name, part in parts.items() if _is_number(part)]
    for name in parts:
        part = called.get(name, f"{name} of {where}")
        one = _as_column(compare, numbers.index(name), len(numbers)) if name in numbers else compare
        verdict = compare_structure(parts[name], have[name], one, part)
        if not verdict:
            return verdict
    return RIGHT


def parts_of(value: Any) -> dict[str, Any] | None:
    """Return the parts of a value by name; None for numbers and arrays of numbers."""
    if isinstance(value, dict):
        return {f"[{key!r}]": each for key, each in value.items()}
    if is_dataclass(value):
        return {f".{each.name}": getattr(value, each.name) for each in fields(value)}
    if isinstance(value, tuple | list):
        return {f"value {i}": each for i, each in enumerate(value, start=1)}
    return None


def _is_number(value: Any) -> bool:
    return isinstance(value, bool | int | float | complex | np.number | np.bool_)


def _as_column(compare: Compare, column: int, width: int) -> Compare:
    """Compare a number as a column of a row of numbers."""

    def one(elements: Elements) -> Verdict:
        return compare(
            Elements(
                elements.wanted, elements.have, elements.where, (), columns=np.array(column), width=width
            )
        )

    return one


def _elements(expected: Any, got: Any, where: str, names: tuple[str, ...]) -> Elements | Verdict:
    """Pair the elements of numbers, arrays or sparse matrices that have the same kind and shape."""
    sparse = is_sparse(type(expected))
    if sparse and not is_sparse(type(got)):
        return Verdict("type", f"{where} is {with_article(got)}; expected a sparse matrix")
    wanted, have = (expected, got) if sparse else (np.asarray(expected), as_numbers(got, where, "c"))
    if isinstance(have, Verdict):
        return have
    kinds = wanted.dtype.kind, have.dtype.kind
    if (kinds[0] == "b") != (kinds[1] == "b") or (kinds[1] == "c" and kinds[0] != "c"):
        hint = _COMPLEX * (kinds[1] == "c")
        return Verdict("type", f"{where} holds {KINDS[kinds[1]]}, not {KINDS[kinds[0]]}{hint}")
    if wanted.shape != have.shape:
        return Verdict("shape", f"{where} has shape {have.shape}; expected shape {wanted.shape}")
    return _stored(wanted, have, where, names) if sparse else _dense(wanted, have, where, names)


def _dense(wanted: Array, have: Array, where: str, names: tuple[str, ...]) -> Elements:
    shape = wanted.shape
    return Elements(wanted, have, where, shape, width=shape[-1] if shape else 1, names=names)


def _stored(wanted: Any, have: Any, where: str, names: tuple[str, ...]) -> Elements:
    """Return the elements that are stored in one of two sparse matrices; the others are zero in both."""
    one, other = wanted.tocoo(), have.tocoo()
    width = int(one.shape[1])
    keys = np.concatenate([each.row.astype(np.int64) * width + each.col for each in (one, other)])
    places, at = np.unique(keys, return_inverse=True)
    values, others = np.zeros(len(places), one.dtype), np.zeros(len(places), other.dtype)
    np.add.at(values, at[: one.nnz], one.data)
    np.add.at(others, at[one.nnz :], other.data)
    row, column = places // max(width, 1), places % max(width, 1)
    return Elements(values, others, where, tuple(one.shape), row, column, width, names)


def as_numbers(got: Any, where: str, also: str = "") -> Array | Verdict:
    """Convert an answer to an array of numbers, or return why that is not possible.

    `where` is its name in messages; complex numbers are allowed if `also` is "c".
    """
    if got is None:
        return Verdict("nothing", f"{where} is None: a return may be missing")
    if isinstance(got, list | tuple) and (count := _how_many(got)) > MOST_IN_LISTS:
        return Verdict(
            "type", f"{where} is {with_article(got)} of {count} values; return an array if there are so many"
        )
    try:
        if _only_numbers(got) and (array := np.asarray(got)).dtype.kind in "biuf" + also:
            return array
    except (ValueError, OverflowError):  # rows of different lengths
        return Verdict("type", f"{where} is {with_article(got)} whose rows do not fit together")
    return Verdict("type", f"{where} is {with_article(got)}, not numbers")


def _how_many(got: Any) -> int:
    """Count the values of nested lists, because NumPy would convert all of them to the largest type."""
    if isinstance(got, list | tuple):
        return sum(map(_how_many, got))
    return got.size if isinstance(got, np.ndarray) else 1


def _only_numbers(got: Any) -> bool:
    """Return whether there are only numbers, because NumPy would reserve the longest text's size for each element."""
    if isinstance(got, list | tuple):
        return all(map(_only_numbers, got))
    return _is_number(got) or isinstance(got, np.ndarray)
