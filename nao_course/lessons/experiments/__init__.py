"""Figures, panels and data of lesson 10, experiments."""

from nao_course._internal.lazy_names import import_when_asked

_NAMES = {
    "budget": (
        "Budget",
        "larger_source",
        "draw_budget",
        "draw_range_budget",
        "measure_budget",
        "pixel_errors",
        "tell_tilt_left",
        "usual_scene",
    ),
    "intervals": ("Interval",),
    "landscape": (
        "broken_promise",
        "best_settings",
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
}
__all__ = sorted(name for names in _NAMES.values() for name in names)


__getattr__ = import_when_asked(__name__, _NAMES)  # a check compares intervals, and needs no panel


def __dir__() -> list[str]:
    """List the public names, without the modules that define them."""
    return __all__
