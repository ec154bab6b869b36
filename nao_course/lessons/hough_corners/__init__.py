"""What lesson 03, Hough corners, alone uses."""

from nao_course.lessons.hough_corners.figures import draw_costs, draw_funnel, draw_places, draw_segments
from nao_course.lessons.hough_corners.segments import Segments, coverage

__all__ = ["Segments", "coverage", "draw_costs", "draw_funnel", "draw_places", "draw_segments"]


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
