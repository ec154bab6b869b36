"""Expressions come back from a student's process as steps, and have the values that SymPy gives them."""

import numpy as np
import pytest
import sympy
from sympy import Abs, Max, Min, Mod, Piecewise, Rational, atan2, cos, exp, log, pi, sign, sin, sqrt, tan

from nao_course.codec import decode, encode
from nao_course.exercises.comparisons import expressions
from nao_course.exercises.comparisons.expressions import OPERATIONS, Steps, compute

x, y = sympy.symbols("x y")
AT = {"x": np.array([0.5, -1.5, 2.0]), "y": np.array([1.0, 3.0, -0.25])}


def value(expression):
    steps = Steps()
    place = steps.place(expression)
    return compute(decode(encode(steps.steps)), AT)[place]


@pytest.mark.parametrize(
    "expression",
    [
        x + y - 2 * x * y / 3,
        sqrt(x**2 + y**2) ** 3 + x ** Rational(-3, 1),
        atan2(y, x) + atan2(sin(x), cos(x)),
        Mod(x + pi, 2 * pi) - pi,
        exp(-x) * log(x**2 + 1) + tan(y) / sympy.E,
        sympy.asin(x / 5) + sympy.acos(y / 5) + sympy.atan(x) + sympy.sinc(y),
        sympy.sinh(x) + sympy.cosh(y) + sympy.tanh(x) + sympy.asinh(y) + sympy.acosh(y**2 + 1),
        sympy.atanh(x / 5) + sympy.cot(x) + sympy.sec(x) + sympy.csc(y) + sympy.acot(x),
        Piecewise((x, x > y), (y**2, sympy.And(x < y, sympy.Not(sympy.Eq(x, 2)))), (7, True)),
        Abs(x) + sign(y) + Max(x, y, 0) + Min(x, 1, y) + sympy.floor(x) - sympy.ceiling(y),
        sympy.arg(x + sympy.I * y)
        + sympy.re(x * sympy.I * sympy.I)
        + sympy.im(sympy.conjugate(x + sympy.I * y)),
        sympy.Heaviside(x, 1) + Piecewise((1, sympy.Or(x >= 1, sympy.Ne(y, 1))), (2, x <= 0), (3, True)),
    ],
    ids=str,
)
def test_an_expression_has_sympys_values(expression):
    known = [complex(expression.subs({x: a, y: b})).real for a, b in zip(*AT.values(), strict=True)]
    assert value(expression) == pytest.approx(known, rel=1e-12)


def test_a_strict_condition_does_not_hold_at_its_edge_and_what_is_no_real_number_is_nan():
    for nothing in (sqrt(-1 - x**2), x + sympy.I, log(-1 - x**2), sympy.nan, atan2(x + sympy.I, y)):
        assert np.isnan(value(nothing)).all()
    for nothing, name in (
        (sympy.Derivative(x**2, x), "Derivative"),
        (sympy.Integral(x**2, x), "Integral"),
        (sympy.Function("f")(x), "f has no value"),
        (sympy.gamma(x), "gamma"),
    ):
        with pytest.raises(ValueError, match=name):
            Steps().place(nothing)
    for condition, chosen in ((x < 0, 2), (x <= 0, 1), (x > 0, 2), (x >= 0, 1)):
        steps = Steps()
        place = steps.place(Piecewise((1, condition), (2, True)))
        assert compute(steps.steps, {"x": np.zeros(1)})[place] == chosen


def test_what_stands_in_two_places_is_one_step_and_steps_have_an_end(monkeypatch):
    steps = Steps()
    steps.place(sin(x * y) + 1)
    before = len(steps.steps)
    steps.place(sin(x * y))
    assert len(steps.steps) == before
    monkeypatch.setattr(expressions, "MOST_STEPS", 50)
    with pytest.raises(ValueError, match="simplify"):
        Steps().place(sympy.Add(*(x + number for number in range(50)), evaluate=False))
    with pytest.raises(ValueError, match="too many"):
        compute([("symbol", "x")] * 51, AT)


@pytest.mark.parametrize("name", sorted(OPERATIONS))
@pytest.mark.parametrize("count", [0, 1, 2, 3])
def test_no_operation_raises_whatever_it_is_given(name, count):
    symbols = AT | {"nan": np.full(3, np.nan), "huge": np.full(3, 1e308)}
    first = [*(("symbol", each) for each in symbols), ("number", 1j), ("number", 0.0)]
    for start in range(len(first)):
        places = [(start + each) % len(first) for each in range(count)]
        assert compute([*first, (name, *places)], symbols)[-1].shape == (3,)
