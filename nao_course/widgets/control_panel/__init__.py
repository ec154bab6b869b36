"""The control panel: the robot's commands, what is shown, and the student's vision that looks along."""

from nao_course.widgets.control_panel.panel import ControlPanel
from nao_course.widgets.control_panel.pipeline import Overlay, Pipeline, Sight, Stage

__all__ = ["ControlPanel", "Overlay", "Pipeline", "Sight", "Stage"]


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
