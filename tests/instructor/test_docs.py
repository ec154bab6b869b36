"""What the pages for assistants and authors say is so: their commands run, and what they name exists."""

import csv
import json
import os
import re
import shutil
import socket
import subprocess
import sys
import zipfile

import pytest

from nao_course.instructor.authoring import scaffold
from nao_course.instructor.sandbox.layers import LEVELS, NAMESPACES, probe
from nao_course.instructor.sandbox.warm_server import WarmServer
from nao_course.instructor.sandbox.worker import Worker
from tests.attacks.code import ATTACKS
from tests.paths import PROJECT
from tests.sandboxed import attacker, attempt, need, only
from tests.toy.course import lay_out_first_lessons

DOCS = PROJECT / "docs"
PAGES = ("../README.md", *sorted(path.name for path in DOCS.glob("*.md")))

LESSON = "01_hsl_filtering.ipynb"


def text_of(page):
    return (DOCS / page).read_text(encoding="utf-8")


def fences(page):
    """Each fenced block of a page: its language and its text."""
    return re.findall(r"^```(\w*)\n(.*?)^```$", text_of(page), re.MULTILINE | re.DOTALL)


def squeezed(text):
    """Without what a longer number or the terminal's width changes in a table."""
    return re.sub(r"[\s━]+", " ", text)


@pytest.fixture
def sh(tmp_path, monkeypatch):
    """Runs commands in a copy of the course's first two lessons, for a user who has never graded."""
    course = tmp_path / "course"
    lay_out_first_lessons(course)
    for name in ("pyproject.toml", "README.md", "LICENSE", "requirements-dev.lock"):
        shutil.copy(PROJECT / name, course)
    program = tmp_path / "bin" / "nao-course"
    program.parent.mkdir()
    program.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m nao_course.cli "$@"\n')
    program.chmod(0o755)
    monkeypatch.delenv("NAO_COURSE_SECRET", raising=False)
    monkeypatch.delenv("XDG_CONFIG_HOME", raising=False)
    told = {"HOME": str(tmp_path), "PYTHONPATH": str(course), "COLUMNS": "250"}
    path = f"{program.parent}{os.pathsep}{os.environ['PATH']}"

    environment = {**os.environ, **told, "PATH": path}

    def run(commands):
        words = ["sh", "-e", "-c", commands]
        done = subprocess.run(words, cwd=course, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, f"{commands}\n{done.stderr}"
        return done.stdout

    return run


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="the page says to grade on Linux")
def test_grading_can_be_followed_word_for_word(sh, tmp_path):
    need(*NAMESPACES)
    blocks = fences("grade_a_class.md")
    assert sum(language == "" for language, _ in blocks) >= 6
    said = ""
    for language, text in blocks:
        if language == "":
            if ".csv" in text:
                _mark(tmp_path / "rehearsal_grades" / "marking", ("ada", "eve"))
            if "--out ../grades " in text:
                _hand_in_to_moodle(tmp_path / "moodle.zip")
            said = sh(text)
        elif language == "text":
            for line in text.splitlines():
                assert line.startswith("Sandbox:") or squeezed(line) in squeezed(said), said
    assert re.search(r"graded +│ 0 .*unchanged +│ 1 ", said, re.DOTALL), said
    assert (tmp_path / "grades/exports/gradescope/autograder_01_hsl_filtering.zip").is_file()
    with (tmp_path / "rehearsal_grades/exports/grades.csv").open(encoding="utf-8-sig", newline="") as file:
        totals = {row["student"]: float(row["total"]) for row in csv.DictReader(file)}
    assert totals == {"ada": 14.5, "ben": 1.0, "eve": 14.5}
    assert not (tmp_path / "rehearsal").exists()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="the page says to grade on Linux")
