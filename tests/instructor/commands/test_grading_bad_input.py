"""Every grading command says in a sentence what it cannot use, with status 1, and writes nothing then."""

import hashlib
import os
import shutil
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import pytest
from typer.testing import CliRunner

from nao_course import cli
from nao_course.instructor.autograding.assignment import prepare
from nao_course.instructor.autograding.grader import refuse
from nao_course.instructor.collecting.submissions import Submission
from nao_course.instructor.gradebook.journal import NAME, Journal
from tests.paths import PROJECT
from tests.sandboxed import crossed, quickly
from tests.toy import chain

posix = pytest.mark.skipif(sys.platform == "win32", reason="pipes and modes of POSIX")
READERS = {
    "regrade": ("regrade", "@GRADES", "--student", "ada", "--set", "double=1", "--reason", "x"),
    "regrade again": ("regrade", "@GRADES", "--student", "ada"),
    "export csv": ("export", "@GRADES", "--format", "csv"),
    "export gradescope": ("export", "@GRADES", "--format", "gradescope"),
    "export moodle": ("export", "@GRADES", "--format", "moodle", "--sheet", "@THEIRS"),
    "marks": ("marks", "@GRADES"),
    "marks of a sheet": ("marks", "@GRADES", "@SHEET"),
    "report": ("report", "@GRADES"),
}
ALL = READERS | {"grade": ("grade", "@IN", "--out", "@GRADES")}


@pytest.fixture(scope="module")
def assignment(tmp_path_factory):
    return prepare(chain.make_course(tmp_path_factory.mktemp("course")), "90", chain.SECRET)


@pytest.fixture
def place(tmp_path, monkeypatch, assignment, secret):
    """A course in the working folder, and in "grades" a journal of one refused submission."""
    chain.make_course(tmp_path / "course")
    monkeypatch.chdir(tmp_path / "course")
    path = chain.hand_in(tmp_path / "in", "ada", b"{")
    with Journal(tmp_path / "grades") as journal:
        journal.keep(refuse(Submission("ada", chain.LESSON, path), assignment, "it is broken"))
        journal.began(tmp_path / "in")
    (tmp_path / "sheet.csv").write_text("student,points\nada,1\n")
    (tmp_path / "theirs.csv").write_text("Identifier,Full name,Grade\nParticipant 12,Ada,\n")
    return tmp_path


def words(place, command, **others):
    names = {"GRADES": "grades", "IN": "in", "SHEET": "sheet.csv", "THEIRS": "theirs.csv"}
    paths = {name: place / file for name, file in names.items()} | others
    return [str(paths[word[1:]]) if word.startswith("@") else word for word in ALL[command]]


def state(folder):
    """All files and folders of a place, but for what SQLite itself keeps beside a journal that is read."""

    def content(path):
        is_small = path.is_file() and path.stat().st_size < 2**24
        return hashlib.sha256(path.read_bytes()).hexdigest() if is_small else path.lstat().st_mode

    paths = [path for path in folder.rglob("*") if not path.name.endswith((".sqlite-wal", ".sqlite-shm"))]
    return {str(path): content(path) for path in paths}


def refused(place, arguments, *said):
    """Run a command that has to be refused in a sentence; nothing is written."""
    before = state(place)
    done = CliRunner().invoke(cli.app, [str(word) for word in arguments])
    assert isinstance(done.exception, SystemExit), repr(done.exception)
    assert done.exit_code == 1, done.output
    assert "Traceback" not in done.output
    assert 0 < len(done.stderr.strip()) < 600 and done.stderr.strip().isprintable(), done.stderr
    for text in said:
        assert text in done.stderr
    assert state(place) == before


def fill(path, content):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    return path


@pytest.mark.parametrize(
    ("command", "what"),
    crossed(
        [name for name in READERS if name != "export gradescope"],
        ["nothing", "empty", "file", "link to nothing"],
    ),
)
def test_what_is_no_folder_of_grades_is_said_and_none_is_made(place, command, what):
    refused(place, words(place, command, GRADES=odd_grades(place, what)), "there is no journal", "grade")


