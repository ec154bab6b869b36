"""Panels to drive the robot with; each one leaves a picture and a text where no widget can live."""

from nao_course.widgets.dial import RealityDial
from nao_course.widgets.panel import ControlPanel

__all__ = ["ControlPanel", "RealityDial"]


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
