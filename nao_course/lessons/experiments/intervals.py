"""Judge the answers of lesson 10: intervals made from random draws, with several generators, and lists of numbers."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_course.exercises import Case, Comparison, Verdict, register, register_driver
from nao_course.exercises.comparisons.comparison import RIGHT, with_article
from nao_course.exercises.comparisons.structure import as_numbers

SEEDS = (0, 1, 2, 3, 4, 0)  # the first one is repeated at the end and has to give the same answer
NARROW = 0.4  # below this fraction of the right width, the width is reported and not an end
_ENDS = ("the lower end", "the upper end")


@register_driver
def with_generators(function: Callable[..., Any], values: Any, probability: float) -> list[Any]:
    """Call ``function(values, probability, rng)`` with several generators and return the answers."""
    return [function(np.array(values), probability, np.random.default_rng(seed)) for seed in SEEDS]


@register
@dataclass(frozen=True)
class Interval(Comparison):
    """Compare two ends, which vary between generators, with the reference's.

    Parameters
    ----------
    share : float
        Largest distance of an end's mean over the generators from the reference's, as a fraction of the width.
    scatter : float
        Largest standard deviation of an end over the generators, as a fraction of the width. With 2000 resamples it
        is 0.015, and 0.02 for 99 %.
    """

    share: float = 0.05
    scatter: float = 0.045

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare the answers to all generators with the reference's."""
        wanted = np.asarray(expected, dtype=float)
        if not isinstance(got, list) or len(got) != len(SEEDS):
            return Verdict("type", "your function did not return one answer for each call")
        if any(each is None for each in got):
            return Verdict("nothing", "your answer is None: a return may be missing")
        rows = [as_numbers(each, "your answer") for each in got]
        for answer, row in zip(got, rows, strict=True):
            if isinstance(row, Verdict):
                return Verdict(
                    "type", f"your answer is {with_article(answer)}; return two numbers (low, high)"
                )
            if row.shape != (2,):
                return Verdict("shape", f"your answer has shape {row.shape}; return two numbers (low, high)")
            if np.isnan(row).any():
                return Verdict("nan", "your answer has NaN in it")
        return self._judge_ends(wanted, np.array(rows, dtype=float))

    def alike(self, answer: Any, got: Any) -> bool:
        """Return whether two wrong answers are alike: equally repeatable, with nearly the same ends."""
        pair = [_rows(each) for each in (answer, got)]
        one, other = pair
        if one is None or other is None:
            return one is None and other is None and repr(answer) == repr(got)
        if any(ask(one) != ask(other) for ask in (_repeats, _fixed)):
            return False
        less, more = sorted(float(_scatter(rows).mean()) for rows in pair if rows is not None)
        if more > 3 * less + 1e-9:  # 100 resamples scatter 4.5 times as much as 2000
            return False
        width = max(float(np.ptp(one.mean(axis=0))), 1e-9)
        near = width * (0.035 if _fixed(one) else 2 * self.share)  # what is not drawn does not scatter
        # Scatter is wider than `near` if both ends are nearly the same quantile.
        scatter = 3 * (_scatter(one) + _scatter(other))
        return bool((np.abs(one.mean(axis=0) - other.mean(axis=0)) <= np.maximum(near, scatter)).all())

    def _scatters(self, rows: Any) -> bool:
        """Return whether the ends vary more between generators than with enough resamples."""
        width = float(np.ptp(rows.mean(axis=0)))
        return bool(_scatter(rows).mean() > self.scatter * width + 1e-9)

    def _judge_ends(self, wanted: Any, have: Any) -> Verdict:
        width = float(np.ptp(wanted.mean(axis=0)))
        if not _repeats(have):
            return Verdict("value", "the same rng gave two different answers; draw with rng.choice")
        if width and _fixed(have):
            return Verdict(
                "value",
                "your answer is the same for every rng: draw resamples with rng and take the mean of each. A formula "
                "does not use rng; medians, and quantiles of single values, often give the same for every rng",
            )
        if (have[:, 0] > have[:, 1]).any():
            return Verdict("value", "the lower end is above the upper end; return (low, high)")
        own_width = float(np.ptp(have.mean(axis=0)))
        if width and own_width < 1e-9 * width:
            return Verdict("value", "both ends of your interval are equal; take quantiles of many means")
        if own_width < NARROW * width:
            return Verdict(
                "value",
                f"your interval is {width / own_width:.0f} times too narrow; each number must be the mean of one "
                "resample of len(values) values",
            )
        off = np.abs(have.mean(axis=0) - wanted.mean(axis=0))
        for i, end in enumerate(_ENDS):
            if off[i] > self.share * width + 1e-9:
                where = "low" if have[:, i].mean() < wanted[:, i].mean() else "high"
                return Verdict("value", f"{end} of your interval, {have[:, i].mean():.4g}, is too {where}")
        if self._scatters(have):
            return Verdict(
                "value",
                "the ends of your interval vary too much between generators; draw at least 2000 resamples",
            )
        return RIGHT


def _rows(answers: Any) -> Any:
    """Return answers as an array (len(SEEDS), 2), or None if they are something else."""
    try:
        rows = np.array(answers, dtype=float)
    except (TypeError, ValueError):
        return None
    return rows if rows.shape == (len(SEEDS), 2) and np.isfinite(rows).all() else None


def _scatter(rows: Any) -> Any:
    """Return the standard deviation of each end over the generators."""
    return np.std(rows[:-1], axis=0)


def _repeats(rows: Any) -> bool:
    """Return whether the first generator gave the same answer when it was repeated."""
    return bool((rows[0] == rows[-1]).all())


def _fixed(rows: Any) -> bool:
    """Return whether all generators gave the same answer."""
    return bool(np.allclose(rows, rows[0], rtol=1e-12, atol=1e-12))


@register
def each_once(args: tuple[Any, ...], kwargs: dict[str, Any], answer: Any) -> str:
    """Reject a list in which a number occurs several times."""
    numbers = np.asarray(answer)
    if numbers.dtype.kind in "iuf" and len(np.unique(numbers)) < numbers.size:
        return "your answer contains a number several times; a number of hits is possible or not, so append it once"
    return ""


def case_of(values: Any, probability: float, name: str = "") -> Case:
    """Return a case for `Interval`, whose generators the driver makes."""
    return Case((np.asarray(values, dtype=float), probability), name)
