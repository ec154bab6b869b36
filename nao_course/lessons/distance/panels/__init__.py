"""The panels of lesson 04: the tilted body with its map, and one ray in space."""

from nao_course.lessons.distance.panels.ray import RayPanel
from nao_course.lessons.distance.panels.tilt import TiltPanel

__all__ = ["RayPanel", "TiltPanel"]
