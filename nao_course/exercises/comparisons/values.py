"""How a student's numbers are held against the expected ones: close, exact, points in any order, within bounds.

Both are plain, as they come out of the codec: no class of a student's own has a say in a comparison.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.exercises.case import Case
from nao_course.exercises.codec import register
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

_NEARLY = 20.0  # times the tolerances: so near a wrong answer is one that was rounded
_FINE = 0.01  # relative: a coarser tolerance is for what scatters


@register
@dataclass(frozen=True)
class Close(Comparison):
    """Numbers and arrays that agree within tolerances; tuples, dicts and dataclasses item by item.

    Parameters
    ----------
    rtol, atol : float or tuple of float
        As in numpy.isclose; loose enough for float32. A tuple has one for each column, repeated along the last axis:
        (bearing, range) for (N, 2) measurements and vectors of 2 N. The numbers of a tuple or dataclass are columns.
    period : float or tuple of float
        Where not 0, values are compared on a circle: 360 for hues in degrees, 2 pi for angles.
    allowed : float
        Fraction of an array's elements that may differ.
    names : tuple of str
        What the values of a tuple, or the columns of an array, are called to the student: "your hue".
    mask : str or tuple
        Which elements count: "upper", "lower" or "diagonal" of matrices, or True and False in tuples.
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
            If tolerances or mask do not fit what is expected.
        """
        return compare_structure(expected, got, self._elements, names=self.names)

    def alike(self, answer: Any, got: Any) -> bool:
        """Whether an answer is a mistake's, which may be of another shape than the tolerances are for."""
        try:
            return bool(self.compare(answer, got))
        except ValueError:
            return bool(Close().compare(answer, got))

    def _elements(self, elements: Elements) -> Verdict:
        kind = complex if elements.wanted.dtype.kind == "c" else float
        wanted, have = elements.wanted.astype(kind), elements.have.astype(kind)
        counted = elements.counted(self.mask)
        size = int(np.count_nonzero(counted)) if self.mask else int(np.prod(elements.shape, dtype=np.int64))
        misplaced = (np.isnan(wanted) != np.isnan(have)) & counted
        if np.count_nonzero(misplaced) > self.allowed * size:
            at, value, name = elements.first(misplaced)
            place = f" at {list(at)}{name}" if at else ""
            rest = "" if np.isnan(value) else " where it should be"
            return Verdict("nan", f"{elements.where} is {'' if not rest else 'not '}NaN{place}{rest}", at)
        wrong = self._wrong(elements, wanted, have) & counted
        verdict = elements.differences(wrong, self.allowed, size)
        tolerance = self._say_tolerance()
        if verdict or not tolerance or (self._wrong(elements, wanted, have, _NEARLY) & counted).any():
            return verdict
        return replace(verdict, text=f"{verdict.text}; it is close, and has to be right to {tolerance}")

    def _say_tolerance(self) -> str:
        """How far off an answer may be, where that is one small number; else nothing."""
        if isinstance(self.rtol, tuple) or isinstance(self.atol, tuple) or self.rtol > _FINE:
            return ""
        return f"{100 * self.rtol:g} %" if self.rtol else f"{self.atol:g}"

    def _wrong(self, elements: Elements, wanted: Array, have: Array, times: float = 1.0) -> Any:
        """Which elements are neither within so many times the tolerances nor equal."""
        near = self._near(elements, wanted, have, times)
        return ~(near | (have == wanted) | (np.isnan(wanted) & np.isnan(have)))

    def _near(self, elements: Elements, wanted: Array, have: Array, times: float) -> Any:
        """Which elements are finite and within so many times the tolerances."""
        rtol, atol = elements.of_column(self.rtol, "rtol"), elements.of_column(self.atol, "atol")
        period = np.asarray(elements.of_column(self.period, "period"), dtype=float)
        with np.errstate(all="ignore"):
            difference = np.abs(have - wanted)
            if period.any():
                whole = np.where(period > 0, period, 1.0)
                wrapped = np.abs((difference + whole / 2) % whole - whole / 2)
                difference = np.where(period > 0, wrapped, difference)
            return (difference <= times * (atol + rtol * np.abs(wanted))) & np.isfinite(wanted)


