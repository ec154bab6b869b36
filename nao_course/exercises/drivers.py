"""Functions that run beside a student's code and turn what it does into arrays that can be compared."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

STEP = 1e-6  # of central differences: an error of 1e-12 from the curve, of 1e-10 from rounding


def sampling_law(
    function: Callable[..., float], values: npt.NDArray[Any], n_samples: int, repeats: int
) -> tuple[float, float, bool] | None:
    """Call a function that draws a random sample, many times.

    Parameters
    ----------
    function : callable
        ``function(values, n_samples, rng) -> float``.
    values : ndarray
        What it draws from.
    n_samples : int
        How many it draws.
    repeats : int
        How many generators it is called with, seeds 0 to repeats - 1.

    Returns
    -------
    tuple of (float, float, bool), or None
        Mean and standard deviation of its answers, and whether the same seeds give the same answers again. None where
        an answer is None.
    """

    def answers(seeds: range) -> list[float]:
        return [function(values.copy(), n_samples, np.random.default_rng(seed)) for seed in seeds]

    first, again = answers(range(repeats)), answers(range(min(repeats, 20)))
    if any(answer is None for answer in (*first, *again)):
        return None
    drawn, same = np.array(first, dtype=float), np.array(again, dtype=float)
    return float(drawn.mean()), float(drawn.std()), bool((drawn[: len(same)] == same).all())


def jacobian(
    function: Callable[[], tuple[Any, Any]], points: dict[str, npt.NDArray[np.float64]], by: list[str]
) -> dict[str, Any]:
    """Evaluate a Jacobian that a student derived with SymPy, beside the slopes of their own model.

    Parameters
    ----------
    function : callable
        ``function() -> (model, jacobian)``, SymPy matrices of shape (R, 1) and (R, C).
    points : dict of str to ndarray, shape (N,)
        Values of every symbol, by its name.
    by : list of str
        Names of the C symbols that the columns of the Jacobian are derivatives by, in their order.

    Returns
    -------
    dict
        For `symbolic.Derivative`. "jacobian" and "differences": ndarrays of shape (N, R, C), the second by central
        differences of the model. "terms": for each entry, row by row, an ndarray (K, N) of the terms of its derivative.

    Raises
    ------
    ValueError
        If the model or the Jacobian has a symbol that is not among the points.
    """
    import sympy

    model, derived = (_by_name(sympy.Matrix(each)) for each in function())
    unknown = sorted(
        str(each) for each in model.free_symbols | derived.free_symbols if str(each) not in points
    )
    if unknown:
        raise ValueError(f"the symbols here are called {list(points)}; yours has {unknown}, too")
    symbols = {name: sympy.Symbol(name) for name in points}
    numbers = np.stack([points[name] for name in points])  # (symbols, N)

    def evaluate(matrix: Any, at: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        compiled = sympy.lambdify(list(symbols.values()), matrix, "numpy")
        with np.errstate(all="ignore"):  # what is no number is told as such
            return np.array([compiled(*each) for each in at.T], dtype=float)

    differences = []
    for name in by:
        step = np.zeros_like(numbers)
        step[list(points).index(name)] = STEP
        change = (evaluate(model, numbers + step) - evaluate(model, numbers - step))[:, :, 0]
        jumped = np.abs(change) > np.pi  # an angle that went once round
        differences.append(np.where(jumped, change - 2 * np.pi * np.sign(change), change) / (2 * STEP))
    unwrapped = model.replace(sympy.Mod, lambda angle, period: angle)  # SymPy knows no slope of a remainder
    slopes = [sympy.expand(sympy.diff(row, symbols[name])) for row in unwrapped for name in by]
    terms = [evaluate(sympy.Matrix(sympy.Add.make_args(slope)), numbers)[:, :, 0].T for slope in slopes]
    return {
        "jacobian": evaluate(derived, numbers),
        "differences": np.stack(differences, axis=2),
        "terms": terms,
    }


def _by_name(matrix: Any) -> Any:
    """A SymPy matrix with plain symbols: x is x, also where one was declared real and another was not."""
    import sympy

    return matrix.xreplace({each: sympy.Symbol(str(each)) for each in matrix.free_symbols})
