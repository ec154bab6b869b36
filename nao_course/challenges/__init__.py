"""Open challenges: a task at the end of a lesson with a score, a board and no grade."""

from nao_course._internal.lazy_names import list_public
from nao_course.challenges.board import Board, EntryReport
from nao_course.challenges.declaration import (
    CaseResult,
    CaseScore,
    Challenge,
    Column,
    Row,
    Run,
    recorded_rows,
)
from nao_course.challenges.finding import challenge

__all__ = [
    "Board",
    "CaseResult",
    "CaseScore",
    "Challenge",
    "Column",
    "EntryReport",
    "Row",
    "Run",
    "challenge",
    "recorded_rows",
]
__dir__ = list_public(__name__)
