"""How a student's answer is held against the expected one, and in which words the difference is told."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from nao_course.exercises.codec import register

Kind = Literal["right", "nothing", "type", "shape", "nan", "value"]


@dataclass(frozen=True)
class Verdict:
    """What a comparison found.

    Parameters
    ----------
    kind : str
        "right", or in which way the answer differs.
    text : str
        For the student: what came out, never what was expected to.
    """

    kind: Kind
    text: str = ""

    def __bool__(self) -> bool:
        """Whether the answer is right."""
        return self.kind == "right"


RIGHT = Verdict("right")


@register
@dataclass(frozen=True)
class Close:
    """Numbers and arrays that agree within tolerances; tuples item by item.

    Parameters
    ----------
    rtol, atol : float
        As in numpy.isclose; loose enough for float32.
    period : float
        Where not 0, values are compared on a circle: 360 for hues in degrees, 2 pi for angles.
    allowed : float
        Fraction of an array's elements that may differ.
    """

    rtol: float = 1e-4
    atol: float = 1e-6
    period: float = 0.0
    allowed: float = 0.0

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare an answer with the expected one."""
        return _structure(expected, got, self._arrays)

    def _arrays(self, expected: np.ndarray[Any, Any], got: np.ndarray[Any, Any], where: str) -> Verdict:
        both_nan = np.isnan(expected) & np.isnan(got)
        if (np.isnan(expected) != np.isnan(got)).mean() > self.allowed:
            return Verdict("nan", f"{where} is NaN where it should not be, or is not where it should be")
        difference = np.abs(got - expected)
        if self.period:
            difference = np.abs((difference + self.period / 2) % self.period - self.period / 2)
        with np.errstate(invalid="ignore"):
            wrong = ~(difference <= self.atol + self.rtol * np.abs(expected)) & ~both_nan & (got != expected)
        return _differences(wrong, got, where, self.allowed)


@register
@dataclass(frozen=True)
class Exact:
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

    def _arrays(self, expected: np.ndarray[Any, Any], got: np.ndarray[Any, Any], where: str) -> Verdict:
        return _differences(expected != got, got, where, self.allowed)


@register
@dataclass(frozen=True)
class Points:
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
        verdict = _as_numbers(got, "your answer")
        if isinstance(verdict, Verdict):
            return verdict
        if verdict.ndim != 2 or verdict.shape[1:] != wanted.shape[1:]:
            return Verdict(
                "shape", f"your answer has shape {verdict.shape}; points have shape (N, {wanted.shape[1]})"
            )
        if np.isnan(verdict).any():
            return Verdict("nan", "your answer has NaN in it")
        if len(verdict) != len(wanted):
            return Verdict("value", f"your answer has {len(verdict)} points, which is not the right number")
        from scipy.optimize import linear_sum_assignment  # half a second, which a worker can do without

        away = np.linalg.norm(wanted[:, None] - verdict[None], axis=2)
        rows, columns = linear_sum_assignment(np.minimum(away, 1e9))
        far = int((away[rows, columns] > self.tolerance).sum())
        return (
            Verdict("value", f"{far} of your {len(verdict)} points are at no right place") if far else RIGHT
        )


@register
@dataclass(frozen=True)
class Between:
    """A number that lies between two: for what is random, where the expected answer is (low, high)."""

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare a number with (low, high)."""
        low, high = expected
        number = _as_numbers(got, "your answer")
        if isinstance(number, Verdict):
            return number
        if number.shape != ():
            return Verdict("shape", f"your answer has shape {number.shape}; one number is wanted")
        if np.isnan(number):
            return Verdict("nan", "your answer is NaN")
        return (
            RIGHT
            if low <= float(number) <= high
            else Verdict("value", f"your answer, {float(number):.4g}, is off")
        )


Comparison = Close | Exact | Points | Between


def _structure(expected: Any, got: Any, arrays: Any, where: str = "your answer") -> Verdict:
    """Walk through tuples down to arrays."""
    if got is None:
        return (
            Verdict("right")
            if expected is None
            else Verdict("nothing", f"{where} is None: is a return missing?")
        )
    if isinstance(expected, tuple | list):
        if not isinstance(got, tuple | list) or len(got) != len(expected):
            size = f" of {len(got)}" if isinstance(got, tuple | list) else ""
            return Verdict(
                "type", f"{where} is a {type(got).__name__}{size}; {len(expected)} values are wanted"
            )
        for i, (one, other) in enumerate(zip(expected, got, strict=True)):
            verdict = _structure(one, other, arrays, f"value {i + 1} of your answer")
            if not verdict:
                return verdict
        return RIGHT
    if isinstance(expected, str):
        return RIGHT if expected == got else Verdict("value", f"{where} is another text")
    if expected is None:
        return Verdict("type", f"{where} is a {type(got).__name__}; None is wanted")
    wanted = np.asarray(expected)
    numbers = _as_numbers(got, where)
    if isinstance(numbers, Verdict):
        return numbers
    if (wanted.dtype.kind == "b") != (numbers.dtype.kind == "b"):
        kinds = {
            "b": "True and False",
            "i": "whole numbers",
            "u": "whole numbers",
            "f": "numbers with a point",
        }
        return Verdict(
            "type",
            f"{where} holds {kinds.get(numbers.dtype.kind, str(numbers.dtype))}, not "
            f"{kinds.get(wanted.dtype.kind, str(wanted.dtype))}",
        )
    if wanted.shape != numbers.shape:
        return Verdict("shape", f"{where} has shape {numbers.shape}; shape {wanted.shape} is wanted")
    if wanted.dtype.kind == "b":
        wrong = wanted != numbers
        return RIGHT if not wrong.any() else arrays(wanted.astype(float), numbers.astype(float), where)
    return arrays(wanted.astype(float), numbers.astype(float), where)


def _as_numbers(got: Any, where: str) -> np.ndarray[Any, Any] | Verdict:
    """Turn an answer into an array of numbers, or say why it is none."""
    if got is None:
        return Verdict("nothing", f"{where} is None: is a return missing?")
    try:
        array = np.array(got)
    except (ValueError, TypeError):
        return Verdict("type", f"{where} is a {type(got).__name__}, not numbers")
    if array.dtype.kind not in "biuf":
        return Verdict("type", f"{where} is a {type(got).__name__}, not numbers")
    return array


def _differences(wrong: Any, got: np.ndarray[Any, Any], where: str, allowed: float) -> Verdict:
    """Say how many elements are wrong, and show the first of them as the student has it."""
    count = int(np.count_nonzero(wrong))
    if count <= allowed * max(wrong.size, 1):
        return RIGHT
    if got.shape == ():
        return Verdict("value", f"{where}, {float(got):.6g}, is off")
    index = tuple(int(i) for i in np.argwhere(wrong)[0])
    share = f"{count} of {wrong.size} elements of {where} are off"
    return Verdict("value", f"{share}, the first at {list(index)}: you have {float(got[index]):.6g}")
