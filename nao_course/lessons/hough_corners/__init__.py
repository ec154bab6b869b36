"""What lesson 03, Hough corners, alone uses."""

from importlib import import_module
from typing import Any

_NAMES = {
    "figures": ("draw_close_up", "draw_places", "draw_segments"),
    "measuring": ("count_corners", "with_others"),
    "panel": ("CornerPanel",),
    "results": ("draw_costs", "draw_funnel", "draw_goal_line", "goal_line_left", "last_seen", "mean_cost"),
    "scenes": (
        "CornerPicture",
        "match_pictures",
        "real_pictures",
        "rows_between",
        "three_places",
        "tuning_pictures",
    ),
    "segments": ("Segments", "coverage"),
}
__all__ = sorted(name for names in _NAMES.values() for name in names)


def __getattr__(name: str) -> Any:
    """Import what is asked for, and no more: a check compares segments, and needs no panel."""
    for module, names in _NAMES.items():
        if name in names:
            return getattr(import_module(f"{__name__}.{module}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
