"""What the commands about marks and comments do and say."""

from collections.abc import Iterator, Mapping, Sequence
from functools import cache, partial
from pathlib import Path

from nao_course._internal.counts import say_count
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.autograding.scratch import scratch_folder
from nao_course.instructor.autograding.secret import load_secret, student_code
from nao_course.instructor.collecting import files
from nao_course.instructor.collecting.archives import Refused
from nao_course.instructor.collecting.names import safe_name
from nao_course.instructor.commands import students
from nao_course.instructor.commands.feedback_pages import write_pages
from nao_course.instructor.commands.grading import handed_in_before
from nao_course.instructor.commands.looking_up import (
    graded_lesson,
    list_problems,
    login,
    only_lesson,
    result_of,
    results_of,
    without_result,
)
from nao_course.instructor.commands.personal_numbers import PersonalNumbers
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import SubmissionResult
from nao_course.instructor.reports import comment_sheets, marking_sheets
from nao_course.instructor.reports.html import write_whole
from nao_course.instructor.similarity.own_code import defining_cell, own_code

_SHOWN = 20  # names, and lines of one kind


def marks(
    grades: Path,
    file: Path | None,
    *,
    anonymous: bool = False,
    worlds: Path | None = None,
    by: str = "",
    parts: int = 1,
    double: bool = False,
    lesson: str = "",
) -> Iterator[str]:
    """Write the marking sheets, or read one back and renew the feedback; yield what to say about it.

    Sheets are written for a `lesson`, by default for all. An `anonymous` sheet names students by codes; `worlds` is a
    CSV file with the names in the students' copies, by the names in the gradebook. Each question's answers are divided
    into `parts`, and with `double` a second person gets a sheet of each. `by` is who gave the marks in the file. Raise
    a ValueError if there is no journal, or if anything in the file is wrong, so that nothing is read in.
    """
    with Journal(grades, make=False, policy=load_course().late_policy) as journal:
        if file is None:
            copies = students.names_in_copies(worlds, journal.roster()) if worlds else {}
            if worlds:
                yield from without_result(worlds.name, copies, journal)
            yield from _sheets(
                journal, grades, anonymous, copies, parts, double, graded_lesson(journal, lesson)
            )
            return
        by = by or login()
        with journal.command(f"marks {file.name}", by):
            taken = marking_sheets.read_marks(journal, file, partial(student_code, load_secret()), by)
        yield f"{say_count(taken.read, 'mark')} by {by} read, {len(taken.changed)} of them new or changed"
        changed = sorted({(each.student, each.lesson) for each in taken.changed})
        write_pages(journal, grades, results_of(journal, changed))
        yield from _shortened("Replaced", taken.replaced)
        yield from _shortened("TWO MARKS DIFFER (settle with regrade --set QUESTION=POINTS)", taken.differing)
        if taken.open:
            names = ", ".join(student for student, _ in taken.open[:_SHOWN])
            more = f" and {len(taken.open) - _SHOWN} more" if len(taken.open) > _SHOWN else ""
            yield f"Still to mark: {say_count(len(taken.open), 'answer')} ({names}{more})"
        else:
            yield "Nothing is left to mark in it."
        yield from list_problems(journal)


def _shortened(title: str, lines: Sequence[str]) -> Iterator[str]:
    """Yield a list that is not empty with its title, and only the first lines of a long one."""
    if lines:
        yield f"{title}:"
        yield from (f"  {line}" for line in lines[:_SHOWN])
        if len(lines) > _SHOWN:
            yield f"  and {len(lines) - _SHOWN} more"


def _sheets(
    journal: Journal,
    grades: Path,
    anonymous: bool,
    worlds: Mapping[str, str],
    parts: int,
    double: bool,
    lesson: str | None,
) -> Iterator[str]:
    folder = grades / marking_sheets.FOLDER
    code = partial(student_code, load_secret())
    numbers = PersonalNumbers(load_course(), folder / "personal_numbers.json", worlds)
    numbers.compute(journal.results(lesson))
    written = marking_sheets.write_sheets(
        journal, folder, code, anonymous=anonymous, numbers=numbers, parts=parts, double=double, lesson=lesson
    )
    for each in written:
        yield f"wrote {each.table} and .html: {say_count(each.answers, 'answer')}, {each.open} to mark"
    if written:
        yield "Fill in points and comment, save as CSV, and say nao-course marks GRADES FILE --by NAME."
    else:
        yield "No written question has been handed in: there is nothing to mark."
    yield from list_problems(journal)


