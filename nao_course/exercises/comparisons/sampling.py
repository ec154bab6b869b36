"""Functions that draw random samples: many calls are made of one, and their mean and scatter compared."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from nao_course.exercises.codec import register
from nao_course.exercises.comparisons.values import Close, Comparison, Verdict, as_text, with_article
from nao_course.exercises.running import register_driver


@register_driver
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


@register
@dataclass(frozen=True)
class Sampled(Comparison):
    """What the driver `sampling_law` says of a function that draws random samples.

    Parameters
    ----------
    rtol : float
        Of the mean and the standard deviation of its answers: they are themselves sampled.
    """

    rtol: float = 0.25

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare (mean, standard deviation, whether a seed decides the answer) with the expected ones."""
        if got is None:
            return Verdict("nothing", "your answer is None: a return may be missing")
        if not isinstance(got, tuple | list) or len(got) != 3:
            return Verdict("type", f"your answer is {with_article(got)}, not one number")
        mean, scatter, repeatable = got
        if repeatable is not True:
            return Verdict(
                "value", "the same rng gave two different answers; rng.integers or rng.choice draw from it"
            )
        law = Close(rtol=self.rtol, names=("the mean of your answers", "the scatter of your answers"))
        verdict = law.compare(tuple(expected[:2]), (mean, scatter))
        if verdict.kind == "value" and Close().compare(0.0, scatter):
            text = f"whatever rng it gets, your answer is the same, {as_text(mean)}: draw with the rng it is given"
            return Verdict("value", text)
        return verdict

    def alike(self, answer: Any, got: Any) -> bool:
        """Whether both depend on the generator in the same way, and mean and scatter agree."""
        if answer is None or got is None:
            return answer is got
        return answer[2] is got[2] and bool(Close(rtol=self.rtol, atol=1e-6).compare(answer[:2], got[:2]))
