"""What ``python -m benchmarks ekf_and_graph pose_graphs`` measured for lesson 09, how, and its figures."""

from nao_course.lessons.pose_graphs.measured.recorded import draw_ekf_and_graph, draw_solver_costs

__all__ = ["draw_ekf_and_graph", "draw_solver_costs"]


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