def test_a_term_ends_and_the_next_begins_word_for_word_and_the_old_one_can_be_graded_again(sh, tmp_path):
    need(*NAMESPACES)
    blocks = re.findall(r"^ *```sh\n(.*?)^ *```$", text_of("teach_the_course.md"), re.MULTILINE | re.DOTALL)
    (lay_aside,) = (block for block in blocks if block.startswith("mv "))
    (keep,) = (block for block in blocks if "../kept" in block)
    sh("git init -q && git -c user.name=a -c user.email=a@b commit -q --allow-empty -m course")
    sh(f"mkdir -p ../handed_in/ada && cp solutions/{LESSON} ../handed_in/ada/")
    sh("nao-course grade ../handed_in --out ../grades")
    sh(keep)
    assert len((tmp_path / "kept" / "version").read_text()) == 41
    sh(lay_aside)
    new = sh("nao-course grade ../handed_in --out ../new_grades")
    old = sh("NAO_COURSE_SECRET=../kept/secret nao-course grade ../kept/handed_in --out ../kept/grades")
    assert re.search(r"graded +│ 1 ", new) and re.search(r"unchanged +│ 1 ", old)
    secrets = [tmp_path / name for name in ("secret_of_last_year", ".config/nao-course/secret")]
    assert len({path.read_bytes() for path in secrets}) == 2


def _mark(folder, students):
    """Do in the sheet what the page says to do in a spreadsheet."""
    (path,) = folder.glob("*.csv")
    with path.open(encoding="utf-8-sig", newline="") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        if row["student"] in students:
            row |= {"points": "1.5", "comment": "Good."}
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, rows[0])
        table.writeheader()
        table.writerows(rows)


def _hand_in_to_moodle(path):
    with zipfile.ZipFile(path, "w") as archive:
        archive.write(PROJECT / "solutions" / LESSON, f"Ada Lovelace_1234567_assignsubmission_file_/{LESSON}")


def test_each_message_that_is_explained_is_one_that_is_said():
    table = text_of("grade_a_class.md").split("| message |")[1].split("\n\n")[0]
    messages = [m for row in table.splitlines()[2:] for m in re.findall("`(.+?)`", row.split(" | ")[0])]
    assert len(messages) > 12
    sources = [path.read_text(encoding="utf-8") for path in (PROJECT / "nao_course").rglob("*.py")]
    whole = re.sub(r'"\s+f?"', "", "\n".join(sources))
    messages.remove("regrade")  # a command
    assert [message for message in messages if message not in whole] == []


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page):
    text = re.sub(r"`[^`\n]+`", "", text_of(page))  # code shows how a link is written
    for path, anchor in re.findall(r"\]\(([\w./-]*)(?:#([\w-]+))?\)", text):
        target = (DOCS / page).parent / path if path else DOCS / page
        assert target.exists(), path
        headings = (
            re.findall(r"^#+ (.+)$", target.read_text(encoding="utf-8"), re.MULTILINE) if anchor else []
        )
        assert not anchor or anchor in {re.sub(r"[^\w -]", "", h).lower().replace(" ", "-") for h in headings}


@pytest.fixture(scope="module")
def tests():
    """Return the names of all tests."""
    texts = [path.read_text(encoding="utf-8") for path in (PROJECT / "tests").rglob("test_*.py")]
    return {name for text in texts for name in re.findall(r"^def (test_\w+)", text, re.MULTILINE)}


def test_what_is_said_to_be_tested_is(tests):
    """Each word of code in the last column of the table of threats is a test or an attack that there is."""
    text = text_of("what_is_protected.md")
    rows = text.split("| what a")[1].split("\n\n")[0].splitlines()[2:]
    named = [name for row in rows for name in re.findall(r"`(\w+)`", row.rstrip(" |").split(" | ")[-1])]
    named += re.findall(r"`(test_\w+)`", text)
    assert len(named) >= 20
    assert [name for name in named if name not in tests | {attack.name for attack in ATTACKS}] == []


def test_what_the_accessibility_statement_says_to_be_tested_is(tests):
    rows = text_of("accessibility.md").split("| promise |")[1].split("\n\n")[0].splitlines()[2:]
    named = [re.findall(r"`(test_\w+)`", row) for row in rows]
    assert all(named) and {name for names in named for name in names} <= tests


def test_every_rule_of_a_lesson_names_tests_that_there_are_and_every_test_of_a_rule_is_named(tests):
    text = text_of("write_a_lesson.md").split("## What a great lesson is")[1].split("\n## ")[0]
    rules = re.split(r"^(\d+)\. ", text, flags=re.MULTILINE)[1:]
    rubric = {
        int(number): re.findall(r"`(test_\w+)`", rule)
        for number, rule in zip(rules[::2], rules[1::2], strict=True)
    }
    assert list(rubric) == list(range(1, 35))
    named = {name for names in rubric.values() for name in names}
    assert {name for name in tests if name.startswith("test_rubric_")} <= named <= tests
    for number, names in rubric.items():
        assert all(re.match(rf"test_(?!rubric)|test_rubric_{number}_", name) for name in names)


