"""Distinguish a derivative from a difference quotient: both are computed with 300 digits, where they differ.

With the 16 digits of a float the difference quotient (f(x + h) - f(x - h)) / 2h is as good as a derivative. With more
digits its error, which falls with a power of h, can be measured.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.exercises.comparisons.expressions import Floats, Step

DIGITS = 300
STEP_DIGITS, SAME_DIGITS = 90, 150  # the central differences' step is 1e-90, so their error is about 1e-180
LARGEST = 1e9  # of any value: with larger ones the digits do not suffice
MOST_STEPS = 2_000  # an answer that is longer is not computed


class _NoValue(Exception):  # noqa: N818 - it never leaves this module
    """A step has no real or complex value of a moderate size."""


def exact_entries(
    steps: Sequence[Step],
    model: Sequence[int],
    rows: Sequence[Sequence[int]],
    point: Mapping[str, float],
    by: Sequence[str],
) -> npt.NDArray[np.bool_]:
    """Return which entries of a Jacobian are the model's derivatives to 150 digits.

    Parameters
    ----------
    steps : sequence of tuple
        Of model and Jacobian, which `compute` accepted; see `nao_course.exercises.comparisons.expressions.Steps`.
    model : sequence of int
        The places (R,) of the model's rows in `steps`.
    rows : sequence of sequence of int
        The places (R, C) of the Jacobian's entries.
    point : mapping of str to float
        The value of each symbol at one point.
    by : sequence of str
        Names of the C variables.

    Returns
    -------
    ndarray of bool, shape (R, C)
        False for an entry that is only close to the derivative. All are False where a value is too large, or the
        expressions are too long.
    """
    import mpmath

    derived = np.zeros((len(rows), len(by)), dtype=bool)
    steps = steps[: max(map(max, [model, *rows])) + 1]
    if len(steps) > MOST_STEPS or sum(map(len, steps)) > 5 * MOST_STEPS:
        return derived
    with mpmath.workdps(DIGITS):
        at = {name: mpmath.mpf(value) for name, value in point.items()}
        step, tolerance = mpmath.mpf(10) ** -STEP_DIGITS, mpmath.mpf(10) ** -SAME_DIGITS
        try:
            entries = _values(mpmath, steps, at)
            for column, name in enumerate(by):
                ahead = _values(mpmath, steps[: max(model) + 1], {**at, name: at[name] + step})
                behind = _values(mpmath, steps[: max(model) + 1], {**at, name: at[name] - step})
                for row, place in enumerate(model):
                    wanted = (ahead[place] - behind[place]) / (2 * step)
                    error = abs(entries[rows[row][column]] - wanted)
                    derived[row, column] = bool(error <= tolerance * (1 + abs(wanted)))
        except Exception:  # noqa: BLE001 - mpmath raises many kinds; what has no value is not a derivative
            return np.zeros_like(derived)
    return derived


def at_last(points: Mapping[str, Floats]) -> dict[str, float]:
    """Return the last of some points: the first ones are often chosen where something is special."""
    return {name: float(values[-1]) for name, values in points.items()}


def _values(mp: Any, steps: Sequence[Step], at: Mapping[str, Any]) -> list[Any]:
    operations, values = _operations(mp), list[Any]()
    for step in steps:
        match step:
            case ("symbol", str(name)):
                value = at[name]
            case ("number", float() | complex() as number):
                value = mp.mpmathify(number)
            case ("ratio", int(top), int(bottom)):
                value = mp.mpf(top) / bottom
            case ("constant", str(name)):
                value = {"pi": mp.pi, "e": mp.e}[name] * 1
            case (str(name), *places) if name in operations:
                value = operations[name](*(values[each] for each in places))
            case _:
                raise _NoValue
        if not isinstance(value, bool) and not (mp.isfinite(value) and abs(value) < LARGEST):
            raise _NoValue
        values.append(value)
    return values


def _operations(mp: Any) -> dict[str, Callable[..., Any]]:
    """Return the operations of `expressions.OPERATIONS`, for numbers of `mpmath`."""

    def ordered(test: Callable[[Any, Any], bool]) -> Callable[..., bool]:
        return lambda *parts: all(test(one, other) for one, other in pairwise(parts))

    def chosen(*parts: Any) -> Any:
        return next((value for value, holds in zip(parts[::2], parts[1::2], strict=True) if holds), mp.nan)

    def step_at(x: Any, at_zero: Any) -> Any:
        return at_zero if x == 0 else mp.mpf(x > 0)

    return {
        "Add": lambda *parts: mp.fsum(parts),
        "Mul": lambda *parts: mp.fprod(parts),
        "Pow": mp.power,
        "Mod": lambda x, period: x - period * mp.floor(x / period),
        "exp": mp.exp,
        "log": mp.log,
        "Abs": abs,
        "sign": mp.sign,
        "floor": mp.floor,
        "ceiling": mp.ceil,
        **{name: getattr(mp, name) for name in ("sin", "cos", "tan", "asin", "acos", "atan", "atan2")},
        **{name: getattr(mp, name) for name in ("sinh", "cosh", "tanh", "asinh", "acosh", "atanh")},
        **{name: getattr(mp, name) for name in ("sinc", "cot", "sec", "csc", "re", "im", "arg")},
        "acot": lambda x: mp.atan(1 / x),
        "conjugate": mp.conj,
        "Heaviside": step_at,
        "Max": max,
        "Min": min,
        "StrictLessThan": ordered(lambda one, other: one < other),
        "LessThan": ordered(lambda one, other: one <= other),
        "Equality": ordered(lambda one, other: one == other),
        "Unequality": ordered(lambda one, other: one != other),
        "StrictGreaterThan": ordered(lambda one, other: one > other),
        "GreaterThan": ordered(lambda one, other: one >= other),
        "And": lambda *parts: all(parts),
        "Or": lambda *parts: any(parts),
        "Not": lambda holds: not holds,
        "Piecewise": chosen,
    }
