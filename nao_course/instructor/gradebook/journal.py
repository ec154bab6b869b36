"""The journal: a crash-safe SQLite file with results, manual changes and marks.

It is in WAL mode with synchronous=NORMAL. A result is one transaction, so a grader that is killed leaves all or
nothing of it; what was committed is with the operating system and outlives the process. A power cut may take the
last few transactions, never the file, and the same command grades those again: an fsync for each result buys nothing.
"""

import json
import sqlite3
from collections import defaultdict
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, Self, TypeVar

from nao_course.instructor.collecting.roster import Roster, Student, is_nameless
from nao_course.instructor.gradebook import tables, undo
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
from nao_course.instructor.gradebook.tables import APPLICATION, OF_STUDENTS, RESULT_COLUMNS, VERSION

Decision = Override | Mark | Comment | Request
D = TypeVar("D", Override, Mark, Comment, Request)
Given = TypeVar("Given", Override, Mark)

NAME = "journal.sqlite"
PATIENCE = 60.0  # seconds that one grader waits for another one's transaction


class JournalError(ValueError):
    """A journal that cannot be used or written; the message says which and what to do."""


class Journal:
    """What was graded: open it, keep results in it, read them.

    It is an SQLite file, or the folder of it, and made if there is none, if `make`. By default, late submissions lose
    nothing; `problems` lists failures for single students in `for_one`. Raise a JournalError if it is not a journal, of
    a newer version, or cannot be opened.

    ::

        with Journal(Path("grades")) as journal:
            journal.keep(result)
    """

    def __init__(self, path: Path, *, make: bool = True, policy: LatePolicy | None = None) -> None:
        self.problems: list[str] = []
        self._command: tuple[str, str, str] | None = None  # words, who and when, while it runs
        self._number: int | None = None  # of the command, once it has written something
        self.path = path if path.suffix == ".sqlite" else path / NAME
        if not make and not self.path.is_file():
            raise JournalError(f"there is no journal {self.path}: `nao-course grade ... --out` makes it")
        with self._errors_in_words("open"):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._database = sqlite3.connect(self.path, timeout=PATIENCE, isolation_level=None)
        try:
            with self._errors_in_words("open"):
                self._prepare()
        except BaseException:
            self._database.close()
            raise
        self._policy = policy
        self.policy = self._policy_by_student()

    def _policy_by_student(self) -> LatePolicy | None:
        """Return the late policy with its extensions by the students' names in the journal."""
        extended = self._policy and self._policy.extensions
        return self._policy.by_student(self.roster().meant) if self._policy and extended else self._policy

    def _prepare(self) -> None:
        """Create the tables in a new file; refuse SQLite files of other programs."""
        self._database.execute("PRAGMA synchronous = NORMAL")
        application, version = self._pragma("application_id"), self._pragma("user_version")
        new = (application, version) == (0, 0)
        if new:
            with self._writing():  # another grader may have been faster
                if not self._all("SELECT name FROM sqlite_master"):
                    tables.create(self._database)
            application, version = self._pragma("application_id"), self._pragma("user_version")
        if application != APPLICATION:
            raise JournalError(f"{self.path} is an SQLite file, but no journal of this course: move it away")
        if version > VERSION:
            raise JournalError(
                f"{self.path} is of version {version}, and this nao_course knows {VERSION}: use a newer one"
            )
        if new:
            self._database.execute("PRAGMA journal_mode = WAL")
        if version < VERSION:
            with self._writing():
                present = self._pragma("user_version")  # another grader may have been faster
                tables.migrate(self._database, present, self.each_result, self._write_students)

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

    @contextmanager
    def for_one(self, student: str, lesson: str, lost: str) -> Iterator[None]:
        """Run work for one student: a failure is listed in `problems`, and the others' work goes on.

        `lost` says what a failure means, such as "the feedback page was not written".
        """
        try:
            yield
        except JournalError:
            raise
        except Exception as error:  # noqa: BLE001 - nobody's submission may stop another's
            self.problems.append(f"{student}, {lesson}: {lost} ({type(error).__name__}: {error})")

    # --- results ---

    def keep(self, result: SubmissionResult, *, newest: SubmissionResult | None = None) -> None:
        """Store a result in one transaction; the result that it replaces moves to the history.

        A result that another grader has stored meanwhile for the same files is replaced without a trace. `newest` is
        the result of a newer submission that does not count, so that it is not graded again. Raise a JournalError if
        the disk is full, or the file may only be read.
        """
        key = (result.student, result.lesson)
        graded = newest or result
        row = (
            *key,
            graded.submission,
            graded.assignment,
            result.status,
            result.level,
            result.seconds,
            ", ".join(f"{name} {version}" for name, version in result.graded_with.items()),
            now(),
            json.dumps(as_json(result), ensure_ascii=False),
        )
        with self._writing():
            self._database.execute(
                f"INSERT INTO history SELECT {RESULT_COLUMNS} FROM results WHERE student = ? AND lesson = ? "
                "AND (again = 1 OR submission <> ? OR assignment <> ?)",
                (*key, graded.submission, graded.assignment),
            )
            self._database.execute(
                f"INSERT INTO results ({RESULT_COLUMNS}) VALUES ({','.join('?' * len(row))}) "
                "ON CONFLICT (student, lesson) DO UPDATE SET submission = excluded.submission, "
                "assignment = excluded.assignment, status = excluded.status, level = excluded.level, "
                "seconds = excluded.seconds, versions = excluded.versions, time = excluded.time, "
                "result = excluded.result, again = 0",
                row,
            )
            # Decisions on a whole submission are for its answers, as soon as their fingerprints are known.
            for table in ("overrides", "requests"):
                which = f"{table} WHERE student = ? AND lesson = ? AND decided_on = ?"
                decided = (*key, result.submission)
                for (exercise,) in self._database.execute(
                    f"SELECT exercise FROM {which}", decided
                ).fetchall():
                    self._database.execute(
                        f"UPDATE {which.replace(' WHERE', ' SET decided_on = ? WHERE')} AND exercise = ?",
                        (result.answer_to(exercise), *decided, exercise),
                    )

    def results(self, lesson: str | None = None) -> list[SubmissionResult]:
        """Return what counts, in the order of students and lessons."""
        return list(self.each_result(lesson))

    def each_result(
        self, lesson: str | None = None, student: str | None = None
    ) -> Iterator[SubmissionResult]:
        """Yield what counts, in the order of students and lessons, one at a time."""
        query = (
            "SELECT student, lesson FROM results WHERE student = ifnull(?, student) AND lesson = ifnull(?, lesson) "
            "ORDER BY student, lesson"
        )
        for key in self._all(query, (student, lesson)):
            found = self._all("SELECT result FROM results WHERE student = ? AND lesson = ?", key)
            yield from (self._result(text) for (text,) in found)

    def students(self) -> set[str]:
        """Return the students who have a result."""
        return {student for (student,) in self._all("SELECT DISTINCT student FROM results")}

    def graded(self, student: str) -> list[tuple[str, SubmissionResult, bool]]:
        """Return all results of a student, the oldest first: when they were graded, and whether they count."""
        query = (
            "SELECT time, result, 0 FROM history WHERE student = ? UNION ALL "
            "SELECT time, result, 1 FROM results WHERE student = ? ORDER BY 1, 3"
        )
        found = self._all(query, (student, student))
        return [(time, self._result(text), bool(counts)) for time, text, counts in found]

    def history(self, student: str, lesson: str) -> list[SubmissionResult]:
        """Return a student's earlier results of a lesson, the oldest first."""
        query = "SELECT result FROM history WHERE student = ? AND lesson = ? ORDER BY rowid"
        return [self._result(text) for (text,) in self._all(query, (student, lesson))]

    def missing(self, student: str, lesson: str, submission: str, assignment: str) -> bool:
        """Return True if a submission has to be graded: it has no current result, or grading it again was requested.

        `submission` and `assignment` are hashes of the submission and of everything that its score depends on.
        """
        query = "SELECT submission, assignment, again FROM results WHERE student = ? AND lesson = ?"
        return self._all(query, (student, lesson)) != [(submission, assignment, 0)]

    def want_again(self, student: str, lesson: str) -> None:
        """Mark a submission to be graded in the next run although nothing has changed."""
        with self._writing():
            undo.forget_commands(self._database)
            self._database.execute(
                "UPDATE results SET again = 1 WHERE student = ? AND lesson = ?", (student, lesson)
            )

    def date(self, student: str, lesson: str, submission: str, handed_in: str, timed_by: str) -> bool:
        """Record when a submission was made; return whether the time of its result is another one than before.

        Nothing happens if the result is of another submission.
        """
        with self._writing():
            for before in self.each_result(lesson, student):
                after = replace(before, handed_in=handed_in, timed_by=timed_by)
                if before.submission == submission and before != after:
                    self._database.execute(
                        "UPDATE results SET result = ? WHERE student = ? AND lesson = ?",
                        (json.dumps(as_json(after), ensure_ascii=False), student, lesson),
                    )
                    return before.handed_in != handed_in
        return False

    def _result(self, text: str) -> SubmissionResult:
        try:
            return from_json(json.loads(text))
        except (ValueError, TypeError, KeyError, AttributeError, RecursionError) as error:
            raise JournalError(
                f"{self.path} holds a result that cannot be read ({type(error).__name__}: {error})"
            ) from None

    # --- who is who ---

    def roster(self) -> Roster:
        """Return the students who have a result or are in a sheet."""
        aliases: dict[str, dict[str, str]] = defaultdict(dict)
        for alias, student, lesson in self._all("SELECT alias, student, lesson FROM aliases ORDER BY alias"):
            aliases[student][alias] = lesson
        rows = self._all("SELECT student, name, email, login, section, listed FROM students ORDER BY student")
        known = {
            student: Student(student, name, email, login, section, aliases[student], bool(listed))
            for student, name, email, login, section, listed in rows
        }
        others = self.students() - known.keys()
        return Roster(
            [*known.values(), *(Student(each, "" if is_nameless(each) else each) for each in others)]
        )

    def know(self, students: Iterable[Student]) -> None:
        """Record students; what is known of the same ones is replaced."""
        with self._writing():
            self._write_students(students)
        self.policy = self._policy_by_student()

    def _write_students(self, students: Iterable[Student]) -> None:
        for each in students:
            row = (each.student, each.name, each.email, each.login, each.section, int(each.listed))
            self._database.execute("INSERT OR REPLACE INTO students VALUES (?, ?, ?, ?, ?, ?)", row)
            self._database.execute("DELETE FROM aliases WHERE student = ?", (each.student,))
            self._database.executemany(
                "INSERT OR REPLACE INTO aliases VALUES (?, ?, ?)",
                [(alias, each.student, lesson) for alias, lesson in each.aliases.items()],
            )

    def rename(self, old: str, new: str) -> list[str]:
        """Give a student another name; if there is a student of this name, the two become one.

        Return the lessons of which both have a result: the later submission counts, or else the result with more
        points, and the other result moves to the history.
        """
        roster = self.roster()
        before, after = (roster.students.get(each, Student(each)) for each in (old, new))
        with self._writing():
            (mine, theirs) = (
                {each.lesson: each for each in self.each_result(None, who)} for who in (old, new)
            )
            for lesson in mine.keys() & theirs.keys():
                other = (old if _is_later(theirs[lesson], mine[lesson]) else new, lesson)
                of_one = "WHERE student = ? AND lesson = ?"
                self._database.execute(
                    f"INSERT INTO history SELECT {RESULT_COLUMNS} FROM results {of_one}", other
                )
                self._database.execute(f"DELETE FROM results {of_one}", other)
            for table in ("results", "history"):
                for row, text in self._all(f"SELECT rowid, result FROM {table} WHERE student = ?", (old,)):
                    renamed = json.dumps(json.loads(text) | {"student": new}, ensure_ascii=False)
                    self._database.execute(f"UPDATE {table} SET result = ? WHERE rowid = ?", (renamed, row))
            for table in OF_STUDENTS[:-2]:
                self._database.execute(f"UPDATE {table} SET student = ? WHERE student = ?", (new, old))
            for table in OF_STUDENTS[-2:]:
                self._database.execute(f"DELETE FROM {table} WHERE student = ?", (old,))
            joined = replace(before, student=new).joined(after)
            self._write_students([replace(joined, aliases={**joined.aliases, old: ""})])
        self.policy = self._policy_by_student()
        return sorted(mine.keys() & theirs.keys())

    def forget(self, student: str) -> None:
        """Delete all that is recorded of a student, also from the parts of the file that are not used any more."""
        self._database.execute("PRAGMA secure_delete = ON")
        with self._writing():
            for table in OF_STUDENTS:
                self._database.execute(f"DELETE FROM {table} WHERE student = ?", (student,))
            undo.forget_commands(self._database)
        with self._errors_in_words("write"):
            self._database.execute("VACUUM")
            self._database.execute("PRAGMA wal_checkpoint(TRUNCATE)").fetchall()

    # --- what people did ---

    def override(self, change: Override) -> None:
        """Keep points that a person gave an exercise; the last one for an answer counts."""
        with self._writing():
            self._insert("overrides", [change])

    def overrides(self, lesson: str | None = None) -> list[Override]:
        """Return the overrides of each exercise of each student, the last one for each answer, the oldest first.

        What was withdrawn is left out.
        """
        return _last_of_each(self._records("overrides", Override), lesson)

    def mark(self, marks: Iterable[Mark]) -> None:
        """Keep marks of written answers, all or none of them; the last one of an answer counts."""
        with self._writing():
            self._insert("marks", marks)

    def marks(self, lesson: str | None = None) -> list[Mark]:
        """Return the first and second marks of each question of each student, as `overrides` does."""
        return _last_of_each(self._records("marks", Mark), lesson)

    def comment(self, comments: Iterable[Comment]) -> None:
        """Keep comments on kinds of wrong answers, all or none of them; the last one of a kind counts."""
        with self._writing():
            self._insert("comments", comments)

    def comments(self) -> dict[tuple[str, str, str], Comment]:
        """Return the last comment by lesson, exercise and kind, and leave out what was taken back."""
        last = {(each.lesson, each.exercise, each.kind): each for each in self._records("comments", Comment)}
        return {kind: each for kind, each in last.items() if each.text}

    def request(self, requests: Iterable[Request]) -> list[Request]:
        """Keep requests that are not there yet, and return what has changed.

        A new text takes the place of an open request about the same exercise. What could not be read of a student's
        earlier file (no exercise) is forgotten.
        """
        given, there = list(requests), self.requests()
        known = {(each.student, each.lesson, each.exercise, each.text) for each in there}
        new = [each for each in given if (each.student, each.lesson, each.exercise, each.text) not in known]
        about = {(each.student, each.lesson, each.exercise) for each in new}
        students, unread = (
            {each.student for each in given},
            {each.text for each in given if not each.exercise},
        )
        gone = [
            each
            for each in there
            if (not each.answer and (each.student, each.lesson, each.exercise) in about)
            or (not each.exercise and each.student in students and each.text not in unread)
        ]
        with self._writing():
            self._database.executemany(
                "DELETE FROM requests WHERE student = ? AND lesson = ? AND exercise = ? AND text = ?",
                [(each.student, each.lesson, each.exercise, each.text) for each in gone],
            )
            self._insert("requests", new)
        return [*new, *gone]

    def answer(
        self, student: str, lesson: str, exercise: str, answer: str, decided_on: str, given_by: str = ""
    ) -> bool:
        """Answer the open requests about a student's exercise; return whether there was one."""
        key = (student, lesson, exercise, "")
        if all((each.student, each.lesson, each.exercise, each.answer) != key for each in self.requests()):
            return False
        with self._writing():
            self._database.execute(
                "UPDATE requests SET answer = ?, decided_on = ?, given_by = ? "
                "WHERE student = ? AND lesson = ? AND exercise = ? AND answer = ?",
                (answer, decided_on, given_by, *key),
            )
        return True

    def requests(self) -> list[Request]:
        """Return all requests, the oldest first."""
        return list(self._records("requests", Request))

    def decisions(self, student: str) -> list[Override | Mark]:
        """Return all points and marks that people gave a student, also withdrawn ones, the oldest first."""
        both: list[Override | Mark] = [*self._records("overrides", Override), *self._records("marks", Mark)]
        return sorted((each for each in both if each.student == student), key=lambda each: each.time)

    def last_change(self, lesson: str) -> str:
        """Return when a result, points or a mark of a lesson last came into the journal; empty if none did."""
        every = " UNION ALL ".join(
            f"SELECT time FROM {table} WHERE lesson = :lesson" for table in ("results", "overrides", "marks")
        )
        ((time,),) = self._all(f"SELECT ifnull(max(time), '') FROM ({every})", {"lesson": lesson})
        return str(time)

    @contextmanager
    def command(self, words: str, given_by: str) -> Iterator[None]:
        """Remember what a person's command replaces in the journal, so that `undo` can take it back."""
        self._command = (words, given_by, now())
        try:
            yield
        finally:
            number, self._command, self._number = self._number, None, None
            if number is not None:
                with self._writing():
                    undo.end(self._database, number)

    def undo(self) -> str:
        """Take back the last command, and return its words. Raise a JournalError if there is none."""
        with self._writing():
            last = self._database.execute(
                "SELECT number, words, given_by, time FROM commands ORDER BY number DESC LIMIT 1"
            ).fetchone()
            if last is None:
                raise JournalError(
                    "there is nothing to undo: only marks, comments, points by hand, requests and changes of students "
                    "since the last grade or --forget can be undone"
                )
            undo.take_back(self._database, last[0])
        self.policy = self._policy_by_student()
        return f"{last[1]} (by {last[2] or 'unknown'}, {last[3]})"

    def began(self, submissions: Path) -> None:
        """Note where the submissions of a run are. What was commanded before cannot be undone any more."""
        with self._writing():
            undo.forget_commands(self._database)
            self._database.execute("INSERT INTO runs VALUES (?, ?)", (str(submissions.resolve()), now()))

    def places(self) -> list[Path]:
        """Return the folders of the submissions of all runs, newest first."""
        rows = self._all("SELECT submissions FROM runs GROUP BY submissions ORDER BY max(rowid) DESC")
        return [Path(each[0]) for each in rows]

    # --- SQLite ---

    def _insert(self, table: str, records: Iterable[Decision]) -> None:
        """Insert records, whose fields are the table's columns."""
        for each in records:
            values = vars(each)
            self._database.execute(
                f"INSERT INTO {table} ({', '.join(values)}) VALUES ({', '.join('?' * len(values))})",
                tuple(values.values()),
            )

    def _records(self, table: str, kind: type[D]) -> Iterator[D]:
        """Yield the rows of a table as records, the oldest first."""
        columns = [each.name for each in fields(kind)]
        for row in self._all(f"SELECT {', '.join(columns)} FROM {table} ORDER BY rowid"):
            yield kind(*row)

    def _all(self, query: str, values: tuple[Any, ...] | dict[str, Any] = ()) -> list[Any]:
        with self._errors_in_words("read"):
            return self._database.execute(query, values).fetchall()

    @contextmanager
    def _writing(self) -> Iterator[None]:
        """Write everything in the block, or nothing."""
        with self._errors_in_words("write"):
            self._database.execute("BEGIN IMMEDIATE")
            try:
                number = self._number
                if self._command and number is None:  # a command that is refused writes nothing
                    number = undo.begin(self._database, *self._command)
                yield
                self._database.execute("COMMIT")
                self._number = number
            except BaseException:
                if self._database.in_transaction:  # SQLite may have ended it itself, as when the disk is full
                    self._database.execute("ROLLBACK")
                raise

    @contextmanager
    def _errors_in_words(self, verb: str) -> Iterator[None]:
        try:
            yield
        except (sqlite3.Error, OSError) as error:
            raise JournalError(
                f"cannot {verb} the journal {self.path}: {error}. What it held is still in it. "
                f"{_advice(str(error))}"
            ) from None


