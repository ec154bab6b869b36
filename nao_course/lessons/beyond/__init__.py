"""What lesson 12, beyond the paper, alone uses."""

from nao_course.lazy_names import import_when_asked

_NAMES = {
    "figures": (
        "ancestors_left",
        "blind_doubt",
        "draw_blind_start",
        "draw_depletion",
        "draw_finding",
        "draw_journeys",
        "journeys_table",
    ),
    "panels": ("ExplorePanel", "TwoCamerasPanel"),
    "recorded": (
        "cameras_table",
        "coverage_table",
        "draw_coverage",
        "draw_fast_slam",
        "draw_moves",
        "draw_two_cameras",
        "fast_slam_table",
        "known_after",
        "moves_table",
    ),
    "two_cameras": ("measure_again",),
}
__all__ = sorted(name for names in _NAMES.values() for name in names)


__getattr__ = import_when_asked(__name__, _NAMES)  # a check needs no panel


def __dir__() -> list[str]:
    """What tab completion shows."""
    return __all__
