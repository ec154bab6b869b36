"""Results of ``python -m benchmarks ekf_and_graph pose_graphs`` for lesson 09, their methods and figures."""

from nao_course._internal.lazy_names import list_public
from nao_course.lessons.pose_graphs.measured.recorded import draw_ekf_and_graph, draw_solver_costs

__all__ = ["draw_ekf_and_graph", "draw_solver_costs"]
__dir__ = list_public(__name__)
