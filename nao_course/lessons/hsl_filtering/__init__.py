"""Figures, panel and challenge of lesson 01, HSL filtering."""

from nao_course._internal.lazy_names import import_when_asked

__all__, __getattr__, __dir__ = import_when_asked(
    __name__,
    {
        "challenge_figure": ("harder_rooms",),
        "figures": ("draw_hsl", "draw_hue_circle", "draw_stray_pixel"),
        "light": ("crossing", "draw_light_limits", "draw_lightness", "in_light"),
        "panel": ("FilterPanel",),
        "payoff": ("draw_payoff", "draw_rgb_limits", "without_edges"),
        "personal": ("personal_numbers",),
        "real_pictures": ("draw_real_pictures",),
    },
)
