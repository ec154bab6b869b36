"""The journal keeps whole results, whatever happens to those who write it."""

import json
import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from dataclasses import replace
from datetime import UTC, datetime

import pytest

from nao_course.instructor.collecting.layouts import person_in
from nao_course.instructor.collecting.roster import Student
from nao_course.instructor.gradebook.journal import NAME, VERSION, Journal, JournalError
from nao_course.instructor.gradebook.late import LatePolicy
from nao_course.instructor.gradebook.records import (
    Comment,
    ExerciseResult,
    Mark,
    Override,
    Request,
    SubmissionResult,
    WrittenAnswer,
)
from nao_course.instructor.gradebook.scores import all_scores

LESSON = "01_hsl_filtering"
EXERCISE = ExerciseResult(
    "hue_mask", "1.5", 2.0, 1.0, "wrong", 1, 3, "no", "line 1", ("a",), "hint", "slip", True, ("n",)
)
RESULT = SubmissionResult(
    "ada",
    LESSON,
    "graded",
    file="ada/x.ipynb",
    submission="s",
    assignment="a",
    exercises=(EXERCISE,),
    written=(WrittenAnswer("why", "1.W1", 2.0, "Why?", "because", "Weil \U0001f600 <b>"),),
    notes=("one",),
    level="full",
    seconds=1.5,
)
WRITER = """
import sys
from pathlib import Path
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import ExerciseResult, SubmissionResult
first, many = int(sys.argv[2]), int(sys.argv[3])
with Journal(Path(sys.argv[1])) as journal:
    print("ready", flush=True)
    for number in range(first, first + many):
        rows = tuple(ExerciseResult(f"e{i}", "1.1", 1.0, 1.0, "right", text="x" * 500) for i in range(10))
        journal.keep(SubmissionResult(f"s{number}", "01_x", "graded", submission=str(number), exercises=rows))
        print(number, flush=True)
"""


def writer(folder, first, many, **options):
    words = [sys.executable, "-c", WRITER, str(folder), str(first), str(many)]
    return subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)


def is_whole(folder):
    return sql(folder / NAME, "PRAGMA integrity_check") == [[("ok",)]]


def test_what_is_kept_comes_back_as_it_was(tmp_path):
    with Journal(tmp_path / "grades.2026") as journal:
        journal.keep(RESULT)
        journal.keep(replace(RESULT, student="bob", lesson="02_x", status="refused", reason="empty"))
    with Journal(tmp_path / "grades.2026", make=False) as journal:
        ada, bob = journal.results()
        assert ada == RESULT and ada.seconds == 1.5
        assert (bob.student, bob.reason) == ("bob", "empty")
        assert journal.results(LESSON) == [ada]
        assert list(journal.each_result(student="bob")) == [bob]


def test_a_newer_result_takes_the_place_of_the_older_which_goes_into_the_history_if_they_differ(tmp_path):
    with Journal(tmp_path) as one, Journal(tmp_path) as other:
        one.keep(RESULT)
        other.keep(replace(RESULT, seconds=2.0))
        assert one.history("ada", LESSON) == [] and one.students() == {"ada"}
        one.want_again("ada", LESSON)
        other.keep(RESULT)
        assert [each.seconds for each in one.history("ada", LESSON)] == [2.0]
        for reason in ("first", "second"):
            one.keep(replace(RESULT, submission=reason, reason=reason))
        assert [each.reason for each in one.results()] == ["second"]
        assert [each.reason for each in one.history("ada", LESSON)] == ["", "", "first"]


def test_only_what_is_missing_or_has_changed_or_is_wanted_again_is_missing(tmp_path):
    here = ("ada", LESSON, "s", "a")
    elsewhere = [("ada", LESSON, "other", "a"), ("ada", LESSON, "s", "other"), ("bob", LESSON, "s", "a")]
    with Journal(tmp_path) as journal:
        assert journal.missing(*here)
        for _ in range(2):
            journal.keep(RESULT)
            assert not journal.missing(*here)
            assert all(journal.missing(*each) for each in (*elsewhere, ("ada", "02_x", "s", "a")))
            journal.want_again("ada", LESSON)
            assert journal.missing(*here)


