"""Figures, pictures, measurements and the panel of lesson 03, Hough corners."""

from nao_course._internal.lazy_names import import_when_asked

__all__, __getattr__, __dir__ = import_when_asked(
    __name__,
    {
        "figures": ("draw_close_up", "draw_places", "draw_segments", "draw_votes"),
        "labels": ("or_recorded",),
        "measuring": ("all_crossings", "count_corners", "with_others"),
        "panel": ("CornerPanel",),
        "results": (
            "draw_costs",
            "draw_funnel",
            "draw_goal_line",
            "goal_line_left",
            "last_seen",
            "mean_cost",
        ),
        "scenes": (
            "CornerPicture",
            "match_pictures",
            "more_rooms",
            "other_rooms",
            "ready_made_segments",
            "real_pictures",
            "rows_between",
            "running_picture",
            "running_robot",
            "three_places",
            "tuning_pictures",
        ),
        "segments": ("Segments", "coverage"),
    },
)
