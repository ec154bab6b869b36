"""What lesson 06, localization, alone uses."""

from nao_course.lessons.localization.beliefs import (
    behind,
    cloud,
    draw_cloud,
    draw_not_wrapped,
    draw_put_down_wrongly,
    inside,
    jump,
)
from nao_course.lessons.localization.drives import LANDMARKS, follow_many
from nao_course.lessons.localization.honesty import (
    draw_bands,
    draw_smallest_eigenvalue,
    inside_naive_band,
)
from nao_course.lessons.localization.lab import with_parts
from nao_course.lessons.localization.panels import FusePanel, LabPanel
from nao_course.lessons.localization.surest import draw_surest
from nao_course.metrics import band

__all__ = [
    "LANDMARKS",
    "FusePanel",
    "LabPanel",
    "band",
    "behind",
    "cloud",
    "draw_bands",
    "draw_cloud",
    "draw_not_wrapped",
    "draw_put_down_wrongly",
    "draw_smallest_eigenvalue",
    "draw_surest",
    "follow_many",
    "inside",
    "inside_naive_band",
    "jump",
    "with_parts",
]


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