def test_the_last_override_and_mark_of_each_count_and_survive_a_new_result(tmp_path):
    with Journal(tmp_path) as journal:
        for points in (1.0, 2.0):
            journal.override(Override("ada", LESSON, "hue_mask", points, "because"))
            journal.mark([Mark("ada", LESSON, "why", points, "good"), Mark("bob", "02_x", "why", points)])
        journal.keep(RESULT)
        (override,) = journal.overrides()
        assert (override.points, override.reason) == (2.0, "because") and journal.overrides("02_x") == []
        marks = [(each.student, each.points, each.comment) for each in journal.marks()]
        assert marks == [("ada", 2.0, "good"), ("bob", 2.0, "")]
        assert [each.student for each in journal.marks("02_x")] == ["bob"]


def test_marks_are_kept_all_or_none_and_where_the_submissions_were_is_remembered(tmp_path):
    with Journal(tmp_path) as journal:
        with pytest.raises(JournalError):
            journal.mark([Mark("ada", LESSON, "why", 1.0), Mark("ada", LESSON, None, 1.0)])
        assert journal.marks() == [] and journal.places() == []
        for name in "ab":
            journal.began(tmp_path / name)
        assert journal.places() == [(tmp_path / name).resolve() for name in "ba"]


def test_a_journal_that_is_not_there_is_made_only_where_that_is_wanted(tmp_path):
    with pytest.raises(JournalError, match="there is no journal"):
        Journal(tmp_path, make=False)
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_is_no_journal_of_this_version_is_left_as_it_is(tmp_path):
    path = tmp_path / NAME
    notes = b"my notes, not a database at all" * 100
    path.write_bytes(notes)
    with pytest.raises(JournalError, match="not a journal: move it away"):
        Journal(tmp_path)
    assert path.read_bytes() == notes
    path.unlink()
    sql(path, "CREATE TABLE results (x)")
    before = path.read_bytes()
    with pytest.raises(JournalError, match="no journal of this course"):
        Journal(tmp_path)
    assert path.read_bytes()[100:] == before[100:]
    path.unlink()
    Journal(tmp_path).close()
    sql(path, f"PRAGMA user_version = {VERSION + 1}")
    with pytest.raises(JournalError, match=f"is of version {VERSION + 1}"):
        Journal(tmp_path)


def sql(path, *commands):
    with closing(sqlite3.connect(path)) as database, database:
        return [
            database.execute(*([each] if isinstance(each, str) else each)).fetchall() for each in commands
        ]


def of_version_3(folder):
    """Turn a journal into one of the version in which decisions did not say who made them."""
    made = {"overrides": "given_by is_withdrawn", "marks": "given_by is_withdrawn is_second"}
    made |= {"comments": "given_by", "requests": "given_by"}
    drop = [
        f"ALTER TABLE {table} DROP COLUMN {each}" for table, names in made.items() for each in names.split()
    ]
    sql(folder / NAME, *drop, "DROP TABLE commands", "DROP TABLE replaced", "PRAGMA user_version = 3")


def of_version_1(folder):
    """Turn a journal into one of the version in which decisions did not say for which answer they are."""
    of_version_3(folder)
    decisions = ("overrides", "marks", "comments", "requests")
    *_, ((text,),) = sql(
        folder / NAME,
        *(f"ALTER TABLE {table} DROP COLUMN decided_on" for table in decisions),
        "ALTER TABLE overrides DROP COLUMN earned",
        "SELECT result FROM results",
    )
    found = json.loads(text)
    for each, name in [(each, "answer") for each in found["exercises"]] + [(found["written"][0], "note")]:
        del each[name]
    update = ("UPDATE results SET result = ?", (json.dumps(found),))
    sql(folder / NAME, update, "PRAGMA user_version = 1")


def test_decisions_of_an_older_journal_are_for_the_answers_that_were_there(tmp_path):
    with Journal(tmp_path) as journal:
        journal.keep(RESULT)
        journal.override(Override("ada", LESSON, "hue_mask", 1.5, "because"))
        journal.mark([Mark("ada", LESSON, "why", 2.0)])
        journal.comment([Comment(LESSON, "hue_mask", EXERCISE.kind, "Look.")])
        journal.request([Request("ada", LESSON, "hue_mask", "please")])
        journal.answer("ada", LESSON, "hue_mask", "no", "")
    of_version_1(tmp_path)
    with Journal(tmp_path) as journal:
        assert journal.results()[0].written == RESULT.written
    known = replace(RESULT, exercises=(replace(EXERCISE, answer="x"),), assignment="b")  # graded again
    elsewhere = replace(known, submission="t")
    other = (replace(EXERCISE, answer="y"),), (replace(RESULT.written[0], text="Darum"),)
    changed = replace(elsewhere, exercises=other[0], written=other[1])
    for each, decided in ((RESULT, True), (known, True), (elsewhere, True), (changed, False)):
        with Journal(tmp_path) as journal:
            journal.keep(each)
            (score,) = all_scores(journal)
            (request,) = journal.requests()
        assert (score.earned == 3.5) == bool(score.overrides) == bool(score.marks) == decided
        assert each.has_answer("hue_mask", request.decided_on) == decided
        assert score.comments == {"hue_mask": "Look."}