# An autograder may be exported before anything is graded.
@pytest.mark.parametrize("command", ["grade", "export gradescope"])
@pytest.mark.parametrize("what", ["file", "link to nothing", "below a file"])
def test_grades_that_cannot_be_made_are_said(place, command, what):
    refused(place, words(place, command, GRADES=odd_grades(place, what)), "cannot open the journal")


def odd_grades(place, what):
    grades = place / "elsewhere"
    if what == "empty":
        grades.mkdir()
    elif "file" in what:
        grades.write_text("grades")
    elif what == "link to nothing":
        grades.symlink_to(place / "gone" / "further")
    return grades / "below" if what == "below a file" else grades


def _sql(path, *commands):
    with closing(sqlite3.connect(path)) as database:
        for command in commands:
            database.execute(command)


def _anothers(path):
    path.unlink()
    _sql(path, "CREATE TABLE notes (text TEXT)")


def _damaged(path):
    data = path.read_bytes()
    path.write_bytes(data[:100] + os.urandom(len(data) - 100))


def _huge(path):
    with path.open("wb") as file:
        file.truncate(2**28)


TABLES = ("results", "overrides", "marks", "runs", "history")
JOURNALS = {
    "newer": (lambda path: _sql(path, "PRAGMA user_version = 99"), "of version 99"),
    "anothers": (_anothers, "no journal of this course"),
    "without tables": (lambda path: _sql(path, *(f"DROP TABLE {each}" for each in TABLES)), "cannot"),
    "damaged": (_damaged, "cannot"),
    "cut": (lambda path: path.write_bytes(path.read_bytes()[:5000]), "cannot"),
    "text": (lambda path: path.write_text("student,points\n" * 100), "is not a journal"),
    "huge": (_huge, "is not a journal"),
}


@pytest.mark.parametrize(("command", "kind"), crossed(ALL, JOURNALS))
def test_a_journal_that_cannot_be_used_is_said_and_left_as_it_is(place, command, kind):
    damage, reason = JOURNALS[kind]
    damage(place / "grades" / NAME)
    refused(place, words(place, command), "journal.sqlite", reason)


ODD_RESULTS = ["", "{", "[]", "7", "null", '"text"', "{}", '{"student": 1}', "[" * 60000, '{"exercises": 5}']


@pytest.mark.parametrize(("command", "text"), crossed(READERS, ODD_RESULTS))
def test_a_result_in_the_journal_that_makes_no_sense_is_said(place, command, text):
    with closing(sqlite3.connect(place / "grades" / NAME)) as database, database:
        database.execute("UPDATE results SET result = ?", (text,))
    refused(place, words(place, command), "holds a result that cannot be read")


@pytest.mark.parametrize("command", ["grade", "regrade", "regrade again"])
def test_a_journal_that_another_one_holds_is_said(place, command, monkeypatch):
    monkeypatch.setattr("nao_course.instructor.gradebook.journal.PATIENCE", 0.1)
    with closing(sqlite3.connect(place / "grades" / NAME, isolation_level=None)) as database:
        database.execute("BEGIN IMMEDIATE")
        refused(place, words(place, command), "locked", "Another grader")


@posix
@pytest.mark.parametrize("command", ALL)
def test_a_journal_that_is_a_pipe_or_folder_is_said_at_once(place, command):
    (place / "grades" / NAME).unlink()
    os.mkfifo(place / "grades" / NAME)
    refused(place, words(place, command), "journal")
    (place / "grades" / NAME).unlink()
    (place / "grades" / NAME).mkdir()
    refused(place, words(place, command), "journal")


@pytest.mark.skipif(sys.platform != "linux", reason="a read-only mount in a namespace")
@pytest.mark.parametrize("command", quickly(("grade", "regrade", "regrade again"), "grade"))
def test_grades_that_may_only_be_read_are_said(place, command):
    mount = 'mount --bind "$1" "$1" && mount -o remount,ro,bind "$1" && shift && exec "$@"'
    if subprocess.run(["unshare", "-rm", "true"], capture_output=True).returncode:
        pytest.skip("no user namespaces here")
    before = state(place)
    shell = ["unshare", "-rm", "sh", "-c", mount, "sh", str(place / "grades")]
    ours = [sys.executable, "-m", "nao_course.cli", *words(place, command)]
    environment = os.environ | {"PYTHONPATH": str(PROJECT)}
    done = subprocess.run([*shell, *ours], capture_output=True, text=True, env=environment)
    assert done.returncode == 1, done.stdout + done.stderr
    assert "journal" in done.stderr and "Traceback" not in done.stderr
    assert state(place) == before


