"""What only lesson 05, EKF derivations, uses."""

from nao_course.lessons.ekf_derivations.bugs import draw_bug_hunt
from nao_course.lessons.ekf_derivations.figures import draw_bending
from nao_course.lessons.ekf_derivations.lap import LapPanel, typical_distance
from nao_course.lessons.ekf_derivations.limits import draw_limits, limit_of_mean, measure_limits
from nao_course.lessons.ekf_derivations.mistakes import MISTAKES
from nao_course.lessons.ekf_derivations.panel import LinearisationPanel
from nao_course.lessons.ekf_derivations.report import draw_two_landmarks, report_costs
from nao_course.lessons.ekf_derivations.sheets import motion_sheet, position_sheet

__all__ = [
    "MISTAKES",
    "LapPanel",
    "LinearisationPanel",
    "draw_bending",
    "draw_bug_hunt",
    "draw_limits",
    "draw_two_landmarks",
    "limit_of_mean",
    "measure_limits",
    "motion_sheet",
    "position_sheet",
    "report_costs",
    "typical_distance",
]


def __dir__() -> list[str]:
    """Return the names for tab completion, without the modules that they come from."""
    return __all__
