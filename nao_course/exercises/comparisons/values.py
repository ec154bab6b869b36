"""Compare a student's numbers with the expected numbers: close, exact, points in any order, within bounds.

Both are plain values, as decoded by the codec, so that a student's own class cannot influence a comparison.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course._internal.counts import say_count
from nao_course.codec import register
from nao_course.exercises.case import Case
from nao_course.exercises.comparisons.comparison import RIGHT, Comparison, Verdict
from nao_course.exercises.comparisons.structure import (
    KINDS,
    Array,
    Elements,
    Mask,
    Numbers,
    as_numbers,
    compare_structure,
)

_NEARLY = 20.0  # times the tolerances: a wrong answer within this distance was probably rounded
_OTHER = Verdict("value")
_FINE = 0.01  # relative tolerance; coarser tolerances are for random answers


@register
@dataclass(frozen=True)
class Close(Comparison):
    """Comparison of numbers and arrays within tolerances; tuples, dicts and dataclasses are compared item by item.

    Parameters
    ----------
    rtol, atol : float or tuple of float
        Tolerances as in numpy.isclose, which are coarse enough for float32. A tuple has a value for each column and is
        repeated along the last axis: (bearing, range) for measurements (N, 2) and vectors (2 N,). The numbers of a
        tuple or dataclass are columns.
    period : float or tuple of float
        Period of values on a circle: 360 for hues in degrees, 2 pi for angles; 0 for other values.
    allowed : float
        Fraction of an array's elements that may differ.
    names : tuple of str
        Names of the values of a tuple, or of the columns of an array, in messages: "your hue".
    mask : str or tuple
        Elements that are compared: "upper", "lower" or "diagonal" of matrices, or tuples of True and False.
    """

    rtol: Numbers = 1e-4
    atol: Numbers = 1e-6
    period: Numbers = 0.0
    allowed: float = 0.0
    names: tuple[str, ...] = ()
    mask: Mask = ""

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare an answer with the expected one.

        Raises
        ------
        ValueError
            If the tolerances or the mask do not fit the expected answer.
        """
        return compare_structure(expected, got, self._elements, names=self.names)

    def alike(self, answer: Any, got: Any) -> bool:
        """Return whether an answer is a mistake's, whose shape may differ from the shape of the tolerances.

        It does not call `compare`, because it describes no difference: there are hundreds of mistakes and their pairs.
        """
        try:
            return bool(compare_structure(answer, got, self._alike, names=self.names))
        except ValueError:
            return bool(compare_structure(answer, got, Close()._alike))

    def _alike(self, elements: Elements) -> Verdict:
        """Compare elements without describing what is wrong."""
        return self._elements(elements, describe=False)

    def _elements(self, elements: Elements, *, describe: bool = True) -> Verdict:
        kind = complex if elements.wanted.dtype.kind == "c" else float
        wanted, have = elements.wanted.astype(kind, copy=False), elements.have.astype(kind, copy=False)
        counted = elements.counted(self.mask)
        size = int(np.count_nonzero(counted)) if self.mask else math.prod(elements.shape)
        wrong = self._wrong(elements, wanted, have) & counted  # also where only one of both is NaN
        if np.count_nonzero(wrong) <= self.allowed * size:
            return RIGHT
        if not describe:
            return _OTHER
        misplaced = (np.isnan(wanted) != np.isnan(have)) & counted
        if np.count_nonzero(misplaced) > self.allowed * size:
            at, value, name = elements.first(misplaced)
            place = f" at {list(at)}{name}" if at else ""
            rest = "" if np.isnan(value) else " where it should be"
            return Verdict("nan", f"{elements.where} is {'' if not rest else 'not '}NaN{place}{rest}", at)
        verdict = elements.differences(wrong, self.allowed, size)
        tolerance = self._say_tolerance()
        if not tolerance or (self._wrong(elements, wanted, have, _NEARLY) & counted).any():
            return verdict
        return replace(verdict, text=f"{verdict.text}; it is close, but must be right within {tolerance}")

    def _say_tolerance(self) -> str:
        """Return the tolerance in words if it is one small number; otherwise an empty text."""
        if isinstance(self.rtol, tuple) or isinstance(self.atol, tuple) or self.rtol > _FINE:
            return ""
        return f"{100 * self.rtol:g} %" if self.rtol else f"{self.atol:g}"

    def _wrong(self, elements: Elements, wanted: Array, have: Array, times: float = 1.0) -> Any:
        """Return which elements are neither equal nor within a multiple of the tolerances."""
        near = self._near(elements, wanted, have, times)
        return ~(near | (have == wanted) | (np.isnan(wanted) & np.isnan(have)))

    def _near(self, elements: Elements, wanted: Array, have: Array, times: float) -> Any:
        """Return which elements are finite and within a multiple of the tolerances."""
        rtol, atol = elements.of_column(self.rtol, "rtol"), elements.of_column(self.atol, "atol")
        with np.errstate(all="ignore"):
            difference = np.abs(have - wanted)
            if self.period != 0.0:
                period = np.asarray(elements.of_column(self.period, "period"), dtype=float)
                whole = np.where(period > 0, period, 1.0)
                wrapped = np.abs((difference + whole / 2) % whole - whole / 2)
                difference = np.where(period > 0, wrapped, difference)
            return (difference <= times * (atol + rtol * np.abs(wanted))) & np.isfinite(wanted)


