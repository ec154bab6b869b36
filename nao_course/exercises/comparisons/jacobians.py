"""Jacobians that a student derived with SymPy, held against the slopes of the student's own model."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.exercises.case import Case
from nao_course.exercises.codec import register
from nao_course.exercises.comparisons.comparison import RIGHT, Comparison, Verdict
from nao_course.exercises.comparisons.expressions import Floats, Steps, compute
from nao_course.exercises.comparisons.values import Close
from nao_course.exercises.running import register_driver

UNKNOWN_SLIP = "compare it with a small change of that variable in your model"
STEP = 1e-6  # of central differences: an error of 1e-12 from the curve, of 1e-10 from rounding


@register_driver
def jacobian(function: Callable[[], Any], symbols: Collection[str], by: list[str]) -> dict[str, Any] | None:
    """Ask for a Jacobian that a student derived with SymPy, and take it apart; nothing is computed of it here.

    Parameters
    ----------
    function : callable
        ``function() -> (model, jacobian)``, SymPy matrices of shape (R, 1) and (R, C).
    symbols : collection of str
        Names of all symbols that there may be. Their values are not here: whoever can replace this function could
        answer with numbers that fit them.
    by : list of str
        Names of the C symbols that the columns of the Jacobian are derivatives by, in their order.

    Returns
    -------
    dict or None
        For `evaluated`; None where nothing came, {} where it is no pair. "steps" of all expressions, see `Steps`, and
        the places of their values: "model" (R), "jacobian" (R lists of C), "terms": for each slope of the model, row by
        row, those of its terms, which only the words of a hint depend on.

    Raises
    ------
    ValueError
        If the model or the Jacobian has a symbol that is not among them, or something that has no value.
    """
    import sympy

    answer = function()
    if not isinstance(answer, tuple | list) or len(answer) != 2:
        return None if answer is None else {}  # the comparison says what is wanted
    model, derived = (_by_name(sympy.Matrix(each)) for each in answer)
    if model.rows == 1:  # a model that lies on its side is the same model
        model = model.T
    unknown = sorted(
        str(each) for each in model.free_symbols | derived.free_symbols if str(each) not in symbols
    )
    if unknown:
        raise ValueError(
            f"the symbols here are called {list(symbols)}; yours has {unknown}, too: put in what stands for it"
        )
    steps = Steps()
    places = {
        "model": [steps.place(each) for each in model],
        "jacobian": [[steps.place(each) for each in row] for row in derived.tolist()],
    }
    unwrapped = model.replace(sympy.Mod, lambda angle, period: angle)  # SymPy knows no slope of a remainder
    slopes = [sympy.expand(sympy.diff(row, sympy.Symbol(name))) for row in unwrapped for name in by]
    return {**places, "terms": [_terms(steps, slope) for slope in slopes], "steps": steps.steps}


def _by_name(matrix: Any) -> Any:
    """A SymPy matrix with plain symbols: x is x, also where one was declared real; NumPy has no complex infinity."""
    import sympy

    plain = {each: sympy.Symbol(str(each)) for each in matrix.free_symbols}
    return matrix.xreplace(plain | {sympy.zoo: sympy.nan})


def _terms(steps: Steps, slope: Any) -> list[int]:
    """Places of a slope's terms; of one that SymPy does not know, that of no number."""
    import sympy

    try:
        return [steps.place(each) for each in sympy.Add.make_args(slope)]
    except ValueError:
        return [steps.place(sympy.nan)]


