"""How a student's answer is held against the expected one, and in which words the difference is told.

Both are plain, as they come out of the codec: no class of a student's own has a say in a comparison.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass
from typing import Any, Literal

import numpy as np

from nao_course.exercises.codec import register

Kind = Literal["right", "nothing", "type", "shape", "nan", "value"]
Array = np.ndarray[Any, Any]
_MOST_IN_LISTS = 2_000_000  # values of lists in lists, arrays in them included
_KINDS = {"b": "True and False", "i": "whole numbers", "u": "whole numbers", "f": "numbers with a point"}


@dataclass(frozen=True)
class Verdict:
    """What a comparison found.

    Parameters
    ----------
    kind : str
        "right", or in which way the answer differs.
    text : str
        For the student: what came out, never what was expected to.
    at : tuple of int
        Index of the first element of an array that differs; empty where there is none.
    """

    kind: Kind
    text: str = ""
    at: tuple[int, ...] = ()

    def __bool__(self) -> bool:
        """Whether the answer is right."""
        return self.kind == "right"


RIGHT = Verdict("right")


class Comparison(ABC):
    """How an exercise's answers are compared."""

    @abstractmethod
    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare an answer with the expected one."""

    def alike(self, answer: Any, got: Any) -> bool:
        """Whether an answer is the same wrong one as a mistake's."""
        return bool(self.compare(answer, got))


@register
@dataclass(frozen=True)
class Close(Comparison):
    """Numbers and arrays that agree within tolerances; tuples item by item.

    Parameters
    ----------
    rtol, atol : float
        As in numpy.isclose; loose enough for float32.
    period : float
        Where not 0, values are compared on a circle: 360 for hues in degrees, 2 pi for angles.
    allowed : float
        Fraction of an array's elements that may differ.
    names : tuple of str
        What the values of a tuple are called to the student: "your hue".
    """

    rtol: float = 1e-4
    atol: float = 1e-6
    period: float = 0.0
    allowed: float = 0.0
    names: tuple[str, ...] = ()

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare an answer with the expected one."""
        return _structure(expected, got, self._arrays, names=self.names)

    def _arrays(self, expected: Array, got: Array, where: str) -> Verdict:
        wanted, have = expected.astype(float), got.astype(float)
        misplaced = np.isnan(wanted) != np.isnan(have)
        if np.count_nonzero(misplaced) > self.allowed * wanted.size:
            at = tuple(int(i) for i in np.argwhere(misplaced)[0])
            what = (
                f"{where} is NaN{_at(at)}"
                if np.isnan(have[at])
                else f"{where} is not NaN{_at(at)} where it should be"
            )
            return Verdict("nan", what, at)
        with np.errstate(all="ignore"):
            difference = np.abs(have - wanted)
            if self.period:
                difference = np.abs((difference + self.period / 2) % self.period - self.period / 2)
            near = (difference <= self.atol + self.rtol * np.abs(wanted)) & np.isfinite(wanted)
        same = near | (have == wanted) | (np.isnan(wanted) & np.isnan(have))
        return _differences(~same, got, where, self.allowed)


@register
@dataclass(frozen=True)
class Exact(Comparison):
    """Whole numbers, booleans and text that are equal; of an array, all but a fraction of the elements.

    Parameters
    ----------
    allowed : float
        Fraction of an array's elements that may differ: 0 for masks, a little for labels.
    """

    allowed: float = 0.0

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare an answer with the expected one."""
        return _structure(expected, got, self._arrays)

    def _arrays(self, expected: Array, got: Array, where: str) -> Verdict:
        if expected.dtype.kind in "iu" and got.dtype.kind not in "iu":
            return Verdict("type", f"{where} holds {_KINDS[got.dtype.kind]}, not whole numbers")
        return _differences(expected != got, got, where, self.allowed)


@register
@dataclass(frozen=True)
class Points(Comparison):
    """Points in any order: each expected one has its own within a distance, and there is none besides.

    Parameters
    ----------
    tolerance : float
        Largest distance, in the points' unit.
    """

    tolerance: float = 1.0

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare (N, 2) points with the expected ones."""
        wanted = np.asarray(expected, dtype=float)
        have = _as_numbers(got, "your answer")
        if isinstance(have, Verdict):
            return have
        if have.ndim != 2 or have.shape[1] != wanted.shape[1]:
            columns = wanted.shape[1]
            text = (
                f"your answer has shape {have.shape}; N points have shape (N, {columns}), none (0, {columns})"
            )
            return Verdict("shape", text)
        if np.isnan(have).any():
            return Verdict("nan", "your answer has NaN in it")
        if len(have) != len(wanted):
            return Verdict("value", f"your answer has {len(have)} points, which is not the right number")
        from scipy.optimize import linear_sum_assignment  # takes long to import: workers start without it

        with np.errstate(all="ignore"):
            far = ~(np.linalg.norm(wanted[:, None] - have[None].astype(float), axis=2) <= self.tolerance)
        missed = int(
            far[linear_sum_assignment(far)].sum()
        )  # as few as can be: the best partners, not the nearest
        if missed:
            return Verdict("value", f"{missed} of your {len(have)} points are at no right place")
        return RIGHT

    def alike(self, answer: Any, got: Any) -> bool:
        """As above; a mistake's answer may be no points at all."""
        points = getattr(answer, "ndim", 0) == 2
        return bool((self if points else Close()).compare(answer, got))


