"""Pictures, figures, measures and panel of lesson 02, goal posts."""

from nao_course.lessons.goalposts.figures import (
    draw_column,
    draw_feet,
    draw_heights,
    draw_recall,
    draw_side,
    draw_turning_head,
    score_table,
)
from nao_course.lessons.goalposts.labels import or_recorded
from nao_course.lessons.goalposts.measuring import Feet, FootMatch, match_feet
from nao_course.lessons.goalposts.panel import PostPanel, mark_feet
from nao_course.lessons.goalposts.scenes import (
    PostScene,
    approach,
    match_scenes,
    picture_from,
    post_height,
    robot_before,
    scenes_by_distance,
    turning_head,
)
from nao_course.metrics import total

__all__ = [
    "Feet",
    "FootMatch",
    "PostPanel",
    "PostScene",
    "approach",
    "draw_column",
    "draw_feet",
    "draw_heights",
    "draw_recall",
    "draw_side",
    "draw_turning_head",
    "mark_feet",
    "match_feet",
    "match_scenes",
    "or_recorded",
    "picture_from",
    "post_height",
    "robot_before",
    "scenes_by_distance",
    "score_table",
    "total",
    "turning_head",
]


def __dir__() -> list[str]:
    """Return the names that tab completion shows."""
    return __all__
