"""How many hostile submissions the grader withstands at each level of the sandbox that a machine may have.

``sudo .venv/bin/python -m benchmarks siege`` grades hostile submissions of `tests/attacks` at each level below `full`,
between two ordinary ones, as a user without rights who owns all that they may harm: every submission whose outcome
depends on the layers of the sandbox, and every fifth of the others. A submission is withstood if it earns no more than
its stated points, takes no longer than a submission may take, changes neither its neighbours' points nor their pages,
puts no hidden number on its page, and leaves no file and no process behind.
"""

import json
import os
import sqlite3
from collections import Counter
from collections.abc import Callable, Sequence

from benchmarks import RESULTS, Result, Table
from nao_course.instructor.sandbox.confinement import UNUSED_USER
from nao_course.instructor.sandbox.layers import LEVELS, LINUX_LAYERS, NAMESPACES
from tests.attacks import laws
from tests.attacks.catalogue import AT_LOWER_LEVELS, KINDS
from tests.attacks.range import Attack, Graded, Range, ranges

OFF = {  # the layers that a machine of a level lacks
    "namespaces": ("landlock", "seccomp"),
    "landlock": (*NAMESPACES, "seccomp", "unprivileged user"),
    "process": LINUX_LAYERS,
}
SECONDS_OF_A_RUN = 150.0  # and for each attack in it
SECONDS_OF_AN_ATTACK = 15.0
TOGETHER = 40  # attacks of a run
USER = UNUSED_USER + 1


def withstood(level: str) -> set[str]:
    """Return the names of the attacks that were withstood at a level when the benchmark last ran."""
    passed = json.loads((RESULTS / "siege.json").read_text(encoding="utf-8"))["not withstood"][level]
    return {each.name for each in AT_LOWER_LEVELS} - set(passed)


def broken(graded: Graded, attack: Attack, neighbours: Graded, hidden: set[str]) -> str:
    """Return the law that does not hold for an attack, or an empty string."""
    checks: dict[str, Callable[[], None]] = {
        "points": lambda: laws.is_no_better_off(graded, attack),
        "page": lambda: laws.page_is_safe(graded, attack, hidden),
        "neighbours": lambda: laws.neighbours_are_undisturbed(graded, attack, neighbours),
    }
    for name, check in checks.items():
        try:
            check()
        except AssertionError:
            return name
        except KeyError:  # its own result or a neighbour's
            return "results"
    return ""


def left(graded: Graded) -> str:
    """Return the first thing that a run over attacks left or did not finish, or an empty string."""
    if graded.processes or graded.status < 0:
        return "processes"
    if graded.changed:
        return "files"
    if graded.heard:
        return "network"
    try:
        laws.nothing_is_left(graded)
    except AssertionError:
        return "run"
    return ""


class Siege:
    """The runs of one level."""

    def __init__(self, level: str, make: Callable[..., Range]) -> None:
        self.level, self.make = level, make
        self.neighbours = laws.alone(self.place(1), AT_LOWER_LEVELS)
        self.hidden = laws.hidden(make())

    def place(self, attacks: int) -> Range:
        """Return a new range for some attacks."""
        seconds = SECONDS_OF_A_RUN + SECONDS_OF_AN_ATTACK * attacks
        return self.make(off=OFF[self.level], user=USER, most_seconds=seconds)

    def grade(self, attacks: Sequence[Attack]) -> dict[str, str]:
        """Return the law that each attack breaks, or an empty string, by name.

        If a run is disturbed, the attacks that did not earn too much are graded once more without the others, and in
        halves until it is known which of them it is.
        """
        try:
            graded = self.place(len(attacks)).run(attacks)
        except (OSError, ValueError, sqlite3.Error):  # the journal or the submissions are missing
            found, rest = dict.fromkeys((each.name for each in attacks), "journal"), "journal"
        else:
            found = {each.name: broken(graded, each, self.neighbours, self.hidden) for each in attacks}
            rest = left(graded)
        if len(attacks) == 1:
            return {name: law or rest for name, law in found.items()}
        if not rest and not {"neighbours", "results"} & set(found.values()):
            return found
        others = [each for each in attacks if found[each.name] != "points"]
        if len(others) < len(attacks):
            return found | (self.grade(others) if others else {})
        middle = len(attacks) // 2
        return self.grade(attacks[:middle]) | self.grade(attacks[middle:])


def measure(level: str, attacks: Sequence[Attack] = AT_LOWER_LEVELS) -> dict[str, str]:
    """Return the law that each attack breaks at a level, or an empty string, by name."""
    with ranges() as make:
        siege = Siege(level, make)
        found: dict[str, str] = {}
        for start in range(0, len(attacks), TOGETHER):
            found |= siege.grade(attacks[start : start + TOGETHER])
        return found


def main() -> Result:
    """Grade the catalogue at each lower level."""
    if os.geteuid() != 0:
        raise FileNotFoundError(
            "it has to be started by root, because the attacks run as a user without rights"
        )
    found = {level: measure(level) for level in LEVELS[:-1]}
    kinds = {each.name: KINDS[each.row] for each in AT_LOWER_LEVELS}
    rows: dict[str, dict[str, list[int]]] = {}
    for level, laws_ in found.items():
        held = Counter(kinds[name] for name, law in laws_.items() if not law)
        for kind, graded in Counter(kinds[name] for name in laws_).items():
            rows.setdefault(kind, {})[level] = [held[kind], graded]
    passed = {level: {name: law for name, law in laws_.items() if law} for level, laws_ in found.items()}
    shown = {kind: {level: "{} of {}".format(*of) for level, of in row.items()} for kind, row in rows.items()}
    title = "Hostile submissions that were withstood, of all that were graded"
    return Result("siege", {"withstood": rows, "not withstood": passed}, (Table.of(title, shown),))
