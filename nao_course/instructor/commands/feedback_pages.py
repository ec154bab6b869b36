"""The students' feedback pages in a folder of grades."""

from collections.abc import Iterable
from pathlib import Path

from nao_course.instructor.autograding.batch import feedback_writer
from nao_course.instructor.collecting.names import safe_name
from nao_course.instructor.gradebook.journal import Journal
from nao_course.instructor.gradebook.records import SubmissionResult

FEEDBACK = "feedback"  # in GRADES


def write_pages(journal: Journal, grades: Path, results: Iterable[SubmissionResult]) -> list[Path]:
    """Write feedback pages; a page that fails is among the journal's problems."""
    write, pages = feedback_writer(journal, grades / FEEDBACK), []
    for result in results:
        with journal.for_one(result.student, result.lesson, "the feedback page was not written"):
            pages.append(write(result))
    return pages


def folder_of(grades: Path, student: str) -> Path:
    """Return the folder of a student's pages."""
    return grades / FEEDBACK / safe_name(student)
