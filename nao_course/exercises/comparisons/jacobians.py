"""Compare Jacobians that a student derived with SymPy with the derivatives of the student's own model."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.codec import register
from nao_course.exercises.case import Case
from nao_course.exercises.comparisons.comparison import RIGHT, Comparison, Verdict
from nao_course.exercises.comparisons.exactness import at_last, exact_entries
from nao_course.exercises.comparisons.expressions import Floats, Steps, compute
from nao_course.exercises.comparisons.values import Close
from nao_course.exercises.running import register_driver

NOT_EXACT = (
    "agrees with the derivative of your own model only to a few digits. A difference quotient is not a derivative, and "
    "neither is a rounded number: use the rules of differentiation, or SymPy's diff or jacobian"
)
UNKNOWN_SLIP = "it does not match the effect of a small change of that variable in your model"
# Step of central differences, with an error of 1e-12 from the curvature and of 1e-10 from rounding.
STEP = 1e-6


@register_driver
def jacobian(function: Callable[[], Any], symbols: Collection[str], by: list[str]) -> dict[str, Any] | None:
    """Call a student's function for a Jacobian derived with SymPy, and split it into steps; no value is computed here.

    ``function()`` returns SymPy matrices (R, 1) and (R, C) of the model and of its derivatives by the C symbols `by`.
    The values of the `symbols` are not available here, because a student who replaces this function could return
    numbers that fit them. For `evaluated`, return None if the function returned None, {} if it did not return a pair,
    or else "steps" (see `Steps`), and the places of their values: "model" (R), "jacobian" (R lists of C), and "terms"
    of each derivative of the model, row by row, which only the wording of a hint uses. An unknown symbol or something
    without a value raises a ValueError.
    """
    import sympy

    answer = function()
    if not isinstance(answer, tuple | list) or len(answer) != 2:
        return None if answer is None else {}  # the comparison reports what is expected
    model, derived = (_by_name(sympy.Matrix(each)) for each in answer)
    if model.rows == 1:  # a model that lies on its side is the same model
        model = model.T
    unknown = sorted(
        str(each) for each in model.free_symbols | derived.free_symbols if str(each) not in symbols
    )
    if unknown:
        raise ValueError(
            f"your expressions contain the symbols {', '.join(unknown)}; expected only {', '.join(symbols)}: use "
            "these names, and replace any other symbol by its expression"
        )
    steps = Steps()
    places = {
        "model": [steps.place(each) for each in model],
        "jacobian": [[steps.place(each) for each in row] for row in derived.tolist()],
    }
    # SymPy cannot differentiate a remainder.
    unwrapped = model.replace(sympy.Mod, lambda angle, period: angle)
    derivatives = [sympy.expand(sympy.diff(row, sympy.Symbol(name))) for row in unwrapped for name in by]
    return {**places, "terms": [_terms(steps, each) for each in derivatives], "steps": steps.steps}


def _by_name(matrix: Any) -> Any:
    """Replace symbols with assumptions, such as real, by plain symbols, and SymPy's complex infinity by NaN."""
    import sympy

    plain = {each: sympy.Symbol(str(each)) for each in matrix.free_symbols}
    return matrix.xreplace(plain | {sympy.zoo: sympy.nan})


def _terms(steps: Steps, derivative: Any) -> list[int]:
    """Return the places of a derivative's terms; the place of NaN if SymPy cannot evaluate it."""
    import sympy

    try:
        return [steps.place(each) for each in sympy.Add.make_args(derivative)]
    except ValueError:
        return [steps.place(sympy.nan)]


def evaluated(answer: Any, points: Mapping[str, Floats], by: Sequence[str]) -> dict[str, Any] | None:
    """Evaluate the result of `jacobian`, which may not be trusted, at points with values (N,) of every symbol.

    Return values for `Derivative`: "model" (N, R), "jacobian" and, by central differences of the model, "differences",
    both (N, R, C), and "terms", for each entry, row by row, an array (K, N) of its derivative's terms. None and {} are
    returned unchanged, and {} replaces steps that cannot be evaluated.
    """
    # Invalid steps or indices, or rows of different lengths
    match answer:
        case {
            "steps": [*steps],
            "model": [_, *_] as model,
            "jacobian": [[_, *_], *_] as rows,
            "terms": [*terms],
        }:
            try:
                return _evaluated(steps, model, rows, terms, points, by)
            except (ValueError, TypeError, IndexError):
                return {}
    return None if answer is None else {}


