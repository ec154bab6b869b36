"""What lesson 01, HSL filtering, alone uses."""

from nao_course.lessons.hsl_filtering.figures import draw_hsl, draw_hue_circle
from nao_course.lessons.hsl_filtering.panel import FilterPanel

__all__ = ["FilterPanel", "draw_hsl", "draw_hue_circle"]


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
