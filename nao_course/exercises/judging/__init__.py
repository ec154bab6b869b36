"""The judging of a function's answers: whether a case is right, and what a check tells of all of them."""

from nao_course.exercises.judging.cases import answer, judge
from nao_course.exercises.judging.report import AT_FAULT, CheckState, Report, explain, with_the_reason

__all__ = ["AT_FAULT", "CheckState", "Report", "answer", "explain", "judge", "with_the_reason"]


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
