"""SymPy expressions as steps, which a student's process sends and the judging process evaluates with NumPy.

A step is ("symbol", name), ("number", value), ("ratio", numerator, denominator), ("constant", "pi" or "e"), or an
operation with the indices of its operands among the earlier steps.
The judging process never parses SymPy objects or code.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Step = tuple[Any, ...]

MOST_STEPS = 20_000
LARGEST_INTEGER = 2**53  # of a ratio, which is exact; a larger one becomes a float
CONSTANTS = {"pi": np.pi, "e": np.e}


def _all_of(operation: Any) -> Callable[..., Any]:
    """Extend an operation on two values to many values."""

    def of_many(first: Any, *others: Any) -> Any:
        for other in others:
            first = operation(first, other)
        return first

    return of_many


def _piecewise(*parts: Any) -> Any:
    """Return the first value whose condition holds; the arguments are values and conditions in turn."""
    found: Any = np.nan
    for value, condition in reversed(list(zip(parts[::2], parts[1::2], strict=True))):
        found = np.where(np.asarray(condition, dtype=bool), value, found)
    return found


OPERATIONS: dict[str, Callable[..., Any]] = {
    "Add": _all_of(np.add),
    "Mul": _all_of(np.multiply),
    "Pow": np.power,
    "Mod": np.mod,
    "exp": np.exp,
    "log": np.log,
    "Abs": np.abs,
    "sign": np.sign,
    "floor": np.floor,
    "ceiling": np.ceil,
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "asin": np.arcsin,
    "acos": np.arccos,
    "atan": np.arctan,
    "sinh": np.sinh,
    "cosh": np.cosh,
    "tanh": np.tanh,
    "asinh": np.arcsinh,
    "acosh": np.arccosh,
    "atanh": np.arctanh,
    "atan2": np.arctan2,
    "sinc": lambda x: np.sinc(x / np.pi),
    "cot": lambda x: 1 / np.tan(x),
    "sec": lambda x: 1 / np.cos(x),
    "csc": lambda x: 1 / np.sin(x),
    "acot": lambda x: np.arctan(1 / x),
    "Heaviside": lambda x, at_zero: np.heaviside(x, at_zero),
    "Max": _all_of(np.maximum),
    "Min": _all_of(np.minimum),
    "re": np.real,
    "im": np.imag,
    "arg": np.angle,
    "conjugate": np.conjugate,
    "StrictLessThan": np.less,
    "LessThan": np.less_equal,
    "Equality": np.equal,
    "Unequality": np.not_equal,
    "StrictGreaterThan": np.greater,
    "GreaterThan": np.greater_equal,
    "And": _all_of(np.logical_and),
    "Or": _all_of(np.logical_or),
    "Not": np.logical_not,
    "Piecewise": _piecewise,
}


class Steps:
    """The steps of several expressions, which share common subexpressions."""

    def __init__(self) -> None:
        self.steps: list[Step] = []
        self._places: dict[Any, int] = {}

    def place(self, expression: Any) -> int:
        """Add an expression of SymPy and return the place of its value.

        Raise a ValueError if a part of it has no value, such as an integral.
        """
        if expression not in self._places:
            step = self._step(expression)
            if len(self.steps) >= MOST_STEPS:
                raise ValueError(
                    f"your matrices have more than {MOST_STEPS} terms and factors: simplify them"
                )
            self.steps.append(step)
            self._places[expression] = len(self.steps) - 1
        return self._places[expression]

    def _step(self, expression: Any) -> Step:
        import sympy

        if expression.is_Symbol:
            return ("symbol", str(expression))
        if expression == sympy.I:
            return ("number", 1j)
        if expression in (sympy.true, sympy.false):
            return ("number", float(bool(expression)))
        if expression in (sympy.pi, sympy.E):
            return ("constant", "pi" if expression == sympy.pi else "e")
        if expression.is_Rational and max(abs(expression.p), expression.q) <= LARGEST_INTEGER:
            return ("ratio", int(expression.p), int(expression.q))
        if expression.is_number and not expression.args:
            return ("number", float(expression))
        name, parts = type(expression).__name__, expression.args
        if name not in OPERATIONS:
            raise ValueError(
                f"{name} has no value that could be compared: write sums, products, powers and functions such as sin, "
                "and call .doit() on what is not evaluated yet"
            )
        if name == "Piecewise":
            parts = [each for pair in parts for each in pair.args]
        return (name, *map(self.place, parts))


def compute(steps: Sequence[Step], symbols: Mapping[str, Floats]) -> list[Floats]:
    """Compute the values (N,) of each step, which may be untrusted, from the values (N,) of the symbols.

    A value that is not a real number is NaN; steps that are not valid raise a ValueError.
    """
    values: list[Any] = []
    if len(steps) > MOST_STEPS:
        raise ValueError("too many steps")
    with np.errstate(all="ignore"):
        for step in steps:
            values.append(_value(step, values, symbols))
    count = len(next(iter(symbols.values()), ()))
    return [np.broadcast_to(_real(each), (count,)) for each in values]


def _value(step: Step, before: Sequence[Any], symbols: Mapping[str, Floats]) -> Any:
    match step:
        case ("symbol", str(name)) if name in symbols:
            return np.asarray(symbols[name], dtype=float)
        case ("number", float() | complex() as number):
            return np.asarray(number)
        case ("ratio", top, bottom) if _is_ratio(top, bottom):
            return np.asarray(top / bottom)
        case ("constant", str(name)) if name in CONSTANTS:
            return np.asarray(CONSTANTS[name])
        case (str(name), *places) if name in OPERATIONS and all(_is_place(each, before) for each in places):
            try:
                return OPERATIONS[name](*(before[each] for each in places))
            except (TypeError, ValueError):  # complex numbers, or too few operands
                return np.asarray(np.nan)
    raise ValueError("not a step of an expression")


def _is_ratio(top: object, bottom: object) -> bool:
    """Return whether both are integers of a moderate size, and the second is positive."""
    return (
        type(top) is int
        and type(bottom) is int
        and abs(top) <= LARGEST_INTEGER
        and 0 < bottom <= LARGEST_INTEGER
    )


def _is_place(place: object, before: Sequence[Any]) -> bool:
    return type(place) is int and 0 <= place < len(before)


def _real(value: Any) -> Floats:
    whole = np.asarray(value, dtype=complex)
    return np.where(whole.imag == 0, whole.real, np.nan)
