"""What lesson 08, Graph SLAM, alone uses."""

from nao_course.lazy_names import import_when_asked

_NAMES = {
    "costs": ("draw_costs",),
    "drives": ("Constraint", "Drive", "corridor", "field_drive", "odometry", "odometry_first"),
    "figures": ("draw_snapshots", "draw_valley", "draw_weights"),
    "matrices": ("draw_correlations", "draw_fill_in", "draw_marginalised"),
    "panel": ("GraphPanel",),
    "systems": ("Builders", "assemble", "map_error", "solve_axes", "solved"),
    "turning": ("HEADINGS", "draw_turning", "errors_by_turn", "turn_that_doubles"),
    "weighting": ("draw_powers", "errors_by_power"),
}
__all__ = sorted(name for names in _NAMES.values() for name in names)


__getattr__ = import_when_asked(__name__, _NAMES)  # a check calls a solver, and needs no panel


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
