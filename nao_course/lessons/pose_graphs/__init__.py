"""What lesson 09, pose graphs, alone uses."""

from nao_course._internal.lazy_names import import_when_asked

__all__, __getattr__, __dir__ = import_when_asked(
    __name__,
    {
        "figures": (
            "draw_false_closure",
            "draw_real_building",
            "draw_relaxing",
            "draw_step",
            "drift_that_climbs",
            "relaxed",
        ),
        "guesses": ("HEADINGS", "arrivals", "draw_arrivals", "half_of_them"),
        "information": ("draw_information_frames",),
        "matrices": ("count_of_free_moves", "draw_free_moves"),
        "measured": ("draw_ekf_and_graph",),
        "panels": ("EdgePanel", "RelaxPanel"),
        "robust": ("draw_false_closures", "robust_gauss_newton"),
        "scan_maps": ("draw_scans",),
        "sheet": ("landmark_sheet",),
        "uncertainty": ("draw_uncertainty",),
        "worlds": (
            "World",
            "building",
            "disturbed",
            "drifting_loop",
            "field_drive",
            "loop",
            "position_error",
            "with_false_closures",
        ),
    },
)
