"""The page by which answers in words are marked: each question, its points, its rubric."""

from collections.abc import Iterable

from nao_course.exercises import Written
from website.lessons import Lesson

__all__ = ["rubrics_page"]


def rubrics_page(questions: Iterable[tuple[Lesson, Written]]) -> str:
    """Write all questions below each other, in Markdown."""
    parts = [
        f"## {lesson.number} {lesson.title}, {each.points:g} points\n\n{each.question}\n\n> {each.rubric}"
        for lesson, each in questions
    ]
    return "\n\n".join(["# Rubrics of the answers in words", *parts]) + "\n"