def test_a_read_only_journal_can_be_read_and_a_result_that_cannot_be_read_is_said(tmp_path):
    with Journal(tmp_path) as journal:
        journal.keep(RESULT)
        journal._database.execute("PRAGMA query_only = 1")
        with pytest.raises(JournalError, match="cannot write the journal .*readonly"):
            journal.keep(replace(RESULT, student="bob"))
        assert journal.results() == [RESULT]
        journal._database.execute("PRAGMA query_only = 0")
        journal._database.execute("UPDATE results SET result = '{}'")
        with pytest.raises(JournalError, match="cannot be read"):
            journal.results()


def test_two_graders_on_one_journal_lose_nothing(tmp_path):
    writers = [writer(tmp_path, first, 60) for first in (0, 30, 60)]
    for each in writers:
        assert each.communicate(timeout=120)[1] == ""
        assert each.returncode == 0
    with Journal(tmp_path) as journal:
        assert sorted(int(each.submission) for each in journal.results()) == list(range(120))
        assert all(len(each.exercises) == 10 for each in journal.results())
    assert is_whole(tmp_path)


@pytest.mark.slow
def test_what_was_said_to_be_kept_outlives_a_killed_writer(tmp_path):
    chance = random.Random(5)
    kept = 0
    for _ in range(8):
        process = writer(tmp_path, kept, 10_000)
        process.stdout.readline()
        time.sleep(chance.uniform(0.001, 0.15))
        process.kill()
        said = process.communicate()[0].split()
        last = int(said[-1]) if said else kept - 1
        assert is_whole(tmp_path)
        with Journal(tmp_path) as journal:
            numbers = sorted(int(each.submission) for each in journal.results())
        assert numbers == list(range(len(numbers)))
        assert last < len(numbers) <= last + 2  # at most the one that was being said
        kept = len(numbers)
    assert kept > 8


@pytest.mark.skipif(sys.platform == "win32", reason="limits of POSIX")
def test_a_full_disk_is_said_and_loses_nothing(tmp_path):
    import resource

    def small():
        resource.setrlimit(resource.RLIMIT_FSIZE, (300_000, 300_000))
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)

    process = writer(tmp_path, 0, 1000, preexec_fn=small)
    said, error = process.communicate(timeout=60)
    assert process.returncode == 1
    assert "JournalError: cannot write the journal" in error and "Make room on the disk" in error
    last = int(said.split()[-1])
    assert 5 < last < 999
    assert is_whole(tmp_path)
    with Journal(tmp_path) as journal:
        assert len(journal.results()) == last + 1
        journal.keep(RESULT)  # there is room again


@pytest.mark.skipif(not hasattr(os, "geteuid"), reason="modes of POSIX")
def test_a_folder_that_may_not_be_written_to_is_said(tmp_path):
    if os.geteuid() == 0:
        (tmp_path / "grades").write_text("a file where a folder is wanted")  # root may write anywhere
    else:
        (tmp_path / "grades").mkdir(mode=0o500)
    with pytest.raises(JournalError, match="cannot open the journal .*grades"):
        Journal(tmp_path / "grades")


def of_version_2(folder):
    """Turn a journal into one of the version in which a student was what a folder was called."""
    rows = sql(folder / NAME, "SELECT rowid, result FROM results")[0]
    older = [
        (row, {key: said for key, said in json.loads(text).items() if key != "timed_by"})
        for row, text in rows
    ]
    updates = [
        ("UPDATE results SET result = ? WHERE rowid = ?", (json.dumps(each), row)) for row, each in older
    ]
    of_version_3(folder)
    sql(folder / NAME, *updates, "DROP TABLE students", "DROP TABLE aliases", "PRAGMA user_version = 2")


