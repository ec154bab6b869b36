"""Panels to drive the robot with; each one leaves a picture and a text where no widget can live."""

from nao_course.widgets.colour_filter import FilterPanel
from nao_course.widgets.dial import RealityDial
from nao_course.widgets.panel import ControlPanel

__all__ = ["ControlPanel", "FilterPanel", "RealityDial"]
