"""The control panel: drive the robot, watch its pictures and its map, and run the student's functions on them."""

from typing import TYPE_CHECKING

from nao_course._internal.lazy_names import import_as_typed, list_public

if TYPE_CHECKING:
    from nao_course.widgets.control_panel.panel import ControlPanel
    from nao_course.widgets.control_panel.pipeline import Frame, Overlay, Pipeline, Stage

__all__ = ["ControlPanel", "Frame", "Overlay", "Pipeline", "Stage"]
__getattr__ = import_as_typed(__name__, __file__)
__dir__ = list_public(__name__)
