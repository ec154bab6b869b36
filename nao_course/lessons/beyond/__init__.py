"""Figures, panels and experiments of lesson 12, beyond the paper."""

from nao_course._internal.lazy_names import import_when_asked

__all__, __getattr__, __dir__ = import_when_asked(
    __name__,
    {
        "figures": (
            "ancestors_left",
            "blind_sigma",
            "draw_blind_start",
            "draw_depletion",
            "draw_finding",
            "draw_journeys",
            "draw_lost_filters",
            "draw_real_finding",
            "journeys_table",
        ),
        "panels": ("ExplorePanel", "MovesPanel", "TwoCamerasPanel"),
        "personal": ("personal_numbers",),
        "recorded": ("draw_coverage", "draw_fast_slam", "draw_moves", "draw_two_cameras"),
        "two_cameras": ("measure_again",),
    },
)
