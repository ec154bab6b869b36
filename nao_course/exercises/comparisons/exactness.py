"""Distinguish a derivative from a difference quotient: both are computed with 300 digits, where they differ.

With the 16 digits of a float the difference quotient (f(x + h) - f(x - h)) / 2h is as good as a derivative. With p
digits a quotient of order n has at best p n / (n + 1) right digits: its error is the larger of h^n and 10^-p / h,
and this holds for every step h, also for a step that the answer makes from the precision that it is computed with. The
model's derivatives are therefore not quotients either: they follow from the derivatives of its steps by the chain rule.
An answer that is another one in floats than with 300 digits is not exact.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.exercises.comparisons.expressions import Floats, Step, compute

DIGITS, SAME_DIGITS = 300, 270  # a quotient needs ten evaluations of the model for that many
CONSISTENT = 1e-6  # relative and absolute: by how much the values may differ from those in floats
LARGEST = 1e9  # of any value: with larger ones the digits do not suffice
MOST_PERIODS = 100  # from 0 that a number is rounded at: finer rounding makes a polynomial of any model
MOST_STEPS = 2_000  # an answer that is longer is not computed
_one_at_a_time = threading.Lock()  # mpmath's constants are shared by all threads and grow with the precision


class _NoValue(Exception):  # noqa: N818 - it never leaves this module
    """A step has no real value of a moderate size."""


def exact_entries(
    steps: Sequence[Step],
    model: Sequence[int],
    rows: Sequence[Sequence[int]],
    point: Mapping[str, float],
    by: Sequence[str],
) -> npt.NDArray[np.bool_]:
    """Return which entries (R, C) of a Jacobian are the model's derivatives to 150 digits, and not only close to them.

    `steps` were accepted by `compute`; `model` (R,) and `rows` (R, C) are places in them, `point` has the value of each
    symbol, and `by` are the C variables. All entries are False where a value is too large, or the expressions are too
    long.
    """
    derived = np.zeros((len(rows), len(by)), dtype=bool)
    steps = steps[: max(map(max, [model, *rows])) + 1]
    if len(steps) > MOST_STEPS or sum(map(len, steps)) > 5 * MOST_STEPS:
        return derived
    in_floats = np.array(compute(steps, {name: np.array([value]) for name, value in point.items()}))[:, 0]
    with _one_at_a_time:
        mp = _context()
        tolerance = mp.mpf(10) ** -SAME_DIGITS
        try:
            values = _values(mp, steps, {name: mp.mpf(value) for name, value in point.items()})
            gradients = _gradients(mp, steps[: max(model) + 1], values, by)
            for row, place in enumerate(model):
                for column, entry in enumerate(rows[row]):
                    wanted = gradients[place][column]
                    derived[row, column] = abs(values[entry] - wanted) <= tolerance * (
                        1 + abs(wanted)
                    ) and all(
                        abs(values[each] - in_floats[each]) <= CONSISTENT * (1 + abs(values[each]))
                        for each in (place, entry)
                    )
        except Exception:  # noqa: BLE001 - mpmath raises many kinds; what has no value is not a derivative
            return np.zeros_like(derived)
    return derived


@cache
def _context() -> Any:
    """Return a context of mpmath that nobody else uses, because the precision belongs to the context."""
    import mpmath

    context = mpmath.MPContext()
    context.dps = DIGITS
    return context


def at_last(points: Mapping[str, Floats]) -> dict[str, float]:
    """Return the last of some points: the first ones are often chosen where something is special."""
    return {name: float(values[-1]) for name, values in points.items()}


def _values(mp: Any, steps: Sequence[Step], at: Mapping[str, Any]) -> list[Any]:
    operations, values = _operations(mp), list[Any]()
    for step in steps:
        match step:
            case ("symbol", str(name)):
                value = at[name]
            case ("number", float() as number):
                value = mp.mpf(number)
            case ("ratio", int(top), int(bottom)):
                value = mp.mpf(top) / bottom
            case ("constant", str(name)):
                value = {"pi": mp.pi, "e": mp.e}[name] * 1
            case (str(name), *places) if name in operations:
                value = operations[name](*(values[each] for each in places))
            case _:
                raise _NoValue
        if not isinstance(value, bool | mp.mpf) or not abs(value) < LARGEST:
            raise _NoValue
        values.append(value)
    return values


def _operations(mp: Any) -> dict[str, Callable[..., Any]]:
    """Return the operations of `expressions.OPERATIONS`, for numbers of `mpmath`."""

    def rounded(function: Callable[[Any], Any]) -> Callable[[Any], Any]:
        return lambda x: function(x) if abs(x) <= MOST_PERIODS else mp.nan

    floor = rounded(mp.floor)

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
        "Mod": lambda x, period: x - period * floor(x / period),
        "exp": mp.exp,
        "log": mp.log,
        "Abs": abs,
        "sign": mp.sign,
        "floor": floor,
        "ceiling": rounded(mp.ceil),
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


def _gradients(
    mp: Any, steps: Sequence[Step], values: Sequence[Any], by: Sequence[str]
) -> list[tuple[Any, ...]]:
    """Return the derivatives of each step's value by some symbols, by the chain rule."""
    gradients = list[tuple[Any, ...]]()
    zero, partials = (mp.zero,) * len(by), _partials(mp)
    for step, value in zip(steps, values, strict=False):
        name, *places = step
        total = zero
        if name == "symbol":
            total = tuple(mp.mpf(each == places[0]) for each in by)
        elif name not in ("number", "ratio", "constant") and not isinstance(value, bool):
            operands = [values[each] for each in places]
            for at, place in enumerate(places):
                if any(gradients[place]):
                    partial = partials[name](at, value, *operands)
                    total = tuple(
                        one + partial * other for one, other in zip(total, gradients[place], strict=True)
                    )
        gradients.append(total)
    return gradients


