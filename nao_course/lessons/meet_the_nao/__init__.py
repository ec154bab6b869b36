"""Panel, figures, measurements and challenge of lesson 00, Meet the NAO."""

from nao_course._internal.lazy_names import import_when_asked

__all__, __getattr__, __dir__ = import_when_asked(
    __name__,
    {
        "drift": ("commanded", "draw_drift", "draw_growth", "measure_drift"),
        "figures": ("draw_cameras", "draw_frames", "draw_ground_steps", "draw_real_posts", "plot_footprint"),
        "lost": ("draw_lost_and_found",),
        "panel": ("HeadPanel",),
        "slalom_figure": ("robots_through",),
    },
)
