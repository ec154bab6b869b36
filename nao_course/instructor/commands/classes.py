"""What the commands about a whole class do and say: report, status, and requests to look again."""

from collections.abc import Iterator
from pathlib import Path

import typer
from rich.console import Console
from rich.table import Table

from nao_course._internal.counts import say_count
from nao_course.homework import REQUEST
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.autograding.scratch import scratch_folder
from nao_course.instructor.collecting.requests import AskedAbout, request_files, requests_in
from nao_course.instructor.commands import submission_times
from nao_course.instructor.commands.feedback_pages import write_pages
from nao_course.instructor.commands.looking_up import list_problems, login, results_of, without_result
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import Request
from nao_course.instructor.reports import exports
from nao_course.instructor.reports import status as status_report
from nao_course.instructor.reports.class_report import write_report
from nao_course.instructor.reports.html import visible, write_whole

STATUS = "status.html"  # in GRADES

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


def status(console: Console, grades: Path) -> Iterator[str]:
    """Print a table of what waits for a person, and write GRADES/status.html; yield what to do next.

    Raise a ValueError if there is no journal.
    """
    with Journal(grades, make=False, policy=load_course().late_policy) as journal:
        lessons = sorted({each.lesson for each in journal.each_result()})
        found = status_report.status(journal, exports.last_exports(grades / exports.FOLDER, lessons))
        header, *rows = status_report.status_table(found)
        table = Table(*header)
        for row in rows:
            table.add_row(*row)
        console.print(table)
        yield from status_report.what_to_do(found) or ["Nothing waits for you."]
        yield f"wrote {write_whole(grades / STATUS, status_report.status_page(found))}"
        yield from list_problems(journal)


def requests(grades: Path, submissions: Path | None) -> Iterator[str]:
    """Read students' requests, if a folder is given, and yield a line for each open one.

    Raise a ValueError if there is no journal, or the path is neither a folder nor a zip; exit with status 1 if a
    request could not be read.
    """
    unread = list[str]()
    with (
        Journal(grades, make=False, policy=load_course().late_policy) as journal,
        scratch_folder() as scratch,
    ):
        if submissions is not None:
            with journal.command(f"requests {submissions}", login()):
                unread = read_requests(journal, grades, submissions, scratch)
            yield from (f"NOT READ: {each}" for each in unread)
        waiting = open_requests(journal)
    yield f"{say_count(len(waiting), 'open request')}{':' if waiting else ''}"
    yield from waiting
    if waiting:
        yield (
            "Answer with nao-course regrade GRADES --student NAME --reason TEXT, and --set EXERCISE=POINTS or "
            "--keep EXERCISE."
        )
    yield from list_problems(journal)
    if unread:
        raise typer.Exit(1)


def read_requests(journal: Journal, grades: Path, submissions: Path, scratch: Path) -> list[str]:
    """Read the students' requests in a folder or zip, and write their pages; return a line for what cannot be read.

    `scratch` is a folder of the caller's. Raise a ValueError if the path is neither a folder nor a zip.
    """
    texts, problems = request_files(submissions, scratch, load_course().names(), journal.roster())
    found, unread = list[Request](), list[str]()
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
    new = {(each.student, each.lesson) for each in journal.request(found)}
    write_pages(journal, grades, results_of(journal, sorted(new)))
    return [*unread, *(problem for student, problem in problems if not student)]


def open_requests(journal: Journal) -> list[str]:
    """Return a line for each request without an answer."""
    return [
        f"{each.student}, {each.lesson}, {each.exercise}: {visible(' '.join(each.text.split()))}"
        for each in journal.requests()
        if not each.answer
    ]
