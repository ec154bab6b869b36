"""A later siege gains nothing either, and what is made of its grades runs nowhere."""

import csv
import io
import os
import re
import subprocess
import sys
from collections import Counter

import pytest

from tests.attacks import accidents, code, laws
from tests.attacks.range import ROWS
from tests.attacks.siege import ATTACKS, SPREADSHEETS
from tests.paths import PROJECT


def test_a_name_stands_once_in_all_catalogues():
    before = {attack.name for attack in (*code.ATTACKS, *accidents.ATTACKS)}
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
def test_what_is_made_of_the_grades_runs_nowhere(field):
    besieged = field()
    besieged.run([*SPREADSHEETS, *(each for each in code.ATTACKS if each.name.startswith("injects"))])
    environment = os.environ | {
        "NAO_COURSE_SECRET": str(besieged.root / "secret"),
        "PYTHONPATH": str(PROJECT),
    }
    for words in (["export", "--format", "csv"], ["report"]):
        command = [sys.executable, "-m", "nao_course.cli", *words, str(besieged.grades)]
        done = subprocess.run(
            command, cwd=besieged.course.root, env=environment, capture_output=True, text=True
        )
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