@register
@dataclass(frozen=True)
class Exact(Comparison):
    """Comparison of integers, booleans and texts for equality; a fraction of an array's elements may differ.

    Parameters
    ----------
    allowed : float
        Fraction of an array's elements that may differ: 0 for masks, a little for labels.
    mask : str or tuple
        As in Close.
    """

    allowed: float = 0.0
    mask: Mask = ""

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare an answer with the expected one."""
        return compare_structure(expected, got, self._elements)

    def alike(self, answer: Any, got: Any) -> bool:
        """Return whether an answer is a mistake's, whose shape may differ from the shape of the mask."""
        try:
            return bool(self.compare(answer, got))
        except ValueError:
            return bool(Exact().compare(answer, got))

    def _elements(self, elements: Elements) -> Verdict:
        wanted, have = elements.wanted, elements.have
        if wanted.dtype.kind in "iu" and have.dtype.kind not in "iu":
            held = f"{elements.where} holds {KINDS[have.dtype.kind]} (dtype {have.dtype}), not whole numbers"
            return Verdict(
                "type", f"{held}: give the dtype where you make the array, as in np.zeros(shape, dtype=int)"
            )
        counted = elements.counted(self.mask)
        size = int(np.count_nonzero(counted)) if self.mask else None
        return elements.differences((wanted != have) & counted, self.allowed, size)


_NOWHERE = 1e9  # replaces a coordinate that is NaN, because it is far from every other coordinate


@register
@dataclass(frozen=True)
class Points(Comparison):
    """Comparison of points in any order, with exactly one point within a distance of each expected point.

    Parameters
    ----------
    tolerance : float
        Largest distance, in the points' unit.
    """

    tolerance: float = 1.0

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare (N, 2) points with the expected ones."""
        wanted = np.asarray(expected, dtype=float)
        have = as_numbers(got, "your answer")
        if isinstance(have, Verdict):
            return have
        if have.ndim != 2 or have.shape[1] != wanted.shape[1]:
            columns = wanted.shape[1]
            expected_shape = f"(N, {columns}) for N points, or (0, {columns}) without points"
            text = f"your answer has shape {have.shape}; expected {expected_shape}"
            return Verdict("shape", text)
        if np.isnan(have).any():
            return Verdict("nan", "your answer contains NaN")
        if len(have) != len(wanted):
            points = say_count(len(have), "point")
            return Verdict("value", f"your answer has {points}, which is not the right number")
        with np.errstate(all="ignore"):
            near = np.linalg.norm(wanted[:, None] - have[None].astype(float), axis=2) <= self.tolerance
        missed = len(have) - most_pairs(near)
        if missed:
            if len(have) == 1:
                return Verdict("value", "your point is in the wrong place")
            points = f"{len(have)} points {'is' if missed == 1 else 'are'}"
            return Verdict("value", f"{missed} of your {points} in the wrong place")
        return RIGHT

    def alike(self, answer: Any, got: Any) -> bool:
        """Return whether an answer is a mistake's, which may not be points at all or may contain NaN."""
        if getattr(answer, "ndim", 0) != 2 or getattr(got, "dtype", np.dtype(object)).kind not in "iuf":
            return bool(Close().compare(answer, got))
        return bool(
            self.compare(*(np.nan_to_num(np.asarray(each, float), nan=_NOWHERE) for each in (answer, got)))
        )


@register
@dataclass(frozen=True)
class Between(Comparison):
    """Comparison of random numbers with an interval, ``expected=(low, high)`` of a case; numbers or arrays."""

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare a number, or an array, with (low, high)."""
        low, high = (np.asarray(each, dtype=float) for each in expected)
        low, high = np.broadcast_arrays(low, high)
        have = as_numbers(got, "your answer")
        if isinstance(have, Verdict):
            return have
        if have.shape != low.shape:
            wanted = f"expected shape {low.shape}" if low.shape else "expected one number"
            return Verdict("shape", f"your answer has shape {have.shape}; {wanted}")
        if have.dtype.kind == "b":
            return Verdict("type", "your answer is True or False; expected a number")
        if np.isnan(have).any():
            return Verdict("nan", "your answer contains NaN" if have.shape else "your answer is NaN")
        elements = Elements(low, have, "your answer", have.shape)
        return elements.differences(~((low <= have) & (have <= high)))

    def alike(self, answer: Any, got: Any) -> bool:
        """Return whether two numbers are about the same, because a wrong answer has no interval."""
        return bool(Close(rtol=0.02).compare(answer, got))

    def expects(self, case: Case, answer: Any) -> Any:
        """Return the interval, which the case itself contains."""
        return case.expected


def most_pairs(fits: npt.NDArray[np.bool_]) -> int:
    """Return the largest number of possible pairs, `fits` (N, M), in which each row and each column is used once."""
    from scipy.optimize import linear_sum_assignment  # takes long to import, so workers start without it

    return int(fits[linear_sum_assignment(~fits)].sum())
