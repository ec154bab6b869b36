"""What the commands about a whole class do and say: report."""

from __future__ import annotations

import difflib
from collections.abc import Iterator
from pathlib import Path

from nao_course._internal.counts import say_count
from nao_course.instructor.authoring.course import load_course
from nao_course.instructor.autograding.batch import feedback_writer
from nao_course.instructor.commands import FEEDBACK
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.reports.class_report import write_report


def report(grades: Path) -> Iterator[str]:
    """Write GRADES/report.html and all feedback pages; yield what to say about it.

    Raises
    ------
    ValueError
        If there is no journal.
    """
    with Journal(grades, make=False, policy=load_course().late_policy) as journal:
        yield f"wrote {write_report(journal, grades / 'report.html')}"
        write = feedback_writer(journal, grades / FEEDBACK)
        pages = [write(result) for result in journal.each_result()]
        yield f"wrote {say_count(len(pages), 'feedback page')} again, with the deadlines of course.toml"
        yield from unknown_extensions(journal)


def unknown_extensions(journal: Journal) -> Iterator[str]:
    """Yield a line for each student in course.toml's extensions who has no result: the name may be misspelt."""
    students = journal.students()
    for name in sorted((journal.policy.extensions if journal.policy else {}).keys() - students):
        near = difflib.get_close_matches(name, students, 1)
        hint = f"; is it {near[0]!r}?" if near else ""
        yield f"course.toml: extensions: {name!r} has no result{hint}"
