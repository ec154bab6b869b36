"""The control panel: drive the robot, watch its pictures and its map, and run the student's functions on them."""

from nao_course.widgets.control_panel.panel import ControlPanel
from nao_course.widgets.control_panel.pipeline import Frame, Overlay, Pipeline, Stage

__all__ = ["ControlPanel", "Frame", "Overlay", "Pipeline", "Stage"]


def __dir__() -> list[str]:
    """Return the public names, so that tab completion omits the modules."""
    return __all__
