"""Panel, figures, measurements and challenge of lesson 00, Meet the NAO."""

from nao_course.lessons.meet_the_nao.drift import commanded, draw_drift, draw_growth, measure_drift
from nao_course.lessons.meet_the_nao.figures import (
    draw_cameras,
    draw_frames,
    draw_ground_steps,
    plot_footprint,
)
from nao_course.lessons.meet_the_nao.lost import draw_lost_and_found
from nao_course.lessons.meet_the_nao.panel import HeadPanel
from nao_course.lessons.meet_the_nao.slalom_figure import robots_through

__all__ = [
    "HeadPanel",
    "commanded",
    "draw_cameras",
    "draw_drift",
    "draw_frames",
    "draw_ground_steps",
    "draw_growth",
    "draw_lost_and_found",
    "measure_drift",
    "plot_footprint",
    "robots_through",
]


def __dir__() -> list[str]:
    """Return the names that tab completion shows."""
    return __all__