@register
@dataclass(frozen=True)
class Between(Comparison):
    """A number that lies between two: for what is random, where the expected answer is (low, high)."""

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare a number with (low, high)."""
        low, high = expected
        number = _as_numbers(got, "your answer")
        if isinstance(number, Verdict):
            return number
        if number.shape != ():
            return Verdict("shape", f"your answer has shape {number.shape}; one number is wanted")
        if number.dtype.kind == "b":
            return Verdict("type", "your answer is True or False; a number is wanted")
        if np.isnan(number):
            return Verdict("nan", "your answer is NaN")
        if low <= number <= high:
            return RIGHT
        return Verdict("value", f"your answer, {float(number):.4g}, is off")

    def alike(self, answer: Any, got: Any) -> bool:
        """Whether a number is about the same: of a wrong one no interval is known."""
        return bool(Close(rtol=0.02).compare(answer, got))


def _structure(
    expected: Any,
    got: Any,
    arrays: Callable[[Array, Array, str], Verdict],
    where: str = "your answer",
    names: tuple[str, ...] = (),
) -> Verdict:
    """Walk through tuples, dicts and dataclasses down to arrays."""
    if got is None and expected is not None:
        return Verdict("nothing", f"{where} is None: a return may be missing")
    of_a_kind = expected is None or isinstance(expected, str | dict) or is_dataclass(expected)
    if of_a_kind and type(got) is not type(expected):
        return Verdict("type", f"{where} is {with_article(got)}; {with_article(expected)} is wanted")
    if expected is None:
        return RIGHT
    if isinstance(expected, str):
        return RIGHT if got == expected else Verdict("value", f"{where}, {got[:40]!r}, is another text")
    parts = _parts(expected)
    if parts is None:
        return _numbers(expected, got, arrays, where)
    if isinstance(got, np.ndarray) and got.shape[:1] == (len(parts),):
        got = tuple(got)
    have = _parts(got)
    if have is None or set(parts) != set(have):
        size = "" if have is None else f" of {len(have)}"
        wanted = "other keys" if isinstance(expected, dict) else f"{len(parts)} values"
        if names:
            wanted += f" ({', '.join(names)})"
        return Verdict("type", f"{where} is {with_article(got)}{size}; {wanted} are wanted")
    called = dict(zip(parts, names, strict=False))
    for name in parts:
        part = called.get(name, f"{name} of {where}")
        verdict = _structure(parts[name], have[name], arrays, part)
        if not verdict:
            return verdict
    return RIGHT


def _parts(value: Any) -> dict[str, Any] | None:
    """The values that a value is made of, by what they are called; None for numbers and arrays of them."""
    if isinstance(value, dict):
        return {f"[{key!r}]": each for key, each in value.items()}
    if is_dataclass(value):
        return {f".{each.name}": getattr(value, each.name) for each in fields(value)}
    if isinstance(value, tuple | list):
        return {f"value {i}": each for i, each in enumerate(value, start=1)}
    return None


def _numbers(expected: Any, got: Any, arrays: Callable[[Array, Array, str], Verdict], where: str) -> Verdict:
    """Compare arrays, or numbers, of the same kind and shape."""
    wanted, have = np.asarray(expected), _as_numbers(got, where)
    if isinstance(have, Verdict):
        return have
    if (wanted.dtype.kind == "b") != (have.dtype.kind == "b"):
        return Verdict("type", f"{where} holds {_KINDS[have.dtype.kind]}, not {_KINDS[wanted.dtype.kind]}")
    if wanted.shape != have.shape:
        return Verdict("shape", f"{where} has shape {have.shape}; shape {wanted.shape} is wanted")
    return arrays(wanted, have, where)


def _as_numbers(got: Any, where: str) -> Array | Verdict:
    """Turn an answer into an array of numbers, or say why it is none."""
    if got is None:
        return Verdict("nothing", f"{where} is None: a return may be missing")
    if isinstance(got, list | tuple) and (count := _how_many(got)) > _MOST_IN_LISTS:
        return Verdict(
            "type",
            f"{where} is {with_article(got)} of {count} values; return an array where there are so many",
        )
    try:
        if _only_numbers(got) and (array := np.asarray(got)).dtype.kind in _KINDS:
            return array
    except (ValueError, OverflowError):  # rows of different lengths
        return Verdict("type", f"{where} is {with_article(got)} whose rows do not fit together")
    return Verdict("type", f"{where} is {with_article(got)}, not numbers")


def _how_many(got: Any) -> int:
    """Count values: a row of one type among rows of a smaller one makes numpy widen them all."""
    if isinstance(got, list | tuple):
        return sum(map(_how_many, got))
    return got.size if isinstance(got, np.ndarray) else 1


def _only_numbers(got: Any) -> bool:
    """Whether there are numbers only: numpy would make room for the longest text of a list in each element."""
    if isinstance(got, list | tuple):
        return all(map(_only_numbers, got))
    return isinstance(got, bool | int | float | np.number | np.bool_ | np.ndarray)


def with_article(value: Any) -> str:
    """Name a value's type, with its article."""
    kind = type(value).__name__
    if value is None:
        return kind
    return f"an {kind}" if kind[0] in "aeiou" else f"a {kind}"


def _differences(wrong: Any, got: Array, where: str, allowed: float) -> Verdict:
    """Say how many elements are wrong, and show the first of them as the student has it."""
    count = int(np.count_nonzero(wrong))
    if count <= allowed * wrong.size:
        return RIGHT
    if got.shape == ():
        return Verdict("value", f"{where}, {as_text(got[()])}, is off")
    index = tuple(int(i) for i in np.argwhere(wrong)[0])
    share = f"{count} of {wrong.size} elements of {where} are off"
    return Verdict("value", f"{share}, the first at {list(index)}: you have {as_text(got[index])}", index)


def _at(index: tuple[int, ...]) -> str:
    return f" at {list(index)}" if index else ""


def as_text(value: Any) -> str:
    """Write a number as a student is told it."""
    return str(value) if isinstance(value, np.bool_) else f"{float(value):.6g}"
