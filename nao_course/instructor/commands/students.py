"""What the command about students does and says: who is known, who is who, and who is forgotten."""

import html
import shutil
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from nao_course._internal.counts import say_count
from nao_course._internal.tables import TableError
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.collecting.names import safe_name
from nao_course.instructor.collecting.roster import Roster, Student
from nao_course.instructor.collecting.sheets import Sheet, read_sheet
from nao_course.instructor.commands import submission_times
from nao_course.instructor.commands.feedback_pages import folder_of, write_pages
from nao_course.instructor.commands.looking_up import login
from nao_course.instructor.commands.personal_numbers import read_worlds
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.reports.history import page_of
from nao_course.instructor.reports.html import write_whole
from nao_course.instructor.reports.spreadsheets import table

LIST = "students.csv"  # in GRADES
_TEXTS = (".csv", ".html", ".json", ".txt")


def students(
    grades: Path,
    sheet: Path | None = None,
    lesson: str = "",
    same: tuple[str, str] | None = None,
    rename: tuple[str, str] | None = None,
    new: str = "",
    forget: str = "",
) -> Iterator[str]:
    """Change who is who in a class, and write GRADES/students.csv with all students; yield what to say about it.

    The platform's `sheet` says who is in the class, and when a `lesson` was handed in. A name is the `same` student as
    another one; a student is to `rename`; a name is a `new` student; or all data of a student is to `forget`. Raise a
    ValueError if a name or the sheet does not fit.
    """
    course = load_course()
    words = " ".join(
        f"--{name} {value if isinstance(value, Path | str) else ' '.join(value)}"
        for name, value in (("sheet", sheet), ("same", same), ("new", new), ("rename", rename))
        if value
    )
    with (
        Journal(grades, make=sheet is not None, policy=course.late_policy) as journal,
        journal.command(f"students {words}", login()),
    ):
        if sheet:
            (name,) = course.names([lesson]) if lesson else [""]
            given = read_sheet(sheet, name)
            yield f"read {say_count(len(given.rows), 'row')} of {sheet}"
            yield from learn(journal, grades, given)
            yield from _record_times(journal, grades, given, name)
        if same:
            yield from _join(journal, grades, *same)
        if new:
            journal.know([Student(new, new)])
            yield f"{new} is a student of the class."
        if rename:
            if rename[1] in journal.roster().students:
                raise ValueError(f"there is a student {rename[1]!r} already. If they are one, say --same")
            yield from _rename(journal, grades, _meant(journal.roster(), rename[0]), rename[1])
    with Journal(grades, make=False, policy=course.late_policy) as journal:
        if forget:
            yield from _forget(journal, grades, _meant(journal.roster(), forget))
        yield from _list(journal, grades)


def learn(journal: Journal, grades: Path, sheet: Sheet) -> Iterator[str]:
    """Record what a sheet says about students; yield what to say about it."""
    roster, renamed, by_name = journal.roster().with_sheet(sheet.rows)
    for old, student in renamed.items():
        yield from _rename(journal, grades, old, student)
    journal.know(each for each in roster.students.values() if each.listed)
    yield from by_name


def _record_times(journal: Journal, grades: Path, sheet: Sheet, lesson: str) -> Iterator[str]:
    """Record the times of a lesson that a sheet has; yield what to say about it."""
    if lesson:
        changed = submission_times.record_sheet(sheet, lesson, journal)
        for student, _ in changed:
            write_pages(journal, grades, journal.each_result(lesson, student))
        yield f"{lesson}: {say_count(len(changed), 'time')} new or changed"
    elif sheet.times:
        yield "The sheet's times are not used: they are of one lesson, so name it with --lesson."


def names_in_copies(path: Path, roster: Roster) -> dict[str, str]:
    """Return the names in the students' copies by student, from a table of worlds or the sheet that release was given.

    Raise a ValueError if it is neither.
    """
    from nao_course.instructor.authoring.release import read_students

    try:
        worlds = read_worlds(path)
    except TableError:
        if not read_sheet(path).platform:
            raise
        worlds = {name: name for name in read_students(path)}
    return {roster.meant(name) or name: world for name, world in worlds.items()}