def test_students_of_an_older_journal_keep_their_names_and_are_known_by_their_numbers(tmp_path):
    files = {
        "Group A-Ada_12": "Group A-Ada_12_assignsubmission_file_/x.ipynb",
        "50-6 - Ben - Nov 20, 2026 932 PM": "50-6 - Ben - Nov 20, 2026 932 PM/x.ipynb",
        "lovelaceada_7": f"lovelaceada_7_8_{LESSON}.ipynb",
        "ada": "ada/x.ipynb",
    }
    made = [replace(RESULT, student=student, file=file) for student, file in files.items()]
    with Journal(tmp_path) as journal:
        for each in made:
            journal.keep(each)
    of_version_2(tmp_path)
    with Journal(tmp_path) as journal:
        assert sorted(journal.results(), key=lambda each: each.student) == sorted(
            made, key=lambda each: each.student
        )
        people = [person_in(file.replace("Group A-", ""), LESSON) for file in files.values()]
        found = journal.roster().recognise([each for each in people if each])
        assert sorted(found.students.values()) == sorted([*files][:3]) and not found.by_name
        assert journal.roster().meant("ada") == "ada"


def test_a_student_who_is_renamed_or_joined_with_another_keeps_everything(tmp_path):
    early, late = (replace(RESULT, handed_in=f"2026-11-2{day} 10:00", submission=f"s{day}") for day in (0, 1))
    with Journal(tmp_path) as journal:
        journal.keep(replace(late, student="ada_1"))
        journal.keep(replace(early, student="ada_2"))
        journal.keep(replace(early, student="ada_2", lesson="02_x"))
        journal.override(Override("ada_2", LESSON, "hue_mask", 1.5, "because", decided_on="s0"))
        journal.mark([Mark("ada_2", "02_x", "why", 2.0, decided_on=RESULT.written[0].fingerprint)])
        journal.request([Request("ada_2", LESSON, "hue_mask", "please")])
        assert journal.rename("ada_2", "Ada") == [] and journal.rename("ada_1", "Ada") == [LESSON]
        found = {each.lesson: each for each in journal.results()}
        assert found == {
            LESSON: replace(late, student="Ada"),
            "02_x": replace(early, student="Ada", lesson="02_x"),
        }
        assert journal.history("Ada", LESSON) == [replace(early, student="Ada")]
        decided = (*journal.overrides(), *journal.marks(), *journal.requests())
        assert [each.student for each in decided] == ["Ada"] * 3
        assert [journal.roster().meant(each) for each in ("ada_1", "ada_2")] == ["Ada"] * 2
        assert journal.students() == set(journal.roster().students) == {"Ada"}


def test_of_a_forgotten_student_no_byte_remains(tmp_path):
    with Journal(tmp_path) as journal:
        journal.know([Student("ada", "Ada Byron King", "ada@uni.example", aliases={"moodle 123454321": ""})])
        for text in ("Weil", "Darum"):
            journal.keep(replace(RESULT, submission=text, written=(replace(RESULT.written[0], text=text),)))
        journal.keep(replace(RESULT, student="ben"))
        journal.request([Request("ada", LESSON, "hue_mask", "please, please")])
        journal.forget("ada")
        assert journal.students() == set(journal.roster().students) == {"ben"}
    words = [b"Byron", b"uni.example", b"123454321", b"Darum", b"please"]
    content = b"".join(path.read_bytes() for path in tmp_path.iterdir())
    assert b"ben" in content and [each for each in words if each in content] == []


def test_a_time_is_recorded_for_the_submission_that_it_is_of(tmp_path):
    with Journal(tmp_path) as journal:
        journal.keep(RESULT)
        assert not journal.date("ada", LESSON, "another", "2026-11-20 21:32", "sheet")
        assert journal.date("ada", LESSON, "s", "2026-11-20 21:32", "platform")
        assert not journal.date("ada", LESSON, "s", "2026-11-20 21:32", "sheet")
        (found,) = journal.results()
        assert found == replace(RESULT, handed_in="2026-11-20 21:32", timed_by="sheet")


def test_an_extension_may_be_given_by_any_name_of_a_student(tmp_path):
    due = {LESSON: datetime(2026, 11, 20, tzinfo=UTC)}
    with Journal(tmp_path, policy=LatePolicy(due, {"ada@uni.example": due, "Eve": due})) as journal:
        journal.know([Student("Ada", "Ada", "ada@uni.example")])
        assert set(journal.policy.extensions) == {"Ada", "Eve"}
        journal.rename("Ada", "Ada King")
        assert set(journal.policy.extensions) == {"Ada King", "Eve"}
