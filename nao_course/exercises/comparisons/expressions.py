"""SymPy expressions as steps: what a student's process sends of them, to be computed with NumPy where the judging is.

A step is ("symbol", name), ("number", value) or an operation with the places of the steps before it that it is made of.
Nothing of SymPy, and no text that is code, is read by who computes them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Step = tuple[Any, ...]

MOST_STEPS = 20_000


def _all_of(operation: Any) -> Callable[..., Any]:
    """An operation of two as one of many."""

    def of_many(first: Any, *others: Any) -> Any:
        for other in others:
            first = operation(first, other)
        return first

    return of_many


def _piecewise(*parts: Any) -> Any:
    """The first value whose condition holds; values and conditions in turn."""
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
    """The steps of some expressions; what stands in several of them is one step."""

    def __init__(self) -> None:
        self.steps: list[Step] = []
        self._places: dict[Any, int] = {}

    def place(self, expression: Any) -> int:
        """Add an expression of SymPy and return the place of its value.

        Raises
        ------
        ValueError
            If there is something in it that has no value, such as an integral.
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
        if expression.is_number and not expression.args:
            return ("number", float(expression))
        name, parts = type(expression).__name__, expression.args
        if name not in OPERATIONS:
            raise ValueError(
                f"{name} has no value that could be compared: write sums, products, powers and functions such as sin, "
                "and .doit() where something is left to be done"
            )
        if name == "Piecewise":
            parts = [each for pair in parts for each in pair.args]
        return (name, *map(self.place, parts))


def compute(steps: Sequence[Step], symbols: Mapping[str, Floats]) -> list[Floats]:
    """Compute the value of each step, which a stranger may have written.

    Parameters
    ----------
    steps : sequence of tuple
        As in `Steps.steps`.
    symbols : mapping of str to ndarray, shape (N,)
        Values of each symbol, by its name.

    Returns
    -------
    list of ndarray, shape (N,)
        NaN where there is no real number.

    Raises
    ------
    ValueError
        If they are no steps.
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
        case (str(name), *places) if name in OPERATIONS and all(_is_place(each, before) for each in places):
            try:
                return OPERATIONS[name](*(before[each] for each in places))
            except (TypeError, ValueError):  # of complex numbers, or of too few
                return np.asarray(np.nan)
    raise ValueError("no step of an expression")


def _is_place(place: object, before: Sequence[Any]) -> bool:
    return type(place) is int and 0 <= place < len(before)


def _real(value: Any) -> Floats:
    whole = np.asarray(value, dtype=complex)
    return np.where(whole.imag == 0, whole.real, np.nan)