def _partials(mp: Any) -> dict[str, Callable[..., Any]]:
    """Return, for each operation with real values, its derivative by operand `at` (y: its value)."""

    def of_one(derivative: Callable[[Any, Any], Any]) -> Callable[..., Any]:
        return lambda at, y, x: derivative(x, y)

    def of_two(*derivatives: Callable[[Any, Any, Any], Any]) -> Callable[..., Any]:
        return lambda at, y, one, other: derivatives[at](y, one, other)

    def of_product(at: int, y: Any, *parts: Any) -> Any:
        return y / parts[at] if parts[at] else mp.fprod(parts[:at] + parts[at + 1 :])

    def of_choice(at: int, y: Any, *parts: Any) -> int:
        return int(at == next(i for i in range(0, len(parts), 2) if parts[i + 1]))

    return {
        "Add": lambda *_: 1,
        "Mul": of_product,
        "Pow": of_two(lambda y, x, n: n * mp.power(x, n - 1), lambda y, x, n: y * mp.log(x)),
        "Mod": of_two(lambda *_: 1, lambda y, x, period: (y - x) / period),
        "atan2": of_two(lambda angle, y, x: x / (x * x + y * y), lambda angle, y, x: -y / (x * x + y * y)),
        "exp": of_one(lambda x, y: y),
        "log": of_one(lambda x, y: 1 / x),
        "Abs": of_one(lambda x, y: mp.sign(x)),
        "sin": of_one(lambda x, y: mp.cos(x)),
        "cos": of_one(lambda x, y: -mp.sin(x)),
        "tan": of_one(lambda x, y: 1 + y * y),
        "asin": of_one(lambda x, y: 1 / mp.sqrt(1 - x * x)),
        "acos": of_one(lambda x, y: -1 / mp.sqrt(1 - x * x)),
        "atan": of_one(lambda x, y: 1 / (1 + x * x)),
        "sinh": of_one(lambda x, y: mp.cosh(x)),
        "cosh": of_one(lambda x, y: mp.sinh(x)),
        "tanh": of_one(lambda x, y: 1 - y * y),
        "asinh": of_one(lambda x, y: 1 / mp.sqrt(x * x + 1)),
        "acosh": of_one(lambda x, y: 1 / mp.sqrt(x * x - 1)),
        "atanh": of_one(lambda x, y: 1 / (1 - x * x)),
        "sinc": of_one(lambda x, y: (mp.cos(x) - y) / x if x else 0),
        "cot": of_one(lambda x, y: -1 - y * y),
        "sec": of_one(lambda x, y: y * mp.tan(x)),
        "csc": of_one(lambda x, y: -y * mp.cot(x)),
        "acot": of_one(lambda x, y: -1 / (1 + x * x)),
        "re": lambda *_: 1,
        "conjugate": lambda *_: 1,
        **dict.fromkeys(("sign", "floor", "ceiling", "Heaviside", "im", "arg"), lambda *_: 0),
        "Max": lambda at, y, *parts: int(at == parts.index(y)),
        "Min": lambda at, y, *parts: int(at == parts.index(y)),
        "Piecewise": of_choice,
    }
