"""Figures, panels and experiments of lesson 11, SLAM on the field."""

from nao_course._internal.lazy_names import import_when_asked
from nao_course.colours import GREEN as GREEN
from nao_course.colours import YELLOW as YELLOW
from nao_course.field_slam.association import associate_jointly as associate_jointly
from nao_course.field_slam.compass import wrap_quarter as wrap_quarter
from nao_course.field_slam.drives import OdometryNoisePerMove as OdometryNoisePerMove
from nao_course.field_slam.observation import POST_RADIUS as POST_RADIUS
from nao_course.field_slam.observation import VAGUE as VAGUE
from nao_course.field_slam.observation import Observation as Observation
from nao_course.field_slam.observation import as_observation as as_observation

_NAMES = {
    "associating": ("draw_matching", "right_share"),
    "figures": ("draw_drives", "draw_measurements", "draw_one_tilt"),
    "gates": ("draw_associations", "draw_gates", "recorded_landmarks", "recorded_wrong"),
    "ideas": ("draw_ideas",),
    "one_drive": ("draw_one_drive",),
    "panel": ("AssociationPanel", "ReplayPanel", "RoomPanel"),
    "variants": ("draw_variants", "variants_table"),
}
_FROM_BELOW = (
    *("GREEN", "POST_RADIUS", "VAGUE", "YELLOW"),
    *("OdometryNoisePerMove", "Observation", "as_observation", "associate_jointly", "wrap_quarter"),
)
__all__ = sorted([*_FROM_BELOW, *(name for names in _NAMES.values() for name in names)])


__getattr__ = import_when_asked(__name__, _NAMES)  # a check needs no panel


def __dir__() -> list[str]:
    """List the public names for tab completion, without the modules that they come from."""
    return __all__
