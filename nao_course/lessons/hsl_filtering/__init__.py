"""Figures, panel and challenge of lesson 01, HSL filtering."""

from nao_course.lessons.hsl_filtering.challenge_figure import harder_rooms
from nao_course.lessons.hsl_filtering.figures import draw_hsl, draw_hue_circle, draw_stray_pixel
from nao_course.lessons.hsl_filtering.light import crossing, draw_light_limits, draw_lightness, in_light
from nao_course.lessons.hsl_filtering.panel import FilterPanel
from nao_course.lessons.hsl_filtering.payoff import draw_payoff, draw_rgb_limits
from nao_course.lessons.hsl_filtering.real_pictures import draw_real_pictures

__all__ = [
    "FilterPanel",
    "crossing",
    "draw_hsl",
    "draw_hue_circle",
    "draw_light_limits",
    "draw_lightness",
    "draw_payoff",
    "draw_real_pictures",
    "draw_rgb_limits",
    "draw_stray_pixel",
    "harder_rooms",
    "in_light",
]


def __dir__() -> list[str]:
    """Return the names that tab completion shows."""
    return __all__