def test_every_level_is_a_column_of_the_table_of_threats_and_its_counts_were_measured():
    page = text_of("what_is_protected.md")
    (header,) = re.findall(r"^\| what a student's code.*", page, re.MULTILINE)
    assert re.findall(r"`(\w+)`", header) == list(LEVELS)
    rows = re.findall(r"^\| (denial|gain|leak|harm): (.*)$", page, re.MULTILINE)
    measured = json.loads((PROJECT / "benchmarks" / "results" / "siege.json").read_text(encoding="utf-8"))
    assert [kind for kind, _ in rows] == list(measured["withstood"])
    for kind, row in rows:
        cells = [f"{held} of {graded}" for held, graded in measured["withstood"][kind].values()]
        assert row.split(" | ")[1:4] == cells


# --- what lower levels hold, and what they do not ---

BOTH = {"process", "landlock"}
ANYWHERE = {  # what an attacker does, and at which of the lower levels it works, with no other layer
    "open('/etc/passwd').read()": {"process"},
    "open(args[0] + '/new', 'w')": {"process"},
    "os.chmod(args[0], 0o755)": BOTH,
    "os.kill(args[1], 0)": {"process"},
    "os.listdir('/proc')": {"process"},
    "socket.create_connection(('127.0.0.1', args[2]), 2)": {"process"},
    "s = socket.socket(type=socket.SOCK_DGRAM); s.connect(('127.0.0.1', args[2])); s.send(b'x')\n1": BOTH,
    "socket.socket(socket.AF_UNIX).connect(args[3])": BOTH,
    "bytearray(3 * 2**30)": set(),
    "open('large', 'wb').truncate(10 * 2**30)": set(),
    "[open(f'part{k}', 'wb').truncate(100 * 2**20) for k in range(3)]": BOTH,
}


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="forks")
@pytest.mark.parametrize("level", sorted(BOTH))
def test_a_lower_level_holds_what_the_page_says_and_no_more(level, tmp_path):
    (landlock,) = (layer for layer in probe().layers if layer.name == "landlock")
    if level == "landlock" and int(landlock.detail.rpartition(" ")[2] if landlock.on else 0) < 6:
        pytest.skip("Landlock of this kernel knows neither signals nor TCP")
    notebook = attacker(tmp_path)
    tmp_path.chmod(0o777)
    with (
        WarmServer(only(*({level} - {"process"})), warm=False) as server,
        Worker(notebook, seconds=60.0, server=server) as worker,
        socket.create_server(("127.0.0.1", 0)) as tcp,
        socket.socket(socket.AF_UNIX) as unix,
    ):
        unix.bind(str(tmp_path / "s"))
        unix.listen()
        places = (str(tmp_path), os.getpid(), tcp.getsockname()[1], str(tmp_path / "s"))
        works = {source: attempt(worker, source, *places).status == "value" for source in ANYWHERE}
    assert works == {source: level in levels for source, levels in ANYWHERE.items()}


def test_the_figure_of_the_page_about_lessons_can_be_drawn_and_is_described():
    (block,) = re.findall(
        r"^  ```python\n(  \"\"\"Figures of.*?)^  ```", text_of("write_a_lesson.md"), re.MULTILINE | re.DOTALL
    )
    names = {}
    exec(re.sub("^  ", "", block, flags=re.MULTILINE), names)
    assert names["__all__"] == ["draw_angles"]
    drawing = names["draw_angles"]([0, 1, 2], [0.0, 0.25, 0.5])
    assert drawing.alt.endswith("0.50 rad.") and drawing.image().startswith(b"\x89PNG")


def test_the_page_about_lessons_lists_the_rules_that_a_short_lesson_waives():
    (rules,) = re.findall(r"\[.*\]", scaffold._WAIVED)
    assert f"waived=dict.fromkeys({rules}" in text_of("write_a_lesson.md")