NO_SUBMISSIONS = {
    "missing": (lambda place: place / "gone", "does not exist"),
    "long name": (lambda place: Path("x" * 300), ""),
    "a file": (lambda place: fill(place / "new" / "essay.txt", b"x"), "submissions"),
    "an empty zip": (lambda place: fill(place / "empty.zip", b""), "submissions"),
    "a broken zip": (lambda place: fill(place / "broken.zip", b"PK\3\4" + bytes(500)), "submissions"),
    "a zip of nothing": (
        lambda place: fill(place / "x.zip", b"PK\5\6" + bytes(18)),
        "contains no submissions",
    ),
    "hidden": (lambda place: fill(place / "new" / ".DS_Store", b"{}").parent, "contains no submissions"),
    "null": (lambda place: Path("/dev/null"), "submissions"),
    "zero": (lambda place: Path("/dev/zero"), "submissions"),
}


@pytest.mark.parametrize("what", NO_SUBMISSIONS)
def test_what_holds_no_submissions_is_said_and_no_journal_is_made(place, what):
    make, said = NO_SUBMISSIONS[what]
    path = make(place)
    refused(place, ["grade", path, "--out", place / "new grades"], said)


@posix
def test_a_pipe_for_submissions_is_said_at_once(place):
    os.mkfifo(place / "pipe")
    refused(place, ["grade", place / "pipe", "--out", place / "new grades"], "submissions")


def test_no_course_here_is_said(place, monkeypatch):
    (place / "nowhere").mkdir()
    monkeypatch.chdir(place / "nowhere")
    refused(place, ["grade", place / "in", "--out", place / "new grades"])
    refused(place, ["export", place / "new grades", "--format", "gradescope"])
    refused(place, words(place, "export gradescope"))


@pytest.mark.slow
def test_a_course_that_was_not_built_is_said(place):
    shutil.rmtree(place / "course" / "notebooks")
    done = CliRunner().invoke(cli.app, ["grade", str(place / "in"), "--out", str(place / "new grades")])
    assert done.exit_code == 1 and "nao-course build" in done.stderr
    with Journal(place / "new grades") as journal:
        assert journal.results() == []


@posix
@pytest.mark.parametrize("content", [b"", b"short", None])
def test_a_secret_that_is_none_is_said(place, content):
    (place / "secret").unlink() if content is None else (place / "secret").write_bytes(content)
    refused(place, ["grade", place / "in", "--out", place / "grades"], "secret")


def test_a_level_that_there_is_not_is_said(place):
    done = CliRunner().invoke(cli.app, [*words(place, "grade"), "--require-sandbox", "iron"])
    assert done.exit_code == 1 and "iron" in done.stderr


CONTROLS = "\x1b[31m"
POINTS = "=;double;double=;=1;double=1=2;double=x;double=inf;double=nan;double=1e400;double=-1e-300;double=3"
POINTS += f";double=0x1;double=1,5;Double=1;double =1;why=99;\x00=1;double={CONTROLS};" + "d" * 400 + "=1"
STUDENTS = f";Adam;../ada;%;' OR 1=1 --;{CONTROLS};\ud800;" + "x" * 400
ODD_WORDS = {  # what may be odd, the command, the odd words, and what is said of them
    "grade, lesson": (
        "grade @IN --out @NEW --lesson=",
        ["07", "-1", "", "90_chains", "../90_chain", "x" * 1000, CONTROLS, "٩٠"],
        "lesson",
    ),
    "points": ("regrade @GRADES --student ada --reason x --set=", POINTS.split(";"), ""),
    "student": ("regrade @GRADES --student=", STUDENTS.split(";"), "no result of"),
    "student, set": (
        "regrade @GRADES --set double=1 --reason x --student=",
        ["", "Adam", "\ud800"],
        "no result of",
    ),
    "regrade, lesson": (
        "regrade @GRADES --student ada --set double=1 --reason x --lesson=",
        ["91", "x", "90_chains", "%"],
        "90_chain",
    ),
    "format": ("export @GRADES --format=", ["", "CSV", "../csv", CONTROLS, "x" * 300], "csv"),
    "csv, lesson": ("export @GRADES --format csv --lesson=", ["91", "x", "../90", CONTROLS], "lesson"),
    "gradescope, lesson": ("export @GRADES --format gradescope --lesson=", ["91", CONTROLS], "lesson"),
}


