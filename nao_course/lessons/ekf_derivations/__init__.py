"""What only lesson 05, EKF derivations, uses."""

from nao_course._internal.lazy_names import import_when_asked

__all__, __getattr__, __dir__ = import_when_asked(
    __name__,
    {
        "bugs": ("draw_bug_hunt",),
        "figures": ("draw_bending",),
        "lap": ("LapPanel", "typical_distance"),
        "limits": ("draw_limits", "limit_of_mean", "measure_limits"),
        "mistakes": ("MISTAKES",),
        "panel": ("LinearisationPanel",),
        "real_walk": ("draw_real_measurements",),
        "report": ("draw_two_landmarks", "report_costs"),
        "sheets": ("motion_sheet", "position_sheet"),
    },
)
