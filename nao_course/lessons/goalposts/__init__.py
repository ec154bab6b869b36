"""Pictures, figures, measures and panel of lesson 02, goal posts."""

from nao_course._internal.lazy_names import import_when_asked

__all__, __getattr__, __dir__ = import_when_asked(
    __name__,
    {
        "figures": (
            "draw_column",
            "draw_feet",
            "draw_heights",
            "draw_recall",
            "draw_side",
            "draw_turning_head",
            "score_table",
        ),
        "labels": ("or_recorded",),
        "measuring": ("Feet", "FootMatch", "match_feet"),
        "panel": ("PostPanel", "mark_feet"),
        "scenes": (
            "PostScene",
            "approach",
            "match_scenes",
            "picture_from",
            "post_height",
            "robot_before",
            "scenes_by_distance",
            "turning_head",
        ),
        "nao_course.datasets.real_walk": ("measured_posts",),
        "nao_course.metrics": ("total",),
    },
)
