"""Figures, panels and data of lesson 10, experiments."""

from nao_course._internal.lazy_names import import_when_asked

__all__, __getattr__, __dir__ = import_when_asked(
    __name__,
    {
        "budget": (
            "Budget",
            "draw_budget",
            "draw_range_budget",
            "larger_source",
            "measure_budget",
            "pixel_errors",
            "tell_tilt_left",
            "usual_scene",
        ),
        "intervals": ("Interval",),
        "landscape": (
            "best_settings",
            "broken_promise",
            "draw_beside_paper",
            "draw_landscape",
            "draw_optimism",
            "draw_payoff",
            "draw_winners",
        ),
        "panel": ("SettingPanel",),
        "paper_table": ("BETAS", "GAPS", "LENGTHS", "PAPER_MEANS", "PAPER_SIGMAS", "SETTINGS"),
        "personal": ("personal_costs",),
        "reading": ("draw_agreement", "draw_possible", "draw_sizes", "impossible_means"),
        "resampling": ("optimism", "shares_won"),
        "scenes": ("nothing_costs", "real_scenes", "search_scenes", "simulated_scenes"),
    },
)
