"""Figures, panels and drives that only lesson 06, localization, uses."""

from nao_course.lessons.localization.consistency import draw_bands
from nao_course.lessons.localization.drives import follow_many
from nao_course.lessons.localization.figures import cloud, draw_cloud, draw_wrong_start, inside
from nao_course.lessons.localization.first_drive import draw_bearings, draw_first_drive
from nao_course.lessons.localization.next_landmark import draw_remaining_uncertainty
from nao_course.lessons.localization.panels import FusePanel, LabPanel

__all__ = [
    "FusePanel",
    "LabPanel",
    "cloud",
    "draw_bands",
    "draw_bearings",
    "draw_cloud",
    "draw_first_drive",
    "draw_remaining_uncertainty",
    "draw_wrong_start",
    "follow_many",
    "inside",
]


def __dir__() -> list[str]:
    """Return the public names, without the modules they come from."""
    return __all__
