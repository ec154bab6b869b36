"""Panels to drive the robot and to try functions; without widgets each shows a picture and a text."""

from typing import TYPE_CHECKING

from nao_course._internal.lazy_names import import_as_typed, list_public

if TYPE_CHECKING:
    from nao_course.widgets.control_panel import ControlPanel
    from nao_course.widgets.derivation_sheet import DerivationSheet, derivation
    from nao_course.widgets.dial import RealityDial
    from nao_course.widgets.function_panel import FunctionPanel
    from nao_course.widgets.inputs import Action, Choice, Pixel, RangeSlider, Slider, Toggle
    from nao_course.widgets.player import PlayerPanel
    from nao_course.widgets.shown import Legend
    from nao_course.widgets.vector_map import show_film
    from nao_course.widgets.world import Ray, WorldPanel, WorldPlayer, WorldView

__all__ = [
    "Action",
    "Choice",
    "ControlPanel",
    "DerivationSheet",
    "FunctionPanel",
    "Legend",
    "Pixel",
    "PlayerPanel",
    "RangeSlider",
    "Ray",
    "RealityDial",
    "Slider",
    "Toggle",
    "WorldPanel",
    "WorldPlayer",
    "WorldView",
    "derivation",
    "show_film",
]
__getattr__ = import_as_typed(__name__, __file__)
__dir__ = list_public(__name__)
