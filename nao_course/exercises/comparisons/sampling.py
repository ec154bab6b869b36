"""Functions that draw random samples: many calls are made of one, and the mean and scatter of its answers compared."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from nao_course.exercises.case import Case, copied
from nao_course.exercises.codec import register
from nao_course.exercises.comparisons.comparison import Comparison, Verdict, as_text, with_article
from nao_course.exercises.comparisons.structure import as_numbers
from nao_course.exercises.comparisons.values import Close
from nao_course.exercises.running import register_driver

_REPEATED = 20  # seeds that are drawn with twice: the same generator has to give the same answer


@register_driver
def each_seed(function: Callable[..., Any], *given: Any) -> list[Any]:
    """Call a function that draws random samples once with each seed's generator; what it answers comes back as it is.

    Parameters
    ----------
    function : callable
        ``function(..., rng) -> float``.
    *given : object
        Its arguments, and last of all, in place of the generator, the seeds.

    Returns
    -------
    list
        One answer for each seed.
    """
    *args, seeds = given
    return [function(*map(copied, args), np.random.default_rng(seed)) for seed in seeds]


@register
@dataclass(frozen=True)
class Sampled(Comparison):
    """A function ``function(..., rng) -> float`` that draws random samples, judged by the law of its answers.

    The last argument of a case says how many calls the driver `each_seed` makes of it; a generator takes its place. The
    seeds are drawn here and the answers judged here, so that nothing is decided where the function runs.

    Parameters
    ----------
    rtol : float
        Of the mean and the standard deviation of its answers: they are themselves sampled.
    """

    rtol: float = 0.25

    def calls(self, case: Case) -> Sequence[Case]:
        """The case with the seeds to call with, the first ones twice."""
        *args, repeats = case.args
        seeds = [*range(repeats), *range(min(repeats, _REPEATED))]
        return [Case((*args, seeds), case.name, case.kwargs)]

    def gather(self, case: Case, answers: Iterable[Any]) -> dict[str, Any]:
        """Return the law of the answers.

        Returns
        -------
        dict
            "law": mean, standard deviation, and whether the same seeds gave the same answers again; "calls": how many
            there were. Where an answer is no number, "other" instead: what it is. No answer can look like this itself.
        """
        (drawn_there,) = answers
        if not isinstance(drawn_there, list) or len(drawn_there) < 2:
            return {"other": "no list of answers"}
        other = next((each for each in drawn_there if not _is_number(each)), 0.0)
        if not _is_number(other):
            return {"other": "" if other is None else with_article(other)}
        numbers = np.array([float(each) for each in drawn_there])
        again = min(len(numbers) // 2, _REPEATED)
        drawn = numbers[: len(numbers) - again]
        same = bool((drawn[:again] == numbers[len(drawn) :]).all())
        with np.errstate(all="ignore"):
            return {"law": (float(drawn.mean()), float(drawn.std()), same), "calls": len(numbers)}

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare the law of the answers with the expected one."""
        if "law" in got and got["calls"] != expected["calls"]:
            return Verdict("type", f"your answers are {got['calls']}, not one for each call")
        if "law" not in got:
            if not got["other"]:
                return Verdict("nothing", "your answer is None: a return may be missing")
            return Verdict("type", f"your answer is {got['other']}, not one number")
        mean, scatter, repeatable = got["law"]
        if not repeatable:
            return Verdict(
                "value", "the same rng gave two different answers; rng.integers or rng.choice draw from it"
            )
        law = Close(rtol=self.rtol, names=("the mean of your answers", "the scatter of your answers"))
        verdict = law.compare(expected["law"][:2], (mean, scatter))
        if verdict.kind == "value" and Close().compare(0.0, scatter):
            text = f"whatever rng it gets, your answer is the same, {as_text(mean)}: draw with the rng it is given"
            return Verdict("value", text)
        return verdict

    def alike(self, answer: Any, got: Any) -> bool:
        """Whether both depend on the generator in the same way, and mean and scatter agree."""
        if "law" not in answer or "law" not in got:
            return bool(answer == got)
        one, other = answer["law"], got["law"]
        return one[2] is other[2] and bool(Close(rtol=self.rtol, atol=1e-6).compare(one[:2], other[:2]))


def _is_number(answer: Any) -> bool:
    if type(answer) is float:  # nearly always
        return True
    number = as_numbers(answer, "your answer")
    return not isinstance(number, Verdict) and number.shape == () and number.dtype.kind != "b"
