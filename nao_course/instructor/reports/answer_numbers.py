"""Numbers of personal worlds in written answers, and how probable it is that they are there by chance."""

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

SIGNIFICANT = 5  # digits that two right computations have in common
MOST_CHANCE = 0.01  # of an unrelated answer that agrees with a world; above it, no world is named
# A sign right after a digit, a letter or a bracket is a dash: "0.30-0.45" is a range.
_DECIMAL = re.compile(
    r"(?<![\d.,])((?<![\w)\]])[-\u2212\u2013])?(\d{1,6})[.,](\d{2,20})(?!\d)(?:[eE](-?\d))?", re.ASCII
)


class Written(NamedTuple):
    """A number as it is written in a text, and the largest difference from a value that is written like this."""

    value: float
    rounding: float

    def is_rounded(self, value: float) -> bool:
        """Return whether this may be a value, rounded as it is written or computed in another way."""
        return abs(self.value - value) <= self.tolerance(value)

    def tolerance(self, value: float) -> float:
        """Return the largest difference at which a value counts as equal."""
        unit = 10.0 ** (math.floor(math.log10(abs(value))) + 1 - SIGNIFICANT) if value else 0.0
        return max(self.rounding, unit / 2)


def numbers_in(text: str) -> list[Written]:
    """Return the numbers of a text that have two or more decimals, with a point or a comma.

    >>> [each.value for each in numbers_in("between 0.30-0.45 m, at \u22120,25 rad or 3.20e-2, 1.5 or 2 times")]
    [0.3, 0.45, -0.25, 0.032]
    """
    found = []
    for sign, whole, decimals, exponent in _DECIMAL.findall(text):
        scale = 10.0 ** int(exponent or 0)
        value = float(f"{whole}.{decimals}") * scale * (-1 if sign else 1)
        found.append(Written(value, 0.501 * scale * 10.0 ** -len(decimals)))
    return found


def compare_numbers(answer: str, student: str, worlds: Mapping[str, Mapping[str, float]]) -> Iterator[str]:
    """Compare an answer with the numbers of the student's personal world.

    `worlds` are numbers of each student's personal world by what they are. Yield the student's numbers, and whether
    they are in the answer; then the worlds with which the answer agrees instead, if this is unlikely to be chance.
    """
    own = worlds.get(student, {})
    if not own:
        return
    written = numbers_in(answer)
    found = {name: any(each.is_rounded(value) for each in written) for name, value in own.items()}
    each = (
        f"{name} {value:.3f} ({'in the answer' if found[name] else 'not in the answer'})"
        for name, value in own.items()
    )
    yield f"Personal world: {'; '.join(each)}"
    if all(found.values()):
        return
    others = {name: numbers for name, numbers in worlds.items() if name != student}
    agreeing = [name for name, numbers in others.items() if _agrees(written, numbers.values())]
    chance = chance_of_agreement(written, agreeing, worlds)
    if agreeing and chance <= MOST_CHANCE:
        yield (
            f"These numbers agree with the world of {', '.join(agreeing)}. With {len(others)} other worlds, an "
            f"unrelated answer of this precision agrees with one in {100 * chance:.1g} % of all cases."
        )


def _agrees(written: Sequence[Written], values: Iterable[float]) -> bool:
    return all(any(each.is_rounded(value) for each in written) for value in values)


def chance_of_agreement(
    written: Sequence[Written], agreeing: Iterable[str], worlds: Mapping[str, Mapping[str, float]]
) -> float:
    """Return the probability that an unrelated answer of the same precision agrees with a world.

    The numbers of an unrelated answer are assumed to be distributed as the numbers of the worlds are, as normal
    variables: the difference of two has twice their covariance, and its density at zero times the tolerances is the
    probability of one coincidence. Each number of the answer that lies among the numbers of the worlds is one more
    occasion for it. `agreeing` are the worlds with which the answer agrees. The probability is 1 if there are too few
    worlds to estimate it.
    """
    table = np.array([list(numbers.values()) for numbers in worlds.values()])
    count, dimensions = table.shape
    if count <= dimensions + 1:
        return 1.0
    covariance = np.atleast_2d(np.cov(table, rowvar=False))
    density = 1 / math.sqrt(max((4 * math.pi) ** dimensions * np.linalg.det(covariance), 1e-300))
    low, high = table.min(axis=0), table.max(axis=0)
    once = 0.0
    for name in agreeing:
        probability = density
        for number, value in enumerate(worlds[name].values()):
            occasions = {each.value for each in written if low[number] <= each.value <= high[number]}
            tolerance = min(each.tolerance(value) for each in written if each.is_rounded(value))
            probability *= 2 * tolerance * max(len(occasions), 1)
        once = max(once, probability)
    return 1 - (1 - min(once, 1.0)) ** (count - 1)
