"""The journal: one SQLite file that keeps what was graded, changed by hand and marked, whatever happens meanwhile.

It is in WAL mode with synchronous=NORMAL. A result is one transaction, so a grader that is killed leaves all or
nothing of it; what was committed is with the operating system and outlives the process. A power cut may take the
last few transactions, never the file, and the same command grades those again: an fsync for each result buys nothing.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Self

from nao_course.instructor.gradebook.late import LatePolicy
from nao_course.instructor.gradebook.records import (
    Comment,
    Mark,
    Override,
    Request,
    SubmissionResult,
    as_json,
    from_json,
    now,
)

NAME = "journal.sqlite"
VERSION = 1
PATIENCE = 60.0  # seconds that one grader waits for another one's transaction
_APPLICATION = 0x4E414F4A  # "NAOJ": distinguishes this file from other SQLite files
_COLUMNS = "student, lesson, submission, assignment, status, level, seconds, versions, time, result"
_SCHEMA = f"""
CREATE TABLE results (
    student TEXT NOT NULL, lesson TEXT NOT NULL, submission TEXT NOT NULL, assignment TEXT NOT NULL,
    status TEXT NOT NULL, level TEXT NOT NULL, seconds REAL NOT NULL, versions TEXT NOT NULL, time TEXT NOT NULL,
    result TEXT NOT NULL, again INTEGER NOT NULL DEFAULT 0, PRIMARY KEY (student, lesson));
CREATE TABLE history AS SELECT {_COLUMNS} FROM results;
CREATE TABLE overrides (
    student TEXT NOT NULL, lesson TEXT NOT NULL, exercise TEXT NOT NULL, points REAL NOT NULL, reason TEXT NOT NULL,
    time TEXT NOT NULL);
CREATE TABLE marks (
    student TEXT NOT NULL, lesson TEXT NOT NULL, question TEXT NOT NULL, points REAL NOT NULL, comment TEXT NOT NULL,
    time TEXT NOT NULL);
CREATE TABLE runs (submissions TEXT NOT NULL, time TEXT NOT NULL);
PRAGMA application_id = {_APPLICATION};
PRAGMA user_version = {VERSION};
"""
_COMMENTS = """
CREATE TABLE IF NOT EXISTS comments (
    lesson TEXT NOT NULL, exercise TEXT NOT NULL, kind TEXT NOT NULL, text TEXT NOT NULL, time TEXT NOT NULL)
"""

_REQUESTS = """
CREATE TABLE IF NOT EXISTS requests (
    student TEXT NOT NULL, lesson TEXT NOT NULL, exercise TEXT NOT NULL, text TEXT NOT NULL, answer TEXT NOT NULL,
    time TEXT NOT NULL)
