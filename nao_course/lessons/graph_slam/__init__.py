"""What lesson 08, Graph SLAM, alone uses."""

from nao_course.lessons.graph_slam.costs import draw_costs
from nao_course.lessons.graph_slam.drives import (
    Constraint,
    Drive,
    corridor,
    field_drive,
    odometry,
    odometry_first,
)
from nao_course.lessons.graph_slam.figures import draw_snapshots, draw_valley, draw_weights
from nao_course.lessons.graph_slam.matrices import draw_correlations, draw_fill_in, draw_marginalised
from nao_course.lessons.graph_slam.panel import GraphPanel
from nao_course.lessons.graph_slam.systems import Builders, assemble, map_error, solve_axes
from nao_course.lessons.graph_slam.turning import HEADINGS, draw_turning, errors_by_turn, turn_that_doubles
from nao_course.lessons.graph_slam.weighting import draw_powers, errors_by_power

__all__ = [
    "HEADINGS",
    "Builders",
    "Constraint",
    "Drive",
    "GraphPanel",
    "assemble",
    "corridor",
    "draw_correlations",
    "draw_costs",
    "draw_fill_in",
    "draw_marginalised",
    "draw_powers",
    "draw_snapshots",
    "draw_turning",
    "draw_valley",
    "draw_weights",
    "errors_by_power",
    "errors_by_turn",
    "field_drive",
    "map_error",
    "odometry",
    "odometry_first",
    "solve_axes",
    "turn_that_doubles",
]


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
