"""No hostile code gains a point, changes a neighbour's, or leaves anything behind."""

from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from tests.attacks import accidents, fourth_siege, laws, siege
from tests.attacks.code import ATTACKS
from tests.attacks.conftest import LAYERS
from tests.attacks.range import POINTS, REAL_POINTS, ROWS, Attack, all_but, lined_up, points
from tests.toy import pair

CODE_ROWS = set(ROWS) - {"broken", "styles", "honest"}


def test_the_catalogue_covers_every_row_that_is_about_code():
    assert {attack.row for attack in ATTACKS} >= CODE_ROWS
    assert not [name for name, count in Counter(attack.name for attack in ATTACKS).items() if count > 1]
    for attack in ATTACKS:
        worth = POINTS | REAL_POINTS | pair.POINTS
        assert attack.row in ROWS and all(0 < points <= worth[name] for name, points in attack.honest.items())


@pytest.mark.parametrize(
    "attacks",
    [ATTACKS, siege.ATTACKS, accidents.ATTACKS, fourth_siege.ATTACKS],
    ids=["code", "siege", "accidents", "fourth"],
)
def test_each_attack_stands_between_right_and_half_right_work_of_its_own_lesson(attacks):
    line = list(lined_up(attacks).values())
    assert list(lined_up(attacks)) == sorted(lined_up(attacks))
    assert [each for each in line if each.name not in ("right", "half")] == list(attacks)
    for before, attack, after in zip(line, line[1:], line[2:], strict=False):
        if attack.name not in ("right", "half"):
            assert {before.name, after.name} == {"right", "half"}
            assert before.lesson == attack.lesson == after.lesson


@pytest.mark.slow
def test_an_undisturbed_run_gives_the_neighbours_their_points(alone):
    laws.nothing_is_left(alone)


@pytest.mark.slow
def test_the_run_ends_well_and_leaves_nothing(graded):
    laws.nothing_is_left(graded)


@pytest.mark.slow
@pytest.mark.parametrize("attack", ATTACKS, ids=lambda attack: attack.name)
def test_an_attack_gains_nothing_and_disturbs_nobody(attack, graded, alone, hidden):
    laws.gained_nothing(graded, attack)
    laws.page_is_safe(graded, attack, hidden)
    laws.neighbours_are_undisturbed(graded, attack, alone)


SLOW = """
import time
def drawn(rng, n):
    began = time.process_time()
    while time.process_time() - began < 0.3: pass
    return rng.normal(size=n).cumsum()
"""


def _shared_by_session():
    """Whether the kernel shares processors out by session: it must be told to, and no group may do so instead."""
    switch = Path("/proc/sys/kernel/sched_autogroup_enabled")
    groups = [line.split(":") for line in Path("/proc/self/cgroup").read_text().splitlines()]
    mine = next((path for _, kinds, path in groups if "cpu" in kinds.split(",")), groups[-1][2])
    return switch.exists() and switch.read_text().strip() == "1" and mine == "/"


@pytest.mark.slow
def test_an_honest_function_that_needs_its_time_has_it_beside_forty_busy_children(field):
    if not _shared_by_session():
        pytest.skip("this kernel does not share processors out by session")
    busy = next(attack for attack in ATTACKS if attack.name == "children_that_take_all_processors")
    pairs = [
        (replace(busy, name=f"busy{number}"), Attack(f"slow{number}", "honest", all_but(), {"drawn": SLOW}))
        for number in range(4)
    ]
    attacks = [attack for pair in pairs for attack in pair]
    graded = field().run(attacks)
    laws.nothing_is_left(graded)
    for attack in attacks:
        laws.gained_nothing(graded, attack)


# What takes from nobody but the range: it may be seen to succeed where the walls are down.
HARMLESS = {
    *(
        "reads_the_solution",
        "reads_another_submission",
        "reads_the_secret",
        "reads_a_private_key",
        "reads_the_tests",
    ),
    *(
        "lists_the_submissions",
        "reads_the_users",
        "reads_through_a_link",
        "looks_for_what_the_one_before_left",
    ),
    *(
        "writes_where_anyone_may",
        "connects_by_tcp",
        "sends_by_udp",
        "unix_socket",
        "abstract_socket",
        "real_theft",
    ),
}


@pytest.mark.slow
def test_without_walls_the_same_attacks_succeed_and_are_seen(field):
    attacks = [attack for attack in ATTACKS if attack.name in HARMLESS]
    graded = field(off=LAYERS).run(attacks)
    gained = [
        attack.name
        for attack in attacks
        if points(graded.results[laws.student_of(graded, attack)]) != dict(attack.honest)
    ]
    kept = {"looks_for_what_the_one_before_left"}  # each process has a folder of its own at every level
    assert set(gained) == HARMLESS - kept
    assert set(graded.heard) == {"TCP", "UDP", "UNIX", "ABSTRACT"}
    assert any(name.endswith("nao_attack") for name in graded.changed)