@register
@dataclass(frozen=True)
class Exact(Comparison):
    """Whole numbers, booleans and text that are equal; of an array, all but a fraction of the elements.

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
        """Whether an answer is a mistake's, which may be of another shape than the tolerances are for."""
        try:
            return bool(self.compare(answer, got))
        except ValueError:
            return bool(Exact().compare(answer, got))

    def _elements(self, elements: Elements) -> Verdict:
        wanted, have = elements.wanted, elements.have
        if wanted.dtype.kind in "iu" and have.dtype.kind not in "iu":
            held = f"{elements.where} holds {KINDS[have.dtype.kind]} (dtype {have.dtype}), not whole numbers"
            return Verdict(
                "type", f"{held}: say which where the array is made, as in np.zeros(shape, dtype=int)"
            )
        counted = elements.counted(self.mask)
        size = int(np.count_nonzero(counted)) if self.mask else None
        return elements.differences((wanted != have) & counted, self.allowed, size)


_NOWHERE = 1e9  # stands for a coordinate that is no number: it is near to nothing else


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
        have = as_numbers(got, "your answer")
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
            points = "1 point" if len(have) == 1 else f"{len(have)} points"
            return Verdict("value", f"your answer has {points}, which is not the right number")
        with np.errstate(all="ignore"):
            near = np.linalg.norm(wanted[:, None] - have[None].astype(float), axis=2) <= self.tolerance
        missed = len(have) - most_pairs(near)
        if missed:
            if len(have) == 1:
                return Verdict("value", "your point is at no right place")
            points = f"{len(have)} points {'is' if missed == 1 else 'are'}"
            return Verdict("value", f"{missed} of your {points} at no right place")
        return RIGHT

    def alike(self, answer: Any, got: Any) -> bool:
        """As above; a mistake's answer may be no points at all, or have NaN among them."""
        if getattr(answer, "ndim", 0) != 2 or getattr(got, "dtype", np.dtype(object)).kind not in "iuf":
            return bool(Close().compare(answer, got))
        return bool(
            self.compare(*(np.nan_to_num(np.asarray(each, float), nan=_NOWHERE) for each in (answer, got)))
        )


@register
@dataclass(frozen=True)
class Between(Comparison):
    """Numbers between two, for what is random: a case brings ``expected=(low, high)``, numbers or arrays."""

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare a number, or an array, with (low, high)."""
        low, high = (np.asarray(each, dtype=float) for each in expected)
        low, high = np.broadcast_arrays(low, high)
        have = as_numbers(got, "your answer")
        if isinstance(have, Verdict):
            return have
        if have.shape != low.shape:
            wanted = f"shape {low.shape} is wanted" if low.shape else "one number is wanted"
            return Verdict("shape", f"your answer has shape {have.shape}; {wanted}")
        if have.dtype.kind == "b":
            return Verdict("type", "your answer is True or False; a number is wanted")
        if np.isnan(have).any():
            return Verdict("nan", "your answer has NaN in it" if have.shape else "your answer is NaN")
        elements = Elements(low, have, "your answer", have.shape)
        return elements.differences(~((low <= have) & (have <= high)))

    def alike(self, answer: Any, got: Any) -> bool:
        """Whether a number is about the same: of a wrong one no interval is known."""
        return bool(Close(rtol=0.02).compare(answer, got))

    def expects(self, case: Case, answer: Any) -> Any:
        """What the case brings."""
        return case.expected


def most_pairs(fits: npt.NDArray[np.bool_]) -> int:
    """How many pairs can be made at most, where each row and each column may be used once.

    Parameters
    ----------
    fits : ndarray of bool, shape (N, M)
        Which rows and columns make a pair.
    """
    from scipy.optimize import linear_sum_assignment  # takes long to import: workers start without it

    return int(fits[linear_sum_assignment(~fits)].sum())