def write_comment_sheets(grades: Path, *, anonymous: bool = False, lesson: str = "") -> Iterator[str]:
    """Write a page and a table for each exercise with wrong answers; yield what to say about it.

    They are written for a `lesson`, by default for all. Raise a ValueError if there is no journal, or a table has
    comments that were not read in.
    """
    course = load_course()
    named = partial(student_code, load_secret()) if anonymous else str
    with Journal(grades, make=False, policy=course.late_policy) as journal, scratch_folder() as scratch:
        name = graded_lesson(journal, lesson)
        lessons = sorted({each.lesson for each in journal.each_result(name)})
        submissions = handed_in_before(course, journal, scratch, lessons)

        @cache
        def cells(student: str, lesson: str) -> tuple[str, ...]:
            try:
                return own_code(submissions[student, lesson]).cells
            except (KeyError, Refused, OSError):
                return ()

        def code_of(result: SubmissionResult, exercise: str) -> str:
            return defining_cell(cells(result.student, result.lesson), exercise)

        written = comment_sheets.write_comment_sheets(
            journal, grades / comment_sheets.FOLDER, code_of, named, name
        )
    for path, kinds, answers in written:
        yield f"wrote {path} and .html: {say_count(answers, 'wrong answer')} of {say_count(kinds, 'kind')}"
    if written:
        yield "Fill in comments, save as CSV, and say nao-course marks GRADES FILE."
    else:
        yield "There is no wrong answer to comment on."


def read_comments(grades: Path, file: Path, by: str = "") -> Iterator[str]:
    """Read a table of comments, which a person gave, and renew the feedback; yield what to say about it.

    Raise a ValueError if there is no journal, or if anything in the file is wrong, so that nothing is read in.
    """
    with Journal(grades, make=False, policy=load_course().late_policy) as journal:
        by = by or login()
        with journal.command(f"marks {file.name}", by):
            comments = comment_sheets.read_comments(journal, file, by)
        changed = {(each.lesson, each.exercise, each.kind) for each in comments}
        concerned = (
            result
            for result in journal.each_result()
            if any((result.lesson, each.name, each.kind) in changed for each in result.exercises)
        )
        pages = write_pages(journal, grades, concerned)
        yield f"{say_count(len(changed), 'comment')} new or changed, on {say_count(len(pages), 'feedback page')}"
        yield from list_problems(journal)


def write_oral_check(grades: Path, lesson: str, student: str = "") -> Iterator[str]:
    """Write a page with questions about a lesson's submissions, or one student's; yield what to say about it.

    Raise a ValueError if there is no such lesson or student.
    """
    from nao_course.instructor.reports import oral_check  # it loads what makes mutants

    course = load_course()
    with Journal(grades, make=False, policy=course.late_policy) as journal, scratch_folder() as scratch:
        name = graded_lesson(journal, lesson) or only_lesson(journal)
        results = [result_of(journal, student, name)] if student else list(journal.each_result(name))
        submissions = handed_in_before(course, journal, scratch, [name])
        questions = course.plan(name).questions
        checks = []
        for result in sorted(results, key=lambda each: each.student):
            try:
                submission = submissions[result.student, name]
                cells, notebook = own_code(submission).cells, files.read(submission).notebook
            except (KeyError, Refused, OSError):
                yield f"{result.student}: no notebook that can be read is in the folders of the earlier runs"
                continue
            check = oral_check.oral_check(result, partial(defining_cell, cells), notebook, questions)
            yield f"{result.student}: {say_count(check.count, 'question')}"
            checks.append(check)
    file = f"{name}_{safe_name(results[0].student)}.html" if student else f"{name}.html"
    yield f"wrote {write_whole(grades / oral_check.FOLDER / file, oral_check.oral_page(name, checks))}"