def _evaluated(
    steps: list[Any],
    model: list[int],
    rows: list[list[int]],
    terms: list[list[int]],
    points: Mapping[str, Floats],
    by: Sequence[str],
) -> dict[str, Any]:
    """Evaluate; raise ValueError, TypeError or IndexError if the steps make no sense."""
    values = compute(steps, points)
    of_model = steps[: max(model) + 1]

    def moved(name: str, step: float) -> Floats:
        there = compute(of_model, {**points, name: points[name] + step})
        return np.stack([there[each] for each in model], axis=1)

    differences = []
    for name in by:
        with np.errstate(invalid="ignore"):  # a model that divides by 0 has no derivative
            change = moved(name, STEP) - moved(name, -STEP)
        jumped = np.abs(change) > np.pi  # an angle that wrapped
        differences.append(np.where(jumped, change - 2 * np.pi * np.sign(change), change) / (2 * STEP))
    return {
        "jacobian": np.stack([np.stack([values[each] for each in row], axis=1) for row in rows], axis=1),
        "differences": np.stack(differences, axis=2),
        "model": np.stack([values[each] for each in model], axis=1),
        "terms": [np.stack([values[each] for each in some]) for some in terms],
    }


@register
@dataclass(frozen=True)
class Derivative(Comparison):
    """Compare the result of the driver `jacobian` with the student's own model, and with the reference's.

    A case is ``Case((points, by))`` with the arguments of `evaluated`; only the symbols' names are sent to the process
    that runs the function.

    If an entry is not the derivative of the student's own model, the report names the entry and the likely error. That
    uses only what the student wrote, so it reveals nothing else. A difference quotient is not accepted as a derivative,
    however small its step is; see `nao_course.exercises.comparisons.exactness`.

    Parameters
    ----------
    by : tuple of str
        Names of the variables that the columns are derivatives by.
    tolerance : float
        Relative and absolute tolerance; central differences are accurate to about 1e-8.
    period : tuple of float
        The period of each row of the model: 2 pi for an angle, 0 for a length. With it, the model's values must equal
        the reference's, too; without it, equal derivatives are enough.
    """

    by: tuple[str, ...]
    tolerance: float = 1e-5
    period: tuple[float, ...] = ()

    def calls(self, case: Case) -> Sequence[Case]:
        """Return the case without the points."""
        points, by = case.args
        return [Case((list(points), by), case.name)]

    def gather(self, case: Case, answers: Iterable[Any]) -> dict[str, Any] | None:
        """Evaluate the answer at the case's points; "exact" says which entries are derivatives to many digits."""
        (answer,) = answers
        points, by = case.args
        got = evaluated(answer, points, by)
        if not got or got["jacobian"].shape != got["differences"].shape:
            return got
        places = answer["steps"], answer["model"], answer["jacobian"]
        return got | {"exact": exact_entries(*places, at_last(points), by)}

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare a Jacobian with the student's model, then with the reference's Jacobian."""
        if got is None:
            return Verdict("nothing", "your answer is None: a return may be missing")
        arrays = _arrays(got)
        if arrays is None or arrays[1].shape[2] != len(self.by):
            return Verdict("type", "your answer is not a model and a Jacobian: return (model, jacobian)")
        derived, differences, terms = arrays
        if derived.shape != differences.shape:
            if derived.shape[2] == 1:
                return Verdict(
                    "shape", "your Jacobian has one column: return (model, jacobian), the model first"
                )
            have, want = "x".join(map(str, derived.shape[1:])), "x".join(map(str, differences.shape[1:]))
            why = ": is it transposed?" if derived.shape[1:] == differences.shape[:0:-1] else ""
            if derived.shape[1] == differences.shape[1] and derived.shape[2] > len(self.by):
                why = f": differentiate with respect to {', '.join(self.by)} only"
            return Verdict("shape", f"your Jacobian is {have}; expected {want} for your model{why}")
        if not np.isfinite(differences).all():
            return Verdict("nan", "your model is not a number at some of the points")
        wrong = ~self._same(derived, differences)
        if not wrong.any():
            if (rough := _rough(got)) is not None:
                return Verdict("value", f"{self._where(*rough)} {NOT_EXACT}")
            if self._same(derived, expected["jacobian"]).all() and self._same_model(expected, got):
                return RIGHT
            return Verdict(
                "value", "your Jacobian fits your model, but your model is not the model of the exercise"
            )
        if derived.shape[1] == derived.shape[2] and self._same(derived, differences.transpose(0, 2, 1)).all():
            return Verdict(
                "value", "your Jacobian is transposed: rows belong to the model, columns to the variables"
            )
        (row, column), slip = next(iter(self._faults(derived, differences, terms)))
        return Verdict("value", f"{self._where(row, column)} is not the derivative of your own model: {slip}")

    def _where(self, row: int, column: int) -> str:
        return f"row {row + 1}, column {column + 1} (by {self.by[column]}) of your Jacobian"

    def faults(self, got: Any) -> dict[tuple[int, int], str]:
        """Return each entry that is not the derivative of the student's model, with the likely error.

        Parameters
        ----------
        got : dict
            The result of `evaluated`, with a Jacobian of its model's shape.

        Returns
        -------
        dict of (int, int) to str
            Errors by row and column, from 0, in reading order; empty if all entries are right.

        Raises
        ------
        ValueError
            If `got` is not such a dict, or the shapes differ.
        """
        arrays = _arrays(got)
        if arrays is None or arrays[0].shape != arrays[1].shape:
            raise ValueError("got is not what evaluated() returns for a Jacobian of its model's shape")
        return dict(self._faults(*arrays))

    def _faults(
        self, derived: Floats, differences: Floats, terms: list[Floats]
    ) -> Iterator[tuple[tuple[int, int], str]]:
        for row, column in np.argwhere(~self._same(derived, differences)).tolist():
            slips = self._slips(
                derived[:, row, column],
                differences[:, row, column],
                terms[row * differences.shape[2] + column],
            )
            yield ((row, column), next(slips, UNKNOWN_SLIP))

    def alike(self, answer: Any, got: Any) -> bool:
        """Return whether the Jacobians, the derivatives of the models beside them and the models' values agree."""
        arrays = _arrays(got)
        if arrays is None or not self._same_model(answer, got):
            return False
        both = zip(arrays[:2], (answer["jacobian"], answer["differences"]), strict=True)
        return all(bool(Close().compare(wanted, have)) for have, wanted in both)

    def _same_model(self, wanted: Any, got: Any) -> bool:
        """Return whether the models' values (N, R) agree up to whole periods; true without periods."""
        if not self.period:
            return True
        have = got.get("model")
        if not isinstance(have, np.ndarray) or have.shape != wanted["model"].shape:
            return False
        away = have.astype(float) - wanted["model"]
        period = np.array(self.period)
        turns = np.divide(away, period, out=np.zeros_like(away), where=period > 0)
        return bool(self._same(away - np.round(turns) * period, np.zeros_like(away)).all())

    def _same(self, one: Floats, other: Floats) -> npt.NDArray[np.bool_]:
        """Return which entries (R, C), or elements of a list (K), agree at all points."""
        if one.shape != other.shape:
            return np.array(False)
        with np.errstate(invalid="ignore", over="ignore"):
            close = np.abs(one - other) <= self.tolerance * (1 + np.abs(other))
        return np.asarray(close.all(axis=0))

    def _slips(self, derived: Floats, right: Floats, terms: Floats) -> Iterator[str]:
        """Yield the likely errors of an entry (N,), the likeliest first; `terms` (K, N) add up to `right`."""
        if self._same(derived, -right):
            yield "its sign is wrong"
        if self._same(right, np.zeros_like(right)):
            yield "your model does not change with that variable"
        if self._same(derived, np.zeros_like(right)):
            yield "it is zero, but your model does change with that variable"
        missing = right - derived
        if any(self._same(missing, term) for term in terms):
            yield "the derivative of one term is missing"
        if any(self._same(missing, 2 * term) for term in terms):
            yield "the sign of one term is wrong"
        scale = float(right @ right)
        with np.errstate(invalid="ignore", over="ignore"):
            factor = float(derived @ right) / scale if scale else 0.0
        if np.allclose(derived, right, rtol=1e-2, atol=1e-3):
            yield "it is close, but rounded: write it exactly"
        elif self._same(derived, factor * right):
            yield f"it is {factor:.4g} times as large as it should be"


def _rough(got: Any) -> tuple[int, int] | None:
    """Return the first entry that is only close to a derivative; None where there is none, or none was looked for."""
    match got:
        case {"exact": np.ndarray(ndim=2) as exact} if not exact.all():
            row, column = np.argwhere(~exact.astype(bool)).tolist()[0]
            return row, column
    return None


def _arrays(got: Any) -> tuple[Floats, Floats, list[Floats]] | None:
    """Return Jacobian and differences (N, R, C) and each entry's terms (K, N); None for any other answer."""
    match got:
        case {
            "jacobian": np.ndarray(ndim=3) as derived,
            "differences": np.ndarray(ndim=3) as differences,
            "terms": [*terms],
        }:
            sizes = [term.shape[1:] for term in terms if isinstance(term, np.ndarray) and term.ndim == 2]
            if sizes == [differences.shape[:1]] * (differences.shape[1] * differences.shape[2]) and len(
                sizes
            ) == len(terms):
                return derived.astype(float), differences.astype(float), terms
    return None
