"""What lesson 04, distance, alone uses."""

from nao_course.lessons.distance.calibration import Marked, draw_calibrated, marked_pictures, range_errors
from nao_course.lessons.distance.challenge_figure import draw_leaning_lines
from nao_course.lessons.distance.figures import draw_arrows, draw_paper_error
from nao_course.lessons.distance.looks import Look, look_around, usual_view
from nao_course.lessons.distance.noise_figures import (
    draw_asymmetry,
    draw_pixel_worth,
    draw_shared_tilt,
    draw_tilt_band,
    tilt_errors,
    typical_error,
)
from nao_course.lessons.distance.panel import TiltPanel
from nao_course.lessons.distance.payoff import draw_payoff
from nao_course.lessons.distance.phone import PhoneLab

__all__ = [
    "Look",
    "Marked",
    "PhoneLab",
    "TiltPanel",
    "draw_arrows",
    "draw_asymmetry",
    "draw_calibrated",
    "draw_leaning_lines",
    "draw_paper_error",
    "draw_payoff",
    "draw_pixel_worth",
    "draw_shared_tilt",
    "draw_tilt_band",
    "look_around",
    "marked_pictures",
    "range_errors",
    "tilt_errors",
    "typical_error",
    "usual_view",
]


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
