"""What lesson 04, distance, alone uses."""

from nao_course._internal.lazy_names import import_when_asked

__all__, __getattr__, __dir__ = import_when_asked(
    __name__,
    {
        "calibration": ("Marked", "marked_pictures", "range_errors"),
        "calibration_figure": ("draw_calibrated",),
        "challenge_figure": ("draw_tilted_lines",),
        "figures": ("draw_arrows", "draw_paper_error"),
        "looks": ("MarkedPicture", "look_around", "usual_view"),
        "noise_figures": (
            "draw_asymmetry",
            "draw_landmark_clouds",
            "draw_pixel_worth",
            "draw_shared_tilt",
            "draw_tilt_band",
            "pixel_worth",
            "tilt_errors",
            "typical_error",
        ),
        "panels": ("RayPanel", "TiltPanel"),
        "payoff": ("draw_payoff",),
        "personal": ("personal_numbers",),
        "phone": ("PhoneLab",),
    },
)