def evaluated(answer: Any, points: Mapping[str, Floats], by: Sequence[str]) -> dict[str, Any] | None:
    """Compute what `jacobian` returned, which a stranger may have written.

    Parameters
    ----------
    answer : dict or None
        What it returned.
    points : mapping of str to ndarray, shape (N,)
        Values of every symbol, by its name.
    by : sequence of str
        As there.

    Returns
    -------
    dict or None
        For `Derivative`; None and {} as they came, {} for what makes no sense. "jacobian" and "differences": ndarrays
        of shape (N, R, C), the second by central differences of the model; "model": its values (N, R). "terms": for
        each entry, row by row, an ndarray (K, N) of the terms of its derivative.
    """
    match answer:
        case {
            "steps": [*steps],
            "model": [_, *_] as model,
            "jacobian": [[_, *_], *_] as rows,
            "terms": [*terms],
        }:
            try:
                return _evaluated(steps, model, rows, terms, points, by)
            except (
                ValueError,
                TypeError,
                IndexError,
            ):  # no steps, no places among them, rows of several lengths
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
    """As above; ValueError, TypeError or IndexError where that makes no sense."""
    values = compute(steps, points)
    of_model = steps[: max(model) + 1]

    def moved(name: str, step: float) -> Floats:
        there = compute(of_model, {**points, name: points[name] + step})
        return np.stack([there[each] for each in model], axis=1)

    differences = []
    for name in by:
        with np.errstate(invalid="ignore"):  # a model that divides by 0 has no slope
            change = moved(name, STEP) - moved(name, -STEP)
        jumped = np.abs(change) > np.pi  # an angle that went once round
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
    """What the driver `jacobian` returns: right for the student's own model, and for the reference's.

    A case is ``Case((points, by))``, as `evaluated` takes them; only their names go to where the function runs.

    Where it is not the slope of the student's own model, the wrong entry and the likely slip are named; that takes
    nothing but what the student wrote, and says nothing else.

    Parameters
    ----------
    by : tuple of str
        Names of what the columns are derivatives by.
    tolerance : float
        Relative and absolute; central differences are good to 1e-8 or so.
    period : tuple of float
        For each row of the model, after how much its value is the same again: 2 pi for an angle, 0 for a length. With
        it the model's values must be the reference's, too; without, its slopes are enough.
    """

    by: tuple[str, ...]
    tolerance: float = 1e-5
    period: tuple[float, ...] = ()

    def calls(self, case: Case) -> Sequence[Case]:
        """The case without the points."""
        points, by = case.args
        return [Case((list(points), by), case.name)]

    def gather(self, case: Case, answers: Iterable[Any]) -> dict[str, Any] | None:
        """Return what the answer comes to at the case's points."""
        (answer,) = answers
        return evaluated(answer, *case.args)

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare a Jacobian with the model beside it, then with the reference's."""
        if got is None:
            return Verdict("nothing", "your answer is None: a return may be missing")
        arrays = _arrays(got)
        if arrays is None or arrays[1].shape[2] != len(self.by):
            return Verdict("type", "your answer is no model and Jacobian: return (model, jacobian)")
        derived, slopes, terms = arrays
        if derived.shape != slopes.shape:
            have, want = "x".join(map(str, derived.shape[1:])), "x".join(map(str, slopes.shape[1:]))
            why = ": is it transposed?" if derived.shape[1:] == slopes.shape[:0:-1] else ""
            return Verdict("shape", f"your Jacobian is {have}; for your model it has to be {want}{why}")
        if not np.isfinite(slopes).all():
            return Verdict("nan", "your model is not a number at some of the points")
        wrong = ~self._same(derived, slopes)
        if not wrong.any():
            if self._same(derived, expected["jacobian"]).all() and self._same_model(expected, got):
                return RIGHT
            return Verdict(
                "value", "your Jacobian fits your model, but the model is not the one that is asked for"
            )
        if derived.shape[1] == derived.shape[2] and self._same(derived, slopes.transpose(0, 2, 1)).all():
            return Verdict(
                "value", "your Jacobian is transposed: rows belong to the model, columns to the variables"
            )
        (row, column), slip = next(iter(self._faults(derived, slopes, terms)))
        where = f"row {row + 1}, column {column + 1} (by {self.by[column]}) of your Jacobian"
        return Verdict("value", f"{where} is not the slope of your own model: {slip}")

    def faults(self, got: Any) -> dict[tuple[int, int], str]:
        """Return each entry that is not the slope of the model beside it, and the likely slip.

        Parameters
        ----------
        got : dict
            What `evaluated` returned, the Jacobian in the shape that its model asks for.

        Returns
        -------
        dict of (int, int) to str
            By row and column, from 0, in reading order; empty where all are right.

        Raises
        ------
        ValueError
            If it is no such dict, or the shapes differ.
        """
        arrays = _arrays(got)
        if arrays is None or arrays[0].shape != arrays[1].shape:
            raise ValueError("got is not what evaluated() returns for a Jacobian of its model's shape")
        return dict(self._faults(*arrays))

    def _faults(
        self, derived: Floats, slopes: Floats, terms: list[Floats]
    ) -> Iterator[tuple[tuple[int, int], str]]:
        for row, column in np.argwhere(~self._same(derived, slopes)).tolist():
            slips = self._slips(
                derived[:, row, column], slopes[:, row, column], terms[row * slopes.shape[2] + column]
            )
            yield (
                (row, column),
                next(slips, UNKNOWN_SLIP),
            )

    def alike(self, answer: Any, got: Any) -> bool:
        """Whether the Jacobians are the same, and so are the slopes of the models beside them, and their values."""
        arrays = _arrays(got)
        if arrays is None or not self._same_model(answer, got):
            return False
        both = zip(arrays[:2], (answer["jacobian"], answer["differences"]), strict=True)
        return all(bool(Close().compare(wanted, have)) for have, wanted in both)

    def _same_model(self, wanted: Any, got: Any) -> bool:
        """Whether the models' values (N, R) agree, whole turns aside; always where nothing says how."""
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
        """Which entries (R, C), or elements of a list (K), agree at all points."""
        if one.shape != other.shape:
            return np.array(False)
        with np.errstate(invalid="ignore", over="ignore"):
            close = np.abs(one - other) <= self.tolerance * (1 + np.abs(other))
        return np.asarray(close.all(axis=0))

    def _slips(self, derived: Floats, slope: Floats, terms: Floats) -> Iterator[str]:
        """What an entry (N,) looks like, the likeliest first; terms (K, N) are those of the right derivative."""
        if self._same(derived, -slope):
            yield "its sign is the wrong way round"
        if self._same(slope, np.zeros_like(slope)):
            yield "your model does not change with that variable"
        if self._same(derived, np.zeros_like(slope)):
            yield "it is zero, but your model does change with that variable"
        missing = slope - derived
        if any(self._same(missing, term) for term in terms):
            yield "the derivative of one term is missing"
        if any(self._same(missing, 2 * term) for term in terms):
            yield "the sign of one term is the wrong way round"
        scale = float(slope @ slope)
        with np.errstate(invalid="ignore", over="ignore"):
            factor = float(derived @ slope) / scale if scale else 0.0
        if np.allclose(derived, slope, rtol=1e-2, atol=1e-3):
            yield "it is close, but rounded: write it exactly"
        elif self._same(derived, factor * slope):
            yield f"it is {factor:.4g} times as large as it should be"


def _arrays(got: Any) -> tuple[Floats, Floats, list[Floats]] | None:
    """Jacobian and slopes (N, R, C) and each entry's terms (K, N); None where a stranger sent something else."""
    match got:
        case {
            "jacobian": np.ndarray(ndim=3) as derived,
            "differences": np.ndarray(ndim=3) as slopes,
            "terms": [*terms],
        }:
            sizes = [term.shape[1:] for term in terms if isinstance(term, np.ndarray) and term.ndim == 2]
            if sizes == [slopes.shape[:1]] * (slopes.shape[1] * slopes.shape[2]) and len(sizes) == len(terms):
                return derived.astype(float), slopes.astype(float), terms
    return None
