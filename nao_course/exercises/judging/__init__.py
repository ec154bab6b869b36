"""Judge a function's answers, case by case, and report the result to the student."""

from nao_course._internal.lazy_names import list_public
from nao_course.exercises.judging.cases import answer, judge
from nao_course.exercises.judging.earlier_functions import differing
from nao_course.exercises.judging.report import (
    AT_FAULT,
    CheckState,
    Report,
    explain,
    is_unstable,
    same_answer,
    with_the_reason,
)

__all__ = [
    "AT_FAULT",
    "CheckState",
    "Report",
    "answer",
    "differing",
    "explain",
    "is_unstable",
    "judge",
    "same_answer",
    "with_the_reason",
]
__dir__ = list_public(__name__)
