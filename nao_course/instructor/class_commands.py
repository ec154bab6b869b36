"""What the commands about a whole class do and say: report, comments, and requests to look again."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache, partial
from pathlib import Path

import typer

from nao_course._internal.counts import say_count
from nao_course.homework import REQUEST
from nao_course.instructor import submission_times
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.autograding.batch import feedback_writer
from nao_course.instructor.autograding.scratch import scratch_folder
from nao_course.instructor.autograding.secret import load_secret, student_code
from nao_course.instructor.collecting.archives import Refused
from nao_course.instructor.collecting.requests import AskedAbout, request_files, requests_in
from nao_course.instructor.commands import handed_in_before, list_problems, results_of, without_result
from nao_course.instructor.feedback_pages import FEEDBACK, write_pages
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import Request, SubmissionResult
from nao_course.instructor.reports import comment_sheets
from nao_course.instructor.reports.class_report import write_report
from nao_course.instructor.reports.html import visible
from nao_course.instructor.similarity.own_code import defining_cell, own_code

_HOW_TO_ASK = (
    f"This part of your {REQUEST} could not be read. Write the name of an exercise of this course, a colon and your "
    "reason in one line, and hand the file in again."
)


def report(grades: Path) -> Iterator[str]:
    """Write GRADES/report.html and all feedback pages; yield what to say about it.

    Raise a ValueError if there is no journal.
    """
    with Journal(grades, make=False, policy=load_course().late_policy) as journal:
        yield f"wrote {write_report(journal, grades / 'report.html')}"
        pages = write_pages(journal, grades, journal.each_result())
        yield f"wrote {say_count(len(pages), 'feedback page')} again, with the deadlines of course.toml"
        yield from submission_times.without_time(journal)
        extensions = journal.policy.extensions if journal.policy else {}
        yield from without_result("course.toml: extensions", extensions, journal)
        yield from list_problems(journal)


def write_comment_sheets(grades: Path, *, anonymous: bool = False) -> Iterator[str]:
    """Write a page and a table for each exercise with wrong answers; yield what to say about it.

    Raise a ValueError if there is no journal, or a table has comments that were not read in.
    """
    course = load_course()
    named = partial(student_code, load_secret()) if anonymous else str
    with Journal(grades, make=False, policy=course.late_policy) as journal, scratch_folder() as scratch:
        lessons = sorted({each.lesson for each in journal.each_result()})
        submissions = handed_in_before(course, journal, scratch, lessons)

        @cache
        def cells(student: str, lesson: str) -> tuple[str, ...]:
            try:
                return own_code(submissions[student, lesson]).cells
            except (KeyError, Refused, OSError):
                return ()

        def code_of(result: SubmissionResult, exercise: str) -> str:
            return defining_cell(cells(result.student, result.lesson), exercise)

        written = comment_sheets.write_comment_sheets(journal, grades / comment_sheets.FOLDER, code_of, named)
    for path, kinds, answers in written:
        yield f"wrote {path} and .html: {say_count(answers, 'wrong answer')} of {say_count(kinds, 'kind')}"
    if written:
        yield "Fill in comments, save as CSV, and say nao-course marks GRADES FILE."
    else:
        yield "There is no wrong answer to comment on."


def read_comments(grades: Path, file: Path) -> Iterator[str]:
    """Read a table of comments and renew the feedback; yield what to say about it.

    Raise a ValueError if there is no journal, or if anything in the file is wrong, so that nothing is read in.
    """
    with Journal(grades, make=False, policy=load_course().late_policy) as journal:
        changed = {
            (each.lesson, each.exercise, each.kind) for each in comment_sheets.read_comments(journal, file)
        }
        concerned = (
            result
            for result in journal.each_result()
            if any((result.lesson, each.name, each.kind) in changed for each in result.exercises)
        )
        pages = write_pages(journal, grades, concerned)
        yield f"{say_count(len(changed), 'comment')} new or changed, on {say_count(len(pages), 'feedback page')}"
        yield from list_problems(journal)


def requests(grades: Path, submissions: Path | None) -> Iterator[str]:
    """Read students' requests, if a folder is given, and yield a line for each open one.

    Raise a ValueError if there is no journal, or the path is neither a folder nor a zip; exit with status 1 if a
    request could not be read.
    """
    course, unread = load_course(), list[str]()
    with Journal(grades, make=False, policy=course.late_policy) as journal, scratch_folder() as scratch:
        if submissions is not None:
            texts, problems = request_files(submissions, scratch, course.names(), journal.roster())
            found = []
            for student in sorted({*texts, *(student for student, _ in problems if student)}):
                with journal.for_one(student, "requests", "the file was not read"):
                    results = list(journal.each_result(student=student))
                    exercises = [
                        AskedAbout(result.lesson, each.number, each.name)
                        for result in results
                        for each in result.exercises
                    ]
                    asked, lost = requests_in(texts.get(student, ""), exercises)
                    lost += [problem for whose, problem in problems if whose == student]
                    found += [Request(student, *exercise, said) for exercise, said in asked.items()]
                    if lost:
                        told = "\n".join(lost)
                        found += [Request(student, each.lesson, "", told, _HOW_TO_ASK) for each in results]
                    unread += [f"{student}: {line}" for line in lost]
            unread += [problem for student, problem in problems if not student]
            new = {(each.student, each.lesson) for each in journal.request(found)}
            write_pages(journal, grades, results_of(journal, sorted(new)))
            yield from (f"NOT READ: {each}" for each in unread)
        waiting = [each for each in journal.requests() if not each.answer]
    yield f"{say_count(len(waiting), 'open request')}{':' if waiting else ''}"
    for each in waiting:
        yield f"{each.student}, {each.lesson}, {each.exercise}: {visible(' '.join(each.text.split()))}"
    if waiting:
        yield (
            "Answer with nao-course regrade GRADES --student NAME --reason TEXT, and --set EXERCISE=POINTS or "
            "--keep EXERCISE."
        )
    yield from list_problems(journal)
    if unread:
        raise typer.Exit(1)


def keep_points(grades: Path, student: str, exercise: str, reason: str) -> Iterator[str]:
    """Answer a request without a change of points; yield what to say about it.

    Raise a ValueError if there is no such open request, or no reason.
    """
    if not reason.strip():
        raise ValueError("say why with --reason: the journal keeps it, and the student reads it")
    with Journal(grades, make=False, policy=load_course().late_policy) as journal:
        answered = [
            result
            for result in journal.each_result(student=journal.roster().meant(student) or "")
            if journal.answer(
                result.student, result.lesson, exercise, reason.strip(), result.answer_to(exercise)
            )
        ]
        if not answered:
            raise ValueError(f"there is no open request of {student!r} about {exercise!r}")
        for result in answered:
            page = feedback_writer(journal, grades / FEEDBACK)(result)
            yield f"{student}, {exercise}: the points stay. {page} gives the reason."
