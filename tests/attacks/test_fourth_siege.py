"""The fourth catalogue gains nothing, and a large notebook earns what a small one does."""

from collections import Counter

import pytest

from tests.attacks import accidents, code, laws, siege
from tests.attacks.conftest import LAYERS
from tests.attacks.fourth_siege import ATTACKS, HARMLESS
from tests.attacks.range import ROWS

NAMESPACES = [name for name in LAYERS if name.endswith("namespace")]
OFF = {
    "namespaces": ["landlock", "seccomp"],
    "landlock": [*NAMESPACES, "seccomp", "unprivileged user"],
    "process": LAYERS,
}


def test_a_name_stands_once_in_all_catalogues():
    before = {attack.name for attack in (*code.ATTACKS, *accidents.ATTACKS, *siege.ATTACKS)}
    names = Counter(attack.name for attack in ATTACKS)
    assert not [name for name, count in names.items() if count > 1 or name in before]
    assert all(attack.row in ROWS for attack in ATTACKS)


@pytest.mark.slow
def test_the_run_ends_well_and_leaves_nothing(graded):
    laws.nothing_is_left(graded)


@pytest.mark.slow
@pytest.mark.parametrize("attack", ATTACKS, ids=lambda attack: attack.name)
def test_an_attack_gains_nothing_and_disturbs_nobody(attack, graded, alone, hidden):
    laws.gained_nothing(graded, attack)
    laws.page_is_safe(graded, attack, hidden)
    laws.neighbours_are_undisturbed(graded, attack, alone)


@pytest.mark.slow
@pytest.mark.parametrize("level", OFF)
def test_a_lower_level_grades_large_and_odd_notebooks_in_the_same_way(level, field):
    some = HARMLESS[:: 5 if level == "process" else 9]
    below = field(off=OFF[level])
    graded = below.run(some)
    laws.nothing_is_left(graded)
    assert {result.level for result in graded.results.values()} == {level}
    for attack in some:
        laws.gained_nothing(graded, attack)
        laws.page_is_safe(graded, attack, laws.hidden(below))
