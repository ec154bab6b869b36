"""What commands look up in a journal; their errors name what is nearest to what was given."""

import difflib
import getpass
from collections.abc import Iterable, Iterator

import typer

from nao_course._internal.counts import say_count
from nao_course.exercises import lesson_names
from nao_course.instructor.gradebook.journal import Journal, JournalError
from nao_course.instructor.gradebook.records import SubmissionResult


def login() -> str:
    """Return the login of the person who gives the command; an empty text if there is none."""
    try:
        return getpass.getuser()
    except (OSError, KeyError, ImportError):
        return ""


def result_of(journal: Journal, student: str, lesson: str) -> SubmissionResult:
    """Return the only result that matches."""
    results = list(journal.each_result(student=journal.roster().meant(student) or ""))
    if not results:
        names = {each.student for each in journal.each_result()}
        near = difflib.get_close_matches(student, names, 3)
        hint = (
            f"; is it {' or '.join(map(repr, near))}?"
            if near
            else "; nao-course students GRADES lists all names"
        )
        raise ValueError(f"the journal has no result of {student!r}{hint}")
    there = [each.lesson for each in results]
    meant = [each for each in results if not lesson or each.lesson in lesson_names.meant(lesson, there)]
    if len(meant) != 1:
        raise ValueError(f"say which lesson of {student!r} with --lesson: there are {', '.join(there)}")
    return meant[0]


def results_of(journal: Journal, keys: Iterable[tuple[str, str]]) -> Iterator[SubmissionResult]:
    """Yield the results of students in lessons."""
    for student, lesson in keys:
        yield from journal.each_result(lesson, student)


def graded_lesson(journal: Journal, wanted: str) -> str | None:
    """Return the full name of a graded lesson; None for all lessons."""
    if not wanted:
        return None
    there = sorted({each.lesson for each in journal.each_result()})
    meant = lesson_names.meant(wanted, there)
    if not meant:
        raise JournalError(f"no lesson {wanted!r} was graded; there are {', '.join(there) or 'none'}")
    return meant[0]


def only_lesson(journal: Journal) -> str:
    """Return the name of the only lesson that was graded; raise a JournalError if there are several or none."""
    there = sorted({each.lesson for each in journal.each_result()})
    if len(there) != 1:
        raise JournalError(f"say which lesson: --lesson NN; graded are {', '.join(there) or 'none'}")
    return there[0]


def without_result(where: str, names: Iterable[str], journal: Journal) -> Iterator[str]:
    """Yield a line for each name of a file that no student with a result has: it may be misspelt."""
    students = journal.students()
    for name in sorted(set(names) - students):
        near = difflib.get_close_matches(name, students, 1)
        hint = f"; is it {near[0]!r}?" if near else ""
        yield f"{where}: {name!r} has no result{hint}"


def unknown_extensions(journal: Journal) -> list[str]:
    """Return the names in the extensions of course.toml that no student has, once a sheet says who is in the class."""
    roster = journal.roster()
    extensions = journal.policy.extensions if journal.policy else {}
    return sorted(extensions.keys() - roster.students.keys()) if roster.is_listed else []


def list_problems(journal: Journal) -> Iterator[str]:
    """Yield what failed for single students; end the command with status 1 after it."""
    if journal.problems:
        yield f"FAILED for {say_count(len(journal.problems), 'student')}; everything else is done:"
        yield from journal.problems
        raise typer.Exit(1)
