"""The tables of a journal, what each version of them added, and how a journal of an earlier version gets it."""

from collections.abc import Callable, Iterable
from sqlite3 import Connection

from nao_course.instructor.collecting.layouts import person_in
from nao_course.instructor.collecting.roster import Student, said_of
from nao_course.instructor.gradebook.records import SubmissionResult, fingerprint

VERSION = 4
APPLICATION = 0x4E414F4A  # "NAOJ": distinguishes this file from other SQLite files
RESULT_COLUMNS = "student, lesson, submission, assignment, status, level, seconds, versions, time, result"
_VERSION_1 = f"""
CREATE TABLE results (
    student TEXT NOT NULL, lesson TEXT NOT NULL, submission TEXT NOT NULL, assignment TEXT NOT NULL,
    status TEXT NOT NULL, level TEXT NOT NULL, seconds REAL NOT NULL, versions TEXT NOT NULL, time TEXT NOT NULL,
    result TEXT NOT NULL, again INTEGER NOT NULL DEFAULT 0, PRIMARY KEY (student, lesson));
CREATE TABLE history AS SELECT {RESULT_COLUMNS} FROM results;
CREATE TABLE overrides (
    student TEXT NOT NULL, lesson TEXT NOT NULL, exercise TEXT NOT NULL, points REAL NOT NULL, reason TEXT NOT NULL,
    time TEXT NOT NULL);
CREATE TABLE marks (
    student TEXT NOT NULL, lesson TEXT NOT NULL, question TEXT NOT NULL, points REAL NOT NULL, comment TEXT NOT NULL,
    time TEXT NOT NULL);
CREATE TABLE runs (submissions TEXT NOT NULL, time TEXT NOT NULL);
PRAGMA application_id = {APPLICATION};
"""
_VERSION_2 = """
CREATE TABLE IF NOT EXISTS comments (
    lesson TEXT NOT NULL, exercise TEXT NOT NULL, kind TEXT NOT NULL, text TEXT NOT NULL, time TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS requests (
    student TEXT NOT NULL, lesson TEXT NOT NULL, exercise TEXT NOT NULL, text TEXT NOT NULL, answer TEXT NOT NULL,
    time TEXT NOT NULL);
ALTER TABLE overrides ADD COLUMN decided_on TEXT NOT NULL DEFAULT '';
ALTER TABLE overrides ADD COLUMN earned REAL NOT NULL DEFAULT 0;
ALTER TABLE marks ADD COLUMN decided_on TEXT NOT NULL DEFAULT '';
ALTER TABLE comments ADD COLUMN decided_on TEXT NOT NULL DEFAULT '';
ALTER TABLE requests ADD COLUMN decided_on TEXT NOT NULL DEFAULT '';
PRAGMA user_version = 2;
"""
# The students are in the journal, and not in a file beside it, so that one transaction changes who a person is and
# whose the results are, and two graders that run at once agree on it.
_VERSION_3 = """
CREATE TABLE IF NOT EXISTS students (
    student TEXT PRIMARY KEY, name TEXT NOT NULL, email TEXT NOT NULL, login TEXT NOT NULL, section TEXT NOT NULL,
    listed INTEGER NOT NULL);
CREATE TABLE IF NOT EXISTS aliases (alias TEXT PRIMARY KEY, student TEXT NOT NULL, lesson TEXT NOT NULL);
PRAGMA user_version = 3;
"""
_VERSION_4 = """
CREATE TABLE IF NOT EXISTS commands (
    number INTEGER PRIMARY KEY AUTOINCREMENT, words TEXT NOT NULL, given_by TEXT NOT NULL,
    time TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS replaced (command INTEGER NOT NULL, name TEXT NOT NULL, row INTEGER NOT NULL, old TEXT);
ALTER TABLE overrides ADD COLUMN given_by TEXT NOT NULL DEFAULT '';
ALTER TABLE overrides ADD COLUMN is_withdrawn INTEGER NOT NULL DEFAULT 0;
ALTER TABLE marks ADD COLUMN given_by TEXT NOT NULL DEFAULT '';
ALTER TABLE marks ADD COLUMN is_withdrawn INTEGER NOT NULL DEFAULT 0;
ALTER TABLE marks ADD COLUMN is_second INTEGER NOT NULL DEFAULT 0;
ALTER TABLE comments ADD COLUMN given_by TEXT NOT NULL DEFAULT '';
ALTER TABLE requests ADD COLUMN given_by TEXT NOT NULL DEFAULT '';
PRAGMA user_version = 4;
"""
OF_STUDENTS = ("results", "history", "overrides", "marks", "requests", "aliases", "students")  # tables
_VERSIONS = (_VERSION_1, _VERSION_2, _VERSION_3, _VERSION_4)


def create(database: Connection) -> None:
    """Create the tables in an empty database, in the caller's transaction."""
    for statements in _VERSIONS:
        _run(database, statements)


def migrate(
    database: Connection,
    version: int,
    results: Callable[[], Iterable[SubmissionResult]],
    know: Callable[[Iterable[Student]], None],
) -> None:
    """Add to a journal what its version does not have yet, in the caller's transaction.

    `results` returns what counts in it, and `know` records students.
    """
    for number, statements in enumerate(_VERSIONS, start=1):
        if number <= max(version, 1):
            continue
        _run(database, statements)
        if number == 2:
            _decide_on_present_answers(database, results())
        elif number == 3:
            know(_students_in(results()))


def _run(database: Connection, statements: str) -> None:
    for statement in statements.split(";"):
        database.execute(statement)


def _decide_on_present_answers(database: Connection, results: Iterable[SubmissionResult]) -> None:
    """Assign decisions that do not name their answers to the present answers."""
    for result in results:
        key = (result.student, result.lesson)
        of_key = "WHERE student = ? AND lesson = ?"
        database.execute(f"UPDATE requests SET decided_on = ? {of_key}", (result.submission, *key))
        for each in result.exercises:
            database.execute(
                f"UPDATE overrides SET decided_on = ?, earned = ? {of_key} AND exercise = ?",
                (result.submission, each.earned, *key, each.name),
            )
            database.execute(
                "UPDATE comments SET decided_on = ? WHERE lesson = ? AND exercise = ? AND kind = ?",
                (fingerprint(each.hint), result.lesson, each.name, each.kind),
            )
        for answer in result.written:
            database.execute(
                f"UPDATE marks SET decided_on = ? {of_key} AND question = ?",
                (answer.fingerprint, *key, answer.name),
            )


def _students_in(results: Iterable[SubmissionResult]) -> list[Student]:
    """Return students with the numbers and names that are in the names of their files."""
    students: dict[str, Student] = {}
    for result in results:
        if person := person_in(result.file, result.lesson):
            said = said_of(result.student, person)
            before = students.get(result.student)
            students[result.student] = before.joined(said) if before else said
    return list(students.values())
