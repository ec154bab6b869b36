"""What `nao-course export`, `nao-course marks` and `nao-course report` do and say."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from nao_course.instructor.autograding.batch import feedback_writer
from nao_course.instructor.commands import FEEDBACK
from nao_course.instructor.gradebook.journal import Journal, JournalError
from nao_course.instructor.reports import exports, marking_sheets
from nao_course.instructor.reports.html import counted

_SHOWN = 20  # names of those who wait


def export(grades: Path, format_: str, lesson: str = "") -> Iterator[str]:
    """Write grades for another system; yield what to say about it.

    Parameters
    ----------
    grades : Path
        Folder of the journal.
    format_ : str
        One of `exports.FORMATS`.
    lesson : str
        Number or name; all where empty.

    Raises
    ------
    ValueError
        If there is no such format, journal or lesson.
    """
    if exports.check_format(format_) == "gradescope":
        yield from _gradescope(grades, lesson)
        return
    with Journal(grades, make=False) as journal:
        yield f"wrote {exports.write_csv(journal, grades / exports.FOLDER, _lesson(journal, lesson))}"


def _gradescope(grades: Path, lesson: str) -> Iterator[str]:
    from nao_course.instructor.authoring.course import load_course
    from nao_course.instructor.autograding.secret import load_secret
    from nao_course.instructor.gradescope import write_autograder

    course, secret = load_course(), load_secret()
    wanted = course.names([lesson]) if lesson else []
    folder = grades / exports.FOLDER / "gradescope"
    with Journal(grades) as journal:  # an autograder is wanted before anything was graded
        graded = sorted({each.lesson for each in journal.each_result()})
        for name in wanted or course.names(graded):
            written = exports.write_gradescope(journal, folder, name)
            yield f"wrote {counted(len(written), 'result')} into {folder / name}"
            yield f"wrote {write_autograder(course, name, secret, folder)}"
    yield "An autograder's zip holds the solution: upload it to Gradescope, and give it to nobody."


def _lesson(journal: Journal, wanted: str) -> str | None:
    """The whole name of a lesson that was graded."""
    there = sorted({each.lesson for each in journal.each_result()})
    meant = [each for each in there if wanted in ("", each) or each.split("_")[0] == wanted.zfill(2)]
    if wanted and not meant:
        raise JournalError(f"no lesson {wanted!r} was graded; there are {', '.join(there) or 'none'}")
    return meant[0] if wanted else None


def marks(grades: Path, file: Path | None) -> Iterator[str]:
    """Write the marking sheets, or read one back and renew the feedback; yield what to say about it.

    Parameters
    ----------
    grades : Path
        Folder of the journal.
    file : Path or None
        A sheet that is filled in.

    Raises
    ------
    ValueError
        If there is no journal, or something in the file is wrong: then nothing is read in.
    """
    with Journal(grades, make=False) as journal:
        if file is None:
            yield from _sheets(journal, grades)
            return
        taken = marking_sheets.read_marks(journal, file)
        yield f"{counted(taken.read, 'mark')} read, {len(taken.changed)} of them new or changed"
        changed = {(each.student, each.lesson) for each in taken.changed}
        write = feedback_writer(journal, grades / FEEDBACK)
        for student, lesson in sorted(changed):
            for result in journal.each_result(lesson, student):
                write(result)
        if taken.open:
            names = ", ".join(student for student, _ in taken.open[:_SHOWN])
            more = f" and {len(taken.open) - _SHOWN} more" if len(taken.open) > _SHOWN else ""
            yield f"Still to mark: {counted(len(taken.open), 'answer')} ({names}{more})"
        else:
            yield "Nothing is left to mark in it."


def _sheets(journal: Journal, grades: Path) -> Iterator[str]:
    written = marking_sheets.write_sheets(journal, grades / marking_sheets.FOLDER)
    for each in written:
        yield f"wrote {each.table} and .html: {counted(each.answers, 'answer')}, {each.open} to mark"
    if written:
        yield "Fill in points and comment, save as CSV, and say nao-course marks GRADES FILE."
    else:
        yield "No written question has been handed in: there is nothing to mark."


def report(grades: Path) -> Iterator[str]:
    """Write GRADES/report.html; yield what to say about it.

    Raises
    ------
    ValueError
        If there is no journal.
    """
    from nao_course.instructor.reports.class_report import write_report

    with Journal(grades, make=False) as journal:
        yield f"wrote {write_report(journal, grades / 'report.html')}"
