"""What lesson 03, Hough corners, alone uses."""

from nao_course.lazy_names import import_when_asked

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


__getattr__ = import_when_asked(__name__, _NAMES)  # a check compares segments, and needs no panel


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
