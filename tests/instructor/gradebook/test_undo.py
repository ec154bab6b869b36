"""A command is taken back completely, whatever it changed, and nothing of anybody else's is."""

import sqlite3
from contextlib import closing
from dataclasses import replace

import pytest

from nao_course.instructor.collecting.roster import Student
from nao_course.instructor.gradebook.journal import NAME, Journal, JournalError
from nao_course.instructor.gradebook.records import Comment, Mark, Override, Request
from tests.pages import answer, exercise, mark, result

LESSON = "01_hsl_filtering"
OVERRIDE = Override("ada", LESSON, "rgb_to_hsl", 1.0, "because", given_by="ben")
CHANGES = {
    "points by hand": lambda journal: journal.override(OVERRIDE),
    "points taken back": lambda journal: journal.override(replace(OVERRIDE, is_withdrawn=True)),
    "marks": lambda journal: journal.mark([mark(1.0), mark(2.0, student="ben")]),
    "a comment": lambda journal: journal.comment([Comment(LESSON, "rgb_to_hsl", "wrong", "Look.")]),
    "a request": lambda journal: journal.request([Request("ada", LESSON, "rgb_to_hsl", "please, now")]),
    "an answer": lambda journal: journal.answer("ada", LESSON, "rgb_to_hsl", "no", "s", "ben"),
    "a time": lambda journal: journal.date("ada", LESSON, "s", "2026-11-20 12:00+00:00", "sheet"),
    "what is known of a student": lambda journal: journal.know(
        [Student("ada", "Ada L.", aliases={"canvas 7": ""})]
    ),
    "a new name": lambda journal: journal.rename("ada", "Ada Lovelace"),
    "two who are one": lambda journal: journal.rename("ada_2", "ada"),
}


@pytest.fixture
def journal(tmp_path):
    with Journal(tmp_path) as opened:
        for student in ("ada", "ada_2", "ben"):
            opened.keep(result(student, exercise(), answer(), submission="s"))
        opened.know([Student("ada", "Ada", email="ada@uni.example", aliases={"moodle 1": LESSON})])
        opened.override(OVERRIDE)
        opened.mark([mark(student="ada_2")])
        opened.request([Request("ada", LESSON, "rgb_to_hsl", "please")])
        yield opened


def content(folder):
    """Return all rows of all tables of a journal."""
    with closing(sqlite3.connect(folder / NAME)) as database:
        query = "SELECT name FROM sqlite_master WHERE type = 'table' AND name NOT LIKE 'sqlite%'"
        tables = [row[0] for row in database.execute(query)]
        return {table: database.execute(f"SELECT rowid, * FROM {table}").fetchall() for table in tables}


@pytest.mark.parametrize("change", CHANGES)
def test_undo_leaves_the_journal_as_it_was_before_the_command(journal, tmp_path, change):
    before = content(tmp_path)
    with journal.command("change", "ben"):
        CHANGES[change](journal)
    assert content(tmp_path) != before
    assert journal.undo().startswith("change (by ben, 20")
    assert content(tmp_path) == before


def test_commands_are_undone_one_after_the_other_and_those_that_changed_nothing_are_none(journal, tmp_path):
    states = [content(tmp_path)]
    for change in CHANGES.values():
        with journal.command("change", ""):
            change(journal)
        states.append(content(tmp_path))
    with journal.command("nothing", ""):
        pass
    while len(states) > 1:
        assert content(tmp_path) == states.pop()
        journal.undo()
    with pytest.raises(JournalError, match="nothing to undo"):
        journal.undo()


def test_what_another_grader_does_at_the_same_time_stays(journal, tmp_path):
    with Journal(tmp_path) as other, journal.command("marks", "ben"):
        journal.mark([mark(1.0)])
        other.mark([mark(2.0, student="ben")])
    journal.undo()
    assert {(each.student, each.points) for each in journal.marks()} == {("ada_2", 1.5), ("ben", 2.0)}


def test_a_run_that_begins_during_a_command_leaves_nothing_of_it_to_undo(journal, tmp_path):
    with Journal(tmp_path) as other, journal.command("marks", "ben"):
        journal.mark([mark(1.0)])
        other.began(tmp_path)
        with other.command("request", "cleo"):
            CHANGES["a request"](other)
        journal.mark([mark(2.0)])
    journal.undo()
    assert [each.points for each in journal.marks() if each.student == "ada"] == [2.0]
    assert not content(tmp_path)["replaced"]


def test_a_command_that_fails_half_way_can_be_undone(journal, tmp_path):
    before = content(tmp_path)
    with journal.command("marks", "ben"):
        journal.mark([mark(1.0)])
        with pytest.raises(JournalError):
            journal.mark([Mark("ada", LESSON, None, 1.0)])
    assert len(journal.marks()) == 2
    journal.undo()
    assert content(tmp_path) == before


@pytest.mark.parametrize("end", ["run", "forgotten student", "graded again"])
def test_nothing_before_a_run_or_a_deletion_can_be_undone(journal, tmp_path, end):
    with journal.command("marks", "ben"):
        CHANGES["a new name"](journal)
    if end == "run":
        journal.began(tmp_path)
    elif end == "graded again":
        journal.want_again("ben", LESSON)
    else:
        journal.forget("ben")
    with pytest.raises(JournalError, match="nothing to undo"):
        journal.undo()
    assert not content(tmp_path)["replaced"]
