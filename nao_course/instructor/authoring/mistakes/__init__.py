"""Mistakes: small changes of an exercise's solution, applied one at a time or two together."""

from nao_course.instructor.authoring.mistakes.changes import (
    Change,
    ChangeError,
    catalogue,
    changed,
    with_functions,
    without_numeric_warnings,
)

__all__ = [
    "Change",
    "ChangeError",
    "catalogue",
    "changed",
    "changes",
    "pairs",
    "with_functions",
    "without_numeric_warnings",
]