"""


class JournalError(ValueError):
    """A journal that cannot be used or written; the message says which and what to do."""


class Journal:
    """What was graded: open it, keep results in it, read them.

    Parameters
    ----------
    path : Path
        The SQLite file, or the folder of it; made where there is none.
    make : bool
        Whether it may be made.
    policy : LatePolicy, optional
        What late submissions lose in the scores that are made of it; nothing by default.

    Raises
    ------
    JournalError
        If it is no journal, of a newer version, or cannot be opened.

    Examples
    --------
    ::

        with Journal(Path("grades")) as journal:
            journal.keep(result)
    """

    def __init__(self, path: Path, *, make: bool = True, policy: LatePolicy | None = None) -> None:
        self.policy = policy
        self.path = path if path.suffix == ".sqlite" else path / NAME
        if not make and not self.path.is_file():
            raise JournalError(f"there is no journal {self.path}: `nao-course grade ... --out` makes it")
        with self._plainly("open"):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._database = sqlite3.connect(self.path, timeout=PATIENCE, isolation_level=None)
        try:
            with self._plainly("open"):
                self._prepare()
        except BaseException:
            self._database.close()
            raise

    def _prepare(self) -> None:
        """Make the tables of a new file; refuse a file that is another one's."""
        self._database.execute("PRAGMA synchronous = NORMAL")
        application, version = self._pragma("application_id"), self._pragma("user_version")
        new = (application, version) == (0, 0)
        if new:
            with self._writing():  # another grader may have been faster
                if not self._all("SELECT name FROM sqlite_master"):
                    for statement in _SCHEMA.split(";"):
                        self._database.execute(statement)
            application, version = self._pragma("application_id"), self._pragma("user_version")
        if application != _APPLICATION:
            raise JournalError(f"{self.path} is an SQLite file, but no journal of this course: move it away")
        if version > VERSION:
            raise JournalError(
                f"{self.path} is of version {version}, and this nao_course knows {VERSION}: use a newer one"
            )
        if new:
            self._database.execute("PRAGMA journal_mode = WAL")

    def _pragma(self, name: str) -> int:
        return int(self._all(f"PRAGMA {name}")[0][0])

    def __enter__(self) -> Self:
        """Return the journal."""
        return self

    def __exit__(self, *_: object) -> None:
        """Close the file."""
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._database.close()

    # --- results ---

    def keep(self, result: SubmissionResult, versions: str = "") -> None:
        """Store a result in one transaction; the result that it replaces moves to the history.

        A result that another grader has stored meanwhile for the same files is replaced without a trace.

        Parameters
        ----------
        result : SubmissionResult
            Complete.
        versions : str
            Of Python and libraries that it was graded with.

        Raises
        ------
        JournalError
            If it cannot be written: the disk is full, or the file may only be read.
        """
        key = (result.student, result.lesson)
        row = (
            *key,
            result.submission,
            result.assignment,
            result.status,
            result.level,
            result.seconds,
            versions,
            now(),
            json.dumps(as_json(result), ensure_ascii=False),
        )
        with self._writing():
            self._database.execute(
                f"INSERT INTO history SELECT {_COLUMNS} FROM results WHERE student = ? AND lesson = ? "
                "AND (again = 1 OR submission <> ? OR assignment <> ?)",
                (*key, result.submission, result.assignment),
            )
            self._database.execute(
                f"INSERT INTO results ({_COLUMNS}) VALUES ({','.join('?' * len(row))}) "
                "ON CONFLICT (student, lesson) DO UPDATE SET submission = excluded.submission, "
                "assignment = excluded.assignment, status = excluded.status, level = excluded.level, "
                "seconds = excluded.seconds, versions = excluded.versions, time = excluded.time, "
                "result = excluded.result, again = 0",
                row,
            )

    def results(self, lesson: str | None = None) -> list[SubmissionResult]:
        """Return what counts, in the order of students and lessons."""
        return list(self.each_result(lesson))

    def each_result(
        self, lesson: str | None = None, student: str | None = None
    ) -> Iterator[SubmissionResult]:
        """Yield what counts, in the order of students and lessons, one at a time."""
        keys = self._all("SELECT student, lesson FROM results ORDER BY student, lesson")
        for key in keys:
            if (lesson in (None, key[1])) and (student in (None, key[0])):
                found = self._all("SELECT result FROM results WHERE student = ? AND lesson = ?", key)
                yield from (self._result(text) for (text,) in found)

    def students(self) -> set[str]:
        """Return the students who have a result."""
        return {student for (student,) in self._all("SELECT DISTINCT student FROM results")}

    def history(self, student: str, lesson: str) -> list[SubmissionResult]:
        """Return a student's earlier results of a lesson, the oldest first."""
        query = "SELECT result FROM history WHERE student = ? AND lesson = ? ORDER BY rowid"
        return [self._result(text) for (text,) in self._all(query, (student, lesson))]

    def missing(self, student: str, lesson: str, submission: str, assignment: str) -> bool:
        """Return True if a submission has to be graded: it has no current result, or grading it again was requested.

        Parameters
        ----------
        student, lesson : str
            Whose, and of which lesson.
        submission, assignment : str
            Hashes of the submission and of everything that its score depends on.
        """
        query = "SELECT submission, assignment, again FROM results WHERE student = ? AND lesson = ?"
        return self._all(query, (student, lesson)) != [(submission, assignment, 0)]

    def want_again(self, student: str, lesson: str) -> None:
        """Mark a submission to be graded in the next run although nothing has changed."""
        with self._writing():
            self._database.execute(
                "UPDATE results SET again = 1 WHERE student = ? AND lesson = ?", (student, lesson)
            )

    def _result(self, text: str) -> SubmissionResult:
        try:
            return from_json(json.loads(text))
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
            raise JournalError(
                f"{self.path} holds a result that cannot be read ({type(error).__name__}: {error})"
            ) from None

    # --- what people did ---

    def override(self, change: Override) -> None:
        """Keep points that a person gave an exercise; the last one counts."""
        row = (change.student, change.lesson, change.exercise, change.points, change.reason, change.time)
        with self._writing():
            self._database.execute("INSERT INTO overrides VALUES (?, ?, ?, ?, ?, ?)", row)

    def overrides(self, lesson: str | None = None) -> list[Override]:
        """Return the last override of each exercise of each student."""
        rows = self._all("SELECT * FROM overrides ORDER BY rowid")
        last = {each[:3]: Override(*each) for each in rows if lesson in (None, each[1])}
        return [last[key] for key in sorted(last)]

    def mark(self, marks: Iterable[Mark]) -> None:
        """Keep marks of written answers, all or none of them; the last one of an answer counts."""
        with self._writing():
            self._database.executemany(
                "INSERT INTO marks VALUES (?, ?, ?, ?, ?, ?)",
                [(m.student, m.lesson, m.question, m.points, m.comment, m.time) for m in marks],
            )

    def marks(self, lesson: str | None = None) -> list[Mark]:
        """Return the last mark of each written answer."""
        rows = self._all("SELECT * FROM marks ORDER BY rowid")
        last = {each[:3]: Mark(*each) for each in rows if lesson in (None, each[1])}
        return [last[key] for key in sorted(last)]

    def comment(self, comments: Iterable[Comment]) -> None:
        """Keep comments on kinds of wrong answers, all or none of them; the last one of a kind counts."""
        rows = [(each.lesson, each.exercise, each.kind, each.text, each.time) for each in comments]
        with self._writing():
            self._database.execute(_COMMENTS)  # journals of earlier versions have no such table
            self._database.executemany("INSERT INTO comments VALUES (?, ?, ?, ?, ?)", rows)

    def comments(self) -> dict[tuple[str, str, str], str]:
        """Return the last comment by lesson, exercise and kind, and leave out what was taken back."""
        if not self._all("SELECT name FROM sqlite_master WHERE name = 'comments'"):
            return {}
        rows = self._all("SELECT lesson, exercise, kind, text FROM comments ORDER BY rowid")
        return {kind: text for kind, text in {each[:3]: each[3] for each in rows}.items() if text}

    def request(self, requests: Iterable[Request]) -> list[Request]:
        """Keep requests that are not there yet, as open ones; return these."""
        known = {(each.student, each.lesson, each.exercise, each.text) for each in self.requests()}
        new = [
            each for each in requests if (each.student, each.lesson, each.exercise, each.text) not in known
        ]
        rows = [(each.student, each.lesson, each.exercise, each.text, "", now()) for each in new]
        with self._writing():
            self._database.execute(_REQUESTS)
            self._database.executemany("INSERT INTO requests VALUES (?, ?, ?, ?, ?, ?)", rows)
        return new

    def answer(self, student: str, lesson: str, exercise: str, answer: str) -> bool:
        """Answer the open requests about a student's exercise; return whether there was one."""
        key = (student, lesson, exercise, "")
        if all((each.student, each.lesson, each.exercise, each.answer) != key for each in self.requests()):
            return False
        with self._writing():
            self._database.execute(
                "UPDATE requests SET answer = ? WHERE student = ? AND lesson = ? AND exercise = ? AND answer = ?",
                (answer, *key),
            )
        return True

    def requests(self) -> list[Request]:
        """Return all requests, the oldest first."""
        if not self._all("SELECT name FROM sqlite_master WHERE name = 'requests'"):
            return []
        rows = self._all("SELECT student, lesson, exercise, text, answer FROM requests ORDER BY rowid")
        return [Request(*each) for each in rows]

    def began(self, submissions: Path) -> None:
        """Note where the submissions of a run are."""
        with self._writing():
            self._database.execute("INSERT INTO runs VALUES (?, ?)", (str(submissions.resolve()), now()))

    def places(self) -> list[Path]:
        """Return the folders of the submissions of all runs, newest first."""
        rows = self._all("SELECT submissions FROM runs GROUP BY submissions ORDER BY max(rowid) DESC")
        return [Path(each[0]) for each in rows]

    # --- SQLite ---

    def _all(self, query: str, values: tuple[Any, ...] = ()) -> list[Any]:
        with self._plainly("read"):
            return self._database.execute(query, values).fetchall()

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """Write everything in the block, or nothing."""
        with self._plainly("write"):
            self._database.execute("BEGIN IMMEDIATE")
            try:
                yield
                self._database.execute("COMMIT")
            except BaseException:
                if self._database.in_transaction:  # SQLite may have ended it itself, as when the disk is full
                    self._database.execute("ROLLBACK")
                raise

    @contextmanager
    def _plainly(self, verb: str) -> Iterator[None]:
        try:
            yield
        except (sqlite3.Error, OSError) as error:
            raise JournalError(
                f"cannot {verb} the journal {self.path}: {error}. What it held is still in it. "
                f"{_advice(str(error))}"
            ) from None


def _advice(reason: str) -> str:
    """Return advice for an error of SQLite."""
    if "not a database" in reason:
        return "The file is not a journal: move it away, or give another folder."
    if "locked" in reason:
        return "Another grader has been writing for long: wait for it."
    if "full" in reason or "I/O" in reason:
        return "Make room on the disk and say the same again: only what is missing is graded."
    return "Is the folder there, and may it be written to?"