def _list(journal: Journal, grades: Path) -> Iterator[str]:
    """Write the table of all students, and yield a line for each."""
    known = journal.roster().students.values()
    header = ["student", "name", "email", "login", "section", "aliases"]
    rows = [
        [each.student, each.name, each.email, each.login, each.section, "; ".join(each.aliases)]
        for each in known
    ]
    for row in rows:
        more = ", ".join(filter(None, [*(cell for cell in row[1:5] if cell != row[0]), row[5]]))
        yield f"{row[0]}{': ' if more else ''}{more}"
    path = write_whole(grades / LIST, table([header, *rows]))
    yield f"wrote {path}: {say_count(len(rows), 'student')}; nao-course release --students {grades} uses these names"


def _meant(roster: Roster, word: str) -> str:
    if student := roster.meant(word):
        return student
    raise ValueError(f"there is no student {word!r}: nao-course students GRADES lists all")


def _join(journal: Journal, grades: Path, name: str, word: str) -> Iterator[str]:
    """Make a name in a download, or a student, the same as the student whom a word means."""
    roster = journal.roster()
    student = _meant(roster, word)
    if name in roster.students and name != student:
        yield from _rename(journal, grades, name, student)
        return
    other = roster.students.get(roster.meant(name) or "")
    if other is None or other.student == student:
        yield from _rename(journal, grades, name, student)
        return
    theirs = {alias: lesson for alias, lesson in other.aliases.items() if roster.is_alias(alias, name)}
    kept = {alias: lesson for alias, lesson in other.aliases.items() if alias not in theirs}
    joined = roster.students[student].joined(Student(student, aliases={**theirs, name: ""}))
    journal.know([replace(other, aliases=kept), joined])
    yield (
        f"{name} is {student} and not {other.student}. Run grade again with the download; what was graded as "
        f"{other.student}'s stays until that student's own work is graded."
    )


def _rename(journal: Journal, grades: Path, old: str, new: str) -> Iterator[str]:
    """Give a student another name, also on the feedback pages."""
    both = journal.rename(old, new)
    if old != new:
        shutil.rmtree(folder_of(grades, old), ignore_errors=True)
        page_of(grades, old).unlink(missing_ok=True)
    write_pages(journal, grades, journal.each_result(student=new))
    yield f"{old} is {new}."
    if both:
        yield (
            f"Of {', '.join(both)} both had a result: the later one counts, the other one is in the history. Run grade "
            "again with the download to be sure."
        )


def _forget(journal: Journal, grades: Path, student: str) -> Iterator[str]:
    """Delete what is recorded and written about a student; yield what remains elsewhere."""
    said = journal.roster().students[student]
    places = [each for each in journal.places() if each.exists()]
    extensions = journal.policy.extensions if journal.policy else {}
    journal.forget(student)
    shutil.rmtree(folder_of(grades, student), ignore_errors=True)
    page_of(grades, student).unlink(missing_ok=True)
    for folder in (grades / "exports").glob(f"gradescope/*/{safe_name(student)}"):
        shutil.rmtree(folder, ignore_errors=True)
    (grades / LIST).unlink(missing_ok=True)
    yield f"{student} is forgotten: results, decisions, requests, names and feedback pages are deleted."
    words = {each for each in (student, said.name, said.email, said.login, *said.aliases) if len(each) > 2}
    for path in sorted(grades.rglob("*")):
        if path.suffix in _TEXTS and path.is_file():
            text = path.read_text(encoding="utf-8", errors="replace")
            if any(word in text or html.escape(word) in text for word in words):
                yield f"still names the student, write it again or delete it: {path}"
        elif path.suffix == ".zip":
            yield f"may contain a page of the student, write it again or delete it: {path}"
    if student in extensions:
        yield "still names the student: course.toml, in [extensions]"
    for place in places:
        yield f"may contain work of the student: {place}"
