"""The control panel: drive the robot, watch its pictures and its map, and run the student's functions on them."""

from nao_course._internal.lazy_names import list_public
from nao_course.widgets.control_panel.panel import ControlPanel
from nao_course.widgets.control_panel.pipeline import Frame, Overlay, Pipeline, Stage

__all__ = ["ControlPanel", "Frame", "Overlay", "Pipeline", "Stage"]
__dir__ = list_public(__name__)
