"""The panels of lesson 09, and the given solver behind them."""

from nao_course.lessons.pose_graphs.panels.edges import EdgePanel
from nao_course.lessons.pose_graphs.panels.relaxing import RelaxPanel

__all__ = ["EdgePanel", "RelaxPanel"]
