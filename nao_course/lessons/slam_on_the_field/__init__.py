"""What lesson 11, SLAM on the field, alone uses."""

from nao_course.colours import GREEN as GREEN
from nao_course.colours import YELLOW as YELLOW
from nao_course.lazy_names import import_when_asked

_NAMES = {
    "associating": ("draw_matching", "right_share"),
    "figures": ("draw_drives", "draw_one_tilt", "draw_sights"),
    "gates": ("draw_associations", "draw_gates", "gate_table", "lost_landmarks", "wrong_share"),
    "ideas": ("draw_ideas",),
    "panel": ("AssociationPanel",),
    "system.association": ("associate_jointly",),
    "system.compass": ("wrap_quarter",),
    "system.drives": ("FieldOdometry",),
    "system.observation": ("POST_RADIUS", "VAGUE", "Observation", "as_observation"),
    "system.ways": ("draw_ways", "ways_table"),
}
__all__ = sorted(["GREEN", "YELLOW", *(name for names in _NAMES.values() for name in names)])


__getattr__ = import_when_asked(__name__, _NAMES)  # a check needs no panel


def __dir__() -> list[str]:
    """What tab completion shows: not the modules these names come from."""
    return __all__
