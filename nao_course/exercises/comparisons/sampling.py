"""Compare functions that draw random samples by the mean and the scatter of many answers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt
from numpy.random.bit_generator import ISpawnableSeedSequence

from nao_course.codec import register
from nao_course.exercises.case import Case, copied
from nao_course.exercises.comparisons.comparison import Comparison, Verdict, as_text, with_article
from nao_course.exercises.comparisons.structure import as_numbers
from nao_course.exercises.comparisons.values import Close
from nao_course.exercises.running import register_driver

_PREPARED = 260  # seeds, of the largest case
_REPEATED = 8  # seeds that are used twice, because equal generators must give equal answers


@register_driver
def each_seed(function: Callable[..., Any], *given: Any) -> list[Any] | npt.NDArray[np.float64]:
    """Call ``function(..., rng) -> float`` once with each seed's generator, and return its answers.

    The last argument contains the seeds in place of the generator. The last call gets the arguments themselves, so that
    a change of them is noticed. Answers that are all floats are an array, because it is sent much faster.
    """
    *args, seeds = given
    last = len(seeds) - 1
    answers = [
        function(*(args if number == last else map(copied, args)), _generator(int(seed)))
        for number, seed in enumerate(seeds)
    ]
    return np.array(answers) if all(type(each) is float for each in answers) else answers


def _generator(seed: int) -> np.random.Generator:
    """Return the same generator as ``np.random.default_rng(seed)``, for a seed that is used often."""
    return np.random.Generator(np.random.PCG64(_KnownSeed(seed)))  # type: ignore[arg-type]


class _KnownSeed(ISpawnableSeedSequence):
    """A seed whose words are computed once: that takes most of the time in which a generator is made."""

    def __init__(self, seed: int) -> None:
        self.seed = seed
        self.whole: np.random.SeedSequence | None = None

    def generate_state(self, n_words: int, dtype: Any = np.uint32) -> npt.NDArray[Any]:
        """Return the words that the seed stands for."""
        return _words(self.seed, n_words, np.dtype(dtype).str)

    def spawn(self, n_children: int) -> list[np.random.SeedSequence]:  # type: ignore[override]
        """Return seeds of further generators, other ones each time."""
        self.whole = self.whole or np.random.SeedSequence(self.seed)
        return self.whole.spawn(n_children)


@cache
def _words(seed: int, count: int, dtype: str) -> npt.NDArray[Any]:
    words = np.random.SeedSequence(seed).generate_state(count, np.dtype(dtype).type)
    words.flags.writeable = False
    return words


def prepare_seeds() -> None:
    """Compute the words of the usual seeds, so that processes that are forked need not do it."""
    for seed in range(_PREPARED):
        _generator(seed)


@register
@dataclass(frozen=True)
class Sampled(Comparison):
    """Comparison of a function ``function(..., rng) -> float`` by the distribution of its random answers.

    The last argument of a case is the number of calls by the driver `each_seed`, which replaces it by a generator. The
    seeds are drawn, and the answers are judged, outside of the process that runs the function.

    Parameters
    ----------
    rtol : float
        Relative tolerance of the mean and the standard deviation of the answers, which are themselves random.
    chance : float
        Probability that a right function fails the Kolmogorov-Smirnov test, which compares the distribution of its
        answers with the reference's.
    """

    rtol: float = 0.25
    chance: float = 1e-5

    def calls(self, case: Case) -> Sequence[Case]:
        """Return the case with its seeds, some of which are repeated."""
        *args, repeats = case.args
        seeds = [*range(repeats), *range(min(repeats, _REPEATED))]
        return [Case((*args, np.array(seeds)), case.name, case.kwargs)]

    def gather(self, case: Case, answers: Iterable[Any]) -> dict[str, Any]:
        """Return the statistics of the answers.

        Returns
        -------
        dict
            "law": mean, standard deviation, and whether the same seeds gave the same answers again; "drawn": the
            answers in ascending order; "calls": their number. If an answer is not a number: "other", its type. No
            answer can look like this itself.
        """
        (drawn_there,) = answers
        row = isinstance(drawn_there, np.ndarray) and drawn_there.dtype == float and drawn_there.ndim == 1
        if not (row or isinstance(drawn_there, list)) or len(drawn_there) < 2:
            return {"other": "not a list of answers"}
        other = 0.0 if row else next((each for each in drawn_there if not _is_number(each)), 0.0)
        if not _is_number(other):
            return {"other": "" if other is None else with_article(other)}
        numbers = drawn_there if row else np.array([float(each) for each in drawn_there])
        again = min(len(numbers) // 2, _REPEATED)
        drawn = numbers[: len(numbers) - again]
        same = bool((drawn[:again] == numbers[len(drawn) :]).all())
        with np.errstate(all="ignore"):
            law = (float(drawn.mean()), float(drawn.std()), same)
        return {"law": law, "drawn": np.sort(drawn), "calls": len(numbers)}

    def compare(self, expected: Any, got: Any) -> Verdict:
        """Compare the statistics of the answers with the expected statistics."""
        if "law" in got and got["calls"] != expected["calls"]:
            return Verdict("type", f"your answers are {got['calls']}, not one for each call")
        if "law" not in got:
            if not got["other"]:
                return Verdict("nothing", "your answer is None: a return may be missing")
            return Verdict("type", f"your answer is {got['other']}, not one number")
        mean, scatter, repeatable = got["law"]
        if not repeatable:
            return Verdict(
                "value", "the same rng gave two different answers: draw with rng.integers or rng.choice"
            )
        law = Close(rtol=self.rtol, names=("the mean of your answers", "the scatter of your answers"))
        verdict = law.compare(expected["law"][:2], (mean, scatter))
        if verdict.kind == "value" and Close().compare(0.0, scatter):
            text = f"your answer is {as_text(mean)} for every rng, but it should vary with the drawn values"
            return Verdict("value", text)
        if verdict and self._differs(expected["drawn"], got["drawn"]):
            return Verdict(
                "law",
                "the mean and the scatter of your answers are right, but not their distribution: each answer should be "
                "the mean of values that were drawn",
            )
        return verdict

    def _differs(self, expected: Any, got: Any) -> bool:
        """Return whether the Kolmogorov-Smirnov test tells two samples apart."""
        values = np.concatenate([expected, got])
        ranks = [np.searchsorted(each, values, side="right") / len(each) for each in (expected, got)]
        critical = np.sqrt(-np.log(self.chance / 2) / 2 * (1 / len(expected) + 1 / len(got)))
        return bool(np.abs(ranks[0] - ranks[1]).max() > critical)

    def alike(self, answer: Any, got: Any) -> bool:
        """Return whether both depend on the generator in the same way, and mean and scatter agree."""
        if "law" not in answer or "law" not in got:
            return bool(answer == got)
        one, other = answer["law"], got["law"]
        return (
            one[2] is other[2]
            and bool(Close(rtol=self.rtol, atol=1e-6).compare(one[:2], other[:2]))
            and not self._differs(answer["drawn"], got["drawn"])
        )


def _is_number(answer: Any) -> bool:
    if type(answer) is float:  # nearly always
        return True
    number = as_numbers(answer, "your answer")
    return not isinstance(number, Verdict) and number.shape == () and number.dtype.kind != "b"
