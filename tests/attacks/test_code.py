"""No hostile code gains a point, changes a neighbour's, or leaves anything behind."""

from collections import Counter

import pytest

from tests.attacks import laws
from tests.attacks.code import ATTACKS
from tests.attacks.range import POINTS, REAL_POINTS, ROWS

CODE_ROWS = set(ROWS) - {"broken", "styles", "honest"}


@pytest.fixture(scope="module")
def alone(field):
    return laws.alone(field(), ATTACKS)


@pytest.fixture(scope="module")
def graded(field):
    return field().run(ATTACKS)


def test_the_catalogue_covers_every_row_that_is_about_code():
    assert {attack.row for attack in ATTACKS} >= CODE_ROWS
    assert not [name for name, count in Counter(attack.name for attack in ATTACKS).items() if count > 1]
    for attack in ATTACKS:
        worth = POINTS | REAL_POINTS
        assert attack.row in ROWS and all(0 < points <= worth[name] for name, points in attack.honest.items())


@pytest.mark.slow
def test_an_undisturbed_run_gives_the_neighbours_their_points(alone):
    laws.nothing_is_left(alone)


@pytest.mark.slow
def test_the_run_ends_well_and_leaves_nothing(graded):
    laws.nothing_is_left(graded)


@pytest.mark.slow
@pytest.mark.parametrize("attack", ATTACKS, ids=lambda attack: attack.name)
def test_an_attack_gains_nothing_and_disturbs_nobody(attack, graded, alone, hidden):
    laws.gained_nothing(graded, ATTACKS, attack)
    laws.page_is_safe(graded, ATTACKS, attack, hidden)
    laws.neighbours_are_undisturbed(graded, ATTACKS, attack, alone)
