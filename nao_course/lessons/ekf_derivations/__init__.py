"""What lesson 05, EKF derivations, alone uses."""

from nao_course.lessons.ekf_derivations.bugs import draw_bug_hunt, worst_heading
from nao_course.lessons.ekf_derivations.figures import draw_bending
from nao_course.lessons.ekf_derivations.limits import TITLES, draw_limits, limit_at, measure_limits
from nao_course.lessons.ekf_derivations.mistakes import MISTAKES
from nao_course.lessons.ekf_derivations.panel import LinearisationPanel
from nao_course.lessons.ekf_derivations.report import draw_two_landmarks, report_costs

__all__ = [
    "MISTAKES",
    "TITLES",
    "LinearisationPanel",
    "draw_bending",
    "draw_bug_hunt",
    "draw_limits",
    "draw_two_landmarks",
    "limit_at",
    "measure_limits",
    "report_costs",
    "worst_heading",
]


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
