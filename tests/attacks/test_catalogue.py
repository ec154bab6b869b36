"""No hostile or odd submission gains a point, changes a neighbour's page, or leaves anything behind."""

import csv
import io
import os
import re
import subprocess
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.course.siege import OFF, USER, withstood
from tests.attacks import accidents, laws
from tests.attacks.catalogue import HOSTILE, KINDS
from tests.attacks.code import ATTACKS, SPREADSHEETS
from tests.attacks.conftest import LAYERS
from tests.attacks.range import POINTS, REAL_POINTS, ROWS, Attack, all_but, lined_up, points
from tests.paths import PROJECT
from tests.toy import pair


def test_the_catalogues_cover_every_row_and_a_name_stands_once():
    every = (*ATTACKS, *accidents.ATTACKS)
    assert {attack.row for attack in every} == set(ROWS) == set(KINDS)
    assert max(Counter(attack.name for attack in every).values()) == 1
    worth = POINTS | REAL_POINTS | pair.POINTS
    for attack in every:
        assert all(0 < points <= worth[name] for name, points in attack.honest.items())


@pytest.mark.parametrize("attacks", [ATTACKS, accidents.ATTACKS], ids=["hostile", "accidents"])
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
    laws.hold(graded, attack, alone, hidden)


@pytest.mark.slow
def test_what_is_made_of_the_grades_runs_nowhere(field):
    besieged = field()
    besieged.run([*SPREADSHEETS, *(each for each in ATTACKS if each.name.startswith("injects"))])
    own = {"NAO_COURSE_SECRET": str(besieged.root / "secret"), "PYTHONPATH": str(PROJECT)}
    options = {"cwd": besieged.course.root, "env": os.environ | own, "capture_output": True, "text": True}
    for words in (["export", "--format", "csv"], ["report"]):
        command = [sys.executable, "-m", "nao_course.cli", *words, str(besieged.grades)]
        done = subprocess.run(command, **options)
        assert done.returncode == 0, done.stderr[-2000:]
    made = [path for path in besieged.grades.rglob("*") if path.suffix in (".csv", ".html")]
    assert {path.suffix for path in made} == {".csv", ".html"}
    assert any("nao_attack" in path.read_text(encoding="utf-8") for path in made), "nothing was said anywhere"
    for path in made:
        text = path.read_text(encoding="utf-8-sig")
        if path.suffix == ".html":
            parser = laws.Elements()
            parser.feed(text)
            assert "nao_attack" not in parser.seen, path
            continue
        for separator in ",;\t|":
            rows = csv.reader(io.StringIO(text, newline=""), delimiter=separator)
            assert not [cell for row in rows for cell in row if re.match(r"\s*[=+@-].*nao_attack", cell)], (
                path
            )


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


# --- lower levels ---


@pytest.mark.slow
@pytest.mark.parametrize("level", OFF)
def test_a_lower_level_withstands_what_the_page_counts(level, field):
    """A sample: `python -m benchmarks siege` grades all. Only root may lend the hostile ones another user."""
    some = [each for each in accidents.ATTACKS if each.row == "large"][::9]
    user = USER if os.geteuid() == 0 else None
    if user:
        some += [each for each in HOSTILE if each.name in withstood(level)][::25]
    below = field(off=OFF[level], user=user)
    graded = below.run(some)
    laws.nothing_is_left(graded)
    assert {result.level for result in graded.results.values()} == {level}
    hidden = laws.hidden(below)
    for attack in some:
        laws.is_no_better_off(graded, attack)
        laws.page_is_safe(graded, attack, hidden)


# What takes from nobody but the range: it may be seen to succeed where the walls are down.
VISIBLE = {
    *("reads_the_solution", "reads_another_submission", "reads_the_secret", "reads_the_users", "real_theft"),
    *("reads_through_a_link", "lists_the_submissions", "looks_for_what_the_one_before_left"),
    *("writes_where_anyone_may", "connects_by_tcp", "sends_by_udp", "unix_socket", "abstract_socket"),
}


@pytest.mark.slow
def test_without_walls_the_same_attacks_succeed_and_are_seen(field):
    attacks = [attack for attack in ATTACKS if attack.name in VISIBLE]
    graded = field(off=LAYERS).run(attacks)
    gained = [
        attack.name
        for attack in attacks
        if points(graded.results[laws.student_of(graded, attack)]) != dict(attack.honest)
    ]
    kept = {"looks_for_what_the_one_before_left"}  # each process has a folder of its own at every level
    assert set(gained) == VISIBLE - kept
    assert set(graded.heard) == {"TCP", "UDP", "UNIX", "ABSTRACT"}
    assert any(name.endswith("nao_attack") for name in graded.changed)
