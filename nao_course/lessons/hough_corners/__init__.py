"""What lesson 03, Hough corners, alone uses."""

from nao_course.lessons.hough_corners.figures import draw_close_up, draw_places, draw_segments
from nao_course.lessons.hough_corners.measuring import count_corners, white_lines, with_others
from nao_course.lessons.hough_corners.panel import CornerPanel
from nao_course.lessons.hough_corners.results import (
    draw_costs,
    draw_funnel,
    draw_goal_line,
    goal_line_left,
    last_seen,
    mean_cost,
)
from nao_course.lessons.hough_corners.scenes import (
    CornerPicture,
    match_pictures,
    real_pictures,
    rows_between,
    three_places,
    tuning_pictures,
)
from nao_course.lessons.hough_corners.segments import Segments, coverage

__all__ = [
    "CornerPanel",
    "CornerPicture",
    "Segments",
    "count_corners",
    "coverage",
    "draw_close_up",
    "draw_costs",
    "draw_funnel",
    "draw_goal_line",
    "draw_places",
    "draw_segments",
    "goal_line_left",
    "last_seen",
    "match_pictures",
    "mean_cost",
    "real_pictures",
    "rows_between",
    "three_places",
    "tuning_pictures",
    "white_lines",
    "with_others",
]


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