@pytest.mark.parametrize("what", ODD_WORDS)
def test_a_word_that_means_nothing_is_said(place, what):
    command, odd, said = ODD_WORDS[what]
    *first, last = command.split(" ")
    names = {"@IN": place / "in", "@GRADES": place / "grades", "@NEW": place / "new grades"}
    for word in odd:
        refused(place, [*(names.get(each, each) for each in first), last + word], said)


def test_a_submission_that_is_not_there_any_more_is_said(place):
    shutil.move(place / "in" / "ada", place / "in" / "bob")
    done = CliRunner().invoke(cli.app, words(place, "regrade again"))
    assert done.exit_code == 1 and "any more" in done.stderr
    with Journal(place / "grades") as journal:
        assert [each.student for each in journal.results()] == ["ada"]


def test_a_platforms_sheet_has_to_be_given_and_to_be_theirs(place):
    for platform in ("moodle", "canvas"):
        refused(place, ["export", place / "grades", "--format", platform], "--sheet")
        for sheet in ("nothing.csv", "in", "secret"):
            given = ["--sheet", place / sheet]
            refused(place, ["export", place / "grades", "--format", platform, *given], sheet.split(".")[0])


@pytest.mark.parametrize(
    "content",
    [
        *(
            b"",
            b"\n\n\n",
            b"\0" * 100,
            bytes(range(256)) * 20,
            b"PK\3\4" + bytes(100),
            "a,b".encode("utf-16"),
        ),
        *(b"student,lesson\n", b"student,points\nada,1\n", b'"' * 10_000, b"," * 10_000, b'a,"b\nc'),
        *(b"x" * 2**20, b"<html><table></table></html>", b"\x1b[31m,\x1b[2J\n"),
    ],
    ids=lambda content: f"{content[:8]!r} {len(content)}",
)
def test_a_sheet_that_is_none_is_said_and_no_mark_is_kept(place, content):
    refused(place, words(place, "marks of a sheet", SHEET=fill(place / "bad.csv", content)))


@posix
@pytest.mark.parametrize("what", ["missing", "folder", "pipe", "zeros", "huge"])
def test_a_sheet_that_is_no_file_is_said_at_once(place, what):
    sheet = Path("/dev/zero") if what == "zeros" else place / "bad.csv"
    if what == "folder":
        sheet.mkdir()
    elif what == "pipe":
        os.mkfifo(sheet)
    elif what == "huge":
        _huge(sheet)
    refused(place, words(place, "marks of a sheet", SHEET=sheet))


def test_an_empty_journal_is_no_mistake(place):
    """Nothing was graded yet: the tables are headers, the page says so, and the status is 0."""
    with Journal(place / "new grades"):
        pass
    for command in ("export csv", "marks", "report"):
        done = CliRunner().invoke(cli.app, words(place, command, GRADES=place / "new grades"))
        assert done.exit_code == 0, done.output


@pytest.mark.slow
def test_a_class_of_refused_submissions_has_a_status_of_0(place):
    """Each has its reason: that is all a run can do."""
    fill(place / "in" / "bob" / f"{chain.LESSON}.ipynb", b"{")
    done = CliRunner().invoke(cli.app, words(place, "grade"))
    assert done.exit_code == 0, done.output
    assert "bob, 90_chain: 90_chain.ipynb: not a notebook of format 4" in done.output
