"""Results of ``python -m benchmarks ekf_and_graph pose_graphs`` for lesson 09, their methods and figures."""

from nao_course.lessons.pose_graphs.measured.recorded import draw_ekf_and_graph, draw_solver_costs

__all__ = ["draw_ekf_and_graph", "draw_solver_costs"]


def __dir__() -> list[str]:
    """Return the public names for tab completion, without the modules they come from."""
    return __all__
