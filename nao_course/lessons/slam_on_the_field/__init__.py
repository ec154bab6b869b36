"""Figures, panels and experiments of lesson 11, SLAM on the field."""

from nao_course._internal.lazy_names import import_when_asked

__all__, __getattr__, __dir__ = import_when_asked(
    __name__,
    {
        "associating": ("draw_matching", "right_share"),
        "false_corners": ("draw_false_corners",),
        "figures": ("draw_drives", "draw_measurements", "draw_one_tilt"),
        "gates": ("draw_associations", "draw_gates", "recorded_landmarks", "recorded_wrong"),
        "ideas": ("draw_ideas",),
        "one_drive": ("draw_one_drive",),
        "panel": ("AssociationPanel", "ReplayPanel", "RoomPanel"),
        "variants": ("draw_variants", "variants_table"),
        "nao_course.colours": ("GREEN", "YELLOW"),
        "nao_course.field_slam.association": ("associate_jointly",),
        "nao_course.field_slam.compass": ("wrap_quarter",),
        "nao_course.field_slam.drives": ("OdometryNoisePerMove",),
        "nao_course.field_slam.observation": ("Observation", "POST_RADIUS", "VAGUE", "as_observation"),
    },
)
