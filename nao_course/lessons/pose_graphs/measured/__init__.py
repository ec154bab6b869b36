"""The result of ``python -m benchmarks ekf_and_graph`` for lesson 09, its methods and figure."""

from nao_course._internal.lazy_names import list_public
from nao_course.lessons.pose_graphs.measured.recorded import draw_ekf_and_graph

__all__ = ["draw_ekf_and_graph"]
__dir__ = list_public(__name__)
