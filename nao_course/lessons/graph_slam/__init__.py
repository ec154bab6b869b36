"""Figures, drives and the panel of lesson 08, Graph SLAM."""

from nao_course._internal.lazy_names import import_when_asked

_NAMES = {
    "costs": ("draw_costs",),
    "drives": ("Constraint", "LinearDrive", "corridor", "field_drive", "odometry", "odometry_first"),
    "figures": ("draw_snapshots", "draw_valley", "draw_weights"),
    "matrices": ("draw_correlations", "draw_fill_in", "draw_marginalised"),
    "panel": ("GraphPanel",),
    "residuals": ("dead_reckoning", "draw_drive", "draw_residuals", "filtered", "residuals"),
    "systems": ("Builders", "assemble", "map_error", "solve_axes", "solved"),
    "map_errors": (
        "HEADINGS",
        "draw_powers",
        "draw_turning",
        "errors_by_power",
        "errors_by_turn",
        "doubling_turn",
    ),
}
__all__ = sorted(name for names in _NAMES.values() for name in names)


__getattr__ = import_when_asked(__name__, _NAMES)  # a check calls a solver, and needs no panel


def __dir__() -> list[str]:
    """Return the names that tab completion shows, without the modules that define them."""
    return __all__
