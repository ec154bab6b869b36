"""Figures, panels and drives that only lesson 06, localization, uses."""

from nao_course._internal.lazy_names import import_when_asked

__all__, __getattr__, __dir__ = import_when_asked(
    __name__,
    {
        "consistency": ("draw_bands",),
        "drives": ("follow_many",),
        "figures": ("cloud", "draw_cloud", "draw_wrong_start", "draw_wrong_starts", "inside"),
        "forms": ("eigenvalue_table",),
        "first_drive": ("draw_bearings", "draw_first_drive"),
        "next_landmark": ("draw_remaining_uncertainty",),
        "panels": ("FusePanel", "LabPanel"),
        "personal": ("personal_numbers",),
        "real_walk": ("draw_real_walk",),
    },
)
