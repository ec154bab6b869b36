"""Entries to lesson 05's challenge: no name, all entries beside finite differences, one after the other, a plan."""

from collections import Counter
from collections.abc import Callable, Iterable
from functools import cache
from itertools import product

from nao_course.lessons.ekf_derivations.mistakes import COLUMNS, MISTAKES, ROWS, jacobian_at, with_mistake

Ask = Callable[..., float]
Entry = tuple[int, int]

POSE, LANDMARK = (0.3, -0.2, 0.7), (2.1, 1.0)  # a place where no two mistakes look alike
ENTRIES: tuple[Entry, ...] = tuple(product(range(len(ROWS)), range(len(COLUMNS))))
_DIGITS = 4  # to which two values are the same


@cache
def told(name: str, entry: Entry) -> float:
    """Return the value of an entry in a Jacobian with a mistake, or in the right one if there is no name."""
    matrix = with_mistake(name, POSE, LANDMARK) if name else jacobian_at(POSE, LANDMARK)
    return round(float(matrix[entry]), _DIGITS) + 0.0


def left(names: Iterable[str], entry: Entry, value: float) -> list[str]:
    """Return the mistakes with which the entry would have this value."""
    return [name for name in names if told(name, entry) == value]


def no_name(ask: Ask) -> str:
    """Return the first mistake of the catalogue in every case."""
    return next(iter(MISTAKES))


def brute_force(ask: Ask) -> str:
    """Ask for all ten entries, and only then compare them with the right ones."""
    names = list(MISTAKES)
    values = {entry: round(ask(*entry, POSE, LANDMARK), _DIGITS) + 0.0 for entry in ENTRIES}
    for entry, value in values.items():
        names = left(names, entry, value)
    return names[0]


def one_after_the_other(ask: Ask) -> str:
    """Ask for entries in reading order until one mistake is left."""
    names = list(MISTAKES)
    for entry in ENTRIES:
        if len(names) > 1:
            names = left(names, entry, round(ask(*entry, POSE, LANDMARK), _DIGITS) + 0.0)
    return names[0]


def best_question(names: tuple[str, ...]) -> Entry:
    """Return the entry whose value leaves the fewest mistakes on average."""

    def remaining(entry: Entry) -> float:
        return sum(count**2 for count in Counter(told(name, entry) for name in names).values())

    return min(ENTRIES, key=remaining)


def planned(ask: Ask) -> str:
    """Ask for the entry that splits the mistakes that are left best."""
    names = list(MISTAKES)
    while len(names) > 1:
        entry = best_question(tuple(names))
        names = left(names, entry, round(ask(*entry, POSE, LANDMARK), _DIGITS) + 0.0)
    return names[0]


JACOBIAN_ENTRIES = {
    "nothing": no_name,
    "brute force": brute_force,
    "the reference": one_after_the_other,
    "a better plan": planned,
}
