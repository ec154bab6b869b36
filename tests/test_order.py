"""The order in which tests begin: it names tests that there are, loses none, and keeps a file's tests together."""

import re
import subprocess
import sys
from itertools import groupby

import pytest

from tests.changed import LAWS, mirrors_of
from tests.order import APART, FIRST, in_order, unit_of
from tests.paths import PROJECT

SOME = [
    "tests/sim/test_render.py::test_few",
    *(f"tests/test_slam.py::test_law[{number}]" for number in range(3)),
    f"tests/lessons/test_exercises.py::{APART[0]}[01]",
    "tests/lessons/test_exercises.py::test_a_rule[01]",
    f"tests/lessons/test_exercises.py::{APART[0]}[02]",
    f"{FIRST[0]}::test_long",
]


def test_what_begins_first_and_what_stands_apart_is_there():
    for each in set(FIRST) - set(APART):
        assert (PROJECT / each).is_file(), each
    source = "\n".join(path.read_text(encoding="utf-8") for path in (PROJECT / "tests").rglob("test_*.py"))
    assert set(APART) <= set(FIRST) and set(APART) <= set(re.findall(r"^def (\w+)\(", source, re.MULTILINE))


def test_the_longest_begin_then_the_files_of_the_most_tests_and_none_is_lost():
    places = in_order(SOME)
    assert sorted(places) == list(range(len(SOME)))
    assert [SOME[place].partition("::")[0] for place in places] == [
        FIRST[0],
        *["tests/lessons/test_exercises.py"] * 2,
        *["tests/test_slam.py"] * 3,
        "tests/lessons/test_exercises.py",
        "tests/sim/test_render.py",
    ]
    units = [unit for unit, _ in groupby(map(unit_of, (SOME[place] for place in in_order(SOME))))]
    assert len(units) == len(set(units)) == 6


@pytest.mark.slow
def test_a_test_that_hangs_fails_once_and_the_others_run(tmp_path):
    (tmp_path / "conftest.py").write_text("from tests.conftest import pytest_xdist_make_scheduler\n")
    (tmp_path / "test_three.py").write_text(
        "import time\ndef test_a(): pass\ndef test_b(): time.sleep(1000)\ndef test_c(): pass\n"
    )
    options = ["-n2", "-pno:nbval", "-pno:cacheprovider", "-ofaulthandler_timeout=4"]
    folders = ["-c", PROJECT / "pyproject.toml", "--rootdir", tmp_path, tmp_path]
    command = [sys.executable, "-m", "pytest", *options, *folders]
    run = subprocess.run(command, capture_output=True, text=True, cwd=PROJECT, check=False)
    assert "1 failed, 2 passed" in run.stdout, run.stdout


def test_a_changed_file_is_tested_by_the_file_or_the_folder_that_mirrors_it():
    for path, mirror in (
        ("nao_course/sim/nao.py", "tests/sim/test_nao.py"),
        ("nao_course/widgets/control_panel/student_view.py", "tests/widgets/control_panel"),
        ("deploy/hub/names.py", "tests/deploy"),
        ("solutions/exercises/07_ekf_slam.py", "tests/lessons/ekf_slam"),
    ):
        assert list(mirrors_of([path])) == [*LAWS, mirror]
    assert list(mirrors_of(["docs/design.md"])) == [*LAWS]
