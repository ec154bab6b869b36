"""A view of the world in three dimensions: the field, its room, the robot and what it estimates."""

from nao_course.widgets.world.contents import Ray
from nao_course.widgets.world.panel import WorldPanel, WorldPlayer
from nao_course.widgets.world.scene import Viewpoint
from nao_course.widgets.world.view import WorldView

__all__ = ["Ray", "Viewpoint", "WorldPanel", "WorldPlayer", "WorldView"]
