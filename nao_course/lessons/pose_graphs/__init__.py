"""What lesson 09, pose graphs, alone uses."""

from nao_course.lessons.pose_graphs.figures import (
    draw_false_closure,
    draw_real_building,
    draw_relaxing,
    draw_step,
    drift_that_climbs,
    false_world,
    relaxed,
)
from nao_course.lessons.pose_graphs.guesses import HEADINGS, arrivals, draw_arrivals, half_of_them
from nao_course.lessons.pose_graphs.information import draw_information_frames
from nao_course.lessons.pose_graphs.matrices import count_of_free_moves, draw_free_moves
from nao_course.lessons.pose_graphs.measured import draw_ekf_and_graph, draw_solver_costs
from nao_course.lessons.pose_graphs.panels import EdgePanel, RelaxPanel
from nao_course.lessons.pose_graphs.robust import draw_false_closures, robust_gauss_newton
from nao_course.lessons.pose_graphs.sheet import landmark_sheet
from nao_course.lessons.pose_graphs.uncertainty import draw_uncertainty
from nao_course.lessons.pose_graphs.worlds import (
    World,
    building,
    disturbed,
    drifting_loop,
    field_drive,
    loop,
    position_error,
    with_false_closures,
)

__all__ = [
    "HEADINGS",
    "EdgePanel",
    "RelaxPanel",
    "World",
    "arrivals",
    "building",
    "count_of_free_moves",
    "disturbed",
    "draw_arrivals",
    "draw_ekf_and_graph",
    "draw_false_closure",
    "draw_false_closures",
    "draw_free_moves",
    "draw_information_frames",
    "draw_real_building",
    "draw_relaxing",
    "draw_solver_costs",
    "draw_step",
    "draw_uncertainty",
    "drift_that_climbs",
    "drifting_loop",
    "false_world",
    "field_drive",
    "half_of_them",
    "landmark_sheet",
    "loop",
    "position_error",
    "relaxed",
    "robust_gauss_newton",
    "with_false_closures",
]


def __dir__() -> list[str]:
    """Return the public names for tab completion, without the modules they come from."""
    return __all__
