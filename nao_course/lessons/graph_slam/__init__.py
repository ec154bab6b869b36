"""Figures, drives and the panel of lesson 08, Graph SLAM."""

from nao_course._internal.lazy_names import import_when_asked

__all__, __getattr__, __dir__ = import_when_asked(
    __name__,
    {
        "costs": ("draw_costs",),
        "drives": ("Constraint", "LinearDrive", "corridor", "field_drive", "odometry", "odometry_first"),
        "figures": ("draw_snapshots", "draw_valley", "draw_weights"),
        "map_errors": (
            "HEADINGS",
            "TURN_REMARKS",
            "doubling_turn",
            "draw_powers",
            "draw_turning",
            "errors_by_power",
            "errors_by_turn",
        ),
        "matrices": ("FILLED_REMARKS", "draw_correlations", "draw_fill_in", "draw_marginalised"),
        "panel": ("GraphPanel",),
        "real_building": ("draw_real_building",),
        "residuals": ("dead_reckoning", "draw_drive", "draw_residuals", "filtered", "residuals"),
        "systems": ("Builders", "assemble", "map_error", "solve_axes", "solved"),
    },
)
