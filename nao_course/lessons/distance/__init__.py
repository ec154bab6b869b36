"""What lesson 04, distance, alone uses."""

from nao_course.lessons.distance.calibration import Marked, draw_calibrated, marked_pictures, range_errors
from nao_course.lessons.distance.challenge_figure import draw_tilted_lines
from nao_course.lessons.distance.figures import draw_arrows, draw_paper_error
from nao_course.lessons.distance.looks import MarkedPicture, look_around, usual_view
from nao_course.lessons.distance.noise_figures import (
    draw_asymmetry,
    draw_pixel_worth,
    draw_shared_tilt,
    draw_tilt_band,
    tilt_errors,
    typical_error,
)
from nao_course.lessons.distance.panels import RayPanel, TiltPanel
from nao_course.lessons.distance.payoff import draw_payoff
from nao_course.lessons.distance.phone import PhoneLab

__all__ = [
    "Marked",
    "MarkedPicture",
    "PhoneLab",
    "RayPanel",
    "TiltPanel",
    "draw_arrows",
    "draw_asymmetry",
    "draw_calibrated",
    "draw_paper_error",
    "draw_payoff",
    "draw_pixel_worth",
    "draw_shared_tilt",
    "draw_tilt_band",
    "draw_tilted_lines",
    "look_around",
    "marked_pictures",
    "range_errors",
    "tilt_errors",
    "typical_error",
    "usual_view",
]


def __dir__() -> list[str]:
    """Return the names that tab completion shows."""
    return __all__