def _is_later(one: SubmissionResult, other: SubmissionResult) -> bool:
    """Return whether a result was handed in later than another one, or has more points if a time is unknown."""
    if one.handed_in and other.handed_in:
        return one.handed_in >= other.handed_in
    return one.earned >= other.earned


def _last_of_each(given: Iterable[Given], lesson: str | None) -> list[Given]:
    """Return the last decision for each answer, by students and lessons and then the oldest first."""
    last: dict[tuple[str, str, str, bool], dict[str, Given]] = defaultdict(dict)
    for each in given:
        if lesson in (None, each.lesson):
            decided = last[each.student, each.lesson, each.item, bool(getattr(each, "is_second", False))]
            if each.is_withdrawn:
                decided.clear()
            else:
                decided.pop(each.decided_on, None)
                decided[each.decided_on] = each
    return [each for key in sorted(last) for each in last[key].values()]


def _advice(reason: str) -> str:
    """Return advice for an error of SQLite."""
    if "not a database" in reason:
        return "The file is not a journal: move it away, or give another folder."
    if "locked" in reason:
        return "Another grader has been writing for long: wait for it."
    if "full" in reason or "I/O" in reason:
        return "Make room on the disk and say the same again: only what is missing is graded."
    return "Is the folder there, and may it be written to?"
